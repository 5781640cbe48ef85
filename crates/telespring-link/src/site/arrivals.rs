//! What comes in: greetings, packets of the session agreed to, and everything else, which is counted.

use telespring::session::{LocalTime, WatchdogState, wire};

use super::coupling::Coupling;
use super::greeter::Heard;
use super::round_trip::RoundTrips;
use super::{Happened, Interruption, Phase, Site};
use crate::clock::Clock;
use crate::device::Device;
use crate::hello::{Greeting, NoGreeting};
use crate::transport::{ROOM, Transport};

/// Datagrams that are looked at in one tick; the rest waits, or is lost in the kernel's buffer.
pub(super) const MOST_DATAGRAMS: usize = 256;

impl<D: Device, T: Transport> Site<D, T> {
    /// Takes what has come.
    pub(super) fn receive(&mut self, clock: &impl Clock) {
        let mut room = [0; ROOM];
        for _ in 0..MOST_DATAGRAMS {
            // The clock is read after the arrival: a stamp of the partner, on one machine, is never later.
            let Some(length) = self.transport.receive(clock.now(), &mut room) else { return };
            let now = clock.now();
            self.take(now, room.get(..length).unwrap_or_default());
        }
        self.tally.full_ticks += 1;
    }

    /// Takes a datagram.
    fn take(&mut self, now: LocalTime, datagram: &[u8]) {
        match Greeting::decode(datagram) {
            Ok(greeting) => self.hear(now, &greeting),
            Err(NoGreeting::OtherVersion(version)) => {
                if self.phase == Phase::Connecting
                    && let Some(difference) = self.greeter.note_version(now, version)
                {
                    self.log.push(now, Happened::Disagreed(difference));
                }
            }
            Err(NoGreeting::Foreign) => self.take_packet(now, datagram),
        }
    }

    /// Takes a greeting.
    fn hear(&mut self, now: LocalTime, greeting: &Greeting) {
        self.awaited.partner = false;
        match self.greeter.hear(now, greeting, self.is_idle()) {
            Heard::Nothing => {}
            Heard::Refusable => self.tally.strange_greetings += 1,
            Heard::Disagreed(difference) => {
                self.interrupt(now, Interruption::PartnerChanged);
                self.log.push(now, Happened::Disagreed(difference));
            }
            Heard::Agreed(session) => {
                self.interrupt(now, Interruption::PartnerChanged);
                self.accord.meet(greeting.stance.round);
                self.round_trips = RoundTrips::default();
                self.log.push(now, Happened::Agreed { session });
                self.lock(now, greeting.terms.lock);
                self.learn(now, greeting);
            }
            Heard::Partner => self.learn(now, greeting),
            Heard::Left => self.part_for_good(now),
        }
    }

    /// Takes where the partner stands.
    fn learn(&mut self, now: LocalTime, greeting: &Greeting) {
        let before =
            (self.accord.partner_consents(), self.accord.partner().is_some_and(|stance| stance.is_stopped));
        let round = self.accord.own.round;
        if !self.accord.hear(now, greeting.stance, &greeting.stamps) {
            self.tally.overtaken_greetings += 1;
            return;
        }
        self.round_trips.take(now, &greeting.stamps);
        if self.accord.own.round != round {
            self.greeter.hurry();
        }
        if self.accord.partner_consents() && !before.0 {
            self.log.push(now, Happened::PartnerConsented);
        }
        if greeting.stance.is_stopped && !before.1 {
            self.tell_stop(now, false);
        }
    }

    /// Whether no force acts because of the partner. One that has started anew is greeted anew, but not before.
    fn is_idle(&self) -> bool {
        match self.coupling {
            _ if self.left.is_some() => false,
            Coupling::Off => true,
            Coupling::On { .. } => matches!(self.endpoint.state(), WatchdogState::Disengaged { .. }),
            Coupling::Falling { .. } => false,
        }
    }

    /// Takes a packet: only that of the session agreed to reaches the endpoint.
    fn take_packet(&mut self, now: LocalTime, datagram: &[u8]) {
        let packet = wire::Packet::decode(datagram).ok();
        if let Some(session) = packet.map(|packet| packet.session) {
            if self.greeter.partner() != Some(session) {
                self.tally.strange_packets += 1;
                return;
            }
            // Whoever sends packets to this side has agreed to its terms.
            self.greeter.note_packet();
        }
        if self.coupling == Coupling::Off {
            self.tally.early_datagrams += 1;
            self.passed_over.pass(packet.as_ref());
            return;
        }
        let is_taken = self.endpoint.handle_datagram(now, datagram).is_ok();
        let taken = packet.filter(|_| is_taken);
        if let Some(taken) = &taken {
            self.heard = Some(now);
            self.passed_over.take(taken);
        }
        self.notes.arrive(now, datagram, taken);
    }
}
