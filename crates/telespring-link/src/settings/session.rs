//! `[session]` and `[fallback]`: when the two sites may be coupled, and when not any more.

use serde::Deserialize;
use telespring::InvalidInput;
use telespring::session::Span;

use crate::site::{Consent, Fallback, Rules};

/// What a site file says of it; the rest is as usual for the study.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SessionText {
    consent: Option<ConsentWord>,
    alignment: Option<f64>,
    rest: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum ConsentWord {
    Order,
    Automatic,
}

/// See [`SessionText`].
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FallbackText {
    loss: Option<f64>,
    held: Option<f64>,
    age: Option<f64>,
    softened: Option<f64>,
    patience: Option<f64>,
    recovery: Option<f64>,
    silence: Option<f64>,
}

/// What a site file says about when the two sites may be coupled.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SessionChoice {
    session: SessionText,
    fallback: FallbackText,
}

impl SessionChoice {
    /// `is_real`: a person may hold the robot, so somebody must consent.
    pub(super) fn new(
        session: SessionText,
        fallback: FallbackText,
        is_real: bool,
    ) -> Result<Self, InvalidInput> {
        if is_real && session.consent == Some(ConsentWord::Automatic) {
            return Err(InvalidInput::new(
                "session.consent",
                "\"automatic\"",
                "whoever holds a robot consents, each time",
                "Write consent = \"order\", and give the order on the console or at the device.",
            ));
        }
        let choice = Self { session, fallback };
        choice.rules(Rules::default(), is_real).check()?;
        Ok(choice)
    }

    /// The usual rules of a study with what the file says. A simulated person consents by itself unless the file says
    /// otherwise.
    pub(super) fn rules(&self, usual: Rules, is_real: bool) -> Rules {
        let SessionText { consent, alignment, rest } = self.session;
        let by_itself = if is_real { ConsentWord::Order } else { ConsentWord::Automatic };
        Rules {
            consent: match consent.unwrap_or(by_itself) {
                ConsentWord::Order => Consent::Ordered,
                ConsentWord::Automatic => Consent::Automatic,
            },
            alignment: alignment.unwrap_or(usual.alignment),
            rest: rest.unwrap_or(usual.rest),
            fallback: self.fallback.over(usual.fallback),
            ..usual
        }
    }
}

impl FallbackText {
    fn over(self, usual: Fallback) -> Fallback {
        let span = |given: Option<f64>, usual: Span| given.map_or(usual, Span::from_seconds);
        Fallback {
            loss: self.loss.unwrap_or(usual.loss),
            held: self.held.unwrap_or(usual.held),
            age: self.age.unwrap_or(usual.age),
            softened: self.softened.unwrap_or(usual.softened),
            patience: span(self.patience, usual.patience),
            recovery: span(self.recovery, usual.recovery),
            silence: span(self.silence, usual.silence),
        }
    }
}
