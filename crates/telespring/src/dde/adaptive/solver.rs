//! The loop over steps: where each ends, whether it is kept, and how long the next one is.

use super::crossing::{StateSource, Window};
use super::discontinuity::{Discontinuities, Discontinuity, resolution};
use super::equation::{Delayed, Equation, Interrupt};
use super::history::{StateHistory, aside};
use super::interpolant;
use super::options::Checked;
use super::solution::{Solution, Status};
use super::step::{Ends, Outcome, Scale, StepAttempt};

/// The controller of Gustafsson as in Hairer, Nørsett and Wanner (1993), section IV.2 of volume II and DOPRI5:
/// the weight of the last error, the safety factor and the limits of one change.
const BETA: f64 = 0.04;
const SAFETY: f64 = 0.9;
const SHRINK: f64 = 0.2;
const GROW: f64 = 5.0;

/// What a step that did not settle is cut to, and by how much each kept step then lifts that ceiling.
const UNSETTLED: f64 = 0.5;
const LIFT: f64 = 1.1;

/// How often a step is cut back to a break that a state-dependent delay meets before it is taken as it is.
const CUTS: usize = 6;

/// The computation under way.
pub(super) struct Solver<'a, E, F, H> {
    history: StateHistory<'a, E, F, H>,
    discontinuities: Discontinuities,
    attempt: StepAttempt,
    scale: Scale,
    options: Checked,
    /// Sorted times of the declared breaks.
    declared: Vec<f64>,
    end: f64,
    /// The current state; the current time is `history.here`.
    state: Vec<f64>,
    /// Whether the last stage of the last step still has to be replaced by a fresh first one.
    fresh: bool,
    rejected: usize,
    last_error: f64,
}

/// Where a step is to end and what waits there.
#[derive(Debug, Clone, Copy)]
struct StepEnd {
    end: f64,
    landing: Option<u32>,
}

