//! What happens, in words, for whoever sits at a terminal.

use std::time::Duration;

use telespring::session::{EventKind, LocalTime};

use super::Output;
use crate::feed::{Item, Observer};
use crate::site::{Happened, Phase};
use crate::summary::{Entry, Summary};

/// How long a line waits for a terminal that stands still.
const PATIENCE: Duration = Duration::from_millis(200);

/// Tells states, events and what to do about them as lines of text.
#[derive(Debug)]
pub struct Narrator {
    output: Output,
    /// Before every line of this side.
    name: String,
    /// Whether somebody is asked to do something: not in a demonstration.
    asks: bool,
    first: Option<LocalTime>,
}

impl Narrator {
    /// The narrator of a side with this name; `asks`: somebody at the terminal can do something.
    pub fn new(output: Output, name: impl Into<String>, asks: bool) -> Self {
        Self { output, name: name.into(), asks, first: None }
    }

    /// An event as a line; `None` for what an interested person need not know while it happens.
    fn line(&self, entry: &Entry, happened: &Happened) -> Option<String> {
        let words = match happened {
            // the states and the summary say the same
            Happened::Session(kind) if !is_news(kind) => return None,
            Happened::Ended(_) => return None,
            Happened::Entered(Phase::Ended) => return None,
            Happened::Agreed { .. } => "agreed with the partner".to_owned(),
            Happened::Entered(phase) => phase.word().to_owned(),
            _ => match &entry.cause {
                Some(cause) => format!("{}: {cause}", entry.event),
                None => entry.event.to_owned(),
            },
        };
        let remedy =
            entry.remedy.filter(|_| self.asks).map(|remedy| format!(". {remedy}")).unwrap_or_default();
        Some(format!("{}{:8.2} s  {words}{remedy}", self.name, entry.time))
    }
}

impl Observer for Narrator {
    fn name(&self) -> &'static str {
        "narrator"
    }

    fn take(&mut self, item: &Item) {
        match item {
            Item::Tick { moment, .. } => {
                self.first.get_or_insert(moment.time);
            }
            Item::Event { time, happened } => {
                let entry = Entry::new(*self.first.get_or_insert(*time), *time, happened);
                if let Some(line) = self.line(&entry, happened) {
                    self.output.write_text(&line, PATIENCE);
                }
            }
            Item::Arrival(_) => {}
        }
    }

    fn finish(&mut self, summary: &Summary) {
        for line in in_words(summary) {
            self.output.write_text(&format!("{}{line}", self.name), PATIENCE);
        }
    }
}

/// Whether an event of the endpoint is more than a step on the way from state to state.
fn is_news(kind: &EventKind) -> bool {
    matches!(
        kind,
        EventKind::RampingOut(_)
            | EventKind::PartnerRestarted { .. }
            | EventKind::ImpossibleValue { .. }
            | EventKind::ImpossibleForce
            | EventKind::ClockStepped
    )
}

/// A summary in a few lines.
fn in_words(summary: &Summary) -> Vec<String> {
    let Summary { seconds, coupled_share, round_trip, age, loss, lateness, .. } = summary;
    let cause = summary.cause.unwrap_or("cut off");
    let mut lines =
        vec![format!("coupled for {:.1} of {seconds:.1} s; ended: {cause}", seconds * coupled_share)];
    if let (Some(trip), Some(age)) = (round_trip.latest, age) {
        lines.push(format!(
            "round trip {:.1} ms; age of the partner's motion {:.1} ms; {:.1} % of the packets lost",
            1e3 * trip,
            1e3 * age.mean,
            1e2 * loss.share
        ));
    }
    if *coupled_share > 0.0 {
        lines.push(format!(
            "largest force {:.2} N; changed by the strategy at {:.1} %, by a limit at {:.1} % of the ticks",
            summary.largest_force,
            1e2 * summary.limited_share.unwrap_or(0.0),
            1e2 * summary.cut_share
        ));
    }
    lines.push(format!(
        "ticks within {:.2} ms in 99 of 100 cases; {} left out",
        1e3 * lateness.quantile_99,
        lateness.overruns
    ));
    lines
}
