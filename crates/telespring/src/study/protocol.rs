//! The section `[protocol]`: conditions, number and duration of trials.

use std::f64::consts::TAU;

use super::entry::Entry;
use super::laboratory::Task;
use super::reader::Reader;
use crate::criteria::{critical_stiffness, maximum_delay};
use crate::error::{InvalidInput, Result};
use crate::model::{Dyad, DyadAxis};
use crate::quantity;
use crate::rig::{Protocol, Schedule};

/// The conditions as given in the study.
#[derive(Debug, Clone, PartialEq)]
pub enum Conditions {
    /// Every stiffness (N/m) with every delay (s); missing lists default to multiples of K and Δ.
    Combinations {
        /// Stiffnesses, N/m; {0.5, 1, 2, 4}·K by default.
        stiffness: Option<Vec<f64>>,
        /// One-way delays, s; {0, 0.5, 1, 2}·Δ by default.
        delay: Option<Vec<f64>>,
    },
    /// Stiffness (N/m) and one-way delay (s) of each condition.
    Listed(Vec<(f64, f64)>),
}

/// The protocol as given in the study; missing values follow from robots, task and controllers.
#[derive(Debug, Clone, PartialEq)]
pub struct ProtocolChoice {
    /// True if the robots also run without the spring.
    pub unconnected: bool,
    /// The connected conditions.
    pub conditions: Conditions,
    /// The number of trials per condition.
    pub trials: usize,
    /// The duration of a trial, s; twelve target periods by default.
    pub duration: Option<f64>,
    /// The part discarded at the start, s; two target periods by default.
    pub discard: Option<f64>,
    /// Samples recorded per second, Hz; about 100 by default.
    pub record_rate: Option<f64>,
    /// The seed from which the seeds of all trials are drawn.
    pub seed: u64,
    /// True for an order drawn from the seed.
    pub shuffled: bool,
}

const MAX_TRIALS: i64 = 10_000;
const MAX_CONDITIONS: usize = 1000;
/// For all trials together, about 10 GB as a dataset; the paper's protocol records a million.
const MAX_ROWS: f64 = 5e7;
/// The largest whole number in TOML.
const LARGEST_SEED: i64 = i64::MAX;
const STIFFNESS_FACTORS: [f64; 4] = [0.5, 1.0, 2.0, 4.0];
const DELAY_FACTORS: [f64; 4] = [0.0, 0.5, 1.0, 2.0];
/// Whole periods, so that the mean error does not depend on where a trial is cut: ten to evaluate after two
/// in which the transient of every stable condition decays.
const PERIODS: [f64; 2] = [12.0, 2.0];
/// Duration and discarded part for a target of unknown period, s.
const WITHOUT_PERIOD: [f64; 2] = [30.0, 5.0];

impl ProtocolChoice {
    /// The paper's protocol: unconnected and all sixteen combinations, twenty trials each.
    pub fn paper() -> Self {
        Self {
            unconnected: true,
            conditions: Conditions::Combinations { stiffness: None, delay: None },
            trials: 20,
            duration: None,
            discard: None,
            record_rate: None,
            seed: 1,
            shuffled: false,
        }
    }

