//! An adaptive solver for any right-hand side with delays.
//!
//! y'(t) = f(t, y(t), y(t − τ₁), …, y(t − τ_d)) with delays that are constant, functions of time or of time and
//! state, from a history for t ≤ t₀. It serves where the dyad is no longer linear (friction, saturation) or its
//! delay is not constant; for the linear dyad at constant delay [`linear`](super::linear) is exact and faster.
//!
//! | file | job |
//! |---|---|
//! | `equation`, `options` | what the caller states, and its checks |
//! | `interpolant` | the Runge-Kutta pair and the polynomial of one step |
//! | `discontinuity` | break points: time, order, how they travel |
//! | `crossing` | break points that come back through a varying delay |
//! | `history` | lookups of delayed values |
//! | `step` | one trial step, repeated where it looks into itself |
//! | `solver` | the loop over steps and its step size |
//! | `solution` | the polynomials of all steps, and how the computation ended |
//!
//! The method is the explicit pair of Dormand and Prince with its continuous extension, used as in RETARD
//! (Hairer, Nørsett and Wanner 1993, section II.17): steps end on break points, and a step longer than the delay
//! is repeated on its own polynomial until that settles.

mod crossing;
mod discontinuity;
mod equation;
mod history;
mod interpolant;
mod options;
mod solution;
mod solver;
mod step;

pub use discontinuity::Discontinuity;
pub use equation::{DelayKind, Delayed};
pub use options::{Options, Tolerance};
pub use solution::{Solution, Status};

use crate::error::{InvalidInput, Result};
use equation::{Equation, Interrupt};
use history::aside;

