//! The strategies that an architecture may have, and what of them can be chosen.
//!
//! The usual values are those of the strategies themselves.

use crate::session::AccountSettings;
use crate::session::strategy::{SetPositionSettings, TankSettings, WaveSettings};

/// What can be chosen of the guard; see [`AccountSettings`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GuardDesign {
    /// The share of the loss in the robot's damping that the spring may give out again, from 0 to below 1.
    pub share: f64,
    /// What the account holds at the start, J.
    pub capacity: f64,
    /// The largest power at which energy of the partner is taken in, W.
    pub intake: f64,
}

impl Default for GuardDesign {
    fn default() -> Self {
        let AccountSettings { share, capacity, intake, .. } = AccountSettings::new(1.0, [0.0; 2]);
        Self { share, capacity, intake }
    }
}

/// What can be chosen of wave variables; see [`WaveSettings`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WaveDesign {
    /// The wave impedance, N·s/m.
    pub impedance: f64,
    /// The time constant of the filter on the arriving wave, s.
    pub filter: f64,
}

impl Default for WaveDesign {
    /// 10 N·s/m, near the damping of the paper's robots.
    fn default() -> Self {
        let WaveSettings { impedance, filter, .. } = WaveSettings::new(1.0, 10.0);
        Self { impedance, filter }
    }
}

/// What can be chosen of time-domain passivity control; see
/// [`TimeDomainPassivity`](crate::session::strategy::TimeDomainPassivity).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeDomainPassivityDesign {
    /// The largest damping with which a debt is braked back, N·s/m: at most the handle's mass over the sample period.
    pub largest_damping: f64,
}

impl Default for TimeDomainPassivityDesign {
    /// 100 N·s/m, an eighth of what the paper's lighter axis allows at 1 kHz.
    fn default() -> Self {
        Self { largest_damping: 100.0 }
    }
}

/// What can be chosen of the two-layer architecture; see [`TankSettings`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TwoLayerDesign {
    /// What the tank holds at the start, and the level below which it is filled, J.
    pub level: f64,
    /// The share of the tank that leaves for the partner per second, 1/s.
    pub transfer_rate: f64,
    /// The damper that fills the tank, N·s/m for each J below the level.
    pub filling: f64,
    /// The largest damper that fills the tank, N·s/m.
    pub largest_damping: f64,
    /// A full force needs the energy of a spring this many times as stiff as the coupling.
    pub saturation: f64,
}

impl Default for TwoLayerDesign {
    fn default() -> Self {
        let TankSettings { level, transfer_rate, filling, largest_damping, saturation_stiffness } =
            TankSettings::new(1.0);
        Self { level, transfer_rate, filling, largest_damping, saturation: saturation_stiffness }
    }
}

/// What can be chosen of passive set-position modulation; see [`SetPositionSettings`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SetPositionDesign {
    /// The damper on the own handle that fills the reservoir, N·s/m.
    pub damping: f64,
    /// What the reservoir holds at the start and at most, J.
    pub ceiling: f64,
}

impl Default for SetPositionDesign {
    /// A damper of 5 N·s/m.
    fn default() -> Self {
        let SetPositionSettings { damping, ceiling, .. } = SetPositionSettings::new(1.0, 5.0);
        Self { damping, ceiling }
    }
}

/// How the partner's motion becomes a force.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum StrategyDesign {
    /// The bare spring of the paper.
    #[default]
    Spring,
    /// The spring behind an energy account.
    Guard(GuardDesign),
    /// The spring beside a damper sized by the delays.
    InjectedDamping,
    /// A virtual transmission line.
    WaveVariables(WaveDesign),
    /// A passivity observer and controller.
    TimeDomainPassivity(TimeDomainPassivityDesign),
    /// The coupling law above a tank of energy.
    TwoLayer(TwoLayerDesign),
    /// A set position that jumps only as far as a reservoir pays.
    SetPositionModulation(SetPositionDesign),
}

impl StrategyDesign {
    /// The words for the kinds of strategy.
    pub const KINDS: [&'static str; 7] = [
        "spring",
        "guard",
        "injected-damping",
        "wave-variables",
        "time-domain-passivity",
        "two-layer",
        "set-position-modulation",
    ];

    /// The strategy of this kind with its usual settings; `None` for another word.
    pub fn of_kind(kind: &str) -> Option<Self> {
        Some(match kind {
            "spring" => Self::Spring,
            "guard" => Self::Guard(GuardDesign::default()),
            "injected-damping" => Self::InjectedDamping,
            "wave-variables" => Self::WaveVariables(WaveDesign::default()),
            "time-domain-passivity" => Self::TimeDomainPassivity(TimeDomainPassivityDesign::default()),
            "two-layer" => Self::TwoLayer(TwoLayerDesign::default()),
            "set-position-modulation" => Self::SetPositionModulation(SetPositionDesign::default()),
            _ => return None,
        })
    }

    /// The word for the kind of this strategy.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Spring => "spring",
            Self::Guard(_) => "guard",
            Self::InjectedDamping => "injected-damping",
            Self::WaveVariables(_) => "wave-variables",
            Self::TimeDomainPassivity(_) => "time-domain-passivity",
            Self::TwoLayer(_) => "two-layer",
            Self::SetPositionModulation(_) => "set-position-modulation",
        }
    }

    /// Whether the strategy has a place for a damper between both handles. Damping injection, wave variables and
    /// set-position modulation have dampers of their own instead.
    pub fn has_coupling_damper(&self) -> bool {
        !matches!(self, Self::InjectedDamping | Self::WaveVariables(_) | Self::SetPositionModulation(_))
    }

    /// Whether the strategy keeps an account of energy.
    pub fn has_account(&self) -> bool {
        !matches!(self, Self::Spring | Self::InjectedDamping | Self::WaveVariables(_))
    }
}
