//! What is known of the partner from its packets alone.

#![deny(clippy::indexing_slicing)]

use super::DatagramError;
use crate::session::watchdog::{Cause, Fault, WatchdogSettings};
use crate::session::wire::{Echo, Flags, Packet};
use crate::session::{LocalTime, PeerTime};

/// Sessions of the partner that are over and recognised as such.
const RETIRED: usize = 8;

/// What a packet is to this side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Arrival {
    /// The first packet of all.
    First,
    /// Later than every packet before it.
    Later,
    /// Not later: it was overtaken, repeated, or frozen.
    Other,
    /// The first packet of a partner that has restarted.
    Restarted,
}

/// The latest packet.
#[derive(Debug, Clone, Copy)]
struct Latest {
    session: u64,
    sequence: u64,
    sent: PeerTime,
    arrival: LocalTime,
    /// Since when the position is the same, and how far the velocities sent since then go.
    still_since: PeerTime,
    still_travel: [f64; 2],
    position: [f64; 2],
}

/// The partner, from its packets.
#[derive(Debug, Clone)]
pub(super) struct Partner {
    latest: Option<Latest>,
    /// Session ids that are over, newest first.
    retired: [Option<u64>; RETIRED],
    heard: Option<LocalTime>,
    /// The energy of the sessions that are over, and the largest total of this one, J.
    energy: (f64, f64),
    stiffness: f64,
    flags: Flags,
    pub(super) restarts: u64,
}

impl Partner {
    pub(super) fn new() -> Self {
        Self {
            latest: None,
            retired: [None; RETIRED],
            heard: None,
            energy: (0.0, 0.0),
            stiffness: 0.0,
            flags: Flags::default(),
            restarts: 0,
        }
    }

    /// Takes a packet. `idle`: nothing later has come for so long that an earlier stamp means a restart, not a packet
    /// that was overtaken.
    pub(super) fn accept(
        &mut self,
        now: LocalTime,
        packet: &Packet,
        idle: bool,
    ) -> Result<Arrival, DatagramError> {
        if self.retired.contains(&Some(packet.session)) {
            return Err(DatagramError::FormerSession { session: packet.session });
        }
        let arrival = match &self.latest {
            None => Arrival::First,
            Some(latest) if latest.session != packet.session => Arrival::Restarted,
            Some(latest) => {
                let order = (packet.sequence.cmp(&latest.sequence), packet.sent.cmp(&latest.sent));
                use std::cmp::Ordering::{Equal, Greater, Less};
                match order {
                    (Greater, Greater) => Arrival::Later,
                    (Less, Less) if idle => Arrival::Restarted,
                    // a program whose clock stands still may go on counting
                    (Less, Less) | (Equal, Equal) | (Greater, Equal) => Arrival::Other,
                    (Less, Equal | Greater) | (Equal, Less | Greater) | (Greater, Less) => Arrival::Restarted,
                }
            }
        };
        if arrival == Arrival::Restarted {
            self.restarts = self.restarts.saturating_add(1);
            if let Some(former) = self.latest.map(|latest| latest.session).filter(|id| *id != packet.session)
            {
                self.retired.rotate_right(1);
                if let Some(place) = self.retired.first_mut() {
                    *place = Some(former);
                }
                self.energy = (self.energy.0 + self.energy.1, 0.0);
            }
            self.latest = None;
        }
        self.heard = Some(now);
        self.energy.1 = self.energy.1.max(packet.energy_sent);
        if arrival != Arrival::Other {
            self.latest = Some(self.follow(now, packet));
            (self.stiffness, self.flags) = (packet.stiffness, packet.flags);
        }
        Ok(arrival)
    }

    /// The record of a later packet.
    fn follow(&self, now: LocalTime, packet: &Packet) -> Latest {
        let mut latest = Latest {
            session: packet.session,
            sequence: packet.sequence,
            sent: packet.sent,
            arrival: now,
            still_since: packet.sent,
            still_travel: [0.0; 2],
            position: packet.motion.position,
        };
        if let Some(before) = self.latest.filter(|before| before.position == latest.position) {
            let elapsed = (packet.sent - before.sent).seconds();
            let ([x, y], [u, v]) = (before.still_travel, packet.motion.velocity);
            latest.still_since = before.still_since;
            latest.still_travel = [x + u * elapsed, y + v * elapsed];
        }
        latest
    }

    /// What is wrong with the partner at `now`, if anything.
    pub(super) fn fault(&self, now: LocalTime, settings: &WatchdogSettings) -> Option<Fault> {
        let (heard, latest) = (self.heard?, self.latest?);
        let silent = heard + settings.silence;
        if now >= silent {
            return Some(Fault { cause: Cause::Silence, since: silent });
        }
        let frozen = latest.arrival + settings.frozen;
        if now >= frozen {
            return Some(Fault { cause: Cause::FrozenStamps, since: frozen });
        }
        let still = latest.sent - latest.still_since;
        let travelled = latest.still_travel.iter().any(|travel| travel.abs() >= settings.frozen_distance);
        (still >= settings.frozen && travelled)
            .then_some(Fault { cause: Cause::FrozenMotion, since: latest.arrival })
    }

    /// The next time at which the partner is at fault if no packet comes.
    pub(super) fn next_timeout(&self, settings: &WatchdogSettings) -> Option<LocalTime> {
        let (heard, latest) = (self.heard?, self.latest?);
        Some((heard + settings.silence).min(latest.arrival + settings.frozen))
    }

    /// The newest stamp, as a packet sent at `now` echoes it.
    pub(super) fn echo(&self, now: LocalTime) -> Option<Echo> {
        // one that came after the stamp of the packet would make the round trip too short
        let latest = self.latest.filter(|latest| latest.arrival <= now)?;
        Some(Echo { stamp: latest.sent.seen_by_peer(), held: now - latest.arrival })
    }

    /// All energy that the partner has sent, J: the largest total of each of its sessions.
    pub(super) fn energy_sent(&self) -> f64 {
        self.energy.0 + self.energy.1
    }

    pub(super) fn stiffness(&self) -> f64 {
        self.stiffness
    }

    pub(super) fn flags(&self) -> Flags {
        self.flags
    }

    pub(super) fn session(&self) -> Option<u64> {
        self.latest.map(|latest| latest.session)
    }
}
