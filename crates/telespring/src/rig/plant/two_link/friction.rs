//! Coulomb friction of the robot's axes, coupled through the arm's inertia: which axis slips, which sticks.

use super::dynamics::ForceBalance;

/// An axis lets go at this part of the level above it: the force that is then left over starts it without
/// doubt, where one of rounding's size could as well leave it stuck, again and again.
const EXCESS: f64 = 1e-12;

/// By how much the force that would hold an axis is too large for it to stick, N; at most 0 where it does.
#[inline]
pub(super) fn sticking_excess(friction: f64, level: f64) -> f64 {
    friction.abs() - (1.0 + EXCESS) * level
}

/// What friction does on one axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Contact {
    /// There is none.
    Frictionless,
    /// The axis moves towards positive positions, or is about to.
    Forward,
    /// The axis moves towards negative positions, or is about to.
    Backward,
    /// Friction is as large as it must be to hold the axis.
    Stuck,
}

impl Contact {
    /// The sign of a velocity that this contact allows; zero where any does.
    pub fn direction(self) -> f64 {
        match self {
            Self::Forward => 1.0,
            Self::Backward => -1.0,
            Self::Frictionless | Self::Stuck => 0.0,
        }
    }

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

/// What both contacts lead to.
#[derive(Debug, Clone, Copy)]
pub(super) struct ContactMotion {
    pub acceleration: [f64; 2],
    /// Force of friction on the handle, N.
    pub friction: [f64; 2],
}

/// Acceleration and friction under given contacts; `level` is the largest friction per axis, N.
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

/// The contacts that hold at this velocity.
///
/// An axis at rest sticks where the force that holds it is at most the level, else it starts against
/// full friction. What holds one axis depends on whether the other moves; as the mass matrix is positive
/// definite, exactly one choice for both is consistent.
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
        // rounding may leave no choice without any: then the one nearest to it
        if violation < best.1 {
            best = (contact, violation);
        }
    }
    best.0
}
