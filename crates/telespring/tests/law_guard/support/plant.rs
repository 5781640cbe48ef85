//! A robot and what holds it, on one axis, advanced by the matrix exponential under held forces; shares no code with the
//! core.

use nalgebra::{Matrix3, Vector3};

/// Nodes and weights of the Gauss–Legendre rule with five points on [0, 1].
const NODES: [(f64, f64); 5] = [
    (0.046_910_077_030_668, 0.118_463_442_528_094_5),
    (0.230_765_344_947_158_45, 0.239_314_335_249_683_23),
    (0.5, 0.284_444_444_444_444_44),
    (0.769_234_655_052_841_5, 0.239_314_335_249_683_23),
    (0.953_089_922_969_332, 0.118_463_442_528_094_5),
];

/// One axis: M x'' + B x' + K x = force.
#[derive(Debug, Clone)]
pub struct AxisPlant {
    pub mass: f64,
    pub stiffness: f64,
    pub position: f64,
    pub velocity: f64,
    period: f64,
    whole: Matrix3<f64>,
    parts: [Matrix3<f64>; 5],
}

impl AxisPlant {
    pub fn new(mass: f64, damping: f64, stiffness: f64, period: f64) -> Self {
        let generator =
            Matrix3::new(0.0, 1.0, 0.0, -stiffness / mass, -damping / mass, 1.0 / mass, 0.0, 0.0, 0.0);
        let after = |time: f64| (generator * time).exp();
        Self {
            mass,
            stiffness,
            position: 0.0,
            velocity: 0.0,
            period,
            whole: after(period),
            parts: NODES.map(|(node, _)| after(node * period)),
        }
    }

    /// Kinetic energy, and that in the ground spring, J.
    pub fn energy(&self) -> f64 {
        0.5 * self.mass * self.velocity.powi(2) + 0.5 * self.stiffness * self.position.powi(2)
    }

    /// Advances one period under a held force; returns the displacement and ∫ v² over it.
    pub fn advance(&mut self, force: f64) -> (f64, f64) {
        let before = Vector3::new(self.position, self.velocity, force);
        let squares =
            self.parts.iter().zip(NODES).map(|(part, (_, weight))| weight * (part * before)[1].powi(2));
        let squares = self.period * squares.sum::<f64>();
        let after = self.whole * before;
        (self.position, self.velocity) = (after[0], after[1]);
        (after[0] - before[0], squares)
    }
}
