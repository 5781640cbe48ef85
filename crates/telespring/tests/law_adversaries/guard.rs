//! The guard under every adversary: two H-MANs, each driven by an endpoint, one of them pulled for a second and let go.

use telespring::rig::{Adversary, NetworkModel};
use telespring::session::strategy::{Guard, Spring, StrategyChoice};
use telespring::session::{AccountSettings, Endpoint, EndpointSettings, Law, LocalTime, Motion, Span};

use crate::withstand_common::plant::AxisPlant;

const PERIOD: f64 = 1e-3;
/// The one-way delay, s.
const DELAY: f64 = 0.05;
/// How long both handles are watched, s.
const SECONDS: usize = 30;

/// What a run shows.
#[derive(Debug, Clone, Copy, Default)]
struct Course {
    /// The largest distance of a handle from the start along an axis, m.
    farthest: f64,
    /// The largest speed along an axis in the last second, m/s.
    last_speed: f64,
    /// The largest force relative to √(2 k S), at any tick.
    force: f64,
    /// The energy that a side gave out beyond what its account can have had, J, at any tick; at most 0.
    beyond: f64,
    /// The energy that the sides took in from each other, J.
    received: f64,
}

/// Two H-MANs coupled through endpoints over a network with an adversary each way.
fn run(kind: Adversary, law: Law, strategy: impl Fn(usize, [f64; 2]) -> StrategyChoice) -> Course {
    let hman = telespring::hman();
    let least = hman.robots().each_ref().map(|robot| [robot.damping()[0], robot.damping()[1]]);
    let mut plants = [0, 1].map(|side| {
        let robot = &hman.robots()[side];
        [0, 1].map(|axis| AxisPlant::new(robot.mass()[axis], robot.damping()[axis], 0.0, PERIOD))
    });
    let mut sides = [0, 1].map(|side| {
        let settings = EndpointSettings::new(side as u64 + 1, law, Span::from_seconds(DELAY));
        let strategy = strategy(side, least[side]);
        Endpoint::new(EndpointSettings { strategy, watchdog: None, ..settings }).unwrap()
    });
    let network = NetworkModel { adversary: Some(kind), ..NetworkModel::ideal() };
    network.check().unwrap();
    let mut links = [0, 1].map(|side| network.channel(Span::from_seconds(DELAY - PERIOD), 1, side));
    let mut course = Course { beyond: f64::NEG_INFINITY, ..Course::default() };
    // the energy given out at the plant, and what its damping took
    let (mut given_out, mut lost) = ([0.0; 2], [0.0; 2]);
    for n in 0..SECONDS * 1000 {
        let now = LocalTime(n as u64 * 1_000_000);
        let motions = plants.each_ref().map(|plant| Motion {
            position: [0, 1].map(|axis| plant[axis].position),
            velocity: [0, 1].map(|axis| plant[axis].velocity),
        });
        for side in 0..2 {
            sides[side].handle_measurement(now, motions[side]).unwrap();
            links[1 - side].send(now, sides[side].poll_transmit(now).unwrap());
        }
        for side in 0..2 {
            links[side].observe(motions[side]);
            while let Some(packet) = links[side].deliver(now) {
                // a lie that is no packet of the partner is refused
                let _ = sides[side].handle_datagram(now, &packet);
            }
            let force = sides[side].force(now);
            let report = sides[side].report().strategy;
            if let Some(balance) = report.balance {
                let most = (2.0 * law.stiffness * balance.max(0.0)).sqrt();
                let size = force[0].hypot(force[1]);
                course.force = course.force.max(if size > 0.0 { size / most } else { 0.0 });
                let settings = AccountSettings::new(law.stiffness, least[side]);
                let had = settings.capacity + settings.share * lost[side] + report.energy_received;
                course.beyond = course.beyond.max(given_out[side] - had + report.energy_sent);
                assert!(report.energy_received <= settings.intake * now.seconds() * (1.0 + 1e-9) + 1e-9);
            }
            for axis in 0..2 {
                let pull = if side == 0 && (1000..2000).contains(&n) { [5.0, -3.0][axis] } else { 0.0 };
                let (moved, squares) = plants[side][axis].advance(force[axis] + pull);
                given_out[side] += force[axis] * moved;
                lost[side] += least[side][axis] * squares;
                course.farthest = course.farthest.max(plants[side][axis].position.abs());
                if n >= (SECONDS - 1) * 1000 {
                    course.last_speed = course.last_speed.max(plants[side][axis].velocity.abs());
                }
            }
        }
        if course.farthest > 10.0 {
            break;
        }
    }
    course.received = sides.iter().map(|side| side.report().strategy.energy_received).sum();
    course
}

