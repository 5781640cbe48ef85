//! From an architecture to the settings of one live side.

#![cfg_attr(not(test), deny(clippy::indexing_slicing))]

use super::{Architecture, GuardDesign, PlayoutDesign, PredictorDesign, StrategyDesign};
use crate::error::{InvalidInput, Result};
use crate::quantity;
use crate::session::playout::Histogram;
use crate::session::predictor::{Hold, Kalman, Linear, PredictorChoice, SharedTarget};
use crate::session::strategy::{
    Guard, InjectedDamping, InjectedDampingSettings, SetPositionModulation, SetPositionSettings, Spring,
    StrategyChoice, TankSettings, TimeDomainPassivity, TwoLayer, WaveSettings, WaveVariables,
};
use crate::session::{AccountSettings, EndpointSettings, Law, PlayoutSettings, Span, WatchdogSettings};

/// What one side knows of both robots and of the network.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SideFacts {
    /// The id of the session; see [`EndpointSettings::session`].
    pub session: u64,
    /// The coupling law.
    pub law: Law,
    /// The one-way delays from the measurement of a motion to its arrival, s: of the partner's motion here, and of the own
    /// motion there.
    pub delays: [f64; 2],
    /// The most by which a motion may be older than these delays, s: jitter and gap.
    pub lateness: [f64; 2],
    /// How much older still a motion may become because packets are lost or wait at a link, s; no play-out waits for it.
    pub missing: [f64; 2],
    /// Whether a fixed play-out without a delay of its own waits for the latest motion.
    pub has_playout_buffer: bool,
    /// The time between two measurements, on both sides, s.
    pub sample_period: f64,
    /// Whether a force acts one measurement after the one that it was computed from.
    pub computing_tick: bool,
    /// The step of the position sensor, m; 0 for none.
    pub encoder_step: f64,
    /// The time constant with which the device's force follows the commanded one, s; 0 for none. Then
    /// [`Endpoint::handle_acted`](crate::session::Endpoint::handle_acted) is told the mean force that acted.
    pub actuator_lag: f64,
    /// The damping that the own robot and the partner's have at least, per axis, N·s/m.
    pub least_damping: [[f64; 2]; 2],
    /// The mass that the own robot has at least, per axis, kg.
    pub least_mass: [f64; 2],
}

impl Architecture {
    /// The settings of one live side: strategy, predictor and play-out of this architecture, watched, on a shared clock.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if a value is out of range, the law has a damper and the strategy no place for it, or the guard's
    /// account bounds nothing with these facts ([`AccountSettings::check_bound`]).
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::session::architecture::{Architecture, SideFacts};
    /// use telespring::session::{Endpoint, Law, PlayoutSettings, Span};
    ///
    /// let facts = SideFacts {
    ///     session: 0x5eed,
    ///     law: Law { stiffness: 71.2, damping: 0.0 },
    ///     delays: [0.084, 0.084],
    ///     lateness: [0.0, 0.0],
    ///     missing: [0.0, 0.0],
    ///     has_playout_buffer: false,
    ///     sample_period: 0.001,
    ///     computing_tick: false,
    ///     encoder_step: 0.0,
    ///     actuator_lag: 0.0,
    ///     least_damping: [[7.7, 10.1]; 2],
    ///     least_mass: [0.83, 1.07],
    /// };
    /// let settings = Architecture::default().endpoint_settings(&facts)?;
    /// assert_eq!(settings.playout, PlayoutSettings::Fixed { delay: Span::from_seconds(0.084) });
    /// let side = Endpoint::new(settings)?;
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn endpoint_settings(&self, facts: &SideFacts) -> Result<EndpointSettings> {
        if let StrategyDesign::Guard(design) = self.strategy {
            let [x, y] = facts.least_mass;
            design.account(facts).check_bound(x.min(y))?;
        }
        let watchdog = Some(WatchdogSettings::for_period(Span::from_seconds(facts.sample_period)));
        Ok(EndpointSettings { watchdog, ..self.rehearsal_settings(facts)? })
    }

    /// As [`Architecture::endpoint_settings`] for a side in the virtual laboratory, which asks what a coupling does: on
    /// however old a motion, without a watchdog, and also where nothing is proven.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if a value is out of range, or the law has a damper and the strategy no place for it.
    pub fn rehearsal_settings(&self, facts: &SideFacts) -> Result<EndpointSettings> {
        let ([delay, _], [lateness, _]) = (facts.delays, facts.lateness);
        let playout = match self.playout {
            PlayoutDesign::Fixed { .. } => {
                PlayoutSettings::Fixed { delay: Span::from_seconds(self.fixed_delay(facts, delay, lateness)) }
            }
            PlayoutDesign::Adaptive(adaptive) => PlayoutSettings::Adaptive(adaptive),
        };
        Ok(EndpointSettings {
            strategy: self.strategy_choice(facts)?,
            predictor: self.predictor.choice()?,
            playout,
            watchdog: None,
            sample_period: Span::from_seconds(facts.sample_period),
            computing_tick: facts.computing_tick,
            ..EndpointSettings::new(facts.session, facts.law, Span(0))
        })
    }

