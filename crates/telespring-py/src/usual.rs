//! The check that a value is one that laboratories have.

use pyo3::prelude::*;
use telespring::InvalidInput;
use telespring::quantity::{self, Quantity};

use crate::errors::Outcome;

/// The quantities that are checked outside a study, by name.
static QUANTITIES: [(&str, Quantity); 13] = [
    ("mass", quantity::MASS),
    ("added mass", quantity::ADDED_MASS),
    ("damping", quantity::DAMPING),
    ("operator damping", quantity::OPERATOR_DAMPING),
    ("stiffness", quantity::STIFFNESS),
    ("ground stiffness", quantity::GROUND_STIFFNESS),
    ("delay", quantity::DELAY),
    ("time span", quantity::SPAN),
    ("controller period", quantity::CONTROLLER_PERIOD),
    ("rate", quantity::RATE),
    ("force", quantity::FORCE),
    ("duration", quantity::DURATION),
    ("decay rate", quantity::DECAY_RATE),
];

/// Check that laboratories have such a value of a quantity, and return it.
///
/// A study makes this check by itself; functions of the theory take whatever can be computed.
///
/// Parameters
/// ----------
/// quantity : str
///     Its name, such as "delay".
/// field : str
///     What a refusal calls the value.
/// value : float
///     In SI units.
///
/// Raises
/// ------
/// InvalidInput
///     If the value cannot be computed with, or no laboratory has it; the remedy names the unit that was
///     probably meant.
///
/// Examples
/// --------
/// >>> from telespring._core import check_usual
/// >>> check_usual("delay", "delay", 0.08)
/// 0.08
/// >>> check_usual("delay", "delay", 80.0)
/// Traceback (most recent call last):
/// telespring._errors.InvalidInput: delay = 80 s: a delay is usually up to 2 s. Did you mean 80 ms? Write 0.08. ...
#[pyfunction]
pub fn check_usual(quantity: &str, field: &str, value: f64) -> Outcome<f64> {
    let kind = named(quantity)?;
    kind.check(field, value)?;
    Ok(kind.check_usual(field, value)?)
}

/// The smallest and the largest magnitude, besides 0, that laboratories have of a quantity, in SI units.
///
/// Parameters
/// ----------
/// quantity : str
///     Its name, as in `check_usual`.
///
/// Returns
/// -------
/// tuple of two floats
///     `check_usual` accepts what lies between them, both included; 0 and infinity if every value is usual.
///
/// Raises
/// ------
/// InvalidInput
///     If there is no such quantity.
///
/// Examples
/// --------
/// >>> from telespring._core import usual_range
/// >>> usual_range("stiffness")
/// (0.1, 20000.0)
#[pyfunction]
pub fn usual_range(quantity: &str) -> Outcome<(f64, f64)> {
    Ok(named(quantity)?.usual_range().unwrap_or((0.0, f64::INFINITY)))
}

/// A quantity by its name.
fn named(quantity: &str) -> Outcome<&'static Quantity> {
    match QUANTITIES.iter().find(|(name, _)| *name == quantity) {
        Some((_, kind)) => Ok(kind),
        None => {
            let names = QUANTITIES.map(|(name, _)| name).join(", ");
            let allowed = format!("the quantities are {names}");
            Err(InvalidInput::new("quantity", quantity, allowed, "Choose one of them.").into())
        }
    }
}
