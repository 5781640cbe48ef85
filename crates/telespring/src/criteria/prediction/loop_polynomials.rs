//! The polynomials of a loop with a predictor: χ(s) = N₁ N₂ − D₁ D₂ e^(−T s), all multiplied by the filters' denominator d.
//!
//! Nᵢ = (mᵢ s² + (bᵢ + c) s + k + k_h,i) d is one side, D = k x + c v what it is pulled by, with the numerators x and v of
//! the predicted position and velocity.

use crate::model::{DyadAxis, Side};
use crate::prediction::PredictionFilter;

/// The coefficients of a polynomial of degree up to 5 in s, constant first.
pub(super) type Quintic = [f64; 6];

/// The polynomials of one side.
#[derive(Debug, Clone, Copy)]
pub(super) struct SidePolynomials {
    /// N − D, formed without cancellation; its constant is 0 exactly if the handle is free.
    pub alone: Quintic,
    /// D.
    pub coupling: Quintic,
    /// N.
    pub whole: Quintic,
}

/// A loop with a predictor at any stiffness and age.
#[derive(Debug, Clone, Copy)]
pub(super) struct PredictedLoop<'a> {
    pub axis: &'a DyadAxis,
    pub filter: PredictionFilter,
}

/// A polynomial times s^`power`, times a factor, added to another one.
fn add(sum: &mut Quintic, factor: f64, polynomial: &[f64], power: usize) {
    for (place, coefficient) in polynomial.iter().enumerate() {
        if let Some(term) = sum.get_mut(place + power) {
            *term += factor * coefficient;
        }
    }
}

impl PredictedLoop<'_> {
    /// The polynomials of one side at a stiffness (N/m) and an age (s).
    pub fn side(&self, side: &Side, stiffness: f64, age: f64) -> SidePolynomials {
        let c = self.axis.coupling_damping;
        let d = &self.filter.denominator;
        let (mut alone, mut coupling, mut whole) = ([0.0; 6], self.coupling(stiffness, age), [0.0; 6]);
        for (power, factor) in [side.ground_stiffness, side.damping, side.mass].into_iter().enumerate() {
            add(&mut alone, factor, d, power);
            add(&mut whole, factor, d, power);
        }
        add(&mut whole, c, d, 1);
        add(&mut whole, stiffness, d, 0);
        add(&mut alone, stiffness, &self.filter.missing(age), 0);
        // c (s d − v): the lowest terms of both are the same
        for power in self.filter.order + 1..5 {
            alone[power] += c * d[power - 1];
        }
        add(&mut alone, -c * age, &self.filter.estimate(2), 0);
        // exactly 0 beyond its degree
        coupling[5] = 0.0;
        SidePolynomials { alone, coupling, whole }
    }

    /// D at a stiffness and an age.
    fn coupling(&self, stiffness: f64, age: f64) -> Quintic {
        let mut coupling = [0.0; 6];
        add(&mut coupling, stiffness, &self.filter.position(age), 0);
        add(&mut coupling, self.axis.coupling_damping, &self.filter.velocity(age), 0);
        coupling
    }

    /// The derivative of D by the age, at a stiffness and an age; that of N − D is its negative.
    pub fn coupling_by_age(&self, stiffness: f64, age: f64) -> Quintic {
        let mut slope = [0.0; 6];
        add(&mut slope, stiffness, &self.filter.velocity(age), 0);
        add(&mut slope, self.axis.coupling_damping, &self.filter.estimate(2), 0);
        slope
    }

    /// A bound on |s| of every root with Re s ≥ 0, for all stiffnesses and ages up to these.
    pub fn root_bound(&self, stiffness: f64, age: f64) -> f64 {
        self.axis.sides.iter().fold(0.0, |bound: f64, side| {
            let SidePolynomials { coupling, whole, .. } = self.side(side, stiffness, age);
            let degree = whole.iter().rposition(|&coefficient| coefficient > 0.0).unwrap_or(0);
            let (lower, leading) = (&whole[..degree], whole[degree]);
            // the leading term exceeds the sum of all others: Fujiwara's bound
            let others = lower.iter().zip(&coupling).enumerate();
            let root = others.fold(0.0, |root: f64, (power, (own, delayed))| {
                root.max(((own + delayed) / leading).powf(1.0 / (degree - power) as f64))
            });
            bound.max(2.0 * root)
        })
    }
}
