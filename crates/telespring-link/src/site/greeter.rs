//! The greeting of one side: who the partner is, and whether both agree.

use telespring::session::{LocalTime, Span};

use crate::hello::{Difference, Disagreement, Greeting, Purpose, Stamps, Stance, Terms};

/// What a greeting meant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Heard {
    /// Nothing new.
    Nothing,
    /// It is the partner's, and the terms fit.
    Partner,
    /// It is not for this session, or comes while the session has another partner.
    Refusable,
    /// The two sides do not agree; said once per disagreement.
    Disagreed(Difference),
    /// This side agrees to the partner's terms.
    Agreed(u64),
    /// The partner says goodbye.
    Left,
}

/// Refusals since anything else was heard.
#[derive(Debug, Clone, Copy)]
struct Refusal {
    disagreement: Disagreement,
    /// Whether this side found it. What the partner says is not said back to it: both would go on for ever.
    is_own: bool,
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
    /// The partner whose terms fit.
    partner: Option<u64>,
    /// Whether the partner has accepted this session.
    is_accepted: bool,
    /// Why the partner in sight does not fit.
    refused: Option<Refusal>,
    /// A greeting is due at once, because something has changed.
    urgent: bool,
}

impl Greeter {
    pub(super) fn new(session: u64, terms: Terms) -> Self {
        Self { session, terms, partner: None, is_accepted: false, refused: None, urgent: false }
    }

    /// What both sides must agree on.
    pub(super) fn terms(&self) -> &Terms {
        &self.terms
    }

    /// The partner agreed to.
    pub(super) fn partner(&self) -> Option<u64> {
        self.partner
    }

    /// Both sides have accepted each other.
    pub(super) fn is_settled(&self) -> bool {
        self.partner.is_some() && self.is_accepted
    }

    /// Something has changed that the partner must know at once.
    pub(super) fn hurry(&mut self) {
        self.urgent = true;
    }

    pub(super) fn is_urgent(&self) -> bool {
        self.urgent
    }

    /// The partner has sent a packet: it runs, so it has accepted.
    pub(super) fn note_packet(&mut self) {
        self.is_accepted = true;
    }

    /// A greeting of another version came; on what the two sides disagree then, if that is news.
    pub(super) fn note_version(&mut self, now: LocalTime, version: u8) -> Option<Difference> {
        let is_news = self.refuse(now, Disagreement::Version, true);
        is_news.then(|| Difference::of_version(version))
    }

    /// True if the disagreement is news.
    fn refuse(&mut self, now: LocalTime, disagreement: Disagreement, is_own: bool) -> bool {
        let before = self.refused;
        let (since, count) = before.map_or((now, 0), |refusal| (refusal.since, refusal.count));
        self.refused = Some(Refusal { disagreement, is_own, since, count: count.saturating_add(1) });
        before.is_none_or(|refusal| refusal.disagreement != disagreement)
    }

    /// The disagreement, if nothing but refusals, and enough of them, have been heard for this long.
    pub(super) fn refused_for(&self, now: LocalTime, patience: Span) -> Option<Disagreement> {
        let refusal = self.refused.filter(|refusal| refusal.count >= ENOUGH);
        refusal.filter(|refusal| now - refusal.since >= patience).map(|refusal| refusal.disagreement)
    }

    /// Takes a greeting. `is_idle`: no force acts because of the partner, so it may be another one from now on.
    pub(super) fn hear(&mut self, now: LocalTime, greeting: &Greeting, is_idle: bool) -> Heard {
        if greeting.session == self.session {
            return Heard::Refusable;
        }
        let is_known = self.partner == Some(greeting.session);
        if greeting.purpose == Purpose::Goodbye {
            let is_ours = is_known && greeting.accepted == self.session;
            return if is_ours { Heard::Left } else { Heard::Refusable };
        }
        let own = self.terms.difference(&greeting.terms);
        let said = greeting.refusal.map(Difference::said_there);
        if let Some(difference) = own.or(said) {
            if !is_idle {
                return Heard::Refusable;
            }
            if is_known {
                (self.partner, self.is_accepted) = (None, false);
            }
            return if self.refuse(now, difference.on, own.is_some()) {
                Heard::Disagreed(difference)
            } else {
                Heard::Nothing
            };
        }
        if !is_known && !is_idle {
            return Heard::Refusable;
        }
        self.refused = None;
        self.is_accepted = greeting.accepted == self.session || (is_known && self.is_accepted);
        if is_known {
            return Heard::Partner;
        }
        self.partner = Some(greeting.session);
        self.urgent = true;
        Heard::Agreed(greeting.session)
    }

    /// The partner is gone before anything has begun: another one may come.
    pub(super) fn forget(&mut self) {
        (self.partner, self.is_accepted) = (None, false);
    }

    /// The greeting to send now.
    pub(super) fn greeting(&mut self, purpose: Purpose, stance: Stance, stamps: Stamps) -> Greeting {
        self.urgent = false;
        let accepted = self.partner.unwrap_or(0);
        let refusal = self.refused.filter(|refusal| refusal.is_own).map(|refusal| refusal.disagreement);
        Greeting { refusal, stance, stamps, ..Greeting::new(purpose, self.session, accepted, self.terms) }
    }
}
