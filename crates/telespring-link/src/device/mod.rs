//! Devices: the robot of one side.
//!
//! A device reports a motion and applies a force until the next command. It ramps its force to zero by itself if no command
//! comes: nobody else can, once this program has died.

pub mod protocol;
pub mod request;
mod simulated;
mod udp;
mod unread;

pub use simulated::Simulated;
pub use udp::UdpDevice;

use std::os::fd::BorrowedFd;

use telespring::session::{LocalTime, Motion};

use crate::operator::Order;

/// The device's own count and time of a measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stamp {
    /// Counts the measurements of the device.
    pub sequence: f64,
    /// The device's own time, s.
    pub time: f64,
}

/// What a device says at a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// The motion, if a new one has been measured since the last tick.
    pub motion: Option<Motion>,
    /// The stamp of the newest measurement.
    pub stamp: Option<Stamp>,
    /// The mean force that acted on the handle since the last measurement, N, if it is known better than by the commands.
    pub acted: Option<[f64; 2]>,
    /// The target that the person is shown, if this program shows one.
    pub target: Option<Motion>,
    /// Whether the robot is homed and its motors may act.
    pub is_ready: bool,
    /// Whether its emergency stop is pressed.
    pub is_stopped: bool,
}

/// What a device is told at a tick.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Command {
    /// The force on the handle until the next command, N.
    pub force: [f64; 2],
    /// Whether the two sides are coupled: a simulated person moves meanwhile.
    pub is_running: bool,
    /// Whether the session is over.
    pub is_over: bool,
}

/// Why a device cannot go on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Fault {
    /// The simulated arm would have to stretch beyond its reach, or its motion is too stiff.
    #[error("the simulated robot cannot move on")]
    Halted,
    /// The device program has sent nothing for too long.
    #[error("the device is silent")]
    Silent,
    /// The device has reported values that cannot be for so long that no force acts.
    #[error("the device reports values that cannot be")]
    Impossible,
}

impl Fault {
    /// The fault in a word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Halted => "device-halted",
            Self::Silent => "device-silent",
            Self::Impossible => "device-impossible",
        }
    }

    /// Whether the device cannot come back.
    pub fn is_final(self) -> bool {
        matches!(self, Self::Halted)
    }
}

/// The robot of one side. No call waits or allocates.
pub trait Device {
    /// Takes what the device has sent so far; whether it has measured anew since the latest reading. Only a device with a pace
    /// of its own is asked.
    fn listen(&mut self, now: LocalTime) -> bool {
        let _ = now;
        false
    }

    /// What the device says now.
    ///
    /// # Errors
    ///
    /// [`Fault`] if it cannot go on.
    fn read(&mut self, now: LocalTime) -> Result<Reading, Fault>;

    /// Tells the device what to do from now on.
    fn command(&mut self, now: LocalTime, command: Command);

    /// The oldest order that somebody gave at the device and that nobody has asked for yet.
    fn poll_order(&mut self) -> Option<Order> {
        None
    }

    /// What a robot that is not ready lacks, in words; `None` if it is ready, or does not say.
    fn lacks(&self) -> Option<&'static str> {
        None
    }

    /// What becomes readable when the device has sent something, if the device has a pace of its own: [`Device::listen`] says
    /// whether that is a measurement.
    fn pace(&self) -> Option<BorrowedFd<'_>> {
        None
    }
}

impl<D: Device + ?Sized> Device for Box<D> {
    fn listen(&mut self, now: LocalTime) -> bool {
        (**self).listen(now)
    }

    fn read(&mut self, now: LocalTime) -> Result<Reading, Fault> {
        (**self).read(now)
    }

    fn command(&mut self, now: LocalTime, command: Command) {
        (**self).command(now, command);
    }

    fn poll_order(&mut self) -> Option<Order> {
        (**self).poll_order()
    }

    fn lacks(&self) -> Option<&'static str> {
        (**self).lacks()
    }

    fn pace(&self) -> Option<BorrowedFd<'_>> {
        (**self).pace()
    }
}
