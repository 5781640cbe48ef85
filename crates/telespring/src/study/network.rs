//! The sections [network] and [controller].

use super::reader::Reader;
use crate::error::Result;
use crate::model::Delay;
use crate::quantity;
use crate::verdicts::Network;

/// Reads the network's delays and the timing of both controllers.
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
        reader.number_or_zero("network", "jitter", quantity::SPAN)?,
        reader.number_or_zero("network", "max_gap", quantity::SPAN)?,
        reader.number_or_zero("controller", "sample_period", quantity::SPAN)?,
        reader.number_or_zero("controller", "computing_time", quantity::SPAN)?,
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
