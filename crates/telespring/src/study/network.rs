//! The sections `[network]` and `[controller]`.

use super::entry::Entry;
use super::laboratory::read_sample_period as laboratory_period;
use super::reader::Reader;
use crate::error::Result;
use crate::model::Delay;
use crate::quantity;
use crate::verdicts::Network;

/// The default sample period of both controllers, s.
pub(super) const SAMPLE_PERIOD: f64 = 0.001;

/// Reads the network's delays and the timing of both controllers; the jitter of each way, s, is read already.
pub(super) fn read_network(reader: &Reader<'_>, jitters: [f64; 2]) -> Result<Network> {
    let delay = match reader.get("network", "delay") {
        None => Delay::each_way(0.0),
        Some(entry) => read_delay(&entry)?,
    };
    let period = match reader.get("controller", "sample_period") {
        Some(entry) => entry.number(quantity::CONTROLLER_PERIOD, "a number")?,
        // The laboratory has the same controllers.
        None => laboratory_period(reader)?.unwrap_or(SAMPLE_PERIOD),
    };
    Network::with_jitters(
        delay.map_err(|error| reader.place("network", error))?,
        jitters,
        reader.number_or_zero("network", "max_gap", quantity::SPAN)?,
        period,
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

/// Reads the delay each way.
fn read_delay(entry: &Entry<'_, '_>) -> Result<Result<Delay>> {
    Ok(match entry.pair(["forward", "backward"], "or give one number")? {
        Some([forward, backward]) => Delay::new(
            forward.number(quantity::DELAY, "a number")?,
            backward.number(quantity::DELAY, "a number")?,
        ),
        None => Delay::each_way(entry.number(quantity::DELAY, "a number or {forward = …, backward = …}")?),
    })
}
