//! What goes through the queues between the loop and the thread of the network.

use std::collections::VecDeque;

use rtrb::Producer;

use crate::transport::ROOM;

/// Datagrams that wait for the loop in the queue, and as many again in front of it.
pub(super) const INBOX: usize = 64;
/// Datagrams that wait for the thread of the network.
pub(super) const OUTBOX: usize = 32;

/// A datagram of fixed size, so that a queue holds it without an allocation.
#[derive(Debug, Clone, Copy)]
pub(super) struct Packet {
    length: u8,
    bytes: [u8; ROOM],
}

impl Packet {
    /// A datagram; one that is too long is cut, and refused by its length where it is read.
    pub(super) fn new(datagram: &[u8]) -> Self {
        let mut bytes = [0; ROOM];
        for (place, byte) in bytes.iter_mut().zip(datagram) {
            *place = *byte;
        }
        Self { length: u8::try_from(datagram.len().min(ROOM)).unwrap_or(u8::MAX), bytes }
    }

    pub(super) fn bytes(&self) -> &[u8] {
        self.bytes.get(..usize::from(self.length)).unwrap_or_default()
    }
}

/// What has come and waits for the loop: a queue that the loop empties, and in front of it the newest of what did not fit.
#[derive(Debug)]
pub(super) struct Inbox {
    queue: Producer<Packet>,
    waiting: VecDeque<Packet>,
}

impl Inbox {
    pub(super) fn new(queue: Producer<Packet>) -> Self {
        Self { queue, waiting: VecDeque::with_capacity(INBOX) }
    }

    /// Takes a datagram in. Returns whether an older one was dropped for it.
    pub(super) fn push(&mut self, datagram: &[u8]) -> bool {
        let is_full = self.waiting.len() >= INBOX;
        if is_full {
            self.waiting.pop_front();
        }
        self.waiting.push_back(Packet::new(datagram));
        self.flush();
        is_full
    }

    /// Hands the loop what has room.
    pub(super) fn flush(&mut self) {
        while let Some(packet) = self.waiting.front() {
            if self.queue.push(*packet).is_err() {
                return;
            }
            self.waiting.pop_front();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_a_loop_that_stands_still_finds_the_newest_and_no_more_than_fits() {
        let (queue, mut read) = rtrb::RingBuffer::new(INBOX);
        let mut inbox = Inbox::new(queue);
        let dropped = (0..1000_u32).filter(|number| inbox.push(&number.to_le_bytes())).count();
        assert_eq!(dropped, 1000 - 2 * INBOX);
        let mut got = Vec::new();
        for _ in 0..3 {
            while let Ok(packet) = read.pop() {
                got.push(u32::from_le_bytes(packet.bytes().try_into().unwrap()));
            }
            inbox.flush();
        }
        // in the order in which they came, and the last ones are there
        assert!(got.is_sorted(), "{got:?}");
        assert_eq!(got.len(), 2 * INBOX);
        assert_eq!(got[INBOX..], (936..1000).collect::<Vec<u32>>());
    }

    #[test]
    fn law_a_datagram_of_any_length_fits() {
        for length in [0, 1, 112, ROOM, ROOM + 1, 5000] {
            let packet = Packet::new(&vec![7; length]);
            assert_eq!(packet.bytes(), vec![7; length.min(ROOM)]);
        }
    }
}
