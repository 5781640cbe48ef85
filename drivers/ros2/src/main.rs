//! The program `telespring-ros2`: a bridge from the telemetry stream of telespring-link to ROS 2.

#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::todo)]

use std::error::Error;
use std::io::ErrorKind;
use std::net::{IpAddr, SocketAddr, UdpSocket};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use clap::Parser;
use telespring_ros2::conversion::offset;
use telespring_ros2::node::{Side, context};
use telespring_ros2::row::{LENGTH, Row};

/// How long one look waits for a row.
const LOOK: Duration = Duration::from_millis(100);

/// Publishes the telemetry stream of telespring-link as topics of ROS 2, until Ctrl-C.
#[derive(Debug, Parser)]
#[command(version)]
struct Arguments {
    /// Where it listens: telemetry.address of the site file
    #[arg(long)]
    listen: SocketAddr,
    /// The domain of ROS 2
    #[arg(long, env = "ROS_DOMAIN_ID", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=232))]
    domain: u16,
    /// The address of the one network of this machine that the topics are offered on; without it, all of them
    #[arg(long)]
    network: Option<IpAddr>,
    /// The frame of every message: the axes of the study
    #[arg(long, default_value = "telespring")]
    frame: String,
}

/// The monotonic clock, ns.
fn monotonic() -> u128 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    u128::from(time.tv_sec.unsigned_abs()) * 1_000_000_000 + u128::from(time.tv_nsec.unsigned_abs())
}

fn serve(arguments: &Arguments, stop: &AtomicBool) -> Result<(), Box<dyn Error>> {
    let socket = UdpSocket::bind(arguments.listen)
        .map_err(|error| format!("--listen {}: {error}", arguments.listen))?;
    socket.set_read_timeout(Some(LOOK))?;
    let context = context(arguments.domain, arguments.network)?;
    let mut sides: Vec<Side> = Vec::new();
    let mut room = [0; LENGTH + 1];
    while !stop.load(Ordering::Relaxed) {
        let length = match socket.recv(&mut room) {
            Ok(length) => length,
            Err(error)
                if matches!(
                    error.kind(),
                    ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted
                ) =>
            {
                continue;
            }
            Err(error) => return Err(error.into()),
        };
        let Some(row) = room.get(..length).and_then(Row::decode) else { continue };
        let Some(number) = row.side() else { continue };
        let place = match sides.iter().position(|side| side.side() == number) {
            Some(place) => place,
            None => {
                sides.push(Side::new(&context, number, &arguments.frame)?);
                println!("/telespring/robot{number} in domain {}", arguments.domain);
                sides.len() - 1
            }
        };
        if let (Some(side), Some(offset)) = (sides.get_mut(place), offset(monotonic)) {
            side.publish(&row, offset);
        }
    }
    Ok(())
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        if let Err(error) = signal_hook::flag::register(signal, Arc::clone(&stop)) {
            eprintln!("signal {signal} ends the program without a goodbye: {error}");
        }
    }
    match serve(&arguments, &stop) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}
