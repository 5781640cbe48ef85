//! Damping injection: the bare spring beside a damper that is just strong enough for the delays.

#![cfg_attr(not(test), deny(clippy::indexing_slicing))]

use super::tally::Tally;
use super::{Outgoing, Strategy, StrategyReport, Tick};
use crate::error::Result;
use crate::quantity;
use crate::session::Law;
use crate::session::pair::{is_finite, zip};

/// What the damping is sized by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InjectedDampingSettings {
    /// The least damping of the own robot per axis, N·s/m.
    pub own_damping: [f64; 2],
    /// The least damping of the partner's robot per axis, N·s/m.
    pub partner_damping: [f64; 2],
    /// The largest age of a partner sample in use, summed over both directions: T₁ + T₂, s. It contains delay, jitter,
    /// gaps and the sample period.
    pub round_trip: f64,
    /// The largest age of the own sample in use, s: one sample period, with a computing tick two.
    pub own_age: f64,
}

impl InjectedDampingSettings {
    /// The damping to add to both robots, per axis, N·s/m: the least at which k < 2√((B₁ − k h)(B₂ − k h))/(T₁ + T₂) is met
    /// with equality, and 0 where it is met without.
    fn damping(&self, stiffness: f64) -> [f64; 2] {
        zip(self.own_damping, self.partner_damping, |own, partner| {
            // (b₁ + d − k h)(b₂ + d − k h) = (k T/2)²
            let root = (0.5 * (own - partner)).hypot(0.5 * stiffness * self.round_trip);
            (root - 0.5 * (own + partner) + stiffness * self.own_age).max(0.0)
        })
    }
}

/// The bare spring and a damper −d·v on the own handle (P+d control; Nuño, Basañez and Ortega, "Passivity-based control
/// for bilateral teleoperation: a tutorial", Automatica 47, 2011, sec. 3).
///
/// Both sides add the same damping d. It is the least for which k ≤ 2√(B₁B₂)/(T₁ + T₂), where Bᵢ is the damping of robot i
/// with d, less k times the age of the own sample. Below this bound the velocities die out for every passive hand and any
/// delays, varying or not, up to the stated ones. The rule assumes a damper that acts at once: d times the sample period
/// must be well below the handle's mass.
///
/// # Examples
///
/// ```
/// use telespring::session::strategy::{InjectedDamping, InjectedDampingSettings};
///
/// let (own_damping, partner_damping) = ([4.0, 12.0], [4.0, 12.0]);
/// let settings =
///     InjectedDampingSettings { own_damping, partner_damping, round_trip: 0.2, own_age: 0.0 };
/// // 100 N/m · 0.2 s / 2 = 10 N·s/m
/// assert_eq!(InjectedDamping::new(100.0, settings)?.damping(), [6.0, 0.0]);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct InjectedDamping {
    law: Law,
    damping: [f64; 2],
    tally: Tally,
}

impl InjectedDamping {
    /// A spring of this stiffness (N/m) and the damping that the rule asks for.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`](crate::InvalidInput) for the first value out of range.
    pub fn new(stiffness: f64, settings: InjectedDampingSettings) -> Result<Self> {
        quantity::STIFFNESS.check("stiffness", stiffness)?;
        let (own, partner) = (settings.own_damping, settings.partner_damping);
        for (field, [x, y]) in [("own_damping", own), ("partner_damping", partner)] {
            quantity::DAMPING.check(&format!("{field}[0]"), x)?;
            quantity::DAMPING.check(&format!("{field}[1]"), y)?;
        }
        quantity::SPAN.check("round_trip", settings.round_trip)?;
        quantity::SPAN.check("own_age", settings.own_age)?;
        let law = Law { stiffness, damping: 0.0 };
        Ok(Self { law, damping: settings.damping(stiffness), tally: Tally::default() })
    }

    /// The injected damping per axis, N·s/m.
    pub fn damping(&self) -> [f64; 2] {
        self.damping
    }
}

impl Strategy for InjectedDamping {
    fn settle(&mut self, tick: &Tick) {
        self.tally.settle(tick);
    }

    fn force(&mut self, tick: &Tick) -> [f64; 2] {
        let Some(partner) = &tick.partner else {
            self.tally.pause();
            return [0.0; 2];
        };
        let spring = self.law.force(&tick.own, &partner.wanted);
        let damper = zip(self.damping, tick.own.velocity, |damping, velocity| -damping * velocity);
        let wanted = spring.map(|force| force * tick.enabled);
        let force = zip(spring, damper, |spring, damper| (spring + damper) * tick.enabled);
        let (wanted, force) = if is_finite(force) { (wanted, force) } else { ([0.0; 2], [0.0; 2]) };
        self.tally.count(wanted, force);
        force
    }

    fn outgoing(&self) -> Outgoing {
        let limited = self.tally.is_limited();
        Outgoing { stiffness: self.law.stiffness, limited, ..Outgoing::default() }
    }

    fn report(&self) -> StrategyReport {
        self.tally.report()
    }
}
