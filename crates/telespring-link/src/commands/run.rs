//! `telespring-link run`.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use telespring_link::conduct::{Plan, conduct};
use telespring_link::feed::Observer;
use telespring_link::hello::draw_session;
use telespring_link::real_time::Limits;
use telespring_link::settings::{SiteFile, check_duration};
use telespring_link::site::SiteSettings;

use super::{Failure, outcome, parts, print, stop_on_signal};

/// Runs the site of a file until the partner leaves, Ctrl-C, or the time is over, and prints a summary as JSON
#[derive(Debug, Args)]
pub struct Run {
    /// The site file
    site: PathBuf,
    /// How long the session takes at most, s
    #[arg(long, allow_negative_numbers = true)]
    seconds: Option<f64>,
}

impl Run {
    pub(super) fn run(self) -> Result<ExitCode, Failure> {
        let SiteFile { study, side, duration, network, device, safety, real_time, telemetry } =
            SiteFile::read(&self.site)?;
        let duration = self.seconds.map(check_duration).transpose()?.or(duration);
        let settings = SiteSettings::new(&study, side, draw_session(), safety)?;
        let transport = parts::transport(&network, real_time.priority)?;
        let device = parts::device(&device, &study, side)?;
        let mut observers: Vec<Box<dyn Observer>> = Vec::new();
        if let Some(choice) = telemetry {
            observers.push(parts::telemetry(&choice, &settings.terms)?);
        }
        let plan = Plan { real_time, limits: Limits { duration }, observers };
        let summary = conduct(settings, device, transport, plan, &stop_on_signal(), |_| {})?;
        print(&summary);
        Ok(outcome([&summary]))
    }
}
