//! Every architecture in the laboratory against two endpoints that a program of its own drives: strategies made by hand,
//! exact plants, a queue of packets.

use std::collections::VecDeque;

use telespring::rig::{Agent, ConnectedMode, Laboratory, Recording, Schedule, Status, Trial};
use telespring::session::architecture::{
    Architecture, GuardDesign, PlayoutDesign, PredictorDesign, StrategyDesign, TwoLayerDesign,
};
use telespring::session::predictor::{
    Hold, Kalman, Linear, MotionModel, Noise, PredictorChoice, SharedTarget,
};
use telespring::session::strategy::{
    Guard, InjectedDamping, InjectedDampingSettings, SetPositionModulation, SetPositionSettings, Spring,
    StrategyChoice, TankSettings, TimeDomainPassivity, TwoLayer, WaveSettings, WaveVariables,
};
use telespring::session::{
    AccountSettings, AdaptiveDelay, Endpoint, EndpointSettings, Law, LocalTime, Motion, PlayoutSettings, Span,
};
use telespring::{Delay, InvalidInput};

const PERIOD: f64 = 1e-3;
const STIFFNESS: f64 = 142.0;
const DELAY: f64 = 0.084;
/// Stiffness (N/m) and damping (N·s/m) of both agents.
const AGENTS: [[f64; 2]; 2] = [[120.0, 0.0]; 2];

fn laboratory(architecture: Architecture) -> Laboratory {
    let mut laboratory = Laboratory::paper();
    for (station, [stiffness, damping]) in laboratory.stations.iter_mut().zip(AGENTS) {
        station.agent = Agent::Skilled { stiffness, damping };
    }
    laboratory.session.architecture = architecture;
    laboratory
}

fn coupling(stiffness: f64, delay: f64) -> Option<ConnectedMode> {
    Some(ConnectedMode { stiffness, damping: 0.0, delay: Delay::each_way(delay).unwrap() })
}

fn rehearsed(architecture: Architecture, stiffness: f64, delay: f64, seconds: f64) -> Recording {
    let laboratory = laboratory(architecture);
    let schedule = Schedule::new(seconds, 100.0, PERIOD).unwrap();
    let coupling = coupling(stiffness, delay);
    let trial = Trial { laboratory: &laboratory, coupling, seed: 1, schedule };
    trial.record::<InvalidInput>([None, None]).unwrap()
}

/// Strategy and predictor of one side, from their own settings.
fn choices(label: &str, side: usize) -> (StrategyChoice, PredictorChoice) {
    let law = Law { stiffness: STIFFNESS, damping: 0.0 };
    let robots = telespring::hman();
    let damping = |side: usize| [0, 1].map(|axis| robots.robots()[side].damping()[axis]);
    let (strategy, predictor) = label.split_once(" + ").unwrap_or((label, "hold"));
    let strategy = match strategy.split(',').next().unwrap() {
        "spring" => StrategyChoice::Spring(Spring::new(law)),
        "guard" => {
            let settings = AccountSettings::new(STIFFNESS, damping(side));
            StrategyChoice::Guard(Guard::new(law, settings).unwrap())
        }
        "injected-damping" => {
            let settings = InjectedDampingSettings {
                own_damping: damping(side),
                partner_damping: damping(1 - side),
                round_trip: 2.0 * (DELAY + PERIOD),
                own_age: PERIOD,
            };
            StrategyChoice::InjectedDamping(InjectedDamping::new(STIFFNESS, settings).unwrap())
        }
        "wave-variables" => {
            let settings = WaveSettings::new(STIFFNESS, 10.0);
            StrategyChoice::WaveVariables(WaveVariables::new(settings).unwrap())
        }
        "time-domain-passivity" => {
            StrategyChoice::TimeDomainPassivity(TimeDomainPassivity::new(law, 100.0).unwrap())
        }
        "two-layer" => StrategyChoice::TwoLayer(TwoLayer::new(law, TankSettings::new(STIFFNESS)).unwrap()),
        "set-position-modulation" => {
            let settings = SetPositionSettings::new(STIFFNESS, 5.0);
            StrategyChoice::SetPositionModulation(SetPositionModulation::new(settings).unwrap())
        }
        other => panic!("{other}"),
    };
    let noise = Noise { process: 100.0, position: 1e-5 };
    let predictor = match predictor {
        "hold" => PredictorChoice::Hold(Hold),
        "linear" => PredictorChoice::Linear(Linear),
        "kalman" => PredictorChoice::Kalman(Kalman::new(MotionModel::ConstantAcceleration, noise).unwrap()),
        "shared-target" => PredictorChoice::SharedTarget(SharedTarget),
        other => panic!("{other}"),
    };
    (strategy, predictor)
}

