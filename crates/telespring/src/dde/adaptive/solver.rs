//! The loop over steps: step ends, acceptance and step-size control.

use super::crossing::{StateSource, Window};
use super::discontinuity::{Discontinuities, Discontinuity, resolution};
use super::equation::{Delayed, Equation, Interrupt};
use super::history::{StateHistory, offset_by_roundings};
use super::interpolant;
use super::options::CheckedOptions;
use super::solution::{Solution, Status};
use super::step::{ErrorScale, Outcome, StepAttempt, StepInterval};

/// Gustafsson's step-size controller as in Hairer, Nørsett and Wanner (1993), section IV.2 of volume II,
/// and DOPRI5: the weight of the last error, the safety factor and the limits of one change.
const BETA: f64 = 0.04;
const SAFETY: f64 = 0.9;
const SHRINK: f64 = 0.2;
const GROW: f64 = 5.0;

/// The factor for a step that did not converge, and the factor by which each accepted step raises that
/// ceiling.
const UNSETTLED: f64 = 0.5;
const LIFT: f64 = 1.1;

/// How often a step is cut back to a break through a state-dependent delay before it is accepted as it is.
const CUTS: usize = 6;

/// The state of the solver.
pub(super) struct Solver<'a, E, F, H> {
    history: StateHistory<'a, E, F, H>,
    discontinuities: Discontinuities,
    attempt: StepAttempt,
    scale: ErrorScale,
    options: CheckedOptions,
    /// The sorted times of the declared breaks.
    declared: Vec<f64>,
    end: f64,
    /// The current state; the current time is `history.here`.
    state: Vec<f64>,
    /// True if the first stage must be evaluated anew instead of reusing the last stage.
    fresh: bool,
    rejected: usize,
    last_error: f64,
}

