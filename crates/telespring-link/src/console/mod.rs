//! The console: status and events of a session as JSON lines on the standard output, for a program that shows them.

mod output;
mod status;

pub use output::Output;
pub use status::{Gauge, LatencyNow, LatenessNow, Status};

use std::time::Duration;

use serde::Serialize;

use crate::feed::{Item, Observer};
use crate::hello::Terms;
use crate::summary::Entry;

/// How long an event waits for a reader that stalls; a status does not.
const PATIENCE: Duration = Duration::from_millis(200);

/// Writes the status of a side ten times per second, and its events at once.
#[derive(Debug)]
pub struct Console {
    output: Output,
    side: u8,
    gauge: Gauge,
}

/// An event of a side.
#[derive(Serialize)]
struct Event<'a> {
    side: u8,
    #[serde(flatten)]
    entry: &'a Entry,
}

impl Console {
    /// The console of the side with these terms.
    pub fn new(output: Output, terms: &Terms) -> Self {
        let [stiffness, _] = terms.coupling;
        Self { output, side: terms.side, gauge: Gauge::new(terms.side, stiffness) }
    }
}

impl Observer for Console {
    fn name(&self) -> &'static str {
        "console"
    }

    fn take(&mut self, item: &Item) {
        match item {
            Item::Tick { moment, lateness, overruns, .. } => {
                if let Some(status) = self.gauge.take(moment, *lateness, *overruns) {
                    self.output.write("status", &status, Duration::ZERO);
                }
            }
            Item::Event { time, happened } => {
                let time_since_start = self.gauge.since_start(*time);
                let entry = Entry { time: time_since_start, ..Entry::new(*time, *time, happened) };
                self.output.write("event", &Event { side: self.side, entry: &entry }, PATIENCE);
            }
            _ => {}
        }
    }
}
