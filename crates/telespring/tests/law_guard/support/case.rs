//! Random cases: dyad, hands, network or adversary, predictor, settings.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use telespring::session::{AccountSettings, Law, Motion};

use super::Law as Broken;

/// What stands between the two sides.
#[derive(Debug, Clone, Copy)]
pub enum Network {
    /// Delay and largest jitter (s), probability of loss; whether an overtaken packet is played backwards.
    Random { delay: f64, jitter: f64, loss: f64, backwards: bool },
    /// An adversary that holds every sample for as long as it may, s.
    Oldest { span: f64 },
    /// An adversary that plays the sample of this span (s) that gives the robot the most power.
    Harmful { span: f64 },
    /// A partner that lies in position, velocity, stamps and totals.
    Liar,
    /// No partner.
    Nothing,
}

#[derive(Debug, Clone, Copy)]
pub enum PredictorKind {
    Hold,
    Linear,
    ConstantVelocity,
    ConstantAcceleration,
    SharedTarget,
}

#[derive(Debug, Clone, Copy)]
pub struct CaseSide {
    /// Robot and operator together.
    pub mass: [f64; 2],
    pub damping: [f64; 2],
    pub ground: [f64; 2],
    pub velocity: [f64; 2],
    pub settings: AccountSettings,
    /// The amplitude (N), angular frequency (rad/s) and phase of the hand's force per axis.
    pub hand: [(f64, f64, f64); 2],
    /// The stiffness of an agent that follows the target, N/m.
    pub agent: f64,
}

#[derive(Debug, Clone, Copy)]
pub struct Case {
    pub period: f64,
    pub ticks: usize,
    pub law: Law,
    pub sides: [CaseSide; 2],
    pub network: Network,
    pub predictor: PredictorKind,
    /// The largest force of the device per axis, N.
    pub force_limit: f64,
    /// How often the coupling is ramped out and in, 1/s; 0 for never.
    pub ramps: f64,
    /// When the hands let go, s.
    pub let_go: f64,
    /// The laws that are not checked.
    pub unchecked: &'static [Broken],
}

/// A number whose logarithm is uniform.
fn spread(random: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    (random.random_range(low.ln()..high.ln())).exp()
}

fn pick<T: Copy>(random: &mut ChaCha8Rng, choices: &[T]) -> T {
    choices[random.random_range(0..choices.len())]
}

impl Case {
    pub fn random(random: &mut ChaCha8Rng, ticks: usize) -> Self {
        let stiffness = spread(random, 10.0, 5000.0);
        let computing_tick = random.random_bool(0.4);
        let encoder_step = pick(random, &[0.0, 0.0, 1e-5, 1e-4, 1e-3]);
        let free = random.random_bool(0.3);
        let sides = [0, 1].map(|_| {
            let robot: [f64; 2] = [0, 1].map(|_| spread(random, 0.5, 40.0));
            let added = if free { 0.0 } else { random.random_range(0.0..10.0) };
            let ground = if free || random.random_bool(0.5) { 0.0 } else { spread(random, 10.0, 500.0) };
            CaseSide {
                mass: [0, 1].map(|_| spread(random, 0.3, 5.0)),
                damping: robot.map(|damping| damping + added),
                ground: [ground; 2],
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
                hand: [0, 1].map(|_| {
                    if free {
                        (0.0, 0.0, 0.0)
                    } else {
                        (
                            random.random_range(0.0..15.0),
                            spread(random, 0.5, 30.0),
                            random.random_range(0.0..6.0),
                        )
                    }
                }),
                agent: 0.0,
            }
        });
        let span = spread(random, 0.05, 1.0);
        let network = match random.random_range(0..7) {
            0..3 => Network::Random {
                delay: spread(random, 1e-3, 0.5),
                jitter: pick(random, &[0.0, 0.01, 0.1]),
                loss: pick(random, &[0.0, 0.02, 0.3]),
                backwards: random.random_bool(0.5),
            },
            3 => Network::Oldest { span },
            4 => Network::Harmful { span: span.min(0.3) },
            5 => Network::Liar,
            _ => {
                if random.random_bool(0.2) {
                    Network::Nothing
                } else {
                    Network::Oldest { span: 1.0 }
                }
            }
        };
        let damping = if random.random_bool(0.25) { random.random_range(0.0..10.0) } else { 0.0 };
        let period = pick(random, &[5e-4, 1e-3, 1e-3, 4e-3]);
        let at_period = |settings| AccountSettings { sample_period: period, ..settings };
        Self {
            period,
            ticks,
            law: Law { stiffness, damping },
            sides: sides.map(|side| CaseSide { settings: at_period(side.settings), ..side }),
            network,
            predictor: pick(
                random,
                &[
                    PredictorKind::Hold,
                    PredictorKind::Linear,
                    PredictorKind::ConstantVelocity,
                    PredictorKind::ConstantAcceleration,
                    PredictorKind::SharedTarget,
                ],
            ),
            force_limit: pick(random, &[f64::INFINITY, 20.0, 2.0]),
            ramps: pick(random, &[0.0, 0.0, 0.7]),
            let_go: 0.5 * ticks as f64 * period,
            unchecked: &[],
        }
    }

    pub fn travel_time(&self, random: &mut ChaCha8Rng) -> f64 {
        match self.network {
            Network::Random { delay, jitter, .. } => delay + jitter * random.random::<f64>(),
            _ => 0.0,
        }
    }

    pub fn is_lost(&self, random: &mut ChaCha8Rng) -> bool {
        match self.network {
            Network::Random { loss, .. } => loss > 0.0 && random.random_bool(loss),
            _ => false,
        }
    }

    /// The watchdog's factor: a trapezium, zero for a part of every period.
    pub fn enabled(&self, now: f64) -> f64 {
        if self.ramps == 0.0 {
            1.0
        } else {
            (2.0 * (std::f64::consts::TAU * self.ramps * now).cos() + 1.0).clamp(0.0, 1.0)
        }
    }

    /// The force of the hand on an axis, N.
    pub fn hand(&self, side: usize, axis: usize, now: f64, target: &Motion) -> f64 {
        if now >= self.let_go {
            return 0.0;
        }
        let (amplitude, frequency, phase) = self.sides[side].hand[axis];
        amplitude * (frequency * now + phase).cos() + self.sides[side].agent * target.position[axis]
    }

    /// Whether the totals that a side hears are those that its partner sends.
    pub fn is_honest(&self) -> bool {
        !matches!(self.network, Network::Liar)
    }
}