fn guarded(kind: Adversary, stiffness: f64) -> Course {
    let law = Law { stiffness, damping: 0.0 };
    run(kind, law, |_, least| {
        StrategyChoice::Guard(Guard::new(law, AccountSettings::new(stiffness, least)).unwrap())
    })
}

fn bare(kind: Adversary, stiffness: f64) -> Course {
    let law = Law { stiffness, damping: 0.0 };
    run(kind, law, |_, _| StrategyChoice::Spring(Spring::new(law)))
}

/// The adversaries that tell no lie about energy.
pub const HONEST_ABOUT_ENERGY: [Adversary; 5] = [
    Adversary::OldestSample { memory: 1.0 },
    Adversary::MostHarmfulSample { memory: 1.0 },
    Adversary::StretchTimed { longest: 1.0 },
    Adversary::LyingPeer { position: 0.1, stamp: -0.2, power: 0.0 },
    Adversary::LyingPeer { position: 0.02, stamp: 0.03, power: 0.0 },
];

/// One that lies about everything.
pub const LIAR: Adversary = Adversary::LyingPeer { position: 0.05, stamp: -0.1, power: 5.0 };

#[test]
fn law_under_guard_every_adversary_leaves_robots_near_and_at_rest() {
    for stiffness in [142.0, 2000.0] {
        for kind in HONEST_ABOUT_ENERGY {
            let (guard, spring) = (guarded(kind, stiffness), bare(kind, stiffness));
            println!(
                "{kind:?}, {stiffness} N/m: guard {guard:?}, bare spring {:.2} m, {:.2} m/s",
                spring.farthest, spring.last_speed
            );
            // a lie of some centimetres keeps the spring swinging, the others make it grow without end
            let swings = spring.farthest > 10.0 || spring.last_speed > 0.1;
            assert!(swings, "{kind:?}, {stiffness}: {spring:?}");
            assert!(guard.farthest < 1.0 && guard.last_speed < 1e-3, "{kind:?}, {stiffness}: {guard:?}");
            // the overdraft of a held force, ½ k |Δx|² at 1 m/s
            assert!(guard.beyond < 0.5 * stiffness * 1e-6, "{kind:?}, {stiffness}: {guard:?}");
            assert!(guard.force < 1.0 + 1e-12, "{kind:?}, {stiffness}: {guard:?}");
        }
    }
}

#[test]
fn law_a_partner_that_lies_about_everything_gets_no_more_than_the_intake() {
    for stiffness in [142.0, 2000.0] {
        let kind = LIAR;
        let (guard, spring) = (guarded(kind, stiffness), bare(kind, stiffness));
        println!(
            "{kind:?}, {stiffness} N/m: guard {guard:?}, bare spring {:.2} m, {:.2} m/s",
            spring.farthest, spring.last_speed
        );
        assert!(guard.force < 1.0 + 1e-12 && guard.beyond < 0.5 * stiffness * 1e-6, "{guard:?}");
        // it goes on moving with what it takes in, but no farther
        assert!(guard.farthest < 2.0, "{guard:?}");
    }
}
