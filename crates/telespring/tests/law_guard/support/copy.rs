//! A copy of the guard, written apart from it, with one term of its account left out.

use telespring::session::strategy::{Outgoing, Strategy, StrategyReport, Tick};
use telespring::session::{AccountSettings, Law};

/// The term of the account that is missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Missing {
    Nothing,
    /// Nothing is debited for the energy given out.
    GivenOut,
    /// The commanded force is debited, not the one that acted.
    ActedForce,
    /// The whole loss is credited.
    Share,
    /// Twice the lower end of the damping is taken for certain.
    LowerEnd,
    /// Nothing is debited for what the encoder hides of the energy given out.
    HiddenByEncoder,
    /// The loss is computed from the displacement as measured.
    EncoderInLoss,
    /// What the partner claims is added at every tick.
    RunningTotal,
    /// Everything claimed is taken in at once.
    IntakePower,
    /// What is sent is not debited.
    Sent,
    /// An overdraft is forgiven.
    Deficit,
    /// The spring is not limited.
    Limit,
    /// With a computing tick, the force still to act is not thought of when the next is paid.
    Pending,
    /// With a computing tick, energy leaves that the force still to act may need.
    Committed,
}

pub struct GuardCopy {
    missing: Missing,
    law: Law,
    settings: AccountSettings,
    balance: f64,
    given: f64,
    sent: f64,
    received: f64,
    claimed: f64,
    waiting: f64,
    before: [f64; 2],
    /// The last two forces commanded, the newer one last.
    commanded: [[f64; 2]; 2],
    windows: [(f64, f64); 2],
}

impl GuardCopy {
    pub fn new(missing: Missing, law: Law, settings: AccountSettings) -> Self {
        Self {
            missing,
            law,
            settings,
            balance: settings.capacity,
            given: 0.0,
            sent: 0.0,
            received: 0.0,
            claimed: 0.0,
            waiting: 0.0,
            before: [0.0; 2],
            commanded: [[0.0; 2]; 2],
            windows: [(0.0, 0.0); 2],
        }
    }
}

impl Strategy for GuardCopy {
    fn settle(&mut self, tick: &Tick) {
        let Self { missing, settings, .. } = *self;
        let acted = match (missing, settings.computing_tick) {
            (Missing::ActedForce, false) => self.commanded[1],
            (Missing::ActedForce, true) => self.commanded[0],
            _ => tick.acted,
        };
        let moved = tick.displacement();
        let mut change = 0.0;
        for axis in 0..2 {
            if missing != Missing::GivenOut {
                change -= acted[axis] * moved[axis];
            }
            self.given += acted[axis] * moved[axis];
            if missing != Missing::HiddenByEncoder {
                let rise = acted[axis].abs() - self.before[axis].abs();
                change -= 0.5 * settings.encoder_step * ((acted[axis] - self.before[axis]).abs() + rise);
            }
            let (time, distance) = &mut self.windows[axis];
            (*time, *distance) = (*time + tick.elapsed, *distance + moved[axis]);
            if settings.encoder_step == 0.0 || distance.abs() >= 16.0 * settings.encoder_step || *time >= 0.05
            {
                let less = if missing == Missing::EncoderInLoss { 0.0 } else { settings.encoder_step };
                let share = if missing == Missing::Share { 1.0 } else { settings.share };
                let factor = if missing == Missing::LowerEnd { 2.0 } else { 1.0 };
                let certain = (distance.abs() - less).max(0.0);
                if *time > 0.0 {
                    change += share * factor * settings.damping[axis] * certain.powi(2) / *time;
                }
                (*time, *distance) = (0.0, 0.0);
            }
        }
        self.before = acted;
        let claim = tick.partner.map_or(0.0, |partner| partner.energy_sent);
        if claim.is_finite() {
            if missing == Missing::RunningTotal {
                self.waiting += claim.max(0.0);
            } else {
                self.waiting += (claim - self.claimed).max(0.0);
            }
            self.claimed = self.claimed.max(claim);
        }
        let mut taken = self.waiting;
        if missing != Missing::IntakePower {
            taken = taken.min(settings.intake * tick.elapsed);
        }
        self.received += taken;
        self.waiting = (self.waiting - taken).min(5.0 * settings.intake);
        self.balance += change + taken;
        if missing == Missing::Deficit {
            self.balance = self.balance.max(0.0);
        }
    }

    fn force(&mut self, tick: &Tick) -> [f64; 2] {
        let mut wanted = [0.0; 2];
        let mut kept = 0.0_f64;
        if let Some(partner) = tick.partner {
            wanted = self.law.force(&tick.own, &partner.wanted).map(|force| force * tick.enabled);
            for axis in 0..2 {
                let offset = partner.wanted.position[axis] - tick.own.position[axis];
                kept += 0.5 * self.law.stiffness * offset.powi(2);
            }
        }
        let size = wanted[0].hypot(wanted[1]);
        let most = (2.0 * self.law.stiffness * self.balance.max(0.0)).sqrt();
        let mut allowed = most;
        if self.settings.computing_tick && self.missing != Missing::Pending {
            allowed = allowed.min(2.0 * most - self.commanded[1][0].hypot(self.commanded[1][1])).max(0.0);
        }
        let factor = if size > allowed && self.missing != Missing::Limit { allowed / size } else { 1.0 };
        let force = wanted.map(|force| force * factor);
        let excess =
            self.balance - kept.max(size.powi(2) / (2.0 * self.law.stiffness)) - self.settings.capacity;
        if excess > 0.0 {
            self.sent += excess;
            if self.missing != Missing::Sent {
                self.balance -= excess;
            }
        }
        self.commanded = [self.commanded[1], force];
        force
    }

    fn outgoing(&self) -> Outgoing {
        Outgoing { energy_sent: self.sent, signal: [0.0; 2], stiffness: self.law.stiffness, limited: false }
    }

    fn report(&self) -> StrategyReport {
        StrategyReport {
            given_out: self.given,
            balance: Some(self.balance),
            energy_sent: self.sent,
            energy_received: self.received,
            ..StrategyReport::default()
        }
    }
}
