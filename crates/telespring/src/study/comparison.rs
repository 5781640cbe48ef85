//! The section `[comparison]`: what a comparison runs beside the stiffnesses and delays of the protocol.

use serde::Deserialize;
use toml::de::{DeValue, ValueDeserializer};
use toml::{Spanned, Table, Value};

use super::Study;
use super::entry::Entry;
use super::keys::SECTIONS;
use super::protocol::read_numbers;
use super::reader::Reader;
use super::session::{architecture_of, read_strategy};
use crate::error::{InvalidInput, Result};
use crate::quantity;
use crate::session::Architecture;

/// A comparison has at most this many architectures, and as many networks.
const MOST: usize = 100;

/// A network of a comparison.
#[derive(Debug, Clone, PartialEq)]
pub struct ComparedNetwork {
    /// Its name.
    pub name: String,
    /// The keys of the section `[network]` that take the place of all that the study's own has, but its delay.
    pub keys: Table,
    /// The delays that take the place of those of the protocol, s; `None` for the protocol's.
    pub delays: Option<Vec<f64>>,
}

/// What a comparison runs, as given in the study; what is missing follows from it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ComparisonChoice {
    /// The architectures.
    pub architectures: Option<Vec<Architecture>>,
    /// The networks.
    pub networks: Option<Vec<ComparedNetwork>>,
}

impl Study {
    /// The architectures that a comparison of this study runs: by default the usual ones, without those that have no place
    /// for the study's coupling damping.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::study::Study;
    /// assert_eq!(Study::paper().compared_architectures().len(), 11);
    /// ```
    pub fn compared_architectures(&self) -> Vec<Architecture> {
        self.comparison.architectures.clone().unwrap_or_else(|| {
            let has_damper = self.dyad.coupling_damping() > 0.0;
            let mut usual = Architecture::usual();
            usual.retain(|architecture| !has_damper || architecture.strategy.has_coupling_damper());
            usual
        })
    }

    /// The networks on which a comparison of this study runs; `None` for the study's own alone.
    pub fn compared_networks(&self) -> Option<&[ComparedNetwork]> {
        self.comparison.networks.as_deref()
    }

    /// Checks a network of the study's comparison by running the study on it.
    fn check_compared(&self, network: &ComparedNetwork) -> Result<()> {
        let mut tables = self.tables();
        tables.remove("comparison");
        tables.insert("network".to_owned(), Value::Table(network.keys.clone()));
        Self::from_tables(&tables).map(drop)
    }

    /// Checks that every strategy of the study has a place for its coupling damping, if it has any.
    pub(super) fn check_dampers(&self, reader: &Reader<'_>) -> Result<()> {
        if self.dyad.coupling_damping() == 0.0 {
            return Ok(());
        }
        let listed = reader.get("comparison", "architectures").map(|entry| entry.items("architectures"));
        let listed = listed.transpose()?.unwrap_or_default();
        let compared = listed.into_iter().zip(self.comparison.architectures.iter().flatten());
        let own = reader.get("session", "strategy").into_iter().map(|entry| (entry, &self.session));
        for (entry, Architecture { strategy, .. }) in own.chain(compared) {
            if !strategy.has_coupling_damper() {
                return Err(entry.reject(
                    format!("{} has dampers of its own, and no place for coupling.damping", strategy.kind()),
                    "Remove coupling.damping, or choose another strategy.",
                ));
            }
        }
        Ok(())
    }

    /// Checks all networks of the study's comparison.
    pub(super) fn check_comparison(&self, reader: &Reader<'_>) -> Result<()> {
        let Some(networks) = self.compared_networks() else { return Ok(()) };
        let Some(entry) = reader.get("comparison", "networks") else { return Ok(()) };
        for (item, network) in entry.items("networks")?.iter().zip(networks) {
            self.check_compared(network).map_err(|refusal| {
                let field = match refusal.field.strip_prefix("network.") {
                    Some(key) => format!("{}.{key}", item.field),
                    None => format!("{}, {}", item.field, refusal.field),
                };
                item.place(InvalidInput { field, ..refusal })
            })?;
        }
        Ok(())
    }
}

