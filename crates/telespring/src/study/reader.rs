//! Reads the sections and keys of a study file; every error gives the dotted field and its line.

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::entry::Entry;
use super::keys::{Keys, REHEARSAL, SECTIONS, toml_key};
use super::source::{Source, UnknownKey};
use crate::error::{InvalidInput, Result};
use crate::quantity::Quantity;

/// A longer text is the wrong file, not a study.
const LONGEST: usize = 1 << 20;

/// The parsed text of a study file.
pub(super) struct Reader<'a> {
    source: Source<'a>,
    table: DeTable<'a>,
}

impl<'a> Reader<'a> {
    /// Parses the text and checks that all sections and keys are known.
    pub fn new(source: Source<'a>) -> Result<Self> {
        let text = source.text();
        if text.len() > LONGEST {
            return Err(InvalidInput::new(
                "study",
                format!("{} bytes of text", text.len()),
                format!("a study has at most {LONGEST} bytes"),
                "Check that this is the study file.",
            ));
        }
        let table = DeTable::parse(text).map_err(|error| {
            let start = error.span().map_or(0, |span| span.start);
            let line = source.line(start);
            let content = text.lines().nth(line - 1).unwrap_or("").trim();
            InvalidInput::new(
                "study",
                format!("{:?}", content.chars().take(60).collect::<String>()),
                format!("a study must be valid TOML: {}", error.message().trim().replace('\n', ", ")),
                format!("Correct line {line}."),
            )
        })?;
        let reader = Self { source, table: table.into_inner() };
        reader.check_keys()?;
        Ok(reader)
    }

    /// The reader's check that all sections are known, and the keys in them.
    fn check_keys(&self) -> Result<()> {
        let sections: Vec<&str> = SECTIONS.iter().map(|(name, _)| *name).collect();
        let mut top = vec!["name"];
        top.extend(&sections);
        for (key, value) in &self.table {
            let name = key.get_ref().as_ref();
            let Some(&(_, keys)) = SECTIONS.iter().find(|(section, _)| *section == name) else {
                if name == "name" {
                    continue;
                }
                let allowed = format!(
                    "a study has a name and the sections {}",
                    sections.iter().map(|name| format!("[{name}]")).collect::<Vec<_>>().join(", ")
                );
                let unknown = UnknownKey {
                    field: &toml_key(name),
                    key: name,
                    position: key.span().start,
                    section: None,
                    allowed,
                    keys: &top,
                };
                return Err(self.source.reject_unknown_key(unknown, value));
            };
            let Some(section) = value.get_ref().as_table() else {
                return Err(self.source.reject(
                    name,
                    value,
                    format!("[{name}] is a section with the keys {}", keys.all().join(", ")),
                    format!("Write [{name}] on a line of its own and its keys below."),
                ));
            };
            self.check_section(name, section, keys)?;
        }
        Ok(())
    }

    /// The reader's check that all keys of a section are known.
    fn check_section(&self, name: &str, section: &DeTable<'a>, keys: Keys) -> Result<()> {
        if let (kinds @ [_, ..], Some(entry)) = (&keys.kinds()[..], self.get(name, "kind")) {
            entry.choice(kinds)?;
        }
        let (known, kind) = keys.allowed_in(section);
        for (key, value) in section {
            let word = key.get_ref().as_ref();
            if known.contains(&word) {
                continue;
            }
            let position = key.span().start;
            let allowed = match kind {
                Some(kind) => format!("[{name}] of kind \"{kind}\" has the keys {}", known.join(", ")),
                None => format!("[{name}] has the keys {}", known.join(", ")),
            };
            let unknown = UnknownKey {
                field: &format!("{name}.{}", toml_key(word)),
                key: word,
                position,
                section: Some(name),
                allowed,
                keys: known,
            };
            let mut refusal = self.source.reject_unknown_key(unknown, value);
            if let Some(other) = keys.kind_with_key(word) {
                refusal.remedy =
                    format!("It belongs to kind = \"{other}\": set that kind, or remove the key.");
                refusal = self.source.with_line(refusal, position);
            }
            return Err(refusal);
        }
        Ok(())
    }

