//! The exact motion of one side under a zero-order hold, from sample to sample.
//!
//! Polynomials are written in w = z − 1: at 1 kHz the poles of a robot lie within 1 % of z = 1, where
//! polynomials in z would lose six digits to cancellation.

use crate::model::Side;

/// A 2 × 2 matrix by rows.
type Matrix = [[f64; 2]; 2];

/// Mass, damper and ground spring over one sample period: X⁺ = (1 + Ψ) X + Γ_new F_n + Γ_old F_(n−1), where
/// X is (position, velocity) and F_n is computed from the samples at tick n.
#[derive(Debug, Clone, Copy)]
pub(super) struct SampledPlant {
    /// Ψ = e^(A h) − 1.
    pub change: Matrix,
    /// Γ_new: the effect of the force computed at this tick.
    pub new_force: [f64; 2],
    /// Γ_old: the effect of the previous force, which acts until the computing time has passed.
    pub old_force: [f64; 2],
    /// The sample period, s.
    pub period: f64,
    /// True if a computing time makes the previous force act.
    pub has_computing_time: bool,
}

impl SampledPlant {
    /// The side under zero-order hold over one period (s), the force switching `computing_time` (s) after the tick.
    pub fn new(side: &Side, period: f64, computing_time: f64) -> Self {
        let (change, whole) = exact_step(side, period);
        if computing_time == 0.0 {
            return Self { change, new_force: whole, old_force: [0.0; 2], period, has_computing_time: false };
        }
        let (late_change, new_force) = exact_step(side, period - computing_time);
        let (_, early) = exact_step(side, computing_time);
        let old_force =
            [0, 1].map(|row| early[row] + late_change[row][0] * early[0] + late_change[row][1] * early[1]);
        Self { change, new_force, old_force, period, has_computing_time: true }
    }

    /// The characteristic polynomial of one held side alone in w, constant term first; with a computing time it
    /// has an additional factor z.
    pub fn denominator(&self) -> Vec<f64> {
        let [[a, b], [c, d]] = self.change;
        let plant = [a * d - b * c, -(a + d), 1.0];
        if self.has_computing_time { multiply_by_z(&plant) } else { plant.to_vec() }
    }

    /// The numerator in w of stiffness × position + damping × velocity, per unit force under zero-order hold.
    pub fn numerator(&self, stiffness: f64, damping: f64) -> Vec<f64> {
        let [[a, b], [c, d]] = self.change;
        // adj(w − Ψ) Γ, read by the row (stiffness, damping).
        let read = |[x, v]: [f64; 2]| {
            [stiffness * (b * v - d * x) + damping * (c * x - a * v), stiffness * x + damping * v]
        };
        let now = read(self.new_force);
        if !self.has_computing_time {
            return now.to_vec();
        }
        let mut numerator = multiply_by_z(&now);
        for (sum, part) in numerator.iter_mut().zip(read(self.old_force)) {
            *sum += part;
        }
        numerator
    }
}

/// Multiplies a polynomial in w by z = 1 + w, for the zero-order hold.
fn multiply_by_z(polynomial: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; polynomial.len() + 1];
    for (i, &coefficient) in polynomial.iter().enumerate() {
        product[i] += coefficient;
        product[i + 1] += coefficient;
    }
    product
}

/// The exact response to a held force over a span: e^(A t) − 1 and ∫₀ᵗ e^(A s) ds (0, 1/M)ᵀ, from a Taylor
/// series over a short span that is doubled up to t.
fn exact_step(side: &Side, span: f64) -> (Matrix, [f64; 2]) {
    let damping = side.damping / side.mass;
    let spring = side.ground_stiffness / side.mass;
    let speed = damping.max(spring.sqrt());
    // With speed × span ≤ 1/4 the terms fall faster than 4⁻ⁿ/n!: 14 of them reach the last bit.
    let doublings = (4.0 * speed * span).log2().ceil().max(0.0);
    let span = span / doublings.exp2();
    let mut change = [[0.0; 2]; 2];
    let mut force = [0.0; 2];
    let mut power = [[1.0, 0.0], [0.0, 1.0]];
    for order in 1..=14 {
        let factor = span / f64::from(order);
        // ∫ of the previous power acts on (0, 1/M)ᵀ.
        for row in 0..2 {
            force[row] += power[row][1] * factor / side.mass;
        }
        power = power.map(|[x, v]| [-spring * v * factor, (x - damping * v) * factor]);
        for row in 0..2 {
            for column in 0..2 {
                change[row][column] += power[row][column];
            }
        }
    }
    for _ in 0..doublings as u32 {
        let [[a, b], [c, d]] = change;
        force = [2.0 * force[0] + a * force[0] + b * force[1], 2.0 * force[1] + c * force[0] + d * force[1]];
        change = [[2.0 * a + a * a + b * c, b * (2.0 + a + d)], [c * (2.0 + a + d), 2.0 * d + b * c + d * d]];
    }
    (change, force)
}
