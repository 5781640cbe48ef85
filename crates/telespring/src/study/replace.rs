//! A study with some of its values replaced.

use std::collections::BTreeMap;

use toml::{Table, Value};

use super::keys::{SECTIONS, TOP};
use super::source::Source;
use super::{HOLDERS, NamedHolders, RobotFile, Study};
use crate::error::{InvalidInput, Result};

/// What takes the place of a section of a study.
#[derive(Debug, Clone, PartialEq)]
pub enum Replacement {
    /// New values of some keys. `None` removes a key, so that its default holds.
    Keys(BTreeMap<String, Option<Value>>),
    /// One value outside the sections: the study's name, or whether it allows unusual values.
    Value(Value),
    /// Nothing, so that the section's defaults hold.
    Default,
}

/// A section and one of its keys.
type Key = (&'static str, &'static str);

/// Keys that exclude each other: to set one removes the others.
const EXCLUSIVE: [(Key, &[Key]); 7] = [
    (("protocol", "conditions"), &[("protocol", "stiffness"), ("protocol", "delay")]),
    (("protocol", "stiffness"), &[("protocol", "conditions")]),
    (("protocol", "delay"), &[("protocol", "conditions")]),
    (("network", "jitter"), &[("laboratory", "jitter")]),
    (("network", "loss"), &[("laboratory", "loss")]),
    (("laboratory", "jitter"), &[("network", "jitter")]),
    (("laboratory", "loss"), &[("network", "loss")]),
];

/// The keys that a replaced key excludes.
pub(super) fn excluded_by<'k>(section: &'k str, key: &'k str) -> impl Iterator<Item = Key> + 'k {
    EXCLUSIVE
        .into_iter()
        .filter(move |(of, _)| *of == (section, key))
        .flat_map(|(_, others)| others.iter().copied())
}

impl Study {
    /// The study with some values replaced, by section. Keys that are not named keep their values, with three
    /// exceptions: a new `kind` restarts its section, the `conditions` of a protocol exclude its lists of
    /// `stiffness` and `delay`, and `jitter` and `loss` of `[network]` exclude those of `[laboratory]`.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if a value is refused, by its dotted field.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::study::{Replacement, Study, Value};
    /// let stiffness = [("stiffness".to_owned(), Some(Value::from(140.0)))];
    /// let coupling = Replacement::Keys(stiffness.into());
    /// let stiff = Study::paper().replace(&[("coupling".to_owned(), coupling)].into())?;
    /// assert_eq!(stiff.coupling()?.stiffness, 140.0);
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn replace(&self, sections: &BTreeMap<String, Replacement>) -> Result<Self> {
        let mut tables = self.tables();
        for (name, replacement) in sections {
            let Replacement::Keys(keys) = replacement else { continue };
            for (section, key) in keys.keys().flat_map(|key| excluded_by(name, key)) {
                if let Some(Value::Table(section)) = tables.get_mut(section) {
                    section.remove(key);
                }
            }
        }
        for (name, replacement) in sections {
            let is_known =
                TOP.contains(&name.as_str()) || SECTIONS.iter().any(|(section, _)| section == name);
            match replacement {
                // left in the text for the reader to refuse
                _ if !is_known => drop(tables.insert(name.clone(), Value::Table(Table::new()))),
                Replacement::Keys(keys) => replace_keys(&mut tables, name, keys),
                Replacement::Value(value) => drop(tables.insert(name.clone(), value.clone())),
                Replacement::Default => drop(tables.remove(name)),
            }
        }
        let mut study = Self::from_tables(&tables)?;
        let names_holder = HOLDERS.iter().any(|holder| sections.contains_key(*holder));
        study.holders = NamedHolders(self.holders.0 || names_holder);
        Ok(study)
    }

    /// The study with one of its robots replaced by that of a robot file; robots are counted from 0.
    ///
    /// Where the file records a spring between the robot and the ground, it is the robot's `ground_stiffness`.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if the study refuses the robot.
    pub fn with_robot(&self, robot: usize, file: &RobotFile) -> Result<Self> {
        let section = format!("robot{}", robot + 1);
        let mut tables = self.tables();
        tables.insert(section.clone(), Value::Table(file.robot()?));
        let mut study = Self::from_tables(&tables).map_err(|mut refusal| {
            file.sign(&mut refusal, &section);
            refusal
        })?;
        study.holders = self.holders;
        Ok(study)
    }

    /// Whether the study names what holds a handle in its rehearsal: whether its file has one of the sections
    /// `[arm1]`, `[arm2]`, `[agent1]` and `[agent2]`, even with the default values.
    pub fn names_arms_or_agents(&self) -> bool {
        self.holders.0
    }

    /// The study as tables, one per section, whose values can be replaced.
    pub(super) fn tables(&self) -> Table {
        self.to_toml().parse().expect("a study writes TOML")
    }

    /// The study from its tables after values were replaced.
    pub(super) fn from_tables(tables: &Table) -> Result<Self> {
        let text = toml::to_string(tables).map_err(|error| unwritable(&error))?;
        Self::read(Source::generated(&text), None)
    }
}

/// Replaces values in one section of the study's tables; `None` removes a key.
fn replace_keys(tables: &mut Table, name: &str, keys: &BTreeMap<String, Option<Value>>) {
    let mut section = match tables.remove(name) {
        Some(Value::Table(section)) => section,
        _ => Table::new(),
    };
    if let Some(kind) = keys.get("kind")
        && section.get("kind") != kind.as_ref()
    {
        section.clear();
    }
    for (key, value) in keys {
        match value {
            Some(value) => drop(section.insert(key.clone(), value.clone())),
            None => drop(section.remove(key)),
        }
    }
    if !section.is_empty() {
        tables.insert(name.to_owned(), Value::Table(section));
    }
}

/// A replacement that TOML cannot write; [`Value`] has none, so that this is never seen.
pub(super) fn unwritable(error: &toml::ser::Error) -> InvalidInput {
    InvalidInput::new(
        "study",
        error,
        "a study contains numbers, strings, booleans, and lists and tables of these",
        "Convert the values to these.",
    )
}
