//! What both sides know of each other's stance, and whether they may be coupled: the state machine of a session.
//!
//! Each side says where it stands in every greeting, and derives the common state from its own stance and the newest that it
//! knows of the partner. A consent is for one round. A side leaves the round whenever it leaves the coupling, and joins that
//! of a partner that is further; both take back its consent. So an old consent, repeated or overtaken, is never one for now.
//!
//! Rounds count in a circle, since a partner may claim any: a last one that it could lead to would never be left.

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

/// Whether a round is further than another one: by less than half of the circle. Of two that are just half of it apart the larger
/// number is further, so that the sides still meet.
fn is_further(round: u32, other: u32) -> bool {
    const HALF: u32 = 1 << 31;
    match round.wrapping_sub(other) {
        0 => false,
        HALF => round > other,
        ahead => ahead < HALF,
    }
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
        let furthest = if is_further(round, self.own.round) { round } else { self.own.round };
        self.own.round = furthest.wrapping_add(1);
        self.own.has_consented = false;
        self.own.is_aligned = false;
        (self.partner, self.coupled) = (None, None);
    }

    /// Takes the stance in a greeting of the partner; false if a later one came before.
    pub(super) fn hear(&mut self, now: LocalTime, stance: Stance, stamps: &Stamps) -> bool {
        if self.partner.is_some_and(|told| told.sent >= stamps.sent) {
            return false;
        }
        if is_further(stance.round, self.own.round) {
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
            self.own.round = self.own.round.wrapping_add(1);
        }
        self.own.has_consented = false;
        self.own.is_aligned = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOW: LocalTime = LocalTime(0);

    /// What a partner says that would be coupled in this round.
    fn willing(round: u32) -> Stance {
        Stance { is_ready: true, is_aligned: true, has_consented: true, round, ..Stance::default() }
    }

    fn hear(accord: &mut Accord, round: u32, sent: u64) {
        assert!(accord.hear(NOW, willing(round), &Stamps { sent, ..Stamps::default() }));
    }

    #[test]
    fn law_of_two_rounds_one_is_further_wherever_they_are() {
        let rounds = [0, 1, 2, (1 << 31) - 1, 1 << 31, (1 << 31) + 1, u32::MAX - 1, u32::MAX];
        for one in rounds {
            assert!(!is_further(one, one));
            assert!(is_further(one.wrapping_add(1), one));
            for other in rounds.into_iter().filter(|other| *other != one) {
                assert!(is_further(one, other) != is_further(other, one), "{one} {other}");
            }
        }
    }

    #[test]
    fn law_no_round_that_a_partner_claims_is_the_last_one() {
        for claimed in [1, u32::MAX - 1, u32::MAX, 1 << 31, (1 << 31) - 1] {
            let mut accord = Accord::default();
            accord.meet(0);
            // by as many steps as it takes
            hear(&mut accord, claimed / 2, 1);
            hear(&mut accord, claimed, 2);
            accord.own = Stance { round: accord.own.round, position: None, ..willing(0) };
            let before = accord.own.round;
            hear(&mut accord, before, 3);
            assert_eq!(accord.stage(NOW, true), Stage::Agreed, "{claimed}");
            accord.couple();
            accord.part();
            // the consent that the partner gave before is none for now, whatever is consented here
            accord.own = Stance { round: accord.own.round, ..willing(0) };
            assert_eq!(accord.stage(NOW, true), Stage::Consenting, "{claimed}");
            hear(&mut accord, before, 4);
            assert_eq!(accord.stage(NOW, true), Stage::Consenting, "{claimed}");
            let now = accord.own.round;
            hear(&mut accord, now, 5);
            assert_eq!(accord.stage(NOW, true), Stage::Agreed, "{claimed}");
        }
    }

    #[test]
    fn law_two_sites_meet_in_one_round_wherever_a_third_one_has_led_one_of_them() {
        for led in [0, 5, u32::MAX, 1 << 31, (1 << 31) - 1, 3 << 30] {
            let mut sites = [Accord::default(), Accord::default()];
            sites[0].own.round = led;
            let rounds = sites.each_ref().map(|site| site.own.round);
            sites[0].meet(rounds[1]);
            sites[1].meet(rounds[0]);
            for sent in 1..4 {
                for side in 0..2 {
                    let stance = sites[1 - side].own;
                    assert!(sites[side].hear(NOW, stance, &Stamps { sent, ..Stamps::default() }));
                }
            }
            assert_eq!(sites[0].own.round, sites[1].own.round, "{led}");
        }
    }
}
