//! The control law of one side without input or output: packets and the time in, forces and packets out.
//!
//! [`Endpoint`] is one side. It receives the time, never reads a clock, and does not depend on the
//! transport of its packets. The virtual laboratory drives two endpoints through an emulated network, a
//! live program one of them through a real network, with the same code.
//!
//! | part | job |
//! |---|---|
//! | [`wire`] | packets as bytes, and their errors |
//! | [`time`](LocalTime) | points of time on the two clocks, which do not mix |
//! | [`clock`] | round trip, offset and drift of the partner's clock, with bounds |
//! | [`motion`] | position and velocity of a handle |
//! | [`playout`] | the partner's motion, a chosen time after its measurement |
//! | [`predictor`] | from the partner's motion of some time ago to now |
//! | [`law`] | the force from both motions |
//! | [`strategy`] | the force of one side: the bare spring and what keeps it safe |
//! | [`account`] | the energy that one side may still give out |
//! | [`watchdog`] | whether the force may act: hold, ramp out, begin again from zero |
//! | [`event`] | what happened, and why |
//! | [`endpoint`] | one side: all of it together |
//! | [`gate`] | what goes on to the device of the endpoint's force |
//! | [`architecture`] | strategy, predictor and play-out by name, as plain data |
//!
//! After its construction an endpoint allocates nothing, takes no lock, reads no clock and does not panic, whatever
//! comes in. It is written for the control loop of a robot.

#![cfg_attr(
    not(test),
    deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::unreachable, clippy::todo)
)]

pub mod account;
pub mod architecture;
pub mod clock;
pub mod endpoint;
pub mod event;
pub mod gate;
pub mod law;
pub mod motion;
mod pair;
pub mod playout;
pub mod predictor;
pub mod strategy;
mod target;
mod time;
pub mod watchdog;
pub mod wire;

pub use account::{AccountSettings, EnergyAccount, Overdraft};
pub use architecture::{Architecture, SideFacts};
pub use clock::{Clock, ClockSettings};
pub use endpoint::{DatagramError, Endpoint, EndpointSettings, SessionReport, SessionSnapshot};
pub use event::{Event, EventKind};
pub use law::Law;
pub use motion::Motion;
pub use playout::{AdaptiveDelay, Playout, PlayoutSettings};
pub use time::{LocalTime, PeerTime, Span};
pub use watchdog::{WatchdogSettings, WatchdogState};
pub use wire::{Packet, PacketError};
