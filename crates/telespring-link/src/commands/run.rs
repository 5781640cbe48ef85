//! `telespring-link run`.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use telespring_link::conduct::{Plan, conduct};
use telespring_link::console::{Console, Narrator, Output};
use telespring_link::feed::Observer;
use telespring_link::hello::draw_session;
use telespring_link::real_time::Limits;
use telespring_link::record::Facts;
use telespring_link::record::live::LiveServer;
use telespring_link::settings::{SiteFile, check_duration};

use super::marks::Marks;
use super::{Attended, Failure, orders, outcome, parts, print_summary, stop_on_signal};

/// What somebody at a terminal may type.
const ORDERS: &str = " Orders: consent, withdraw, pause, resume, stop, clear, mark KIND TEXT.";

/// Runs the site of a file until the partner leaves a session that has begun, Ctrl-C, or the time is over, and prints a summary as JSON; in a terminal
/// it tells what happens in words, and takes orders: consent, withdraw, pause, resume, stop, clear, mark KIND TEXT
#[derive(Debug, Args)]
pub struct Run {
    /// The site file
    site: PathBuf,
    /// How long the session takes at most, s
    #[arg(long, allow_negative_numbers = true)]
    seconds: Option<f64>,
    /// For a program that shows the session: prints status, events and summary as JSON, one object per line, and takes orders
    /// from standard input, one per line
    #[arg(long)]
    console: bool,
    #[command(flatten)]
    marks: Marks,
    /// The folder for a recording
    #[arg(long, value_name = "FOLDER")]
    record: Option<PathBuf>,
    /// An address of this machine for Foxglove or Lichtblick
    #[arg(long, value_name = "ADDRESS")]
    live: Option<SocketAddr>,
}

impl Run {
    pub(super) fn run(self) -> Result<ExitCode, Failure> {
        let file = SiteFile::read(&self.site)?;
        let marks = self.marks.orders()?;
        let duration = self.seconds.map(check_duration).transpose()?.or(file.duration);
        let settings = file.site(draw_session())?;
        let facts = Facts::new(&file.study, &settings)
            .with("device", file.device.word())
            .with("network", file.network.word());
        let transport = parts::transport(&file.network, file.real_time.priority)?;
        let device = parts::device(&file.device, &file.study, file.side)?;
        let mut observers: Vec<Box<dyn Observer>> = Vec::new();
        if let Some(choice) = &file.telemetry {
            observers.push(parts::telemetry(choice, &settings.terms)?);
        }
        let stop = stop_on_signal();
        let attended = Attended::new(self.console);
        let [orders] = orders(marks, self.console || attended.gives_orders, &stop)?;
        let server = match (self.live, file.live) {
            (Some(address), _) => Some(LiveServer::start("--live", address)?),
            (None, Some(address)) => Some(LiveServer::start("live.address", address)?),
            (None, None) => None,
        };
        let folder = match (&self.record, &file.recording) {
            (Some(folder), _) => Some(("--record", folder)),
            (None, Some(folder)) => Some(("recording.folder", folder)),
            (None, None) => None,
        };
        let console = self.console.then(Output::stdout).transpose()?;
        if let Some(output) = &console {
            observers.push(Box::new(Console::new(output.clone(), file.side)));
        }
        if attended.is_told {
            observers.push(Box::new(Narrator::new(Output::stderr()?, "", attended.gives_orders)));
            let orders = if attended.gives_orders { ORDERS } else { "" };
            eprintln!("Site {} waits for its partner. Ctrl-C ends the session.{orders}", file.side);
        }
        let plan = Plan {
            real_time: file.real_time,
            limits: Limits { duration },
            observers,
            orders,
            ..Plan::default()
        };
        let plan = plan.watched(&facts, folder, server.as_ref())?;
        let summary = conduct(settings, device, transport, plan, &stop, |_| {})?;
        if !attended.reads {
            print_summary(&summary, console.as_ref());
        }
        Ok(outcome([&summary]))
    }
}
