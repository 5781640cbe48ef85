//! What a site is made of.

use telespring::InvalidInput;
use telespring::session::{EndpointSettings, Span, WatchdogSettings};
use telespring::study::Study;

use crate::hello::Terms;

/// What keeps the person safe whatever the network does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Safety {
    /// The largest force, N: a larger one is cut along its direction.
    pub force: f64,
    /// The force is zero this long after the partner's last packet.
    pub silence: Span,
    /// How long the force stays while the own device, or the loop itself, stands still; then it ramps out. A device holds
    /// its last force meanwhile, so the energy account stays exact.
    pub stall: Span,
    /// From full to zero force when a session leaves.
    pub ramp_out: Span,
}

impl Default for Safety {
    /// 20 N; zero 150 ms after the last packet; on for 20 ms of a standstill; out within 100 ms.
    fn default() -> Self {
        let milliseconds = |number: i64| Span(number * 1_000_000);
        Self { force: 20.0, silence: milliseconds(150), stall: milliseconds(20), ramp_out: milliseconds(100) }
    }
}

impl Safety {
    /// Checks the values.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] with the field.
    pub fn check(&self) -> Result<(), InvalidInput> {
        let Self { force, silence, stall, ramp_out } = *self;
        if !(force > 0.0 && force <= 1000.0) {
            let remedy = "Give the largest force that the person and the robot bear.";
            return Err(InvalidInput::new("safety.force", force, "a force above 0 N, up to 1000 N", remedy));
        }
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

/// What a site is made of.
#[derive(Debug, Clone)]
pub struct SiteSettings {
    /// What the partner must agree to.
    pub terms: Terms,
    /// The endpoint.
    pub endpoint: EndpointSettings,
    /// The limits.
    pub safety: Safety,
}

impl SiteSettings {
    /// The site that moves robot `side`, 1 or 2, of a study: watched, with the clock of the partner estimated.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if the study or a value does not do for a live session.
    pub fn new(study: &Study, side: u8, session: u64, safety: Safety) -> Result<Self, InvalidInput> {
        let terms = Terms::new(study, side)?;
        let watchdog = safety.watchdog(Span::from_seconds(terms.sample_period))?;
        Ok(Self { endpoint: study.live_side(side, session, watchdog)?, terms, safety })
    }
}
