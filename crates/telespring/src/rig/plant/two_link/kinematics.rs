//! Kinematics of the two-link arm: the pose of the links from the position of the handle.

use super::OutOfReach;
use crate::rig::{Elbow, TwoLinkArm};

/// The smallest |sin(elbow angle)| within reach: 5.7° from straight or folded. The apparent inertia and
/// damping grow with its inverse square; at this limit they are a hundred times those at a right angle.
pub const SMALLEST_ELBOW_SINE: f64 = 0.1;

/// The pose of both links at one position of the handle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pose {
    /// Unit vectors from shoulder to elbow and from elbow to handle.
    pub link: [[f64; 2]; 2],
    /// Cosine of the elbow angle.
    pub cosine: f64,
    /// Sine of the elbow angle, negative with the elbow on the left.
    pub sine: f64,
    /// Row i times the handle velocity is the angular velocity of link i with respect to the x axis, rad/s.
    pub rate: [[f64; 2]; 2],
}

/// The scalar product of two plane vectors of the arm.
#[inline]
pub(super) fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// Rotates a plane vector of the arm by a quarter turn counter-clockwise.
#[inline]
fn quarter_turn(a: [f64; 2]) -> [f64; 2] {
    [-a[1], a[0]]
}

impl Pose {
    /// The pose of the arm that holds the handle at `position`, m.
    #[inline]
    pub fn at(arm: &TwoLinkArm, position: [f64; 2]) -> Result<Self, OutOfReach> {
        let [upper, lower] = arm.link_length;
        let reach = [position[0] - arm.base[0], position[1] - arm.base[1]];
        let square = dot(reach, reach);
        let cosine = (square - upper * upper - lower * lower) / (2.0 * upper * lower);
        let sine_square = 1.0 - cosine * cosine;
        // A NaN position fails here too.
        if !(sine_square >= SMALLEST_ELBOW_SINE * SMALLEST_ELBOW_SINE) {
            return Err(OutOfReach { position });
        }
        let sine = match arm.elbow {
            Elbow::Left => -sine_square.sqrt(),
            Elbow::Right => sine_square.sqrt(),
        };
        // As complex numbers: reach = first (upper + lower (cosine + j sine)).
        let (along, across) = ((upper + lower * cosine) / square, lower * sine / square);
        let first = [along * reach[0] + across * reach[1], along * reach[1] - across * reach[0]];
        let second = [cosine * first[0] - sine * first[1], cosine * first[1] + sine * first[0]];
        let (by_first, by_second) = (1.0 / (upper * sine), -1.0 / (lower * sine));
        Ok(Self {
            link: [first, second],
            cosine,
            sine,
            rate: [
                [by_first * second[0], by_first * second[1]],
                [by_second * first[0], by_second * first[1]],
            ],
        })
    }

    /// The angular velocities of both links for a velocity of the handle, rad/s.
    #[inline]
    pub fn rates(&self, velocity: [f64; 2]) -> [f64; 2] {
        [dot(self.rate[0], velocity), dot(self.rate[1], velocity)]
    }

    /// The force at the handle equivalent to moments on both links in this pose, N.
    #[inline]
    pub fn force(&self, moment: [f64; 2]) -> [f64; 2] {
        [
            self.rate[0][0] * moment[0] + self.rate[1][0] * moment[1],
            self.rate[0][1] * moment[0] + self.rate[1][1] * moment[1],
        ]
    }

    /// The torques J(θ)ᵀ F of shoulder and elbow equivalent to a force at the handle, N·m.
    #[inline]
    pub fn torque(&self, arm: &TwoLinkArm, force: [f64; 2]) -> [f64; 2] {
        let elbow = arm.link_length[1] * dot(quarter_turn(self.link[1]), force);
        [arm.link_length[0] * dot(quarter_turn(self.link[0]), force) + elbow, elbow]
    }

    /// Transforms a quadratic form of the links' angular velocities to one of the handle velocity.
    #[inline]
    pub fn at_handle(&self, [first, cross, second]: [f64; 3]) -> Symmetric {
        let [a, b] = self.rate;
        let entry =
            |i: usize, j: usize| a[i] * (first * a[j] + cross * b[j]) + b[i] * (cross * a[j] + second * b[j]);
        Symmetric { xx: entry(0, 0), xy: entry(0, 1), yy: entry(1, 1) }
    }

    /// The angles of shoulder and elbow, rad, as defined in [`TwoLinkArm`].
    pub fn joint_angles(&self) -> [f64; 2] {
        [self.link[0][1].atan2(self.link[0][0]), self.sine.atan2(self.cosine)]
    }
}

/// A symmetric matrix over the axes x and y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Symmetric {
    pub xx: f64,
    pub xy: f64,
    pub yy: f64,
}

impl Symmetric {
    /// A symmetric matrix of the arm's kinematics times a vector.
    #[inline]
    pub fn times(&self, vector: [f64; 2]) -> [f64; 2] {
        [self.xx * vector[0] + self.xy * vector[1], self.xy * vector[0] + self.yy * vector[1]]
    }

    /// A symmetric matrix of the arm's kinematics plus a diagonal one.
    #[inline]
    pub fn plus_diagonal(self, diagonal: [f64; 2]) -> Self {
        Self { xx: self.xx + diagonal[0], yy: self.yy + diagonal[1], ..self }
    }

    /// A diagonal matrix of the arm's kinematics.
    #[inline]
    pub fn diagonal(&self) -> [f64; 2] {
        [self.xx, self.yy]
    }

    /// Solves matrix · x = `right` in the plane of the arm; the matrix is positive definite.
    #[inline]
    pub fn solve(&self, right: [f64; 2]) -> [f64; 2] {
        let scale = 1.0 / (self.xx * self.yy - self.xy * self.xy);
        [scale * (self.yy * right[0] - self.xy * right[1]), scale * (self.xx * right[1] - self.xy * right[0])]
    }

    /// The rows of a symmetric matrix of the arm's kinematics.
    pub fn rows(&self) -> [[f64; 2]; 2] {
        [[self.xx, self.xy], [self.xy, self.yy]]
    }
}
