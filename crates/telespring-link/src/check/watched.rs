//! A device that is listened to, and told nothing but zero.

use std::cell::Cell;
use std::os::fd::BorrowedFd;
use std::rc::Rc;

use telespring::session::{LocalTime, Span};

use crate::device::{Command, Device, Fault, Reading};

/// What a device has said.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Seen {
    /// Ticks at which it had a new motion.
    pub rows: u64,
    /// From the first to the latest of them.
    pub first: Option<LocalTime>,
    /// See `first`.
    pub latest: LocalTime,
    /// The longest time between two of them.
    pub longest_gap: Span,
    /// Whether a value was not finite.
    pub is_impossible: bool,
    /// Whether it is ready, as it said last.
    pub is_ready: bool,
    /// What it lacks to be ready, in words, as it said last.
    pub lacks: Option<&'static str>,
    /// Whether its emergency stop is pressed, as it said last.
    pub is_stopped: bool,
    /// Whether it measures the force on the handle.
    pub has_force: bool,
    /// Why it could not go on.
    pub fault: Option<Fault>,
}

/// A device that seems never to be ready. It is commanded zero, whatever it is asked to do.
#[derive(Debug)]
pub struct Watched<D> {
    device: D,
    seen: Rc<Cell<Seen>>,
}

impl<D> Watched<D> {
    /// The device, and what it says.
    pub fn new(device: D) -> (Self, Rc<Cell<Seen>>) {
        let seen = Rc::default();
        (Self { device, seen: Rc::clone(&seen) }, seen)
    }
}

impl<D: Device> Device for Watched<D> {
    fn listen(&mut self, now: LocalTime) -> bool {
        self.device.listen(now)
    }

    fn read(&mut self, now: LocalTime) -> Result<Reading, Fault> {
        let mut seen = self.seen.get();
        let reading = match self.device.read(now) {
            Ok(reading) => reading,
            Err(fault) => {
                seen.fault = Some(fault);
                self.seen.set(seen);
                // the loop and the partner are tried all the same
                return Ok(nothing());
            }
        };
        if let Some(motion) = reading.motion {
            let first = *seen.first.get_or_insert(now);
            let before = if seen.rows == 0 { first } else { seen.latest };
            seen.rows += 1;
            seen.longest_gap = seen.longest_gap.max(now - before);
            seen.latest = now;
            let mut values = motion.position.into_iter().chain(motion.velocity);
            seen.is_impossible |= !values.all(f64::is_finite);
        }
        seen.has_force |= reading.acted.is_some();
        (seen.is_ready, seen.is_stopped) = (reading.is_ready, reading.is_stopped);
        seen.lacks = self.device.lacks();
        self.seen.set(seen);
        Ok(Reading { is_ready: false, is_stopped: false, ..reading })
    }

    fn command(&mut self, now: LocalTime, _: Command) {
        self.device.command(now, Command::default());
    }

    fn pace(&self) -> Option<BorrowedFd<'_>> {
        self.device.pace()
    }
}

/// What a device says that says nothing.
fn nothing() -> Reading {
    Reading { motion: None, stamp: None, acted: None, target: None, is_ready: false, is_stopped: false }
}
