//! Stability, simulation and analysis of two people coupled through robots over a delayed network.
//!
//! This crate is pure: it reads no clock, does no input or output, and knows no Python.
//!
//! | module | job |
//! |---|---|
//! | [`model`] | robots, operators, dyads, with checked values |
//! | [`study`] | reads and writes study files |
//! | [`criteria`] | crossings, critical stiffness, stable delays and their inverses, for one axis |
//! | [`verdicts`](mod@verdicts) | the five verdicts on a dyad over a network |
//! | [`decision`] | the answer in one word, with what it keeps in reserve |
//! | [`spectrum`] | characteristic roots with a certificate that none is missing |
//! | [`response`] | transfer matrix, Nyquist locus, magnitude and phase |
//! | [`dde`] | time response: exact for the linear dyad, adaptive for any right-hand side |
//! | [`session`] | one side of a live coupling: packets and time in, force and packets out |
//! | [`prediction`] | what a predictor does to the loop |
//! | [`rig`] | the virtual laboratory: two sessions, robots, arms and a network in virtual time |
//! | [`delay_system`] | any linear system with several constant delays |
//! | [`population`] | how often the paper's critical stiffness is unsafe in a population of dyads |
//! | [`poses`] | a dyad held by two-link arms, one frozen pose at a time |
//! | [`quantity`] | the physical quantities with their units and ranges |
//! | [`error`] | the error type for invalid input |
//!
//! All values are in SI units. Let k be the stiffness of the spring, c the damper parallel to it and T the
//! sum of both one-way delays. One axis of a dyad then has the characteristic function χ(s) = P₁(s) P₂(s) −
//! (k + c s)² e^(−T s) with Pᵢ(s) = mᵢ s² + (bᵢ + c) s + k + k_h,i. Its zeros, the characteristic roots,
//! decide stability.

pub mod criteria;
pub mod dde;
pub mod decision;
pub mod delay_system;
pub mod error;
pub mod model;
pub mod population;
pub mod poses;
pub mod prediction;
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
    //! Internal functions exposed to the fuzzers.

    /// The positive roots of a polynomial of degree up to 8; coefficients start with the constant term.
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

/// Runs the examples of the page on sessions.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/session.md")]
pub struct SessionPage;