/// One robot: m v' = F − b v for a held force, exactly.
struct Robot {
    mass: [f64; 2],
    damping: [f64; 2],
    motion: Motion,
}

impl Robot {
    fn advance(&mut self, force: [f64; 2]) {
        for axis in 0..2 {
            let (m, b) = (self.mass[axis], self.damping[axis]);
            let (x, v, still) = (self.motion.position[axis], self.motion.velocity[axis], force[axis] / b);
            let faded = -(-b / m * PERIOD).exp_m1();
            self.motion.position[axis] = x + still * PERIOD + (v - still) * m / b * faded;
            self.motion.velocity[axis] = v - (v - still) * faded;
        }
    }
}

fn target(time: f64) -> Motion {
    let w = 2.59;
    Motion {
        position: [0.05 * (2.0 * w * time).sin(), 0.1 * (w * time).sin()],
        velocity: [0.1 * w * (2.0 * w * time).cos(), 0.1 * w * (w * time).cos()],
    }
}

/// Positions and balances at every tick, until a handle is 10 m away.
fn driven(label: &str, seconds: f64) -> Vec<[(Motion, f64); 2]> {
    let playout = if label.ends_with("adaptive") {
        PlayoutSettings::Adaptive(AdaptiveDelay::default())
    } else {
        PlayoutSettings::Fixed { delay: Span::from_seconds(DELAY) }
    };
    let robots = telespring::hman();
    let mut sides = [0, 1].map(|side| {
        let (strategy, predictor) = choices(label, side);
        let law = Law { stiffness: STIFFNESS, damping: 0.0 };
        let settings = EndpointSettings::new(side as u64 + 7, law, Span(0));
        let settings = EndpointSettings { strategy, predictor, playout, watchdog: None, ..settings };
        let robot = &robots.robots()[side];
        let per_axis = |values: &[f64]| [values[0], values[1]];
        let motion = Motion { velocity: [0.0; 2], ..target(0.0) };
        let robot = Robot { mass: per_axis(robot.mass()), damping: per_axis(robot.damping()), motion };
        (Endpoint::new(settings).unwrap(), robot)
    });
    let mut travelling = [VecDeque::new(), VecDeque::new()];
    let mut course = Vec::new();
    for n in 0..=(seconds / PERIOD).round() as usize {
        let now = LocalTime(n as u64 * 1_000_000);
        let aim = target(n as f64 * PERIOD);
        for (side, (endpoint, robot)) in sides.iter_mut().enumerate() {
            endpoint.handle_measurement(now, robot.motion).unwrap();
            endpoint.handle_target(now, aim);
            // 83 ms under way: what is sent in one tick is there at the end of another
            travelling[1 - side].push_back((n + 83, endpoint.poll_transmit(now).unwrap()));
        }
        let mut ticks = [(Motion { position: [0.0; 2], velocity: [0.0; 2] }, 0.0); 2];
        for (side, (endpoint, robot)) in sides.iter_mut().enumerate() {
            while travelling[side].front().is_some_and(|(due, _)| *due <= n) {
                let (_, packet) = travelling[side].pop_front().unwrap();
                endpoint.handle_datagram(now, &packet).unwrap();
            }
            let coupling = endpoint.force(now);
            ticks[side] = (robot.motion, endpoint.report().strategy.balance.unwrap_or(f64::NAN));
            let [k, b] = AGENTS[side];
            robot.advance([0, 1].map(|axis| {
                let pulled = k * (aim.position[axis] - robot.motion.position[axis]);
                coupling[axis] + pulled + b * (aim.velocity[axis] - robot.motion.velocity[axis])
            }));
        }
        course.push(ticks);
        if ticks.iter().any(|(motion, _)| motion.position.iter().any(|x| x.abs() > 10.0)) {
            break;
        }
    }
    course
}

