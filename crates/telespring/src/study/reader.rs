//! Study text to checked values: every refusal names the dotted field, its line, the value and the remedy.

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::error::{InvalidInput, Result};
use crate::quantity::Quantity;

use super::keys::{Keys, REHEARSAL, SECTIONS, as_written, nearest};

/// A study of more text than this is a slip (the wrong file), not a study.
const LONGEST: usize = 1 << 20;

/// One number, or the two ends of a range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Span {
    pub low: f64,
    pub high: f64,
}

/// A value per axis, or one for all of them.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum PerAxis {
    Every(Span),
    Each(Vec<Span>),
}

impl PerAxis {
    /// The number of axes it prescribes, if it does.
    pub fn count(&self) -> Option<usize> {
        match self {
            Self::Every(_) => None,
            Self::Each(values) => Some(values.len()),
        }
    }

    /// One value for each of `count` axes; a list must have that length.
    pub fn spread(&self, count: usize) -> Vec<Span> {
        match self {
            Self::Every(value) => vec![*value; count],
            Self::Each(values) => values.clone(),
        }
    }
}

/// The text with its table, to look things up with their lines.
pub(super) struct Reader<'a> {
    text: &'a str,
    table: DeTable<'a>,
}

/// A value with its dotted field.
pub(super) struct Entry<'r, 'a> {
    reader: &'r Reader<'a>,
    pub field: String,
    value: &'r Spanned<DeValue<'a>>,
}

/// The value as a person would recognise it in the file, cut short.
fn shown(text: &str, span: std::ops::Range<usize>) -> String {
    const LONGEST_SHOWN: usize = 60;
    let raw = text.get(span).unwrap_or("").trim();
    let line = raw.lines().next().unwrap_or("");
    let short: String = line.chars().take(LONGEST_SHOWN).collect();
    if short.len() < raw.len() { format!("{short} …") } else { short }
}

