//! The commands, one room each, and what they share.

mod check;
mod demo;
mod id;
mod keygen;
mod parts;
mod probe;
mod relay_config;
mod run;

use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::{Parser, Subcommand};
use rtrb::Consumer;
use serde::Serialize;
use signal_hook::consts::{SIGINT, SIGTERM};
use telespring::InvalidInput;
use telespring_link::conduct::ConductError;
use telespring_link::operator::{self, Order};
use telespring_link::summary::Summary;

/// One side of a live coupling.
#[derive(Debug, Parser)]
#[command(
    version,
    arg_required_else_help = true,
    after_help = "docs/connect.md has the keys of a site file.\nExit status: 0 after a session that ran, 1 if it never ran or a \
                  fault ended it, 2 for bad input."
)]
pub struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Run(run::Run),
    Demo(demo::Demo),
    Check(check::Check),
    Keygen(keygen::Keygen),
    Id(id::Id),
    Probe(probe::Probe),
    RelayConfig(relay_config::RelayConfig),
}

impl Arguments {
    /// Does what was asked for.
    pub fn run(self) -> ExitCode {
        let outcome = match self.command {
            Command::Run(command) => command.run(),
            Command::Demo(command) => command.run(),
            Command::Check(command) => command.run(),
            Command::Keygen(command) => command.run(),
            Command::Id(command) => command.run(),
            Command::Probe(command) => command.run(),
            Command::RelayConfig(command) => command.run(),
        };
        outcome.unwrap_or_else(|failure| {
            eprintln!("{failure}");
            match failure {
                Failure::Input(_) => ExitCode::from(2),
                Failure::Other(_) => ExitCode::FAILURE,
            }
        })
    }
}

/// Why a command was not carried out.
#[derive(Debug, thiserror::Error)]
enum Failure {
    /// A value that is refused.
    #[error(transparent)]
    Input(#[from] InvalidInput),
    /// Something else.
    #[error("{0}")]
    Other(String),
}

impl From<ConductError> for Failure {
    fn from(error: ConductError) -> Self {
        match error {
            ConductError::Input(refusal) => Self::Input(refusal),
            other => Self::Other(other.to_string()),
        }
    }
}

/// A switch that Ctrl-C and SIGTERM set.
fn stop_on_signal() -> Arc<AtomicBool> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        // without the handler the signal ends the program, and the device's own deadline ends its force
        if let Err(error) = signal_hook::flag::register(signal, Arc::clone(&stop)) {
            eprintln!("signal {signal} ends the program without a goodbye: {error}");
        }
    }
    stop
}

/// The orders from standard input, for each of `N` sides.
fn orders<const N: usize>() -> Result<[Consumer<Order>; N], Failure> {
    let lines = std::io::BufReader::new(std::io::stdin());
    let (_, orders) = operator::listen(lines).map_err(|error| Failure::Other(error.to_string()))?;
    Ok(orders)
}

/// Success if every side ran, and was left as people leave.
fn outcome<'a>(sides: impl IntoIterator<Item = &'a Summary>) -> ExitCode {
    let fine = sides.into_iter().all(|side| {
        side.coupled_share > 0.0 && matches!(side.cause, Some("stop-requested" | "partner-left"))
    });
    if fine { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn print(summary: &impl Serialize) {
    match serde_json::to_string_pretty(summary) {
        Ok(text) => println!("{text}"),
        Err(error) => eprintln!("the summary cannot be written: {error}"),
    }
}
