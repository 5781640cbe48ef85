//! Reads the sections and keys of a study file; every error gives the dotted field and its line.

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::changes::Changes;
use super::entry::Entry;
use super::keys::{Keys, REHEARSAL, SECTIONS, TOP, toml_key};
use super::other_files::{is_robot_file, remedy_for_table};
use super::source::{Source, UnknownKey};
use crate::error::{InvalidInput, Result};
use crate::quantity::Quantity;

/// A longer text is the wrong file, not a study.
const LONGEST: usize = 1 << 20;

/// The parsed text of a study file, and what takes the place of parts of it.
pub(super) struct Reader<'a> {
    source: Source<'a>,
    table: DeTable<'a>,
    changes: Option<(Source<'a>, DeTable<'a>)>,
}

impl<'a> Reader<'a> {
    /// Parses the text, makes the changes, and checks that all sections and keys are known.
    pub fn new(source: Source<'a>, changes: Option<&'a Changes>) -> Result<Self> {
        let mut reader = Self { source, table: parse(source)?, changes: None };
        if let Some(changes) = changes {
            changes.remove_from(&mut reader.table);
            let source = Source::generated(changes.text());
            reader.changes = Some((source, parse(source)?));
        }
        let allows_unusual = reader.top("allow_unusual").map_or(Ok(false), |entry| entry.boolean())?;
        reader.source.allows_unusual |= allows_unusual;
        if let Some((changed, _)) = &mut reader.changes {
            changed.allows_unusual |= allows_unusual;
        }
        reader.check_keys()?;
        Ok(reader)
    }

    /// The changes to the study's text, then the text: the first that has a value counts.
    fn layers(&self) -> impl Iterator<Item = (Source<'a>, &DeTable<'a>)> {
        let changes = self.changes.iter().map(|(source, table)| (*source, table));
        changes.chain(std::iter::once((self.source, &self.table)))
    }

    /// The reader's check that all sections are known, and the keys in them.
    fn check_keys(&self) -> Result<()> {
        if is_robot_file(&self.table) {
            return Err(InvalidInput::new(
                "study",
                "[robot]",
                "this is a robot file, which has one robot; a study has [robot1] and [robot2]",
                "Give it as a robot: telespring decide --robot FILE --robot FILE for two such robots. In Python, \
                 pass it to Study.with_robot.",
            ));
        }
        let sections: Vec<&str> = SECTIONS.iter().map(|(name, _)| *name).collect();
        let mut top = TOP.to_vec();
        top.extend(&sections);
        for (source, key, value) in self
            .layers()
            .flat_map(|(source, table)| table.iter().map(move |(key, value)| (source, key, value)))
        {
            let name = key.get_ref().as_ref();
            let Some(&(_, keys)) = SECTIONS.iter().find(|(section, _)| *section == name) else {
                if TOP.contains(&name) {
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
                return Err(source.reject_unknown_key(unknown, value));
            };
            let Some(section) = value.get_ref().as_table() else {
                return Err(source.reject(
                    name,
                    value,
                    format!("[{name}] is a section with the keys {}", keys.all().join(", ")),
                    format!("Write [{name}] on a line of its own and its keys below."),
                ));
            };
            self.check_section(source, name, section, keys)?;
        }
        Ok(())
    }

    /// The reader's check that all keys of a section are known.
    fn check_section(&self, source: Source<'a>, name: &str, section: &DeTable<'a>, keys: Keys) -> Result<()> {
        if let (kinds @ [_, ..], Some(entry)) = (&keys.kinds()[..], self.get(name, "kind")) {
            entry.choice(kinds)?;
        }
        let kind = self.get(name, "kind");
        let (known, kind) = keys.allowed_in(kind.as_ref().and_then(|kind| kind.value().as_str()));
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
            let mut refusal = source.reject_unknown_key(unknown, value);
            if let Some(other) = keys.kind_with_key(word) {
                refusal.remedy =
                    format!("It belongs to kind = \"{other}\": set that kind, or remove the key.");
                refusal = source.with_line(refusal, position);
            }
            return Err(refusal);
        }
        Ok(())
    }

