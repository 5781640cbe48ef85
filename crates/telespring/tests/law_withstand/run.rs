//! A case, tick by tick, with every law checked at every tick.

use crate::case::{Case, CaseSide, predictors};
use crate::liar::Liar;
use crate::withstand_common::books::{Answer, Books};
use crate::withstand_common::ledger::{Facts, Law, Ledger, Together, Violation, judge};
use crate::withstand_common::pair::{Actuator, Station, measure_and_send};
use crate::withstand_common::plant::AxisPlant;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use telespring::session::strategy::{Guard, StrategyChoice, StrategyReport};
use telespring::session::{
    Endpoint, EndpointSettings, LocalTime, Motion, Packet, Span, WatchdogSettings, WatchdogState,
};

/// What came of a run.
#[derive(Debug, Clone, Default)]
pub struct Outcome {
    /// The largest distance of a handle from the origin along an axis, m.
    pub farthest: f64,
    /// The largest speed along an axis over the last second, m/s.
    pub last_speed: f64,
    /// The share of ticks with a partner at which each side was limited.
    pub limited: [f64; 2],
    /// The energy that both sides have sent, J.
    pub sent: f64,
    /// The positions per tick, side and axis, m.
    pub positions: Vec<[[f64; 2]; 2]>,
}

/// One side with its robot, at the start of a case.
fn station(case: &Case, side: usize, seed: u64) -> Station {
    let Case { law, period, lag, .. } = *case;
    let facts = &case.sides[side];
    let (_, predictor) = predictors()[case.predictor].clone();
    let settings = EndpointSettings {
        strategy: StrategyChoice::Guard(Guard::new(law, facts.settings).unwrap()),
        predictor,
        playout: case.playout,
        clock: case.clock,
        watchdog: case.is_watched.then(|| WatchdogSettings {
            silence: Span(20_000_000).max(period + period),
            ..WatchdogSettings::default()
        }),
        sample_period: period,
        computing_tick: facts.settings.computing_tick,
        ..EndpointSettings::new(side as u64 + 1, law, Span(0))
    };
    let plants = [0, 1].map(|axis| {
        let (mass, damping, ground) = (facts.mass[axis], facts.damping[axis], facts.ground[axis]);
        let mut plant = AxisPlant::new(mass, damping, ground, period.seconds());
        plant.velocity = facts.velocity[axis];
        if lag > 0.0 { plant.behind_lag(damping, lag * period.seconds()) } else { plant }
    });
    let mut channel = case.network.towards(side).channel(case.travel[side], seed, side);
    if case.has_liar[side] {
        let random = ChaCha8Rng::seed_from_u64(seed + side as u64);
        channel = Box::new(Liar { channel, random, receiver: Motion::default(), restarts: 0 });
    }
    let mut station = Station::new(plants, Endpoint::new(settings).unwrap(), channel);
    station.actuator = Actuator {
        computing_tick: facts.settings.computing_tick,
        limit: case.force_limit,
        is_told: lag > 0.0 || case.force_limit.is_finite(),
    };
    station.clock = case.clocks[side];
    station.encoder_step = facts.settings.encoder_step;
    station
}

/// What the test knows of a side.
struct Watcher {
    ledger: Ledger,
    books: Books,
    is_honest: bool,
    is_undamped: bool,
    unchecked: &'static [Law],
    /// The local time of the last measurement, and what was measured.
    last: Option<(LocalTime, [f64; 2])>,
    /// The mean force that acted since, N.
    acted: [f64; 2],
    /// The largest total in the packets taken, J.
    claimed: f64,
    ticks: u64,
}

impl Watcher {
    fn new(case: &Case, side: usize, station: &Station, unchecked: &'static [Law]) -> Self {
        let CaseSide { mass, damping, settings, .. } = case.sides[side];
        let facts = Facts {
            mass,
            damping,
            settings,
            is_honest: case.is_honest(side),
            // its readings are whole nanoseconds
            clock_error: case.clocks[side].drift.abs() + 1e-9 / case.period.seconds(),
            unchecked,
        };
        Self {
            ledger: Ledger::new(facts, &station.plants, settings.capacity),
            books: Books::new(settings),
            is_honest: case.is_honest(side),
            is_undamped: case.law.damping == 0.0,
            unchecked,
            last: None,
            acted: [0.0; 2],
            claimed: 0.0,
            ticks: 0,
        }
    }

