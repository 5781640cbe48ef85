//! Break points that propagate through a varying delay: roots of t − τ(t) = ξ within a step.

use super::discontinuity::{Discontinuities, Discontinuity, resolution};
use super::equation::{Delayed, Interrupt};
use super::history::StateHistory;
use super::interpolant;

/// Points per step at which the delayed argument is compared with the break points. A pair of crossings
/// between two points can be missed; the error control then handles it.
const SAMPLES: usize = 4;

/// The interval of one step in a search for crossings.
pub(super) struct Window<'c> {
    pub(super) start: f64,
    pub(super) end: f64,
    /// The times passed to callbacks at both ends.
    pub(super) seen: (f64, f64),
    pub(super) state: StateSource<'c>,
}

/// The state along the step: not needed, or the polynomial of an attempted step.
pub(super) enum StateSource<'c> {
    Unneeded(&'c [f64]),
    Attempt(&'c [f64]),
}

impl<'a, E, F, H> StateHistory<'a, E, F, H>
where
    F: FnMut(f64, &[f64], Delayed<'_>, &mut [f64]) -> Result<(), E>,
    H: FnMut(f64, &mut [f64]) -> Result<(), E>,
{
    /// The first crossing of a break in `window`, which propagates through delay `index`; the start is
    /// excluded, the end included.
    pub(super) fn delayed_crossing(
        &mut self,
        index: usize,
        window: &Window<'_>,
        discontinuities: &Discontinuities,
    ) -> Result<Option<Discontinuity>, Interrupt<E>> {
        let width = window.end - window.start;
        let mut scratch = vec![0.0; self.equation.dimension];
        let mut first: Option<Discontinuity> = None;
        let mut before = self.argument_in(index, window, window.start, &mut scratch)?;
        let mut earlier = window.start;
        for sample in 1..=SAMPLES {
            let last = sample == SAMPLES;
            let later = if last { window.end } else { window.start + width * sample as f64 / SAMPLES as f64 };
            let after = self.argument_in(index, window, later, &mut scratch)?;
            let slack = self.slack(index, later, after);
            let (low, high) = (before.min(after) - slack, before.max(after) + slack);
            for source in discontinuities.reached_between(low, high) {
                let gap_before = before - source.time;
                let gap_after = after - source.time;
                let leaving = sample == 1 && gap_before.abs() <= self.slack(index, earlier, before);
                let time = if last && gap_after.abs() <= slack {
                    window.end
                } else if !leaving && (gap_before < 0.0) != (gap_after < 0.0) {
                    self.bisect_crossing(
                        index,
                        window,
                        source.time,
                        (earlier, gap_before),
                        later,
                        &mut scratch,
                    )?
                } else {
                    continue;
                };
                let crossing = Discontinuity { time, order: source.order + 1 };
                first = Some(match first {
                    Some(known) if known.time < time - resolution(time) => known,
                    Some(known) if known.time <= time + resolution(time) => {
                        Discontinuity { time: known.time, order: known.order.min(crossing.order) }
                    }
                    _ => crossing,
                });
            }
            if first.is_some() {
                break;
            }
            (before, earlier) = (after, later);
        }
        Ok(first.filter(|crossing| crossing.time > window.start + resolution(window.start)))
    }

    /// The delayed argument t − τ at `t`, to find its crossing of a break in the window of a step.
    fn argument_in(
        &mut self,
        index: usize,
        window: &Window<'_>,
        t: f64,
        scratch: &mut [f64],
    ) -> Result<f64, Interrupt<E>> {
        let seen = if t == window.start {
            window.seen.0
        } else if t == window.end {
            window.seen.1
        } else {
            t
        };
        match window.state {
            StateSource::Unneeded(y) => self.equation.argument(index, t, seen, y),
            StateSource::Attempt(coefficients) => {
                let theta = (t - window.start) / (window.end - window.start);
                interpolant::evaluate_polynomial(coefficients, theta, scratch);
                self.equation.argument(index, t, seen, scratch)
            }
        }
    }

    /// The crossing, root of argument = `level`, between `low`, given with its gap, and `high`, by bisection to
    /// neighbouring numbers: breaks are located to the last digit, and delays need not be smooth.
    fn bisect_crossing(
        &mut self,
        index: usize,
        window: &Window<'_>,
        level: f64,
        (mut low, gap_low): (f64, f64),
        mut high: f64,
        scratch: &mut [f64],
    ) -> Result<f64, Interrupt<E>> {
        loop {
            let middle = low + 0.5 * (high - low);
            if middle <= low || middle >= high {
                return Ok(high);
            }
            let gap = self.argument_in(index, window, middle, scratch)? - level;
            if gap == 0.0 {
                return Ok(middle);
            }
            if (gap < 0.0) == (gap_low < 0.0) {
                low = middle;
            } else {
                high = middle;
            }
        }
    }
}
