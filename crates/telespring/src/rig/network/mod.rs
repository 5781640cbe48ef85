//! Networks: what one direction of a network does to packets.
//!
//! | part | job |
//! |---|---|
//! | [`Channel`] | one direction: packets in, packets out |
//! | [`NetworkModel`] | what one direction does, as plain values |
//! | [`emulator`] | the channel of a model, with seeded random numbers |
//! | [`adversary`] | channels that do the worst they can |
//! | [`missing`] | how many packets in a row it does not deliver |
//! | [`trace`] | recorded delays and losses: read, described, replayed, fitted to the models |
//!
//! # Examples
//!
//! One packet of a hundred is lost, in bursts of four on average, on the way to robot 2 only:
//!
//! ```
//! use telespring::rig::{GilbertElliott, Laboratory, NetworkModel};
//!
//! let burst = GilbertElliott { to_bad: 0.0025252525252525255, to_good: 0.25, loss_good: 0.0, loss_bad: 1.0 };
//! assert!((burst.loss() - 0.01).abs() < 1e-12);
//! assert!((burst.mean_burst_length() - 4.0).abs() < 1e-12);
//! let mut laboratory = Laboratory::paper();
//! laboratory.network.forward = NetworkModel { burst: Some(burst), ..NetworkModel::ideal() };
//! laboratory.check()?;
//! # Ok::<(), telespring::InvalidInput>(())
//! ```

pub mod adversary;
mod burst;
mod check;
pub mod emulator;
mod jitter;
pub mod missing;
mod model;
pub mod trace;

pub use adversary::Adversary;
pub use burst::GilbertElliott;
pub use jitter::JitterDistribution;
pub use model::{Blackout, Network, NetworkModel, PacketOrder, RateLimit};
pub use trace::{Trace, TraceRow};

use crate::session::wire::LENGTH;
use crate::session::{LocalTime, Motion};

/// The bytes of one packet on a network.
pub type Datagram = [u8; LENGTH];

/// One direction of a network.
pub trait Channel: std::fmt::Debug {
    /// Sends a packet into the network at time `now`; the times of successive calls do not decrease.
    fn send(&mut self, now: LocalTime, packet: Datagram);

    /// The next packet that the network has delivered by `now`; called until it returns `None`.
    fn deliver(&mut self, now: LocalTime) -> Option<Datagram>;

    /// Shows an adversary on the network the motion of the side that receives, before it is asked to deliver; a network
    /// does not look.
    fn observe(&mut self, receiver: Motion) {
        let _ = receiver;
    }
}