impl<'a, E, F, H> Solver<'a, E, F, H>
where
    F: FnMut(f64, &[f64], Delayed<'_>, &mut [f64]) -> Result<(), E>,
    H: FnMut(f64, &mut [f64]) -> Result<(), E>,
{
    pub(super) fn new(
        equation: Equation<'a, E, F, H>,
        initial: Vec<f64>,
        start: Discontinuity,
        end: f64,
        options: Checked,
    ) -> Self {
        let dimension = equation.dimension;
        let discontinuities =
            Discontinuities::new(equation.constant_delays(), start, end, &options.breakpoints);
        let mut history = StateHistory::new(equation, start.time, initial.clone());
        history.jumps = discontinuities.jumps();
        let scale = Scale { rtol: options.rtol.clone(), atol: options.atol.clone() };
        let mut declared: Vec<f64> = options.breakpoints.iter().map(|d| d.time).collect();
        declared.sort_by(f64::total_cmp);
        Self {
            history,
            discontinuities,
            attempt: StepAttempt::new(dimension),
            scale,
            options,
            declared,
            end,
            state: initial,
            fresh: true,
            rejected: 0,
            last_error: 1e-4,
        }
    }

    /// Runs to the end and hands the solution over, whatever became of it.
    pub(super) fn run(mut self) -> Solution<E> {
        let (status, failure) = match self.advance() {
            Ok(status) => (status, None),
            Err(Interrupt::Callback(error)) => (Status::Stopped { at: self.history.here }, Some(error)),
            Err(Interrupt::NonFinite) => (Status::NonFinite { at: self.history.here }, None),
            Err(Interrupt::Delay { at, delay, value }) => (Status::InvalidDelay { at, delay, value }, None),
        };
        Solution {
            status,
            failure,
            steps: self.history.mesh.steps(),
            rejected: self.rejected,
            evaluations: self.history.equation.evaluations,
            discontinuities: self.discontinuities.since(self.history.start),
            mesh: self.history.mesh,
            initial: self.history.initial,
        }
    }

    fn advance(&mut self) -> Result<Status, Interrupt<E>> {
        let mut width = self.first_width()?;
        let (mut cuts, mut cut) = (0, None);
        let mut not_finite = false;
        // Neither a rejected step nor one that did not settle is tried again at once.
        let (mut grow, mut ceiling) = (GROW, f64::INFINITY);
        while self.history.here < self.end {
            let here = self.history.here;
            if self.history.mesh.steps() + self.rejected >= self.options.max_steps {
                return Ok(Status::TooManySteps { at: here });
            }
            let mut target = self.target(width, cut.take())?;
            if target.landing.is_none() && target.end < self.end && target.end - here <= self.smallest(here) {
                return Ok(if not_finite {
                    Status::NonFinite { at: here }
                } else {
                    Status::StepTooSmall { at: here }
                });
            }
            let ends = Ends { start: here, end: target.end, seen_end: self.seen(target, -1.0) };
            self.prepare(ends)?;
            let outcome = match self.attempt.run(&mut self.history, ends, &self.state, &self.scale) {
                Err(Interrupt::NonFinite) => {
                    not_finite = true;
                    Outcome::Unsettled
                }
                other => other?,
            };
            let Outcome::Error(error) = outcome else {
                self.rejected += 1;
                width = UNSETTLED * ends.width();
                ceiling = width;
                if width < resolution(here) {
                    return Ok(if not_finite {
                        Status::NonFinite { at: here }
                    } else {
                        Status::StepTooSmall { at: here }
                    });
                }
                continue;
            };
            if let Some(found) = self.state_crossing(ends)? {
                if found.time < ends.end && cuts < CUTS {
                    cuts += 1;
                    self.rejected += 1;
                    cut = Some(found.time);
                    continue;
                }
                if found.time == ends.end {
                    target.landing = Some(target.landing.map_or(found.order, |o| o.min(found.order)));
                }
            }
            let factor = SAFETY * error.powf(0.75 * BETA - 0.2) * self.last_error.powf(BETA);
            if error.is_nan() || error > 1.0 {
                self.rejected += 1;
                let factor = if error.is_finite() { SAFETY * error.powf(-0.2) } else { SHRINK };
                width = ends.width() * factor.clamp(SHRINK, SAFETY);
                grow = 1.0;
                if width < resolution(here) {
                    return Ok(Status::StepTooSmall { at: here });
                }
                continue;
            }
            self.history.equation.judge_delays(ends.end, &self.attempt.new)?;
            // A step cut short by a break says little about the step that the solution could bear.
            let next = ends.width() * factor.clamp(SHRINK, grow);
            width = if ends.width() < 0.99 * width && cuts == 0 { next.max(width) } else { next };
            ceiling *= LIFT;
            width = width.min(ceiling);
            grow = GROW;
            self.last_error = error.max(1e-4);
            self.keep(target);
            (cuts, not_finite) = (0, false);
        }
        Ok(Status::Completed)
    }

    /// The time that callbacks are shown at the end (`side` −1) or the start (1) of a step: a few roundings
    /// inside it where the caller declared a break.
    fn seen(&self, target: StepEnd, side: f64) -> f64 {
        let slack = resolution(target.end);
        let nearest = self.declared.partition_point(|d| *d < target.end - slack);
        match self.declared.get(nearest) {
            Some(d) if *d <= target.end + slack => aside(target.end, side, 0.0),
            _ => target.end,
        }
    }

    /// The smallest step that still moves the time and the solution.
    fn smallest(&self, here: f64) -> f64 {
        0.5 * resolution(here.abs().max(1e-4 * (self.end - self.history.start)))
    }

    /// Where a step of about `width` should end: on a break where one is near, never leaving a sliver before it.
    /// `cut` is the time at which a trial met a break through the state.
    fn target(&mut self, width: f64, cut: Option<f64>) -> Result<StepEnd, Interrupt<E>> {
        let here = self.history.here;
        let width = width.min(self.options.max_step);
        let (stop, order) = match self.discontinuities.next() {
            Some(next) => (next.time, Some(next.order)),
            None => (self.end, None),
        };
        let distance = stop - here;
        let mut target = if let Some(end) = cut {
            StepEnd { end, landing: None }
        } else if distance <= 1.01 * width {
            StepEnd { end: stop, landing: order }
        } else if distance < 2.0 * width {
            StepEnd { end: here + 0.5 * distance, landing: None }
        } else {
            StepEnd { end: here + width, landing: None }
        };
        let seen_start = self.seen(StepEnd { end: here, landing: None }, 1.0);
        for index in 0..self.history.equation.delays.len() {
            if !self.history.equation.is_timed(index) {
                continue;
            }
            let window = Window {
                start: here,
                end: target.end,
                seen: (seen_start, self.seen(target, -1.0)),
                state: StateSource::Unneeded(&self.state),
            };
            if let Some(found) = self.history.crossing(index, &window, &self.discontinuities)? {
                let order = match target.landing {
                    Some(known) if found.time >= target.end - resolution(target.end) => {
                        known.min(found.order)
                    }
                    _ => found.order,
                };
                let end =
                    if found.time >= target.end - resolution(target.end) { target.end } else { found.time };
                target = StepEnd { end, landing: Some(order) };
            }
        }
        Ok(target)
    }

    /// Makes the first stage and a first guess of the step ready.
    fn prepare(&mut self, ends: Ends) -> Result<(), Interrupt<E>> {
        let here = ends.start;
        self.history.state_slack = self.history.equation.state_slack * ends.width();
        self.history.aim(ends.end, &self.state, &self.attempt.stages[0])?;
        if self.fresh {
            let seen = self.seen(StepEnd { end: here, landing: None }, 1.0);
            self.history.slope(here, seen, &self.state, &mut self.attempt.stages[0])?;
            self.fresh = false;
        }
        let predictor = &mut self.history.predictor;
        let steps = self.history.mesh.steps();
        // The last step's polynomial goes on for a while, unless the solution breaks here.
        let continues = steps > 0
            && !self.discontinuities.breaks_at(here)
            && ends.width() <= 2.0 * self.history.mesh.step(steps - 1).2;
        if continues {
            let (coefficients, origin, width) = self.history.mesh.step(steps - 1);
            predictor.coefficients.copy_from_slice(coefficients);
            (predictor.origin, predictor.width) = (origin, width);
        } else {
            (predictor.origin, predictor.width) = (here, ends.width());
            interpolant::straight(
                ends.width(),
                &self.state,
                &self.attempt.stages[0],
                &mut predictor.coefficients,
            );
        }
        Ok(())
    }

    /// The first break in the trial that comes through a state-dependent delay.
    fn state_crossing(&mut self, ends: Ends) -> Result<Option<Discontinuity>, Interrupt<E>> {
        let mut first: Option<Discontinuity> = None;
        for index in 0..self.history.equation.delays.len() {
            if !self.history.equation.is_state_dependent(index) {
                continue;
            }
            let window = Window {
                start: ends.start,
                end: ends.end,
                seen: (ends.start, ends.seen_end),
                state: StateSource::Attempt(&self.attempt.coefficients),
            };
            match self.history.crossing(index, &window, &self.discontinuities) {
                Ok(Some(found)) if first.is_none_or(|known| found.time < known.time) => first = Some(found),
                Ok(_) | Err(Interrupt::NonFinite) => {}
                Err(other) => return Err(other),
            }
        }
        Ok(first)
    }

    /// Takes the trial step over.
    fn keep(&mut self, target: StepEnd) {
        self.history.mesh.push(target.end, &self.attempt.coefficients);
        self.history.here = target.end;
        self.state.copy_from_slice(&self.attempt.new);
        let (first, last) = self.attempt.stages.split_at_mut(1);
        first[0].copy_from_slice(&last[5]);
        if let Some(order) = target.landing {
            self.discontinuities.arrive(Discontinuity { time: target.end, order }, self.history.start);
            self.fresh = true;
            self.last_error = 1e-4;
        }
    }

    /// The first step to try (Hairer, Nørsett and Wanner 1993, section II.4).
    fn first_width(&mut self) -> Result<f64, Interrupt<E>> {
        let span = self.end - self.history.start;
        let small = 1e-6 * span;
        let seen = |time: f64| Ends { start: time, end: time + small, seen_end: time + small };
        self.prepare(seen(self.history.here))?;
        if let Some(width) = self.options.initial_step {
            return Ok(width.min(span));
        }
        let (state, first) = (self.state.clone(), self.attempt.stages[0].clone());
        let value = self.scale.measure(&state, &state, |i| state[i]);
        let slope = self.scale.measure(&state, &state, |i| first[i]);
        let probe = if value < 1e-5 || slope < 1e-5 { small } else { 0.01 * value / slope };
        let probe = probe
            .min(span)
            .min(self.discontinuities.next().map_or(span, |next| next.time - self.history.here));
        let moved: Vec<f64> = state.iter().zip(&first).map(|(y, v)| y + probe * v).collect();
        let mut second = vec![0.0; state.len()];
        let time = self.history.here + probe;
        let bend = match self.history.slope(time, time, &moved, &mut second) {
            Ok(()) => self.scale.measure(&state, &state, |i| second[i] - first[i]) / probe,
            Err(Interrupt::NonFinite) => return Ok(probe),
            Err(other) => return Err(other),
        };
        let steepest = slope.max(bend);
        let wanted = if steepest <= 1e-15 { probe.max(small) } else { (0.01 / steepest).powf(0.2) };
        Ok(wanted.min(100.0 * probe).min(span))
    }
}
