//! What the network does to the packets of a rehearsal, from the section `[network]` of a study.

use std::sync::Arc;

use super::Study;
use super::adversary::read_adversary;
use super::entry::Entry;
use super::reader::Reader;
use crate::error::{InvalidInput, Result};
use crate::quantity::{self, Quantity};
use crate::rig::trace::{IrttDelay, TraceFormat, TraceUnits, names_round_trips};
use crate::rig::{
    Blackout, GilbertElliott, JitterDistribution, Network, NetworkModel, PacketOrder, RateLimit, Trace,
};

/// A file with a recorded trace of the network.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TraceFile {
    /// As written in the study: relative to its folder.
    pub path: String,
    /// Whether its delays are round trips, of which one way takes half.
    pub is_round_trip: bool,
}

impl TraceFile {
    /// The recorded trace in the text of the study's file: a table, the JSON of IRTT, or the log of `ping -D`.
    ///
    /// Of IRTT's delays it takes the round trip if the study says so, otherwise the one from client to server on the
    /// way forward and the other on the way backward: the client stands at robot 1. The delays of a ping are round trips
    /// whatever the study says: where it does not, the trace has half of each, as a way that is not said to be a round trip.
    ///
    /// # Errors
    ///
    /// As [`Trace::from_csv`], [`Trace::from_irtt`] and [`Trace::from_ping`], with the name of the file; or if a column is
    /// named `rtt` and the file is not said to have round trips.
    pub fn trace(&self, text: &str, is_forward: bool) -> Result<Trace> {
        let read = match TraceFormat::of(text) {
            TraceFormat::Irtt => {
                let taken = match (self.is_round_trip, is_forward) {
                    (true, _) => IrttDelay::RoundTrip,
                    (false, true) => IrttDelay::Send,
                    (false, false) => IrttDelay::Receive,
                };
                Trace::from_irtt(text, taken)
            }
            TraceFormat::Ping if self.is_round_trip => Trace::from_ping(text),
            TraceFormat::Ping => Trace::from_ping(text).map(Trace::halved),
            TraceFormat::Table if names_round_trips(text) && !self.is_round_trip => Err(InvalidInput::new(
                "trace, column delay",
                "\"rtt\"",
                "a round trip is not the delay of one way",
                "Say that it is a round trip (round_trip = true in a study, --round-trip on the command line), \
                 which takes half of it for each way.",
            )),
            TraceFormat::Table => Trace::from_csv(text, TraceUnits::default()),
        };
        read.map_err(|refusal| InvalidInput { field: format!("{}, {}", self.path, refusal.field), ..refusal })
    }
}

/// What the network does to the packets of a rehearsal, as given in the study.
#[derive(Debug, Clone, PartialEq)]
pub struct EmulatedNetwork {
    /// Both directions, without their traces.
    pub model: Network,
    /// The recorded traces of both directions, forward and backward.
    pub traces: [Option<TraceFile>; 2],
}

impl EmulatedNetwork {
    /// A network with a constant delay only.
    pub fn ideal() -> Self {
        Self { model: Network::each_way(NetworkModel::ideal()), traces: [None, None] }
    }

    /// The largest additional delay of a packet in either direction, s, which the verdicts assume.
    pub fn jitter(&self) -> f64 {
        self.model.forward.jitter.max(self.model.backward.jitter)
    }
}

/// The keys that moved from `[laboratory]` to `[network]`, and are still read there.
const MOVED: [&str; 2] = ["jitter", "loss"];

/// The keys that a study's file has at their old place, with their new one. They do not make it another study.
#[derive(Debug, Clone, Default)]
pub(super) struct MovedKeys(Vec<(String, String)>);

impl PartialEq for MovedKeys {
    /// Always true: where a key stands does not make it another study.
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl MovedKeys {
    /// The moved keys of a study's text.
    pub fn of(reader: &Reader<'_>) -> Self {
        let given = MOVED.into_iter().filter(|key| reader.get("laboratory", key).is_some());
        Self(given.map(|key| (format!("laboratory.{key}"), format!("network.{key}"))).collect())
    }
}

impl Study {
    /// What the network does to the packets of a rehearsal.
    pub fn emulated_network(&self) -> &EmulatedNetwork {
        &self.emulated_network
    }

