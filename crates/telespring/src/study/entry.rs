//! One value of a study file: converted to its type, or rejected with its line.

use toml::Spanned;
use toml::de::DeValue;

use super::keys::{nearest_word, toml_key};
use super::source::{Source, UnknownKey};
use crate::error::{InvalidInput, Result};
use crate::quantity::Quantity;

/// One number, or the two ends of a range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Span {
    pub low: f64,
    pub high: f64,
}

/// One value per axis, or one for all axes.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum PerAxis {
    Every(Span),
    Each(Vec<Span>),
}

impl PerAxis {
    /// The number of axes in an entry's list; `None` for a single value.
    pub fn count(&self) -> Option<usize> {
        match self {
            Self::Every(_) => None,
            Self::Each(values) => Some(values.len()),
        }
    }

    /// One value of an entry for each of `count` axes; a list must have that length.
    pub fn spread(&self, count: usize) -> Vec<Span> {
        match self {
            Self::Every(value) => vec![*value; count],
            Self::Each(values) => values.clone(),
        }
    }
}

/// A value of a study file with its dotted field.
pub(super) struct Entry<'r, 'a> {
    pub(super) source: Source<'a>,
    pub(super) field: String,
    pub(super) value: &'r Spanned<DeValue<'a>>,
}

impl<'r, 'a> Entry<'r, 'a> {
    /// The error for this entry of the study file.
    pub fn reject(&self, allowed: impl Into<String>, remedy: impl Into<String>) -> InvalidInput {
        self.source.reject(&self.field, self.value, allowed, remedy)
    }

    /// Adds the line of this entry in the study file to an error.
    pub fn place(&self, error: InvalidInput) -> InvalidInput {
        self.source.with_line(error, self.value.span().start)
    }

    /// Reads an entry of the study file as a string.
    pub fn text(&self) -> Result<String> {
        match self.value.get_ref() {
            DeValue::String(text) if text.contains('\0') => Err(self.reject(
                "text without the character U+0000 is required, because datasets cannot contain it",
                "Remove \\u0000.",
            )),
            DeValue::String(text) => Ok(text.clone().into_owned()),
            _ => Err(self.reject("a string in quotes is required", "Put it in quotes.")),
        }
    }

