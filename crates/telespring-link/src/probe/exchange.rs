//! What comes in, and telling the partner what came.

use telespring::session::{LocalTime, Packet, Span};

use super::report::{ABSENT, PER_BLOCK, Report};
use super::{MOST_PACKETS, Probe, Stage};
use crate::clock::Clock;
use crate::hello::{Greeting, NoGreeting};
use crate::transport::{ROOM, Transport};

/// Blocks of the report per tick.
const BLOCKS_PER_TICK: usize = 2;
/// Datagrams that are looked at in one tick.
const MOST_DATAGRAMS: usize = 256;
/// A block is sent again if it is not acknowledged after two round trips and this.
const AGAIN: Span = Span(50_000_000);

/// The partner's report as far as it has come.
#[derive(Debug, Clone)]
pub(super) struct Heard {
    /// The partner's own first packet of the measurement, and how many there are.
    pub(super) first: usize,
    pub(super) packets: usize,
    /// Travels of the own packets, on two clocks, ns.
    blocks: Vec<Option<[Option<i64>; PER_BLOCK]>>,
    /// Blocks from the beginning without a gap.
    complete: usize,
}

impl Heard {
    pub(super) fn is_complete(&self) -> bool {
        !self.blocks.is_empty() && self.complete == self.blocks.len()
    }

    /// Takes a block of this report.
    fn take(&mut self, report: &Report) {
        let place = usize::try_from(report.block).ok().and_then(|block| self.blocks.get_mut(block));
        let Some(place) = place else { return };
        *place = Some(report.travels.map(|units| {
            (units != ABSENT).then(|| report.base.saturating_add(i64::from(units).saturating_mul(100)))
        }));
        while self.blocks.get(self.complete).is_some_and(Option::is_some) {
            self.complete += 1;
        }
    }

    /// The travels of the own packets, on two clocks, ns; `None` as long as blocks are missing.
    pub(super) fn travels(&self, packets: usize) -> Option<Vec<Option<i64>>> {
        let blocks: Option<Vec<_>> = self.blocks.iter().copied().collect();
        Some(blocks?.into_iter().flatten().take(packets).collect())
    }
}

/// What the partner has been told.
#[derive(Debug, Clone, Default)]
pub(super) struct Told {
    /// When each block was sent last; empty before the partner's number of packets is known.
    sent: Vec<Option<LocalTime>>,
    /// Blocks that the partner has, from the beginning.
    acknowledged: usize,
}

impl Told {
    fn is_complete(&self) -> bool {
        !self.sent.is_empty() && self.acknowledged >= self.sent.len()
    }

    /// The next block to send: the first that the partner may not have.
    fn next(&mut self, now: LocalTime, again: Span) -> Option<usize> {
        let (block, place) = self
            .sent
            .iter_mut()
            .enumerate()
            .skip(self.acknowledged)
            .find(|(_, sent)| sent.is_none_or(|sent| now - sent >= again))?;
        *place = Some(now);
        Some(block)
    }
}

/// Blocks of a report on this many packets.
fn blocks(packets: usize) -> usize {
    packets.div_ceil(PER_BLOCK)
}

impl<T: Transport> Probe<T> {
    /// Whether both ways are known here and the partner knows what came here.
    pub(super) fn knows_all(&self) -> bool {
        self.told.is_complete() && self.reported.as_ref().is_some_and(Heard::is_complete)
    }

    /// Takes what has come.
    pub(super) fn receive(&mut self, clock: &impl Clock) {
        let mut room = [0; ROOM];
        for _ in 0..MOST_DATAGRAMS {
            let Some(length) = self.transport.receive(clock.now(), &mut room) else { return };
            let datagram = room.get(..length).unwrap_or_default();
            let now = clock.now();
            if let Ok(packet) = Packet::decode(datagram) {
                self.take_packet(now, &packet);
            } else if let Some(report) = Report::decode(datagram) {
                self.take_report(now, &report);
            } else {
                self.runs_session |= Greeting::decode(datagram) != Err(NoGreeting::Foreign);
                self.strange += 1;
            }
        }
    }

    /// Whether a datagram of this session is the partner's.
    fn is_partner(&mut self, session: u64) -> bool {
        if session == self.settings.session || self.partner.is_some_and(|partner| partner != session) {
            self.strange += 1;
            // somebody who comes anew, after an echo: the partner's program was started again
            if self.stage == Stage::Waiting && session != self.settings.session {
                (self.partner, self.newest) = (None, None);
                self.clock.forget();
                self.travels.clear();
            } else {
                return false;
            }
        }
        self.partner = Some(session);
        true
    }

    fn take_packet(&mut self, now: LocalTime, packet: &Packet) {
        if !self.is_partner(packet.session) {
            return;
        }
        self.heard = Some(now);
        self.clock.handle_packet(now, packet);
        if self.newest.is_none_or(|(sent, _)| packet.sent > sent) {
            self.newest = Some((packet.sent, now));
        }
        if self.stage == Stage::Measuring
            && let Some(round_trip) = self.clock.report(now).round_trip
            && self.round_trips.len() < self.round_trips.capacity()
        {
            self.round_trips.push(round_trip);
        }
        if let Ok(number) = usize::try_from(packet.sequence) {
            let travel = now.0.cast_signed().wrapping_sub(packet.sent.0.cast_signed());
            self.travels.note(number, travel);
            if self.stage == Stage::Measuring {
                self.first_heard = Some(self.first_heard.map_or(number, |first| first.min(number)));
            }
        }
    }

    fn take_report(&mut self, now: LocalTime, report: &Report) {
        if report.partner != self.settings.session {
            self.strange += 1;
            return;
        }
        if !self.is_partner(report.session) {
            return;
        }
        self.heard = Some(now);
        let (Ok(first), Ok(packets)) = (usize::try_from(report.first), usize::try_from(report.packets))
        else {
            return;
        };
        if !(1..=MOST_PACKETS).contains(&packets) {
            return;
        }
        if self.told.sent.is_empty() {
            self.told.sent = vec![None; blocks(packets)];
        }
        let acknowledged = usize::try_from(report.acknowledged).unwrap_or(0).min(self.told.sent.len());
        self.told.acknowledged = self.told.acknowledged.max(acknowledged);
        let heard =
            self.reported.get_or_insert_with(|| Heard { first, packets, blocks: Vec::new(), complete: 0 });
        // while this side measures, nobody can know how many packets there will be
        let own = blocks(self.sent.len());
        if self.stage == Stage::Reporting && report.blocks == own as u64 {
            heard.blocks.resize(own, None);
            heard.take(report);
        }
    }

    /// Sends what the partner does not know yet.
    pub(super) fn tell(&mut self, now: LocalTime) {
        let Some(partner) = self.partner else { return };
        let round_trip = self.clock.report(now).round_trip.unwrap_or_default();
        let again = round_trip + round_trip + AGAIN;
        let first = self.reported.as_ref().map_or(0, |heard| heard.first);
        for sent in 0..BLOCKS_PER_TICK {
            let next = self.told.next(now, again);
            if next.is_none() && sent > 0 {
                return;
            }
            let (base, travels) = self.travels.block(first, next.unwrap_or(0));
            let report = Report {
                session: self.settings.session,
                partner,
                first: self.first,
                packets: self.sent.len() as u64,
                blocks: self.told.sent.len() as u64,
                acknowledged: self.reported.as_ref().map_or(0, |heard| heard.complete) as u64,
                block: next.map_or(u64::MAX, |block| block as u64),
                base,
                travels,
            };
            self.transport.send(now, &report.encode());
        }
    }
}
