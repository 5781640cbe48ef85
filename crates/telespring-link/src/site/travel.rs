//! How fast a handle is: a device may report no velocity, or a false one, and a sensor may jump.

use telespring::session::{LocalTime, Motion, Span};

use super::locks::without;

/// Positions count as a speed over this time at the least: a tick that is early or late by a fraction of a period is no motion.
const WINDOW: Span = Span(10_000_000);
/// The speed of the positions may be so many times as high as that which the device reports.
const SLACK: f64 = 1.25;

/// How fast the positions of a handle change.
#[derive(Debug, Clone, Default)]
pub(super) struct Travel {
    from: Option<(LocalTime, [f64; 2])>,
    /// m/s; `None` before it is known.
    velocity: Option<[f64; 2]>,
}

impl Travel {
    /// Takes a motion measured at `now`.
    pub(super) fn take(&mut self, now: LocalTime, motion: &Motion) {
        if motion.impossible_value().is_some() {
            return;
        }
        let ([x, y], here) = (motion.position, (now, motion.position));
        match self.from {
            Some((then, [u, v])) if now - then >= WINDOW => {
                self.velocity = Some([x - u, y - v].map(|way| way / (now - then).seconds()));
                self.from = Some(here);
            }
            Some(_) => {}
            None => self.from = Some(here),
        }
    }

    /// The speed of a handle of which the device reports this velocity, m/s, without the axes that are locked: the reported one,
    /// or that of the positions if it is higher by more than measuring makes it. `None` before the positions show one.
    pub(super) fn speed(&self, reported: [f64; 2], lock: [bool; 2]) -> Option<f64> {
        let size = |velocity: [f64; 2]| {
            let [x, y] = without(lock, velocity);
            x.hypot(y)
        };
        let (reported, shown) = (size(reported), size(self.velocity?) / SLACK);
        // what is not a number stays none
        Some(if shown > reported { shown } else { reported })
    }

    /// What comes next does not continue this.
    pub(super) fn forget(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A handle that goes this way in each of 20 ms.
    fn travelled(way: [f64; 2]) -> Travel {
        let mut travel = Travel::default();
        for tick in 0..=20_u32 {
            let position = way.map(|way| way * f64::from(tick));
            let now = LocalTime(u64::from(tick) * 1_000_000);
            travel.take(now, &Motion { position, velocity: [0.0; 2] });
        }
        travel
    }

    #[test]
    fn law_the_higher_speed_counts_and_what_is_not_known_or_not_a_number_is_no_rest() {
        let speed = |way, reported, lock| travelled(way).speed(reported, lock);
        let near = |found: Option<f64>, expected: f64| {
            assert!((found.unwrap() - expected).abs() < 1e-12, "{found:?} {expected}");
        };
        near(speed([3e-4, -4e-4], [0.0; 2], [false; 2]), 0.5 / SLACK);
        near(speed([3e-4, -4e-4], [0.0, 0.6], [false; 2]), 0.6);
        near(speed([3e-4, -4e-4], [0.0, 0.6], [false, true]), 0.3 / SLACK);
        near(speed([3e-4, -4e-4], [0.0, 0.6], [true; 2]), 0.0);
        assert!(speed([1e-3, 0.0], [f64::NAN, 0.0], [false; 2]).unwrap().is_nan());
        assert_eq!(Travel::default().speed([0.0; 2], [false; 2]), None);
        let mut travel = travelled([1e-3, 0.0]);
        travel.forget();
        assert_eq!(travel.speed([0.0; 2], [false; 2]), None);
    }
}
