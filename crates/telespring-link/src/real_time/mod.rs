//! The loop: one thread that ticks a site at absolute times, or whenever its device has measured anew.

mod pace;
mod privileges;
mod wait;

pub use pace::{Lateness, Pace};
pub use privileges::{Privileges, claim};

use std::sync::atomic::{AtomicBool, Ordering};

use telespring::session::Span;
use wait::{Woken, wait};

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

/// Waits until the next tick is due, or the device has measured anew if the loop `follows` it. Orders, noise and errors of the
/// device's socket set no pace.
fn wait_for<D: Device, T: Transport>(site: &mut Site<D, T>, pace: &Pace, follows: bool) -> Woken {
    let clock = MonotonicClock;
    loop {
        let woken = wait(site.device_pace().filter(|_| follows), pace.earliest(), pace.due());
        if woken == Woken::Clock {
            return woken;
        }
        let now = clock.now();
        if site.listen(now) {
            return woken;
        }
        if now >= pace.due() {
            return Woken::Clock;
        }
    }
}

/// Ticks a site until its session has ended; `stop` asks it to. The device's measurements say when to tick if `follows` is
/// set and the device has a pace of its own; the clock does otherwise, and where a measurement fails to come. `watch` sees
/// every event and every tick. It allocates nothing if `watch` does not.
pub fn run<D: Device, T: Transport>(
    site: &mut Site<D, T>,
    pace: &mut Pace,
    limits: Limits,
    stop: &AtomicBool,
    follows: bool,
    mut watch: impl FnMut(Item),
) {
    let clock = MonotonicClock;
    let start = clock.now();
    pace.begin(start);
    let mut ended = None;
    loop {
        let woken = wait_for(site, pace, follows);
        let now = clock.now();
        let lateness = match woken {
            Woken::Clock => pace.wake(now),
            Woken::Device => pace.wake_early(now),
        };
        let is_over = limits.duration.is_some_and(|duration| now - start >= duration);
        if is_over {
            site.expire();
        }
        let moment = site.tick(&clock, stop.load(Ordering::Relaxed));
        for (time, happened) in site.log().news() {
            watch(Item::Event { time: *time, happened: *happened });
        }
        for arrival in site.arrivals() {
            watch(Item::Arrival(*arrival));
        }
        let duration = clock.now() - now;
        watch(Item::Tick { moment, lateness, duration, overruns: pace.overruns() });
        if moment.phase == Phase::Ended && now - *ended.get_or_insert(now) >= LINGER {
            return;
        }
        pace.rest(clock.now(), woken == Woken::Device);
    }
}
