//! Lookups: where a delayed argument falls, and the value there.

use super::discontinuity::resolution;
use super::equation::{Delayed, Equation, Interrupt};
use super::interpolant;
use super::solution::Mesh;

/// Callbacks at one side of a jump are asked this many roundings aside of it.
const ASIDE: f64 = 4.0 * f64::EPSILON;

/// `t` moved by a few roundings to the later side (`direction` 1) or the earlier one (−1); `scale` speaks for
/// the unit of time where `t` is near zero.
pub(super) fn aside(t: f64, direction: f64, scale: f64) -> f64 {
    t + direction * ASIDE * t.abs().max(scale)
}

/// A polynomial that stands in for the step under way where a lookup falls into it.
#[derive(Debug, Default)]
pub(super) struct Predictor {
    pub(super) coefficients: Vec<f64>,
    pub(super) origin: f64,
    pub(super) width: f64,
}

impl Predictor {
    pub(super) fn evaluate(&self, t: f64, out: &mut [f64]) {
        interpolant::evaluate(&self.coefficients, (t - self.origin) / self.width, out);
    }
}

/// The equation together with its solution so far: all that an evaluation of the slope needs.
pub(super) struct StateHistory<'a, E, F, H> {
    pub(super) equation: Equation<'a, E, F, H>,
    pub(super) mesh: Mesh,
    pub(super) initial: Vec<f64>,
    pub(super) start: f64,
    /// Times at which the history or its junction with the solution jumps.
    pub(super) jumps: Vec<f64>,
    pub(super) predictor: Predictor,
    /// The time from which the predictor answers.
    pub(super) here: f64,
    /// Each delay's argument in the middle of the step: it tells on which side of a jump the step looks.
    pub(super) middle: Vec<f64>,
    /// How near to a jump a state-dependent argument counts as being on it.
    pub(super) state_slack: f64,
    /// Set when a lookup used the predictor.
    pub(super) looked_ahead: bool,
    hints: Vec<usize>,
    delayed: Vec<f64>,
}

impl<'a, E, F, H> StateHistory<'a, E, F, H>
where
    F: FnMut(f64, &[f64], Delayed<'_>, &mut [f64]) -> Result<(), E>,
    H: FnMut(f64, &mut [f64]) -> Result<(), E>,
{
    pub(super) fn new(equation: Equation<'a, E, F, H>, start: f64, initial: Vec<f64>) -> Self {
        let (delays, dimension) = (equation.delays.len(), equation.dimension);
        Self {
            equation,
            mesh: Mesh::new(start, dimension),
            initial,
            start,
            jumps: Vec::new(),
            predictor: Predictor {
                coefficients: vec![0.0; interpolant::COEFFICIENTS * dimension],
                origin: start,
                width: 1.0,
            },
            here: start,
            middle: vec![f64::NAN; delays],
            state_slack: 0.0,
            looked_ahead: false,
            hints: vec![0; delays],
            delayed: vec![0.0; delays * dimension],
        }
    }

    /// The roundings within which the argument `s` of delay `index`, asked at `t`, cannot be told from a break.
    pub(super) fn slack(&self, index: usize, t: f64, s: f64) -> f64 {
        let rounding = resolution(t.abs().max(s.abs()));
        if self.equation.is_state_dependent(index) { rounding.max(self.state_slack) } else { rounding }
    }

    /// Prepares the step from the current time to `end`: which side of each jump it looks at.
    pub(super) fn aim(&mut self, end: f64, y: &[f64], slope: &[f64]) -> Result<(), Interrupt<E>> {
        if self.jumps.is_empty() {
            return Ok(());
        }
        let half = 0.5 * (end - self.here);
        let time = self.here + half;
        let state: Vec<f64> = y.iter().zip(slope).map(|(y, v)| y + half * v).collect();
        for index in 0..self.middle.len() {
            self.middle[index] = self.equation.argument(index, time, time, &state)?;
        }
        Ok(())
    }

    /// y' at the mesh time `nominal`, at which callbacks are shown `seen`.
    pub(super) fn slope(
        &mut self,
        nominal: f64,
        seen: f64,
        y: &[f64],
        out: &mut [f64],
    ) -> Result<(), Interrupt<E>> {
        let mut delayed = std::mem::take(&mut self.delayed);
        let result = self
            .gather(nominal, seen, y, &mut delayed)
            .and_then(|()| self.equation.slope(seen, y, &delayed, out));
        self.delayed = delayed;
        result
    }

    /// Fills one row per delay with the delayed state.
    fn gather(
        &mut self,
        nominal: f64,
        seen: f64,
        y: &[f64],
        delayed: &mut [f64],
    ) -> Result<(), Interrupt<E>> {
        for (index, row) in delayed.chunks_exact_mut(self.equation.dimension).enumerate() {
            let argument = self.equation.argument(index, nominal, seen, y)?;
            if argument >= nominal {
                // No delay at all: the state itself, so that nothing has to be repeated.
                row.copy_from_slice(y);
            } else {
                self.look_up(index, nominal, argument, row)?;
            }
        }
        Ok(())
    }

    /// The value at the argument `s` of delay `index`, asked at `t`.
    fn look_up(&mut self, index: usize, t: f64, s: f64, out: &mut [f64]) -> Result<(), Interrupt<E>> {
        let slack = self.slack(index, t, s);
        if let Some(&jump) = self.jumps.iter().find(|&&jump| (s - jump).abs() <= slack) {
            let later = self.middle[index] > jump;
            if later && jump == self.start {
                out.copy_from_slice(&self.initial);
                return Ok(());
            }
            let scale = (self.predictor.width).abs();
            return self.equation.past(aside(jump, if later { 1.0 } else { -1.0 }, scale), out);
        }
        if s > self.here {
            self.looked_ahead = true;
            self.predictor.evaluate(s, out);
        } else if s > self.start {
            self.hints[index] = self.mesh.evaluate(s, self.hints[index], out);
        } else {
            self.equation.past(s, out)?;
        }
        Ok(())
    }
}