/// Reads what a comparison of the study runs.
pub(super) fn read_comparison(reader: &Reader<'_>) -> Result<ComparisonChoice> {
    let architectures = reader.get("comparison", "architectures");
    let networks = reader.get("comparison", "networks");
    Ok(ComparisonChoice {
        architectures: architectures.map(|entry| read_architectures(&entry)).transpose()?,
        networks: networks.map(|entry| read_networks(&entry)).transpose()?,
    })
}

/// The items of a list of the comparison: at least one, and not too many.
fn items_of<'r, 'a>(entry: &Entry<'r, 'a>, what: &str) -> Result<Vec<Entry<'r, 'a>>> {
    let items = entry.items(what)?;
    if (1..=MOST).contains(&items.len()) {
        return Ok(items);
    }
    let remedy = if items.is_empty() { "Leave the key out for the usual ones." } else { "Compare fewer." };
    Err(entry.reject(format!("a comparison has 1 to {MOST} {what}"), remedy))
}

/// Reads the architectures of a comparison: words for strategies, or tables as the section [session].
fn read_architectures(entry: &Entry<'_, '_>) -> Result<Vec<Architecture>> {
    let mut read: Vec<Architecture> = Vec::new();
    for item in items_of(entry, "architectures")? {
        let architecture = match item.parts(["strategy", "predictor", "playout"])? {
            Some(parts) => architecture_of(parts)?,
            None => Architecture { strategy: read_strategy(&item)?, ..Architecture::default() },
        };
        if read.contains(&architecture) {
            return Err(item.reject("every architecture must be distinct", "Remove it."));
        }
        read.push(architecture);
    }
    Ok(read)
}

/// Reads the networks of a comparison.
fn read_networks(entry: &Entry<'_, '_>) -> Result<Vec<ComparedNetwork>> {
    let mut read: Vec<ComparedNetwork> = Vec::new();
    for item in items_of(entry, "networks")? {
        let network = read_network(&item)?;
        if read.iter().any(|other| other.name == network.name) {
            return Err(item.reject(
                format!("every network needs a name of its own, and {:?} is given twice", network.name),
                "Choose another name.",
            ));
        }
        read.push(network);
    }
    Ok(read)
}

/// Reads one network of a comparison; the study that it gives is checked later.
fn read_network(item: &Entry<'_, '_>) -> Result<ComparedNetwork> {
    const EXAMPLE: &str = "{name = \"Wi-Fi\", jitter = 0.02, delay = [0.0, 0.05]}";
    if item.value().as_table().is_none() {
        return Err(item.reject(
            "a network of a comparison is a table with a name and keys of [network]",
            format!("Write, for example, {EXAMPLE}."),
        ));
    }
    let mut name = None;
    let mut delays = None;
    let mut keys = Table::new();
    for (key, value) in item.members()? {
        match key.as_str() {
            "name" => name = Some(value.text()?),
            "delay" if value.value().is_table() => {
                return Err(value.reject(
                    "a rehearsal has the same delay each way: a number or a list of numbers is required",
                    "Give one number, and what the two ways differ in under jitter, trace or another key.",
                ));
            }
            "delay" if value.value().is_array() => delays = Some(read_numbers(&value, quantity::DELAY)?),
            "delay" => delays = Some(vec![value.number(quantity::DELAY, "a number")? + 0.0]),
            _ => drop(keys.insert(key.clone(), plain(&value)?)),
        }
    }
    let network_keys = SECTIONS.iter().find(|(section, _)| *section == "network").map(|(_, keys)| keys.all());
    let mut allowed = vec!["name"];
    allowed.extend(network_keys.unwrap_or_default());
    item.check_keys(&allowed)?;
    let missing = || {
        let remedy = format!("Write, for example, {EXAMPLE}.");
        item.place(InvalidInput::missing(format!("{}.name", item.field), "", remedy))
    };
    let name = name.ok_or_else(missing)?;
    if name.trim().is_empty() {
        return Err(item.reject("a network needs a name", "Give it one that tells it from the others."));
    }
    Ok(ComparedNetwork { name, keys, delays })
}

/// A value of the study as plain TOML.
fn plain(entry: &Entry<'_, '_>) -> Result<Value> {
    let value: Spanned<DeValue<'_>> = entry.value.clone();
    Value::deserialize(ValueDeserializer::from(value))
        .map_err(|error| entry.reject(format!("it must be valid TOML: {error}"), "Correct it."))
}
