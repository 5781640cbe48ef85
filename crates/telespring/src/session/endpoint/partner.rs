//! What is known of the partner from its packets alone.

#![cfg_attr(not(test), deny(clippy::indexing_slicing))]

use super::DatagramError;
use crate::session::watchdog::{Cause, Fault, WatchdogSettings};
use crate::session::wire::{Echo, Flags, Packet};
use crate::session::{LocalTime, PeerTime, Span};

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
    /// Since when that contradicts each other for long and far enough.
    frozen_since: Option<LocalTime>,
    position: [f64; 2],
}

/// The partner, from its packets.
#[derive(Debug, Clone)]
pub(super) struct Partner {
    watchdog: Option<WatchdogSettings>,
    latest: Option<Latest>,
    /// Session ids that are over, newest first.
    retired: [Option<u64>; RETIRED],
    heard: Option<LocalTime>,
    /// The latest stamp of ours that the partner has echoed.
    echoed: Option<LocalTime>,
    /// The energy of the sessions that are over, and the largest total of this one, J.
    energy: (f64, f64),
    stiffness: f64,
    flags: Flags,
    pub(super) restarts: u64,
}

impl Partner {
    pub(super) fn new(watchdog: Option<WatchdogSettings>) -> Self {
        Self {
            watchdog,
            latest: None,
            retired: [None; RETIRED],
            heard: None,
            echoed: None,
            energy: (0.0, 0.0),
            stiffness: 0.0,
            flags: Flags::default(),
            restarts: 0,
        }
    }

    /// Takes a packet. `idle`: nothing later has come for so long that an earlier stamp may mean a restart, not a packet
    /// that was overtaken. It does if the packet echoes a later stamp of ours than any before, which no old packet that is
    /// sent once more does.
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
                    (Less, Less) if idle && packet.echo.map(|echo| echo.stamp) > self.echoed => {
                        Arrival::Restarted
                    }
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
        self.echoed = self.echoed.max(packet.echo.map(|echo| echo.stamp).filter(|stamp| *stamp <= now));
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
            frozen_since: None,
            position: packet.motion.position,
        };
        if let Some(before) = self.latest.filter(|before| before.position == latest.position) {
            let elapsed = (packet.sent - before.sent).seconds();
            let ([x, y], [u, v]) = (before.still_travel, packet.motion.velocity);
            latest.still_since = before.still_since;
            latest.still_travel = [x + u * elapsed, y + v * elapsed];
            let frozen = self.watchdog.is_some_and(|settings| {
                let far = latest.still_travel.iter().any(|travel| travel.abs() >= settings.frozen_distance);
                far && latest.sent - latest.still_since >= settings.frozen
            });
            latest.frozen_since = if frozen { before.frozen_since.or(Some(now)) } else { None };
        }
        latest
    }

    /// What is wrong with the partner at `now`, if anything.
    pub(super) fn fault(&self, now: LocalTime) -> Option<Fault> {
        let (settings, heard, latest) = (self.watchdog?, self.heard?, self.latest?);
        let silent = heard + settings.silence;
        if now > silent {
            return Some(Fault { cause: Cause::Silence, since: silent });
        }
        let frozen = latest.arrival + settings.frozen;
        if now > frozen {
            return Some(Fault { cause: Cause::FrozenStamps, since: frozen });
        }
        latest.frozen_since.map(|since| Fault { cause: Cause::FrozenMotion, since })
    }

    /// The times at which the partner is at fault if no packet comes.
    pub(super) fn timeouts(&self) -> [Option<LocalTime>; 2] {
        let Some(settings) = self.watchdog else { return [None; 2] };
        let frozen = self.latest.map(|latest| latest.arrival + settings.frozen + Span(1));
        [self.heard.map(|heard| heard + settings.silence + Span(1)), frozen]
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
