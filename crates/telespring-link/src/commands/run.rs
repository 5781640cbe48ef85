//! `telespring-link run`.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use telespring_link::conduct::{Plan, conduct};
use telespring_link::feed::Observer;
use telespring_link::hello::draw_session;
use telespring_link::real_time::Limits;
use telespring_link::settings::{SiteFile, check_duration};

use super::{Failure, orders, outcome, parts, print, stop_on_signal};

/// Runs the site of a file until the partner leaves, Ctrl-C, or the time is over, and prints a summary as JSON
#[derive(Debug, Args)]
pub struct Run {
    /// The site file
    site: PathBuf,
    /// How long the session takes at most, s
    #[arg(long, allow_negative_numbers = true)]
    seconds: Option<f64>,
    /// Takes orders from standard input, one per line: consent, withdraw, pause, resume, stop, clear, mark KIND TEXT
    #[arg(long)]
    console: bool,
}

impl Run {
    pub(super) fn run(self) -> Result<ExitCode, Failure> {
        let file = SiteFile::read(&self.site)?;
        let settings = file.site(draw_session())?;
        let SiteFile { study, side, duration, network, device, real_time, telemetry, .. } = file;
        let duration = self.seconds.map(check_duration).transpose()?.or(duration);
        let transport = parts::transport(&network, real_time.priority)?;
        let device = parts::device(&device, &study, side)?;
        let mut observers: Vec<Box<dyn Observer>> = Vec::new();
        if let Some(choice) = telemetry {
            observers.push(parts::telemetry(&choice, &settings.terms)?);
        }
        let [orders] = if self.console { orders()?.map(Some) } else { [None] };
        let plan = Plan { real_time, limits: Limits { duration }, observers, orders };
        let summary = conduct(settings, device, transport, plan, &stop_on_signal(), |_| {})?;
        print(&summary);
        Ok(outcome([&summary]))
    }
}
