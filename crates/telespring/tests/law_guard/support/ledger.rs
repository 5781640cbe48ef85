//! What really happened to the energy of one side, and the laws that it must obey.

use telespring::session::strategy::{Strategy, StrategyReport, Tick};

use super::case::{Case, CaseSide};
use super::plant::AxisPlant;

/// The laws of the guard.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Law {
    /// The plant's energy is what it was plus all work less all losses: a check of the test itself.
    Plant,
    /// |F| ≤ √(2 k S).
    Force,
    /// The account holds what it must hold.
    Account,
    /// The account is overdrawn by no more than stated.
    Overdraft,
    /// No more is taken in than was sent, and no faster than the set power.
    Intake,
    /// The robot's energy exceeds what it had and got by no more than the overdraft.
    Energy,
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
fn judge(unchecked: &[Law], violation: Violation) -> Result<(), Violation> {
    if unchecked.contains(&violation.law) { Ok(()) } else { Err(violation) }
}

pub struct Ledger {
    period: f64,
    side: CaseSide,
    is_honest: bool,
    unchecked: &'static [Law],
    start: f64,
    start_balance: f64,
    /// What acted on the robot: the spring's work, the hand's, all losses, and those in the damping that is certain.
    work: f64,
    hand: f64,
    loss: f64,
    certain: f64,
    /// The bound b|Δx|²/Δt of the certain loss.
    bound: f64,
    /// The largest displacement of a tick as measured, m.
    longest: f64,
    scale: f64,
    energy: f64,
}

impl Ledger {
    pub fn new(case: &Case, side: usize, plants: &[AxisPlant; 2], strategy: &dyn Strategy) -> Self {
        let energy = plants.iter().map(AxisPlant::energy).sum();
        Self {
            period: case.period,
            side: case.sides[side],
            is_honest: case.is_honest(),
            unchecked: case.unchecked,
            start: energy,
            start_balance: strategy.report().balance.unwrap_or(0.0),
            work: 0.0,
            hand: 0.0,
            loss: 0.0,
            certain: 0.0,
            bound: 0.0,
            longest: 0.0,
            scale: 1.0,
            energy,
        }
    }

    /// One axis moved over one period.
    pub fn add(&mut self, axis: usize, moved: f64, squares: f64, acted: f64, hand: f64) {
        self.work += acted * moved;
        self.hand += hand * moved;
        self.loss += self.side.damping[axis] * squares;
        self.certain += self.side.settings.damping[axis] * squares;
        self.bound += self.side.settings.damping[axis] * moved * moved / self.period;
        self.scale += (acted * moved).abs() + (hand * moved).abs();
    }

    fn overdraft(&self) -> f64 {
        let settings = &self.side.settings;
        let factor = if settings.computing_tick { 2.0 } else { 0.5 };
        factor * settings.stiffness * (self.longest + 2.0_f64.sqrt() * settings.encoder_step).powi(2)
    }

    pub fn check(
        &mut self,
        time: f64,
        plants: &[AxisPlant; 2],
        report: &StrategyReport,
        partner_sent: f64,
        tick: &Tick,
    ) -> Result<(), Violation> {
        let settings = &self.side.settings;
        let tolerance = 1e-11 * self.scale;
        let unchecked = self.unchecked;
        let fail = |law, value, bound| judge(unchecked, Violation { law, time, value, bound });
        let [x, y] = tick.displacement();
        self.longest = self.longest.max(x.hypot(y));
        self.energy = plants.iter().map(AxisPlant::energy).sum();

        let expected = self.start + self.work + self.hand - self.loss;
        if !((self.energy - expected).abs() <= 1e-9 * self.scale) {
            fail(Law::Plant, self.energy, expected)?;
        }
        let balance = report.balance.unwrap_or(0.0);
        let (taken, sent) = (report.energy_received, report.energy_sent);
        if settings.encoder_step == 0.0 {
            let expected = self.start_balance - self.work + settings.share * self.bound + taken - sent;
            if !((balance - expected).abs() <= tolerance) {
                fail(Law::Account, balance, expected)?;
            }
        }
        let most = self.start_balance - self.work + settings.share * self.certain + taken - sent;
        if !(balance <= most + tolerance) {
            fail(Law::Account, balance, most)?;
        }
        if !(balance >= -self.overdraft() - tolerance) {
            fail(Law::Overdraft, balance, -self.overdraft())?;
        }
        let mut allowed = settings.intake * time;
        if self.is_honest {
            allowed = allowed.min(partner_sent);
        }
        if !(taken <= allowed + tolerance) {
            fail(Law::Intake, taken, allowed)?;
        }
        let spent = self.loss - settings.share * self.certain;
        let most = self.start + self.start_balance + self.hand + allowed - sent - spent + self.overdraft();
        if !(self.energy <= most + 1e-9 * self.scale) {
            fail(Law::Energy, self.energy, most)?;
        }
        Ok(())
    }

    pub fn check_force(&self, time: f64, force: [f64; 2], report: &StrategyReport) -> Result<(), Violation> {
        let size = force[0].hypot(force[1]);
        let balance = report.balance.unwrap_or(0.0);
        // what moved to the partner after the force was paid is still behind it
        let bound = (2.0 * self.side.settings.stiffness * balance.max(0.0)).sqrt();
        if size <= bound * (1.0 + 1e-9) + 1e-12 {
            return Ok(());
        }
        judge(self.unchecked, Violation { law: Law::Force, time, value: size, bound })
    }
}

/// The laws of both sides together, if the totals are honest.
#[derive(Debug, Default)]
pub struct Together {
    /// What both sides had when the hands let go, and what was lost for good until then.
    at_let_go: Option<(f64, f64)>,
}

impl Together {
    pub fn check(
        &mut self,
        case: &Case,
        time: f64,
        sides: [(&Ledger, StrategyReport); 2],
    ) -> Result<(), Violation> {
        if !case.is_honest() {
            return Ok(());
        }
        let (mut held, mut got, mut spent, mut overdraft, mut scale) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (index, (ledger, report)) in sides.iter().enumerate() {
            let partner = &sides[1 - index].1;
            held += ledger.energy
                + report.balance.unwrap_or(0.0)
                + (report.energy_sent - partner.energy_received);
            got += ledger.start + ledger.start_balance + ledger.hand;
            spent += ledger.loss - ledger.side.settings.share * ledger.certain;
            overdraft += ledger.overdraft();
            scale += ledger.scale;
        }
        let tolerance = 1e-9 * scale;
        if !(held <= got - spent + tolerance) {
            judge(case.unchecked, Violation { law: Law::Together, time, value: held, bound: got - spent })?;
        }
        if time < case.let_go {
            return Ok(());
        }
        let (had, before) = *self.at_let_go.get_or_insert((held, spent));
        let bound = had + overdraft;
        if !(spent - before <= bound + tolerance) {
            judge(case.unchecked, Violation { law: Law::DiesOut, time, value: spent - before, bound })?;
        }
        Ok(())
    }
}