    /// Reads an entry of the study file as one of several words.
    pub fn choice<'w>(&self, words: &[&'w str]) -> Result<&'w str> {
        let listed = words.iter().map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(", ");
        let given = match self.value.get_ref() {
            DeValue::String(text) => text.as_ref(),
            _ => "",
        };
        words.iter().find(|word| **word == given).copied().ok_or_else(|| {
            let remedy = nearest_word(given, words)
                .map_or_else(|| "Choose one of them.".to_owned(), |word| format!("Did you mean \"{word}\"?"));
            self.reject(format!("it must be one of {listed}"), remedy)
        })
    }

    /// Reads an entry of the study file as a boolean.
    pub fn boolean(&self) -> Result<bool> {
        self.value
            .get_ref()
            .as_bool()
            .ok_or_else(|| self.reject("true or false is required", "Write it without quotes."))
    }

    /// Reads an entry of the study file as a whole number within a range.
    pub fn whole_number(&self, what: &str, least: i64, most: i64) -> Result<i64> {
        let remedy = match self.value.get_ref() {
            // A number beyond 64 bits is out of range too.
            DeValue::Integer(integer) => match i64::from_str_radix(integer.as_str(), integer.radix()) {
                Ok(value) if (least..=most).contains(&value) => return Ok(value),
                _ => "Choose a number in that range.",
            },
            _ => "Write it without a decimal point, quotes or a unit.",
        };
        Err(self.reject(format!("{what} must be a whole number from {least} to {most}"), remedy))
    }

    /// The items of a list entry in the study file.
    pub fn items(&self, what: &str) -> Result<Vec<Self>> {
        let Some(items) = self.value.get_ref().as_array() else {
            return Err(self.reject(format!("a list of {what} is required"), "Put it in square brackets."));
        };
        Ok(items.iter().enumerate().map(|(i, item)| self.child(format!("[{i}]"), item)).collect())
    }

    /// The members of a table entry in the study file with their keys.
    pub fn members(&self) -> Result<Vec<(String, Self)>> {
        let Some(table) = self.value.get_ref().as_table() else {
            return Err(
                self.reject("a table of names and values is required", "Write, for example, {gain = 2.0}.")
            );
        };
        let member = |(key, value): (&Spanned<std::borrow::Cow<'a, str>>, &'r Spanned<DeValue<'a>>)| {
            let key = key.get_ref().as_ref();
            (key.to_owned(), self.child(format!(".{}", toml_key(key)), value))
        };
        Ok(table.iter().map(|(key, value)| member((key, value))).collect())
    }

    /// The parsed TOML value of an entry.
    pub fn value(&self) -> &'r DeValue<'a> {
        self.value.get_ref()
    }

    /// Reads an entry as two numbers, or with `one` also a single number for both.
    pub fn two_numbers(&self, quantity: Quantity, one: bool) -> Result<[f64; 2]> {
        let values = self.per_axis(quantity, false)?;
        match values.count() {
            None if one => {}
            Some(2) => {}
            _ => {
                return Err(self.reject(
                    if one {
                        "one number or a list of two is required"
                    } else {
                        "a list of two numbers is required"
                    },
                    "Write, for example, [1.0, 2.0].",
                ));
            }
        }
        let values = values.spread(2);
        Ok([values[0].low, values[1].low])
    }

    /// Reads an entry of the study file as a list of strings.
    pub fn text_list(&self) -> Result<Vec<String>> {
        let Some(items) = self.value.get_ref().as_array() else {
            return Err(self.reject(
                "a list of strings is required, one per axis",
                "Write, for example, [\"x\", \"y\"].",
            ));
        };
        items.iter().enumerate().map(|(i, item)| self.child(format!("[{i}]"), item).text()).collect()
    }

    /// The kind that an entry names: a word, or that of a table under the key kind.
    pub fn kind<'w>(&self, kinds: &[&'w str]) -> Result<&'w str> {
        let Some(table) = self.value.get_ref().as_table() else { return self.choice(kinds) };
        match table.get("kind") {
            Some(kind) => self.child(".kind".to_owned(), kind).choice(kinds),
            None => {
                let first = kinds.first().unwrap_or(&"");
                let missing = InvalidInput::missing(format!("{}.kind", self.field), "", "");
                let listed = kinds.iter().map(|kind| format!("\"{kind}\"")).collect::<Vec<_>>().join(", ");
                let remedy = format!("Add, for example, kind = \"{first}\"; the kinds are {listed}.");
                Err(self.place(InvalidInput { remedy, ..missing }))
            }
        }
    }

    /// An item or member of this entry of the study file, with its own field.
    fn child(&self, suffix: String, value: &'r Spanned<DeValue<'a>>) -> Self {
        Entry { source: self.source, field: format!("{}{suffix}", self.field), value }
    }

    /// Reads an entry as a table with exactly these two keys, such as min and max; `None` if it is not a table.
    /// `instead` describes the alternative.
    pub fn pair(&self, keys: [&str; 2], instead: &str) -> Result<Option<[Self; 2]>> {
        let Some([one, other]) = self.parts(keys)? else { return Ok(None) };
        let part = |key: &str, given: Option<Self>| match given {
            Some(entry) => Ok(entry),
            None => Err(self.place(InvalidInput::missing(
                format!("{}.{key}", self.field),
                "",
                if instead.is_empty() {
                    format!("Add {key} = ….")
                } else {
                    format!("Add {key} = …, {instead}.")
                },
            ))),
        };
        Ok(Some([part(keys[0], one)?, part(keys[1], other)?]))
    }

    /// Checks that an entry of the study file that is a table has none but these keys.
    pub fn check_keys(&self, keys: &[&str]) -> Result<()> {
        let Some(table) = self.value.get_ref().as_table() else { return Ok(()) };
        for (key, value) in table {
            let word = key.get_ref().as_ref();
            if !keys.contains(&word) {
                let (last, others) = keys.split_last().unwrap_or((&"", &[]));
                let unknown = UnknownKey {
                    field: &format!("{}.{}", self.field, toml_key(word)),
                    key: word,
                    position: key.span().start,
                    section: Some(""),
                    allowed: match others {
                        [] => format!("its only key is {last}"),
                        _ => format!("its keys are {} and {last}", others.join(", ")),
                    },
                    keys,
                };
                return Err(self.source.reject_unknown_key(unknown, value));
            }
        }
        Ok(())
    }

    /// The parts of an entry that is a table with some of these keys, in their order; `None` if it is not a table.
    pub fn parts<const N: usize>(&self, keys: [&str; N]) -> Result<Option<[Option<Self>; N]>> {
        let Some(table) = self.value.get_ref().as_table() else { return Ok(None) };
        self.check_keys(&keys)?;
        Ok(Some(keys.map(|key| table.get(key).map(|value| self.child(format!(".{key}"), value)))))
    }

    /// Reads an entry of the study file as a number within the range of a quantity.
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
            let written = self.value.get_ref().as_str().and_then(|text| quantity.read_with_unit(text));
            let remedy = match written {
                Some(value) => {
                    format!("Write {value}: a study has numbers in {}, without quotes.", quantity.unit())
                }
                None if quantity.unit().is_empty() => "Write the number without quotes.".to_owned(),
                None => format!("Write the number alone, in {}, without quotes.", quantity.unit()),
            };
            return Err(self.reject(format!("{kinds} is required"), remedy));
        };
        let checked = quantity.check(&self.field, value);
        let checked = match checked {
            Ok(value) if !self.source.allows_unusual => quantity.check_usual(&self.field, value),
            other => other,
        };
        checked.map_err(|error| self.place(error))
    }

    /// Reads an entry as a number, or with `ranges` also {min = …, max = …}.
    fn number_or_range(&self, quantity: Quantity, ranges: bool, kinds: &str) -> Result<Span> {
        if ranges && let Some([low, high]) = self.pair(["min", "max"], "or give one number")? {
            let (from, to) = (low.number(quantity, "a number")?, high.number(quantity, "a number")?);
            if from > to {
                return Err(self.reject("the minimum must not exceed the maximum", "Swap the two."));
            }
            return Ok(Span { low: from, high: to });
        }
        let value = self.number(quantity, kinds)?;
        Ok(Span { low: value, high: value })
    }

    /// Reads an entry as a number or a list, one per axis; with `ranges` any number may be {min = …, max = …}.
    pub fn per_axis(&self, quantity: Quantity, ranges: bool) -> Result<PerAxis> {
        let kinds = if ranges {
            "a number, a range {min = …, max = …} or a list of these, one per axis,"
        } else {
            "a number or a list of numbers, one per axis,"
        };
        let Some(items) = self.value.get_ref().as_array() else {
            return Ok(PerAxis::Every(self.number_or_range(quantity, ranges, kinds)?));
        };
        if items.is_empty() {
            return Err(self.reject(format!("{kinds} is required"), "Give one value per axis."));
        }
        let kind = if ranges { "a number or a range {min = …, max = …}" } else { "a number" };
        items
            .iter()
            .enumerate()
            .map(|(i, item)| self.child(format!("[{i}]"), item).number_or_range(quantity, ranges, kind))
            .collect::<Result<_>>()
            .map(PerAxis::Each)
    }
}
