//! The sections that only the verdicts need: operators, network and controllers.

use super::entry::Span;
use super::reader::Reader;
use super::robot::check_count;
use crate::criteria::verdicts::{Network, OperatorRange};
use crate::error::{InvalidInput, Result};
use crate::model::{Delay, Operator};
use crate::quantity;

/// A value that is 0 where it is not given.
pub(super) fn optional(
    reader: &Reader<'_>,
    section: &str,
    key: &str,
    quantity: quantity::Quantity,
) -> Result<f64> {
    reader.get(section, key).map_or(Ok(0.0), |entry| entry.number(quantity, "a number"))
}

pub(super) fn operator(reader: &Reader<'_>, section: &str, axes: usize) -> Result<OperatorRange> {
    let keys = [
        ("mass", quantity::ADDED_MASS),
        ("damping", quantity::DAMPING),
        ("stiffness", quantity::GROUND_STIFFNESS),
    ];
    let mut spans = Vec::with_capacity(3);
    for (key, quantity) in keys {
        spans.push(match reader.get(section, key) {
            None => vec![Span { low: 0.0, high: 0.0 }; axes],
            Some(entry) => {
                let values = entry.per_axis(quantity, true)?;
                check_count(&entry, &values, axes)?;
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

pub(super) fn network(reader: &Reader<'_>) -> Result<Network> {
    let entry = reader.need("network", "delay", "delay = 0.05 (s, one way)")?;
    let delay = match entry.pair(["forward", "backward"], "or give one number")? {
        Some([forward, backward]) => Delay::new(
            forward.number(quantity::DELAY, "a number")?,
            backward.number(quantity::DELAY, "a number")?,
        ),
        None => Delay::each_way(entry.number(quantity::DELAY, "a number or {forward = …, backward = …}")?),
    };
    Network::new(
        delay.map_err(|error| reader.place("network", error))?,
        optional(reader, "network", "jitter", quantity::SPAN)?,
        optional(reader, "network", "max_gap", quantity::SPAN)?,
        optional(reader, "controller", "sample_period", quantity::SPAN)?,
        optional(reader, "controller", "computing_time", quantity::SPAN)?,
    )
    .map_err(|error| {
        let section =
            if matches!(error.field.as_str(), "jitter" | "max_gap") { "network" } else { "controller" };
        match reader.get(section, &error.field) {
            Some(entry) => entry.place(error.within(section)),
            None => error.within(section),
        }
    })
}
