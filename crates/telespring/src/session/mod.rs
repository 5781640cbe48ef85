//! The control law of one side without input or output: packets and the time in, forces and packets out.
//!
//! [`Endpoint`] is one side. It receives the time, never reads a clock, and does not depend on the
//! transport of its packets. The virtual laboratory drives two endpoints through an emulated network, a
//! live program one of them through a real network, with the same code.
//!
//! | part | job |
//! |---|---|
//! | [`wire`] | packets as bytes, and their errors |
//! | [`motion`] | position and velocity of a handle |
//! | [`playout`] | the partner's motion, a fixed time after its measurement |
//! | [`predictor`] | from the partner's motion of some time ago to now |
//! | [`law`] | the force from both motions |
//! | [`strategy`] | the force of one side: the bare spring and what keeps it safe |
//! | [`account`] | the energy that one side may still give out |
//! | [`endpoint`] | one side: wire, playout and law together |
//!
//! All times are whole nanoseconds of a clock shared by both sides ([`Nanoseconds`]).

pub mod account;
pub mod endpoint;
pub mod law;
pub mod motion;
pub mod playout;
pub mod predictor;
pub mod strategy;
mod time;
pub mod wire;

pub use account::{AccountSettings, EnergyAccount};
pub use endpoint::Endpoint;
pub use law::Law;
pub use motion::Motion;
pub use playout::Playout;
pub use time::{LocalTime, Nanoseconds, PeerTime, Span};
pub use wire::{Packet, PacketError};
