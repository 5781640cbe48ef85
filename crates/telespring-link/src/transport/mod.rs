//! Transports: datagrams to and from the partner.
//!
//! A transport loses, repeats and reorders as it likes; the endpoint and the hello see to that. It never waits. Who the
//! partner is, the transport decides: [`Udp`] believes the address, so it is for one machine, a wire or a virtual private
//! network.

mod emulated;
mod udp;

pub use emulated::Emulated;
pub use udp::Udp;

use telespring::session::LocalTime;
use telespring::session::wire::LENGTH;

/// Room for the longest datagram that is looked at; what is longer is cut, and refused by its length.
pub const ROOM: usize = 2 * LENGTH;

/// A change of the way that datagrams take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum PathEvent {
    /// The datagrams take another way, with another delay.
    Changed,
    /// No way is left.
    Lost,
}

/// What a transport has counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TransportReport {
    /// Datagrams handed to the network.
    pub sent: u64,
    /// Datagrams that the network did not take.
    pub unsent: u64,
    /// Datagrams that came.
    pub received: u64,
    /// Times that the network said that the partner is not there.
    pub unreachable: u64,
}

/// Datagrams to and from one partner.
pub trait Transport {
    /// Sends a datagram. What cannot go out at once is lost: a later one is worth more.
    fn send(&mut self, now: LocalTime, datagram: &[u8]);

    /// The next datagram that has come: its length, at most [`ROOM`]; `None` if there is none now.
    fn receive(&mut self, now: LocalTime, room: &mut [u8; ROOM]) -> Option<usize>;

    /// The oldest change of the way that nobody has asked for yet.
    fn poll_path(&mut self) -> Option<PathEvent> {
        None
    }

    /// What the transport has counted.
    fn report(&self) -> TransportReport;
}

impl<T: Transport + ?Sized> Transport for Box<T> {
    fn send(&mut self, now: LocalTime, datagram: &[u8]) {
        (**self).send(now, datagram);
    }

    fn receive(&mut self, now: LocalTime, room: &mut [u8; ROOM]) -> Option<usize> {
        (**self).receive(now, room)
    }

    fn poll_path(&mut self) -> Option<PathEvent> {
        (**self).poll_path()
    }

    fn report(&self) -> TransportReport {
        (**self).report()
    }
}
