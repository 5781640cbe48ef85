//! Time-domain passivity: an observer of the energy at the own port, and a damper that acts when it runs out.

#![cfg_attr(not(test), deny(clippy::indexing_slicing))]

use super::tally::{Tally, step};
use super::{Outgoing, Strategy, StrategyReport, Tick};
use crate::error::Result;
use crate::quantity;
use crate::session::Law;
use crate::session::pair::{dot, finite_or, is_finite, size, zip};

/// Time-domain passivity control with delay (Ryu, Artigas and Preusche, "A passive bilateral control scheme for a
/// teleoperator with time-varying communication delay", Mechatronics 20, 2010), in the position–position form.
///
/// The observer divides the energy at the own port, F·Δx over both axes, into what goes in and what comes out. The total
/// that went in travels to the partner, which may give out no more: out here ≤ in there, as far as known here. Loss and
/// repetition do not matter, because the totals never fall. Where the spring would give out more in the next tick, the
/// controller takes the excess from the force along the velocity; a debt that is left is braked back by a damper of at most
/// the given size before anything else acts.
///
/// It predicts the next tick by the velocity of now, so the observer falls below 0 by no more than what one tick gives out
/// beyond the prediction, if the largest damping is at most the handle's mass over the sample period. A partner that states a
/// false total is believed. The loss in the robots' own damping is not used, so even a stable coupling may be limited.
///
/// # Examples
///
/// ```
/// use telespring::session::strategy::{PartnerView, Strategy, Tick, TimeDomainPassivity};
/// use telespring::session::{Law, Motion};
///
/// let law = Law { stiffness: 100.0, damping: 0.0 };
/// let mut side = TimeDomainPassivity::new(law, 100.0)?;
/// let at = |x| Motion { position: [x, 0.0], velocity: [0.2, 0.0] };
/// let partner = |energy_sent| PartnerView {
///     wanted: at(0.05), played: at(0.05), age: 0.1, fresh: true, signal: [0.0; 2], energy_sent, stiffness: 100.0,
/// };
/// let tick = |energy_sent| Tick {
///     elapsed: 0.001, own: at(0.0), previous: at(0.0), acted: [0.0; 2], partner: Some(partner(energy_sent)), enabled: 1.0,
/// };
/// assert_eq!(side.force(&tick(0.0)), [0.0, 0.0]); // nothing has gone in there
/// assert_eq!(side.force(&tick(0.0004)), [2.0, 0.0]); // 2 N · 0.2 m/s · 1 ms
/// assert_eq!(side.force(&tick(0.1)), [5.0, 0.0]); // the whole spring
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct TimeDomainPassivity {
    law: Law,
    largest_damping: f64,
    /// What went in at the partner, as far as known, J.
    received: f64,
    /// What came out here, less what was braked back, J.
    drawn: f64,
    /// What went in here, J.
    sent: f64,
    tally: Tally,
}

impl TimeDomainPassivity {
    /// A coupling law behind a passivity controller whose damper is at most this large, N·s/m.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`](crate::InvalidInput) for the first value out of range.
    pub fn new(law: Law, largest_damping: f64) -> Result<Self> {
        quantity::STIFFNESS.check("stiffness", law.stiffness)?;
        quantity::DAMPING.check("coupling_damping", law.damping)?;
        quantity::DAMPING.check("largest_damping", largest_damping)?;
        Ok(Self { law, largest_damping, received: 0.0, drawn: 0.0, sent: 0.0, tally: Tally::default() })
    }

    /// The passivity observer: what may still come out here, J; below 0 it is a debt.
    pub fn observer(&self) -> f64 {
        self.received - self.drawn
    }

    /// The force that the observer allows instead of `wanted`.
    fn allowed(&self, wanted: [f64; 2], velocity: [f64; 2], time: f64) -> [f64; 2] {
        let (speed, observer) = (size(velocity), self.observer());
        if !(speed > 0.0 && speed.is_finite() && time > 0.0) {
            return if observer < 0.0 { [0.0; 2] } else { wanted };
        }
        let along = velocity.map(|velocity| velocity / speed);
        let (forward, allowed) = (dot(wanted, along), observer / (speed * time));
        if observer < 0.0 {
            let braked = (-forward).max(-allowed).min(self.largest_damping * speed);
            along.map(|along| -braked * along)
        } else if forward > allowed {
            zip(wanted, along, |wanted, along| wanted - (forward - allowed) * along)
        } else {
            wanted
        }
    }
}

impl Strategy for TimeDomainPassivity {
    fn settle(&mut self, tick: &Tick) {
        // what nobody knows counts as if all had come out
        let given_out = self.tally.settle(tick).unwrap_or(self.observer().max(0.0));
        let debt = (-self.observer()).max(0.0);
        let back = (-given_out).clamp(0.0, debt);
        self.drawn = finite_or(self.drawn + given_out.max(0.0) - back, self.drawn);
        self.sent = finite_or(self.sent + (-given_out - back).max(0.0), self.sent);
    }

    fn force(&mut self, tick: &Tick) -> [f64; 2] {
        let Some(partner) = &tick.partner else {
            self.tally.pause();
            return [0.0; 2];
        };
        self.received = self.received.max(finite_or(partner.energy_sent, 0.0));
        let wanted = self.law.force(&tick.own, &partner.wanted).map(|force| force * tick.enabled);
        let force = self.allowed(wanted, tick.own.velocity, step(tick));
        let force = if is_finite(force) { force } else { [0.0; 2] };
        self.tally.count(wanted, force);
        force
    }

    fn outgoing(&self) -> Outgoing {
        self.tally.outgoing(self.law.stiffness, self.sent)
    }

    fn report(&self) -> StrategyReport {
        StrategyReport {
            balance: Some(self.observer()),
            energy_sent: self.sent,
            energy_received: self.received,
            ..self.tally.report()
        }
    }
}
