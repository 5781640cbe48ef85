//! Random cases: dyad, hands, controller, network, play-out and predictor.

use crate::networks::random_network;
use crate::withstand_common::pair::SideClock;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use telespring::rig::{Adversary, Network};
use telespring::session::predictor::{
    Hold, Kalman, Linear, MotionModel, Noise, PredictorChoice, SharedTarget,
};
use telespring::session::{
    AccountSettings, AdaptiveDelay, ClockSettings, Law, Motion, PlayoutSettings, Span,
};

/// The force of a hand along an axis: a steady pull (N) and a swing of an amplitude (N), angular frequency (rad/s) and
/// phase.
pub type HandForce = (f64, f64, f64, f64);

#[derive(Debug, Clone, Copy)]
pub struct CaseSide {
    /// Robot and hand together.
    pub mass: [f64; 2],
    pub damping: [f64; 2],
    pub ground: [f64; 2],
    pub velocity: [f64; 2],
    pub settings: AccountSettings,
    pub hand: [HandForce; 2],
}

#[derive(Debug, Clone)]
pub struct Case {
    pub period: Span,
    pub ticks: usize,
    /// The tick at which the hands let go.
    pub let_go: usize,
    pub law: Law,
    pub sides: [CaseSide; 2],
    pub network: Network,
    /// What every packet takes at least, towards each side.
    pub travel: [Span; 2],
    /// Whether each side hears a partner of which nothing is true.
    pub has_liar: [bool; 2],
    pub playout: PlayoutSettings,
    pub clock: ClockSettings,
    pub clocks: [SideClock; 2],
    pub is_watched: bool,
    pub predictor: usize,
    /// How wrong the target of the second side is: its factor, and how much later it is, s.
    pub wrong_target: (f64, f64),
    /// The largest force of each robot per axis, N.
    pub force_limit: f64,
    /// The time constant of each actuator in sample periods; 0 without a lag.
    pub lag: f64,
}

/// A number whose logarithm is uniform.
pub fn spread(random: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    random.random_range(low.ln()..high.ln()).exp()
}

pub fn pick<T: Clone>(random: &mut ChaCha8Rng, choices: &[T]) -> T {
    choices[random.random_range(0..choices.len())].clone()
}

