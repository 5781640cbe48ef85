//! Stability criteria of one axis of a dyad.
//!
//! A root of the characteristic function lies on the imaginary axis, at s = jω, exactly where
//! |P₁(jω)|²|P₂(jω)|² = (k² + c²ω²)² (the magnitudes agree) and the phase of the delay makes up the
//! rest. Everything else here follows from these two facts:
//!
//! | question | function |
//! |---|---|
//! | where do roots meet the imaginary axis? | [`crossings`] |
//! | which stiffness is stable at every constant delay? | [`critical_stiffness`], [`is_delay_independent`] |
//! | which delays are stable? | [`maximum_delay`], [`stable_delays`], [`unstable_root_count`], [`stability_map`] |
//! | which stiffness or damping does a delay bear? | [`maximum_stiffness`], [`minimum_damping`], [`decay_stiffness`] |
//! | what does the paper say? | [`paper_critical_stiffness`], [`paper_maximum_delay`] |

mod branch_and_bound;
mod critical;
mod crossings;
mod intervals;
mod inverse;
mod paper;
mod polynomial;
mod undamped_resonance;

pub(crate) use intervals::is_in_any;

pub use critical::{critical_stiffness, is_delay_independent};
pub use crossings::{Crossing, Crossings, crossings};
pub use intervals::{intersection, maximum_delay, stability_map, stable_delays, unstable_root_count};
pub use inverse::{decay_stiffness, maximum_stiffness, minimum_damping};
pub use paper::{paper_critical_stiffness, paper_maximum_delay};
