//! The solution of a delay differential equation: the polynomials of all steps and the status.

use super::discontinuity::Discontinuity;
use super::interpolant::{self, COEFFICIENTS};
use crate::error::{InvalidInput, Result};

/// How a computation ended. The solution is valid up to [`Solution::end`] for every status.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Status {
    /// The whole span was solved.
    Completed,
    /// The tolerance required a step too small to resolve. Usual causes: a solution that diverges, or a
    /// right-hand side that switches back and forth without end.
    StepTooSmall {
        /// The time reached.
        at: f64,
    },
    /// [`Options::max_steps`](super::Options::max_steps) was reached.
    TooManySteps {
        /// The time reached.
        at: f64,
    },
    /// The right-hand side, the history or the solution was infinite or not a number at any step size.
    NonFinite {
        /// The time reached.
        at: f64,
    },
    /// A delay was negative or not a number.
    InvalidDelay {
        /// The time of the evaluation.
        at: f64,
        /// The index of the delay.
        delay: usize,
        /// The value of the delay.
        value: f64,
    },
    /// A callback failed; its error is in [`Solution::failure`].
    Stopped {
        /// The time reached.
        at: f64,
    },
}

impl std::fmt::Display for Status {
    /// Writes the status of a solution.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Completed => write!(f, "the whole span was solved"),
            Self::StepTooSmall { at } => {
                write!(
                    f,
                    "the step became too small at t = {at}: loosen the tolerance, declare the break points, or \
                     smooth a switch that never settles"
                )
            }
            Self::TooManySteps { at } => {
                write!(f, "the step limit was reached at t = {at}: raise max_steps or loosen the tolerance")
            }
            Self::NonFinite { at } => {
                write!(f, "the solution or its derivative is not finite after t = {at}")
            }
            Self::InvalidDelay { at, delay, value } => {
                write!(f, "delay {delay} is {value} at t = {at}: a delay must be a number of 0 or more")
            }
            Self::Stopped { at } => write!(f, "a callback failed after t = {at}"),
        }
    }
}

/// The polynomials of consecutive steps.
#[derive(Debug, Clone)]
pub(super) struct Mesh {
    dimension: usize,
    knots: Vec<f64>,
    coefficients: Vec<f64>,
}

impl Mesh {
    /// A mesh of a solution, without steps yet.
    pub(super) fn new(start: f64, dimension: usize) -> Self {
        Self { dimension, knots: vec![start], coefficients: Vec::new() }
    }

    /// Appends the polynomial of a step to the mesh of the solution.
    pub(super) fn push(&mut self, end: f64, coefficients: &[f64]) {
        self.knots.push(end);
        self.coefficients.extend_from_slice(coefficients);
    }

    /// The number of steps in the mesh of the solution.
    pub(super) fn steps(&self) -> usize {
        self.knots.len() - 1
    }

    /// The polynomial of step `index` of the solution's mesh, its start and its width.
    pub(super) fn step(&self, index: usize) -> (&[f64], f64, f64) {
        let length = COEFFICIENTS * self.dimension;
        let (start, end) = (self.knots[index], self.knots[index + 1]);
        (&self.coefficients[index * length..(index + 1) * length], start, end - start)
    }

    /// The index of the solution's step that contains `t`; a knot belongs to the step that starts there. `hint` is
    /// tried first.
    fn locate(&self, t: f64, hint: usize) -> usize {
        let last = self.steps() - 1;
        for guess in [hint, hint + 1] {
            if guess <= last && self.knots[guess] <= t && t < self.knots[guess + 1] {
                return guess;
            }
        }
        self.knots[1..=last].partition_point(|&knot| knot <= t)
    }

    /// The solution at `t`, which must lie within the steps; returns the index of the step as the next
    /// hint.
    pub(super) fn evaluate(&self, t: f64, hint: usize, out: &mut [f64]) -> usize {
        let index = self.locate(t, hint);
        let (coefficients, start, width) = self.step(index);
        interpolant::evaluate_polynomial(coefficients, (t - start) / width, out);
        index
    }
}

/// The solution of a delay differential equation as a continuous function, with statistics of its
/// computation.
#[derive(Debug, Clone)]
pub struct Solution<E> {
    /// How the computation ended.
    pub status: Status,
    /// The error of the callback that stopped the computation.
    pub failure: Option<E>,
    /// The number of accepted steps.
    pub steps: usize,
    /// The number of rejected steps.
    pub rejected: usize,
    /// The number of evaluations of the right-hand side.
    pub evaluations: usize,
    /// The break points at which steps ended, from the start, sorted by time.
    pub discontinuities: Vec<Discontinuity>,
    pub(super) mesh: Mesh,
    pub(super) initial: Vec<f64>,
}

