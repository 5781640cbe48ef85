//! The commands, one room each, and what they share.

mod check;
mod demo;
mod id;
mod keygen;
mod marks;
mod parts;
mod probe;
mod relay_config;
mod run;

use std::io::{BufReader, Cursor, IsTerminal, Read, Write};
use std::os::fd::AsFd;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use clap::{Parser, Subcommand};
use rtrb::Consumer;
use serde::Serialize;
use signal_hook::consts::{SIGINT, SIGTERM};
use telespring::InvalidInput;
use telespring_link::conduct::ConductError;
use telespring_link::console::{Output, numbers};
use telespring_link::operator::{self, Order};
use telespring_link::summary::Summary;

/// How long the summary waits for a reader that stalls.
const PATIENCE: Duration = Duration::from_secs(10);

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

impl From<std::io::Error> for Failure {
    fn from(error: std::io::Error) -> Self {
        Self::Other(format!("the operating system refused: {error}"))
    }
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

/// The orders for each of `N` sides: those of `first`, one per line, then, with a console, those from standard input. The end
/// of an input that a program writes sets `stop`: whoever watched the session is gone then.
fn orders<const N: usize>(
    first: String,
    has_console: bool,
    stop: &Arc<AtomicBool>,
) -> Result<[Option<Consumer<Order>>; N], Failure> {
    if !has_console {
        if first.is_empty() {
            return Ok([const { None }; N]);
        }
        return Ok(operator::listen(Cursor::new(first))?.1.map(Some));
    }
    let (listener, orders) = operator::listen(BufReader::new(Cursor::new(first).chain(std::io::stdin())))?;
    if is_written_by_program(&std::io::stdin()) {
        let stop = Arc::clone(stop);
        let wait = move || {
            // whether it ended or broke off, nobody is heard any more
            let _ = listener.join();
            stop.store(true, Ordering::Relaxed);
        };
        std::thread::Builder::new().name("input".to_owned()).spawn(wait)?;
    }
    Ok(orders.map(Some))
}

/// Sets `stop` once the input has ended, if a program writes it: whoever watched is gone then. What it says is not read.
fn stop_with_input(stop: &Arc<AtomicBool>) -> Result<(), Failure> {
    if is_written_by_program(&std::io::stdin()) {
        let stop = Arc::clone(stop);
        let wait = move || {
            let _ = std::io::copy(&mut std::io::stdin(), &mut std::io::sink());
            stop.store(true, Ordering::Relaxed);
        };
        std::thread::Builder::new().name("input".to_owned()).spawn(wait)?;
    }
    Ok(())
}

/// Success if every side ran, and was left as people leave.
fn outcome<'a>(sides: impl IntoIterator<Item = &'a Summary>) -> ExitCode {
    let fine = sides.into_iter().all(|side| {
        side.coupled_share > 0.0
            && matches!(side.cause, Some("stop-requested" | "time-over" | "partner-left"))
    });
    if fine { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Prints the summary of a session, as the last line of the console if there is one.
fn print_summary(summary: &impl Serialize, console: Option<&Output>) {
    match console {
        Some(output) => output.write("summary", summary, PATIENCE),
        None => print(summary),
    }
}

/// Whether a person sits here: not a program that wants JSON.
#[derive(Debug, Clone, Copy)]
struct Attended {
    /// What happens is told in words, on the standard error.
    is_told: bool,
    /// Orders are typed.
    gives_orders: bool,
    /// A summary in words is enough.
    reads: bool,
}

impl Attended {
    /// `has_console`: a program reads, or a person who wants what a program gets.
    fn new(has_console: bool) -> Self {
        let is_told = !has_console && std::io::stderr().is_terminal();
        Self {
            is_told,
            gives_orders: is_told && std::io::stdin().is_terminal() && is_in_foreground(),
            reads: is_told && std::io::stdout().is_terminal(),
        }
    }
}

fn print(content: &impl Serialize) {
    let text = numbers::lines(content).map_err(std::io::Error::from);
    let write = |mut text: Vec<u8>| {
        text.push(b'\n');
        std::io::stdout().write_all(&text)
    };
    // whoever read it may have left
    if let Err(error) = text.and_then(write) {
        eprintln!("the output cannot be written: {error}");
    }
}

/// Whether the terminal listens to this program: one in the background would be stopped for reading. If that is not known, it
/// does not.
fn is_in_foreground() -> bool {
    let facts = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // behind the name of the program, which may have spaces: state, parent, group, session, terminal, its group in front
    let mut rest = facts.rsplit(')').next().unwrap_or_default().split_whitespace().skip(2);
    let (group, front) = (rest.next(), rest.nth(2));
    // -1: it belongs to no terminal, and nobody stops it
    group.is_some() && (front == group || front == Some("-1"))
}

/// Whether an input is a pipe or a socket. A terminal, a file and nothing at all have an end that means nothing.
fn is_written_by_program(input: &impl AsFd) -> bool {
    let kind = rustix::fs::fstat(input).map(|state| rustix::fs::FileType::from_raw_mode(state.st_mode));
    matches!(kind, Ok(rustix::fs::FileType::Fifo | rustix::fs::FileType::Socket))
}
