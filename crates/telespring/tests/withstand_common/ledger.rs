//! What really happened to the energy of one side, and the laws that it must obey.

use telespring::session::AccountSettings;
use telespring::session::strategy::StrategyReport;

use super::plant::{AxisPlant, Step};

/// The laws of the guard.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Law {
    /// The plant's energy is what it was plus all work less all losses: a check of the test itself.
    Plant,
    /// |F| ≤ √(2 k S).
    Force,
    /// The account holds what it must hold.
    Account,
    /// The account holds what it is computed to hold from what was measured, acted and received.
    Recomputed,
    /// A force that changes within a tick does no more than stated beyond its mean.
    Unseen,
    /// Every force is finite.
    Finite,
    /// The account is overdrawn by no more than stated.
    Overdraft,
    /// No more is taken in than was sent, and no faster than the set power.
    Intake,
    /// The robot's energy exceeds what it had and got by no more than the overdraft.
    Energy,
    /// The robot's energy is at most what was there so far over 1 less the ratio of the overdraft.
    Bounded,
    /// Both sides together give out no more than they got.
    Together,
    /// After the hands let go the losses are bounded.
    DiesOut,
}

#[derive(Debug, Clone)]
#[allow(dead_code, reason = "printed when a test fails")]
pub struct Violation {
    pub law: Law,
    pub time: f64,
    pub value: f64,
    pub bound: f64,
}

/// An error, unless this law is not checked.
pub fn judge(unchecked: &[Law], violation: Violation) -> Result<(), Violation> {
    if unchecked.contains(&violation.law) { Ok(()) } else { Err(violation) }
}

/// What is true of a side.
#[derive(Debug, Clone, Copy)]
pub struct Facts {
    /// The mass and the damping of robot and hand together, kg and N·s/m.
    pub mass: [f64; 2],
    pub damping: [f64; 2],
    pub settings: AccountSettings,
    /// Whether the totals that this side hears are those that its partner sends.
    pub is_honest: bool,
    /// The largest share by which its clock runs wrong.
    pub clock_error: f64,
    /// The laws that are not checked.
    pub unchecked: &'static [Law],
}

pub struct Ledger {
    facts: Facts,
    start: f64,
    start_balance: f64,
    /// What acted on the robot: its own work as the mean forces show it, the most that they do not show, the hand's work,
    /// all losses, and those in the damping that is certain.
    work: f64,
    unseen: f64,
    hand: f64,
    loss: f64,
    certain: f64,
    /// The bound b|Δx|²/Δt of the certain loss.
    bound: f64,
    /// The robot's work, J.
    true_work: f64,
    /// The largest displacement of a tick as measured, m.
    longest: f64,
    scale: f64,
    energy: f64,
    /// The largest energy so far of the robot, and of all that it had, got and did not lose, J.
    largest: f64,
    available: f64,
}

impl Ledger {
    /// A side whose account holds this balance, J.
    pub fn new(facts: Facts, plants: &[AxisPlant; 2], balance: f64) -> Self {
        let energy = plants.iter().map(AxisPlant::energy).sum();
        Self {
            facts,
            start: energy,
            start_balance: balance,
            work: 0.0,
            unseen: 0.0,
            hand: 0.0,
            loss: 0.0,
            certain: 0.0,
            bound: 0.0,
            true_work: 0.0,
            longest: 0.0,
            scale: 1.0,
            energy,
            largest: energy,
            available: 0.0,
        }
    }

    /// One axis moved over one period, which took `elapsed` s on the side's own clock.
    pub fn add(&mut self, axis: usize, step: &Step, hand: f64, elapsed: f64) {
        let Step { moved, squares, mean, work, unseen } = *step;
        self.work += mean * moved;
        self.true_work += work;
        self.unseen += unseen;
        self.hand += hand * moved;
        self.loss += self.facts.damping[axis] * squares;
        self.certain += self.facts.settings.damping[axis] * squares;
        self.bound += self.facts.settings.damping[axis] * moved * moved / elapsed;
        self.scale += (mean * moved).abs() + (hand * moved).abs();
    }

    /// All energy moved, J.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// The most that the account can be overdrawn by, J.
    fn overdraft(&self) -> f64 {
        let settings = &self.facts.settings;
        let longest = self.longest + 2.0_f64.sqrt() * settings.encoder_step;
        0.5 * settings.stiffness * (longest * self.periods()).powi(2)
    }

    /// For how many sample periods a force acts.
    fn periods(&self) -> f64 {
        let settings = &self.facts.settings;
        let tick = if settings.computing_tick { 1.0 } else { 0.0 };
        1.0 + tick + settings.actuator_lag / settings.sample_period
    }

    /// The most by which the account can be overdrawn where the robot has at most this energy, J.
    fn overdraft_at(&self, energy: f64) -> f64 {
        let Facts { settings, mass: [x, y], .. } = &self.facts;
        let fastest = (2.0 * energy / x.min(*y)).sqrt();
        let longest = fastest * settings.sample_period + 2.0 * 2.0_f64.sqrt() * settings.encoder_step;
        0.5 * settings.stiffness * (longest * self.periods()).powi(2)
    }

