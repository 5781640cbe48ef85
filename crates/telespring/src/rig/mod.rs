//! The virtual laboratory: two robots, two arms, their agents, a target and a network, in virtual time.
//!
//! | part | job |
//! |---|---|
//! | [`Laboratory`] | the parts, as plain values |
//! | [`Trial`] | one run with a seed; repeatable bit for bit on one type of CPU |
//! | [`network`] | what a network does to packets; adversaries; recorded traces |
//! | [`plant`] | robots held by arms, moved by forces |
//! | [`replay`] | a recorded live session through endpoints of the same or other settings |
//! | [`RunningTrial`] | a trial under way, moved tick by tick by the caller |
//! | [`SimulatedRobot`] | one robot with its arm and agent, moved step by step by the caller |
//! | [`trial_seed`] | the seed of each trial of a rehearsal |
//!
//! # Examples
//!
//! The paper's two robots at 71.2 N/m and a delay of 84 ms for one second:
//!
//! ```
//! use telespring::rig::{ConnectedMode, Laboratory, Recording, Schedule, Status, Trial};
//! use telespring::{Delay, InvalidInput};
//!
//! let laboratory = Laboratory::paper();
//! let coupling = ConnectedMode { stiffness: 71.2, damping: 0.0, delay: Delay::each_way(0.084)? };
//! let schedule = Schedule::new(1.0, 100.0, laboratory.controller.sample_period)?;
//! let trial = Trial { laboratory: &laboratory, coupling: Some(coupling), seed: 1, schedule };
//! let recording: Recording = trial.record::<InvalidInput>([None, None])?;
//! assert_eq!(recording.outcome.status, Status::Completed);
//! assert_eq!(recording.position.len(), 101);
//! # Ok::<(), telespring::InvalidInput>(())
//! ```

mod actuated;
mod agent;
mod check;
mod connected;
mod energy;
mod held_coupling;
mod laboratory;
pub mod network;
pub mod plant;
mod random;
mod record;
pub mod replay;
mod robot;
mod running;
mod schedule;
mod station;
mod target;
mod trial;

pub use agent::Observation;
pub use connected::ConnectedMode;
pub use energy::CouplingEnergy;
pub use held_coupling::HeldCoupling;
pub use laboratory::{
    Agent, Arm, Controller, Elbow, Handle, Laboratory, Protocol, SessionPlan, Spots, Station, Target,
    TwoLinkArm,
};
pub use network::{
    Adversary, Blackout, Channel, Datagram, GilbertElliott, JitterDistribution, Network, NetworkModel,
    PacketOrder, RateLimit, Trace, TraceRow, trace,
};
pub use plant::{Halt, OutOfReach};
pub use random::trial_seed;
pub use record::{Record, Recording, Row, Status, TrialOutcome};
pub use robot::SimulatedRobot;
pub use running::RunningTrial;
pub use schedule::{MAX_TICKS, Schedule};
pub use station::POSITION_LIMIT;
pub use target::figure_eight_positions;
pub use trial::{Callback, InterruptCheck, Trial};