/// Solves y'(t) = f(t, y(t), y(t − τ₁), …, y(t − τ_d)) over `span`.
///
/// - `right_hand_side(t, y, delayed, out)` writes y'(t); `delayed[j][i]` is component i of y(t − τ_j).
/// - `history(t, out)` writes y(t) for t ≤ t₀. It is asked only there.
/// - `initial` is y(t₀) where it differs from the history's end (a jump); `None` takes the history at t₀. With
///   a value, the history's end is taken a few roundings before t₀, so it does not matter what the callback
///   answers at t₀ itself. `dimension` is the number of components.
/// - `span` is (t₀, t₁), t₁ > t₀.
///
/// Callbacks may fail; their error stops the computation and is handed back in [`Solution::failure`].
///
/// The solution is accurate to about the tolerance times the problem's own amplification. Break points travel
/// through constant delays exactly and through varying ones as roots of t − τ(t) = ξ, up to the order of the
/// method; a state-dependent one is landed on within the tolerance. A right-hand side that switches with the
/// state (Coulomb friction) is met by shorter steps; one that would hold the state on the switch (sticking) ends
/// with [`Status::TooManySteps`] or [`Status::StepTooSmall`] and should be smoothed. Derivatives of delayed
/// values (neutral equations) are not offered.
///
/// # Errors
///
/// [`InvalidInput`] for an empty or reversed span, no component, an `initial` of another length or not finite, a
/// negative constant delay and bad options. How the computation ended is [`Solution::status`].
///
/// # Examples
///
/// y'(t) = −y(t − 1) from y = 1: the value at t = 2 is −1/2.
///
/// ```
/// use telespring::dde::adaptive::{DelayKind, Options, Status, solve};
///
/// let solution = solve(
///     |_, _, delayed, out| {
///         out[0] = -delayed[0][0];
///         Ok::<(), std::convert::Infallible>(())
///     },
///     vec![DelayKind::Constant(1.0)],
///     |_, out| {
///         out[0] = 1.0;
///         Ok(())
///     },
///     1,
///     None,
///     (0.0, 2.0),
///     &Options::default(),
/// )?;
/// assert_eq!(solution.status, Status::Completed);
/// let mut y = [0.0];
/// solution.evaluate(2.0, &mut y)?;
/// assert!((y[0] + 0.5).abs() < 1e-12);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
///
/// # Source
///
/// E. Hairer, S. P. Nørsett and G. Wanner (1993), "Solving Ordinary Differential Equations I", 2nd ed.,
/// sections II.4 to II.6 and II.17; W. H. Enright and H. Hayashi (1997), "A delay differential equation solver
/// based on a continuous Runge-Kutta method with defect control", Numer. Algorithms 16, 349-364, for steps that
/// look into themselves.
pub fn solve<'a, E, F, H>(
    right_hand_side: F,
    delays: Vec<DelayKind<'a, E>>,
    history: H,
    dimension: usize,
    initial: Option<&[f64]>,
    span: (f64, f64),
    options: &Options,
) -> Result<Solution<E>>
where
    F: FnMut(f64, &[f64], Delayed<'_>, &mut [f64]) -> std::result::Result<(), E>,
    H: FnMut(f64, &mut [f64]) -> std::result::Result<(), E>,
{
    let (start, end) = span;
    if !(start.is_finite() && end.is_finite() && end > start) {
        return Err(InvalidInput::new(
            "span",
            format!("({start}, {end})"),
            "the span must be two finite times, the second after the first",
            "Give the start and the end in this order.",
        ));
    }
    check_initial(dimension, initial)?;
    equation::check_delays(&delays)?;
    let checked = options.check(dimension, start)?;
    let state_slack = checked.rtol.iter().copied().fold(0.0, f64::max);
    let mut equation = Equation { right_hand_side, delays, history, dimension, evaluations: 0, state_slack };
    let (begin, state) = match begin(&mut equation, initial, span) {
        Ok(found) => found,
        Err(interrupt) => return Ok(not_begun(interrupt, start, dimension)),
    };
    Ok(solver::Solver::new(equation, state, begin, end, checked).run())
}

fn check_initial(dimension: usize, initial: Option<&[f64]>) -> Result<()> {
    if dimension == 0 {
        return Err(InvalidInput::new(
            "dimension",
            0,
            "an equation has at least one component",
            "Give the number of components.",
        ));
    }
    let Some(values) = initial else { return Ok(()) };
    if values.len() != dimension {
        return Err(InvalidInput::new(
            "initial",
            format!("{} value(s)", values.len()),
            format!("one value per component is needed, that is {dimension}"),
            "Give the state at the start, or leave it out to take the history's.",
        ));
    }
    match values.iter().position(|v| !v.is_finite()) {
        Some(i) => Err(InvalidInput::new(
            format!("initial[{i}]"),
            values[i],
            "the state at the start must be finite",
            "Replace the missing value by a number.",
        )),
        None => Ok(()),
    }
}

/// The break at the start with the state there: a jump where the initial state differs from the history's end.
fn begin<E, F, H>(
    equation: &mut Equation<'_, E, F, H>,
    initial: Option<&[f64]>,
    (start, end): (f64, f64),
) -> std::result::Result<(Discontinuity, Vec<f64>), Interrupt<E>>
where
    F: FnMut(f64, &[f64], Delayed<'_>, &mut [f64]) -> std::result::Result<(), E>,
    H: FnMut(f64, &mut [f64]) -> std::result::Result<(), E>,
{
    let mut state = vec![0.0; equation.dimension];
    let Some(values) = initial else {
        equation.past(start, &mut state)?;
        return Ok((Discontinuity::kink(start), state));
    };
    equation.past(aside(start, -1.0, end - start), &mut state)?;
    let order = u32::from(state == values);
    state.copy_from_slice(values);
    Ok((Discontinuity { time: start, order }, state))
}

/// The solution where not even the first state could be had.
fn not_begun<E>(interrupt: Interrupt<E>, start: f64, dimension: usize) -> Solution<E> {
    let (status, failure) = match interrupt {
        Interrupt::Callback(error) => (Status::Stopped { at: start }, Some(error)),
        Interrupt::NonFinite => (Status::NonFinite { at: start }, None),
        Interrupt::Delay { at, delay, value } => (Status::InvalidDelay { at, delay, value }, None),
    };
    Solution {
        status,
        failure,
        steps: 0,
        rejected: 0,
        evaluations: 0,
        discontinuities: Vec::new(),
        mesh: solution::Mesh::new(start, dimension),
        initial: vec![f64::NAN; dimension],
    }
}