    /// Whether the study file has a section.
    pub fn has(&self, section: &str) -> bool {
        self.section(section).is_some()
    }

    /// A section of the study file or of the changes to it, with its source.
    fn section(&self, name: &str) -> Option<(Source<'a>, &Spanned<DeValue<'a>>)> {
        self.layers().find_map(|(source, table)| Some((source, table.get(name)?)))
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
        let refusal = InvalidInput::new(section, "a section", allowed, remedy);
        match self.section(section) {
            Some((source, value)) => source.with_line(refusal, value.span().start),
            None => refusal,
        }
    }

    /// The first section that only a rehearsal needs.
    pub fn rehearsal_section(&self) -> Option<&'static str> {
        REHEARSAL.into_iter().find(|name| self.has(name))
    }

    /// Adds the line of the field of an error: of its key, or else of its section.
    pub fn with_line_of_field(&self, error: InvalidInput) -> InvalidInput {
        let mut parts = error.field.splitn(2, '.');
        let section = parts.next().unwrap_or_default();
        let key: String =
            parts.next().unwrap_or_default().chars().take_while(|c| !matches!(c, '[' | '.')).collect();
        let entry = self.get(section, &key).map(|entry| (entry.source, entry.value));
        match entry.or_else(|| self.section(section)) {
            Some((source, value)) => source.with_line(error, value.span().start),
            None => error,
        }
    }

    /// The name of the study, if given in the file.
    pub fn name(&self) -> Result<Option<String>> {
        self.top("name").map(|entry| entry.text()).transpose()
    }

    /// Whether the study accepts values that no laboratory has.
    pub fn allows_unusual(&self) -> bool {
        self.source.allows_unusual
    }

    /// A value of the study file outside its sections.
    fn top(&self, key: &str) -> Option<Entry<'_, 'a>> {
        let (source, value) = self.section(key)?;
        Some(Entry { source, field: key.to_owned(), value })
    }

    /// The value of a key in a section of the study file, if given.
    pub fn get(&self, section: &str, key: &str) -> Option<Entry<'_, 'a>> {
        let field = format!("{section}.{key}");
        self.layers().find_map(|(source, table)| {
            let value = table.get(section)?.get_ref().as_table()?.get(key)?;
            Some(Entry { source, field: field.clone(), value })
        })
    }

    /// The number of a key in a section; 0 if the key is missing.
    pub fn number_or_zero(&self, section: &str, key: &str, quantity: Quantity) -> Result<f64> {
        self.get(section, key).map_or(Ok(0.0), |entry| entry.number(quantity, "a number"))
    }

    /// The value of a required key in a section; the error for a missing one gives the unit and an example.
    pub fn require(&self, section: &str, key: &str, unit: &str, example: &str) -> Result<Entry<'_, 'a>> {
        self.get(section, key).ok_or_else(|| {
            let missing = |remedy: String| InvalidInput::missing(format!("{section}.{key}"), unit, remedy);
            match self.section(section) {
                None => missing(format!("Add a section [{section}] with {key} = {example}.")),
                Some((source, value)) => {
                    let remedy = format!("Add {key} = {example} under [{section}].");
                    source.with_line(missing(remedy), value.span().start)
                }
            }
        })
    }

    /// Adds the section and its line to an error of the model.
    pub fn place(&self, section: &str, error: InvalidInput) -> InvalidInput {
        let error = error.within(section);
        match self.section(section) {
            Some((source, value)) => source.with_line(error, value.span().start),
            None => error,
        }
    }
}

/// The table that a study's text contains.
fn parse(source: Source<'_>) -> Result<DeTable<'_>> {
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
            remedy_for_table(text).map_or_else(|| format!("Correct line {line}."), str::to_owned),
        )
    })?;
    Ok(table.into_inner())
}