/// The largest distance of a handle from the origin along an axis, m.
fn farthest(recording: &Recording) -> f64 {
    recording.position.iter().flatten().flatten().fold(0.0, |most: f64, x| most.max(x.abs()))
}

#[test]
fn cross_every_architecture_runs_in_the_laboratory_as_on_its_own() {
    let seconds = 60.0;
    for architecture in Architecture::usual() {
        let label = architecture.label();
        let recording = rehearsed(architecture, STIFFNESS, DELAY, seconds);
        let course = driven(&label, seconds);
        let mut worst = [0.0_f64; 2];
        let has_account = architecture.strategy.has_account();
        assert_eq!(recording.account.len(), if has_account { recording.outcome.rows } else { 0 }, "{label}");
        for (row, positions) in recording.position.iter().enumerate() {
            for side in 0..2 {
                let (motion, balance) = course[10 * row][side];
                for axis in 0..2 {
                    let (here, there) = (positions[side][axis], motion.position[axis]);
                    worst[0] = worst[0].max((here - there).abs() / (0.1 + there.abs()));
                }
                assert_eq!(has_account, !balance.is_nan(), "{label}");
                if let Some(account) = recording.account.get(row) {
                    worst[1] = worst[1].max((account[side] - balance).abs() / (0.05 + balance.abs()));
                }
            }
        }
        assert!(worst.iter().all(|difference| *difference < 1e-7), "{label}: {worst:?}");
        assert_eq!(recording.outcome.status, Status::Completed, "{label}");
        if label.starts_with("spring") {
            assert!(
                farthest(&recording) > 0.5,
                "{label}: it runs away, ten times the hands' amplitude along x"
            );
        } else {
            assert!(farthest(&recording) < 0.3, "{label}");
        }
    }
}

/// What each side reports, where it can be told without the laboratory.
#[test]
fn law_a_trial_reports_what_both_sides_did() {
    let guard = StrategyDesign::Guard(GuardDesign::default());
    let architecture = Architecture { strategy: guard, ..Architecture::default() };
    let recording = rehearsed(architecture, STIFFNESS, DELAY, 5.0);
    let [one, two] = recording.outcome.sessions.unwrap();
    let ticks = 5_001;
    assert_eq!((one.sent, two.sent), (ticks, ticks));
    for side in [one, two] {
        assert_eq!(side.strategy.ticks, ticks - 84, "the first motion is played at 84 ms");
        let ages = side.playout.ages.unwrap();
        assert_eq!((ages.smallest, ages.largest), (Span::from_seconds(DELAY), Span::from_seconds(DELAY)));
        assert_eq!((side.playout.held_ticks, side.playout.lost), (0, 0));
    }
    // the observer of both handles, and the accounts of both sides: the same energy, but for the last tick
    let given_out = one.strategy.given_out + two.strategy.given_out;
    assert!((given_out + recording.outcome.coupling_energy.total).abs() < 1e-3, "{given_out}");
    assert_eq!(recording.account[0], [0.05; 2]);
    assert_eq!(recording.account.len(), recording.outcome.rows);
    let laboratory = laboratory(architecture);
    let schedule = Schedule::new(1.0, 100.0, PERIOD).unwrap();
    let alone = Trial { laboratory: &laboratory, coupling: None, seed: 1, schedule };
    let alone = alone.record::<InvalidInput>([None, None]).unwrap();
    assert_eq!(alone.outcome.sessions, None);
    assert!(alone.account.is_empty());
}