    pub fn check(
        &mut self,
        time: f64,
        plants: &[AxisPlant; 2],
        report: &StrategyReport,
        partner_sent: f64,
        [x, y]: [f64; 2],
    ) -> Result<(), Violation> {
        let Facts { settings, is_honest, clock_error, unchecked, .. } = self.facts;
        let tolerance = 1e-11 * self.scale;
        let fail = |law, value, bound| judge(unchecked, Violation { law, time, value, bound });
        self.longest = self.longest.max(x.hypot(y));
        self.energy = plants.iter().map(AxisPlant::energy).sum();

        let expected = self.start + self.true_work + self.hand - self.loss;
        if !((self.energy - expected).abs() <= 1e-9 * self.scale) {
            fail(Law::Plant, self.energy, expected)?;
        }
        let unseen = (self.true_work - self.work).abs();
        if !(unseen <= 1.05 * self.unseen + 1e-9 * self.scale) {
            fail(Law::Unseen, unseen, self.unseen)?;
        }
        let balance = report.balance.unwrap_or(0.0);
        let (taken, sent) = (report.energy_received, report.energy_sent);
        if settings.encoder_step == 0.0 {
            let expected = self.start_balance - self.work + settings.share * self.bound + taken - sent;
            if !((balance - expected).abs() <= tolerance) {
                fail(Law::Account, balance, expected)?;
            }
        }
        let credited = settings.share * self.certain * (1.0 + clock_error);
        let most = self.start_balance - self.work + credited + taken - sent;
        if !(balance <= most + tolerance) {
            fail(Law::Account, balance, most)?;
        }
        if !(balance >= -self.overdraft() - tolerance) {
            fail(Law::Overdraft, balance, -self.overdraft())?;
        }
        let mut allowed = settings.intake * time * (1.0 + clock_error);
        if is_honest {
            allowed = allowed.min(partner_sent);
        }
        if !(taken <= allowed + tolerance) {
            fail(Law::Intake, taken, allowed)?;
        }
        let spent = self.loss - credited;
        let overdraft = self.overdraft() + 1.05 * self.unseen;
        let most = self.start + self.start_balance + self.hand + allowed - sent - spent + overdraft;
        if !(self.energy <= most + 1e-9 * self.scale) {
            fail(Law::Energy, self.energy, most)?;
        }
        self.available = self.available.max(most - self.overdraft());
        self.largest = self.largest.max(self.energy);
        let most = self.available + self.overdraft_at(self.largest);
        if !(self.energy <= most + 1e-9 * self.scale) {
            fail(Law::Bounded, self.energy, most)?;
        }
        Ok(())
    }

    /// The same, of a force just computed, N, with the report after it. `time` is on the clock that does not err.
    pub fn check_force(
        &mut self,
        time: f64,
        force: [f64; 2],
        report: &StrategyReport,
    ) -> Result<(), Violation> {
        let size = force[0].hypot(force[1]);
        if !size.is_finite() {
            judge(self.facts.unchecked, Violation { law: Law::Finite, time, value: size, bound: 0.0 })?;
        }
        let balance = report.balance.unwrap_or(0.0);
        // what moved to the partner after the force was paid is still behind it
        let bound = (2.0 * self.facts.settings.stiffness * balance.max(0.0)).sqrt();
        if size <= bound * (1.0 + 1e-9) + 1e-12 {
            return Ok(());
        }
        judge(self.facts.unchecked, Violation { law: Law::Force, time, value: size, bound })
    }
}

/// The laws of both sides together, if the totals are honest.
#[derive(Debug, Default)]
pub struct Together {
    /// What both sides had when the hands let go, and what was lost for good until then.
    at_let_go: Option<(f64, f64)>,
}

impl Together {
    /// Checks both sides at a time (s); `are_free` once the hands have let go.
    pub fn check(
        &mut self,
        time: f64,
        are_free: bool,
        sides: [(&Ledger, StrategyReport); 2],
    ) -> Result<(), Violation> {
        if sides.iter().any(|(ledger, _)| !ledger.facts.is_honest) {
            return Ok(());
        }
        let unchecked = sides[0].0.facts.unchecked;
        let (mut held, mut got, mut spent, mut overdraft, mut scale) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (index, (ledger, report)) in sides.iter().enumerate() {
            let partner = &sides[1 - index].1;
            held += ledger.energy
                + report.balance.unwrap_or(0.0)
                + (report.energy_sent - partner.energy_received);
            got += ledger.start + ledger.start_balance + ledger.hand + 1.05 * ledger.unseen;
            let Facts { settings, clock_error, .. } = ledger.facts;
            spent += ledger.loss - settings.share * ledger.certain * (1.0 + clock_error);
            overdraft += ledger.overdraft() + 1.05 * ledger.unseen;
            scale += ledger.scale;
        }
        let tolerance = 1e-9 * scale;
        if !(held <= got - spent + tolerance) {
            judge(unchecked, Violation { law: Law::Together, time, value: held, bound: got - spent })?;
        }
        if !are_free {
            return Ok(());
        }
        let (had, before) = *self.at_let_go.get_or_insert((held, spent));
        let bound = had + overdraft;
        if !(spent - before <= bound + tolerance) {
            judge(unchecked, Violation { law: Law::DiesOut, time, value: spent - before, bound })?;
        }
        Ok(())
    }
}
