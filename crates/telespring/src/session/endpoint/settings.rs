//! What an endpoint is made of.

#![cfg_attr(not(test), deny(clippy::indexing_slicing))]

use crate::error::{InvalidInput, Result};
use crate::session::predictor::PredictorChoice;
use crate::session::strategy::{Spring, StrategyChoice};
use crate::session::{ClockSettings, Law, PlayoutSettings, Span, WatchdogSettings};

/// What an endpoint is made of.
#[derive(Debug, Clone)]
pub struct EndpointSettings {
    /// The id of this session: a number drawn anew whenever the program starts, so that the partner notices a restart.
    /// It differs from the partner's.
    pub session: u64,
    /// How the partner's motion becomes a force; it contains the coupling law.
    pub strategy: StrategyChoice,
    /// From the partner's motion as played to now.
    pub predictor: PredictorChoice,
    /// When the partner's motion is played.
    pub playout: PlayoutSettings,
    /// How the two clocks compare.
    pub clock: ClockSettings,
    /// When the coupling may act. Without a watchdog it acts always, on however old a motion: for the virtual
    /// laboratory, never for people.
    pub watchdog: Option<WatchdogSettings>,
    /// The time between two measurements, on both sides.
    pub sample_period: Span,
    /// True if a force acts one measurement after the one that it was computed from.
    pub computing_tick: bool,
}

impl EndpointSettings {
    /// The bare spring with a fixed delay on a shared clock at 1 kHz, watched.
    pub fn new(session: u64, law: Law, delay: Span) -> Self {
        Self {
            session,
            strategy: StrategyChoice::Spring(Spring::new(law)),
            predictor: PredictorChoice::default(),
            playout: PlayoutSettings::Fixed { delay },
            clock: ClockSettings::default(),
            watchdog: Some(WatchdogSettings::default()),
            sample_period: Span(1_000_000),
            computing_tick: false,
        }
    }

    /// Checks the values that concern several parts.
    pub(super) fn check(&self) -> Result<()> {
        let Some(watchdog) = &self.watchdog else { return Ok(()) };
        watchdog.check()?;
        let least = self.sample_period + self.sample_period;
        for (field, span) in [("watchdog.silence", watchdog.silence), ("watchdog.frozen", watchdog.frozen)] {
            if span < least {
                return Err(InvalidInput::new(
                    field,
                    format!("{} s", span.seconds()),
                    format!("at least two sample periods, here {} s", least.seconds()),
                    "Lengthen it, for instance with WatchdogSettings::for_period: one late packet is no fault.",
                ));
            }
        }
        Ok(())
    }
}
