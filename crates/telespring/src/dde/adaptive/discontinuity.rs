//! Break points of the solution: their times and orders, and their propagation through the delays.

use super::interpolant::ORDER;

/// Two times within this many roundings are one.
const ROUNDINGS: f64 = 32.0;

/// The distance below which two discontinuities near `time` count as one.
pub(super) fn resolution(time: f64) -> f64 {
    ROUNDINGS * f64::EPSILON * time.abs()
}

/// A time at which a derivative of the solution jumps, with the order of the lowest such derivative.
///
/// Order 0 is a jump of the value, order 1 a kink, and so on. A break of order k at ξ propagates through a
/// delay τ to the time t with t − τ(t) = ξ, one order smoother, since y'(t) depends on y(t − τ).
///
/// # Examples
///
/// ```
/// use telespring::dde::adaptive::Discontinuity;
///
/// let force_switches = Discontinuity::kink(2.5);
/// assert_eq!(force_switches, Discontinuity { time: 2.5, order: 1 });
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Discontinuity {
    /// The time, in the unit of the problem.
    pub time: f64,
    /// The lowest derivative of the solution that jumps; 0 is the solution itself.
    pub order: u32,
}

impl Discontinuity {
    /// A break point where the first derivative jumps: a force that switches on.
    pub fn kink(time: f64) -> Self {
        Self { time, order: 1 }
    }

    /// A break point where the value jumps, possible only in a history.
    pub fn jump(time: f64) -> Self {
        Self { time, order: 0 }
    }
}

/// The break points reached so far and the known ones ahead.
#[derive(Debug)]
pub(super) struct Discontinuities {
    /// Sorted by time; those before the start belong to the history.
    reached: Vec<Discontinuity>,
    /// Sorted by time, all later than the last reached one.
    pending: Vec<Discontinuity>,
    constant_delays: Vec<f64>,
    end: f64,
}

impl Discontinuities {
    /// The break points at `start`, including those declared by the caller in the history and ahead.
    pub(super) fn new(
        constant_delays: Vec<f64>,
        start: Discontinuity,
        end: f64,
        declared: &[Discontinuity],
    ) -> Self {
        let mut discontinuities = Self { reached: Vec::new(), pending: Vec::new(), constant_delays, end };
        // Declared times go first, so that a propagated time that differs by rounding yields to them.
        for &breakpoint in declared.iter().filter(|d| d.time > start.time) {
            discontinuities.add_pending(breakpoint, resolution(breakpoint.time));
        }
        let mut in_history: Vec<_> = declared.iter().copied().filter(|d| d.time < start.time).collect();
        in_history.sort_by(|a, b| a.time.total_cmp(&b.time));
        for breakpoint in in_history {
            discontinuities.reach(breakpoint, start.time);
        }
        discontinuities.reach(start, start.time);
        discontinuities
    }

    /// Adds a break ahead, or lowers the order of an existing one.
    fn add_pending(&mut self, new: Discontinuity, slack: f64) {
        if new.time > self.end || new.order > ORDER {
            return;
        }
        let at = self.pending.partition_point(|d| d.time < new.time - slack);
        match self.pending.get_mut(at) {
            Some(known) if known.time <= new.time + slack => {
                known.order = known.order.min(new.order);
            }
            _ => self.pending.insert(at, new),
        }
    }

    /// The next known discontinuity ahead.
    pub(super) fn next_pending(&self) -> Option<Discontinuity> {
        self.pending.first().copied()
    }

    /// Records a break as reached and propagates it through the constant delays.
    pub(super) fn reach(&mut self, here: Discontinuity, start: f64) {
        let done = self.pending.partition_point(|d| d.time <= here.time + resolution(here.time));
        self.pending.drain(..done);
        self.reached.push(here);
        for i in 0..self.constant_delays.len() {
            let delay = self.constant_delays[i];
            let time = here.time + delay;
            // The sum is as uncertain as its larger part, however close to zero it is.
            let slack = resolution(here.time.abs().max(delay));
            if time > start.max(here.time) + slack {
                self.add_pending(Discontinuity { time, order: here.order + 1 }, slack);
            }
        }
    }

    /// The breaks from `low` to `high` whose image, one order smoother, still affects the method.
    pub(super) fn reached_between(&self, low: f64, high: f64) -> impl Iterator<Item = Discontinuity> + '_ {
        let from = self.reached.partition_point(|d| d.time < low);
        self.reached[from..].iter().take_while(move |d| d.time <= high).copied().filter(|d| d.order < ORDER)
    }

    /// The times of the break points at which the value jumps.
    pub(super) fn jumps(&self) -> Vec<f64> {
        self.reached.iter().filter(|d| d.order == 0).map(|d| d.time).collect()
    }

    /// Whether the solution has just reached a discontinuity at `time`.
    pub(super) fn has_break_at(&self, time: f64) -> bool {
        self.reached.last().is_some_and(|d| d.time == time)
    }

    /// All discontinuities reached at or after `start`.
    pub(super) fn since(&self, start: f64) -> Vec<Discontinuity> {
        self.reached.iter().copied().filter(|d| d.time >= start).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_breaks_travel_one_order_smoother_and_end_at_the_method_order() {
        let mut discontinuities = Discontinuities::new(vec![0.5], Discontinuity::jump(0.0), 10.0, &[]);
        let mut seen = Vec::new();
        while let Some(next) = discontinuities.next_pending() {
            seen.push(next);
            discontinuities.reach(next, 0.0);
        }
        let expected: Vec<_> =
            (1..=ORDER).map(|order| Discontinuity { time: 0.5 * f64::from(order), order }).collect();
        assert_eq!(seen, expected);
    }

    #[test]
    fn law_routes_that_differ_by_rounding_are_one_break() {
        let mut discontinuities =
            Discontinuities::new(vec![1.0 / 3.0, 0.2], Discontinuity::kink(0.0), 1.0, &[]);
        let mut seen = Vec::new();
        while let Some(next) = discontinuities.next_pending() {
            seen.push(next.time);
            discontinuities.reach(next, 0.0);
        }
        assert!(seen.windows(2).all(|w| w[1] - w[0] > 1e-3), "{seen:?}");
    }

    #[test]
    fn law_a_declared_time_is_kept_to_the_last_digit() {
        let declared = Discontinuity { time: 0.3, order: 3 };
        let discontinuities =
            Discontinuities::new(vec![0.1 + 0.2], Discontinuity::jump(0.0), 1.0, &[declared]);
        assert_eq!(discontinuities.next_pending(), Some(Discontinuity { time: 0.3, order: 1 }));
    }
}