    /// The keys that the study's text has at their old place, each with the new one; they are read for one release.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::study::Study;
    /// let robots = "robot1 = {mass = [1, 1], damping = 5}\nrobot2 = {mass = [1, 1], damping = 5}\n";
    /// let study = Study::from_toml(&format!("{robots}laboratory.loss = 0.1"))?;
    /// assert_eq!(study.moved_keys(), [("laboratory.loss".to_owned(), "network.loss".to_owned())]);
    /// assert_eq!(study, Study::from_toml(&format!("{robots}network.loss = 0.1"))?);
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn moved_keys(&self) -> &[(String, String)] {
        &self.moved_keys.0
    }

    /// Recorded traces as one way of the study's network.
    pub(super) fn one_way(&self, traces: [Option<Arc<Trace>>; 2]) -> Result<[Option<Arc<Trace>>; 2]> {
        let mut found = [None, None];
        for (way, trace) in traces.into_iter().enumerate() {
            found[way] = match (&self.emulated_network.traces[way], trace) {
                (Some(file), Some(trace)) if file.is_round_trip => {
                    Some(Arc::new(Trace::clone(&trace).halved()))
                }
                (Some(_), trace) => trace,
                (None, None) => None,
                (None, Some(_)) => {
                    return Err(InvalidInput::new(
                        "traces",
                        "a trace",
                        "the study names no recorded trace for this direction",
                        "Add network.trace to the study, or leave the trace out.",
                    ));
                }
            };
        }
        Ok(found)
    }

