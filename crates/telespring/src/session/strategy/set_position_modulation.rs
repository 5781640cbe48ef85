//! Passive set-position modulation: the set position of the spring jumps only as far as a reservoir pays.

#![cfg_attr(not(test), deny(clippy::indexing_slicing))]

use super::tally::Tally;
use super::{Outgoing, Strategy, StrategyReport, Tick};
use crate::error::Result;
use crate::quantity;
use crate::session::pair::{finite_or, is_finite, size, zip};
use crate::session::{AccountSettings, EnergyAccount, Law};

/// The settings of passive set-position modulation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SetPositionSettings {
    /// The stiffness of the virtual spring, N/m.
    pub stiffness: f64,
    /// The damper on the own handle that fills the reservoir, N·s/m. It also pays for the hold: at least half the stiffness
    /// times the sample period.
    pub damping: f64,
    /// What the reservoir holds at the start and at most, J; what exceeds it goes to the partner.
    pub ceiling: f64,
    /// Whether a force acts only one sample period after the motion it was computed from.
    pub computing_tick: bool,
}

impl SetPositionSettings {
    /// A stiffness (N/m) and a damper (N·s/m), a ceiling of 0.05 J and no computing tick.
    pub fn new(stiffness: f64, damping: f64) -> Self {
        Self { stiffness, damping, ceiling: 0.05, computing_tick: false }
    }
}

/// The intake of the reservoir, W: the source has no limit, and no hand sends as much.
const INTAKE: f64 = 1e3;

/// Passive set-position modulation (Lee and Huang, "Passive-set-position-modulation framework for interactive robotic
/// systems", IEEE Transactions on Robotics 26, 2010).
///
/// The handle is held by a spring and a damper, −B·v − k (x − ȳ). A set position y comes in at any instants; the one in use, ȳ,
/// is the nearest to it whose jump the reservoir can pay: E + D + ΔE − (½k|x − ȳ|² − ½k|x − ȳ⁻|²) ≥ 0, where D is what the damper took
/// and ΔE what the partner sent. E above its ceiling goes to the partner. The source judges whenever a set position comes in, this
/// strategy at every tick, for the newest one.
///
/// Where the source estimates D from positions between the jumps, the energy that the force really gave out, F·Δx, is known
/// here at every tick, so the hold, saturation and ramps are in the account. E is never below 0 if the damper is at least half
/// the stiffness times the sample period (twice that with a computing tick) and the force acts as commanded. Unlike
/// [`Guard`](super::Guard) it takes no credit from the robot's own damping. A partner that states a false total is believed.
///
/// # Examples
///
/// ```
/// use telespring::session::strategy::{PartnerView, SetPositionModulation, SetPositionSettings, Strategy, Tick};
/// use telespring::session::Motion;
///
/// let settings = SetPositionSettings { ceiling: 0.02, ..SetPositionSettings::new(100.0, 5.0) };
/// let mut side = SetPositionModulation::new(settings)?;
/// let at = |x| Motion { position: [x, 0.0], velocity: [0.0; 2] };
/// let partner = PartnerView {
///     wanted: at(0.1), played: at(0.1), age: 0.1, fresh: true, signal: [0.0; 2], energy_sent: 0.0, stiffness: 100.0,
/// };
/// let tick =
///     Tick { elapsed: 0.001, own: at(0.0), previous: at(0.0), acted: [0.0; 2], partner: Some(partner), enabled: 1.0 };
/// assert_eq!(side.force(&tick), [2.0, 0.0]); // a jump of 0.02 m costs ½ · 100 N/m · (0.02 m)² = 0.02 J
/// assert!(side.reservoir().abs() < 1e-12);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
#[derive(Debug, Clone)]
pub struct SetPositionModulation {
    law: Law,
    damping: f64,
    /// The reservoir and the spring together.
    account: EnergyAccount,
    /// The energy of the spring as played, J.
    stored: f64,
    tally: Tally,
}

impl SetPositionModulation {
    /// A spring and a damper with a reservoir.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`](crate::InvalidInput) for the first setting out of range.
    pub fn new(settings: SetPositionSettings) -> Result<Self> {
        let SetPositionSettings { stiffness, damping, ceiling, computing_tick } = settings;
        quantity::STIFFNESS.check("stiffness", stiffness)?;
        quantity::DAMPING.check("damping", damping)?;
        quantity::ENERGY.check("ceiling", ceiling)?;
        let account = EnergyAccount::new(AccountSettings {
            share: 0.0,
            capacity: ceiling,
            intake: INTAKE,
            computing_tick,
            ..AccountSettings::new(stiffness, [0.0; 2])
        })?;
        let law = Law { stiffness, damping: 0.0 };
        Ok(Self { law, damping, account, stored: 0.0, tally: Tally::default() })
    }

    /// The energy in the reservoir, J: what the next jump may cost.
    pub fn reservoir(&self) -> f64 {
        self.account.balance() - self.stored
    }
}

impl Strategy for SetPositionModulation {
    fn settle(&mut self, tick: &Tick) {
        self.tally.settle(tick);
        let claimed = tick.partner.map_or(f64::NAN, |partner| partner.energy_sent);
        // the damper's force is in what acted: what it took comes in here
        self.account.settle(tick.elapsed, tick.displacement(), tick.acted, claimed);
    }

    fn force(&mut self, tick: &Tick) -> [f64; 2] {
        let Some(partner) = &tick.partner else {
            self.tally.pause();
            self.stored = 0.0;
            return self.account.pay([0.0; 2], 0.0);
        };
        let wanted = self.law.force(&tick.own, &partner.wanted).map(|force| force * tick.enabled);
        let spring = self.account.pay(wanted, 0.0);
        let paid = size(spring);
        let balance = self.account.balance().max(0.0);
        self.stored = finite_or(paid * paid / (2.0 * self.law.stiffness), balance);
        let damping = self.damping * tick.enabled;
        let force = zip(spring, tick.own.velocity, |spring, velocity| spring - damping * velocity);
        let force = if is_finite(force) { force } else { [0.0; 2] };
        self.tally.count(wanted, spring);
        force
    }

    fn outgoing(&self) -> Outgoing {
        self.tally.outgoing(self.law.stiffness, self.account.sent())
    }

    fn report(&self) -> StrategyReport {
        StrategyReport {
            balance: Some(self.reservoir()),
            energy_sent: self.account.sent(),
            energy_received: self.account.received(),
            ..self.tally.report()
        }
    }
}