impl<E> Solution<E> {
    /// The number of components of the solution.
    pub fn dimension(&self) -> usize {
        self.initial.len()
    }

    /// The first time of the solution.
    pub fn start(&self) -> f64 {
        self.mesh.knots[0]
    }

    /// The last time of the solution: the end of the span if the status is [`Status::Completed`], else the
    /// end of the last accepted step.
    pub fn end(&self) -> f64 {
        *self.mesh.knots.last().unwrap_or(&f64::NAN)
    }

    /// The knots of the solution: the times at which steps start and end.
    pub fn knots(&self) -> &[f64] {
        &self.mesh.knots
    }

    /// The polynomials of all steps of the solution, one step after the other.
    pub fn coefficients(&self) -> &[f64] {
        &self.mesh.coefficients
    }

    /// The state at the start of the solution.
    pub fn initial(&self) -> &[f64] {
        &self.initial
    }

    /// The same solution again from its status, its numbers of steps, rejected steps and evaluations, and its
    /// [`discontinuities`](Self::discontinuities), [`knots`](Self::knots),
    /// [`coefficients`](Self::coefficients) and [`initial`](Self::initial) state.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if the numbers of knots, coefficients and components do not belong together.
    pub fn restore(
        status: Status,
        [steps, rejected, evaluations]: [usize; 3],
        discontinuities: Vec<Discontinuity>,
        knots: Vec<f64>,
        coefficients: Vec<f64>,
        initial: Vec<f64>,
    ) -> Result<Self> {
        let dimension = initial.len();
        let expected = knots.len().saturating_sub(1) * dimension * COEFFICIENTS;
        if knots.is_empty() || dimension == 0 || coefficients.len() != expected {
            return Err(InvalidInput::new(
                "coefficients",
                format!("{} value(s)", coefficients.len()),
                format!("{expected} values are required, {COEFFICIENTS} per component and step"),
                "Pass what the accessors of a solution returned.",
            ));
        }
        let mesh = Mesh { dimension, knots, coefficients };
        Ok(Self { status, failure: None, steps, rejected, evaluations, discontinuities, mesh, initial })
    }

    /// Checks that a time lies within the solution and an output array has the right length.
    fn check(&self, t: f64, length: usize, expected: usize) -> Result<()> {
        if !(self.start()..=self.end()).contains(&t) {
            return Err(InvalidInput::new(
                "t",
                t,
                format!("the solution is known from {} to {}", self.start(), self.end()),
                "Choose a time in that span; the status says why it ends there.",
            ));
        }
        if length != expected {
            return Err(InvalidInput::new(
                "out",
                format!("{length} value(s)"),
                format!("{expected} are required"),
                "Give an array with one value per component and time.",
            ));
        }
        Ok(())
    }

    /// Writes y(`t`), one value per component.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if `t` is outside [`start`](Self::start) to [`end`](Self::end) or `out` has the
    /// wrong length.
    pub fn evaluate(&self, t: f64, out: &mut [f64]) -> Result<()> {
        self.check(t, out.len(), self.dimension())?;
        if self.mesh.steps() == 0 {
            out.copy_from_slice(&self.initial);
        } else {
            self.mesh.evaluate(t, 0, out);
        }
        Ok(())
    }

    /// Writes y'(`t`), the derivative of the step polynomial, one order less accurate than the value. At a
    /// kink it is the right derivative.
    ///
    /// # Errors
    ///
    /// As [`evaluate`](Self::evaluate), and if no step was accepted.
    pub fn derivative(&self, t: f64, out: &mut [f64]) -> Result<()> {
        self.check(t, out.len(), self.dimension())?;
        if self.mesh.steps() == 0 {
            return Err(InvalidInput::new(
                "t",
                t,
                "the derivative is known only after an accepted step",
                "The status gives the reason.",
            ));
        }
        let (coefficients, start, width) = self.mesh.step(self.mesh.locate(t, 0));
        interpolant::differentiate_polynomial(coefficients, (t - start) / width, width, out);
        Ok(())
    }

    /// The solution at many times as one array, time by time (`times.len()` rows, one column per
    /// component). Ascending times are fastest.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] naming the first time outside the solution.
    pub fn sample(&self, times: &[f64]) -> Result<Vec<f64>> {
        let dimension = self.dimension();
        let mut out = vec![0.0; times.len() * dimension];
        let mut hint = 0;
        for (i, (&t, row)) in times.iter().zip(out.chunks_exact_mut(dimension)).enumerate() {
            self.check(t, dimension, dimension).map_err(|mut refused| {
                refused.field = format!("times[{i}]");
                refused
            })?;
            if self.mesh.steps() == 0 {
                row.copy_from_slice(&self.initial);
            } else {
                hint = self.mesh.evaluate(t, hint, row);
            }
        }
        Ok(out)
    }
}