/// All predictors, by name.
pub fn predictors() -> [(&'static str, PredictorChoice); 5] {
    let kalman = |model, process| {
        PredictorChoice::Kalman(Kalman::new(model, Noise { process, position: 1e-5 }).unwrap())
    };
    [
        ("hold", PredictorChoice::Hold(Hold)),
        ("linear", PredictorChoice::Linear(Linear)),
        ("constant velocity", kalman(MotionModel::ConstantVelocity, 1.0)),
        ("constant acceleration", kalman(MotionModel::ConstantAcceleration, 100.0)),
        ("shared target", PredictorChoice::SharedTarget(SharedTarget)),
    ]
}

impl Case {
    pub fn random(random: &mut ChaCha8Rng, ticks: usize) -> Self {
        let seconds = pick(random, &[5e-4, 1e-3, 1e-3, 4e-3]);
        let stiffness = spread(random, 10.0, 5000.0);
        let computing_tick = random.random_bool(0.4);
        let encoder_step = pick(random, &[0.0, 0.0, 1e-5, 1e-4, 1e-3]);
        let sides = [0, 1].map(|_| random_side(random, stiffness, computing_tick, encoder_step));
        let has_own_clock = random.random_bool(0.4);
        let clocks = [0, 1].map(|_| match has_own_clock {
            false => SideClock::TRUE,
            true => SideClock {
                offset: Span::from_seconds(random.random_range(0.0..1e5)),
                drift: random.random_range(-1e-4..1e-4),
            },
        });
        let travel = [0, 1].map(|_| Span::from_seconds(pick(random, &[0.0, 0.02, 0.084, 0.2, 0.334])));
        let playout = match random.random_range(0..3) {
            0 => PlayoutSettings::Adaptive(AdaptiveDelay {
                quantile: random.random_range(0.0..=1.0),
                window: Span::from_seconds(spread(random, 0.1, 10.0)),
                slew: random.random_range(0.05..0.9),
                ..AdaptiveDelay::default()
            }),
            _ => PlayoutSettings::Fixed { delay: Span::from_seconds(pick(random, &[0.0, 0.05, 0.2, 0.4])) },
        };
        let case = Self {
            period: Span::from_seconds(seconds),
            ticks,
            let_go: ticks / 2,
            law: Law {
                stiffness,
                damping: if random.random_bool(0.25) { random.random_range(0.0..10.0) } else { 0.0 },
            },
            sides,
            network: random_network(random, seconds),
            travel,
            has_liar: [0, 1].map(|_| random.random_bool(0.1)),
            playout,
            clock: if has_own_clock { ClockSettings::estimated() } else { ClockSettings::default() },
            clocks,
            is_watched: random.random_bool(0.3),
            predictor: random.random_range(0..5),
            wrong_target: pick(random, &[(1.0, 0.0), (1.0, 0.3), (-1.0, 0.0), (20.0, 0.0)]),
            force_limit: pick(random, &[f64::INFINITY, f64::INFINITY, 20.0, 2.0]),
            lag: pick(random, &[0.0, 0.0, 0.0, 0.5, 3.0, 10.0]),
        };
        let period = case.period;
        case.at_period(period)
    }

    /// The case with controllers of this sample period.
    pub fn at_period(mut self, period: Span) -> Self {
        self.period = period;
        for side in &mut self.sides {
            side.settings.sample_period = period.seconds();
            side.settings.actuator_lag = self.lag * period.seconds();
        }
        self
    }

    /// The target that a side shows: a figure of eight of 5 cm and 10 cm (Eq. 12 of Du et al. 2025), wrong on the second.
    pub fn target(&self, side: usize, time: f64) -> Motion {
        let (factor, late) = if side == 0 { (1.0, 0.0) } else { self.wrong_target };
        let w = 2.59 * (time - late);
        Motion {
            position: [factor * 0.05 * (2.0 * w).sin(), factor * 0.1 * w.sin()],
            velocity: [factor * 2.0 * 2.59 * 0.05 * (2.0 * w).cos(), factor * 2.59 * 0.1 * w.cos()],
        }
    }

    /// The forces of a hand at a tick, N.
    pub fn hand(&self, side: usize, tick: usize) -> [f64; 2] {
        if tick >= self.let_go {
            return [0.0; 2];
        }
        let time = tick as f64 * self.period.seconds();
        self.sides[side].hand.map(|(pull, swing, rate, phase)| pull + swing * (rate * time + phase).cos())
    }

    /// Whether the totals that a side hears are those that its partner sends.
    pub fn is_honest(&self, side: usize) -> bool {
        let adversary = self.network.towards(side).adversary;
        !self.has_liar[side] && !matches!(adversary, Some(Adversary::LyingPeer { .. }))
    }
}

/// A robot with no hand, a spring, a random passive hand, or one that pulls and swings.
fn random_side(random: &mut ChaCha8Rng, stiffness: f64, computing_tick: bool, encoder_step: f64) -> CaseSide {
    let robot: [f64; 2] = [0, 1].map(|_| spread(random, 0.5, 40.0));
    let mass: [f64; 2] = [0, 1].map(|_| spread(random, 0.3, 5.0));
    let kind = random.random_range(0..4);
    let added = |random: &mut ChaCha8Rng, from: usize, low: f64, high: f64| {
        [0, 1].map(|_| if kind >= from { spread(random, low, high) } else { 0.0 })
    };
    let (hand_mass, hand_damping) = (added(random, 2, 0.1, 3.0), added(random, 2, 0.1, 20.0));
    let ground = added(random, 1, 10.0, 800.0);
    let holds = kind < 3 || random.random();
    CaseSide {
        mass: [0, 1].map(|axis| mass[axis] + hand_mass[axis]),
        damping: [0, 1].map(|axis| robot[axis] + hand_damping[axis]),
        ground: if holds { ground } else { [0.0; 2] },
        velocity: [0, 1].map(|_| random.random_range(-1.0..1.0)),
        settings: AccountSettings {
            stiffness,
            damping: robot.map(|damping| damping * random.random_range(0.5..=1.0)),
            share: random.random_range(0.0..0.95),
            capacity: spread(random, 1e-3, 0.2),
            intake: if random.random_bool(0.2) { 0.0 } else { random.random_range(0.0..0.5) },
            encoder_step,
            computing_tick,
            ..AccountSettings::new(stiffness, robot)
        },
        hand: [0, 1].map(|_| match kind {
            3 => (
                pick(random, &[0.0, 5.0, -10.0]),
                random.random_range(0.0..15.0),
                spread(random, 0.5, 30.0),
                random.random_range(0.0..6.0),
            ),
            _ => (0.0, 0.0, 0.0, 0.0),
        }),
    }
}
