//! Stability criteria of one axis of a dyad.
//!
//! A characteristic root lies on the imaginary axis, at s = jω, exactly where the magnitudes of both terms
//! agree, |P₁(jω)|²|P₂(jω)|² = (k² + c²ω²)², and the delay supplies the remaining phase. All criteria
//! follow from these two conditions:
//!
//! | question | function |
//! |---|---|
//! | where do roots cross the imaginary axis? | [`crossings`] |
//! | which stiffness is stable at every constant delay? | [`critical_stiffness`], [`is_delay_independent`] |
//! | which delays are stable? | [`maximum_delay`], [`stable_delays`], [`unstable_root_count`], [`stability_map`] |
//! | which stiffness or damping does a delay allow? | [`maximum_stiffness`], [`minimum_damping`], [`decay_stiffness`] |
//! | what does a predictor change? | [`predicted_maximum_stiffness`], [`predicted_maximum_delay`], [`predicted_unstable_root_count`], [`predicted_stability_map`] |
//! | what do the paper's formulas give? | [`paper_critical_stiffness`], [`paper_maximum_delay`] |

mod box_tests;
pub(crate) mod branch_and_bound;
pub(crate) mod complex_box;
mod critical;
mod crossing_search;
mod crossings;
mod decay;
mod intervals;
mod inverse;
mod lines;
mod paper;
mod polynomial;
mod prediction;
mod undamped_resonance;

pub(crate) use intervals::is_in_any;

pub use critical::{critical_stiffness, is_delay_independent};
pub use crossings::{Crossing, Crossings, crossings};
pub use decay::decay_stiffness;
pub use intervals::{intersection, maximum_delay, stability_map, stable_delays, unstable_root_count};
pub use inverse::{maximum_stiffness, minimum_damping};
pub use paper::{paper_critical_stiffness, paper_maximum_delay};
pub use prediction::{
    predicted_maximum_delay, predicted_maximum_stiffness, predicted_stability_map,
    predicted_unstable_root_count,
};