    fn compare(&self, time: f64, report: &StrategyReport) -> Result<(), Violation> {
        let tolerance = 1e-11 * self.ledger.scale();
        let pairs = [
            (report.balance.unwrap_or(f64::NAN), self.books.balance()),
            (report.energy_sent, self.books.sent()),
        ];
        for (value, bound) in pairs {
            if !((value - bound).abs() <= tolerance) {
                judge(self.unchecked, Violation { law: Law::Recomputed, time, value, bound })?;
            }
        }
        Ok(())
    }

    /// After a measurement.
    fn settled(&mut self, now: LocalTime, station: &Station, partner_sent: f64) -> Result<(), Violation> {
        let (time, local) = (now.seconds(), station.clock.at(now));
        let position = station.measured.position;
        let (before, from) = self.last.replace((local, position)).unwrap_or((local, position));
        let report = station.endpoint.report().strategy;
        self.books.settle((local - before).seconds(), position, self.acted, self.is_honest, &report);
        self.compare(time, &report)?;
        let displacement = [position[0] - from[0], position[1] - from[1]];
        self.ledger.check(time, &station.plants, &report, partner_sent, displacement)
    }

    /// After a force.
    fn answered(&mut self, now: LocalTime, endpoint: &Endpoint, force: [f64; 2]) -> Result<(), Violation> {
        let (report, state) = (endpoint.report().strategy, endpoint.state());
        let has_partner = report.ticks > self.ticks && !matches!(state, WatchdogState::RampingOut { .. });
        self.ticks = report.ticks;
        let is_whole = matches!(
            state,
            WatchdogState::Engaged | WatchdogState::Holding { .. } | WatchdogState::Disengaged { .. }
        );
        let answer = Answer {
            force,
            claimed: has_partner.then_some(self.claimed),
            is_spring: self.is_undamped && is_whole,
        };
        self.books.pay(&answer, &report);
        self.compare(now.seconds(), &report)?;
        self.ledger.check_force(now.seconds(), force, &report)
    }
}

/// Runs a case; the first law broken ends it.
pub fn run(case: &Case, seed: u64, unchecked: &'static [Law]) -> Result<Outcome, Violation> {
    let mut stations = [0, 1].map(|side| station(case, side, seed));
    let mut watchers = [0, 1].map(|side| Watcher::new(case, side, &stations[side], unchecked));
    let (mut outcome, mut together) = (Outcome::default(), Together::default());
    let last_second = case.ticks.saturating_sub((1.0 / case.period.seconds()) as usize);
    for n in 0..=case.ticks {
        let now = LocalTime(0) + Span(n as i64 * case.period.0);
        measure_and_send(&mut stations, now);
        let sent = stations.each_ref().map(|station| station.endpoint.report().strategy.energy_sent);
        for side in 0..2 {
            watchers[side].settled(now, &stations[side], sent[1 - side])?;
        }
        let sides = [0, 1].map(|side| (&watchers[side].ledger, stations[side].endpoint.report().strategy));
        together.check(now.seconds(), n >= case.let_go, sides)?;
        outcome
            .positions
            .push(stations.each_ref().map(|station| station.plants.each_ref().map(|p| p.position)));
        for side in 0..2 {
            let (station, watcher) = (&mut stations[side], &mut watchers[side]);
            let local = station.clock.at(now);
            station.endpoint.handle_target(local, case.target(side, now.seconds()));
            let force = station.answer(now, |packet, is_taken| {
                if let (true, Ok(packet)) = (is_taken, Packet::decode(packet)) {
                    watcher.claimed = watcher.claimed.max(packet.energy_sent);
                }
            });
            watcher.answered(now, &station.endpoint, force)?;
            let hand = case.hand(side, n);
            let steps = station.advance(force, hand);
            watcher.acted = steps.map(|step| step.mean);
            let elapsed = (station.clock.at(now + case.period) - local).seconds();
            for axis in 0..2 {
                watcher.ledger.add(axis, &steps[axis], hand[axis], elapsed);
                let plant = &station.plants[axis];
                outcome.farthest = outcome.farthest.max(plant.position.abs());
                if n >= last_second {
                    outcome.last_speed = outcome.last_speed.max(plant.velocity.abs());
                }
            }
        }
    }
    let reports = stations.each_ref().map(|station| station.endpoint.report().strategy);
    outcome.limited = reports.map(|report| report.limited_ticks as f64 / report.ticks.max(1) as f64);
    outcome.sent = reports.iter().map(|report| report.energy_sent).sum();
    Ok(outcome)
}