/// Play-outs of their own over the same delay, and what a playout buffer waits for.
#[test]
fn law_the_play_out_is_the_condition_s_delay_its_own_or_the_latest_motion() {
    let age = |playout: PlayoutDesign, has_playout_buffer: bool| {
        let mut laboratory = laboratory(Architecture { playout, ..Architecture::default() });
        laboratory.session.has_playout_buffer = has_playout_buffer;
        laboratory.session.lateness = [0.013, 0.02];
        let schedule = Schedule::new(2.0, 100.0, PERIOD).unwrap();
        let coupling = coupling(20.0, 0.03);
        let trial = Trial { laboratory: &laboratory, coupling, seed: 1, schedule };
        let recording = trial.record::<InvalidInput>([None, None]).unwrap();
        let ages = recording.outcome.sessions.unwrap().map(|side| side.playout.ages.unwrap());
        assert!(ages.iter().all(|each| each.smallest == each.largest), "{ages:?}");
        ages.map(|each| each.mean)
    };
    let fixed = |delay| PlayoutDesign::Fixed { delay };
    assert_eq!(age(fixed(None), false), [Span(30_000_000); 2]);
    // robot 1 receives backward, robot 2 forward
    assert_eq!(age(fixed(None), true), [Span(50_000_000), Span(43_000_000)]);
    assert_eq!(age(fixed(Some(0.1)), false), [Span(100_000_000); 2]);
    assert_eq!(age(fixed(Some(0.1)), true), [Span(100_000_000); 2]);
}

#[test]
fn law_an_architecture_that_cannot_run_is_refused() {
    let refused = |architecture: Architecture, damping: f64| {
        let laboratory = laboratory(architecture);
        let coupling = ConnectedMode { damping, ..coupling(STIFFNESS, DELAY).unwrap() };
        let schedule = Schedule::new(1.0, 100.0, PERIOD).unwrap();
        let trial = Trial { laboratory: &laboratory, coupling: Some(coupling), seed: 1, schedule };
        trial.record::<InvalidInput>([None, None]).map(|_| ()).map_err(|refusal| refusal.field)
    };
    for strategy in StrategyDesign::KINDS.into_iter().filter_map(StrategyDesign::of_kind) {
        let architecture = Architecture { strategy, ..Architecture::default() };
        let with_damper =
            if strategy.has_coupling_damper() { Ok(()) } else { Err("coupling_damping".to_owned()) };
        assert_eq!(refused(architecture, 1.0), with_damper, "{}", strategy.kind());
        assert_eq!(refused(architecture, 0.0), Ok(()), "{}", strategy.kind());
    }
    let with = |strategy| Architecture { strategy, ..Architecture::default() };
    let share = StrategyDesign::Guard(GuardDesign { share: 1.0, ..GuardDesign::default() });
    assert_eq!(refused(with(share), 0.0), Err("share".to_owned()));
    let saturation =
        StrategyDesign::TwoLayer(TwoLayerDesign { saturation: 1e9, ..TwoLayerDesign::default() });
    assert_eq!(refused(with(saturation), 0.0), Err("saturation".to_owned()));
    let predictor = PredictorDesign::of_kind("kalman").unwrap();
    assert_eq!(refused(Architecture { predictor, ..Architecture::default() }, 0.0), Ok(()));
}

/// A target given by samples has the velocity between two of them; with a damper in the coupling it enters the force.
#[test]
fn law_a_sampled_target_is_shared_like_the_one_of_a_formula() {
    let architecture = Architecture {
        strategy: StrategyDesign::Guard(GuardDesign::default()),
        predictor: PredictorDesign::SharedTarget,
        ..Architecture::default()
    };
    let run = |sampled: bool| {
        let mut laboratory = laboratory(architecture);
        if sampled {
            let times: Vec<f64> = (0..=10_000).map(|n| f64::from(n) * PERIOD).collect();
            let positions = telespring::rig::figure_eight_positions([0.05, 0.1], 2.59, &times);
            laboratory.target = telespring::rig::Target::Sampled(positions);
        }
        let coupling = ConnectedMode { damping: 3.0, ..coupling(STIFFNESS, DELAY).unwrap() };
        let schedule = Schedule::new(10.0, 100.0, PERIOD).unwrap();
        let trial = Trial { laboratory: &laboratory, coupling: Some(coupling), seed: 1, schedule };
        trial.record::<InvalidInput>([None, None]).unwrap()
    };
    let (formula, samples) = (run(false), run(true));
    let places = |recording: &Recording| recording.position.concat().concat();
    let apart = places(&formula).iter().zip(places(&samples)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    // the velocity is half a period ahead: 3 N·s/m · 0.5 ms · 2.7 m/s² against the stiffness of hand and spring
    assert!(apart > 0.0 && apart < 1e-4, "{apart}");
}
