//! A transport over an emulated path: the laboratory's network on top of a real one.

use telespring::rig::{Channel, NetworkModel};
use telespring::session::wire::LENGTH;
use telespring::session::{LocalTime, Span};

use super::{PathEvent, ROOM, Transport, TransportReport};

/// A transport whose datagrams take, after their arrival, the emulated path of the virtual laboratory. It needs no thread:
/// they wait at the receiver until they are due. For demonstrations and tests; the path allocates.
#[derive(Debug)]
pub struct Emulated<T> {
    inner: T,
    /// The path towards this side.
    path: Box<dyn Channel>,
}

impl<T: Transport> Emulated<T> {
    /// Puts what a network model does, and `travel` on top of the real delay, on the way to a side, counted from 0.
    pub fn new(inner: T, model: &NetworkModel, travel: Span, seed: u64, side: usize) -> Self {
        Self { inner, path: model.channel(travel, seed, side) }
    }
}

impl<T: Transport> Transport for Emulated<T> {
    fn is_due(&mut self) -> bool {
        self.inner.is_due()
    }

    fn send(&mut self, now: LocalTime, datagram: &[u8]) {
        self.inner.send(now, datagram);
    }

    fn receive(&mut self, now: LocalTime, room: &mut [u8; ROOM]) -> Option<usize> {
        // All datagrams of the program have one length; what has another is not the program's and gets lost.
        while let Some(length) = self.inner.receive(now, room) {
            if let Some(Ok(datagram)) = room.get(..length).map(<[u8; LENGTH]>::try_from) {
                self.path.send(now, datagram);
            }
        }
        let datagram = self.path.deliver(now)?;
        room[..LENGTH].copy_from_slice(&datagram);
        Some(LENGTH)
    }

    fn poll_path(&mut self) -> Option<PathEvent> {
        self.inner.poll_path()
    }

    fn report(&self) -> TransportReport {
        self.inner.report()
    }
}
