//! Two H-MANs with an exact hold, each driven by an endpoint, over a network that delays, varies and loses.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

use crate::withstand_common::pair::{Station, measure_and_send};
use crate::withstand_common::plant::AxisPlant;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use telespring::rig::{Channel, Datagram};
use telespring::session::strategy::{
    Guard, InjectedDamping, InjectedDampingSettings, SetPositionModulation, SetPositionSettings, Spring,
    StrategyChoice, StrategyReport, TankSettings, TimeDomainPassivity, TwoLayer, WaveSettings, WaveVariables,
};
use telespring::session::{
    AccountSettings, Endpoint, EndpointSettings, Law, LocalTime, Motion, PlayoutSettings, Span,
    WatchdogSettings,
};

/// The sample period, s.
pub const PERIOD: f64 = 1e-3;

/// The stiffness at which the bare spring over 84 ms runs away, N/m.
pub const STIFFNESS: f64 = 142.0;

pub fn spring_law() -> Law {
    Law { stiffness: STIFFNESS, damping: 0.0 }
}

/// The dampings of the two H-MANs, per robot and axis, N·s/m.
pub fn hman_damping() -> [[f64; 2]; 2] {
    telespring::hman().robots().each_ref().map(|robot| [robot.damping()[0], robot.damping()[1]])
}

fn hman_mass() -> [[f64; 2]; 2] {
    telespring::hman().robots().each_ref().map(|robot| [robot.mass()[0], robot.mass()[1]])
}

/// The target of both hands, m: the paper's figure.
pub fn target(time: f64) -> [f64; 2] {
    let w = 2.59 * time;
    [0.05 * (2.0 * w).sin(), 0.1 * w.sin()]
}

/// What happens.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    /// Ticks from sending to arrival, and how much later a packet may come.
    pub delay: usize,
    pub jitter: usize,
    /// The share of packets lost.
    pub loss: f64,
    /// The delay of the play-out, in ticks.
    pub playout: usize,
    pub seconds: f64,
    /// The stiffness of each hand, N/m; it follows the target if `follows`, else it stays at 0.
    pub hands: [f64; 2],
    pub follows: bool,
    /// A force of the second hand beside it along each axis, N: the less skilled one.
    pub disturbance: f64,
    /// A steady pull at the first handle along x from 1 s on, N.
    pub pull: f64,
    /// The velocity of the first handle along x at the start, m/s.
    pub velocity: f64,
    /// The ticks between which no packet is sent; with it, both sides have a watchdog.
    pub blackout: Option<(usize, usize)>,
}

impl Case {
    /// Free handles, one side held, both held on the target, and held over a network that loses and overtakes.
    pub fn with_and_without_hands() -> [Self; 4] {
        [
            Self::free(84, 30.0),
            Self { hands: [0.0, 300.0], ..Self::free(84, 30.0) },
            Self::hands(84),
            Self { delay: 20, jitter: 130, loss: 0.1, playout: 60, ..Self::hands(20) },
        ]
    }

    /// Free handles over a constant delay of some ticks, the first one thrown at 0.3 m/s.
    pub fn free(delay: usize, seconds: f64) -> Self {
        Self {
            delay,
            jitter: 0,
            loss: 0.0,
            playout: delay,
            seconds,
            hands: [0.0; 2],
            follows: false,
            disturbance: 0.0,
            pull: 0.0,
            velocity: 0.3,
            blackout: None,
        }
    }

    /// Two hands of 120 N/m that follow the target for 29 s, the second one less skilled.
    pub fn hands(delay: usize) -> Self {
        Self { hands: [120.0; 2], follows: true, disturbance: 2.0, velocity: 0.0, ..Self::free(delay, 29.0) }
    }
}

/// One side at one tick, after its force.
#[derive(Clone, Copy)]
pub struct Tick {
    pub motion: Motion,
    pub force: [f64; 2],
    pub report: StrategyReport,
    /// The energy given out so far by the force at the plant, J; from the plant alone.
    pub given_out: f64,
}

/// All ticks of both sides.
pub struct Course(pub Vec<[Tick; 2]>);

impl Course {
    /// The largest distance of a handle from the origin along an axis, m.
    pub fn farthest(&self) -> f64 {
        let places = self.0.iter().flatten().flat_map(|tick| tick.motion.position);
        places.fold(0.0, |most, x| most.max(x.abs()))
    }

    /// The largest speed of a handle along an axis in the last second, m/s.
    pub fn last_speed(&self) -> f64 {
        let last = self.0.iter().rev().take(1000).flatten().flat_map(|tick| tick.motion.velocity);
        last.fold(0.0, |most, v| most.max(v.abs()))
    }

    /// The most energy that both sides together have given out at any time, J: above 0 the coupling is not passive.
    pub fn most_given_out(&self) -> f64 {
        self.0.iter().map(|[one, two]| one.given_out + two.given_out).fold(0.0, f64::max)
    }

    /// The most energy that a side gave out in one tick, J.
    pub fn most_in_a_tick(&self) -> f64 {
        let steps = self
            .0
            .windows(2)
            .flat_map(|pair| [0, 1].map(|side| pair[1][side].given_out - pair[0][side].given_out));
        steps.fold(0.0, f64::max)
    }

    /// The mean distance of a handle to the target after the first second, mm.
    pub fn tracking_error(&self, side: usize) -> f64 {
        let errors = self.0.iter().enumerate().skip(1000).map(|(n, ticks)| {
            let ([x, y], [u, v]) = (ticks[side].motion.position, target(n as f64 * PERIOD));
            (x - u).hypot(y - v)
        });
        1e3 * errors.sum::<f64>() / (self.0.len() - 1000) as f64
    }