    /// Whether the study file has a section.
    pub fn has(&self, section: &str) -> bool {
        self.table.contains_key(section)
    }

    /// The kind of a section of the study file; the first kind by default.
    pub fn kind(&self, section: &str) -> Result<&'static str> {
        let kinds = SECTIONS.iter().find(|(name, _)| *name == section).map(|(_, keys)| keys.kinds());
        let kinds = kinds.unwrap_or_default();
        match self.get(section, "kind") {
            Some(entry) => entry.choice(&kinds),
            None => Ok(kinds.first().copied().unwrap_or_default()),
        }
    }

    /// The error for a whole section of the study file.
    pub fn reject_section(&self, section: &str, allowed: String, remedy: &str) -> InvalidInput {
        let position = self.table.get(section).map_or(0, |value| value.span().start);
        self.source.with_line(InvalidInput::new(section, "a section", allowed, remedy), position)
    }

    /// The first section that only a rehearsal needs.
    pub fn rehearsal_section(&self) -> Option<&'static str> {
        REHEARSAL.into_iter().find(|name| self.table.contains_key(*name))
    }

    /// Adds the line of the field of an error: of its key, or else of its section.
    pub fn with_line_of_field(&self, error: InvalidInput) -> InvalidInput {
        let mut parts = error.field.splitn(2, '.');
        let section = parts.next().unwrap_or_default();
        let key: String =
            parts.next().unwrap_or_default().chars().take_while(|c| !matches!(c, '[' | '.')).collect();
        let place = self.table.get(section).map(|value| {
            let key = value.get_ref().as_table().and_then(|table| table.get(key.as_str()));
            key.unwrap_or(value).span().start
        });
        match place {
            Some(position) => self.source.with_line(error, position),
            None => error,
        }
    }

    /// The name of the study, if given in the file.
    pub fn name(&self) -> Result<Option<String>> {
        self.table.get("name").map(|value| self.entry("name".to_owned(), value).text()).transpose()
    }

    /// A value of the study file with its dotted field.
    fn entry<'r>(&'r self, field: String, value: &'r Spanned<DeValue<'a>>) -> Entry<'r, 'a> {
        Entry { source: self.source, field, value }
    }

    /// The value of a key in a section of the study file, if given.
    pub fn get(&self, section: &str, key: &str) -> Option<Entry<'_, 'a>> {
        let value = self.table.get(section)?.get_ref().as_table()?.get(key)?;
        Some(self.entry(format!("{section}.{key}"), value))
    }

    /// The number of a key in a section; 0 if the key is missing.
    pub fn number_or_zero(&self, section: &str, key: &str, quantity: Quantity) -> Result<f64> {
        self.get(section, key).map_or(Ok(0.0), |entry| entry.number(quantity, "a number"))
    }

    /// The value of a required key in a section; the error for a missing one gives the unit and an example.
    pub fn require(&self, section: &str, key: &str, unit: &str, example: &str) -> Result<Entry<'_, 'a>> {
        self.get(section, key).ok_or_else(|| {
            let missing = |remedy: String| InvalidInput::missing(format!("{section}.{key}"), unit, remedy);
            match self.table.get(section) {
                None => missing(format!("Add a section [{section}] with {key} = {example}.")),
                Some(value) => {
                    let remedy = format!("Add {key} = {example} under [{section}].");
                    self.source.with_line(missing(remedy), value.span().start)
                }
            }
        })
    }

    /// Adds the section and its line to an error of the model.
    pub fn place(&self, section: &str, error: InvalidInput) -> InvalidInput {
        let error = error.within(section);
        match self.table.get(section) {
            Some(value) => self.source.with_line(error, value.span().start),
            None => error,
        }
    }
}
