//! `telespring-link demo`.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, ValueEnum};
use telespring_link::console::Output;
use telespring_link::demo::{self, DemoError};
use telespring_link::settings::LoopChoice;

use super::marks::Marks;
use super::{Attended, Failure, orders, outcome, print_summary, stop_on_signal};

/// Runs both sides on this machine, over an emulated path, and prints a summary as JSON
#[derive(Debug, Args)]
pub struct Demo {
    /// How long, s
    #[arg(long, default_value_t = 20.0, allow_negative_numbers = true)]
    seconds: f64,
    /// Delay of the path each way, s
    #[arg(long, default_value_t = 0.06, allow_negative_numbers = true)]
    delay: f64,
    /// The largest additional delay of a packet, s
    #[arg(long, default_value_t = 0.006, allow_negative_numbers = true)]
    jitter: f64,
    /// The probability that a packet is lost
    #[arg(long, default_value_t = 0.02, allow_negative_numbers = true)]
    loss: f64,
    /// Stiffness of the virtual spring, N/m
    #[arg(long, default_value_t = 142.0, allow_negative_numbers = true)]
    stiffness: f64,
    /// What couples the robots
    #[arg(long, value_enum, default_value_t = Strategy::Guard)]
    strategy: Strategy,
    /// Draws the path and what the simulated people see
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// A delay that is imposed on the partner's motion, s; it must not be below that of the path
    #[arg(long, allow_negative_numbers = true)]
    imposed_delay: Option<f64>,
    /// Prints status, events and summary as JSON, one object per line, and takes orders from standard input, one per line, for
    /// both sides or, after 1 or 2, for one: consent, withdraw, pause, resume, stop, clear, mark KIND TEXT
    #[arg(long)]
    console: bool,
    #[command(flatten)]
    marks: Marks,
    /// The folder for the recordings of both sides
    #[arg(long, value_name = "FOLDER")]
    record: Option<PathBuf>,
    /// An address of this machine for Foxglove or Lichtblick
    #[arg(long, value_name = "ADDRESS")]
    live: Option<SocketAddr>,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Strategy {
    Guard,
    Spring,
}

impl Demo {
    pub(super) fn run(self) -> Result<ExitCode, Failure> {
        let Self { seconds, delay, jitter, loss, stiffness, strategy, seed, .. } = self;
        let Self { imposed_delay, console, marks, record, live, .. } = self;
        let marks = marks.orders()?;
        let strategy = match strategy {
            Strategy::Guard => "guard",
            Strategy::Spring => "spring",
        };
        let real_time = LoopChoice::default();
        let demo = demo::Demo {
            seconds,
            delay,
            jitter,
            loss,
            stiffness,
            strategy,
            seed,
            imposed_delay,
            real_time,
            record,
            live,
        };
        let stop = stop_on_signal();
        let attended = Attended::new(console);
        let orders = orders(marks, console || attended.gives_orders, &stop)?;
        let console = console.then(Output::stdout).transpose()?;
        let words = attended.is_told.then(Output::stderr).transpose()?;
        let summary =
            demo.run(&stop, orders, console.as_ref(), words.as_ref()).map_err(|error| match error {
                DemoError::Input(refusal) => Failure::Input(refusal),
                DemoError::Conduct(error) => error.into(),
                other => Failure::Other(other.to_string()),
            })?;
        if !attended.reads {
            print_summary(&summary, console.as_ref());
        }
        Ok(outcome(&summary.sites))
    }
}
