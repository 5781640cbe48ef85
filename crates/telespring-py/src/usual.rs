//! The check that a value is one that laboratories have.

use pyo3::prelude::*;
use telespring::InvalidInput;
use telespring::quantity::{self, Quantity};

use crate::errors::Outcome;

/// The quantities that are checked outside a study, by name.
const QUANTITIES: [(&str, Quantity); 13] = [
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
    let Some((_, kind)) = QUANTITIES.iter().find(|(name, _)| *name == quantity) else {
        let names = QUANTITIES.map(|(name, _)| name).join(", ");
        let allowed = format!("the quantities are {names}");
        return Err(InvalidInput::new("quantity", quantity, allowed, "Choose one of them.").into());
    };
    kind.check(field, value)?;
    Ok(kind.check_usual(field, value)?)
}
