//! A robot with a lumped arm, constant in every pose: M v' = F − B v − friction on each axis.
//!
//! Forces are held, so the motion between two events is known exactly. Events are the stop, where v passes
//! zero, and the start, where the axis breaks loose. At rest, friction balances any force up to the Coulomb
//! level; in motion it opposes the motion at the Coulomb level (static and kinetic friction are equal).

use super::RelaxingForce;
use crate::rig::Handle;

/// One axis of robot and arm.
#[derive(Debug, Clone, Copy)]
struct Axis {
    /// Combined mass of robot and arm, kg.
    mass: f64,
    /// Combined damping of robot and arm, N·s/m.
    damping: f64,
    /// N.
    coulomb: f64,
    arm_mass: f64,
    arm_damping: f64,
    position: f64,
    velocity: f64,
    /// The exact map of the last span.
    step: SpanMap,
    relaxation: Relaxation,
}

/// The exact map of an axis without friction over a span: with z = B·span/M, v ← decay·v + gain·F and x ← x
/// + reach·v + push·F.
#[derive(Debug, Clone, Copy)]
struct SpanMap {
    span: f64,
    decay: f64,
    gain: f64,
    reach: f64,
    push: f64,
}

/// The averages φ₁(z) = (1 − e^(−z))/z and φ₂(z) = (1 − φ₁(z))/z of an exponential, for a lumped arm.
pub(super) fn exponential_averages(z: f64) -> (f64, f64) {
    if z > 0.5 {
        let first = -(-z).exp_m1() / z;
        return (first, (1.0 - first) / z);
    }
    // φ₂ = Σ (−z)ⁿ/(n+2)!: 1 − φ₁ would cancel
    let (mut term, mut second) = (0.5, 0.5);
    for n in 3..18 {
        term *= -z / f64::from(n);
        second += term;
    }
    (1.0 - z * second, second)
}

impl SpanMap {
    /// The exact map of one axis of a lumped plant, with this mass (kg) and damping (N·s/m), over a span (s).
    fn new(mass: f64, damping: f64, span: f64) -> Self {
        let z = damping / mass * span;
        let (first, second) = exponential_averages(z);
        Self {
            span,
            decay: (-z).exp(),
            gain: span / mass * first,
            reach: span * first,
            push: span * span / mass * second,
        }
    }
}

/// The effect of a force e^(−t/τ) over a span on velocity and position of an axis without friction.
#[derive(Debug, Clone, Copy)]
struct Relaxation {
    span: f64,
    gain: f64,
    push: f64,
}

impl Relaxation {
    /// The lumped plant under a relaxing force: with p = B·span/M and q = span/τ the gains are divided
    /// differences of the exponential: span/M exp[−p, −q] and span²/M exp[0, −p, −q].
    fn new(mass: f64, damping: f64, time_constant: f64, span: f64) -> Self {
        let (p, q) = (damping / mass * span, span / time_constant);
        let (low, high) = (p.min(q), p.max(q));
        let first = (-low).exp() * exponential_averages(high - low).0;
        let second = if high > 1.0 {
            (exponential_averages(low).0 - first) / high
        } else {
            // Σ hₙ(−p, −q)/(n+2)!, hₙ the complete homogeneous polynomial
            let (mut power, mut sum, mut factorial, mut second) = (1.0, 1.0, 0.5, 0.5);
            for n in 3..20 {
                power *= -high;
                sum = power - low * sum;
                factorial /= f64::from(n);
                second += sum * factorial;
            }
            second
        };
        Self { span, gain: span / mass * first, push: span * span / mass * second }
    }
}

impl Axis {
    /// Moves an axis of the lumped plant under a constant force, friction not considered.
    fn slide(&mut self, step: &SpanMap, force: f64) {
        self.position += step.reach * self.velocity + step.push * force;
        self.velocity = step.decay * self.velocity + step.gain * force;
    }

    /// Moves an axis of the lumped plant over a span under a held force, with friction.
    fn advance(&mut self, force: f64, span: f64) {
        if self.step.span != span {
            self.step = SpanMap::new(self.mass, self.damping, span);
        }
        let step = self.step;
        if self.coulomb == 0.0 {
            return self.slide(&step, force);
        }
        if self.velocity == 0.0 {
            return self.start_from_rest(force, &step);
        }
        let net = force - self.coulomb.copysign(self.velocity);
        let end = step.decay * self.velocity + step.gain * net;
        if net * self.velocity >= 0.0 {
            // Nothing stops it; strong damping may round the velocity to 0.
            return self.slide(&step, net);
        }
        if end != 0.0 && end.is_sign_positive() == self.velocity.is_sign_positive() {
            // v is monotonic under a constant force: it has not passed zero.
            return self.slide(&step, net);
        }
        // v = 0 at t = (M/B) ln(1 − B v/net); net opposes v here.
        let ratio = -self.damping * self.velocity / net;
        let stretched = if ratio < 1e-300 { 1.0 } else { ratio.ln_1p() / ratio };
        let stop = (-self.mass * self.velocity / net * stretched).min(span);
        let until = SpanMap::new(self.mass, self.damping, stop);
        self.position += until.reach * self.velocity + until.push * net;
        self.velocity = 0.0;
        self.start_from_rest(force, &SpanMap::new(self.mass, self.damping, span - stop));
    }

