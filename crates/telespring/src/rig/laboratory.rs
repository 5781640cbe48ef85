//! What stands in the laboratory, as plain values in SI units; axes are x and y. The study reader fills
//! it in and checks it.

/// A planar robot as its handle feels: the two axes are independent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Handle {
    /// Mass per axis, kg.
    pub mass: [f64; 2],
    /// Viscous damping per axis, N·s/m.
    pub damping: [f64; 2],
    /// Coulomb friction per axis, N: the largest force at which the axis still sticks, and the force
    /// against its motion.
    pub coulomb: [f64; 2],
}

/// What carries the agent's hand to the handle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Arm {
    /// A mass and a damping that are the same in every pose; both zero is the ideal massless arm, which
    /// passes the agent's force on unchanged.
    Lumped {
        /// Mass per axis, kg.
        mass: [f64; 2],
        /// Viscous damping per axis, N·s/m.
        damping: [f64; 2],
    },
    /// Two links in the plane of the handle.
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

/// A planar arm of two links, its handle pinned to the robot's by a free bearing.
///
/// The shoulder angle is counted from the x axis, the elbow angle from the first link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TwoLinkArm {
    /// Shoulder, m, in the coordinates of the task.
    pub base: [f64; 2],
    /// To which side the elbow bends.
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
    /// Largest torque of each actuator, N·m; infinite where there is no limit.
    pub torque_limit: [f64; 2],
}

/// The cloud of spots that a less-skilled agent follows (Appendix C).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spots {
    /// How many spots.
    pub count: usize,
    /// Standard deviation of a spot's velocity relative to the target, per axis, m/s.
    pub velocity: f64,
    /// From a spot's birth on the target to its renewal, s.
    pub lifetime: f64,
}

/// Who moves an arm.
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
    /// A spring to each of the spots, together as stiff as `stiffness` (Eq. 14).
    Blurred {
        /// N/m.
        stiffness: f64,
        /// The cloud.
        spots: Spots,
    },
    /// A program of the caller's gives the force.
    External,
}

/// What the agents follow.
#[derive(Debug, Clone, PartialEq)]
pub enum Target {
    /// p*(t) = (A sin 2ωt, B sin ωt), Eq. 12.
    FigureEight {
        /// A and B, m.
        amplitude: [f64; 2],
        /// ω, rad/s.
        angular_frequency: f64,
    },
    /// Positions that the caller gives at every tick of the controllers, m; linear in between.
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
    /// Period over which every force is held, s.
    pub sample_period: f64,
    /// True where a force acts one period after the sample it was computed from.
    pub computing_tick: bool,
    /// Time constant of the robots' actuators, s; 0 is none.
    pub actuator_lag: f64,
    /// Step to which measured positions are rounded, m; 0 is none. Velocities are measured without a step.
    pub encoder_resolution: f64,
}

/// What the emulated network does beside the constant delay of a condition.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NetworkImpairments {
    /// Each packet is later by a time uniform between 0 and this, s.
    pub jitter: f64,
    /// Probability that a packet is lost. A sample that is lost is interpolated over where its successor
    /// has come by its turn; else the newest that has come is held.
    pub loss: f64,
}

/// The whole laboratory: what does not change from condition to condition.
#[derive(Debug, Clone, PartialEq)]
pub struct Laboratory {
    /// Both sides.
    pub stations: [Station; 2],
    /// What both agents follow.
    pub target: Target,
    /// Both controllers.
    pub controller: Controller,
    /// The network.
    pub network: NetworkImpairments,
}

/// Which trials are run.
#[derive(Debug, Clone, PartialEq)]
pub struct Protocol {
    /// Conditions in order: stiffness in N/m, `None` in the unconnected mode, and the one-way delay, s.
    pub conditions: Vec<(Option<f64>, f64)>,
    /// Trials of each condition.
    pub trials: usize,
    /// Length of a trial, s.
    pub duration: f64,
    /// First part of a trial that the analysis leaves out, s.
    pub discard: f64,
    /// Samples kept per second, Hz; divides the controllers' rate.
    pub record_rate: f64,
    /// From which every trial's own seed is drawn.
    pub seed: u64,
    /// True where the trials of all conditions are run in an order drawn from the seed, false block by block.
    pub shuffled: bool,
}
