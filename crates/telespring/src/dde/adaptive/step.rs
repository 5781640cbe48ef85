//! One attempted Runge-Kutta step: its seven stages, iterated if it overlaps its own delay.

use super::equation::{Delayed, Interrupt};
use super::history::StateHistory;
use super::interpolant::{self, COEFFICIENTS, ERROR, NODES, STAGES, WEIGHTS};

/// The maximum number of iterations of a step that overlaps its own delay.
const REPETITIONS: usize = 12;

/// The remaining iteration error at the end, as a fraction of the tolerance.
const SETTLED: f64 = 0.01;

/// The allowed ratio of the defect in the middle of a step to the error estimate.
///
/// The pair's error estimate gives a jump of the slope between 0 and 0.8 of the step a weight of 0.003 or
/// less although the error is a quarter of it, so a friction switch could pass at a hundred times the
/// tolerance. The defect contains such a jump in full (Enright and Hayashi 1997 control it alone). In
/// smooth steps a tenth of it is about as large as the estimate, and it also keeps the dense output within
/// the tolerance.
const DEFECT: f64 = 10.0;

/// The interval of a step: mesh times, and the times passed to callbacks.
#[derive(Debug, Clone, Copy)]
pub(super) struct StepInterval {
    pub(super) start: f64,
    pub(super) end: f64,
    pub(super) seen_end: f64,
}

impl StepInterval {
    /// The width of a step of the adaptive solver.
    pub(super) fn width(&self) -> f64 {
        self.end - self.start
    }
}

/// The tolerances, one per component.
#[derive(Debug)]
pub(super) struct ErrorScale {
    pub(super) rtol: Vec<f64>,
    pub(super) atol: Vec<f64>,
}

impl ErrorScale {
    /// The error of a step: its largest |difference| relative to the tolerance of its component; NaN if one is NaN.
    pub(super) fn measure(&self, old: &[f64], new: &[f64], difference: impl Fn(usize) -> f64) -> f64 {
        let mut largest = 0.0;
        for i in 0..old.len() {
            let allowed = self.atol[i] + self.rtol[i] * old[i].abs().max(new[i].abs());
            let measured = difference(i).abs() / allowed;
            if measured.is_nan() {
                return f64::NAN;
            }
            largest = f64::max(largest, measured);
        }
        largest
    }
}

/// The memory of an attempted step.
#[derive(Debug)]
pub(super) struct StepAttempt {
    pub(super) stages: [Vec<f64>; STAGES],
    pub(super) new: Vec<f64>,
    pub(super) coefficients: Vec<f64>,
    argument: Vec<f64>,
    guess: [Vec<f64>; 2],
    reached: [Vec<f64>; 2],
}

/// The outcome of an attempted step.
#[derive(Debug, PartialEq)]
pub(super) enum Outcome {
    /// The error as a fraction of the tolerance; acceptable up to 1.
    Error(f64),
    /// The iteration did not converge: the step is too long for the delay.
    Unsettled,
}

impl StepAttempt {
    /// Memory for attempted steps of a system with this dimension.
    pub(super) fn new(dimension: usize) -> Self {
        let room = || vec![0.0; dimension];
        Self {
            stages: std::array::from_fn(|_| room()),
            new: room(),
            coefficients: vec![0.0; COEFFICIENTS * dimension],
            argument: room(),
            guess: [room(), room()],
            reached: [room(), room()],
        }
    }

