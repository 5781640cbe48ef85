//! What a site is made of.

use telespring::InvalidInput;
use telespring::session::architecture::PlayoutDesign;
use telespring::session::{EndpointSettings, Span, WatchdogSettings};
use telespring::study::Study;

use super::{Fallback, Limits};
use crate::hello::Terms;

/// What keeps the person safe whatever the network does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Safety {
    /// The force is zero this long after the partner's last packet.
    pub silence: Span,
    /// How long the force stays while the own device, or the loop itself, stands still; then it ramps out. Whether the device
    /// holds its last force meanwhile nobody knows, so the energy account takes the worst.
    pub stall: Span,
    /// From full to zero force when a coupling ends.
    pub ramp_out: Span,
}

impl Default for Safety {
    /// Zero 150 ms after the last packet; on for 20 ms of a standstill; out within 100 ms.
    fn default() -> Self {
        let milliseconds = |number: i64| Span(number * 1_000_000);
        Self { silence: milliseconds(150), stall: milliseconds(20), ramp_out: milliseconds(100) }
    }
}

impl Safety {
    /// Checks the values.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] with the field.
    pub fn check(&self) -> Result<(), InvalidInput> {
        let Self { silence, stall, ramp_out } = *self;
        for (field, span, usual) in
            [("silence", silence, "0.15"), ("stall", stall, "0.02"), ("ramp_out", ramp_out, "0.1")]
        {
            if !(Span(5_000_000)..=Span(10_000_000_000)).contains(&span) {
                let (field, value) = (format!("safety.{field}"), format!("{} s", span.seconds()));
                return Err(InvalidInput::new(field, value, "0.005 to 10 s", format!("Give {usual}.")));
            }
        }
        Ok(())
    }

    /// The watchdog that keeps these limits.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if the time is too short for this sample period.
    pub fn watchdog(&self, sample_period: Span) -> Result<WatchdogSettings, InvalidInput> {
        let within = WatchdogSettings::within(self.silence, self.stall, sample_period);
        within.map_err(|refusal| refusal.within("safety"))
    }
}

/// Who says that the person at a site agrees to be coupled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Consent {
    /// Somebody there, by an order.
    Ordered,
    /// Nobody: a simulated person agrees as soon as the handles are aligned.
    Automatic,
}

/// When two sites may be coupled, and when not any more.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rules {
    /// Who consents.
    pub consent: Consent,
    /// The largest distance between the handles at which a coupling begins, m.
    pub alignment: f64,
    /// The largest speed of the own handle at which a coupling begins, m/s.
    pub rest: f64,
    /// What happens under a bad network.
    pub fallback: Fallback,
    /// The delay that the study imposes on the partner's motion, s: an experiment's condition, which a slower network is not
    /// allowed to break.
    pub imposed_delay: Option<f64>,
}

impl Default for Rules {
    /// A person consents; 2 cm, 5 cm/s; no delay imposed.
    fn default() -> Self {
        let (consent, fallback) = (Consent::Ordered, Fallback::default());
        Self { consent, alignment: 0.02, rest: 0.05, fallback, imposed_delay: None }
    }
}

impl Rules {
    /// The usual rules of a study. A fixed play-out with a delay of its own imposes it. A motion is too old beyond
    /// twice the age that the study states of the network, or imposes, and 50 ms.
    fn of_study(study: &Study) -> Result<Self, InvalidInput> {
        let imposed_delay = match study.session().playout {
            PlayoutDesign::Fixed { delay } => delay,
            PlayoutDesign::Adaptive(_) => None,
        };
        let delay = study.network()?.delay();
        let [here, there] = study.laboratory_without_traces()?.session.lateness;
        let stated = (delay.forward() + here).max(delay.backward() + there).max(imposed_delay.unwrap_or(0.0));
        let age = (2.0 * stated + 0.05).min(60.0);
        let usual = Self::default();
        // a fixed play-out that waits for nothing more than the network's delay holds a motion at every second tick
        let waits = imposed_delay.is_some() || matches!(study.session().playout, PlayoutDesign::Adaptive(_));
        let held = if waits { usual.fallback.held } else { 1.0 };
        Ok(Self { imposed_delay, fallback: Fallback { age, held, ..usual.fallback }, ..usual })
    }

    /// Checks the values.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] with the field.
    pub fn check(&self) -> Result<(), InvalidInput> {
        let Self { alignment, rest, fallback, .. } = *self;
        if !(alignment > 0.0 && alignment <= 10.0) {
            let remedy = "Give the offset across which a person may be coupled, for instance 0.02.";
            return Err(InvalidInput::new("session.alignment", alignment, "above 0, up to 10 m", remedy));
        }
        if !(rest > 0.0 && rest <= 10.0) {
            let remedy = "Give the speed below which a handle rests, for instance 0.05.";
            return Err(InvalidInput::new("session.rest", rest, "above 0, up to 10 m/s", remedy));
        }
        fallback.check()
    }
}

/// What a site is made of.
#[derive(Debug, Clone)]
pub struct SiteSettings {
    /// What the partner must agree to.
    pub terms: Terms,
    /// The endpoint.
    pub endpoint: EndpointSettings,
    /// What keeps the person safe whatever the network does.
    pub safety: Safety,
    /// The limits of robot and person.
    pub limits: Limits,
    /// When the two sites may be coupled.
    pub rules: Rules,
}

impl SiteSettings {
    /// The site that moves robot `side`, 1 or 2, of a study: watched, with the clock of the partner estimated, the usual
    /// limits, and a person who consents by an order.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if the study or a value does not do for a live session.
    pub fn new(study: &Study, side: u8, session: u64, safety: Safety) -> Result<Self, InvalidInput> {
        let terms = Terms::new(study, side)?;
        let watchdog = safety.watchdog(Span::from_seconds(terms.sample_period))?;
        let endpoint = study.live_side(side, session, watchdog)?;
        let (limits, rules) = (Limits::default(), Rules::of_study(study)?);
        Ok(Self { terms, endpoint, safety, limits, rules })
    }

    /// As these, with a simulated person, who consents without an order.
    #[must_use]
    pub fn simulated(self) -> Self {
        Self { rules: Rules { consent: Consent::Automatic, ..self.rules }, ..self }
    }
}
