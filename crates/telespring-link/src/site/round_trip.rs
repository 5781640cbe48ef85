//! The round trip by the greetings: what is known of the network before any packet.

use telespring::session::{LocalTime, Span};

use crate::hello::Stamps;

/// Round trips that are kept.
const KEPT: usize = 16;
/// Fewer say nothing.
const ENOUGH: usize = 8;

/// The latest round trips.
#[derive(Debug, Clone, Default)]
pub(super) struct RoundTrips {
    latest: [Option<Span>; KEPT],
    next: usize,
    /// The newest stamp of the partner, and when it came.
    heard: Option<(u64, LocalTime)>,
}

impl RoundTrips {
    /// Takes the stamps of a greeting that came at `now`, later than all before.
    pub(super) fn take(&mut self, now: LocalTime, stamps: &Stamps) {
        let Stamps { sent, echo, held } = *stamps;
        self.heard = Some((sent, now));
        let took = now.0.checked_sub(echo).and_then(|took| took.checked_sub(held));
        if let Some(took) = took.filter(|_| echo > 0).and_then(|took| i64::try_from(took).ok()) {
            if let Some(place) = self.latest.get_mut(self.next) {
                *place = Some(Span(took));
            }
            self.next = (self.next + 1) % KEPT;
        }
    }

    /// The stamps of a greeting that is sent at `now`.
    pub(super) fn stamps(&self, now: LocalTime) -> Stamps {
        let (echo, held) =
            self.heard.map_or((0, 0), |(sent, then)| (sent, (now - then).0.max(0).unsigned_abs()));
        Stamps { sent: now.0, echo, held }
    }

    /// The latest round trip.
    pub(super) fn latest(&self) -> Option<Span> {
        self.latest.get((self.next + KEPT - 1) % KEPT).copied().flatten()
    }

    /// When the partner was heard last.
    pub(super) fn heard(&self) -> Option<LocalTime> {
        self.heard.map(|(_, heard)| heard)
    }

    /// The median of the latest round trips, if there are enough of them.
    pub(super) fn median(&self) -> Option<Span> {
        let count = self.latest.iter().flatten().count();
        if count < ENOUGH {
            return None;
        }
        let mut sorted = self.latest.map(|span| span.map_or(i64::MAX, |span| span.0));
        sorted.sort_unstable();
        sorted.get(count / 2).copied().map(Span)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_the_median_takes_half_and_hostile_stamps_change_nothing() {
        let mut trips = RoundTrips::default();
        assert_eq!(trips.stamps(LocalTime(5)), Stamps { sent: 5, echo: 0, held: 0 });
        for trip in 1..=9_u64 {
            assert_eq!(trips.median().is_some(), trip > 8);
            let now = LocalTime(trip * 1000);
            trips.take(now, &Stamps { sent: trip, echo: now.0 - 100 - trip, held: 100 });
        }
        assert_eq!([trips.median(), trips.latest()], [5, 9].map(|trip| Some(Span(trip))));
        assert_eq!(trips.heard(), Some(LocalTime(9000)));
        for (echo, held) in [(0, 0), (9_001, 0), (8_000, 1_001), (u64::MAX >> 1, 1), (1, u64::MAX >> 1)] {
            trips.take(LocalTime(9_000), &Stamps { sent: 10, echo, held });
        }
        assert_eq!(trips.median(), Some(Span(5)));
        assert_eq!(trips.stamps(LocalTime(9_500)), Stamps { sent: 9_500, echo: 10, held: 500 });
    }
}