    /// Tries the step over `ends` from `old`; the first stage is given. Lookups within the step use its own
    /// polynomial, and the step is iterated until that polynomial converges.
    pub(super) fn try_step<E, F, H>(
        &mut self,
        history: &mut StateHistory<'_, E, F, H>,
        ends: StepInterval,
        old: &[f64],
        scale: &ErrorScale,
    ) -> Result<Outcome, Interrupt<E>>
    where
        F: FnMut(f64, &[f64], Delayed<'_>, &mut [f64]) -> Result<(), E>,
        H: FnMut(f64, &mut [f64]) -> Result<(), E>,
    {
        let width = ends.width();
        let checkpoints = [ends.start + 0.5 * width, ends.end];
        let mut last_change = f64::INFINITY;
        for repetition in 0.. {
            history.looked_ahead = false;
            self.run_stages(history, ends, old)?;
            interpolant::fit_polynomial(width, old, &self.new, &self.stages, &mut self.coefficients);
            if !history.looked_ahead {
                break;
            }
            let mut change = 0.0;
            for (k, &time) in checkpoints.iter().enumerate() {
                history.predictor.evaluate(time, &mut self.guess[k]);
                interpolant::evaluate_polynomial(
                    &self.coefficients,
                    (time - ends.start) / width,
                    &mut self.reached[k],
                );
                let (guess, reached) = (&self.guess[k], &self.reached[k]);
                let here = scale.measure(guess, reached, |i| reached[i] - guess[i]);
                if !here.is_finite() {
                    return Ok(Outcome::Unsettled);
                }
                change = f64::max(change, here);
            }
            // The change left in further iterations, from the ratio of the last two changes.
            let ratio = change / last_change;
            let left = if last_change.is_finite() { change * ratio / (1.0 - ratio).max(0.1) } else { change };
            if change <= SETTLED * SETTLED || left <= SETTLED {
                break;
            }
            if repetition >= REPETITIONS || (repetition >= 2 && ratio > 0.8) {
                return Ok(Outcome::Unsettled);
            }
            last_change = change;
            history.predictor.coefficients.copy_from_slice(&self.coefficients);
            history.predictor.origin = ends.start;
            history.predictor.width = width;
        }
        let stages = &self.stages;
        let error = scale.measure(old, &self.new, |i| {
            width * ERROR.iter().zip(stages).map(|(weight, stage)| weight * stage[i]).sum::<f64>()
        });
        if error.is_nan() || error > 1.0 {
            return Ok(Outcome::Error(error));
        }
        Ok(Outcome::Error(error.max(self.defect(history, ends, scale)? / DEFECT)))
    }

    /// The defect of a step: the residual of its polynomial in the equation in the middle of the step, times the
    /// step, as a fraction of the tolerance.
    fn defect<E, F, H>(
        &mut self,
        history: &mut StateHistory<'_, E, F, H>,
        ends: StepInterval,
        scale: &ErrorScale,
    ) -> Result<f64, Interrupt<E>>
    where
        F: FnMut(f64, &[f64], Delayed<'_>, &mut [f64]) -> Result<(), E>,
        H: FnMut(f64, &mut [f64]) -> Result<(), E>,
    {
        let (width, time) = (ends.width(), ends.start + 0.5 * ends.width());
        let [state, rise] = &mut self.reached;
        interpolant::evaluate_polynomial(&self.coefficients, 0.5, state);
        interpolant::differentiate_polynomial(&self.coefficients, 0.5, width, rise);
        history.slope(time, time, state, &mut self.argument)?;
        let slope = &self.argument;
        Ok(scale.measure(state, &self.new, |i| width * (rise[i] - slope[i])))
    }

    /// Evaluates the step's stages after the first; the argument of the last one is the new state.
    fn run_stages<E, F, H>(
        &mut self,
        history: &mut StateHistory<'_, E, F, H>,
        ends: StepInterval,
        old: &[f64],
    ) -> Result<(), Interrupt<E>>
    where
        F: FnMut(f64, &[f64], Delayed<'_>, &mut [f64]) -> Result<(), E>,
        H: FnMut(f64, &mut [f64]) -> Result<(), E>,
    {
        let width = ends.width();
        for (row, weights) in WEIGHTS.iter().enumerate() {
            let stage = row + 1;
            for (i, value) in self.argument.iter_mut().enumerate() {
                let mut sum = 0.0;
                for (weight, slope) in weights.iter().zip(&self.stages) {
                    sum += weight * slope[i];
                }
                *value = old[i] + width * sum;
            }
            let (nominal, seen) = if NODES[stage] == 1.0 {
                (ends.end, ends.seen_end)
            } else {
                let time = ends.start + NODES[stage] * width;
                (time, time)
            };
            history.slope(nominal, seen, &self.argument, &mut self.stages[stage])?;
        }
        self.new.copy_from_slice(&self.argument);
        if self.new.iter().all(|v| v.is_finite()) { Ok(()) } else { Err(Interrupt::NonFinite) }
    }
}
