//! Markers on the command line: they are set as the session begins.

use std::fmt::Write;

use clap::Args;
use telespring::InvalidInput;
use telespring_link::operator::{Mark, MarkKind};

/// Markers for the record.
#[derive(Debug, Args)]
pub(super) struct Marks {
    /// Marks who takes part, for the record: a code such as P-07, never a name
    #[arg(long, value_name = "CODE")]
    participant: Option<String>,
    /// Marks the condition, for the record
    #[arg(long, value_name = "TEXT")]
    condition: Option<String>,
    /// Marks the trial, for the record: it lasts to the next one, or to the end
    #[arg(long, value_name = "TEXT")]
    trial: Option<String>,
}

impl Marks {
    /// The orders that set them, one per line: the trial last, so that the others hold for it.
    pub(super) fn orders(&self) -> Result<String, InvalidInput> {
        let mut lines = String::new();
        for (kind, text) in [
            (MarkKind::Participant, &self.participant),
            (MarkKind::Condition, &self.condition),
            (MarkKind::Trial, &self.trial),
        ] {
            let Some(text) = text else { continue };
            let (word, text) = (kind.word(), text.trim());
            let Some(mark) = Mark::new(kind, text) else {
                let (allowed, remedy) = match kind {
                    MarkKind::Participant => {
                        ("up to 16 letters, digits, - and _, with a digit", "Give a code such as P-07.")
                    }
                    _ => ("up to 64 printable ASCII characters", "Give a short text."),
                };
                return Err(InvalidInput::new(format!("--{word}"), text, allowed, remedy));
            };
            // a text cannot refuse what is written to it
            let _ = writeln!(lines, "mark {word} {}", mark.label.text());
        }
        Ok(lines)
    }
}
