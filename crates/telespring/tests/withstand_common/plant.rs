//! A robot and what holds it, on one axis, advanced by the matrix exponential under held forces or behind a lag; shares no
//! code with the core.

use nalgebra::{Matrix3, Matrix5, Vector3, Vector5};

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
    lag: Option<Lag>,
}

/// An actuator whose force follows the commanded one with a time constant, and the motion behind it: the state is
/// position, velocity, force of the robot, commanded force, force of the hand.
#[derive(Debug, Clone)]
struct Lag {
    /// The force of the robot, N.
    force: f64,
    whole: Matrix5<f64>,
    /// The nodes of the first and of the second half of the period.
    parts: [[Matrix5<f64>; 5]; 2],
}

/// What happened over one period.
#[derive(Debug, Clone, Copy)]
pub struct Step {
    /// The displacement, m.
    pub moved: f64,
    /// ∫ v² dt, m²/s.
    pub squares: f64,
    /// The mean force of the robot, N.
    pub mean: f64,
    /// The work of the robot, ∫ F v dt, J.
    pub work: f64,
    /// The most of that work that the mean force does not show, J; 0 for a held force.
    pub unseen: f64,
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
            lag: None,
        }
    }

    /// The same behind an actuator of this time constant (s), which rests.
    pub fn behind_lag(self, damping: f64, time_constant: f64) -> Self {
        let (mass, rate) = (self.mass, 1.0 / time_constant);
        let mut generator = Matrix5::zeros();
        generator[(0, 1)] = 1.0;
        generator[(1, 0)] = -self.stiffness / mass;
        generator[(1, 1)] = -damping / mass;
        (generator[(1, 2)], generator[(1, 4)]) = (1.0 / mass, 1.0 / mass);
        (generator[(2, 2)], generator[(2, 3)]) = (-rate, rate);
        let after = |time: f64| (generator * time).exp();
        let parts = [0.0, 1.0].map(|half| NODES.map(|(node, _)| after(0.5 * (half + node) * self.period)));
        Self { lag: Some(Lag { force: 0.0, whole: after(self.period), parts }), ..self }
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

    /// Advances one period under a command to the actuator and a held force of the hand, N.
    pub fn advance_robot(&mut self, command: f64, hand: f64) -> Step {
        let Some(lag) = &mut self.lag else {
            let (moved, squares) = self.advance(command + hand);
            return Step { moved, squares, mean: command, work: command * moved, unseen: 0.0 };
        };
        let before = Vector5::new(self.position, self.velocity, lag.force, command, hand);
        let after = lag.whole * before;
        let within = lag.parts.each_ref().map(|half| half.each_ref().map(|part| part * before));
        let integral = |value: &dyn Fn(&Vector5<f64>) -> f64| {
            let halves = within.iter().flat_map(|half| half.iter().zip(NODES));
            0.5 * self.period * halves.map(|(state, (_, weight))| weight * value(state)).sum::<f64>()
        };
        let (squares, work) = (integral(&|state| state[1].powi(2)), integral(&|state| state[1] * state[2]));
        let mean = integral(&|state| state[2]) / self.period;
        let speeds = [before[1], after[1]].into_iter().chain(within.iter().flatten().map(|state| state[1]));
        let (low, high) =
            speeds.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        // |∫ (F − mean) (v − middle)| with a force that rises or falls all the time
        let unseen = 0.25 * (after[2] - before[2]).abs() * (high - low) * self.period;
        lag.force = after[2];
        (self.position, self.velocity) = (after[0], after[1]);
        Step { moved: after[0] - before[0], squares, mean, work, unseen }
    }
}
