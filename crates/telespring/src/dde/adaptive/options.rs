//! Options of the adaptive solver: tolerances, limits and declared break points.

use super::discontinuity::Discontinuity;
use crate::error::{InvalidInput, Result};

/// One tolerance for all components, or one per component.
#[derive(Debug, Clone, PartialEq)]
pub enum Tolerance {
    /// The same for all components.
    Uniform(f64),
    /// One per component.
    PerComponent(Vec<f64>),
}

impl From<f64> for Tolerance {
    /// The tolerance option from one number for all components.
    fn from(value: f64) -> Self {
        Self::Uniform(value)
    }
}

impl From<Vec<f64>> for Tolerance {
    /// The tolerance option from one number per component.
    fn from(values: Vec<f64>) -> Self {
        Self::PerComponent(values)
    }
}

impl Tolerance {
    /// Expands the tolerance option to one checked value per component.
    fn expand(&self, field: &str, dimension: usize, minimum: f64) -> Result<Vec<f64>> {
        let values = match self {
            Self::Uniform(value) => vec![*value; dimension],
            Self::PerComponent(values) => values.clone(),
        };
        if values.len() != dimension {
            return Err(InvalidInput::new(
                field,
                format!("{} value(s)", values.len()),
                format!("{dimension} values are required, one per component"),
                "Give one number for all components or one for each.",
            ));
        }
        for (i, &value) in values.iter().enumerate() {
            if !(value >= minimum && value.is_finite()) {
                let place = match self {
                    Self::Uniform(_) => field.to_owned(),
                    Self::PerComponent(_) => format!("{field}[{i}]"),
                };
                return Err(InvalidInput::new(
                    place,
                    value,
                    format!("a tolerance must be a finite number of at least {minimum:e}"),
                    "Give a tolerance that double precision can reach.",
                ));
            }
        }
        Ok(values)
    }
}

/// Tolerances, limits and declared break points. The local error of component i stays below `atol[i] +
/// rtol[i] |y_i|` in every step.
///
/// # Examples
///
/// ```
/// use telespring::dde::adaptive::{Discontinuity, Options};
///
/// let options = Options {
///     rtol: 1e-9.into(),
///     breakpoints: vec![Discontinuity::kink(1.0)],
///     ..Options::default()
/// };
/// assert_eq!(options.max_steps, 100_000);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Relative tolerance, at least 1e-13; by default 1e-6.
    pub rtol: Tolerance,
    /// Absolute tolerance in the components' units, above zero; by default 1e-9.
    pub atol: Tolerance,
    /// The maximum number of steps, accepted or rejected; by default 100 000.
    pub max_steps: usize,
    /// The first step to try, in the unit of time of the problem; chosen automatically if `None`.
    pub initial_step: Option<f64>,
    /// The longest step, in the unit of time of the problem; unlimited if `None`.
    pub max_step: Option<f64>,
    /// Break points that only the caller knows. Before the start: jumps and kinks of the history. After it:
    /// times at which the right-hand side or a delay switches (order 1) or has a kink (order 2). Steps end
    /// exactly on them. Callbacks receive a time a few roundings before such a point at the end of a step,
    /// and a few after it at the start, so the side to which they assign the point does not matter.
    pub breakpoints: Vec<Discontinuity>,
}

impl Default for Options {
    /// The default options of the adaptive solver.
    fn default() -> Self {
        Self {
            rtol: Tolerance::Uniform(1e-6),
            atol: Tolerance::Uniform(1e-9),
            max_steps: 100_000,
            initial_step: None,
            max_step: None,
            breakpoints: Vec::new(),
        }
    }
}

/// The checked options.
#[derive(Debug)]
pub(super) struct CheckedOptions {
    pub(super) rtol: Vec<f64>,
    pub(super) atol: Vec<f64>,
    pub(super) max_steps: usize,
    pub(super) initial_step: Option<f64>,
    pub(super) max_step: f64,
    pub(super) breakpoints: Vec<Discontinuity>,
}

impl Options {
    /// Checks the options of the adaptive solver.
    pub(super) fn check(&self, dimension: usize, start: f64) -> Result<CheckedOptions> {
        let rtol = self.rtol.expand("rtol", dimension, 1e-13)?;
        let atol = self.atol.expand("atol", dimension, f64::MIN_POSITIVE)?;
        for (field, step) in [("initial_step", self.initial_step), ("max_step", self.max_step)] {
            if let Some(step) = step
                && !(step > 0.0 && step.is_finite())
            {
                return Err(InvalidInput::new(
                    field,
                    step,
                    "a step must be a finite number above zero",
                    "Omit it for an automatic choice.",
                ));
            }
        }
        for (i, declared) in self.breakpoints.iter().enumerate() {
            let field = format!("breakpoints[{i}]");
            if !declared.time.is_finite() {
                return Err(InvalidInput::new(
                    field,
                    declared.time,
                    "a break point's time must be finite",
                    "Leave it out.",
                ));
            }
            if declared.time > start && declared.order == 0 {
                return Err(InvalidInput::new(
                    field,
                    format!("order 0 at t = {}", declared.time),
                    "after the start the order must be at least 1, since the solution is continuous there",
                    "Write order 1 for a right-hand side or a delay that switches.",
                ));
            }
        }
        Ok(CheckedOptions {
            rtol,
            atol,
            max_steps: self.max_steps,
            initial_step: self.initial_step,
            max_step: self.max_step.unwrap_or(f64::INFINITY),
            breakpoints: self.breakpoints.clone(),
        })
    }
}
