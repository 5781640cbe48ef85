//! The adversary of a network in a rehearsal, from the key `adversary` of the section `[network]`.

use toml::{Table, Value};

use super::Study;
use super::emulated_network::{number, required};
use super::entry::Entry;
use crate::error::Result;
use crate::quantity::{self, Quantity};
use crate::rig::Adversary;

/// A setting of an adversary: its key, its quantity, and what to write in the study where it is missing.
type Setting = (&'static str, Quantity, &'static str);

const MEMORY: Setting = ("memory", quantity::SPAN, "memory = 1.0");
const LONGEST: Setting = ("longest", quantity::SPAN, "longest = 1.0");
const POSITION: Setting = ("position", quantity::POSITION_SHIFT, "position = 0.05");
const STAMP: Setting = ("stamp", quantity::STAMP_SHIFT, "stamp = -0.1");
const POWER: Setting = ("power", quantity::POWER, "power = 5.0");

impl Adversary {
    /// The adversary as the value of the study's key.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::rig::Adversary;
    ///
    /// let table = Adversary::StretchTimed { longest: 0.5 }.to_table();
    /// assert_eq!(table["kind"].as_str(), Some("stretch-timed"));
    /// assert_eq!(table["longest"].as_float(), Some(0.5));
    /// ```
    pub fn to_table(&self) -> Table {
        let kind = ("kind", Value::String(self.kind().to_owned()));
        let settings = self.settings().into_iter().map(|(key, value)| (key, Value::Float(value)));
        std::iter::once(kind).chain(settings).map(|(key, value)| (key.to_owned(), value)).collect()
    }

    /// The settings of the adversary by their keys, in SI units.
    pub fn settings(&self) -> Vec<(&'static str, f64)> {
        match *self {
            Self::OldestSample { memory } | Self::MostHarmfulSample { memory } => vec![("memory", memory)],
            Self::StretchTimed { longest } => vec![("longest", longest)],
            Self::LyingPeer { position, stamp, power } => {
                vec![("position", position), ("stamp", stamp), ("power", power)]
            }
        }
    }
}

impl Study {
    /// The adversaries on the study's network, forward and backward; `None` where there is none.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::study::Study;
    /// assert_eq!(Study::paper().adversaries(), [None, None]);
    /// ```
    pub fn adversaries(&self) -> [Option<Adversary>; 2] {
        let network = &self.emulated_network().model;
        [network.forward.adversary, network.backward.adversary]
    }
}

/// Reads an adversary of the study's network; its values are checked with the network.
pub(super) fn read_adversary(entry: &Entry<'_, '_>) -> Result<Adversary> {
    let kind = entry.kind(&Adversary::KINDS)?;
    // A word has no settings, and every adversary needs some.
    let is_table = entry.value().is_table();
    let read = |settings: &[Setting]| -> Result<Vec<f64>> {
        if !is_table {
            let written = settings.iter().map(|(.., example)| format!(", {example}")).collect::<String>();
            return Err(entry.reject(
                "an adversary has settings: a table is required",
                format!("Write {{kind = \"{kind}\"{written}}} with your values."),
            ));
        }
        let keys: Vec<_> = std::iter::once("kind").chain(settings.iter().map(|(key, ..)| *key)).collect();
        entry.check_keys(&keys)?;
        let values = settings.iter().map(|(key, quantity, example)| {
            let part = entry.members()?.into_iter().find(|(member, _)| member == key).map(|(_, part)| part);
            number(&required(entry, part, example)?, *quantity)
        });
        values.collect()
    };
    let [oldest, most_harmful, stretch_timed, _] = Adversary::KINDS;
    Ok(if kind == oldest {
        Adversary::OldestSample { memory: read(&[MEMORY])?[0] }
    } else if kind == most_harmful {
        Adversary::MostHarmfulSample { memory: read(&[MEMORY])?[0] }
    } else if kind == stretch_timed {
        Adversary::StretchTimed { longest: read(&[LONGEST])?[0] }
    } else {
        let values = read(&[POSITION, STAMP, POWER])?;
        Adversary::LyingPeer { position: values[0], stamp: values[1], power: values[2] }
    })
}