    pub fn limited_share(&self) -> f64 {
        let [one, _] = self.0.last().unwrap();
        one.report.limited_ticks as f64 / one.report.ticks.max(1) as f64
    }
}

/// One way of the network of a case; both ways draw from the same random numbers.
#[derive(Debug)]
struct Link {
    case: Case,
    random: Rc<RefCell<ChaCha8Rng>>,
    /// The tick at which each packet is due, in the order of sending.
    travelling: VecDeque<(usize, Datagram)>,
}

fn tick_at(now: LocalTime) -> usize {
    (now.seconds() / PERIOD).round() as usize
}

impl Channel for Link {
    fn send(&mut self, now: LocalTime, packet: Datagram) {
        let Case { delay, jitter, loss, blackout, .. } = self.case;
        let (n, mut random) = (tick_at(now), self.random.borrow_mut());
        let late = random.random_range(0..=jitter);
        let dark = blackout.is_some_and(|(from, to)| (from..to).contains(&n));
        if random.random::<f64>() >= loss && !dark {
            self.travelling.push_back((n + delay + late, packet));
        }
    }

    fn deliver(&mut self, now: LocalTime) -> Option<Datagram> {
        let place = self.travelling.iter().position(|(due, _)| *due <= tick_at(now))?;
        self.travelling.remove(place).map(|(_, packet)| packet)
    }
}

/// Runs a pair of strategies through a case; it stops where a handle is 100 m away.
pub fn run(case: &Case, strategies: [StrategyChoice; 2]) -> Course {
    let random = Rc::new(RefCell::new(ChaCha8Rng::seed_from_u64(7)));
    let playout = PlayoutSettings::Fixed { delay: Span(case.playout as i64 * 1_000_000) };
    let (mass, damping) = (hman_mass(), hman_damping());
    let watchdog = case.blackout.map(|_| WatchdogSettings::default());
    let mut sides = 0..2;
    let mut stations = strategies.map(|strategy| {
        let side = sides.next().unwrap();
        let settings = EndpointSettings::new(side as u64 + 1, spring_law(), Span(0));
        let endpoint = Endpoint::new(EndpointSettings { strategy, playout, watchdog, ..settings }).unwrap();
        let plants = [0, 1]
            .map(|axis| AxisPlant::new(mass[side][axis], damping[side][axis], case.hands[side], PERIOD));
        let link = Link { case: *case, random: random.clone(), travelling: VecDeque::new() };
        Station::new(plants, endpoint, Box::new(link))
    });
    stations[0].plants[0].velocity = case.velocity;
    let mut given_out = [0.0; 2];
    let mut course = Vec::new();
    for n in 0..(case.seconds / PERIOD).round() as usize {
        let now = LocalTime(n as u64 * 1_000_000);
        measure_and_send(&mut stations, now);
        let hand = if case.follows { target(n as f64 * PERIOD) } else { [0.0; 2] };
        let ticks = [0, 1].map(|side| {
            let station = &mut stations[side];
            let force = station.answer(now, |_, is_taken| assert!(is_taken));
            let report = station.endpoint.report().strategy;
            Tick { motion: station.measured, force, report, given_out: given_out[side] }
        });
        course.push(ticks);
        for side in 0..2 {
            let held = [0, 1].map(|axis| {
                let pull = if (side, axis) == (0, 0) && n >= 1000 { case.pull } else { 0.0 };
                let slip = if side == 1 { case.disturbance } else { 0.0 };
                let (rate, phase) = [(4.1, 0.3), (5.3, 1.0)][axis];
                let slip = slip * (rate * n as f64 * PERIOD + phase).cos();
                case.hands[side] * hand[axis] + pull + slip
            });
            let steps = stations[side].advance(ticks[side].force, held);
            given_out[side] += steps.iter().map(|step| step.work).sum::<f64>();
        }
        let mut plants = stations.iter().flat_map(|station| &station.plants);
        if plants.any(|plant| plant.position.abs() > 100.0) {
            break;
        }
    }
    Course(course)
}

/// A strategy of every kind for the two H-MANs, at the same stiffness, for ages of at most `age` s each way.
pub fn pair(kind: &str, age: f64) -> [StrategyChoice; 2] {
    let law = spring_law();
    let damping = hman_damping();
    [0, 1].map(|side: usize| match kind {
        "spring" => StrategyChoice::Spring(Spring::new(law)),
        "guard" => {
            let settings = AccountSettings::new(law.stiffness, damping[side]);
            StrategyChoice::Guard(Guard::new(law, settings).unwrap())
        }
        "injected damping" => {
            let settings = InjectedDampingSettings {
                own_damping: damping[side],
                partner_damping: damping[1 - side],
                round_trip: 2.0 * age,
                own_age: PERIOD,
            };
            StrategyChoice::InjectedDamping(InjectedDamping::new(law.stiffness, settings).unwrap())
        }
        "wave variables" => {
            let settings = WaveSettings::new(law.stiffness, 10.0);
            StrategyChoice::WaveVariables(WaveVariables::new(settings).unwrap())
        }
        "time-domain passivity" => {
            StrategyChoice::TimeDomainPassivity(TimeDomainPassivity::new(law, 100.0).unwrap())
        }
        "two layers" => {
            let settings = TankSettings::new(law.stiffness);
            StrategyChoice::TwoLayer(TwoLayer::new(law, settings).unwrap())
        }
        "set-position modulation" => {
            let settings = SetPositionSettings::new(law.stiffness, 5.0);
            StrategyChoice::SetPositionModulation(SetPositionModulation::new(settings).unwrap())
        }
        _ => unreachable!("{kind}"),
    })
}

/// All kinds but the bare spring.
pub const KINDS: [&str; 6] = [
    "guard",
    "injected damping",
    "wave variables",
    "time-domain passivity",
    "two layers",
    "set-position modulation",
];
