//! The delay differential equation: right-hand side, delays, history, and their failures.

use super::discontinuity::resolution;
use crate::error::{InvalidInput, Result};

/// A delay computed by a callback from time and state.
type StateDelay<'a, E> = Box<dyn FnMut(f64, &[f64]) -> std::result::Result<f64, E> + 'a>;
/// A delay computed by a callback from time.
type TimeDelay<'a, E> = Box<dyn FnMut(f64) -> std::result::Result<f64, E> + 'a>;

/// One delay τ of the equation, never negative.
///
/// # Examples
///
/// A delay that oscillates around 0.2 and one that grows with the state:
///
/// ```
/// use telespring::dde::adaptive::DelayKind;
///
/// let swinging: DelayKind<'_, String> = DelayKind::time(|t| 0.2 + 0.05 * t.sin());
/// let growing: DelayKind<'_, String> = DelayKind::state(|_, y| 0.1 + y[0].abs());
/// let may_fail: DelayKind<'_, String> = DelayKind::Time(Box::new(|_| Err("no packet".to_owned())));
/// # let _ = (swinging, growing, may_fail);
/// ```
pub enum DelayKind<'a, E> {
    /// Constant. Break points propagate through it exactly.
    Constant(f64),
    /// A function of time. Break points are roots of t − τ(t) = ξ. Where τ itself jumps or has a kink,
    /// declare the time in [`Options::breakpoints`](super::Options::breakpoints).
    Time(TimeDelay<'a, E>),
    /// A function of time and state, τ(t, y(t)).
    State(StateDelay<'a, E>),
}

impl<'a, E> DelayKind<'a, E> {
    /// A delay as a function of time that cannot fail; [`DelayKind::Time`] takes one that can.
    pub fn time(mut delay: impl FnMut(f64) -> f64 + 'a) -> Self {
        Self::Time(Box::new(move |t| Ok(delay(t))))
    }

    /// A delay as a function of time and state that cannot fail; [`DelayKind::State`] takes one that can.
    pub fn state(mut delay: impl FnMut(f64, &[f64]) -> f64 + 'a) -> Self {
        Self::State(Box::new(move |t, y| Ok(delay(t, y))))
    }
}

impl<E> std::fmt::Debug for DelayKind<'_, E> {
    /// Writes the kind of delay of an equation.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Constant(delay) => write!(f, "Constant({delay})"),
            Self::Time(_) => write!(f, "Time(..)"),
            Self::State(_) => write!(f, "State(..)"),
        }
    }
}

/// The delayed states passed to the right-hand side: `delayed[j][i]` is component i of y(t − τ_j).
#[derive(Debug, Clone, Copy)]
pub struct Delayed<'a> {
    values: &'a [f64],
    dimension: usize,
}

impl<'a> Delayed<'a> {
    /// All delayed values in an equation as one array, one row per delay and one column per component.
    pub fn as_slice(&self) -> &'a [f64] {
        self.values
    }
}

impl std::ops::Index<usize> for Delayed<'_> {
    type Output = [f64];

    /// The delayed values of one delay of the equation.
    fn index(&self, delay: usize) -> &[f64] {
        &self.values[delay * self.dimension..(delay + 1) * self.dimension]
    }
}

/// Why an evaluation failed.
#[derive(Debug)]
pub(super) enum Interrupt<E> {
    /// A callback failed.
    Callback(E),
    /// A callback returned an infinity or a NaN.
    NonFinite,
    /// A delay is negative or not a number.
    Delay { at: f64, delay: usize, value: f64 },
}

/// The equation with its callbacks, which counts and checks every evaluation.
pub(super) struct Equation<'a, E, F, H> {
    pub(super) right_hand_side: F,
    pub(super) delays: Vec<DelayKind<'a, E>>,
    pub(super) history: H,
    pub(super) dimension: usize,
    pub(super) evaluations: usize,
    /// How far below zero an error of the state may move a state-dependent delay, relative to the time.
    pub(super) state_slack: f64,
}

