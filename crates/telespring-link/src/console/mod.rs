//! The console: status and events of a session as JSON lines on the standard output, for a program that shows them.

mod narrator;
pub mod numbers;
mod output;
mod status;

pub use narrator::Narrator;
pub use output::{Line, Output};
pub use status::{Gauge, LatencyNow, LatenessNow, Status};

use std::time::Duration;

use serde::Serialize;

use crate::feed::{Item, Observer};
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
    /// The console of side 1 or 2.
    pub fn new(output: Output, side: u8) -> Self {
        Self { output, side, gauge: Gauge::new(side) }
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
                let entry = Entry::new(self.gauge.first().unwrap_or(*time), *time, happened);
                self.output.write("event", &Event { side: self.side, entry: &entry }, PATIENCE);
            }
            _ => {}
        }
    }
}
