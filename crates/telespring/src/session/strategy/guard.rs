//! The guard: a spring that gives out no more energy than its account holds.

use super::tally::Tally;
use super::{Outgoing, Strategy, StrategyReport, Tick};
use crate::error::{InvalidInput, Result};
use crate::session::{AccountSettings, EnergyAccount, Law};

/// The spring of the coupling law behind an energy account: whatever the partner's motion is (played, held, predicted or
/// false), the robot gives out no more energy than the account holds.
///
/// Where the account can pay the wanted force, the guard is the bare spring. `docs/guard.md` has the proof. The idea of a
/// spring that moves its set position only as far as its energy allows is that of passive set-position modulation (Lee
/// and Huang, IEEE Transactions on Robotics 26, 2010).
///
/// # Examples
///
/// ```
/// use telespring::session::strategy::{Guard, PartnerView, Strategy, Tick};
/// use telespring::session::{AccountSettings, Law, Motion};
///
/// let law = Law { stiffness: 100.0, damping: 0.0 };
/// let mut guard = Guard::new(law, AccountSettings { capacity: 0.02, ..AccountSettings::new(100.0, [6.0, 6.0]) })?;
/// let at = |x| Motion { position: [x, 0.0], velocity: [0.0; 2] };
/// let partner = |wanted| PartnerView {
///     wanted, played: wanted, age: 0.1, fresh: true, signal: [0.0; 2], energy_sent: 0.0, stiffness: 100.0,
/// };
/// let tick = |wanted| Tick {
///     elapsed: 0.001, own: at(0.0), previous: at(0.0), acted: [0.0; 2], partner: Some(partner(wanted)), enabled: 1.0,
/// };
/// assert_eq!(guard.force(&tick(at(0.01))), [1.0, 0.0]); // the bare spring
/// assert_eq!(guard.force(&tick(at(900.0))), [2.0, 0.0]); // √(2 k S)
/// assert_eq!(guard.report().limited_ticks, 1);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
#[derive(Debug, Clone)]
pub struct Guard {
    law: Law,
    account: EnergyAccount,
    tally: Tally,
}

impl Guard {
    /// A guard for a coupling law.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] for the first setting out of range, or if the account is for another stiffness than the law's.
    pub fn new(law: Law, settings: AccountSettings) -> Result<Self> {
        if settings.stiffness != law.stiffness {
            return Err(InvalidInput::new(
                "stiffness",
                settings.stiffness,
                format!("the account must be for the law's stiffness, {} N/m", law.stiffness),
                "Give both the same stiffness.",
            ));
        }
        crate::quantity::DAMPING.check("coupling_damping", law.damping)?;
        let account = EnergyAccount::new(settings)?;
        Ok(Self { law, account, tally: Tally::default() })
    }

    /// The energy account.
    pub fn account(&self) -> &EnergyAccount {
        &self.account
    }
}

impl Strategy for Guard {
    fn settle(&mut self, tick: &Tick) {
        let claimed = tick.partner.map_or(f64::NAN, |partner| partner.energy_sent);
        self.account.settle(tick.elapsed, tick.displacement(), tick.acted, claimed);
    }

    fn force(&mut self, tick: &Tick) -> [f64; 2] {
        let Some(partner) = &tick.partner else {
            self.tally.pause();
            return self.account.pay([0.0; 2], 0.0);
        };
        let wanted = self.law.force(&tick.own, &partner.wanted).map(|force| force * tick.enabled);
        // The whole spring, also while it is ramped in.
        let spring = Law { damping: 0.0, ..self.law };
        let [x, y] = spring.force(&tick.own, &partner.wanted);
        let force = self.account.pay(wanted, (x * x + y * y) / (2.0 * self.law.stiffness));
        self.tally.count(wanted, force);
        force
    }

    fn outgoing(&self) -> Outgoing {
        self.tally.outgoing(self.law.stiffness, self.account.sent())
    }

    fn report(&self) -> StrategyReport {
        StrategyReport {
            given_out: self.account.given_out(),
            balance: Some(self.account.balance()),
            energy_sent: self.account.sent(),
            energy_received: self.account.received(),
            ..self.tally.report()
        }
    }
}
