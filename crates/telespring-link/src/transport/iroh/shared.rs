//! What the thread of the network tells the loop, without a lock.

use std::sync::atomic::{AtomicBool, AtomicU8, AtomicU64, Ordering::Relaxed};
use std::time::Duration;

use telespring::session::Span;

use crate::transport::{PathEvent, TransportReport};

/// The way that datagrams take.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Way {
    /// None yet, or none any more.
    #[default]
    None,
    /// From address to address.
    Direct,
    /// Over the relay, and this site allows it.
    Relayed,
    /// There is one over the relay only, and this site does not allow it: nothing is sent or taken.
    Withheld,
}

/// Counts and states, written by the thread of the network and read by the loop.
#[derive(Debug, Default)]
pub(super) struct Shared {
    /// The site is to end.
    pub(super) stop: AtomicBool,
    /// Datagrams handed to the network.
    pub(super) sent: AtomicU64,
    /// Datagrams for which there was no way.
    pub(super) unsent: AtomicU64,
    /// Datagrams that came.
    pub(super) received: AtomicU64,
    /// Datagrams that came and were dropped for newer ones before the loop looked.
    pub(super) overflowed: AtomicU64,
    /// Packets that got lost on the way to the partner.
    pub(super) lost: AtomicU64,
    /// The partner has refused this site's key.
    pub(super) is_unknown: AtomicBool,
    /// Connections with the partner.
    pub(super) connections: AtomicU64,
    /// Connections of others, or more than one site answers.
    pub(super) refused: AtomicU64,
    /// The round trip, ns; 0 for unknown.
    round_trip: AtomicU64,
    /// Of how many packets one is sent.
    every: AtomicU8,
    /// The way, and above it how often it has changed.
    way: AtomicU64,
}

/// Adds to a count.
pub(super) fn count(counter: &AtomicU64, number: u64) {
    counter.fetch_add(number, Relaxed);
}

impl Shared {
    pub(super) fn set_round_trip(&self, round_trip: Option<Duration>) {
        let nanoseconds = round_trip.map_or(0, |time| u64::try_from(time.as_nanos()).unwrap_or(u64::MAX));
        self.round_trip.store(nanoseconds, Relaxed);
    }

    pub(super) fn set_every(&self, every: u8) {
        self.every.store(every, Relaxed);
    }

    /// Of how many packets one is sent; at least 1.
    pub(super) fn every(&self) -> u8 {
        self.every.load(Relaxed).max(1)
    }

    /// Says which way the datagrams take from now on; also if it is of the same kind as before.
    pub(super) fn set_way(&self, way: Way) {
        let changes = self.way.load(Relaxed) >> 2;
        let kind = match way {
            Way::None => 0,
            Way::Direct => 1,
            Way::Relayed => 2,
            Way::Withheld => 3,
        };
        self.way.store((changes + 1) << 2 | kind, Relaxed);
    }

    fn way(&self) -> (u64, Way) {
        let way = self.way.load(Relaxed);
        let kind = match way & 3 {
            0 => Way::None,
            1 => Way::Direct,
            2 => Way::Relayed,
            _ => Way::Withheld,
        };
        (way >> 2, kind)
    }

    pub(super) fn report(&self, thinned: u64) -> TransportReport {
        let round_trip = self.round_trip.load(Relaxed);
        TransportReport {
            sent: self.sent.load(Relaxed),
            unsent: self.unsent.load(Relaxed),
            received: self.received.load(Relaxed),
            overflowed: self.overflowed.load(Relaxed),
            round_trip: (round_trip > 0).then(|| Span(i64::try_from(round_trip).unwrap_or(i64::MAX))),
            lost: self.lost.load(Relaxed),
            every: self.every(),
            thinned,
            connections: self.connections.load(Relaxed),
            strangers: self.refused.load(Relaxed),
            ..TransportReport::default()
        }
    }
}

/// What the loop has been told of the way and the rate.
#[derive(Debug, Default)]
pub(super) struct Told {
    changes: u64,
    way: Way,
    /// 0 before the first look.
    every: u8,
    /// That the partner does not know this site's key is said once.
    is_unknown: bool,
}

impl Told {
    /// What is new, one thing at a time.
    pub(super) fn news(&mut self, shared: &Shared) -> Option<PathEvent> {
        let (changes, way) = shared.way();
        if changes != self.changes {
            self.changes = changes;
            let before = std::mem::replace(&mut self.way, way);
            return match (before, way) {
                (Way::None, Way::None) => None,
                (_, Way::None) => Some(PathEvent::Lost),
                (before, way) if before == way => Some(PathEvent::Changed),
                (_, Way::Direct) => Some(PathEvent::Direct),
                (_, Way::Relayed) => Some(PathEvent::Relayed),
                (_, Way::Withheld) => Some(PathEvent::Withheld),
            };
        }
        if !self.is_unknown && shared.is_unknown.load(Relaxed) {
            self.is_unknown = true;
            return Some(PathEvent::Refused);
        }
        let every = shared.every();
        let before = std::mem::replace(&mut self.every, every);
        (before.max(1) != every).then_some(PathEvent::Rate { every })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_each_change_is_told_once() {
        let (shared, mut told) = (Shared::default(), Told::default());
        assert_eq!(told.news(&shared), None);
        for (way, expected) in [
            (Way::None, None),
            (Way::Withheld, Some(PathEvent::Withheld)),
            (Way::Direct, Some(PathEvent::Direct)),
            (Way::Direct, Some(PathEvent::Changed)),
            (Way::Relayed, Some(PathEvent::Relayed)),
            (Way::None, Some(PathEvent::Lost)),
            (Way::None, None),
            (Way::Direct, Some(PathEvent::Direct)),
        ] {
            shared.set_way(way);
            assert_eq!(told.news(&shared), expected);
            assert_eq!(told.news(&shared), None);
        }
        for _ in 0..3 {
            shared.is_unknown.store(true, Relaxed);
        }
        assert_eq!([told.news(&shared), told.news(&shared)], [Some(PathEvent::Refused), None]);
        for every in [2, 4, 1] {
            shared.set_every(every);
            assert_eq!(told.news(&shared), Some(PathEvent::Rate { every }));
            assert_eq!(told.news(&shared), None);
        }
    }
}
