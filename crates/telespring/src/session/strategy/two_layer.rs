//! The two-layer architecture: any law above, a tank of energy below.

#![cfg_attr(not(test), deny(clippy::indexing_slicing))]

use super::tally::{Tally, step};
use super::{Outgoing, Strategy, StrategyReport, Tick};
use crate::error::{InvalidInput, Result};
use crate::quantity;
use crate::session::Law;
use crate::session::pair::{dot, finite_or, is_finite, size, zip};

/// The settings of the passivity layer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TankSettings {
    /// What the tank holds at the start, and the level below which it is filled, J.
    pub level: f64,
    /// The share of the tank that leaves for the partner per second, 1/s.
    pub transfer_rate: f64,
    /// The damper that fills the tank, N·s/m for each J below the level.
    pub filling: f64,
    /// The largest damper that fills the tank, N·s/m; well below the handle's mass over the sample period.
    pub largest_damping: f64,
    /// A full force needs the energy of a spring of this stiffness, N/m: |F| ≤ √(2 K H).
    pub saturation_stiffness: f64,
}

impl TankSettings {
    /// The usual settings for a coupling stiffness (N/m): a level of 0.05 J; 10 1/s, which is 1 % per ms, leave; a damper of at
    /// most 20 N·s/m, reached with an empty tank; and a saturation at four times the stiffness, because both tanks share the
    /// energy of the spring.
    pub fn new(stiffness: f64) -> Self {
        Self {
            level: 0.05,
            transfer_rate: 10.0,
            filling: 400.0,
            largest_damping: 20.0,
            saturation_stiffness: 4.0 * stiffness,
        }
    }

    fn check(&self) -> Result<()> {
        quantity::ENERGY.check("level", self.level)?;
        quantity::DECAY_RATE.check("transfer_rate", self.transfer_rate)?;
        quantity::DAMPING.check("largest_damping", self.largest_damping)?;
        quantity::STIFFNESS.check("saturation_stiffness", self.saturation_stiffness)?;
        if self.filling >= 0.0 && self.filling.is_finite() {
            return Ok(());
        }
        Err(InvalidInput::new(
            "filling",
            self.filling,
            "the damper per joule below the level must be a finite number from 0",
            "400 N·s/m per J gives 20 N·s/m at an empty tank with a level of 0.05 J.",
        ))
    }
}

/// The two-layer architecture (Franken, Stramigioli, Misra, Secchi and Macchelli, "Bilateral telemanipulation with time
/// delays: a two-layer approach combining passivity and transparency", IEEE Transactions on Robotics 27, 2011).
///
/// The upper layer wants the force of the coupling law. The lower layer has a tank of energy H. Each tick H falls by what was
/// really given out, F·Δx, and rises by the quanta of the partner; a share of it leaves as a quantum for the partner. The
/// wanted force is saturated: none from an empty tank, no more power than empties it in the next tick, and at most √(2 K H).
/// Below its level the tank is filled by a damper on the own handle, which grows with what is missing.
///
/// Quanta travel as a running total, so none is lost or counted twice. Both tanks, the quanta under way and the energy given
/// out at both handles always add up to what the tanks held at the start: the network cannot create energy. H falls below 0 by
/// no more than what one tick gives out beyond the prediction by the velocity of now. A partner that states a false total is
/// believed.
///
/// # Examples
///
/// ```
/// use telespring::session::Law;
/// use telespring::session::strategy::{TankSettings, TwoLayer};
///
/// let law = Law { stiffness: 100.0, damping: 0.0 };
/// let side = TwoLayer::new(law, TankSettings { level: 0.02, ..TankSettings::new(100.0) })?;
/// assert_eq!(side.largest_force(), 4.0); // √(2 · 400 N/m · 0.02 J)
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct TwoLayer {
    law: Law,
    settings: TankSettings,
    tank: f64,
    sent: f64,
    received: f64,
    tally: Tally,
}

impl TwoLayer {
    /// A coupling law above a tank.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] for the first value out of range.
    pub fn new(law: Law, settings: TankSettings) -> Result<Self> {
        quantity::STIFFNESS.check("stiffness", law.stiffness)?;
        quantity::DAMPING.check("coupling_damping", law.damping)?;
        settings.check()?;
        let tank = settings.level;
        Ok(Self { law, settings, tank, sent: 0.0, received: 0.0, tally: Tally::default() })
    }

    /// The energy in the tank, J; below 0 while it is overdrawn.
    pub fn tank(&self) -> f64 {
        self.tank
    }

    /// The largest force of the upper layer that the tank lets pass, √(2 K H), N.
    pub fn largest_force(&self) -> f64 {
        (2.0 * self.settings.saturation_stiffness * self.tank.max(0.0)).sqrt()
    }

    /// The damper that fills the tank, N·s/m.
    pub fn filling_damping(&self) -> f64 {
        let missing = (self.settings.level - self.tank).max(0.0);
        (self.settings.filling * missing).min(self.settings.largest_damping)
    }

    /// The share of the wanted force that the tank lets pass.
    fn share(&self, wanted: [f64; 2], velocity: [f64; 2], time: f64) -> f64 {
        let (force, given_out) = (size(wanted), dot(wanted, velocity) * time);
        let by_level = if force > 0.0 { self.largest_force() / force } else { 1.0 };
        let by_power = if given_out > 0.0 { self.tank.max(0.0) / given_out } else { 1.0 };
        by_level.min(by_power).min(1.0)
    }
}

impl Strategy for TwoLayer {
    fn settle(&mut self, tick: &Tick) {
        match self.tally.settle(tick) {
            Some(given_out) => self.tank = finite_or(self.tank - given_out, self.tank.min(0.0)),
            // what nobody knows counts as if all had come out
            None => self.tank = self.tank.min(0.0),
        }
        let quantum = self.tank.max(0.0) * (self.settings.transfer_rate * step(tick)).min(1.0);
        self.tank -= quantum;
        self.sent = finite_or(self.sent + quantum, self.sent);
    }

    fn force(&mut self, tick: &Tick) -> [f64; 2] {
        let Some(partner) = &tick.partner else {
            self.tally.pause();
            return [0.0; 2];
        };
        let claimed = finite_or(partner.energy_sent, 0.0);
        if claimed > self.received {
            self.tank += claimed - self.received;
            self.received = claimed;
        }
        let wanted = self.law.force(&tick.own, &partner.wanted).map(|force| force * tick.enabled);
        let share = self.share(wanted, tick.own.velocity, step(tick));
        let damping = self.filling_damping() * tick.enabled;
        let force = zip(wanted, tick.own.velocity, |wanted, velocity| share * wanted - damping * velocity);
        let force = if is_finite(force) { force } else { [0.0; 2] };
        self.tally.count(wanted, force);
        force
    }

    fn outgoing(&self) -> Outgoing {
        self.tally.outgoing(self.law.stiffness, self.sent)
    }

    fn report(&self) -> StrategyReport {
        StrategyReport {
            balance: Some(self.tank),
            energy_sent: self.sent,
            energy_received: self.received,
            ..self.tally.report()
        }
    }
}