/// The end of a step, and the order of the break there.
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
    /// A solver at the start of the span.
    pub(super) fn new(
        equation: Equation<'a, E, F, H>,
        initial: Vec<f64>,
        start: Discontinuity,
        end: f64,
        options: CheckedOptions,
    ) -> Self {
        let dimension = equation.dimension;
        let discontinuities =
            Discontinuities::new(equation.constant_delays(), start, end, &options.breakpoints);
        let mut history = StateHistory::new(equation, start.time, initial.clone());
        history.jumps = discontinuities.jumps();
        let scale = ErrorScale { rtol: options.rtol.clone(), atol: options.atol.clone() };
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

    /// Runs the solver to the end and returns the solution with its status.
    pub(super) fn run(mut self) -> Solution<E> {
        let (status, failure) = match self.run_steps() {
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

    /// The loop over steps until the end or a failure.
    fn run_steps(&mut self) -> Result<Status, Interrupt<E>> {
        let mut width = self.first_step_width()?;
        let (mut cuts, mut cut) = (0, None);
        let mut not_finite = false;
        // A rejected step, or one that did not converge, is not enlarged at once.
        let (mut grow, mut ceiling) = (GROW, f64::INFINITY);
        while self.history.here < self.end {
            let here = self.history.here;
            if self.history.mesh.steps() + self.rejected >= self.options.max_steps {
                return Ok(Status::TooManySteps { at: here });
            }
            let mut target = self.choose_step_end(width, cut.take())?;
            if target.landing.is_none()
                && target.end < self.end
                && target.end - here <= self.smallest_step(here)
            {
                return Ok(if not_finite {
                    Status::NonFinite { at: here }
                } else {
                    Status::StepTooSmall { at: here }
                });
            }
            let ends =
                StepInterval { start: here, end: target.end, seen_end: self.callback_time(target, -1.0) };
            self.prepare_step(ends)?;
            let outcome = match self.attempt.try_step(&mut self.history, ends, &self.state, &self.scale) {
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
            if let Some(crossing) = self.crossing_by_state_delay(ends)? {
                if crossing.time < ends.end && cuts < CUTS {
                    cuts += 1;
                    self.rejected += 1;
                    cut = Some(crossing.time);
                    continue;
                }
                if crossing.time == ends.end {
                    target.landing = Some(target.landing.map_or(crossing.order, |o| o.min(crossing.order)));
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
            self.history.equation.check_state_delays(ends.end, &self.attempt.new)?;
            // A step cut short by a break says little about the step size the solution allows.
            let next = ends.width() * factor.clamp(SHRINK, grow);
            width = if ends.width() < 0.99 * width && cuts == 0 { next.max(width) } else { next };
            ceiling *= LIFT;
            width = width.min(ceiling);
            grow = GROW;
            self.last_error = error.max(1e-4);
            self.accept_step(target);
            (cuts, not_finite) = (0, false);
        }
        Ok(Status::Completed)
    }

    /// The time that the solver passes to callbacks at the end (`side` −1) or the start (1) of a step: a few
    /// roundings inside it at a declared break.
    fn callback_time(&self, target: StepEnd, side: f64) -> f64 {
        let slack = resolution(target.end);
        let nearest = self.declared.partition_point(|d| *d < target.end - slack);
        match self.declared.get(nearest) {
            Some(d) if *d <= target.end + slack => offset_by_roundings(target.end, side, 0.0),
            _ => target.end,
        }
    }

    /// The smallest step width of the solver that changes time and solution.
    fn smallest_step(&self, here: f64) -> f64 {
        0.5 * resolution(here.abs().max(1e-4 * (self.end - self.history.start)))
    }

    /// The end of the solver's next step of about `width`: on a nearby break, never leaving a tiny step
    /// before it. `cut` is the time at which an attempted step met a break through the state.
    fn choose_step_end(&mut self, width: f64, cut: Option<f64>) -> Result<StepEnd, Interrupt<E>> {
        let here = self.history.here;
        let width = width.min(self.options.max_step);
        let (stop, order) = match self.discontinuities.next_pending() {
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
        let seen_start = self.callback_time(StepEnd { end: here, landing: None }, 1.0);
        for index in 0..self.history.equation.delays.len() {
            if !self.history.equation.is_time_dependent(index) {
                continue;
            }
            let window = Window {
                start: here,
                end: target.end,
                seen: (seen_start, self.callback_time(target, -1.0)),
                state: StateSource::Unneeded(&self.state),
            };
            if let Some(crossing) = self.history.delayed_crossing(index, &window, &self.discontinuities)? {
                let order = match target.landing {
                    Some(known) if crossing.time >= target.end - resolution(target.end) => {
                        known.min(crossing.order)
                    }
                    _ => crossing.order,
                };
                let end = if crossing.time >= target.end - resolution(target.end) {
                    target.end
                } else {
                    crossing.time
                };
                target = StepEnd { end, landing: Some(order) };
            }
        }
        Ok(target)
    }

    /// Prepares the first stage and the predictor of the solver's next step.
    fn prepare_step(&mut self, ends: StepInterval) -> Result<(), Interrupt<E>> {
        let here = ends.start;
        self.history.state_slack = self.history.equation.state_slack * ends.width();
        self.history.choose_jump_sides(ends.end, &self.state, &self.attempt.stages[0])?;
        if self.fresh {
            let seen = self.callback_time(StepEnd { end: here, landing: None }, 1.0);
            self.history.slope(here, seen, &self.state, &mut self.attempt.stages[0])?;
            self.fresh = false;
        }
        let predictor = &mut self.history.predictor;
        let steps = self.history.mesh.steps();
        // The polynomial of the last step serves as a predictor, unless the solution breaks here.
        let continues = steps > 0
            && !self.discontinuities.has_break_at(here)
            && ends.width() <= 2.0 * self.history.mesh.step(steps - 1).2;
        if continues {
            let (coefficients, origin, width) = self.history.mesh.step(steps - 1);
            predictor.coefficients.copy_from_slice(coefficients);
            (predictor.origin, predictor.width) = (origin, width);
        } else {
            (predictor.origin, predictor.width) = (here, ends.width());
            interpolant::straight_line(
                ends.width(),
                &self.state,
                &self.attempt.stages[0],
                &mut predictor.coefficients,
            );
        }
        Ok(())
    }

    /// The first break in the solver's attempted step that propagates through a state-dependent delay.
    fn crossing_by_state_delay(&mut self, ends: StepInterval) -> Result<Option<Discontinuity>, Interrupt<E>> {
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
            match self.history.delayed_crossing(index, &window, &self.discontinuities) {
                Ok(Some(crossing)) if first.is_none_or(|known| crossing.time < known.time) => {
                    first = Some(crossing)
                }
                Ok(_) | Err(Interrupt::NonFinite) => {}
                Err(other) => return Err(other),
            }
        }
        Ok(first)
    }

    /// Accepts the solver's attempted step: extends the mesh and reaches the break at its end.
    fn accept_step(&mut self, target: StepEnd) {
        self.history.mesh.push(target.end, &self.attempt.coefficients);
        self.history.here = target.end;
        self.state.copy_from_slice(&self.attempt.new);
        let (first, last) = self.attempt.stages.split_at_mut(1);
        first[0].copy_from_slice(&last[5]);
        if let Some(order) = target.landing {
            self.discontinuities.reach(Discontinuity { time: target.end, order }, self.history.start);
            self.fresh = true;
            self.last_error = 1e-4;
        }
    }

    /// The width of the solver's first step (Hairer, Nørsett and Wanner 1993, section II.4).
    fn first_step_width(&mut self) -> Result<f64, Interrupt<E>> {
        let span = self.end - self.history.start;
        let small = 1e-6 * span;
        let seen = |time: f64| StepInterval { start: time, end: time + small, seen_end: time + small };
        self.prepare_step(seen(self.history.here))?;
        if let Some(width) = self.options.initial_step {
            return Ok(width.min(span));
        }
        let (state, first) = (self.state.clone(), self.attempt.stages[0].clone());
        let value = self.scale.measure(&state, &state, |i| state[i]);
        let slope = self.scale.measure(&state, &state, |i| first[i]);
        let probe = if value < 1e-5 || slope < 1e-5 { small } else { 0.01 * value / slope };
        let probe = probe
            .min(span)
            .min(self.discontinuities.next_pending().map_or(span, |next| next.time - self.history.here));
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
