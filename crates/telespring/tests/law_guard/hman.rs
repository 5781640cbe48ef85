//! What the guard does with the paper's two H-MANs.

use crate::support::{Case, CaseSide, Law as Broken, Network, Outcome, PredictorKind, run, target};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use telespring::session::strategy::{Guard, Spring, Strategy};
use telespring::session::{AccountSettings, Law};

const EVERY_LAW: &[Broken] = &[
    Broken::Plant,
    Broken::Force,
    Broken::Account,
    Broken::Overdraft,
    Broken::Intake,
    Broken::Energy,
    Broken::Bounded,
    Broken::Together,
    Broken::DiesOut,
];

/// The two H-MANs (Table III of Du et al. 2025), each with a hand of this stiffness (N/m) that follows the target.
fn hmans(stiffness: f64, network: Network, agents: [f64; 2], seconds: f64) -> Case {
    let robots = [([0.8334, 1.0649], [7.7257, 10.1168]), ([0.7776, 1.3407], [7.4208, 9.3496])];
    let sides = [0, 1].map(|side: usize| {
        let (mass, damping) = robots[side];
        CaseSide {
            mass,
            damping,
            ground: [agents[side]; 2],
            velocity: [0.0; 2],
            settings: AccountSettings::new(stiffness, damping),
            hand: [(0.0, 0.0, 0.0); 2],
            agent: agents[side],
        }
    });
    Case {
        period: 1e-3,
        ticks: (seconds * 1e3) as usize,
        law: Law { stiffness, damping: 0.0 },
        sides,
        network,
        predictor: PredictorKind::Hold,
        force_limit: f64::INFINITY,
        ramps: 0.0,
        let_go: f64::INFINITY,
        unchecked: &[],
    }
}

fn delay(delay: f64) -> Network {
    Network::Random { delay, jitter: 0.0, loss: 0.0, backwards: false }
}

fn with_guard(case: &Case) -> Outcome {
    let guards = case.sides.each_ref().map(|side| {
        let guard: Box<dyn Strategy> = Box::new(Guard::new(case.law, side.settings).unwrap());
        guard
    });
    run(case, guards, &mut ChaCha8Rng::seed_from_u64(5)).unwrap()
}

fn with_spring(case: &Case) -> Outcome {
    let springs = [(); 2].map(|()| {
        let spring: Box<dyn Strategy> = Box::new(Spring::new(case.law));
        spring
    });
    let case = Case { unchecked: EVERY_LAW, ..*case };
    run(&case, springs, &mut ChaCha8Rng::seed_from_u64(5)).unwrap()
}

/// The mean distance of a handle to the target after the first second, mm.
fn tracking_error(outcome: &Outcome, side: usize) -> f64 {
    let errors = outcome.positions.iter().enumerate().skip(1000).map(|(n, positions)| {
        let aim = target(n as f64 * 1e-3).position;
        (positions[side][0] - aim[0]).hypot(positions[side][1] - aim[1])
    });
    1e3 * errors.sum::<f64>() / (outcome.positions.len() - 1000) as f64
}

/// Two hands that follow the target, the second one less skilled.
fn two_hands(stiffness: f64, seconds: f64) -> Case {
    let mut case = hmans(stiffness, delay(seconds), [120.0; 2], 29.0);
    case.sides[1].hand = [(2.0, 4.1, 0.3), (2.0, 5.3, 1.0)];
    case
}

#[test]
fn law_where_the_spring_is_stable_the_guard_is_the_spring() {
    for (stiffness, seconds) in [(71.0, 0.084), (71.0, 0.167), (142.0, 0.05)] {
        let case = two_hands(stiffness, seconds);
        let (spring, guard) = (with_spring(&case), with_guard(&case));
        assert_eq!(guard.limited, [0.0; 2], "{stiffness} N/m, {seconds} s");
        assert_eq!(guard.positions, spring.positions, "{stiffness} N/m, {seconds} s");
    }
}

#[test]
fn law_where_the_spring_runs_away_the_guard_does_not() {
    let case = two_hands(142.0, 0.12);
    let (spring, guard) = (with_spring(&case), with_guard(&case));
    println!("spring {:.1} mm, guard {:.1} mm", tracking_error(&spring, 0), tracking_error(&guard, 0));
    assert!(spring.farthest > 1.0, "{}", spring.farthest);
    // the figure is 0.1 m large
    assert!(guard.farthest < 0.2, "{}", guard.farthest);
}

