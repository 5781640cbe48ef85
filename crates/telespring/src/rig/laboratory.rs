//! The parts of the virtual laboratory as plain values in SI units; the axes are x and y. The study reader
//! fills them in and checks them.

use super::Network;
use crate::session::Architecture;

/// A planar robot at its handle, with two independent axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Handle {
    /// Mass per axis, kg.
    pub mass: [f64; 2],
    /// Viscous damping per axis, N·s/m.
    pub damping: [f64; 2],
    /// Coulomb friction per axis, N: the largest force at which the axis still sticks, and the friction
    /// force in motion.
    pub coulomb: [f64; 2],
}

/// The arm between the agent and the handle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Arm {
    /// Constant mass and damping in every pose; both zero is the ideal massless arm, which transmits the
    /// agent's force unchanged.
    Lumped {
        /// Mass per axis, kg.
        mass: [f64; 2],
        /// Viscous damping per axis, N·s/m.
        damping: [f64; 2],
    },
    /// A planar two-link arm.
    TwoLink(TwoLinkArm),
}

/// The side to which the elbow bends, seen from the shoulder towards the handle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Elbow {
    /// Elbow angle from 0 to −π.
    Left,
    /// Elbow angle from 0 to π.
    Right,
}

/// A planar two-link arm, attached to the handle by a free bearing.
///
/// The shoulder angle is measured from the x axis, the elbow angle from the first link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TwoLinkArm {
    /// Position of the shoulder, m, in task coordinates.
    pub base: [f64; 2],
    /// The side to which the elbow bends.
    pub elbow: Elbow,
    /// Lengths of upper and lower link, m.
    pub link_length: [f64; 2],
    /// Masses of the links, kg.
    pub link_mass: [f64; 2],
    /// Distance of each link's centre of mass from its joint, m.
    pub link_centre: [f64; 2],
    /// Moment of inertia of each link about its centre of mass, kg·m².
    pub link_inertia: [f64; 2],
    /// Viscous damping of each joint, N·m·s/rad.
    pub joint_damping: [f64; 2],
    /// Inertia of each actuator, reflected to its joint, kg·m².
    pub rotor_inertia: [f64; 2],
    /// Torque limit of each actuator, N·m; infinite if there is none.
    pub torque_limit: [f64; 2],
}

/// The cloud of spots that a less-skilled agent follows (Appendix C).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spots {
    /// The number of spots.
    pub count: usize,
    /// Standard deviation of a spot's velocity relative to the target, per axis, m/s.
    pub velocity: f64,
    /// The lifetime of a spot from its start on the target, s.
    pub lifetime: f64,
}

/// The agent that moves an arm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Agent {
    /// A spring and a damper to the target: F = stiffness (p* − p) + damping (v* − v). Eq. 13 has no
    /// damper.
    Skilled {
        /// N/m.
        stiffness: f64,
        /// N·s/m.
        damping: f64,
    },
    /// A spring to each of the spots with total stiffness `stiffness` (Eq. 14).
    Blurred {
        /// N/m.
        stiffness: f64,
        /// The cloud.
        spots: Spots,
    },
    /// The caller's program computes the force.
    External,
}

/// The target that the agents follow.
#[derive(Debug, Clone, PartialEq)]
pub enum Target {
    /// p*(t) = (A sin 2ωt, B sin ωt), Eq. 12.
    FigureEight {
        /// A and B, m.
        amplitude: [f64; 2],
        /// ω, rad/s.
        angular_frequency: f64,
    },
    /// Positions given by the caller at every tick of the controllers, m; linear in between.
    Sampled(Vec<[f64; 2]>),
}

/// One robot with its arm and agent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Station {
    /// The robot.
    pub handle: Handle,
    /// The arm.
    pub arm: Arm,
    /// The agent.
    pub agent: Agent,
}

/// Timing and imperfections of both controllers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Controller {
    /// The sample period, over which every force is held, s.
    pub sample_period: f64,
    /// True if a force acts one period after the sample from which it was computed.
    pub computing_tick: bool,
    /// Time constant of the robots' actuators, s; 0 for none.
    pub actuator_lag: f64,
    /// Resolution of measured positions, m; 0 for none. Velocities are measured without quantisation.
    pub encoder_resolution: f64,
}

/// What both controllers do with the partner's motion, and what they may count on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SessionPlan {
    /// Strategy, predictor and play-out of both sides.
    pub architecture: Architecture,
    /// The damping that each robot has at least, per robot and axis, N·s/m.
    pub least_damping: [[f64; 2]; 2],
    /// The mass that each robot has at least, per robot and axis, kg.
    pub least_mass: [[f64; 2]; 2],
    /// The most by which a motion may be older than the delay of the condition, forward and backward, s: jitter and gap.
    pub lateness: [f64; 2],
    /// Whether a fixed play-out without a delay of its own waits that much longer, so that the age of a motion is constant.
    pub has_playout_buffer: bool,
}

impl SessionPlan {
    /// The bare spring for two robots whose masses and dampings are certain, over a network without jitter and gaps.
    pub fn spring(robots: [Handle; 2]) -> Self {
        Self {
            architecture: Architecture::default(),
            least_damping: robots.map(|robot| robot.damping),
            least_mass: robots.map(|robot| robot.mass),
            lateness: [0.0; 2],
            has_playout_buffer: false,
        }
    }
}

/// The virtual laboratory: everything that is the same in all conditions.
#[derive(Debug, Clone, PartialEq)]
pub struct Laboratory {
    /// Both robots with their arms and agents.
    pub stations: [Station; 2],
    /// The target of both agents.
    pub target: Target,
    /// The controllers.
    pub controller: Controller,
    /// What the network does to packets, besides the constant delay of a condition.
    pub network: Network,
    /// What the controllers do in the connected mode.
    pub session: SessionPlan,
}

/// The protocol of an experiment: which trials are run.
#[derive(Debug, Clone, PartialEq)]
pub struct Protocol {
    /// The conditions in order: stiffness in N/m, `None` in the unconnected mode, and one-way delay in s.
    pub conditions: Vec<(Option<f64>, f64)>,
    /// The number of trials per condition.
    pub trials: usize,
    /// The duration of a trial, s.
    pub duration: f64,
    /// The first part of a trial that the analysis discards, s.
    pub discard: f64,
    /// Samples recorded per second, Hz; divides the controllers' rate.
    pub record_rate: f64,
    /// The seed from which the seeds of all trials are drawn.
    pub seed: u64,
    /// True if the trials of all conditions run in an order drawn from the seed; false for one block per
    /// condition.
    pub shuffled: bool,
}