impl<'a, E, F, H> Equation<'a, E, F, H>
where
    F: FnMut(f64, &[f64], Delayed<'_>, &mut [f64]) -> std::result::Result<(), E>,
    H: FnMut(f64, &mut [f64]) -> std::result::Result<(), E>,
{
    /// The derivative y' by the equation at `t`; `delayed` has one row per delay.
    pub(super) fn slope(
        &mut self,
        t: f64,
        y: &[f64],
        delayed: &[f64],
        out: &mut [f64],
    ) -> std::result::Result<(), Interrupt<E>> {
        self.evaluations += 1;
        let delayed = Delayed { values: delayed, dimension: self.dimension };
        (self.right_hand_side)(t, y, delayed, out).map_err(Interrupt::Callback)?;
        check_finite(out)
    }

    /// The history of the equation at `t`.
    pub(super) fn history_at(&mut self, t: f64, out: &mut [f64]) -> std::result::Result<(), Interrupt<E>> {
        (self.history)(t, out).map_err(Interrupt::Callback)?;
        check_finite(out)
    }

    /// The delayed argument t − τ of delay `index` in the equation. `nominal` is the mesh time and `seen` the
    /// time passed to callbacks, which differs by a few roundings at declared breaks. A state-dependent delay
    /// may be negative in an attempted step with a rough state: its argument is returned unchanged and
    /// checked when the step is accepted. Any other negative delay fails at once; a rounding below zero
    /// counts as zero.
    pub(super) fn argument(
        &mut self,
        index: usize,
        nominal: f64,
        seen: f64,
        y: &[f64],
    ) -> std::result::Result<f64, Interrupt<E>> {
        let (delay, rough) = match &mut self.delays[index] {
            DelayKind::Constant(delay) => return Ok(nominal - *delay),
            DelayKind::Time(delay) => (delay(seen).map_err(Interrupt::Callback)?, false),
            DelayKind::State(delay) => (delay(seen, y).map_err(Interrupt::Callback)?, true),
        };
        if rough && !delay.is_finite() {
            return Err(Interrupt::NonFinite);
        }
        if !delay.is_finite() || (!rough && delay < -resolution(seen)) {
            return Err(Interrupt::Delay { at: nominal, delay: index, value: delay });
        }
        Ok(if rough { nominal - delay } else { nominal - delay.max(0.0) })
    }

    /// Checks the equation's state-dependent delays at the end of a step to be accepted.
    pub(super) fn check_state_delays(&mut self, t: f64, y: &[f64]) -> std::result::Result<(), Interrupt<E>> {
        for index in 0..self.delays.len() {
            if matches!(self.delays[index], DelayKind::State(_)) {
                let value = t - self.argument(index, t, t, y)?;
                if value < -self.state_slack * t.abs().max(f64::MIN_POSITIVE) {
                    return Err(Interrupt::Delay { at: t, delay: index, value });
                }
            }
        }
        Ok(())
    }

    /// Whether delay `index` of the equation depends on time alone.
    pub(super) fn is_time_dependent(&self, index: usize) -> bool {
        matches!(self.delays[index], DelayKind::Time(_))
    }

    /// Whether delay `index` of the equation depends on the state.
    pub(super) fn is_state_dependent(&self, index: usize) -> bool {
        matches!(self.delays[index], DelayKind::State(_))
    }

    /// The nonzero constant delays of the equation; a zero delay propagates no break.
    pub(super) fn constant_delays(&self) -> Vec<f64> {
        self.delays
            .iter()
            .filter_map(|delay| match delay {
                DelayKind::Constant(delay) if *delay > 0.0 => Some(*delay),
                _ => None,
            })
            .collect()
    }
}

/// Checks that a callback of the equation returned finite values.
fn check_finite<E>(values: &[f64]) -> std::result::Result<(), Interrupt<E>> {
    if values.iter().all(|v| v.is_finite()) { Ok(()) } else { Err(Interrupt::NonFinite) }
}

/// Rejects constant delays of an equation that are negative or not finite.
pub(super) fn check_constant_delays<E>(delays: &[DelayKind<'_, E>]) -> Result<()> {
    for (j, delay) in delays.iter().enumerate() {
        if let DelayKind::Constant(value) = delay
            && !(*value >= 0.0 && value.is_finite())
        {
            return Err(InvalidInput::new(
                format!("delays[{j}]"),
                value,
                "a delay must be a finite number of 0 or more",
                "Check the sign: y(t - delay) looks back for a positive delay.",
            ));
        }
    }
    Ok(())
}