    /// The lumped axis from rest: sticks, or breaks loose at once and cannot stop again under a constant force.
    fn start_from_rest(&mut self, force: f64, step: &SpanMap) {
        if force.abs() > self.coulomb {
            self.slide(step, force - self.coulomb.copysign(force));
        }
    }

    /// As [`Axis::advance`] of the lumped plant under held + relaxing·e^(−t/τ), friction not considered.
    fn advance_relaxing(&mut self, held: f64, relaxing: f64, time_constant: f64, span: f64) {
        if self.relaxation.span != span {
            self.relaxation = Relaxation::new(self.mass, self.damping, time_constant, span);
        }
        self.advance(held, span);
        self.velocity += self.relaxation.gain * relaxing;
        self.position += self.relaxation.push * relaxing;
    }

    /// The Coulomb friction on an axis of the lumped plant under a force, N.
    fn friction_force(&self, force: f64) -> f64 {
        if self.velocity == 0.0 {
            force.clamp(-self.coulomb, self.coulomb)
        } else {
            self.coulomb.copysign(self.velocity)
        }
    }

    /// The force of the lumped arm on the handle on one axis, N.
    fn handle_force(&self, robot_force: f64, hand_force: f64) -> f64 {
        let force = robot_force + hand_force;
        let acceleration = (force - self.damping * self.velocity - self.friction_force(force)) / self.mass;
        hand_force - self.arm_mass * acceleration - self.arm_damping * self.velocity
    }
}

/// A robot with a lumped arm.
#[derive(Debug, Clone)]
pub struct LumpedPlant {
    axes: [Axis; 2],
}

impl LumpedPlant {
    /// A lumped plant at rest at `position` (m), with mass (kg) and damping (N·s/m) of the arm per axis; both
    /// zero is the ideal massless arm.
    pub fn new(handle: Handle, arm_mass: [f64; 2], arm_damping: [f64; 2], position: [f64; 2]) -> Self {
        let axis = |axis: usize| {
            let (mass, damping) =
                (handle.mass[axis] + arm_mass[axis], handle.damping[axis] + arm_damping[axis]);
            Axis {
                mass,
                damping,
                coulomb: handle.coulomb[axis],
                arm_mass: arm_mass[axis],
                arm_damping: arm_damping[axis],
                position: position[axis],
                velocity: 0.0,
                step: SpanMap::new(mass, damping, 0.0),
                relaxation: Relaxation { span: 0.0, gain: 0.0, push: 0.0 },
            }
        };
        Self { axes: [axis(0), axis(1)] }
    }

    /// The same lumped plant with this velocity, m/s.
    #[must_use]
    pub fn with_velocity(mut self, velocity: [f64; 2]) -> Self {
        for (axis, velocity) in self.axes.iter_mut().zip(velocity) {
            axis.velocity = velocity;
        }
        self
    }

    /// The position of the handle with the lumped arm, m.
    pub fn position(&self) -> [f64; 2] {
        self.axes.each_ref().map(|axis| axis.position)
    }

    /// The velocity of the handle with the lumped arm, m/s.
    pub fn velocity(&self) -> [f64; 2] {
        self.axes.each_ref().map(|axis| axis.velocity)
    }

    /// Moves the lumped plant over `span` s under held forces, N per axis.
    pub fn advance(&mut self, robot_force: [f64; 2], hand_force: [f64; 2], span: f64) {
        for (index, axis) in self.axes.iter_mut().enumerate() {
            axis.advance(robot_force[index] + hand_force[index], span);
        }
    }

    /// Moves the lumped plant over `span` s under an exponentially relaxing robot force: exact without Coulomb
    /// friction; with friction the mean force is held.
    pub fn advance_relaxing(&mut self, robot_force: &RelaxingForce, hand_force: [f64; 2], span: f64) {
        let mean = robot_force.mean(span);
        for (index, axis) in self.axes.iter_mut().enumerate() {
            if axis.coulomb > 0.0 {
                axis.advance(mean[index] + hand_force[index], span);
                continue;
            }
            let held = robot_force.to[index] + hand_force[index];
            let relaxing = robot_force.from[index] - robot_force.to[index];
            axis.advance_relaxing(held, relaxing, robot_force.time_constant, span);
        }
    }

    /// The force of the lumped arm on the handle, N per axis; for a massless arm the force of the hand.
    pub fn handle_force(&self, robot_force: [f64; 2], hand_force: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|index| self.axes[index].handle_force(robot_force[index], hand_force[index]))
    }
}
