//! The sections `[operator1]` and `[operator2]`.

use super::entry::Span;
use super::reader::Reader;
use super::robot::check_axis_count;
use crate::error::{InvalidInput, Result};
use crate::model::Operator;
use crate::quantity;
use crate::verdicts::OperatorRange;

/// Reads the range of one operator; a missing section means a free handle.
pub(super) fn read_operator(reader: &Reader<'_>, section: &str, axes: usize) -> Result<OperatorRange> {
    let keys = [
        ("mass", quantity::ADDED_MASS),
        ("damping", quantity::OPERATOR_DAMPING),
        ("stiffness", quantity::GROUND_STIFFNESS),
    ];
    let mut spans = Vec::with_capacity(3);
    for (key, quantity) in keys {
        spans.push(match reader.get(section, key) {
            None => vec![Span { low: 0.0, high: 0.0 }; axes],
            Some(entry) => {
                let values = entry.per_axis(quantity, true)?;
                check_axis_count(&entry, &values, axes)?;
                values.spread(axes)
            }
        });
    }
    let end = |end: fn(&Span) -> f64| {
        let mut values = spans.iter().map(|spans| spans.iter().map(end).collect::<Vec<f64>>());
        let mut next = || values.next().unwrap_or_default();
        Operator::new(next(), next(), next())
    };
    let place = |error: InvalidInput| reader.place(section, error);
    let (low, high) = (end(|span| span.low).map_err(place)?, end(|span| span.high).map_err(place)?);
    OperatorRange::new(low, high).map_err(place)
}

/// The range of an operator together with the robot's own spring to the ground (N/m per axis): the equations
/// have one place for both.
pub(super) fn with_spring(hand: &OperatorRange, spring: &[f64]) -> Result<OperatorRange> {
    let sum = |operator: &Operator| {
        let stiffness = operator.stiffness().iter().zip(spring).map(|(own, more)| own + more);
        Operator::new(operator.mass().to_vec(), operator.damping().to_vec(), stiffness.collect())
    };
    OperatorRange::new(sum(hand.low())?, sum(hand.high())?)
}