impl<'a> Reader<'a> {
    /// The table of a study, its sections and keys known.
    pub fn new(text: &'a str) -> Result<Self> {
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
            let line = line_of(text, start);
            let content = text.lines().nth(line - 1).unwrap_or("").trim();
            InvalidInput::new(
                "study",
                format!("{:?}", content.chars().take(60).collect::<String>()),
                format!(
                    "a study is TOML text, and this is not: {}",
                    error.message().trim().replace('\n', ", ")
                ),
                format!("Mend line {line}."),
            )
        })?;
        let reader = Self { text, table: table.into_inner() };
        reader.check_keys()?;
        Ok(reader)
    }

    fn check_keys(&self) -> Result<()> {
        let sections: Vec<&str> = SECTIONS.iter().map(|(name, _)| *name).collect();
        let mut top = vec!["name"];
        top.extend(&sections);
        for (key, value) in &self.table {
            let name = key.get_ref().as_ref();
            let line = line_of(self.text, key.span().start);
            let Some(&(_, keys)) = SECTIONS.iter().find(|(section, _)| *section == name) else {
                if name == "name" {
                    continue;
                }
                let allowed = format!(
                    "a study has a name and the sections {}",
                    sections.iter().map(|name| format!("[{name}]")).collect::<Vec<_>>().join(", ")
                );
                return Err(self.unknown(&as_written(name), name, value, line, allowed, &top, None));
            };
            let Some(section) = value.get_ref().as_table() else {
                return Err(self.refuse(
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

    fn check_section(&self, name: &str, section: &DeTable<'a>, keys: Keys) -> Result<()> {
        if let (kinds @ [_, ..], Some(entry)) = (&keys.kinds()[..], self.get(name, "kind")) {
            entry.choice(kinds)?;
        }
        let (known, kind) = keys.of(section);
        for (key, value) in section {
            let word = key.get_ref().as_ref();
            if known.contains(&word) {
                continue;
            }
            let line = line_of(self.text, key.span().start);
            let allowed = match kind {
                Some(kind) => format!("[{name}] of kind \"{kind}\" has the keys {}", known.join(", ")),
                None => format!("[{name}] has the keys {}", known.join(", ")),
            };
            let field = format!("{name}.{}", as_written(word));
            let mut refusal = self.unknown(&field, word, value, line, allowed, known, Some(name));
            if let Some(other) = keys.kind_with(word) {
                refusal.remedy = format!(
                    "It belongs to kind = \"{other}\": name that kind, or remove the key. See line {line}."
                );
            }
            return Err(refusal);
        }
        Ok(())
    }

    /// Whether the study has this section.
    pub fn has(&self, section: &str) -> bool {
        self.table.contains_key(section)
    }

    /// The kind of a section that comes in several; the first of them where none is named.
    pub fn kind(&self, section: &str) -> Result<&'static str> {
        let kinds = SECTIONS.iter().find(|(name, _)| *name == section).map(|(_, keys)| keys.kinds());
        let kinds = kinds.unwrap_or_default();
        match self.get(section, "kind") {
            Some(entry) => entry.choice(&kinds),
            None => Ok(kinds.first().copied().unwrap_or_default()),
        }
    }

    /// A refusal of a whole section.
    pub fn refuse_section(&self, section: &str, allowed: String, remedy: &str) -> InvalidInput {
        let line = self.table.get(section).map_or(1, |value| line_of(self.text, value.span().start));
        InvalidInput::new(section, "a section", allowed, format!("{remedy} See line {line}."))
    }

    /// The first section that only a rehearsal needs.
    pub fn rehearsal_section(&self) -> Option<&'static str> {
        REHEARSAL.into_iter().find(|name| self.table.contains_key(*name))
    }

    /// A refusal by its dotted field, put to the line of that key, or of its section.
    pub fn locate(&self, mut error: InvalidInput) -> InvalidInput {
        let mut parts = error.field.splitn(2, '.');
        let section = parts.next().unwrap_or_default();
        let key: String =
            parts.next().unwrap_or_default().chars().take_while(|c| !matches!(c, '[' | '.')).collect();
        let place = self.table.get(section).map(|value| {
            let key = value.get_ref().as_table().and_then(|table| table.get(key.as_str()));
            key.unwrap_or(value).span().start
        });
        if let Some(start) = place {
            error.remedy = format!("{} See line {}.", error.remedy, line_of(self.text, start));
        }
        error
    }

    #[expect(clippy::too_many_arguments, reason = "one message, told from two places")]
    fn unknown(
        &self,
        field: &str,
        word: &str,
        value: &Spanned<DeValue<'_>>,
        line: usize,
        allowed: String,
        keys: &[&str],
        section: Option<&str>,
    ) -> InvalidInput {
        let home = SECTIONS
            .iter()
            .find(|(name, keys)| Some(*name) != section && keys.all().contains(&word) && word != "kind")
            .map(|(name, _)| format!("It belongs under [{name}]."));
        let remedy = home
            .or_else(|| nearest(word, keys).map(|key| format!("Did you mean \"{key}\"?")))
            .unwrap_or_else(|| "Remove it, or correct its name.".to_owned());
        let field: String = field.chars().take(80).collect();
        let shown =
            if value.get_ref().is_table() { "a section".to_owned() } else { shown(self.text, value.span()) };
        InvalidInput::new(field, shown, allowed, format!("{remedy} See line {line}."))
    }

    fn refuse(
        &self,
        field: &str,
        value: &Spanned<DeValue<'_>>,
        allowed: impl Into<String>,
        remedy: impl Into<String>,
    ) -> InvalidInput {
        let line = line_of(self.text, value.span().start);
        let shown = match value.get_ref() {
            DeValue::Table(table) if table.is_empty() => "an empty table".to_owned(),
            _ => shown(self.text, value.span()),
        };
        InvalidInput::new(field, shown, allowed, format!("{} See line {line}.", remedy.into()))
    }

    /// The study's name, where it has one.
    pub fn name(&self) -> Result<Option<String>> {
        self.table.get("name").map(|value| self.entry("name".to_owned(), value).text()).transpose()
    }

    fn entry<'r>(&'r self, field: String, value: &'r Spanned<DeValue<'a>>) -> Entry<'r, 'a> {
        Entry { reader: self, field, value }
    }

    /// A key of a section, where both are there.
    pub fn get(&self, section: &str, key: &str) -> Option<Entry<'_, 'a>> {
        let value = self.table.get(section)?.get_ref().as_table()?.get(key)?;
        Some(self.entry(format!("{section}.{key}"), value))
    }

    /// A key of a section that must be there; `like` is an example of it.
    pub fn need(&self, section: &str, key: &str, like: &str) -> Result<Entry<'_, 'a>> {
        self.get(section, key).ok_or_else(|| {
            let place = match self.table.get(section) {
                None => format!("Add the section [{section}] with {like}."),
                Some(value) => {
                    format!(
                        "Add {like} under [{section}]. See line {}.",
                        line_of(self.text, value.span().start)
                    )
                }
            };
            InvalidInput::new(format!("{section}.{key}"), "nothing", "this value is needed", place)
        })
    }

    /// A refusal from the model, put into the file: the section before the field, its line after.
    pub fn place(&self, section: &str, error: InvalidInput) -> InvalidInput {
        let line = self.table.get(section).map(|value| line_of(self.text, value.span().start));
        let mut error = error.within(section);
        if let Some(line) = line {
            error.remedy = format!("{} See line {line}.", error.remedy);
        }
        error
    }
}

/// The line of a byte, counted from 1.
fn line_of(text: &str, byte: usize) -> usize {
    1 + text.as_bytes().iter().take(byte).filter(|&&byte| byte == b'\n').count()
}

impl<'r, 'a> Entry<'r, 'a> {
    /// A refusal of this entry.
    pub fn refuse(&self, allowed: impl Into<String>, remedy: impl Into<String>) -> InvalidInput {
        self.reader.refuse(&self.field, self.value, allowed, remedy)
    }

    /// The line of a refusal that something else made about this entry.
    pub fn place(&self, mut error: InvalidInput) -> InvalidInput {
        let line = line_of(self.reader.text, self.value.span().start);
        error.remedy = format!("{} See line {line}.", error.remedy);
        error
    }

    /// A string.
    pub fn text(&self) -> Result<String> {
        match self.value.get_ref() {
            DeValue::String(text) => Ok(text.clone().into_owned()),
            _ => Err(self.refuse("a text in quotes is needed", "Put it in quotes.")),
        }
    }

    /// One of a few words.
    pub fn choice<'w>(&self, words: &[&'w str]) -> Result<&'w str> {
        let listed = words.iter().map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(", ");
        let given = match self.value.get_ref() {
            DeValue::String(text) => text.as_ref(),
            _ => "",
        };
        words.iter().find(|word| **word == given).copied().ok_or_else(|| {
            let remedy = nearest(given, words)
                .map_or_else(|| "Choose one of them.".to_owned(), |word| format!("Did you mean \"{word}\"?"));
            self.refuse(format!("this is one of {listed}"), remedy)
        })
    }

    /// True or false.
    pub fn boolean(&self) -> Result<bool> {
        self.value
            .get_ref()
            .as_bool()
            .ok_or_else(|| self.refuse("true or false is needed", "Write it without quotes."))
    }

    /// A whole number in a range.
    pub fn whole(&self, what: &str, least: i64, most: i64) -> Result<i64> {
        let value = match self.value.get_ref() {
            DeValue::Integer(integer) => i64::from_str_radix(integer.as_str(), integer.radix()).ok(),
            _ => None,
        };
        let remedy = match value {
            Some(value) if (least..=most).contains(&value) => return Ok(value),
            Some(_) => "Choose a number in that range.",
            None => "Write it without a decimal point, quotes and units.",
        };
        Err(self.refuse(format!("{what} must be a whole number from {least} to {most}"), remedy))
    }

    /// The items of a list.
    pub fn items(&self, what: &str) -> Result<Vec<Self>> {
        let Some(items) = self.value.get_ref().as_array() else {
            return Err(self.refuse(format!("a list of {what} is needed"), "Put it in square brackets."));
        };
        Ok(items.iter().enumerate().map(|(i, item)| self.item(format!("[{i}]"), item)).collect())
    }

    /// The items of a table, each with its key.
    pub fn members(&self) -> Result<Vec<(String, Self)>> {
        let Some(table) = self.value.get_ref().as_table() else {
            return Err(self.refuse("names with values are needed", "Write it such as {gain = 2.0}."));
        };
        let member = |(key, value): (&Spanned<std::borrow::Cow<'a, str>>, &'r Spanned<DeValue<'a>>)| {
            let key = key.get_ref().as_ref();
            (key.to_owned(), self.item(format!(".{}", as_written(key)), value))
        };
        Ok(table.iter().map(|(key, value)| member((key, value))).collect())
    }

    /// What stands there.
    pub fn value(&self) -> &'r DeValue<'a> {
        self.value.get_ref()
    }

    /// Two numbers, or with `one` also one number that stands for both.
    pub fn two(&self, quantity: Quantity, one: bool) -> Result<[f64; 2]> {
        let values = self.per_axis(quantity, false)?;
        match values.count() {
            None if one => {}
            Some(2) => {}
            _ => {
                return Err(self.refuse(
                    if one {
                        "one number or a list of two is needed"
                    } else {
                        "a list of two numbers is needed"
                    },
                    "Write it such as [1.0, 2.0].",
                ));
            }
        }
        let values = values.spread(2);
        Ok([values[0].low, values[1].low])
    }

    /// A list of strings.
    pub fn texts(&self) -> Result<Vec<String>> {
        let Some(items) = self.value.get_ref().as_array() else {
            return Err(
                self.refuse("a list of texts is needed, one per axis", "Write it such as [\"x\", \"y\"].")
            );
        };
        items.iter().enumerate().map(|(i, item)| self.item(format!("[{i}]"), item).text()).collect()
    }

    fn item(&self, suffix: String, value: &'r Spanned<DeValue<'a>>) -> Self {
        Entry { reader: self.reader, field: format!("{}{suffix}", self.field), value }
    }

    /// A table with exactly these two keys, such as min and max; `None` where it is not a table. `instead`
    /// is what else could stand there.
    pub fn pair(&self, keys: [&str; 2], instead: &str) -> Result<Option<[Self; 2]>> {
        let Some(table) = self.value.get_ref().as_table() else { return Ok(None) };
        for (key, value) in table {
            let word = key.get_ref().as_ref();
            if !keys.contains(&word) {
                let line = line_of(self.reader.text, key.span().start);
                let allowed = format!("this has the keys {} and {}", keys[0], keys[1]);
                let field = format!("{}.{}", self.field, as_written(word));
                return Err(self.reader.unknown(&field, word, value, line, allowed, &keys, Some("")));
            }
        }
        let part = |key: &str| match table.get(key) {
            Some(value) => Ok(self.item(format!(".{key}"), value)),
            None => Err(self.refuse(
                format!("both {} and {} are needed", keys[0], keys[1]),
                if instead.is_empty() {
                    format!("Add {key} = ….")
                } else {
                    format!("Add {key} = …, {instead}.")
                },
            )),
        };
        Ok(Some([part(keys[0])?, part(keys[1])?]))
    }

    /// A number in the range of a quantity.
    pub fn number(&self, quantity: Quantity, kinds: &str) -> Result<f64> {
        let value = match self.value.get_ref() {
            DeValue::Float(float) => float.as_str().parse::<f64>().ok(),
            DeValue::Integer(integer) => {
                let (digits, radix) = (integer.as_str(), integer.radix());
                i128::from_str_radix(digits, radix)
                    .ok()
                    .map(|value| value as f64)
                    .or_else(|| digits.parse().ok())
            }
            _ => None,
        };
        let Some(value) = value else {
            return Err(self.refuse(format!("{kinds} is needed"), "Write numbers without quotes and units."));
        };
        quantity.check(&self.field, value).map_err(|error| self.place(error))
    }

    /// A number, or with `ranges` also {min = …, max = …}.
    fn span(&self, quantity: Quantity, ranges: bool, kinds: &str) -> Result<Span> {
        if ranges && let Some([low, high]) = self.pair(["min", "max"], "or give one number")? {
            let (from, to) = (low.number(quantity, "a number")?, high.number(quantity, "a number")?);
            if from > to {
                return Err(self.refuse("min must not exceed max", "Exchange the two."));
            }
            return Ok(Span { low: from, high: to });
        }
        let value = self.number(quantity, kinds)?;
        Ok(Span { low: value, high: value })
    }

    /// A number, a list of them, one per axis, and with `ranges` {min = …, max = …} for any number.
    pub fn per_axis(&self, quantity: Quantity, ranges: bool) -> Result<PerAxis> {
        let kinds = if ranges {
            "a number, a range {min = …, max = …} or a list of these, one per axis,"
        } else {
            "a number or a list of numbers, one per axis,"
        };
        let Some(items) = self.value.get_ref().as_array() else {
            return Ok(PerAxis::Every(self.span(quantity, ranges, kinds)?));
        };
        if items.is_empty() {
            return Err(self.refuse(format!("{kinds} is needed"), "Give one value per axis."));
        }
        let kind = if ranges { "a number or a range {min = …, max = …}" } else { "a number" };
        items
            .iter()
            .enumerate()
            .map(|(i, item)| self.item(format!("[{i}]"), item).span(quantity, ranges, kind))
            .collect::<Result<_>>()
            .map(PerAxis::Each)
    }
}
