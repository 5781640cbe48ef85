//! The clock of one side, and sleeping until a point of time.

use rustix::thread::clock_nanosleep_absolute;
use rustix::time::{ClockId, Timespec, clock_gettime};
use telespring::session::{LocalTime, Span};

/// A clock that never goes backwards.
pub trait Clock {
    /// The time now.
    fn now(&self) -> LocalTime;

    /// How long the machine has been suspended so far, at least: this clock stands still meanwhile.
    fn suspended(&self) -> Span {
        Span(0)
    }
}

/// The monotonic clock of the machine: setting the date does not move it. All processes of a machine share it.
#[derive(Debug, Clone, Copy, Default)]
pub struct MonotonicClock;

impl Clock for MonotonicClock {
    fn now(&self) -> LocalTime {
        read(ClockId::Monotonic)
    }

    fn suspended(&self) -> Span {
        // in this order: what passes between the two makes it less, never more
        read(ClockId::Boottime) - self.now()
    }
}

fn read(clock: ClockId) -> LocalTime {
    let Timespec { tv_sec, tv_nsec } = clock_gettime(clock);
    LocalTime(tv_sec.unsigned_abs() * 1_000_000_000 + tv_nsec.unsigned_abs())
}

impl MonotonicClock {
    /// Sleeps until a point of time of this clock; returns at once if it has passed. A signal does not end the sleep.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::session::Span;
    /// use telespring_link::clock::{Clock, MonotonicClock};
    ///
    /// let clock = MonotonicClock;
    /// let due = clock.now() + Span(2_000_000);
    /// clock.sleep_until(due);
    /// assert!(clock.now() >= due);
    /// ```
    pub fn sleep_until(&self, due: LocalTime) {
        let request = Timespec {
            tv_sec: i64::try_from(due.0 / 1_000_000_000).unwrap_or(i64::MAX),
            tv_nsec: (due.0 % 1_000_000_000).cast_signed(),
        };
        while self.now() < due {
            if clock_nanosleep_absolute(ClockId::Monotonic, &request).is_ok() {
                break;
            }
        }
    }
}
