//! One trial step: the seven stages, and their repetition where the step looks into itself.

use super::equation::{Delayed, Interrupt};
use super::history::StateHistory;
use super::interpolant::{self, COEFFICIENTS, ERROR, NODES, STAGES, WEIGHTS};

/// How often a step that looks into itself is repeated before it is given up.
const REPETITIONS: usize = 12;

/// What is left of the repetition's error when it ends, as a part of the tolerance.
const SETTLED: f64 = 0.01;

/// How much larger than the error estimate the defect in the middle of a step may be.
///
/// The pair's own estimate weighs a jump of the slope between 0 and 0.8 of the step by 0.003 or less where the
/// error is a quarter of it, so a switch of friction could pass at a hundred times the tolerance. The defect
/// sees such a jump whole (Enright and Hayashi 1997 control it alone). In smooth steps a tenth of it is about as
/// large as the estimate, and it also holds the dense output to the tolerance.
const DEFECT: f64 = 10.0;

/// The two ends of a step: the mesh times, and the times that callbacks are shown there.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ends {
    pub(super) start: f64,
    pub(super) end: f64,
    pub(super) seen_end: f64,
}

impl Ends {
    pub(super) fn width(&self) -> f64 {
        self.end - self.start
    }
}

/// The tolerances, one per component.
#[derive(Debug)]
pub(super) struct Scale {
    pub(super) rtol: Vec<f64>,
    pub(super) atol: Vec<f64>,
}

impl Scale {
    /// The largest of |difference| measured by its component's tolerance; a NaN comes through.
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

/// The room in which a step is tried.
#[derive(Debug)]
pub(super) struct StepAttempt {
    pub(super) stages: [Vec<f64>; STAGES],
    pub(super) new: Vec<f64>,
    pub(super) coefficients: Vec<f64>,
    argument: Vec<f64>,
    guess: [Vec<f64>; 2],
    reached: [Vec<f64>; 2],
}

/// What became of a trial.
#[derive(Debug, PartialEq)]
pub(super) enum Outcome {
    /// The error as a part of the tolerance; to be kept where at most 1.
    Error(f64),
    /// The repetition did not settle: the step is too long for the delay.
    Unsettled,
}

impl StepAttempt {
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

    /// Tries the step `ends` from `old`; the first stage is there already. Where lookups fall into the step, its
    /// own polynomial answers them, and the step is repeated until that polynomial settles.
    pub(super) fn run<E, F, H>(
        &mut self,
        history: &mut StateHistory<'_, E, F, H>,
        ends: Ends,
        old: &[f64],
        scale: &Scale,
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
            interpolant::fit(width, old, &self.new, &self.stages, &mut self.coefficients);
            if !history.looked_ahead {
                break;
            }
            let mut change = 0.0;
            for (k, &time) in checkpoints.iter().enumerate() {
                history.predictor.evaluate(time, &mut self.guess[k]);
                interpolant::evaluate(&self.coefficients, (time - ends.start) / width, &mut self.reached[k]);
                let (guess, reached) = (&self.guess[k], &self.reached[k]);
                let here = scale.measure(guess, reached, |i| reached[i] - guess[i]);
                if !here.is_finite() {
                    return Ok(Outcome::Unsettled);
                }
                change = f64::max(change, here);
            }
            // What further repetitions would still change, by the ratio of the last two changes.
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

    /// How far the polynomial misses the equation in the middle of the step, times the step, as a part of the
    /// tolerance.
    fn defect<E, F, H>(
        &mut self,
        history: &mut StateHistory<'_, E, F, H>,
        ends: Ends,
        scale: &Scale,
    ) -> Result<f64, Interrupt<E>>
    where
        F: FnMut(f64, &[f64], Delayed<'_>, &mut [f64]) -> Result<(), E>,
        H: FnMut(f64, &mut [f64]) -> Result<(), E>,
    {
        let (width, time) = (ends.width(), ends.start + 0.5 * ends.width());
        let [state, rise] = &mut self.reached;
        interpolant::evaluate(&self.coefficients, 0.5, state);
        interpolant::differentiate(&self.coefficients, 0.5, width, rise);
        history.slope(time, time, state, &mut self.argument)?;
        let slope = &self.argument;
        Ok(scale.measure(state, &self.new, |i| width * (rise[i] - slope[i])))
    }

    /// The stages after the first; the last one's argument is the new state.
    fn run_stages<E, F, H>(
        &mut self,
        history: &mut StateHistory<'_, E, F, H>,
        ends: Ends,
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
