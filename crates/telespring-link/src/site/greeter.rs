//! The greeting of one side: who the partner is, and whether both agree.

use telespring::session::{LocalTime, Span};

use crate::hello::{Disagreement, Greeting, Purpose, Terms};

/// What a greeting meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Heard {
    /// Nothing new.
    Nothing,
    /// It is not for this session, or comes while the session has another partner.
    Refusable,
    /// The two sides do not agree; said once per disagreement.
    Disagreed(Disagreement),
    /// This side agrees to the partner's terms.
    Agreed(u64),
    /// The partner says goodbye.
    Left,
}

/// Refusals since anything else was heard.
#[derive(Debug, Clone, Copy)]
struct Refusal {
    disagreement: Disagreement,
    since: LocalTime,
    count: u32,
}

/// Refusals that a single stray greeting does not make.
const ENOUGH: u32 = 10;

/// The greeting of one side.
#[derive(Debug, Clone)]
pub(super) struct Greeter {
    session: u64,
    terms: Terms,
    /// Whether the own device is ready: no partner is accepted before.
    pub(super) is_ready: bool,
    /// The partner whose terms fit.
    partner: Option<u64>,
    /// Whether the partner has accepted this session.
    is_accepted: bool,
    /// Why the partner in sight does not fit.
    refused: Option<Refusal>,
    /// A greeting wants an answer; at once, because something has changed.
    owes: bool,
    urgent: bool,
}

impl Greeter {
    pub(super) fn new(session: u64, terms: Terms) -> Self {
        Self {
            session,
            terms,
            is_ready: false,
            partner: None,
            is_accepted: false,
            refused: None,
            owes: false,
            urgent: false,
        }
    }

    /// What both sides must agree on.
    pub(super) fn terms(&self) -> &Terms {
        &self.terms
    }

    /// The partner agreed to.
    pub(super) fn partner(&self) -> Option<u64> {
        self.partner
    }

    /// Both sides have accepted each other, and both devices are ready.
    pub(super) fn is_settled(&self) -> bool {
        self.is_ready && self.partner.is_some() && self.is_accepted
    }

    pub(super) fn owes_answer(&self) -> bool {
        self.owes
    }

    pub(super) fn is_urgent(&self) -> bool {
        self.urgent
    }

    /// The partner has sent a packet: it runs, so it has accepted.
    pub(super) fn note_packet(&mut self) {
        self.is_accepted = true;
    }

    /// A packet of another session came: if no force acts, its sender is greeted, so that it may greet in turn.
    pub(super) fn note_stranger(&mut self) {
        self.owes = true;
    }

    /// A greeting of another version came; true if that is news.
    pub(super) fn note_version(&mut self, now: LocalTime) -> bool {
        self.owes = true;
        self.refuse(now, Disagreement::Version)
    }

    /// True if the disagreement is news.
    fn refuse(&mut self, now: LocalTime, disagreement: Disagreement) -> bool {
        let before = self.refused;
        let (since, count) = before.map_or((now, 0), |refusal| (refusal.since, refusal.count));
        self.refused = Some(Refusal { disagreement, since, count: count.saturating_add(1) });
        before.is_none_or(|refusal| refusal.disagreement != disagreement)
    }

    /// The disagreement, if nothing but refusals, and enough of them, have been heard for this long.
    pub(super) fn refused_for(&self, now: LocalTime, patience: Span) -> Option<Disagreement> {
        let refusal = self.refused.filter(|refusal| refusal.count >= ENOUGH);
        refusal.filter(|refusal| now - refusal.since >= patience).map(|refusal| refusal.disagreement)
    }

    /// Takes a greeting. `is_greeting`: the session does not run yet; `is_idle`: no force acts because of the partner, so it
    /// may be another one from now on.
    pub(super) fn hear(
        &mut self,
        now: LocalTime,
        greeting: &Greeting,
        is_greeting: bool,
        is_idle: bool,
    ) -> Heard {
        if greeting.session == self.session {
            return Heard::Refusable;
        }
        let is_known = self.partner == Some(greeting.session);
        if greeting.purpose == Purpose::Goodbye {
            let is_ours = is_known && greeting.accepted == self.session;
            return if is_ours { Heard::Left } else { Heard::Refusable };
        }
        if let Some(disagreement) = self.terms.disagreement(&greeting.terms).or(greeting.refusal) {
            if !is_idle {
                return Heard::Refusable;
            }
            if is_known && is_greeting {
                (self.partner, self.is_accepted) = (None, false);
            }
            self.owes = true;
            return if self.refuse(now, disagreement) {
                Heard::Disagreed(disagreement)
            } else {
                Heard::Nothing
            };
        }
        if !is_known && !is_idle {
            return Heard::Refusable;
        }
        self.owes = true;
        self.refused = None;
        self.is_accepted = greeting.accepted == self.session || (is_known && self.is_accepted);
        if is_known {
            return Heard::Nothing;
        }
        self.partner = Some(greeting.session);
        self.urgent = true;
        Heard::Agreed(greeting.session)
    }

    /// The greeting to send now.
    pub(super) fn greeting(&mut self, purpose: Purpose) -> Greeting {
        (self.owes, self.urgent) = (false, false);
        Greeting {
            purpose,
            session: self.session,
            accepted: self.partner.filter(|_| self.is_ready || purpose == Purpose::Goodbye).unwrap_or(0),
            refusal: self.refused.map(|refusal| refusal.disagreement),
            terms: self.terms,
        }
    }
}
