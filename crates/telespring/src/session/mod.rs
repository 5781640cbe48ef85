//! The control law of one side without input or output: bytes and the time go in; force and bytes come out.
//!
//! [`Endpoint`] is one side. It is told the time, never reads a clock, and does not know what carries its
//! bytes: the virtual laboratory drives two of them through an emulated network, a live program one of
//! them through a real one, and both run the same lines.
//!
//! | part | job |
//! |---|---|
//! | [`wire`] | a packet as bytes, and what is refused |
//! | [`playout`] | the partner's motion, a fixed time after it was measured |
//! | [`law`] | force from both motions |
//! | [`endpoint`] | the three together |
//!
//! All times are whole nanoseconds of one clock that both sides share ([`Nanoseconds`]).

pub mod endpoint;
pub mod law;
pub mod playout;
mod time;
pub mod wire;

pub use endpoint::Endpoint;
pub use law::Law;
pub use playout::Playout;
pub use time::Nanoseconds;
pub use wire::{Motion, Packet, PacketError};
