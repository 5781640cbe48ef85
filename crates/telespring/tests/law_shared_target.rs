//! What flattens the tracking errors of guard and shared target where hands and spring resonate (docs/prediction.md).

#![allow(clippy::disallowed_macros, reason = "the tests print what they measure")]

use telespring::Delay;
use telespring::InvalidInput;
use telespring::rig::{Agent, ConnectedMode, Laboratory, Recording, Schedule, Status, Trial};
use telespring::session::SessionReport;
use telespring::session::architecture::{Architecture, GuardDesign, PredictorDesign, StrategyDesign};

const PERIOD: f64 = 1e-3;
/// Trials of a condition.
const SEEDS: u64 = 2;

/// One condition: the coupling, the strategy, and the stiffness of both hands.
#[derive(Debug, Clone, Copy)]
struct Condition {
    stiffness: f64,
    damping: f64,
    delay: f64,
    strategy: StrategyDesign,
    predictor: PredictorDesign,
    hands: [f64; 2],
}

/// Guard and shared target, no damper, the paper's hands.
fn guarded(stiffness: f64, delay: f64) -> Condition {
    Condition {
        stiffness,
        damping: 0.0,
        delay,
        strategy: StrategyDesign::Guard(GuardDesign::default()),
        predictor: PredictorDesign::SharedTarget,
        hands: [120.0; 2],
    }
}

fn recorded(condition: &Condition, seed: u64) -> Recording {
    let mut laboratory = Laboratory::paper();
    for (station, hand) in laboratory.stations.iter_mut().zip(condition.hands) {
        match &mut station.agent {
            Agent::Skilled { stiffness, .. } | Agent::Blurred { stiffness, .. } => *stiffness = hand,
            Agent::External => unreachable!("the paper has two agents"),
        }
    }
    laboratory.session.architecture = Architecture {
        strategy: condition.strategy,
        predictor: condition.predictor,
        ..Architecture::default()
    };
    let coupling = ConnectedMode {
        stiffness: condition.stiffness,
        damping: condition.damping,
        delay: Delay::each_way(condition.delay).unwrap(),
    };
    let schedule = Schedule::new(29.0, 100.0, PERIOD).unwrap();
    let trial = Trial { laboratory: &laboratory, coupling: Some(coupling), seed, schedule };
    trial.record::<InvalidInput>([None, None]).unwrap()
}

/// The share of ticks at which a side was limited.
fn limited_share(session: &SessionReport) -> f64 {
    session.strategy.limited_ticks as f64 / session.strategy.ticks.max(1) as f64
}

/// The mean distance of each handle to the target after the first second, m, and the share of limited ticks.
fn errors(condition: &Condition) -> ([f64; 2], f64) {
    let (mut sums, mut count, mut limited) = ([0.0; 2], 0.0, 0.0);
    for seed in 0..SEEDS {
        let recording = recorded(condition, seed);
        if recording.outcome.status != Status::Completed {
            return ([f64::INFINITY; 2], f64::NAN);
        }
        for (row, target) in recording.position.iter().zip(&recording.target).skip(100) {
            for (sum, position) in sums.iter_mut().zip(row) {
                *sum += (position[0] - target[0]).hypot(position[1] - target[1]);
            }
            count += 1.0;
        }
        if let Some(sessions) = &recording.outcome.sessions {
            limited += sessions.iter().map(limited_share).sum::<f64>() / 2.0;
        }
    }
    (sums.map(|sum| sum / count), limited / SEEDS as f64)
}

/// The larger of both tracking errors over that without delay and damper, and the share of limited ticks.
fn ratio(condition: &Condition) -> (f64, f64) {
    let (undelayed, _) = errors(&Condition { delay: 0.0, damping: 0.0, ..*condition });
    ratio_to(undelayed, condition)
}

fn ratio_to(undelayed: [f64; 2], condition: &Condition) -> (f64, f64) {
    let (delayed, limited) = errors(condition);
    ((delayed[0] / undelayed[0]).max(delayed[1] / undelayed[1]), limited)
}

const DELAYS: [f64; 13] = [0.02, 0.05, 0.084, 0.1, 0.11, 0.12, 0.13, 0.14, 0.167, 0.2, 0.25, 0.3, 0.334];

/// Near 130 ms hands and spring resonate at 142 N/m, and the guard has much to do. A damper of 1 N·s/m beside the spring
/// takes the resonance away: the loop is then stable with these hands at every delay (`tests/test_prediction.py`).
#[test]
fn law_a_small_damper_in_the_coupling_flattens_the_errors() {
    let (undelayed, _) = errors(&guarded(142.0, 0.0));
    for delay in [0.05, 0.084, 0.13, 0.167, 0.334] {
        let plain = ratio_to(undelayed, &guarded(142.0, delay));
        let damped = ratio_to(undelayed, &Condition { damping: 1.0, ..guarded(142.0, delay) });
        println!("{delay} s: {plain:.3?}, with a damper {damped:.3?}");
        assert!(damped.0 < 1.0 && damped.1 < 0.1, "{delay} s: {damped:?}");
        assert!(plain.0 < 1.35 && (delay != 0.13 || plain.0 > 1.15), "{delay} s: {plain:?}");
    }
}

#[test]
#[ignore = "prints the maps of docs/prediction.md"]
fn law_map_of_the_tracking_errors_with_a_shared_target() {
    let print = |label: &str, condition: &dyn Fn(f64) -> Condition| {
        let cells: Vec<String> = DELAYS
            .iter()
            .map(|&delay| {
                let (ratio, limited) = ratio(&condition(delay));
                format!("{ratio:.2} ({:.0})", 100.0 * limited)
            })
            .collect();
        println!("{label} | {}", cells.join(" | "));
    };
    println!("delays {DELAYS:?}");
    for stiffness in [36.0, 71.0, 107.0, 142.0, 178.0, 214.0] {
        print(&format!("{stiffness} N/m"), &|delay| guarded(stiffness, delay));
    }
    for damping in [0.5, 1.0, 2.0, 4.0] {
        print(&format!("142 N/m, damper {damping}"), &|delay| Condition { damping, ..guarded(142.0, delay) });
    }
    for (name, design) in [
        ("share 0.5", GuardDesign { share: 0.5, ..GuardDesign::default() }),
        ("share 0.95", GuardDesign { share: 0.95, ..GuardDesign::default() }),
        ("capacity 0.01 J", GuardDesign { capacity: 0.01, ..GuardDesign::default() }),
        ("capacity 0.2 J", GuardDesign { capacity: 0.2, ..GuardDesign::default() }),
        ("intake 0", GuardDesign { intake: 0.0, ..GuardDesign::default() }),
        ("intake 0.05 W", GuardDesign { intake: 0.05, ..GuardDesign::default() }),
        ("intake 1 W", GuardDesign { intake: 1.0, ..GuardDesign::default() }),
    ] {
        print(&format!("142 N/m, {name}"), &|delay| Condition {
            strategy: StrategyDesign::Guard(design),
            ..guarded(142.0, delay)
        });
    }
    print("142 N/m, bare spring", &|delay| Condition {
        strategy: StrategyDesign::Spring,
        ..guarded(142.0, delay)
    });
    print("142 N/m, hands of 240 N/m", &|delay| Condition { hands: [240.0; 2], ..guarded(142.0, delay) });
    print("142 N/m, hands of 60 N/m", &|delay| Condition { hands: [60.0; 2], ..guarded(142.0, delay) });
}
