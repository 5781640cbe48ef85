//! One side under a held force, from tick to tick, exactly.
//!
//! Everything is written in w = z − 1: at 1 kHz the poles of a robot lie within 1 % of z = 1, and
//! polynomials in z would lose six digits to cancellation there.

use crate::model::Side;

/// A 2 × 2 matrix by rows.
type Matrix = [[f64; 2]; 2];

/// Mass, damper and ground spring between two ticks: X⁺ = (1 + Ψ) X + Γ_new F_n + Γ_old F_(n−1), where
/// X is (position, velocity) and F_n is computed from the samples of tick n.
#[derive(Debug, Clone, Copy)]
pub(super) struct SampledPlant {
    /// Ψ = e^(A h) − 1.
    pub change: Matrix,
    /// Γ_new: the effect of the force that is computed at this tick.
    pub new_force: [f64; 2],
    /// Γ_old: the effect of the previous force, which acts until the computing time is over.
    pub old_force: [f64; 2],
    /// True where a computing time makes the previous force act at all.
    pub computes: bool,
}

impl SampledPlant {
    /// The side over one period (s), the force switching `computing_time` (s) after the tick.
    pub fn new(side: &Side, period: f64, computing_time: f64) -> Self {
        let (change, whole) = advance(side, period);
        if computing_time == 0.0 {
            return Self { change, new_force: whole, old_force: [0.0; 2], computes: false };
        }
        let (late_change, new_force) = advance(side, period - computing_time);
        let (_, early) = advance(side, computing_time);
        let old_force =
            [0, 1].map(|row| early[row] + late_change[row][0] * early[0] + late_change[row][1] * early[1]);
        Self { change, new_force, old_force, computes: true }
    }

    /// The characteristic polynomial of the side alone in w, constant term first; with a computing time
    /// it carries the factor z of the force that waits.
    pub fn denominator(&self) -> Vec<f64> {
        let [[a, b], [c, d]] = self.change;
        let plant = [a * d - b * c, -(a + d), 1.0];
        if self.computes { times_z(&plant) } else { plant.to_vec() }
    }

    /// The numerator in w of stiffness × position + damping × velocity, per force.
    pub fn numerator(&self, stiffness: f64, damping: f64) -> Vec<f64> {
        let [[a, b], [c, d]] = self.change;
        // adj(w − Ψ) Γ, read by the row (stiffness, damping).
        let read = |[x, v]: [f64; 2]| {
            [stiffness * (b * v - d * x) + damping * (c * x - a * v), stiffness * x + damping * v]
        };
        let now = read(self.new_force);
        if !self.computes {
            return now.to_vec();
        }
        let mut numerator = times_z(&now);
        for (sum, part) in numerator.iter_mut().zip(read(self.old_force)) {
            *sum += part;
        }
        numerator
    }
}

/// A polynomial in w times z = 1 + w.
fn times_z(polynomial: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; polynomial.len() + 1];
    for (i, &coefficient) in polynomial.iter().enumerate() {
        product[i] += coefficient;
        product[i + 1] += coefficient;
    }
    product
}

/// e^(A t) − 1 and ∫₀ᵗ e^(A s) ds (0, 1/M)ᵀ: a Taylor series over a short span, doubled up to t.
fn advance(side: &Side, span: f64) -> (Matrix, [f64; 2]) {
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
