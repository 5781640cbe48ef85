//! An adaptive solver for delay differential equations with any right-hand side.
//!
//! y'(t) = f(t, y(t), y(t − τ₁), …, y(t − τ_d)) with delays that are constant or depend on time or on time
//! and state, from a history for t ≤ t₀. Use it if the dyad is nonlinear (friction, saturation) or its
//! delay varies; for the linear dyad at constant delay [`linear`](super::linear) is exact and faster.
//!
//! | file | job |
//! |---|---|
//! | `equation`, `options` | the problem as given by the caller, and its checks |
//! | `interpolant` | the Runge-Kutta pair and the polynomial of one step |
//! | `discontinuity` | break points: time, order, propagation |
//! | `crossing` | break points that propagate through a varying delay |
//! | `history` | lookups of delayed states |
//! | `step` | one attempted step, iterated if it overlaps its own delay |
//! | `solver` | the loop over steps and its step size |
//! | `solution` | the polynomials of all steps and the status |
//!
//! The method is the explicit Dormand–Prince pair with its continuous extension, used as in RETARD (Hairer,
//! Nørsett and Wanner 1993, section II.17): steps end on break points, and a step longer than the delay is
//! iterated on its own polynomial until it converges.

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
use history::offset_by_roundings;

/// Solves y'(t) = f(t, y(t), y(t − τ₁), …, y(t − τ_d)) over `span`.
///
/// - `right_hand_side(t, y, delayed, out)` writes y'(t); `delayed[j][i]` is component i of y(t − τ_j).
/// - `history(t, out)` writes y(t) for t ≤ t₀. It is called only there.
/// - `initial` is y(t₀) if it differs from the end of the history (a jump); `None` uses the history at t₀.
///   With a value, the end of the history is evaluated a few roundings before t₀, so the callback's value
///   at t₀ itself does not matter. `dimension` is the number of components.
/// - `span` is (t₀, t₁), t₁ > t₀.
///
/// Callbacks may fail; their error stops the computation and is returned in [`Solution::failure`].
///
/// The error is about the tolerance times the amplification of the problem itself. Break points propagate
/// exactly through constant delays and as roots of t − τ(t) = ξ through varying ones, up to the order of
/// the method; those of a state-dependent delay are located within the tolerance. A right-hand side that
/// switches with the state (Coulomb friction) leads to shorter steps; one that keeps the state on the
/// switch (sticking) ends with [`Status::TooManySteps`] or [`Status::StepTooSmall`] and should be smoothed.
/// Derivatives of delayed states (neutral equations) are not supported.
///
/// # Errors
///
/// [`InvalidInput`] for an empty or reversed span, zero components, an `initial` of the wrong length or not
/// finite, a negative constant delay, or invalid options. [`Solution::status`] says how the computation
/// ended.
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
/// sections II.4 to II.6 and II.17; W. H. Enright and H. Hayashi (1997), "A delay differential equation
/// solver based on a continuous Runge-Kutta method with defect control", Numer. Algorithms 16, 349-364, for
/// steps longer than the delay.
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
            "Give the start first, then the end.",
        ));
    }
    check_initial(dimension, initial)?;
    equation::check_constant_delays(&delays)?;
    let checked = options.check(dimension, start)?;
    let state_slack = checked.rtol.iter().copied().fold(0.0, f64::max);
    let mut equation = Equation { right_hand_side, delays, history, dimension, evaluations: 0, state_slack };
    let (first_break, state) = match initial_discontinuity(&mut equation, initial, span) {
        Ok(pair) => pair,
        Err(interrupt) => return Ok(failed_at_start(interrupt, start, dimension)),
    };
    Ok(solver::Solver::new(equation, state, first_break, end, checked).run())
}

/// Checks the dimension and the initial state of a delay differential equation.
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
            format!("{dimension} values are required, one per component"),
            "Give the state at the start, or omit it to use the history.",
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

/// The break point and the state at the start: a jump if the initial state differs from the end of the
/// history.
fn initial_discontinuity<E, F, H>(
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
        equation.history_at(start, &mut state)?;
        return Ok((Discontinuity::kink(start), state));
    };
    equation.history_at(offset_by_roundings(start, -1.0, end - start), &mut state)?;
    let order = u32::from(state == values);
    state.copy_from_slice(values);
    Ok((Discontinuity { time: start, order }, state))
}

/// The solution if the equation cannot be evaluated at the start: no steps.
fn failed_at_start<E>(interrupt: Interrupt<E>, start: f64, dimension: usize) -> Solution<E> {
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
