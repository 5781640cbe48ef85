//! The loop: one thread that ticks a site at absolute times.

mod pace;
mod privileges;

pub use pace::{Lateness, Pace};
pub use privileges::{Privileges, claim};

use std::sync::atomic::{AtomicBool, Ordering};

use telespring::session::Span;

use crate::clock::{Clock, MonotonicClock};
use crate::device::Device;
use crate::feed::Item;
use crate::site::{Phase, Site};
use crate::transport::Transport;

/// How long an ended session goes on saying goodbye.
const LINGER: Span = Span(50_000_000);

/// When a loop ends by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Limits {
    /// After this time from the start; `None` for no limit.
    pub duration: Option<Span>,
}

/// Ticks a site at the times of `pace` until its session has ended; `stop` asks it to. `watch` sees every event and every
/// tick. It allocates nothing if `watch` does not.
pub fn run<D: Device, T: Transport>(
    site: &mut Site<D, T>,
    pace: &mut Pace,
    limits: Limits,
    stop: &AtomicBool,
    mut watch: impl FnMut(Item),
) {
    let clock = MonotonicClock;
    let start = clock.now();
    pace.begin(start);
    let mut ended = None;
    loop {
        clock.sleep_until(pace.due());
        let now = clock.now();
        let lateness = pace.wake(now);
        let is_over = limits.duration.is_some_and(|duration| now - start >= duration);
        let moment = site.tick(&clock, is_over || stop.load(Ordering::Relaxed));
        for (time, happened) in site.log().news() {
            watch(Item::Event { time: *time, happened: *happened });
        }
        watch(Item::Tick { moment, lateness });
        if moment.phase == Phase::Ended && now - *ended.get_or_insert(now) >= LINGER {
            return;
        }
        pace.rest(clock.now());
    }
}
