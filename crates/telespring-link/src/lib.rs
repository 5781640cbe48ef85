//! One side of a live coupling: the endpoint of [`telespring::session`] with a clock, a device and a network.
//!
//! Linux only. The endpoint decides what the force is; this crate measures, sends, waits and commands, and holds the force
//! at zero until both sides have agreed on what they are coupled by.
//!
//! | room | its one job | which thread |
//! |---|---|---|
//! | [`clock`] | the monotonic clock, and sleeping until a point of time | the loop |
//! | [`transport`] | datagrams to and from the partner: iroh, UDP, an emulated path on top | the loop; iroh has one of its own |
//! | [`keys`] | the key of a site, in a file; who may be the partner | before the loop |
//! | [`device`] | the robot: simulated, or a program that speaks the device protocol | the loop |
//! | [`operator`] | orders and markers of the people at a site | one thread for the console, then the loop |
//! | [`hello`] | what both sides must agree on before any force, and where each stands | the loop |
//! | [`site`] | one side: device, endpoint, transport and the state of the session; one tick | the loop |
//! | [`real_time`] | the loop: absolute sleeps, lateness, overruns, priority, locked memory | the loop |
//! | [`feed`] | every tick and event, through queues to those who watch | from the loop to one thread each |
//! | [`telemetry`] | a row of numbers per tick for programs beside this one | its own |
//! | [`record`] | the recording and the live view, watching through the feed | threads of their own |
//! | [`settings`] | the site file, checked | before the loop |
//! | [`summary`] | what a session was, as JSON | after the loop |
//! | [`conduct`] | one session on its own thread: settings in, summary out | starts the loop |
//! | [`console`] | status and events as JSON lines, while a session runs | one of its own |
//! | [`check`] | loop, device and partner of a site, tried without any force | starts the loop |
//! | [`probe`] | measures the path to a partner | a loop of its own |
//! | [`demo`] | both sides on this machine | starts two loops |
//!
//! One thread touches a site: the one that runs its loop. It allocates nothing after its start, takes no lock and writes no
//! file. What others want to know of it, it hands out per tick ([`site::Moment`]).

#![cfg_attr(not(test), deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::todo))]
#![deny(unsafe_code)]

#[cfg(not(target_os = "linux"))]
compile_error!(
    "telespring-link runs on Linux only: its loop needs Linux's absolute sleep and real-time priority"
);

pub mod check;
pub mod clock;
pub mod conduct;
pub mod console;
pub mod demo;
pub mod device;
pub mod feed;
pub mod hello;
pub mod keys;
pub mod operator;
pub mod probe;
pub mod real_time;
pub mod record;
pub mod settings;
pub mod site;
pub mod summary;
pub mod telemetry;
pub mod transport;
