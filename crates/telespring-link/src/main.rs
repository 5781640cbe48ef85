//! The program `telespring-link`: one site of a live session, or both as a demonstration.

#![cfg_attr(not(test), deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::todo))]
#![forbid(unsafe_code)]

use std::path::Path;
use std::process::ExitCode;
use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use serde::Serialize;
use signal_hook::consts::{SIGINT, SIGTERM};
use telespring::InvalidInput;
use telespring::session::Span;
use telespring_link::conduct::conduct;
use telespring_link::demo::Demo;
use telespring_link::device::{Device, Simulated, UdpDevice};
use telespring_link::hello::draw_session;
use telespring_link::real_time::Limits;
use telespring_link::settings::{DeviceChoice, LoopChoice, SiteFile};
use telespring_link::site::SiteSettings;
use telespring_link::transport::Udp;

const USAGE: &str = "\
telespring-link: one side of a live coupling

  telespring-link run SITE.toml [--seconds S]
      runs the site of a file until the partner leaves, Ctrl-C, or S seconds are over
  telespring-link demo [--seconds 20] [--delay 0.06] [--jitter 0.006] [--loss 0.02]
                       [--stiffness 142] [--strategy guard|spring] [--seed 1]
      runs both sides on this machine, over an emulated path with this delay each way

Both print a summary as JSON when the session has ended. docs/connect.md has the keys of a site file.
Exit status: 0 after a session that ran, 1 if it never ran or a fault ended it, 2 for bad input.";

/// A refusal of what stands on the command line.
fn refuse(argument: &str, value: &str, allowed: &str) -> InvalidInput {
    InvalidInput::new(argument, value, allowed, "telespring-link --help has every option.")
}

/// What stands behind a command: options with their values, and the rest.
struct Arguments<'a> {
    options: Vec<(&'a str, &'a str)>,
    rest: Vec<&'a str>,
}

impl<'a> Arguments<'a> {
    fn new(arguments: &'a [String]) -> Result<Self, InvalidInput> {
        let (mut options, mut rest) = (Vec::new(), Vec::new());
        let mut arguments = arguments.iter().map(String::as_str);
        while let Some(argument) = arguments.next() {
            if argument.starts_with("--") {
                let missing = || InvalidInput::missing(argument, "", "Give a value after it.");
                options.push((argument, arguments.next().ok_or_else(missing)?));
            } else {
                rest.push(argument);
            }
        }
        Ok(Self { options, rest })
    }
}

/// A number on the command line.
fn number<N: FromStr>(option: &str, value: &str) -> Result<N, InvalidInput> {
    value.parse().map_err(|_| refuse(option, value, "a number is required"))
}

fn read_demo(arguments: &[String]) -> Result<Demo, InvalidInput> {
    let Arguments { options, rest } = Arguments::new(arguments)?;
    if let Some(argument) = rest.first() {
        return Err(refuse("demo", argument, "a demonstration takes options only"));
    }
    let mut demo = Demo::default();
    for (option, value) in options {
        match option {
            "--seconds" => demo.seconds = number(option, value)?,
            "--delay" => demo.delay = number(option, value)?,
            "--jitter" => demo.jitter = number(option, value)?,
            "--loss" => demo.loss = number(option, value)?,
            "--stiffness" => demo.stiffness = number(option, value)?,
            "--seed" => demo.seed = number(option, value)?,
            "--strategy" => {
                demo.strategy = match value {
                    "guard" => "guard",
                    "spring" => "spring",
                    _ => return Err(refuse(option, value, "guard or spring")),
                }
            }
            _ => return Err(refuse(option, value, "there is no such option")),
        }
    }
    Ok(demo)
}

fn read_run(arguments: &[String]) -> Result<SiteFile, InvalidInput> {
    let Arguments { options, rest } = Arguments::new(arguments)?;
    let [path] = rest[..] else {
        return Err(InvalidInput::missing("SITE.toml", "one site file", "Give its path after run."));
    };
    let mut file = SiteFile::read(Path::new(path))?;
    for (option, value) in options {
        match option {
            "--seconds" => {
                let seconds: f64 = number(option, value)?;
                if !(0.1..=86_400.0).contains(&seconds) {
                    return Err(refuse(option, value, "0.1 to 86400 s"));
                }
                file.duration = Some(Span::from_seconds(seconds));
            }
            _ => return Err(refuse(option, value, "there is no such option")),
        }
    }
    Ok(file)
}

/// A refusal of the operating system, with the key that led to it.
fn system(field: &str, value: impl ToString) -> impl FnOnce(std::io::Error) -> InvalidInput {
    let value = value.to_string();
    let remedy = "Give an address of this machine with a free port, or end the program that has it.";
    let field = field.to_owned();
    move |error| InvalidInput::new(field, value, format!("the address cannot be used ({error})"), remedy)
}

fn run_site(file: &SiteFile, stop: &AtomicBool) -> Result<ExitCode, InvalidInput> {
    let SiteFile { study, side, duration, addresses: [local, peer], device, safety, real_time } = file;
    let settings = SiteSettings::new(study, *side, draw_session(), *safety)?;
    let transport = Udp::new(*local, *peer).map_err(system("network.local", local))?;
    let device: Box<dyn Device> = match device {
        DeviceChoice::Simulated { seed } => {
            let laboratory = study.laboratory_without_traces()?;
            Box::new(Simulated::new(&laboratory, usize::from(*side) - 1, *seed)?)
        }
        DeviceChoice::Udp { local, device, deadline } => {
            Box::new(UdpDevice::new(*local, *device, *deadline).map_err(system("device.local", local))?)
        }
    };
    let LoopChoice { .. } = real_time;
    let limits = Limits { duration: *duration };
    let summary = conduct(settings, device, transport, *real_time, limits, stop, |_| {})?;
    print(&summary);
    Ok(outcome([&summary]))
}

/// Success if every side ran, and was left as people leave.
fn outcome<'a>(sides: impl IntoIterator<Item = &'a telespring_link::summary::Summary>) -> ExitCode {
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

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let Some((command, arguments)) = arguments.split_first() else {
        eprintln!("{USAGE}");
        return ExitCode::from(2);
    };
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        // without the handler the signal ends the program, and the device's own deadline ends its force
        if let Err(error) = signal_hook::flag::register(signal, Arc::clone(&stop)) {
            eprintln!("signal {signal} ends the program without a goodbye: {error}");
        }
    }
    let outcome = match command.as_str() {
        "run" => read_run(arguments).and_then(|file| run_site(&file, &stop)),
        "demo" => match read_demo(arguments).map(|demo| demo.run(&stop)) {
            Ok(Ok(summary)) => {
                print(&summary);
                Ok(outcome(&summary.sites))
            }
            Ok(Err(telespring_link::demo::DemoError::Input(refusal))) | Err(refusal) => Err(refusal),
            Ok(Err(error)) => {
                eprintln!("{error}");
                return ExitCode::FAILURE;
            }
        },
        "--help" | "-h" | "help" => {
            println!("{USAGE}");
            return ExitCode::SUCCESS;
        }
        "--version" => {
            println!("telespring-link {}", env!("CARGO_PKG_VERSION"));
            return ExitCode::SUCCESS;
        }
        other => Err(refuse("command", other, "run or demo")),
    };
    outcome.unwrap_or_else(|refusal| {
        eprintln!("{refusal}");
        ExitCode::from(2)
    })
}
