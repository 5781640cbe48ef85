//! `telespring-link run`.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use telespring::InvalidInput;
use telespring_link::conduct::{Plan, conduct};
use telespring_link::device::{Device, Simulated, UdpDevice};
use telespring_link::hello::draw_session;
use telespring_link::real_time::Limits;
use telespring_link::settings::{DeviceChoice, NetworkChoice, SiteFile, check_duration};
use telespring_link::transport::{Transport, Udp};

use super::{Failure, orders, outcome, print, stop_on_signal};

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
        let SiteFile { study, side, duration, network, device, real_time, .. } = file;
        let duration = self.seconds.map(check_duration).transpose()?.or(duration);
        let transport: Box<dyn Transport> = match network {
            NetworkChoice::Udp { local, peer } => {
                Box::new(Udp::new(local, peer).map_err(system("network.local", local))?)
            }
        };
        let device: Box<dyn Device> = match device {
            DeviceChoice::Simulated { seed } => {
                let laboratory = study.laboratory_without_traces()?;
                Box::new(Simulated::new(&laboratory, usize::from(side) - 1, seed)?)
            }
            DeviceChoice::Udp { local, device, deadline } => {
                Box::new(UdpDevice::new(local, device, deadline).map_err(system("device.local", local))?)
            }
        };
        let [orders] = if self.console { orders()?.map(Some) } else { [None] };
        let plan = Plan { real_time, limits: Limits { duration }, observers: Vec::new(), orders };
        let summary = conduct(settings, device, transport, plan, &stop_on_signal(), |_| {})?;
        print(&summary);
        Ok(outcome([&summary]))
    }
}

/// A refusal of the operating system, with the key that led to it.
fn system(field: &str, value: impl ToString) -> impl FnOnce(std::io::Error) -> InvalidInput {
    let value = value.to_string();
    let remedy = "Give an address of this machine with a free port, or end the program that has it.";
    let field = field.to_owned();
    move |error| InvalidInput::new(field, value, format!("the address cannot be used ({error})"), remedy)
}
