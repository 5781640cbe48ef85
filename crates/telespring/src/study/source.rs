//! The text of a study file, and errors that quote a value with its line.

use toml::Spanned;
use toml::de::DeValue;

use super::keys::{SECTIONS, nearest_word};
use crate::error::InvalidInput;

/// The text of a study.
#[derive(Debug, Clone, Copy)]
pub(super) struct Source<'a> {
    text: &'a str,
    /// False if no person has seen the text, so that its lines mean nothing.
    has_lines: bool,
    /// True if values that no laboratory has are accepted.
    pub(super) allows_unusual: bool,
}

/// A key that the study format does not know.
pub(super) struct UnknownKey<'k> {
    /// The dotted field.
    pub field: &'k str,
    /// The key as written.
    pub key: &'k str,
    /// The position of the key in the text, in bytes.
    pub position: usize,
    /// Its section; `None` at the top level.
    pub section: Option<&'k str>,
    /// A sentence that lists the keys allowed in its place.
    pub allowed: String,
    /// Those keys.
    pub keys: &'k [&'k str],
}

impl<'a> Source<'a> {
    /// The source text of a file.
    pub fn file(text: &'a str) -> Self {
        Self { text, has_lines: true, allows_unusual: false }
    }

    /// A source written by the library itself: its errors name no line.
    pub fn generated(text: &'a str) -> Self {
        Self { text, has_lines: false, allows_unusual: false }
    }

    /// The whole source text.
    pub fn text(&self) -> &'a str {
        self.text
    }

    /// The line in the source of a byte position, counted from 1.
    pub fn line(&self, position: usize) -> usize {
        1 + self.text.as_bytes().iter().take(position).filter(|&&byte| byte == b'\n').count()
    }

    /// The value as written in the source, shortened to one line.
    fn excerpt(&self, span: std::ops::Range<usize>) -> String {
        const LONGEST_EXCERPT: usize = 60;
        let raw = self.text.get(span).unwrap_or("").trim();
        if raw.is_empty() {
            return "a table".to_owned();
        }
        let line = raw.lines().next().unwrap_or("");
        let short: String = line.chars().take(LONGEST_EXCERPT).collect();
        if short.len() < raw.len() { format!("{short} …") } else { short }
    }

    /// The error for a value of the source, with its line.
    pub fn reject(
        &self,
        field: &str,
        value: &Spanned<DeValue<'_>>,
        allowed: impl Into<String>,
        remedy: impl Into<String>,
    ) -> InvalidInput {
        let excerpt = match value.get_ref() {
            DeValue::Table(table) if table.is_empty() => "an empty table".to_owned(),
            _ => self.excerpt(value.span()),
        };
        let refusal = InvalidInput::new(field, excerpt, allowed, remedy);
        self.with_line(refusal, value.span().start)
    }

    /// Adds the line in the source of a byte position to an error, unless the library wrote the text.
    pub fn with_line(&self, mut refusal: InvalidInput, position: usize) -> InvalidInput {
        if self.has_lines {
            refusal.remedy = format!("{} See line {}.", refusal.remedy, self.line(position));
        }
        refusal
    }

    /// The error for an unknown key in the source: suggests its sections, or else the nearest known key.
    pub fn reject_unknown_key(&self, unknown: UnknownKey<'_>, value: &Spanned<DeValue<'_>>) -> InvalidInput {
        let UnknownKey { field, key, position, section, allowed, keys } = unknown;
        let homes: Vec<String> = SECTIONS
            .iter()
            .filter(|(name, keys)| Some(*name) != section && keys.all().contains(&key))
            .map(|(name, _)| format!("[{name}]"))
            .collect();
        // a key of many sections says nothing of where it belongs, nor does one that sections of all sorts have
        let home = ((1..=4).contains(&homes.len()) && !["kind", "name"].contains(&key))
            .then(|| format!("It belongs under {}.", homes.join(" or ")));
        let remedy = home
            .or_else(|| nearest_word(key, keys).map(|key| format!("Did you mean \"{key}\"?")))
            .unwrap_or_else(|| "Remove it, or correct its name.".to_owned());
        let field: String = field.chars().take(80).collect();
        let excerpt =
            if value.get_ref().is_table() { "a section".to_owned() } else { self.excerpt(value.span()) };
        self.with_line(InvalidInput::new(field, excerpt, allowed, remedy), position)
    }
}
