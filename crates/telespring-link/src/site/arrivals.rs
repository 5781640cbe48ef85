//! What comes in: greetings, packets of the session agreed to, and everything else, which is counted.

use telespring::session::{LocalTime, WatchdogState, wire};

use super::greeter::Heard;
use super::{Cause, Happened, Phase, Site};
use crate::clock::Clock;
use crate::device::Device;
use crate::hello::{Disagreement, Greeting, NoGreeting};
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
            Err(NoGreeting::OtherVersion) => {
                if self.phase == Phase::Greeting && self.greeter.note_version(now) {
                    self.log.push(now, Happened::Disagreed(Disagreement::Version));
                }
            }
            Err(NoGreeting::Foreign) => self.take_packet(now, datagram),
        }
    }

    /// Takes a greeting.
    fn hear(&mut self, now: LocalTime, greeting: &Greeting) {
        let is_greeting = self.phase == Phase::Greeting;
        match self.greeter.hear(now, greeting, is_greeting, self.is_idle()) {
            Heard::Nothing => {}
            Heard::Refusable => self.tally.strange_greetings += 1,
            Heard::Disagreed(disagreement) => self.log.push(now, Happened::Disagreed(disagreement)),
            Heard::Agreed(session) => self.log.push(now, Happened::Agreed { session }),
            Heard::Left => self.leave(now, Cause::PartnerLeft),
        }
        self.begin(now);
    }

    /// Whether no force acts because of the partner. One that has started anew is greeted anew, but not before.
    fn is_idle(&self) -> bool {
        match self.phase {
            Phase::Greeting => true,
            Phase::Running => matches!(self.endpoint.state(), WatchdogState::Disengaged { .. }),
            Phase::Leaving | Phase::Ended => false,
        }
    }

    /// Begins to run once both sides have agreed.
    fn begin(&mut self, now: LocalTime) {
        if self.phase == Phase::Greeting && self.greeter.is_settled() {
            self.phase = Phase::Running;
            self.log.push(now, Happened::Running);
        }
    }

    /// Takes a packet: only that of the session agreed to reaches the endpoint.
    fn take_packet(&mut self, now: LocalTime, datagram: &[u8]) {
        let packet = wire::Packet::decode(datagram).ok();
        if let Some(session) = packet.map(|packet| packet.session) {
            if self.greeter.partner() != Some(session) {
                self.tally.strange_packets += 1;
                if self.is_idle() {
                    self.greeter.note_stranger();
                }
                return;
            }
            // Whoever sends packets to this side has agreed to its terms.
            self.greeter.note_packet();
            self.begin(now);
        }
        if !self.phase.is_coupled() {
            self.tally.early_datagrams += 1;
            return;
        }
        let is_taken = self.endpoint.handle_datagram(now, datagram).is_ok();
        if is_taken {
            self.heard = Some(now);
        }
        self.notes.arrive(now, datagram, packet.filter(|_| is_taken));
    }
}
