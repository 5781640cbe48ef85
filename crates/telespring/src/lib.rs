//! Stability, simulation and analysis of two people coupled through robots over a delayed network.
//!
//! This crate is pure: it reads no clock, does no input or output, and knows no Python.
//!
//! | module | job |
//! |---|---|
//! | [`model`] | robots, operators, dyads; validated once, at the door |
//! | [`study`] | the text of a study file to the model |
//! | [`criteria`] | crossings, critical stiffness, stable delays and their inverses, for one axis |
//! | [`verdicts`](mod@verdicts) | the four verdicts on a dyad over a network |
//! | [`spectrum`] | characteristic roots with a certificate that none is missing |
//! | [`response`] | transfer matrix, Nyquist locus, magnitude and phase |
//! | [`dde`] | the dyad in time: exact for the linear model, adaptive for any right-hand side |
//! | [`session`] | one side of a live coupling: bytes and time in, force and bytes out |
//! | [`rig`] | the virtual laboratory that drives two sessions in virtual time |
//! | [`delay_system`] | any linear system with several constant delays |
//! | [`poses`] | a dyad in jointed arms, one frozen pose at a time |
//! | [`quantity`] | the quantities that enter, with their units and ranges |
//! | [`error`] | what is refused at the door, and how it is told |
//!
//! Everything is in SI units. With k the stiffness of the spring, c the damper beside it and T the sum of
//! both one-way delays, one axis of a dyad has the characteristic function
//! χ(s) = P₁(s) P₂(s) − (k + c s)² e^(−T s), Pᵢ(s) = mᵢ s² + (bᵢ + c) s + k + k_h,i; its zeros, the
//! characteristic roots, decide what is stable.

pub mod criteria;
pub mod dde;
pub mod delay_system;
pub mod error;
pub mod model;
pub mod poses;
pub mod quantity;
pub mod response;
pub mod rig;
pub mod session;
pub mod spectrum;
pub mod study;
pub mod verdicts;

mod characteristic;
mod poly;

#[cfg(feature = "fuzzing")]
#[doc(hidden)]
pub mod fuzzing {
    //! Inner functions that the fuzzers call.

    /// The positive roots of a polynomial of degree up to 8, its coefficients from the constant on.
    pub fn positive_roots(coefficients: &[f64]) -> Vec<f64> {
        use crate::poly::{Polynomial, positive_roots};
        let mut coefficient = [0.0; 9];
        coefficient[..coefficients.len()].copy_from_slice(coefficients);
        let magnitude = coefficient.map(f64::abs);
        let polynomial = Polynomial { coefficient, magnitude };
        let precise = || Polynomial { coefficient: coefficient.map(twofloat::TwoFloat::from), magnitude };
        positive_roots(&polynomial, precise).iter().map(|root| root.at).collect()
    }
}

pub use error::{InvalidInput, Result};
pub use model::{Delay, Dyad, DyadAxis, Operator, Robot, Side, hman};
