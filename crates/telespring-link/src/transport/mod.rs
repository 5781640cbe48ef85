//! Transports: datagrams to and from the partner.
//!
//! A transport loses, repeats and reorders as it likes; the endpoint and the hello see to that. It never waits. Who the
//! partner is, the transport decides: [`Iroh`] knows the partner by its key; [`Udp`] believes the address, so it is for one
//! machine.

mod emulated;
mod iroh;
mod udp;

pub use self::iroh::{ALPN, Authority, Iroh, IrohSettings};
pub use emulated::Emulated;
pub use udp::Udp;

use telespring::session::wire::LENGTH;
use telespring::session::{LocalTime, Span};

/// Room for the longest datagram that is looked at; what is longer is cut, and refused by its length.
pub const ROOM: usize = 2 * LENGTH;

/// A change of the way that datagrams take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum PathEvent {
    /// The datagrams take another way of the same kind, perhaps with another delay.
    Changed,
    /// The datagrams go from address to address from now on.
    Direct,
    /// The datagrams go over a relay from now on: over TCP, where a loss delays all that is behind it.
    Relayed,
    /// There is a way over a relay only, which this site does not allow: nothing is sent or taken.
    Withheld,
    /// One packet of `every` is sent from now on, because of the loss that lasts, or because it is over.
    Rate {
        /// 1, 2 or 4.
        every: u8,
    },
    /// The partner does not know this site's key. Said once; the transport goes on asking.
    Refused,
    /// Somebody whose key this site does not know wanted to connect. Said once.
    Stranger,
    /// No way is left, or the partner is silent on it. The transport goes on looking for one.
    Lost,
}

impl PathEvent {
    /// The event in a word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Changed => "path-changed",
            Self::Direct => "path-direct",
            Self::Relayed => "path-relayed",
            Self::Withheld => "path-withheld",
            Self::Rate { .. } => "path-rate",
            Self::Refused => "path-refused",
            Self::Stranger => "path-stranger",
            Self::Lost => "path-lost",
        }
    }
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
    /// Datagrams that came, and made room for newer ones before the loop looked.
    pub overflowed: u64,
    /// Packets that were left out, because the network lost many: see `every`.
    pub thinned: u64,
    /// Of how many packets one is sent now; 0 for a transport that leaves out none.
    pub every: u8,
    /// Packets that got lost on the way to the partner, as far as the transport knows.
    pub lost: u64,
    /// The round trip of the path in use, as far as the transport knows.
    pub round_trip: Option<Span>,
    /// Connections with the partner, one after the other.
    pub connections: u64,
    /// Connections that were refused: unknown keys, and more than this site answers.
    pub strangers: u64,
}

/// Datagrams to and from one partner.
pub trait Transport {
    /// Whether it is the next packet's turn. Ask once per packet that could be sent: one that is left out has no sequence number,
    /// so that the partner does not take it for lost. Greetings need not ask.
    fn is_due(&mut self) -> bool {
        true
    }

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
    fn is_due(&mut self) -> bool {
        (**self).is_due()
    }

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
