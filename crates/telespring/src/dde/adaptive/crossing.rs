//! Break points that come back through a varying delay: roots of t − τ(t) = ξ inside a step.

use super::discontinuity::{Discontinuities, Discontinuity, resolution};
use super::equation::{Delayed, Interrupt};
use super::history::StateHistory;
use super::interpolant;

/// Places in a step at which the argument is compared with the break points; between two of them a pair of
/// crossings can hide, which is then left to the error control.
const SAMPLES: usize = 4;

/// The span of one step as a crossing search sees it.
pub(super) struct Window<'c> {
    pub(super) start: f64,
    pub(super) end: f64,
    /// What callbacks are shown for the two ends.
    pub(super) seen: (f64, f64),
    pub(super) state: StateSource<'c>,
}

/// The state along the step: known to be unneeded, or the polynomial of a trial.
pub(super) enum StateSource<'c> {
    Unneeded(&'c [f64]),
    Attempt(&'c [f64]),
}

impl<'a, E, F, H> StateHistory<'a, E, F, H>
where
    F: FnMut(f64, &[f64], Delayed<'_>, &mut [f64]) -> Result<(), E>,
    H: FnMut(f64, &mut [f64]) -> Result<(), E>,
{
    /// The first break in `window` that comes through delay `index`, its start left out and its end included.
    pub(super) fn crossing(
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
                    self.root(index, window, source.time, (earlier, gap_before), later, &mut scratch)?
                } else {
                    continue;
                };
                let found = Discontinuity { time, order: source.order + 1 };
                first = Some(match first {
                    Some(known) if known.time < time - resolution(time) => known,
                    Some(known) if known.time <= time + resolution(time) => {
                        Discontinuity { time: known.time, order: known.order.min(found.order) }
                    }
                    _ => found,
                });
            }
            if first.is_some() {
                break;
            }
            (before, earlier) = (after, later);
        }
        Ok(first.filter(|found| found.time > window.start + resolution(window.start)))
    }

    /// The argument at `t` in the window.
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
                interpolant::evaluate(coefficients, theta, scratch);
                self.equation.argument(index, t, seen, scratch)
            }
        }
    }

    /// The root of argument = `level` between `low`, given with its gap there, and `high`, by bisection down to
    /// neighbouring numbers: a break is landed on to the last digit, and delays need not be smooth.
    fn root(
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
