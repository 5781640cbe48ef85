//! What both sides know of each other's stance, and whether they may be coupled: the state machine of a session.
//!
//! Each side says where it stands in every greeting, and derives the common state from its own stance and the newest that it
//! knows of the partner. A consent is for one round. A side leaves the round whenever it leaves the coupling, and joins that
//! of a partner that is further; both take back its consent. So an old consent, repeated or overtaken, is never one for now.

use telespring::session::{LocalTime, Span};

use crate::hello::{Stamps, Stance};

/// A partner that says nothing for this long is not connected.
pub(super) const FRESH: Span = Span(1_000_000_000);

/// How far both sides are, together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stage {
    Connecting,
    Stopped,
    Homing,
    Paused,
    Aligning,
    Consenting,
    /// Both have consented, in this round.
    Agreed,
}

/// What the partner said last.
#[derive(Debug, Clone, Copy)]
struct Told {
    stance: Stance,
    sent: u64,
    heard: LocalTime,
}

/// Both stances.
#[derive(Debug, Clone, Default)]
pub(super) struct Accord {
    pub(super) own: Stance,
    partner: Option<Told>,
    /// The round in which this side is coupled.
    coupled: Option<u32>,
}

impl Accord {
    /// There is another partner, which is in this round: no consent is for it.
    pub(super) fn meet(&mut self, round: u32) {
        self.own.round = self.own.round.max(round).saturating_add(1);
        self.own.has_consented = false;
        self.own.is_aligned = false;
        (self.partner, self.coupled) = (None, None);
    }

    /// Takes the stance in a greeting of the partner; false if a later one came before.
    pub(super) fn hear(&mut self, now: LocalTime, stance: Stance, stamps: &Stamps) -> bool {
        if self.partner.is_some_and(|told| told.sent >= stamps.sent) {
            return false;
        }
        if stance.round > self.own.round {
            self.own.round = stance.round;
            self.own.has_consented = false;
        }
        self.partner = Some(Told { stance, sent: stamps.sent, heard: now });
        true
    }

    /// The partner's stance as known.
    pub(super) fn partner(&self) -> Option<&Stance> {
        self.partner.as_ref().map(|told| &told.stance)
    }

    /// Whether the partner has consented, in this round.
    pub(super) fn partner_consents(&self) -> bool {
        self.partner().is_some_and(|stance| stance.has_consented && stance.round == self.own.round)
    }

    /// Whether the partner wants a pause, as it said last.
    pub(super) fn partner_pauses(&self) -> bool {
        self.partner().is_some_and(|stance| stance.is_paused)
    }

    /// How far both sides are. `is_settled`: both have accepted each other's terms. Silence of a partner while coupled is for
    /// the watchdog to judge.
    pub(super) fn stage(&self, now: LocalTime, is_settled: bool) -> Stage {
        let own = &self.own;
        let is_fresh = |told: &Told| self.coupled.is_some() || now - told.heard <= FRESH;
        let partner = self.partner.as_ref().filter(|told| is_settled && is_fresh(told));
        let Some(Told { stance: partner, .. }) = partner else {
            return if own.is_stopped { Stage::Stopped } else { Stage::Connecting };
        };
        if own.is_stopped || partner.is_stopped {
            Stage::Stopped
        } else if !(own.is_ready && partner.is_ready) {
            Stage::Homing
        } else if own.is_paused || partner.is_paused {
            Stage::Paused
        } else if !(own.is_aligned && partner.is_aligned) {
            Stage::Aligning
        } else if !(own.has_consented && self.partner_consents()) {
            Stage::Consenting
        } else {
            Stage::Agreed
        }
    }

    /// Whether this side is coupled.
    pub(super) fn is_coupled(&self) -> bool {
        self.coupled.is_some()
    }

    /// This side is coupled from now on.
    pub(super) fn couple(&mut self) {
        self.coupled = Some(self.own.round);
    }

    /// This side is not coupled any more: the next time needs a new round and new consents.
    pub(super) fn part(&mut self) {
        if self.coupled.take() == Some(self.own.round) {
            self.own.round = self.own.round.saturating_add(1);
        }
        self.own.has_consented = false;
        self.own.is_aligned = false;
    }
}
