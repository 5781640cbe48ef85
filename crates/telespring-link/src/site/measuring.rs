//! What the device says, what it means for this side, and what the endpoint is told of it.

use telespring::session::watchdog::Cause as WatchdogCause;
use telespring::session::{EventKind, LocalTime, Motion, Span, WatchdogState};

use super::coupling::Coupling;
use super::{Cause, Happened, Interruption, Limits, Site};
use crate::device::{Device, Fault, Reading};
use crate::transport::Transport;

/// A machine that was suspended for longer has missed what happened.
const NAP: Span = Span(50_000_000);
/// Impossible forces within this time of the previous one that was told are passed over.
const QUIET: Span = Span(1_000_000_000);

impl<D: Device, T: Transport> Site<D, T> {
    /// Reads the device, and what it means for this side.
    pub(super) fn read(&mut self, now: LocalTime) -> Option<Reading> {
        match self.device.read(now) {
            Ok(reading) => {
                self.is_pressed = reading.is_stopped;
                if reading.is_stopped && !self.accord.own.is_stopped {
                    self.accord.own.is_stopped = true;
                    self.interrupt(now, Interruption::EmergencyStop);
                    self.tell_stop(now, true);
                }
                if let Some(motion) = &reading.motion {
                    self.handle = Some(*motion);
                    self.awaited.device = false;
                    self.travel.take(now, motion);
                }
                let reading = self.unlocked(reading);
                self.motion = reading.motion.or(self.motion);
                // while coupled, the endpoint and its watchdog see to what cannot be
                let is_possible = self.coupling != Coupling::Off || !self.motion.is_some_and(is_impossible);
                let is_ready = reading.is_ready && !reading.is_stopped && is_possible;
                if self.accord.own.is_ready && !is_ready {
                    self.interrupt(now, Interruption::DeviceNotReady);
                }
                self.accord.own.is_ready = is_ready;
                Some(reading)
            }
            Err(fault) => {
                if fault.is_final() {
                    self.end(now, Cause::Device(fault));
                } else if self.accord.own.is_ready {
                    self.interrupt(now, Interruption::Device(fault));
                }
                self.accord.own.is_ready = false;
                (self.motion, self.handle) = (None, None);
                self.travel.forget();
                None
            }
        }
    }

    /// Says that an emergency stop has latched.
    pub(super) fn tell_stop(&mut self, now: LocalTime, is_own: bool) {
        self.tally.emergency_stops += 1;
        self.log.push(now, Happened::EmergencyStop { is_own });
    }

    /// Gives the endpoint the own motion, and sends its packet.
    pub(super) fn measure(&mut self, now: LocalTime, reading: &Reading) {
        let Some(motion) = reading.motion else { return };
        if !is_impossible(motion) {
            let passed = self.gate.settle(now, motion.position);
            self.notes.forces.told = self.measured_force(now, reading).or(passed);
        }
        if let Some(acted) = self.notes.forces.told {
            self.endpoint.handle_acted(acted);
        }
        self.notes.is_measured = true;
        // A motion that cannot be is an event of the endpoint, and its watchdog sees to the force.
        let _ = self.endpoint.handle_measurement(now, motion);
        if let Some(target) = reading.target {
            self.endpoint.handle_target(now, target);
        }
        if self.coupling != Coupling::Off
            && self.transport.is_due()
            && let Some(packet) = self.endpoint.poll_transmit(now)
        {
            self.transport.send(now, &packet);
        }
    }

    /// Whether the account still owes what acted before the coupling ended: its last moment, or the time in which the device was
    /// silent.
    pub(super) fn owes(&self, reading: &Reading) -> bool {
        !self.gate.is_settled() && reading.motion.is_some_and(|motion| !is_impossible(motion))
    }

    /// The force that the device has measured, if it can be: the account believes it.
    fn measured_force(&mut self, now: LocalTime, reading: &Reading) -> Option<[f64; 2]> {
        let acted = reading.acted?;
        let places = ["measured force in x (place 7)", "measured force in y (place 8)"];
        let is_wrong = |(_, value): &(&str, f64)| !(value.abs() <= Limits::NONE.force);
        let Some((what, value)) = places.into_iter().zip(acted).find(is_wrong) else {
            return Some(acted);
        };
        if self.impossible_force.is_none_or(|then| now - then >= QUIET) {
            self.impossible_force = Some(now);
            self.log.push(now, Happened::ImpossibleValue { what, value });
        }
        None
    }

    /// A machine that was suspended lets go before anything else: its clock has stood still, so no watchdog has noticed.
    pub(super) fn judge_machine(&mut self, now: LocalTime, suspended: Span) {
        let before = self.suspended.unwrap_or(suspended);
        if suspended - before > NAP {
            self.interrupt(now, Interruption::Suspended);
        }
        self.suspended = Some(suspended.max(before));
    }

    /// A device whose values could not be for so long that no force acts is at fault: what it says next may be of another place.
    pub(super) fn judge_device(&mut self, now: LocalTime) {
        let let_go = WatchdogState::Disengaged { cause: WatchdogCause::OwnMeasurement };
        let is_on = matches!(self.coupling, Coupling::On { .. });
        if is_on && self.endpoint.state() == let_go && self.motion.is_some_and(is_impossible) {
            self.interrupt(now, Interruption::Device(Fault::Impossible));
            self.accord.own.is_ready = false;
        }
    }
}

/// An event of the endpoint; of a value that cannot be, which one it is.
pub(super) fn event(kind: EventKind, motion: Option<Motion>) -> Happened {
    let EventKind::ImpossibleValue { value } = kind else { return Happened::Session(kind) };
    let Some(Motion { position, velocity }) = motion else { return Happened::Session(kind) };
    let places = [
        "position in x (place 3)",
        "position in y (place 4)",
        "velocity in x (place 5)",
        "velocity in y (place 6)",
    ];
    let values = position.into_iter().chain(velocity);
    let found = places.into_iter().zip(values).find(|(_, one)| one.to_bits() == value.to_bits());
    found.map_or(Happened::Session(kind), |(what, value)| Happened::ImpossibleValue { what, value })
}

fn is_impossible(motion: Motion) -> bool {
    motion.impossible_value().is_some()
}
