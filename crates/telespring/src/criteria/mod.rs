//! Stability criteria of one axis of a dyad, and the verdicts on a whole dyad.
//!
//! A root of the characteristic function lies on the imaginary axis, at s = jω, exactly where
//! |P₁(jω)|²|P₂(jω)|² = (k² + c²ω²)² (the magnitudes agree, [`polynomial`]) and the phase of the
//! delay makes up the rest ([`crossings`]). Everything else here follows from these two facts:
//! which stiffness is stable at every delay ([`critical`]), which delays are stable
//! ([`intervals`]), and the inverses that solve for the stiffness or the damping ([`curve`],
//! [`inverse`]).

mod critical;
mod crossings;
mod curve;
mod intervals;
mod inverse;
mod paper;
mod polynomial;
pub mod verdicts;

pub use critical::{critical_stiffness, is_delay_independent};
pub use crossings::{Crossing, Crossings, crossings};
pub use intervals::{maximum_delay, stability_map, stable_delays, unstable_root_count};

pub use inverse::{decay_stiffness, maximum_stiffness, minimum_damping};
pub use paper::{paper_critical_stiffness, paper_maximum_delay};
