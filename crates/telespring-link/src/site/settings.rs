//! What a site is made of.

use telespring::InvalidInput;
use telespring::rig::ConnectedMode;
use telespring::session::{ClockSettings, EndpointSettings, SideFacts, Span, WatchdogSettings};
use telespring::study::{Coupling, Study};

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

    /// The watchdog that lets the force be zero `silence` after the last packet, counted to the tick that is due by then:
    /// 2 parts of silence, 5 of holding on, 8 of ramp.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if the time is too short for this sample period.
    pub fn watchdog(&self, sample_period: Span) -> Result<WatchdogSettings, InvalidInput> {
        let whole = self.silence - sample_period - sample_period;
        let silence = whole.scaled(2.0 / 15.0);
        if silence < sample_period + sample_period {
            return Err(InvalidInput::new(
                "safety.silence",
                format!("{} s", self.silence.seconds()),
                format!("at least 17 sample periods of {} s", sample_period.seconds()),
                "Lengthen it, or shorten the sample period.",
            ));
        }
        let (hold, usual) = (whole.scaled(5.0 / 15.0), WatchdogSettings::for_period(sample_period));
        Ok(WatchdogSettings {
            silence,
            hold,
            ramp_out: whole - silence - hold,
            own_silence: self.stall - usual.own_hold,
            ..usual
        })
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
        if !matches!(side, 1 | 2) {
            return Err(InvalidInput::new(
                "side",
                side,
                "1 or 2",
                "Give the robot of the study that this site moves.",
            ));
        }
        let laboratory = study.laboratory_without_traces()?;
        let Coupling { stiffness, damping } = study.coupling()?;
        let coupling = ConnectedMode { stiffness, damping, delay: study.network()?.delay() };
        let facts = SideFacts { session, ..laboratory.side_facts(usize::from(side) - 1, &coupling) };
        let sample_period = Span::from_seconds(facts.sample_period);
        let endpoint = EndpointSettings {
            clock: ClockSettings::estimated(),
            watchdog: Some(safety.watchdog(sample_period)?),
            ..laboratory.session.architecture.endpoint_settings(&facts)?
        };
        Ok(Self { terms: Terms::new(study, side)?, endpoint, safety })
    }
}
