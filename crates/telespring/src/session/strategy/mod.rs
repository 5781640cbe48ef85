//! Strategies: how one side turns the partner's motion into a force.
//!
//! Every strategy computes the force on the own handle from the own motion and what is known of the partner. The
//! endpoint calls [`Strategy::settle`] once per measurement, with what happened since the previous one, and then
//! [`Strategy::force`]. What the partner must know of it travels in every packet ([`Outgoing`]).
//!
//! `docs/strategies.md` says what each promises and when to use which.
//!
//! No strategy allocates, reads a clock or fails: whatever comes in, it returns a finite force.

mod guard;
mod injected_damping;
mod set_position_modulation;
mod spring;
mod tally;
mod time_domain_passivity;
mod two_layer;
mod wave_variables;

pub use guard::Guard;
pub use injected_damping::{InjectedDamping, InjectedDampingSettings};
pub use set_position_modulation::{SetPositionModulation, SetPositionSettings};
pub use spring::Spring;
pub use time_domain_passivity::TimeDomainPassivity;
pub use two_layer::{TankSettings, TwoLayer};
pub use wave_variables::{WaveSettings, WaveVariables};

use super::motion::Motion;

/// What a strategy knows of the partner at one tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PartnerView {
    /// The motion that the partner should have for this side: as played, then predicted.
    pub wanted: Motion,
    /// The motion as played, without prediction.
    pub played: Motion,
    /// The time from the measurement of the played motion to now, s.
    pub age: f64,
    /// Whether a motion newer than at the previous tick is in use.
    pub fresh: bool,
    /// The strategy's own quantity per axis, sent with the played motion; see [`Outgoing::signal`].
    pub signal: [f64; 2],
    /// The energy that the partner has sent to this side so far, J: the largest total of all packets.
    pub energy_sent: f64,
    /// The stiffness that the partner uses, N/m.
    pub stiffness: f64,
}

/// One tick of a strategy: all that happened since the previous measurement, and what is known now.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tick {
    /// The time since the previous measurement, s; 0 at the first one.
    pub elapsed: f64,
    /// The own motion now.
    pub own: Motion,
    /// The own motion at the previous measurement; that of now at the first one.
    pub previous: Motion,
    /// The force that acted on the own handle since the previous measurement, N.
    pub acted: [f64; 2],
    /// The partner, as known now; `None` before anything has come or while the coupling is disengaged.
    pub partner: Option<PartnerView>,
    /// The watchdog's factor on the force, 0 (disengaged) to 1 (engaged).
    pub enabled: f64,
}

impl Tick {
    /// How far the own handle moved since the previous measurement, m.
    pub fn displacement(&self) -> [f64; 2] {
        [0, 1].map(|axis| self.own.position[axis] - self.previous.position[axis])
    }
}

/// What the partner must know of a strategy, in every packet.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Outgoing {
    /// The energy sent to the partner so far, J; it never falls.
    pub energy_sent: f64,
    /// A quantity of the strategy per axis, for instance a wave variable; 0 where it needs none.
    pub signal: [f64; 2],
    /// The stiffness in use, N/m.
    pub stiffness: f64,
    /// Whether the strategy changed the force of the spring at the last tick.
    pub limited: bool,
}

/// The running account of a strategy.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StrategyReport {
    /// Ticks with a partner.
    pub ticks: u64,
    /// Of these, ticks at which the strategy changed the force of the spring; with wave variables, the arriving wave.
    pub limited_ticks: u64,
    /// The mean share of that force that was withheld at the limited ticks, 0 to 1 (above 1 if the strategy pushed the
    /// other way, below 0 if a damper made the force larger).
    pub withheld: f64,
    /// The energy given out to the own handle since the start, J: the sum of force times displacement.
    pub given_out: f64,
    /// The energy in the account now, J; `None` if the strategy keeps none.
    pub balance: Option<f64>,
    /// The energy sent to the partner since the start, J.
    pub energy_sent: f64,
    /// The energy taken in from the partner since the start, J.
    pub energy_received: f64,
}

/// How one side turns the partner's motion into a force.
pub trait Strategy {
    /// Takes account of the time since the previous measurement: called once per measurement, before
    /// [`Strategy::force`]. `tick.partner` is what was known at the previous tick.
    fn settle(&mut self, tick: &Tick);

    /// The force on the own handle from now until the next call, N per axis.
    fn force(&mut self, tick: &Tick) -> [f64; 2];

    /// What the next packet tells the partner.
    fn outgoing(&self) -> Outgoing;

    /// The running account.
    fn report(&self) -> StrategyReport;
}

/// The strategy of a session.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum StrategyChoice {
    /// The bare spring of the paper.
    Spring(Spring),
    /// The spring behind an energy account.
    Guard(Guard),
    /// The spring beside a damper sized by the delays (Nuño, Basañez and Ortega 2011).
    InjectedDamping(InjectedDamping),
    /// A virtual transmission line (Niemeyer and Slotine 1991).
    WaveVariables(WaveVariables),
    /// A passivity observer and controller (Ryu, Artigas and Preusche 2010).
    TimeDomainPassivity(TimeDomainPassivity),
    /// The coupling law above a tank of energy (Franken et al. 2011).
    TwoLayer(TwoLayer),
    /// A set position that jumps only as far as a reservoir pays (Lee and Huang 2010).
    SetPositionModulation(SetPositionModulation),
}

impl StrategyChoice {
    fn chosen(&self) -> &dyn Strategy {
        match self {
            Self::Spring(strategy) => strategy,
            Self::Guard(strategy) => strategy,
            Self::InjectedDamping(strategy) => strategy,
            Self::WaveVariables(strategy) => strategy,
            Self::TimeDomainPassivity(strategy) => strategy,
            Self::TwoLayer(strategy) => strategy,
            Self::SetPositionModulation(strategy) => strategy,
        }
    }

    fn chosen_mut(&mut self) -> &mut dyn Strategy {
        match self {
            Self::Spring(strategy) => strategy,
            Self::Guard(strategy) => strategy,
            Self::InjectedDamping(strategy) => strategy,
            Self::WaveVariables(strategy) => strategy,
            Self::TimeDomainPassivity(strategy) => strategy,
            Self::TwoLayer(strategy) => strategy,
            Self::SetPositionModulation(strategy) => strategy,
        }
    }
}

impl Strategy for StrategyChoice {
    fn settle(&mut self, tick: &Tick) {
        self.chosen_mut().settle(tick);
    }

    fn force(&mut self, tick: &Tick) -> [f64; 2] {
        self.chosen_mut().force(tick)
    }

    fn outgoing(&self) -> Outgoing {
        self.chosen().outgoing()
    }

    fn report(&self) -> StrategyReport {
        self.chosen().report()
    }
}