    /// The complete protocol for these robots, this task and this sample period (s).
    pub(super) fn resolve(&self, dyad: &Dyad, task: &Task, sample_period: f64) -> Result<Protocol> {
        let mut conditions: Vec<(Option<f64>, f64)> = Vec::new();
        if self.unconnected {
            conditions.push((None, 0.0));
        }
        match &self.conditions {
            Conditions::Listed(listed) => {
                conditions.extend(listed.iter().map(|&(stiffness, delay)| (Some(stiffness), delay)));
            }
            Conditions::Combinations { stiffness: Some(stiffness), delay: Some(delay) } => {
                conditions.extend(combinations(stiffness, delay));
            }
            Conditions::Combinations { stiffness, delay } => {
                let (k, found_delay) = reference_condition(dyad)?;
                let multiples = |factors: [f64; 4], unit: f64| factors.map(|factor| factor * unit).to_vec();
                let stiffness = stiffness.clone().unwrap_or_else(|| multiples(STIFFNESS_FACTORS, k));
                let delay = delay.clone().unwrap_or_else(|| multiples(DELAY_FACTORS, found_delay));
                conditions.extend(combinations(&stiffness, &delay));
            }
        }
        check_condition_count(conditions.len())?;

        let rate = 1.0 / sample_period;
        let spans = match task {
            // Without a frequency the target stands still.
            Task::FigureEight { angular_frequency, .. } if *angular_frequency > 0.0 => {
                PERIODS.map(|count| (count * TAU / angular_frequency * rate).round() / rate)
            }
            _ => WITHOUT_PERIOD,
        };
        let [duration, discard] = [self.duration.unwrap_or(spans[0]), self.discard.unwrap_or(spans[1])];
        quantity::TRIAL_DURATION.check("protocol.duration", duration)?;
        if discard >= duration {
            let default = if self.discard.is_none() { " (by default)" } else { "" };
            return Err(InvalidInput::new(
                "protocol.discard",
                format!("{discard:?}{default}"),
                format!("the discarded part must be shorter than the trial of {duration:?} s"),
                "Give a longer duration, or a shorter part to discard.",
            ));
        }
        // The rate of the controllers or an integer fraction of it: about 100 Hz by default.
        let record_rate = self.record_rate.unwrap_or_else(|| rate / (rate / 100.0 - 1e-9).ceil().max(1.0));
        let schedule = Schedule::new(duration, record_rate, sample_period)
            .map_err(|refusal| refusal.within("protocol"))?;
        // With the fraction of a sample that the analysis allows for rounding.
        let first = (discard / schedule.time(1, sample_period) - 1e-6).ceil().max(0.0);
        if schedule.rows() as f64 - first < 2.0 {
            let default = if self.duration.is_none() { " (by default)" } else { "" };
            return Err(InvalidInput::new(
                "protocol.duration",
                format!("{duration:?}{default}"),
                format!(
                    "at least two samples must remain after the first {discard:?} s, with {record_rate:?} recorded \
                     per second"
                ),
                "Give a longer duration, a shorter part to discard or a higher record_rate.",
            ));
        }
        let rows = conditions.len() as f64 * self.trials as f64 * schedule.rows() as f64;
        if rows > MAX_ROWS {
            return Err(InvalidInput::new(
                "protocol.trials",
                self.trials,
                format!(
                    "all trials together record at most {MAX_ROWS:.0} samples, but {} conditions of {duration:?} s \
                     at {record_rate:?} Hz give {rows:.0}",
                    conditions.len()
                ),
                "Run fewer or shorter trials, or record fewer samples per second.",
            ));
        }
        Ok(Protocol {
            conditions,
            trials: self.trials,
            duration,
            discard,
            record_rate,
            seed: self.seed,
            shuffled: self.shuffled,
        })
    }
}

/// The conditions of a protocol from every stiffness with every delay.
fn combinations(stiffness: &[f64], delay: &[f64]) -> Vec<(Option<f64>, f64)> {
    stiffness.iter().flat_map(|&k| delay.iter().map(move |&delay| (Some(k), delay))).collect()
}

/// Checks the number of conditions of a protocol.
fn check_condition_count(count: usize) -> Result<()> {
    if (1..=MAX_CONDITIONS).contains(&count) {
        return Ok(());
    }
    Err(InvalidInput::new(
        "protocol.conditions",
        format!("{count} conditions"),
        format!("a protocol has 1 to {MAX_CONDITIONS} conditions, the unconnected one included"),
        if count == 0 { "Give a condition, or write unconnected = true." } else { "Give fewer." },
    ))
}

/// The protocol's reference stiffness K and delay Δ of Eq. 11 by the exact criteria, with free handles: the smallest
/// critical stiffness of any axis, and the smallest delay at which twice that stiffness is unstable.
fn reference_condition(dyad: &Dyad) -> Result<(f64, f64)> {
    let [one, two] = dyad.robots();
    let axes = (0..one.mass().len())
        .map(|i| DyadAxis::new(one.mass()[i], one.damping()[i], two.mass()[i], two.damping()[i]))
        .collect::<Result<Vec<_>>>()?;
    let k = axes.iter().map(critical_stiffness).fold(f64::INFINITY, f64::min);
    let mut delay = f64::INFINITY;
    for axis in &axes {
        if quantity::STIFFNESS.check("2K", 2.0 * k).is_ok() {
            delay = delay.min(maximum_delay(axis, 2.0 * k)?);
        }
    }
    let usable = STIFFNESS_FACTORS.iter().all(|factor| quantity::STIFFNESS.check("k", factor * k).is_ok())
        && DELAY_FACTORS.iter().all(|factor| quantity::DELAY.check("delay", factor * delay).is_ok());
    if usable {
        return Ok((k, delay));
    }
    Err(InvalidInput::new(
        "protocol.stiffness",
        "not given",
        format!(
            "the default is a multiple of the robots' critical stiffness K, but K is {k:.4} N/m with a reference \
             delay Δ of {delay:.4} s"
        ),
        "Give both protocol.stiffness and protocol.delay, or give the robots damping on every axis.",
    ))
}

