//! `telespring-link probe`.

use std::fs::{self, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::Ordering;
use std::time::Duration;

use clap::Args;
use serde::Serialize;
use telespring::InvalidInput;
use telespring::session::Span;
use telespring_link::clock::{Clock, MonotonicClock};
use telespring_link::console::{Line, Output};
use telespring_link::hello::draw_session;
use telespring_link::probe::{Outcome, Probe as Measurement, ProbeSettings, Stage};
use telespring_link::real_time::{Pace, claim};
use telespring_link::settings::SiteFile;
use telespring_link::transport::PathEvent;

use super::{Failure, parts, print, print_summary, stop_on_signal, stop_with_input};

/// From one line of progress to the next.
const PROGRESS: Span = Span(500_000_000);
/// How long to wait for the partner.
const PATIENCE: Span = Span(300_000_000_000);

/// Measures the path to the partner, who does the same at the same time, and prints what was found as JSON
#[derive(Debug, Args)]
pub struct Probe {
    /// The site file: it says where the partner is. No robot is touched
    site: PathBuf,
    /// How long packets are sent, s
    #[arg(long, default_value_t = 60.0, allow_negative_numbers = true)]
    seconds: f64,
    /// Writes the delays of all packets to this new file, as IRTT does, for telespring trace
    #[arg(long)]
    trace: Option<PathBuf>,
    /// Prints one JSON object per line: progress, then what was found. If standard input is a pipe, its end stops the probe
    #[arg(long)]
    console: bool,
}

/// A line of progress.
#[derive(Debug, Serialize)]
struct Progress {
    stage: &'static str,
    sent: usize,
    packets: usize,
}

/// What was found, as a line or an object of its own.
#[derive(Debug, Serialize)]
struct Found<'a> {
    /// The robot of the study at this site, and the study, as TOML.
    side: u8,
    study: &'a str,
    #[serde(flatten)]
    outcome: &'a Outcome,
    trace: Option<&'a Path>,
}

impl Probe {
    pub(super) fn run(self) -> Result<ExitCode, Failure> {
        let SiteFile { study, side, network, real_time, .. } = SiteFile::read(&self.site)?;
        if let Some(trace) = &self.trace {
            check_free(trace)?;
        }
        let period = Span::from_seconds(study.laboratory_without_traces()?.controller.sample_period);
        let duration = Span::from_seconds(self.seconds);
        let settings = ProbeSettings { session: draw_session(), period, duration };
        let mut probe = Measurement::new(settings, parts::transport(&network, real_time.priority)?)?;
        let stop = stop_on_signal();
        if self.console {
            stop_with_input(&stop)?;
        }
        let privileges = claim(real_time.priority, false, real_time.stay_awake);
        if let Some(Err(error)) = privileges.priority {
            let error = std::io::Error::from_raw_os_error(error);
            eprintln!(
                "No real-time priority ({error}): what this machine adds to the delays is measured, too."
            );
        }
        let console = self.console.then(Output::stdout).transpose()?;
        let clock = MonotonicClock;
        let mut pace = Pace::new(period);
        let start = clock.now();
        pace.begin(start);
        let (mut next, mut is_over) = (start, false);
        loop {
            clock.sleep_until(pace.due());
            pace.wake(clock.now());
            let stage = probe.tick(&clock, is_over || stop.load(Ordering::Relaxed));
            is_over = stage == Stage::Waiting && clock.now() - start >= PATIENCE;
            if let Some(output) = console.as_ref().filter(|_| clock.now() >= next) {
                next = clock.now() + PROGRESS;
                let (sent, packets) = probe.progress();
                // who reads slowly holds no packet up
                let progress = Progress { stage: stage.word(), sent, packets };
                output.write("status", &progress, Duration::ZERO);
            }
            if matches!(stage, Stage::Done(_)) {
                break;
            }
            pace.rest(clock.now(), false);
        }
        let outcome = probe.outcome();
        let written = match (&self.trace, probe.trace()) {
            (Some(path), Some(text)) => write_new(path, &text).map(Some),
            _ => Ok(None),
        };
        let study = study.to_toml();
        // a full disk takes the trace, not what was found
        let trace = written.as_ref().ok().copied().flatten();
        let found = Found { side, study: &study, outcome: &outcome, trace };
        match &console {
            Some(_) => print_summary(&found, console.as_ref()),
            None => print(&Line { kind: "summary", content: &found }),
        }
        written?;
        match (&outcome.towards_here, &outcome.towards_partner) {
            (Some(_), Some(_)) => Ok(ExitCode::SUCCESS),
            (None, _) => Err(Failure::Other(nobody(&outcome))),
            (Some(_), None) => Err(Failure::Other(
                "The partner fell silent before it had told what came there: the way to it is not known, so there is no trace."
                    .to_owned(),
            )),
        }
    }
}

/// Why nothing was measured.
fn nobody(outcome: &Outcome) -> String {
    let has = |event: PathEvent| outcome.paths.iter().any(|path| path.event == event.word());
    if outcome.partner_runs_session {
        "The partner runs a session. Start telespring-link probe at both sites.".to_owned()
    } else if has(PathEvent::Refused) {
        "The partner does not know the key of this site. Let it write what telespring-link id prints here under network.peer_id."
            .to_owned()
    } else if has(PathEvent::Withheld) && !has(PathEvent::Direct) {
        "The partner is reached over the relay only, and network.relayed is false here (docs/network.md)."
            .to_owned()
    } else {
        "Nobody answered. Start telespring-link probe at both sites within a minute or so, and check network.peer."
            .to_owned()
    }
}

/// A file that can be written and is not there yet.
fn check_free(path: &Path) -> Result<(), InvalidInput> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let allowed = if path.exists() {
        "a new file: this one exists"
    } else if !folder.is_dir() {
        "a file in a folder that exists"
    } else {
        return Ok(());
    };
    Err(InvalidInput::new("--trace", path.display(), allowed, "Give another path."))
}

/// Writes beside the path, and then puts it there whole.
fn write_new<'a>(path: &'a Path, text: &str) -> Result<&'a Path, Failure> {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.unfinished", std::process::id()));
    let beside = path.with_file_name(name);
    let written = OpenOptions::new()
        .write(true)
        .create_new(true)
        .open(&beside)
        .and_then(|mut file| file.write_all(text.as_bytes()).and_then(|()| file.sync_all()))
        .and_then(|()| fs::rename(&beside, path));
    written.map(|()| path).map_err(|error| {
        let _ = fs::remove_file(&beside);
        Failure::Other(format!("The trace {} could not be written: {error}.", path.display()))
    })
}
