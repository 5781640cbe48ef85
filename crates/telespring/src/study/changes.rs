//! A study file with some of its values replaced before any is checked, so that only the whole is judged.

use std::collections::BTreeMap;

use toml::de::DeTable;
use toml::{Table, Value};

use super::replace::{excluded_by, unwritable};
use super::source::Source;
use super::{Replacement, RobotFile, Study};
use crate::error::Result;

/// What takes the place of parts of a study's text.
pub(super) struct Changes {
    text: String,
    /// Sections, or one key of a section, that the text loses.
    removed: Vec<(String, Option<String>)>,
}

impl Changes {
    /// The changes that replace whole robots, and sections or keys.
    fn new(robots: [Option<&RobotFile>; 2], sections: &BTreeMap<String, Replacement>) -> Result<Self> {
        let mut added = Table::new();
        let mut removed = Vec::new();
        for (i, file) in robots.into_iter().enumerate() {
            let Some(file) = file else { continue };
            let section = format!("robot{}", i + 1);
            removed.push((section.clone(), None));
            added.insert(section, Value::Table(file.robot()?));
        }
        for (name, replacement) in sections {
            match replacement {
                Replacement::Default => removed.push((name.clone(), None)),
                Replacement::Value(value) => drop(added.insert(name.clone(), value.clone())),
                Replacement::Keys(keys) => {
                    for (key, value) in keys {
                        removed.push((name.clone(), Some(key.clone())));
                        let excluded = excluded_by(name, key);
                        removed.extend(
                            excluded.map(|(section, key)| (section.to_owned(), Some(key.to_owned()))),
                        );
                        let Some(value) = value else { continue };
                        let section = added.entry(name.clone()).or_insert_with(|| Value::Table(Table::new()));
                        if let Value::Table(section) = section {
                            section.insert(key.clone(), value.clone());
                        }
                    }
                }
            }
        }
        let text = toml::to_string(&added).map_err(|error| unwritable(&error))?;
        Ok(Self { text, removed })
    }

    /// The text of what is added to a study.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Removes from a study's table what the changes replace.
    pub fn remove_from(&self, table: &mut DeTable<'_>) {
        for (section, key) in &self.removed {
            match key {
                None => drop(table.remove(section.as_str())),
                Some(key) => {
                    if let Some(toml::de::DeValue::Table(section)) =
                        table.get_mut(section.as_str()).map(toml::Spanned::get_mut)
                    {
                        drop(section.remove(key.as_str()));
                    }
                }
            }
        }
    }
}

impl Study {
    /// Reads a study from TOML text with whole robots, sections or keys replaced before any value is checked:
    /// a robot with one axis may take the place of one with two if the other robot does so too.
    ///
    /// A section without the replaced keys keeps its others, its `kind` included. A spring to the ground that a
    /// robot file records is the robot's, as by [`Study::with_robot`].
    ///
    /// # Errors
    ///
    /// [`InvalidInput`](crate::InvalidInput) as for [`Study::from_toml`]; a value of the text is named with its
    /// line, one of a robot file with the name of the file.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::study::{RobotFile, Study};
    /// let robot = RobotFile::from_toml("[robot]\nmass = 0.84\ndamping = 7.7", "left.toml")?;
    /// let two_axes = "robot1 = {mass = [1, 2], damping = 5}\nrobot2 = {mass = [1, 2], damping = 5}";
    /// let study = Study::from_changed_toml(two_axes, [Some(&robot), Some(&robot)], &[].into())?;
    /// assert_eq!(study.dyad().robots()[1].mass(), [0.84]);
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn from_changed_toml(
        text: &str,
        robots: [Option<&RobotFile>; 2],
        sections: &BTreeMap<String, Replacement>,
    ) -> Result<Self> {
        let changes = Changes::new(robots, sections)?;
        Self::read(Source::file(text), Some(&changes)).map_err(|mut refusal| {
            for (i, file) in robots.into_iter().enumerate() {
                let section = format!("robot{}", i + 1);
                if let Some(file) = file
                    && refusal.field.starts_with(&section)
                {
                    file.sign(&mut refusal, &section);
                }
            }
            refusal
        })
    }
}
