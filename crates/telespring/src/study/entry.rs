//! One value of a study's text: read as what it must be, or refused with its line.

use toml::Spanned;
use toml::de::DeValue;

use super::keys::{as_written, nearest};
use super::source::{Source, UnknownKey};
use crate::error::{InvalidInput, Result};
use crate::quantity::Quantity;

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

/// A value with its dotted field.
pub(super) struct Entry<'r, 'a> {
    pub(super) source: Source<'a>,
    pub(super) field: String,
    pub(super) value: &'r Spanned<DeValue<'a>>,
}

impl<'r, 'a> Entry<'r, 'a> {
    /// A refusal of this entry.
    pub fn refuse(&self, allowed: impl Into<String>, remedy: impl Into<String>) -> InvalidInput {
        self.source.refuse(&self.field, self.value, allowed, remedy)
    }

    /// The line of a refusal that something else made about this entry.
    pub fn place(&self, error: InvalidInput) -> InvalidInput {
        self.source.with_line(error, self.value.span().start)
    }

    /// A string.
    pub fn text(&self) -> Result<String> {
        match self.value.get_ref() {
            DeValue::String(text) if text.contains('\0') => Err(self.refuse(
                "a text without the character U+0000 is needed, which no dataset can hold",
                "Remove \\u0000.",
            )),
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
        let remedy = match self.value.get_ref() {
            // one that does not fit in 64 bits is a whole number out of the range as well
            DeValue::Integer(integer) => match i64::from_str_radix(integer.as_str(), integer.radix()) {
                Ok(value) if (least..=most).contains(&value) => return Ok(value),
                _ => "Choose a number in that range.",
            },
            _ => "Write it without a decimal point, quotes and units.",
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
        Entry { source: self.source, field: format!("{}{suffix}", self.field), value }
    }

    /// A table with exactly these two keys, such as min and max; `None` where it is not a table. `instead`
    /// is what else could stand there.
    pub fn pair(&self, keys: [&str; 2], instead: &str) -> Result<Option<[Self; 2]>> {
        let Some(table) = self.value.get_ref().as_table() else { return Ok(None) };
        for (key, value) in table {
            let word = key.get_ref().as_ref();
            if !keys.contains(&word) {
                let unknown = UnknownKey {
                    field: &format!("{}.{}", self.field, as_written(word)),
                    key: word,
                    position: key.span().start,
                    section: Some(""),
                    allowed: format!("this has the keys {} and {}", keys[0], keys[1]),
                    keys: &keys,
                };
                return Err(self.source.refuse_unknown_key(unknown, value));
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
