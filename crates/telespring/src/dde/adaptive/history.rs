//! The solution history: lookups of delayed states.

use super::discontinuity::resolution;
use super::equation::{Delayed, Equation, Interrupt};
use super::interpolant;
use super::solution::Mesh;

/// The distance from a jump, in roundings, at which callbacks are evaluated on one side of it.
const ASIDE: f64 = 4.0 * f64::EPSILON;

/// Moves a lookup time `t` in the history by a few roundings to the later (`direction` 1) or earlier side
/// (−1); `scale` sets the unit of time near zero.
pub(super) fn offset_by_roundings(t: f64, direction: f64, scale: f64) -> f64 {
    t + direction * ASIDE * t.abs().max(scale)
}

/// A polynomial that predicts the current step for lookups within it.
#[derive(Debug, Default)]
pub(super) struct Predictor {
    pub(super) coefficients: Vec<f64>,
    pub(super) origin: f64,
    pub(super) width: f64,
}

impl Predictor {
    /// The state at `t` that continues the history within the current step.
    pub(super) fn evaluate(&self, t: f64, out: &mut [f64]) {
        interpolant::evaluate_polynomial(&self.coefficients, (t - self.origin) / self.width, out);
    }
}

/// The equation with its solution so far: everything an evaluation of the derivative needs.
pub(super) struct StateHistory<'a, E, F, H> {
    pub(super) equation: Equation<'a, E, F, H>,
    pub(super) mesh: Mesh,
    pub(super) initial: Vec<f64>,
    pub(super) start: f64,
    /// Times at which the history, or its junction with the solution, jumps.
    pub(super) jumps: Vec<f64>,
    pub(super) predictor: Predictor,
    /// The current time, from which the predictor is used.
    pub(super) here: f64,
    /// The delayed argument of each delay in the middle of the step, which decides the side of a jump.
    pub(super) middle: Vec<f64>,
    /// The distance within which a state-dependent argument counts as on a jump.
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
    /// An empty solution history at the start.
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

    /// The rounding within which the argument `s` of delay `index` at time `t` coincides with a break.
    pub(super) fn slack(&self, index: usize, t: f64, s: f64) -> f64 {
        let rounding = resolution(t.abs().max(s.abs()));
        if self.equation.is_state_dependent(index) { rounding.max(self.state_slack) } else { rounding }
    }

    /// Chooses, for the step from the current time to `end`, the side of each jump that it uses.
    pub(super) fn choose_jump_sides(
        &mut self,
        end: f64,
        y: &[f64],
        slope: &[f64],
    ) -> Result<(), Interrupt<E>> {
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

    /// The derivative y' at the mesh time `nominal` from the solution history; callbacks get `seen`.
    pub(super) fn slope(
        &mut self,
        nominal: f64,
        seen: f64,
        y: &[f64],
        out: &mut [f64],
    ) -> Result<(), Interrupt<E>> {
        let mut delayed = std::mem::take(&mut self.delayed);
        let result = self
            .gather_delayed_states(nominal, seen, y, &mut delayed)
            .and_then(|()| self.equation.slope(seen, y, &delayed, out));
        self.delayed = delayed;
        result
    }

    /// Fills one row per delay with the delayed state from the solution history.
    fn gather_delayed_states(
        &mut self,
        nominal: f64,
        seen: f64,
        y: &[f64],
        delayed: &mut [f64],
    ) -> Result<(), Interrupt<E>> {
        for (index, row) in delayed.chunks_exact_mut(self.equation.dimension).enumerate() {
            let argument = self.equation.argument(index, nominal, seen, y)?;
            if argument >= nominal {
                // Without delay, take the state itself, so that the step need not be iterated.
                row.copy_from_slice(y);
            } else {
                self.delayed_state(index, nominal, argument, row)?;
            }
        }
        Ok(())
    }

    /// The state in the solution history at the argument `s` of delay `index`, for an evaluation at `t`.
    fn delayed_state(&mut self, index: usize, t: f64, s: f64, out: &mut [f64]) -> Result<(), Interrupt<E>> {
        let slack = self.slack(index, t, s);
        if let Some(&jump) = self.jumps.iter().find(|&&jump| (s - jump).abs() <= slack) {
            let later = self.middle[index] > jump;
            if later && jump == self.start {
                out.copy_from_slice(&self.initial);
                return Ok(());
            }
            let scale = (self.predictor.width).abs();
            return self
                .equation
                .history_at(offset_by_roundings(jump, if later { 1.0 } else { -1.0 }, scale), out);
        }
        if s > self.here {
            self.looked_ahead = true;
            self.predictor.evaluate(s, out);
        } else if s > self.start {
            self.hints[index] = self.mesh.evaluate(s, self.hints[index], out);
        } else {
            self.equation.history_at(s, out)?;
        }
        Ok(())
    }
}
