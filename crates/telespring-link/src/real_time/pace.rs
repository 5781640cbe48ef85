//! When the loop is due, how late it was, and what it missed.

use telespring::session::playout::Histogram;
use telespring::session::{LocalTime, Span};

/// How late a loop was.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Lateness {
    /// Ticks.
    pub ticks: u64,
    /// Half of the ticks began no later than this after they were due, at most a 32nd and 1 µs more than exact; 0 without a
    /// tick.
    pub median: Span,
    /// 99 of 100.
    pub quantile_99: Span,
    /// 999 of 1000.
    pub quantile_999: Span,
    /// The latest.
    pub largest: Span,
    /// Ticks that were due while an earlier one had not begun or ended, and were left out.
    pub overruns: u64,
    /// Ticks that a measurement of the device began.
    pub followed: u64,
}

/// The times at which a loop is due: whole periods after its start. A tick that cannot begin before the next one is due is
/// left out and counted, so that a standstill is not followed by a burst.
///
/// # Examples
///
/// ```
/// use telespring::session::{LocalTime, Span};
/// use telespring_link::real_time::Pace;
///
/// let mut pace = Pace::new(Span(1_000_000));
/// pace.begin(LocalTime(0));
/// pace.wake(LocalTime(20_000)); // 20 µs late
/// pace.rest(LocalTime(3_400_000), false); // the tick took 3.4 ms
/// assert_eq!(pace.due(), LocalTime(4_000_000));
/// assert_eq!(pace.lateness().overruns, 3); // those due after 1, 2 and 3 ms
/// ```
#[derive(Debug, Clone)]
pub struct Pace {
    period: Span,
    due: LocalTime,
    /// When the latest tick began.
    woke: Option<LocalTime>,
    histogram: Histogram,
    largest: Span,
    overruns: u64,
    followed: u64,
}

impl Pace {
    /// The pace of a loop with this period, at least 1 ns. It allocates all that it ever needs.
    pub fn new(period: Span) -> Self {
        let period = period.max(Span(1));
        Self {
            period,
            due: LocalTime(0),
            woke: None,
            histogram: Histogram::new(),
            largest: Span(0),
            overruns: 0,
            followed: 0,
        }
    }

    /// The loop starts, and is due at once.
    pub fn begin(&mut self, start: LocalTime) {
        self.due = start;
    }

    /// When the loop is due next.
    pub fn due(&self) -> LocalTime {
        self.due
    }

    /// The earliest time for a tick at the device's pace: half a period after the one before, so that a device that sends
    /// too much does not drive the loop.
    pub fn earliest(&self) -> LocalTime {
        self.woke.map_or(self.due, |woke| (woke + Span(self.period.0 / 2)).min(self.due))
    }

    /// The loop woke up because it was due; returns how late.
    pub fn wake(&mut self, now: LocalTime) -> Span {
        self.note(now, now - self.due)
    }

    /// The loop woke up because its device has measured; returns how much later than a period after the tick before.
    pub fn wake_early(&mut self, now: LocalTime) -> Span {
        self.followed += 1;
        let since = self.woke.map_or(Span(0), |woke| now - woke - self.period);
        self.note(now, since)
    }

    fn note(&mut self, now: LocalTime, late: Span) -> Span {
        let late = late.max(Span(0));
        self.woke = Some(now);
        self.histogram.add(late);
        self.largest = self.largest.max(late);
        late
    }

    /// The tick is done: the next one is due at the first whole period that has not passed. After a measurement of the device
    /// the next one has half a period more, and the clock steps in if it fails to come.
    pub fn rest(&mut self, now: LocalTime, follows: bool) {
        self.due = match self.woke {
            Some(woke) if follows => woke + self.period + Span(self.period.0 / 2),
            _ => self.due + self.period,
        };
        let behind = (now - self.due).0;
        if behind > 0 {
            let missed = (behind + self.period.0 - 1) / self.period.0;
            self.overruns = self.overruns.saturating_add(missed.unsigned_abs());
            self.due = self.due + Span(missed.saturating_mul(self.period.0));
        }
    }

    /// Ticks left out so far.
    pub fn overruns(&self) -> u64 {
        self.overruns
    }

    /// How late the loop was so far.
    pub fn lateness(&self) -> Lateness {
        let quantile = |share| self.histogram.quantile(share).unwrap_or_default().min(self.largest);
        Lateness {
            ticks: self.histogram.len(),
            median: quantile(0.5),
            quantile_99: quantile(0.99),
            quantile_999: quantile(0.999),
            largest: self.largest,
            overruns: self.overruns,
            followed: self.followed,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_a_device_sets_the_pace_and_the_clock_steps_in_when_it_fails() {
        let millisecond = |number: f64| LocalTime((number * 1e6) as u64);
        let mut pace = Pace::new(Span(1_000_000));
        pace.begin(millisecond(0.0));
        pace.wake(millisecond(0.0));
        pace.rest(millisecond(0.1), false);
        // the first measurement comes early, and the next tick waits for the one after it
        pace.wake_early(millisecond(0.7));
        pace.rest(millisecond(0.8), true);
        assert_eq!([pace.earliest(), pace.due()], [1.2, 2.2].map(millisecond));
        // a device that is slow by 20 % keeps the pace
        assert_eq!(pace.wake_early(millisecond(1.9)), Span(200_000));
        pace.rest(millisecond(2.0), true);
        assert_eq!(pace.due(), millisecond(3.4));
        // nothing comes: the clock goes on at its period
        assert_eq!(pace.wake(millisecond(3.5)), Span(100_000));
        pace.rest(millisecond(3.6), false);
        assert_eq!(pace.due(), millisecond(4.4));
        assert_eq!(pace.lateness().overruns, 0);
        // a standstill of the whole loop counts what it missed
        pace.wake_early(millisecond(4.0));
        pace.rest(millisecond(8.0), true);
        assert_eq!(pace.lateness().overruns, 3);
        assert!(pace.due() >= millisecond(8.0));
    }

    #[test]
    fn law_due_times_are_whole_periods_after_the_start_and_none_is_lost_uncounted() {
        let period = Span(1_000_000);
        let mut pace = Pace::new(period);
        pace.begin(LocalTime(7));
        let mut now = LocalTime(7);
        let mut random = 1_u64;
        for tick in 0..10_000_u64 {
            assert!(pace.due() >= now, "{tick}");
            assert_eq!((pace.due().0 - 7) % 1_000_000, 0);
            assert_eq!((pace.due().0 - 7) / 1_000_000, tick + pace.lateness().overruns);
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let late = Span((random >> 44).cast_signed() * 4);
            now = pace.due() + late;
            pace.wake(now);
            pace.rest(now, false);
        }
        let lateness = pace.lateness();
        assert!(lateness.overruns > 10_000 && lateness.largest > Span(4_000_000), "{lateness:?}");
        // uniform up to 4.194 ms
        assert!((lateness.median.seconds() - 2.097e-3).abs() < 1.5e-4, "{lateness:?}");
    }
}