    /// The network of the study's laboratory with these recorded traces, forward and backward.
    pub(super) fn network_on(&self, traces: [Option<Arc<Trace>>; 2]) -> Result<Network> {
        let mut network = self.emulated_network.model.clone();
        let ways = [&mut network.forward, &mut network.backward];
        let traces = self.one_way(traces)?;
        for ((way, file), trace) in ways.into_iter().zip(&self.emulated_network.traces).zip(traces) {
            let Some(file) = file else { continue };
            if trace.is_none() {
                return Err(InvalidInput::new(
                    "network.trace",
                    format!("{:?}", file.path),
                    "the rehearsal needs the content of the recorded trace",
                    "Read the file and give it to Study::laboratory_on.",
                ));
            }
            // The trace has its own delays; what the study calls jitter is for the verdicts.
            way.jitter = 0.0;
            way.trace = trace;
        }
        Ok(network)
    }
}

/// Reads what the network does to the packets of the study's rehearsal.
pub(super) fn read_emulated_network(reader: &Reader<'_>) -> Result<EmulatedNetwork> {
    let jitter = read_moved(reader, "jitter", quantity::SPAN)?;
    let loss = read_moved(reader, "loss", quantity::PROBABILITY)?;
    let distribution = each_way(reader, "distribution", JitterDistribution::Uniform, read_distribution)?;
    let burst = each_way(reader, "burst", None, |entry| read_burst(entry).map(Some))?;
    let duplicate = each_way(reader, "duplicate", 0.0, |entry| number(entry, quantity::PROBABILITY))?;
    let order = each_way(reader, "order", PacketOrder::Any, |entry| {
        Ok(if entry.choice(&["any", "fifo"])? == "fifo" { PacketOrder::Fifo } else { PacketOrder::Any })
    })?;
    let rate = each_way(reader, "rate", None, |entry| read_rate(entry).map(Some))?;
    let blackout = each_way(reader, "blackout", None, |entry| read_blackout(entry).map(Some))?;
    let adversary = each_way(reader, "adversary", None, |entry| read_adversary(entry).map(Some))?;
    let traces = each_way(reader, "trace", None, |entry| read_trace(entry).map(Some))?;
    let way = |i: usize| NetworkModel {
        jitter: jitter[i],
        distribution: distribution[i],
        loss: loss[i],
        burst: burst[i],
        duplicate: duplicate[i],
        order: order[i],
        rate: rate[i],
        blackout: blackout[i],
        trace: None,
        adversary: adversary[i],
    };
    let model = Network { forward: way(0), backward: way(1) };
    model.check().map_err(|refusal| reader.with_line_of_field(refusal.within("network")))?;
    if let (Some(entry), [Some(_), _] | [_, Some(_)]) = (reader.get("network", "distribution"), &traces) {
        return Err(entry.reject(
            "a recorded trace has its own delays, which are not drawn from a distribution",
            "Remove distribution, or trace.",
        ));
    }
    Ok(EmulatedNetwork { model, traces })
}

/// A number of a network without the sign of −0, which has no meaning and would not be written.
pub(super) fn number(entry: &Entry<'_, '_>, quantity: Quantity) -> Result<f64> {
    Ok(entry.number(quantity, "a number")? + 0.0)
}

/// Reads a key of the network: one value for both directions, or `{forward = …, backward = …}`.
fn each_way<T: Clone>(
    reader: &Reader<'_>,
    key: &str,
    default: T,
    read: impl Fn(&Entry<'_, '_>) -> Result<T>,
) -> Result<[T; 2]> {
    let Some(entry) = reader.get("network", key) else { return Ok([default.clone(), default]) };
    let is_pair = entry
        .value()
        .as_table()
        .is_some_and(|table| ["forward", "backward"].iter().any(|way| table.contains_key(*way)));
    if !is_pair {
        let value = read(&entry)?;
        return Ok([value.clone(), value]);
    }
    let [forward, backward] = entry.parts(["forward", "backward"])?.unwrap_or_default();
    // A direction that is not named has the default.
    let way = |entry: Option<Entry<'_, '_>>| entry.map_or_else(|| Ok(default.clone()), |entry| read(&entry));
    Ok([way(forward)?, way(backward)?])
}

/// Reads a number of the network that may still stand in `[laboratory]`.
fn read_moved(reader: &Reader<'_>, key: &str, quantity: Quantity) -> Result<[f64; 2]> {
    let here = each_way(reader, key, 0.0, |entry| number(entry, quantity))?;
    let Some(moved) = reader.get("laboratory", key) else { return Ok(here) };
    let value = number(&moved, quantity)?;
    if reader.get("network", key).is_some() && here != [value; 2] {
        return Err(moved.reject(
            format!("[network] {key} says the same of the same network, and differs"),
            format!("Remove it: {key} under [network] is for the verdicts and for the rehearsal."),
        ));
    }
    Ok([value; 2])
}

/// Reads how the jitter of the network is distributed.
fn read_distribution(entry: &Entry<'_, '_>) -> Result<JitterDistribution> {
    const KINDS: [&str; 4] = ["uniform", "normal", "gamma", "lognormal"];
    let Some([kind, mean, sd]) = entry.parts(["kind", "mean", "sd"])? else {
        return match entry.choice(&KINDS)? {
            "uniform" => Ok(JitterDistribution::Uniform),
            kind => Err(entry.reject(
                format!("a {kind} distribution has a mean and a standard deviation, in s"),
                format!("Write {{kind = \"{kind}\", mean = 0.004, sd = 0.002}} with your values."),
            )),
        };
    };
    let kind = required(entry, kind, "kind = \"gamma\"")?.choice(&KINDS)?;
    if kind == "uniform" {
        if mean.is_some() || sd.is_some() {
            return Err(entry.reject(
                "a uniform jitter lies between 0 and the key jitter, and has no mean or sd of its own",
                "Write distribution = \"uniform\".",
            ));
        }
        return Ok(JitterDistribution::Uniform);
    }
    let mean = number(&required(entry, mean, "mean = 0.004")?, quantity::SPAN)?;
    let sd = number(&required(entry, sd, "sd = 0.002")?, quantity::SPAN)?;
    Ok(match kind {
        "normal" => JitterDistribution::Normal { mean, sd },
        "gamma" => JitterDistribution::Gamma { mean, sd },
        _ => JitterDistribution::LogNormal { mean, sd },
    })
}

/// The part of a network's table that must be there.
pub(super) fn required<'r, 'a>(
    entry: &Entry<'r, 'a>,
    part: Option<Entry<'r, 'a>>,
    example: &str,
) -> Result<Entry<'r, 'a>> {
    part.ok_or_else(|| {
        let key = example.split(' ').next().unwrap_or_default();
        let missing = InvalidInput::missing(
            format!("{}.{key}", entry.field),
            "",
            format!("Add {example} to the table."),
        );
        entry.place(missing)
    })
}

/// The error for a value of the network that must be a table.
fn not_a_table(entry: &Entry<'_, '_>, example: &str) -> InvalidInput {
    entry.reject("a table is required", format!("Write, for example, {example}."))
}

/// Reads losses of the network in bursts.
fn read_burst(entry: &Entry<'_, '_>) -> Result<GilbertElliott> {
    let parts = entry.parts(["to_bad", "to_good", "loss_good", "loss_bad"])?;
    let Some([to_bad, to_good, loss_good, loss_bad]) = parts else {
        return Err(not_a_table(entry, "{to_bad = 0.01, to_good = 0.25}"));
    };
    let optional = |part: Option<Entry<'_, '_>>, default: f64| {
        part.map_or(Ok(default), |part| number(&part, quantity::PROBABILITY))
    };
    Ok(GilbertElliott {
        to_bad: number(&required(entry, to_bad, "to_bad = 0.01")?, quantity::PROBABILITY)?,
        to_good: number(&required(entry, to_good, "to_good = 0.25")?, quantity::PROBABILITY)?,
        loss_good: optional(loss_good, 0.0)?,
        loss_bad: optional(loss_bad, 1.0)?,
    })
}

/// Reads the rate of the network's link: a number in bit/s, or with the length of its queue.
fn read_rate(entry: &Entry<'_, '_>) -> Result<RateLimit> {
    let Some([rate, queue]) = entry.parts(["bits_per_second", "queue"])? else {
        return Ok(RateLimit {
            bits_per_second: number(entry, quantity::BIT_RATE)?,
            queue: RateLimit::QUEUE,
        });
    };
    let queue = queue.map_or(Ok(RateLimit::QUEUE as i64), |queue| {
        queue.whole_number("the number of packets that wait", 0, RateLimit::LONGEST_QUEUE as i64)
    })?;
    let rate = number(&required(entry, rate, "bits_per_second = 1e6")?, quantity::BIT_RATE)?;
    Ok(RateLimit { bits_per_second: rate, queue: queue as usize })
}

/// Reads the blackouts of the network.
fn read_blackout(entry: &Entry<'_, '_>) -> Result<Blackout> {
    let Some([start, duration, period]) = entry.parts(["start", "duration", "period"])? else {
        return Err(not_a_table(entry, "{start = 5.0, duration = 0.5, period = 10.0}"));
    };
    Ok(Blackout {
        start: start.map_or(Ok(0.0), |start| number(&start, quantity::SPAN_OF_TRIAL))?,
        duration: number(&required(entry, duration, "duration = 0.5")?, quantity::SPAN_OF_TRIAL)?,
        period: period.map(|period| number(&period, quantity::SPAN_OF_TRIAL)).transpose()?,
    })
}

/// Reads the name of a file with a recorded trace of the network.
fn read_trace(entry: &Entry<'_, '_>) -> Result<TraceFile> {
    let Some([file, round_trip]) = entry.parts(["file", "round_trip"])? else {
        return Ok(TraceFile { path: entry.text()?, is_round_trip: false });
    };
    Ok(TraceFile {
        path: required(entry, file, "file = \"trace.csv\"")?.text()?,
        is_round_trip: round_trip.map_or(Ok(false), |entry| entry.boolean())?,
    })
}
