//! `telespring-link check`.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use telespring::InvalidInput;
use telespring::session::Span;
use telespring_link::check::{Item, Report, Verdict, check};
use telespring_link::hello::draw_session;
use telespring_link::settings::SiteFile;
use telespring_link::site::SiteSettings;

use super::{Failure, parts, print, stop_on_signal};

/// Tries keys, device, loop and partner of a site before anyone holds a handle, without any force, and prints JSON
#[derive(Debug, Args)]
pub struct Check {
    /// The site file
    site: PathBuf,
    /// How long, s
    #[arg(long, default_value_t = 5.0, allow_negative_numbers = true)]
    seconds: f64,
}

impl Check {
    pub(super) fn run(self) -> Result<ExitCode, Failure> {
        if !(1.0..=600.0).contains(&self.seconds) {
            return Err(InvalidInput::new("seconds", self.seconds, "1 to 600 s", "Give 5.").into());
        }
        let file = SiteFile::read(&self.site)?;
        let settings = file.site(draw_session())?;
        let report = self.report(&file, settings)?;
        print(&report);
        Ok(if report.verdict == Verdict::Failed { ExitCode::FAILURE } else { ExitCode::SUCCESS })
    }

    fn report(&self, file: &SiteFile, settings: SiteSettings) -> Result<Report, Failure> {
        let mut items = vec![Item::fine("site-file", "every key is allowed")];
        let transport = parts::transport(&file.network, file.real_time.priority);
        items.push(opened("network", transport.as_ref().err()));
        let device = parts::device(&file.device, &file.study, file.side);
        if let Err(refusal) = &device {
            items.push(opened("device", Some(refusal)));
        }
        let (Ok(transport), Ok(device)) = (transport, device) else {
            return Ok(Report::new(file.side, items, None));
        };
        let duration = Span::from_seconds(self.seconds);
        let stop = stop_on_signal();
        Ok(check(settings, device, transport, file.real_time, duration, &stop, items)?)
    }
}

/// What became of opening a part of the site.
fn opened(item: &'static str, refusal: Option<&InvalidInput>) -> Item {
    match refusal {
        None => Item::fine(item, "keys and addresses of this site can be used"),
        Some(refusal) => {
            let InvalidInput { field, value, allowed, remedy, .. } = refusal;
            Item::wrong(item, Verdict::Failed, format!("{field} = {value}: {allowed}"), remedy)
        }
    }
}