    /// The delay of a fixed play-out over a way with this delay and lateness, s.
    fn fixed_delay(&self, facts: &SideFacts, delay: f64, lateness: f64) -> f64 {
        match self.playout {
            PlayoutDesign::Fixed { delay: Some(delay) } => delay,
            _ if facts.has_playout_buffer => delay + lateness,
            _ => delay,
        }
    }

    /// The largest age of a motion in use over a way, s: with its delay, its lateness and what is missing, if the network
    /// keeps them.
    fn largest_age(&self, facts: &SideFacts, delay: f64, lateness: f64, missing: f64) -> f64 {
        let latest = delay + lateness;
        let played = match self.playout {
            PlayoutDesign::Fixed { .. } => self.fixed_delay(facts, delay, lateness),
            PlayoutDesign::Adaptive(adaptive) => {
                let quantile = Histogram::largest_quantile(Span::from_seconds(latest)).seconds();
                let wanted = quantile + facts.sample_period + adaptive.margin.seconds();
                wanted.min(adaptive.largest.seconds()).max(adaptive.smallest.seconds())
            }
        };
        played.max(latest) + missing + facts.sample_period
    }

    fn strategy_choice(&self, facts: &SideFacts) -> Result<StrategyChoice> {
        let SideFacts { law, computing_tick, .. } = *facts;
        let Law { stiffness, damping } = law;
        if damping != 0.0 && !self.strategy.has_coupling_damper() {
            return Err(InvalidInput::new(
                "coupling_damping",
                damping,
                format!(
                    "the strategy {} has dampers of its own, and none in the coupling",
                    self.strategy.kind()
                ),
                "Set the coupling damping to 0, or choose another strategy.",
            ));
        }
        let [own_damping, partner_damping] = facts.least_damping;
        Ok(match self.strategy {
            StrategyDesign::Spring => StrategyChoice::Spring(Spring::new(law)),
            StrategyDesign::Guard(design) => StrategyChoice::Guard(Guard::new(law, design.account(facts))?),
            StrategyDesign::InjectedDamping => {
                let ([incoming, outgoing], [here, there]) = (facts.delays, facts.lateness);
                let [missing_here, missing_there] = facts.missing;
                let ages = [
                    self.largest_age(facts, incoming, here, missing_here),
                    self.largest_age(facts, outgoing, there, missing_there),
                ];
                let settings = InjectedDampingSettings {
                    own_damping,
                    partner_damping,
                    round_trip: ages.iter().sum(),
                    own_age: facts.sample_period * if computing_tick { 2.0 } else { 1.0 },
                };
                StrategyChoice::InjectedDamping(InjectedDamping::new(stiffness, settings)?)
            }
            StrategyDesign::WaveVariables(design) => {
                let settings = WaveSettings { stiffness, impedance: design.impedance, filter: design.filter };
                StrategyChoice::WaveVariables(WaveVariables::new(settings)?)
            }
            StrategyDesign::TimeDomainPassivity(design) => {
                let strategy = TimeDomainPassivity::new(law, design.largest_damping)?;
                StrategyChoice::TimeDomainPassivity(strategy)
            }
            StrategyDesign::TwoLayer(design) => {
                quantity::STIFFNESS.check("saturation", design.saturation * stiffness)?;
                let settings = TankSettings {
                    level: design.level,
                    transfer_rate: design.transfer_rate,
                    filling: design.filling,
                    largest_damping: design.largest_damping,
                    saturation_stiffness: design.saturation * stiffness,
                };
                StrategyChoice::TwoLayer(TwoLayer::new(law, settings)?)
            }
            StrategyDesign::SetPositionModulation(design) => {
                let settings = SetPositionSettings {
                    stiffness,
                    damping: design.damping,
                    ceiling: design.ceiling,
                    computing_tick,
                };
                StrategyChoice::SetPositionModulation(SetPositionModulation::new(settings)?)
            }
        })
    }
}

impl PredictorDesign {
    /// The predictor of a session.
    fn choice(self) -> Result<PredictorChoice> {
        Ok(match self {
            Self::Hold => PredictorChoice::Hold(Hold),
            Self::Linear => PredictorChoice::Linear(Linear),
            Self::Kalman(design) => PredictorChoice::Kalman(Kalman::new(design.model, design.noise)?),
            Self::SharedTarget => PredictorChoice::SharedTarget(SharedTarget),
        })
    }
}

impl GuardDesign {
    /// The account of a side with these facts.
    fn account(&self, facts: &SideFacts) -> AccountSettings {
        let [damping, _] = facts.least_damping;
        AccountSettings {
            stiffness: facts.law.stiffness,
            damping,
            share: self.share,
            capacity: self.capacity,
            intake: self.intake,
            encoder_step: facts.encoder_step,
            computing_tick: facts.computing_tick,
            sample_period: facts.sample_period,
            actuator_lag: facts.actuator_lag,
        }
    }
}
