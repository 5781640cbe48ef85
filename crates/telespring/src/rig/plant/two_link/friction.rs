//! Coulomb friction of the robot's axes, coupled through the inertia of the arm: which axis sticks or
//! slips.

use super::dynamics::ForceBalance;

/// An axis breaks loose at this fraction above the friction level. A smaller excess force, of the size of
/// rounding, might leave it stuck again and again.
const EXCESS: f64 = 1e-12;

/// The excess of the holding force over the friction level, N; at most 0 if the axis sticks.
#[inline]
pub(super) fn sticking_excess(friction: f64, level: f64) -> f64 {
    friction.abs() - (1.0 + EXCESS) * level
}

/// The contact state of one axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Contact {
    /// No friction.
    Frictionless,
    /// The axis moves in the positive direction, or is about to.
    Forward,
    /// The axis moves in the negative direction, or is about to.
    Backward,
    /// Friction is as large as needed to hold the axis.
    Stuck,
}

impl Contact {
    /// The sign of the velocity in this contact under friction; zero if any is possible.
    pub fn direction(self) -> f64 {
        match self {
            Self::Forward => 1.0,
            Self::Backward => -1.0,
            Self::Frictionless | Self::Stuck => 0.0,
        }
    }

    /// The friction contacts possible at a velocity of one axis.
    fn candidates(velocity: f64, level: f64) -> &'static [Self] {
        if level == 0.0 {
            &[Self::Frictionless]
        } else if velocity > 0.0 {
            &[Self::Forward]
        } else if velocity < 0.0 {
            &[Self::Backward]
        } else {
            &[Self::Stuck, Self::Forward, Self::Backward]
        }
    }
}

/// Acceleration and friction of both axes.
#[derive(Debug, Clone, Copy)]
pub(super) struct ContactMotion {
    pub acceleration: [f64; 2],
    /// The friction force on the handle, N.
    pub friction: [f64; 2],
}

/// Acceleration and friction under given contacts; `level` is the friction level per axis, N.
#[inline]
pub(super) fn motion_under(balance: &ForceBalance, contact: [Contact; 2], level: [f64; 2]) -> ContactMotion {
    use Contact::Stuck;
    let mass = &balance.mass;
    let mut friction = [-contact[0].direction() * level[0], -contact[1].direction() * level[1]];
    let push = [balance.push[0] + friction[0], balance.push[1] + friction[1]];
    let acceleration = match contact {
        [Stuck, Stuck] => [0.0; 2],
        [Stuck, _] => [0.0, push[1] / mass.yy],
        [_, Stuck] => [push[0] / mass.xx, 0.0],
        _ => mass.solve(push),
    };
    let needed = mass.times(acceleration);
    for axis in 0..2 {
        if contact[axis] == Stuck {
            friction[axis] = needed[axis] - balance.push[axis];
        }
    }
    ContactMotion { acceleration, friction }
}

/// The contacts of both axes (sticking or slipping) that friction allows at a velocity.
///
/// An axis at rest sticks if the holding force does not exceed the friction level; otherwise it starts
/// against full friction. The holding force of one axis depends on whether the other moves; since the mass
/// matrix is positive definite, exactly one pair of contacts is consistent.
#[inline]
pub(super) fn consistent_contacts(
    balance: &ForceBalance,
    velocity: [f64; 2],
    level: [f64; 2],
) -> [Contact; 2] {
    let [first, second] = [0, 1].map(|axis| Contact::candidates(velocity[axis], level[axis]));
    if let ([first], [second]) = (first, second) {
        return [*first, *second];
    }
    let inertia = balance.mass.diagonal();
    let mut best = ([first[0], second[0]], f64::INFINITY);
    for contact in first.iter().flat_map(|&x| second.iter().map(move |&y| [x, y])) {
        let motion = motion_under(balance, contact, level);
        let violation = (0..2)
            .filter(|&axis| velocity[axis] == 0.0)
            .map(|axis| match contact[axis] {
                Contact::Stuck => sticking_excess(motion.friction[axis], level[axis]),
                slipping => -slipping.direction() * motion.acceleration[axis] * inertia[axis],
            })
            .fold(0.0, f64::max);
        // Rounding may leave no consistent pair: then take the one with the smallest violation.
        if violation < best.1 {
            best = (contact, violation);
        }
    }
    best.0
}
