//! The account of one side, kept a second time: from what was measured, what acted and what arrived, term by term.

use telespring::session::AccountSettings;
use telespring::session::strategy::StrategyReport;

/// The longest time for which energy waits to be taken in, s, as docs/guard.md states it.
const LONGEST_WAIT: f64 = 5.0;

/// What a side knew when it computed a force.
#[derive(Debug, Clone, Copy)]
pub struct Answer {
    /// The force computed, N.
    pub force: [f64; 2],
    /// The largest total of energy in the packets taken, J; `None` while no partner is known.
    pub claimed: Option<f64>,
    /// Whether the force is that of the law's spring alone, neither ramped nor damped.
    pub is_spring: bool,
}

/// The account as it must be.
#[derive(Debug, Clone)]
pub struct Books {
    settings: AccountSettings,
    /// S, J.
    balance: f64,
    received: f64,
    sent: f64,
    claimed: f64,
    waiting: f64,
    /// The force that acted before the last measurement, N.
    acted: [f64; 2],
    /// The sizes of the force that reaches the device next, of that which it follows, and of that which acts, N.
    waiting_force: f64,
    followed: f64,
    acting: f64,
    /// The time and the displacement of the loss that is not credited yet, per axis.
    open: [(f64, f64); 2],
    position: Option<[f64; 2]>,
    limited_ticks: u64,
}

impl Books {
    pub fn new(settings: AccountSettings) -> Self {
        Self {
            settings,
            balance: settings.capacity,
            received: 0.0,
            sent: 0.0,
            claimed: 0.0,
            waiting: 0.0,
            acted: [0.0; 2],
            waiting_force: 0.0,
            followed: 0.0,
            acting: 0.0,
            open: [(0.0, 0.0); 2],
            position: None,
            limited_ticks: 0,
        }
    }

    /// The balance that the account must have, J.
    pub fn balance(&self) -> f64 {
        self.balance
    }

    /// A measurement `elapsed` s after the one before, with the position of the plant as the encoder shows it (m) and the
    /// mean force that acted since (N). `report` is used where a partner lies: what is taken in of its claims is not
    /// computed here.
    pub fn settle(
        &mut self,
        elapsed: f64,
        position: [f64; 2],
        acted: [f64; 2],
        is_honest: bool,
        report: &StrategyReport,
    ) {
        let AccountSettings { damping, share, intake, encoder_step, .. } = self.settings;
        let before = self.position.replace(position).unwrap_or(position);
        for axis in 0..2 {
            let moved = position[axis] - before[axis];
            // given out, and what the encoder may hide of it
            self.balance -= acted[axis] * moved;
            let rise = acted[axis].abs() - self.acted[axis].abs();
            self.balance -= 0.5 * encoder_step * ((acted[axis] - self.acted[axis]).abs() + rise);
            let (time, distance) = &mut self.open[axis];
            (*time, *distance) = (*time + elapsed, *distance + moved);
            let is_long = distance.abs() >= 16.0 * encoder_step || *time >= 0.05;
            if *time > 0.0 && (encoder_step == 0.0 || is_long) {
                let certain = (distance.abs() - encoder_step).max(0.0);
                self.balance += share * damping[axis] * certain.powi(2) / *time;
                (*time, *distance) = (0.0, 0.0);
            }
        }
        self.acted = acted;
        if self.settings.actuator_lag > 0.0 {
            self.acting += (self.followed - self.acting) * -(-elapsed / self.settings.actuator_lag).exp_m1();
        }
        let received = if is_honest {
            self.received + self.waiting.min(intake * elapsed)
        } else {
            report.energy_received
        };
        self.waiting = (self.waiting - (received - self.received)).min(intake * LONGEST_WAIT);
        self.balance += received - self.received;
        self.received = received;
    }

    /// A force was computed, and what the account holds too much is sent. Where the wanted force is not known, the excess
    /// is the reported one.
    pub fn pay(&mut self, answer: &Answer, report: &StrategyReport) {
        let AccountSettings { stiffness, capacity, computing_tick, sample_period, actuator_lag, .. } =
            self.settings;
        let size = answer.force[0].hypot(answer.force[1]);
        // the impulse that is still to come, in sample periods, and for how many of them a force acts
        let to_come = size + self.waiting_force + actuator_lag / sample_period * self.acting;
        let periods = actuator_lag / sample_period + if computing_tick { 2.0 } else { 1.0 };
        (self.waiting_force, self.followed) =
            if computing_tick { (size, self.waiting_force) } else { (0.0, size) };
        let is_limited = report.limited_ticks > self.limited_ticks;
        self.limited_ticks = report.limited_ticks;
        let claimed = answer.claimed.unwrap_or(0.0).max(self.claimed);
        self.waiting += claimed - self.claimed;
        self.claimed = claimed;
        let excess = if answer.is_spring && !is_limited {
            let kept = size.powi(2).max((to_come / periods).powi(2)) / (2.0 * stiffness);
            (self.balance - kept - capacity).max(0.0)
        } else {
            report.energy_sent - self.sent
        };
        self.balance -= excess;
        self.sent += excess;
    }

    /// The energy sent to the partner so far, J.
    pub fn sent(&self) -> f64 {
        self.sent
    }
}