/// The tracking errors of both hands at a delay, over those without a delay and without a predictor.
fn relative_errors(stiffness: f64, seconds: f64, predictor: PredictorKind) -> [f64; 2] {
    let case = two_hands(stiffness, seconds);
    let undelayed = with_guard(&Case { network: delay(0.0), ..case });
    let delayed = with_guard(&Case { predictor, ..case });
    [0, 1].map(|side| tracking_error(&delayed, side) / tracking_error(&undelayed, side))
}

#[test]
fn law_with_a_shared_target_the_delay_hardly_costs() {
    for (seconds, most) in [(0.05, 1.1), (0.084, 1.1), (0.12, 1.3), (0.167, 1.1), (0.334, 1.1)] {
        let errors = relative_errors(142.0, seconds, PredictorKind::SharedTarget);
        println!("shared target, {seconds} s: {errors:.3?}");
        assert!(errors.iter().all(|error| *error <= most), "{seconds} s: {errors:?}");
    }
    for (seconds, predictor) in [
        (0.05, PredictorKind::Linear),
        (0.084, PredictorKind::Linear),
        (0.05, PredictorKind::ConstantAcceleration),
        (0.084, PredictorKind::ConstantAcceleration),
    ] {
        println!("{predictor:?}, {seconds} s: {:.3?}", relative_errors(142.0, seconds, predictor));
    }
}

#[test]
fn law_a_steady_pull_is_felt_at_the_other_side() {
    for seconds in [0.1, 0.2] {
        let mut case = hmans(142.0, delay(seconds), [0.0, 300.0], 6.0);
        case.sides[1].agent = 0.0;
        case.sides[0].hand[0] = (10.0, 0.0, 0.0);
        let felt = |case: &Case| {
            let outcome = with_guard(case);
            outcome.positions.iter().map(|positions| 300.0 * positions[1][0]).collect::<Vec<_>>()
        };
        let force = felt(&case);
        println!("{seconds} s: {:.2} N after 2 s, {:.2} N after 6 s", force[2000], force[6000]);
        assert!(force[2000..].iter().all(|&force| force >= 9.5), "{seconds} s");
        // without what the partner sends, the account cannot pay for it
        for side in &mut case.sides {
            side.settings.intake = 0.0;
        }
        let alone = felt(&case);
        println!("  without intake {:.2} N", alone[6000]);
        assert!(alone[6000] < 5.0, "{}", alone[6000]);
    }
}

#[test]
fn law_free_robots_come_to_rest_where_the_spring_diverges() {
    for network in [
        Network::Random { delay: 0.2, jitter: 0.2, loss: 0.02, backwards: false },
        Network::Harmful { span: 1.0 },
    ] {
        for stiffness in [142.0, 2000.0] {
            let mut case = hmans(stiffness, network, [0.0; 2], 12.0);
            case.sides[0].velocity = [0.3, 0.0];
            let (spring, guard) = (with_spring(&case), with_guard(&case));
            println!("{network:?}, {stiffness} N/m: {:.3} m, {:.1e} m/s", guard.farthest, guard.last_speed);
            assert!(spring.farthest > 10.0, "{network:?}, {stiffness} N/m: {}", spring.farthest);
            // 0.3 m/s carry a free H-MAN 3 cm
            assert!(guard.farthest < 0.15, "{network:?}, {stiffness} N/m: {}", guard.farthest);
            assert!(guard.last_speed < 1e-3, "{network:?}, {stiffness} N/m: {}", guard.last_speed);
        }
    }
}

#[test]
#[ignore = "prints the table of docs/guard.md"]
fn law_no_case_of_the_table_breaks_the_account() {
    for (stiffness, seconds) in [
        (71.0, 0.084),
        (71.0, 0.167),
        (142.0, 0.05),
        (142.0, 0.084),
        (142.0, 0.12),
        (142.0, 0.167),
        (142.0, 0.334),
    ] {
        let case = two_hands(stiffness, seconds);
        println!("{stiffness} N/m, {seconds} s: spring {:.1} mm", tracking_error(&with_spring(&case), 0));
        for predictor in [
            PredictorKind::Hold,
            PredictorKind::Linear,
            PredictorKind::ConstantVelocity,
            PredictorKind::ConstantAcceleration,
            PredictorKind::SharedTarget,
        ] {
            let guard = with_guard(&Case { predictor, ..case });
            println!("  {predictor:?} {:.1} mm, limited {:.4}", tracking_error(&guard, 0), guard.limited[0]);
        }
    }
}
