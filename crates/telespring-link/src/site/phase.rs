//! The state of a live session, and why it is left.

use crate::device::Fault;
use crate::hello::Disagreement;

/// The state of a live session: the table in `docs/connect.md`. A force acts in three of them ([`Phase::is_coupled`]).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// The two sides do not hear each other, or do not agree on the terms.
    Connecting,
    /// A robot is not homed, or its motors may not act.
    Homing,
    /// The handles are apart, or move.
    Aligning,
    /// A person has not consented yet.
    Consenting,
    /// Both have consented: the force begins, from zero.
    RampingIn,
    /// The force acts.
    Running,
    /// The force falls to zero, for a pause or the end.
    RampingOut,
    /// A side wants a pause: no force, both stay connected.
    Paused,
    /// An emergency stop has latched: no force until it is cleared.
    Stopped,
    /// The session is over.
    Ended,
}

impl Phase {
    /// All of them, in the order of their codes.
    pub const ALL: [Self; 10] = [
        Self::Connecting,
        Self::Homing,
        Self::Aligning,
        Self::Consenting,
        Self::RampingIn,
        Self::Running,
        Self::RampingOut,
        Self::Paused,
        Self::Stopped,
        Self::Ended,
    ];

    /// The state in a word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Connecting => "connecting",
            Self::Homing => "homing",
            Self::Aligning => "aligning",
            Self::Consenting => "consenting",
            Self::RampingIn => "ramping-in",
            Self::Running => "running",
            Self::RampingOut => "ramping-out",
            Self::Paused => "paused",
            Self::Stopped => "stopped",
            Self::Ended => "ended",
        }
    }

    /// The state as a code in a greeting or a row of numbers.
    pub fn code(self) -> u8 {
        Self::ALL.iter().zip(0..).find(|(one, _)| **one == self).map_or(0, |(_, code)| code)
    }

    /// Whether motions are sent and a force may act.
    pub fn is_coupled(self) -> bool {
        matches!(self, Self::RampingIn | Self::Running | Self::RampingOut)
    }
}

/// Why a session leaves or has ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Cause {
    /// Somebody wants to stop.
    StopRequested,
    /// The time for the session is over.
    TimeOver,
    /// The partner said goodbye.
    PartnerLeft,
    /// The partner's terms are others.
    Refused(Disagreement),
    /// The delay that the study imposes is shorter than that of the network.
    DelayRefused,
    /// The device cannot go on.
    Device(Fault),
}

impl Cause {
    /// The cause in a word.
    pub fn word(self) -> &'static str {
        match self {
            Self::StopRequested => "stop-requested",
            Self::TimeOver => "time-over",
            Self::PartnerLeft => "partner-left",
            Self::Refused(_) => "refused",
            Self::DelayRefused => "delay-refused",
            Self::Device(fault) => fault.word(),
        }
    }
}

/// Why a coupling was interrupted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Interruption {
    /// Somebody here ordered a pause.
    PauseOrdered,
    /// The person here does not agree any more.
    ConsentWithdrawn,
    /// The network was bad for too long.
    Network,
    /// The handle was faster than allowed.
    Velocity,
    /// The handle left its workspace.
    Workspace,
    /// The own emergency stop was pressed.
    EmergencyStop,
    /// The motors may not act any more, or the robot is not homed.
    DeviceNotReady,
    /// The device failed.
    Device(Fault),
    /// The machine was suspended: nobody knows what happened meanwhile.
    Suspended,
    /// The partner let go.
    Partner(Why),
    /// The partner's program started anew.
    PartnerChanged,
}

/// Why a partner let go, as far as it says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Why {
    /// It wants a pause.
    Paused,
    /// Its emergency stop has latched.
    Stopped,
    /// Its robot is silent, not homed, or its motors may not act.
    NotReady,
    /// Anything else: a consent taken back, for instance.
    LetGo,
}

impl Why {
    fn word(self) -> &'static str {
        match self {
            Self::Paused => "partner-paused",
            Self::Stopped => "partner-stopped",
            Self::NotReady => "partner-not-ready",
            Self::LetGo => "partner",
        }
    }
}

impl Interruption {
    /// The cause in a word.
    pub fn word(self) -> &'static str {
        match self {
            Self::PauseOrdered => "pause-ordered",
            Self::ConsentWithdrawn => "consent-withdrawn",
            Self::Network => "network",
            Self::Velocity => "velocity",
            Self::Workspace => "workspace",
            Self::EmergencyStop => "emergency-stop",
            Self::DeviceNotReady => "device-not-ready",
            Self::Device(fault) => fault.word(),
            Self::Suspended => "suspended",
            Self::Partner(why) => why.word(),
            Self::PartnerChanged => "partner-changed",
        }
    }

    /// Whether the force is zero at once; otherwise it falls along a ramp.
    pub(super) fn is_sudden(self) -> bool {
        matches!(
            self,
            Self::EmergencyStop
                | Self::DeviceNotReady
                | Self::Device(_)
                | Self::Suspended
                | Self::PartnerChanged
        )
    }

    /// Whether this side stays paused until somebody here says otherwise.
    pub(super) fn pauses(self) -> bool {
        matches!(self, Self::PauseOrdered | Self::Network | Self::Velocity | Self::Workspace)
    }
}