/// Reads the section `[protocol]`.
pub(super) fn read_protocol(reader: &Reader<'_>) -> Result<ProtocolChoice> {
    const HERE: &str = "protocol";
    let paper = ProtocolChoice::paper();
    let number = |key: &str, quantity: quantity::Quantity| {
        reader.get(HERE, key).map(|entry| Ok(entry.number(quantity, "a number")? + 0.0)).transpose()
    };
    let flag = |key: &str, default: bool| reader.get(HERE, key).map_or(Ok(default), |entry| entry.boolean());
    let whole = |key: &str, what: &str, least: i64, most: i64, default: i64| {
        reader.get(HERE, key).map_or(Ok(default), |entry| entry.whole_number(what, least, most))
    };
    Ok(ProtocolChoice {
        unconnected: flag("unconnected", paper.unconnected)?,
        conditions: read_conditions(reader)?,
        trials: whole("trials", "the number of trials", 1, MAX_TRIALS, paper.trials as i64)? as usize,
        duration: number("duration", quantity::TRIAL_DURATION)?,
        discard: number("discard", quantity::SPAN_OF_TRIAL)?,
        record_rate: number("record_rate", quantity::RATE)?,
        seed: whole("seed", "a seed", 0, LARGEST_SEED, paper.seed as i64)? as u64,
        shuffled: match reader.get(HERE, "order") {
            None => paper.shuffled,
            Some(entry) => entry.choice(&["blocks", "shuffled"])? == "shuffled",
        },
    })
}

/// Reads the conditions of the section `[protocol]`.
fn read_conditions(reader: &Reader<'_>) -> Result<Conditions> {
    let stiffness = read_number_list(reader, "stiffness", quantity::STIFFNESS)?;
    let delay = read_number_list(reader, "delay", quantity::DELAY)?;
    let Some(entry) = reader.get("protocol", "conditions") else {
        return Ok(Conditions::Combinations { stiffness, delay });
    };
    if stiffness.is_some() || delay.is_some() {
        return Err(entry.reject(
            "a protocol has either a list of conditions or lists of stiffness and delay",
            "Remove one of them.",
        ));
    }
    let mut listed: Vec<(f64, f64)> = Vec::new();
    for item in entry.items("conditions")? {
        let Some([stiffness, delay]) = item.pair(["stiffness", "delay"], "")? else {
            return Err(item.reject(
                "a condition has a stiffness and a delay",
                "Write, for example, {stiffness = 71.0, delay = 0.05} (N/m and s).",
            ));
        };
        let condition = (
            stiffness.number(quantity::STIFFNESS, "a number")?,
            delay.number(quantity::DELAY, "a number")? + 0.0,
        );
        if listed.contains(&condition) {
            return Err(
                item.reject("every condition must be distinct", "Remove it, or run more trials of each.")
            );
        }
        listed.push(condition);
        check_condition_count(listed.len())?;
    }
    Ok(Conditions::Listed(listed))
}

/// Reads a list of distinct numbers of the protocol.
fn read_number_list(
    reader: &Reader<'_>,
    key: &str,
    quantity: quantity::Quantity,
) -> Result<Option<Vec<f64>>> {
    let Some(entry) = reader.get("protocol", key) else { return Ok(None) };
    if entry.items("numbers")?.is_empty() {
        return Err(entry.reject(
            "a list of at least one number is required",
            "Write conditions = [] to run the unconnected condition only.",
        ));
    }
    read_numbers(&entry, quantity).map(Some)
}

/// Reads a list of distinct numbers for conditions, at least one.
pub(super) fn read_numbers(entry: &Entry<'_, '_>, quantity: quantity::Quantity) -> Result<Vec<f64>> {
    let items = entry.items("numbers")?;
    if items.is_empty() {
        return Err(
            entry.reject("a list of at least one number is required", "Leave the key out, or give a number.")
        );
    }
    let mut values = Vec::with_capacity(items.len());
    for item in items {
        let value = item.number(quantity, "a number")? + 0.0;
        if values.contains(&value) {
            return Err(item.reject("every value must be distinct", "Remove it."));
        }
        values.push(value);
        check_condition_count(values.len())?;
    }
    Ok(values)
}
