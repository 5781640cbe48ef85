//! Laws of whole trials in the virtual laboratory.

use telespring::rig::{
    Agent, Arm, ConnectedMode, Elbow, Laboratory, Network, NetworkModel, Observation, Recording, Schedule,
    Spots, Status, Target, Trial, TwoLinkArm, trial_seed,
};
use telespring::{Delay, InvalidInput};

fn coupling(stiffness: f64, delay: f64) -> Option<ConnectedMode> {
    Some(ConnectedMode { stiffness, damping: 0.0, delay: Delay::each_way(delay).unwrap() })
}

fn run(laboratory: &Laboratory, coupling: Option<ConnectedMode>, seed: u64, duration: f64) -> Recording {
    laboratory.check().unwrap();
    let schedule = Schedule::new(duration, 1000.0, laboratory.controller.sample_period).unwrap();
    Trial { laboratory, coupling, seed, schedule }.record::<InvalidInput>([None, None]).unwrap()
}

/// Everything that a laboratory can do at once.
fn busy() -> Laboratory {
    let mut laboratory = Laboratory::paper();
    laboratory.network =
        Network::each_way(NetworkModel { jitter: 0.004, loss: 0.05, ..NetworkModel::ideal() });
    laboratory.controller.encoder_resolution = 1e-5;
    laboratory.controller.actuator_lag = 2e-3;
    laboratory.controller.computing_tick = true;
    laboratory.stations[0].arm = Arm::Lumped { mass: [0.5, 0.3], damping: [1.0, 0.0] };
    laboratory.stations[1].handle.coulomb = [0.4, 0.2];
    laboratory
}

#[test]
fn law_a_seed_gives_the_same_bits_and_another_seed_others() {
    for laboratory in [Laboratory::paper(), busy()] {
        let coupling = coupling(71.2, 0.0836);
        let first = run(&laboratory, coupling, 7, 2.0);
        assert_eq!(first, run(&laboratory, coupling, 7, 2.0));
        assert_ne!(first.position, run(&laboratory, coupling, 8, 2.0).position);
    }
}

#[test]
#[expect(clippy::disallowed_methods, reason = "the law is about threads")]
fn law_a_trial_on_another_thread_has_the_same_bits() {
    let laboratory = busy();
    let here: Vec<_> = (0..4).map(|seed| run(&laboratory, coupling(35.6, 0.167), seed, 1.0)).collect();
    let there: Vec<_> = std::thread::scope(|scope| {
        let started: Vec<_> = (0..4)
            .map(|seed| {
                let laboratory = &laboratory;
                scope.spawn(move || run(laboratory, coupling(35.6, 0.167), seed, 1.0))
            })
            .collect();
        started.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    assert_eq!(here, there);
}

#[test]
fn law_jitter_and_loss_leave_the_agents_numbers_as_they_were() {
    let quiet = Laboratory::paper();
    let mut rough = quiet.clone();
    rough.network = busy().network;
    let coupling = coupling(71.2, 0.0836);
    let (quiet, rough) = (run(&quiet, coupling, 3, 1.0), run(&rough, coupling, 3, 1.0));
    assert_eq!(quiet.aim, rough.aim);
    assert_ne!(quiet.position, rough.position);
}

#[test]
fn law_seeds_of_trials_are_all_different_and_depend_on_all_three_numbers() {
    let mut seeds = std::collections::BTreeSet::new();
    for base in 0..5 {
        for condition in 0..20 {
            for trial in 0..40 {
                assert!(seeds.insert(trial_seed(base, condition, trial)));
            }
        }
    }
}

#[test]
fn pin_seeds_of_trials() {
    // moved, every published rehearsal would change
    assert_eq!(
        [trial_seed(1, 0, 0), trial_seed(1, 16, 19)],
        [7_424_550_030_962_593_201, 9_669_131_468_611_139_437]
    );
}

#[test]
fn law_unconnected_robots_do_not_feel_each_other() {
    let laboratory = Laboratory::paper();
    let mut heavier = laboratory.clone();
    heavier.stations[1].handle.mass = [2.0, 3.0];
    let (one, other) = (run(&laboratory, None, 1, 2.0), run(&heavier, None, 1, 2.0));
    for (a, b) in one.position.iter().zip(&other.position) {
        assert_eq!(a[0], b[0]);
    }
    assert_ne!(one.position, other.position);
    assert!(one.coupling_force.iter().flatten().flatten().all(|force| *force == 0.0));
}

#[test]
fn law_the_partner_is_felt_exactly_one_delay_later() {
    let laboratory = Laboratory::paper();
    let recording = run(&laboratory, coupling(71.2, 0.083), 1, 1.0);
    for (tick, forces) in recording.coupling_force.iter().enumerate() {
        for robot in 0..2 {
            for axis in 0..2 {
                // 83 whole periods: the partner's sample itself
                let expected = match tick.checked_sub(83) {
                    Some(past) => {
                        71.2 * (recording.position[past][1 - robot][axis]
                            - recording.position[tick][robot][axis])
                    }
                    None => 0.0,
                };
                assert_eq!(forces[robot][axis], expected, "tick {tick}");
            }
        }
    }
}

#[test]
fn law_unequal_delays_go_each_their_way() {
    let laboratory = Laboratory::paper();
    let delay = Delay::new(0.02, 0.05).unwrap();
    let recording = run(&laboratory, Some(ConnectedMode { stiffness: 71.2, damping: 0.0, delay }), 1, 0.2);
    let first =
        |robot: usize| recording.coupling_force.iter().position(|row| row[robot] != [0.0; 2]).unwrap();
    // forward is what robot 2 receives
    assert_eq!([first(0), first(1)], [50, 20]);
}

#[test]
fn law_exchanging_the_sides_exchanges_the_rows() {
    let mut laboratory = Laboratory::paper();
    laboratory.stations[1].agent = Agent::Skilled { stiffness: 80.0, damping: 3.0 };
    let mut exchanged = laboratory.clone();
    exchanged.stations.swap(0, 1);
    let delay = Delay::new(0.02, 0.0511).unwrap();
    let back = Delay::new(0.0511, 0.02).unwrap();
    let of = |delay| Some(ConnectedMode { stiffness: 71.2, damping: 1.0, delay });
    let (one, other) = (run(&laboratory, of(delay), 1, 1.0), run(&exchanged, of(back), 1, 1.0));
    for (a, b) in one.position.iter().zip(&other.position) {
        assert_eq!([a[1], a[0]], *b);
    }
}

#[test]
fn law_a_computing_tick_acts_one_period_later() {
    let mut laboratory = Laboratory::paper();
    let prompt = run(&laboratory, coupling(71.2, 0.0), 1, 0.02);
    laboratory.controller.computing_tick = true;
    let late = run(&laboratory, coupling(71.2, 0.0), 1, 0.02);
    assert_eq!(late.agent_force[0], [[0.0; 2]; 2]);
    // the blurred agent is off its target from the start
    assert_eq!(late.agent_force[1], prompt.agent_force[0]);
    assert_eq!(late.position[1], late.position[0]);
    assert_ne!(late.position[2], late.position[1]);
}

#[test]
fn law_the_actuator_lags_behind_the_spring() {
    let mut laboratory = Laboratory::paper();
    let lag = 0.01;
    laboratory.controller.actuator_lag = lag;
    let recording = run(&laboratory, coupling(71.2, 0.02), 1, 0.5);
    let decay = (-1e-3 / lag).exp();
    let mut actuator = 0.0;
    for tick in 0..500 {
        assert_eq!(recording.coupling_force[tick][0][0], actuator);
        let spring = match tick.checked_sub(20) {
            Some(past) => 71.2 * (recording.position[past][1][0] - recording.position[tick][0][0]),
            None => 0.0,
        };
        actuator = spring + decay * (actuator - spring);
    }
}

#[test]
fn law_the_encoder_shows_whole_steps() {
    let mut laboratory = Laboratory::paper();
    let step = 1e-4;
    laboratory.controller.encoder_resolution = step;
    let recording = run(&laboratory, None, 1, 0.5);
    for row in 0..recording.position.len() {
        for axis in 0..2 {
            let shown = (recording.position[row][0][axis] / step).round() * step;
            let expected = 120.0 * (recording.target[row][axis] - shown);
            assert_eq!(recording.agent_force[row][0][axis], expected);
        }
    }
}

#[test]
fn law_a_program_that_does_what_an_agent_does_gives_the_same_bits() {
    let laboratory = Laboratory::paper();
    let mut programmed = laboratory.clone();
    programmed.stations[0].agent = Agent::External;
    let schedule = Schedule::new(1.0, 100.0, 1e-3).unwrap();
    let own = Trial { laboratory: &laboratory, coupling: coupling(71.2, 0.0836), seed: 4, schedule };
    let foreign = Trial { laboratory: &programmed, ..own };
    let mut program =
        |seen: &Observation| Ok([0, 1].map(|axis| 120.0 * (seen.target[axis] - seen.position[axis])));
    assert_eq!(
        own.record::<InvalidInput>([None, None]).unwrap(),
        foreign.record::<InvalidInput>([Some(&mut program), None]).unwrap()
    );
    let refusal = foreign.record::<InvalidInput>([None, None]).unwrap_err();
    assert_eq!(refusal.field, "agents[0]");
    let mut broken = |seen: &Observation| Ok([if seen.time > 0.1 { f64::NAN } else { 0.0 }, 0.0]);
    let refusal = foreign.record::<InvalidInput>([Some(&mut broken), None]).unwrap_err();
    assert!(refusal.field.starts_with("agents[0] at 0.101"), "{refusal}");
}

#[test]
fn law_a_trial_that_diverges_stops_and_says_when() {
    let laboratory = Laboratory::paper();
    let recording = run(&laboratory, coupling(500.0, 0.3), 1, 60.0);
    let Status::Diverged { at } = recording.outcome.status else { panic!("{:?}", recording.outcome) };
    // the rows end at the tick before, all inside the limit
    assert_eq!(recording.position.len(), (at * 1000.0).round() as usize);
    assert!(recording.position.iter().flatten().flatten().all(|value| value.abs() <= 10.0));
    let last = recording.position.last().unwrap();
    assert!(last.iter().flatten().any(|value| value.abs() > 5.0));
}

#[test]
fn law_a_row_is_the_state_at_its_own_time() {
    let laboratory = busy();
    let fine = run(&laboratory, coupling(71.2, 0.0836), 2, 1.0);
    let schedule = Schedule::new(1.0, 100.0, 1e-3).unwrap();
    let coarse = Trial { laboratory: &laboratory, coupling: coupling(71.2, 0.0836), seed: 2, schedule }
        .record::<InvalidInput>([None, None])
        .unwrap();
    for (row, position) in coarse.position.iter().enumerate() {
        assert_eq!(*position, fine.position[10 * row]);
        assert_eq!(coarse.handle_force[row], fine.handle_force[10 * row]);
    }
}

/// Mean offsets of the cloud (m) at tick `tick` over many seeds, both axes.
fn offsets(spots: Spots, tick: usize, seeds: u64) -> Vec<f64> {
    let mut laboratory = Laboratory::paper();
    laboratory.stations[1].agent = Agent::Blurred { stiffness: 120.0, spots };
    laboratory.controller.sample_period = 0.01;
    laboratory.check().unwrap();
    // the shortest trial has the tick at its start alone
    let schedule = Schedule::new((tick as f64 * 0.01).max(1e-6), 100.0, 0.01).unwrap();
    assert_eq!(schedule.ticks(), tick);
    (0..seeds)
        .flat_map(|seed| {
            let trial = Trial { laboratory: &laboratory, coupling: None, seed, schedule };
            let recording = trial.record::<InvalidInput>([None, None]).unwrap();
            let (aim, target) = (recording.aim.last().unwrap()[1], *recording.target.last().unwrap());
            [0, 1].map(|axis| aim[axis] - target[axis])
        })
        .collect()
}

#[test]
fn ref_the_cloud_is_as_wide_as_its_spots_ages_say_from_the_start_on() {
    // variance of the mean of N: sd²/N² Σ ageᵢ², the ages being L·frac(i/N + t/L)
    let spots = Spots { count: 10, velocity: 0.3, lifetime: 0.2 };
    let (n, l) = (spots.count as f64, spots.lifetime);
    let variance = |t: f64| {
        let squares = (0..spots.count).map(|i| ((i as f64 / n + t / l).fract() * l).powi(2));
        spots.velocity.powi(2) / (n * n) * squares.sum::<f64>()
    };
    for tick in [0, 1, 33, 777] {
        let found = offsets(spots, tick, 1500);
        let count = found.len() as f64;
        let second = found.iter().map(|x| x * x).sum::<f64>() / count;
        let expected = variance(tick as f64 * 0.01);
        // a mean square of normal numbers has the standard error √(2/count) of itself
        let error = 4.0 * expected * (2.0 / count).sqrt();
        assert!((second - expected).abs() < error, "tick {tick}: {second} is not {expected}");
        let mean = found.iter().sum::<f64>() / count;
        assert!(mean.abs() < 4.0 * (expected / count).sqrt(), "tick {tick}: {mean}");
    }
    // over all phases, one spot being renewed every L/N: sd² L²/(3N)
    let phases = 1000;
    let mean = (0..phases).map(|i| variance((f64::from(i) + 0.5) / f64::from(phases) * l / n)).sum::<f64>();
    let stationary = spots.velocity.powi(2) * l * l / (3.0 * n);
    // midpoint rule
    assert!((mean / f64::from(phases) / stationary - 1.0).abs() < 1e-6);
}

#[test]
fn law_a_cloud_moves_without_jumps_but_where_a_spot_is_renewed() {
    let spots = Spots { count: 4, velocity: 0.3, lifetime: 0.2 };
    let mut laboratory = Laboratory::paper();
    laboratory.stations[1].agent = Agent::Blurred { stiffness: 120.0, spots };
    let recording = run(&laboratory, None, 5, 1.0);
    let offset: Vec<_> =
        recording.aim.iter().zip(&recording.target).map(|(aim, target)| aim[1][0] - target[0]).collect();
    let mut bends = Vec::new();
    for tick in 2..offset.len() {
        let bend = offset[tick] - 2.0 * offset[tick - 1] + offset[tick - 2];
        // the target is added and taken away again
        if bend.abs() > 1e-12 {
            bends.push(tick);
        }
    }
    // straight between renewals at 0.05, 0.10, …; each shows in two second differences
    let expected: Vec<_> = (1..=20).flat_map(|j| [50 * j, 50 * j + 1]).filter(|tick| *tick <= 1000).collect();
    assert_eq!(bends, expected);
}

#[test]
fn law_what_is_out_of_range_is_refused_by_its_name() {
    type Break = fn(&mut Laboratory);
    let cases: [(&str, Break); 9] = [
        ("robot1.mass[1]", |l| l.stations[0].handle.mass[1] = 0.0),
        ("robot2.coulomb[0]", |l| l.stations[1].handle.coulomb[0] = -1.0),
        ("arm2.damping[1]", |l| {
            l.stations[1].arm = Arm::Lumped { mass: [0.0; 2], damping: [0.0, f64::NAN] };
        }),
        ("agent1.stiffness", |l| l.stations[0].agent = Agent::Skilled { stiffness: -1.0, damping: 0.0 }),
        ("agent2.spots", |l| {
            let spots = Spots { count: 0, velocity: 0.3, lifetime: 0.2 };
            l.stations[1].agent = Agent::Blurred { stiffness: 1.0, spots };
        }),
        ("agent2.spot_lifetime", |l| l.controller.sample_period = 0.5),
        ("task.amplitude[0]", |l| {
            l.target = Target::FigureEight { amplitude: [50.0, 0.1], angular_frequency: 1.0 };
        }),
        ("task.target[1][0]", |l| l.target = Target::Sampled(vec![[0.0; 2], [f64::NAN, 0.0]])),
        ("laboratory.sample_period", |l| l.controller.sample_period = 0.0),
    ];
    for (field, make) in cases {
        let mut laboratory = Laboratory::paper();
        make(&mut laboratory);
        assert_eq!(laboratory.check().unwrap_err().field, field);
    }
    let schedule = |duration, rate| Schedule::new(duration, rate, 1e-3).unwrap_err().field;
    assert_eq!(schedule(1.0, 300.0), "record_rate");
    assert_eq!(schedule(1.0, 2000.0), "record_rate");
    assert_eq!(schedule(-1.0, 100.0), "duration");
    assert_eq!(schedule(1e6, 100.0), "duration");
}

#[test]
fn cross_two_links_without_mass_act_as_the_ideal_arm() {
    // the torques are held while the pose turns a little: a first-order difference in the sample period
    let massless = TwoLinkArm {
        link_mass: [0.0; 2],
        link_inertia: [0.0; 2],
        joint_damping: [0.0; 2],
        rotor_inertia: [0.0; 2],
        torque_limit: [f64::INFINITY; 2],
        ..TwoLinkArm::HEBI_X8
    };
    let apart = |period: f64| {
        let mut laboratory = Laboratory::paper();
        laboratory.controller.sample_period = period;
        let mut linked = laboratory.clone();
        linked.stations[0].arm = Arm::TwoLink(massless);
        linked.stations[1].arm = Arm::TwoLink(TwoLinkArm { elbow: Elbow::Left, ..massless });
        let schedule = Schedule::new(3.0, 100.0, period).unwrap();
        let of = |laboratory| {
            Trial { laboratory, coupling: coupling(71.2, 0.0836), seed: 1, schedule }
                .record::<InvalidInput>([None, None])
                .unwrap()
        };
        let (one, other) = (of(&laboratory), of(&linked));
        assert_eq!(other.outcome.status, Status::Completed);
        let pairs = one.position.iter().flatten().flatten().zip(other.position.iter().flatten().flatten());
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    let (coarse, fine) = (apart(1e-3), apart(5e-4));
    assert!(coarse > 0.0 && coarse < 1e-4, "{coarse}");
    assert!((coarse / fine - 2.0).abs() < 0.1, "{coarse} {fine}");
}

#[test]
fn law_an_arm_that_cannot_follow_ends_the_trial_and_says_when() {
    let mut laboratory = Laboratory::paper();
    laboratory.stations[0].arm = Arm::TwoLink(TwoLinkArm { base: [0.0, -0.64], ..TwoLinkArm::HEBI_X8 });
    let recording = run(&laboratory, None, 1, 5.0);
    let Status::OutOfReach { at } = recording.outcome.status else { panic!("{:?}", recording.outcome) };
    assert_eq!(recording.position.len(), (at * 1000.0).round() as usize);
    // one that cannot even begin is refused
    laboratory.stations[0].arm = Arm::TwoLink(TwoLinkArm { base: [0.0, -0.9], ..TwoLinkArm::HEBI_X8 });
    let schedule = Schedule::new(1.0, 100.0, 1e-3).unwrap();
    let trial = Trial { laboratory: &laboratory, coupling: None, seed: 1, schedule };
    let refusal = trial.record::<InvalidInput>([None, None]).unwrap_err();
    assert_eq!(refusal.field, "arm1.base");
    assert!(refusal.to_string().contains("reach"), "{refusal}");
}

#[test]
fn law_two_links_take_every_imperfection_of_the_controllers() {
    let mut laboratory = busy();
    for side in &mut laboratory.stations {
        side.arm = Arm::TwoLink(TwoLinkArm::HEBI_X8);
    }
    let recording = run(&laboratory, coupling(35.6, 0.05), 1, 2.0);
    assert_eq!(recording.outcome.status, Status::Completed);
    let forces = recording.handle_force.iter().flatten().flatten();
    assert!(forces.clone().all(|force| force.is_finite()) && forces.clone().any(|force| *force != 0.0));
}

#[test]
fn law_no_step_of_the_sensors_makes_a_trial_panic() {
    let mut laboratory = Laboratory::paper();
    for resolution in [1e-310, 5e-324, 9e-13, 0.2, -1e-3, f64::NAN] {
        laboratory.controller.encoder_resolution = resolution;
        assert_eq!(laboratory.check().unwrap_err().field, "laboratory.encoder_resolution");
        // whoever leaves the check away gets an ending
        let schedule = Schedule::new(0.1, 100.0, 1e-3).unwrap();
        let trial = Trial { laboratory: &laboratory, coupling: coupling(20.0, 0.05), seed: 1, schedule };
        trial.record::<InvalidInput>([None, None]).unwrap();
    }
    for resolution in [0.0, 1e-12, 0.1] {
        laboratory.controller.encoder_resolution = resolution;
        run(&laboratory, coupling(20.0, 0.05), 1, 0.1);
    }
}

/// Robots of 0.1 g with a damping of 10⁶ N·s/m in links without mass: time constants of 0.1 ns.
fn stiff() -> Laboratory {
    let mut laboratory = Laboratory::paper();
    for side in &mut laboratory.stations {
        side.handle.mass = [1e-4; 2];
        side.handle.damping = [1e6; 2];
        side.arm = Arm::TwoLink(TwoLinkArm {
            link_mass: [0.0; 2],
            link_inertia: [0.0; 2],
            joint_damping: [0.0; 2],
            rotor_inertia: [0.0; 2],
            ..TwoLinkArm::HEBI_X8
        });
    }
    laboratory
}

#[test]
fn law_a_motion_too_stiff_to_follow_ends_the_trial_and_says_so() {
    let recording = run(&stiff(), coupling(71.2, 0.05), 1, 30.0);
    let Status::TooStiff { at } = recording.outcome.status else { panic!("{:?}", recording.outcome) };
    assert_eq!(recording.position.len(), (at * 1000.0).round() as usize);
}

#[test]
fn law_a_watch_ends_a_trial_within_some_ticks() {
    let laboratory = Laboratory::paper();
    let schedule = Schedule::new(10.0, 1000.0, 1e-3).unwrap();
    let trial = Trial { laboratory: &laboratory, coupling: coupling(20.0, 0.05), seed: 1, schedule };
    let mut looks = 0;
    let mut watch = || {
        looks += 1;
        if looks < 4 { Ok(()) } else { Err(InvalidInput::new("watch", looks, "no more", "")) }
    };
    assert_eq!(trial.record_interruptible([None, None], &mut watch).unwrap_err().field, "watch");
    let mut never = || Ok::<(), InvalidInput>(());
    let watched = trial.record_interruptible([None, None], &mut never).unwrap();
    assert_eq!(watched, trial.record::<InvalidInput>([None, None]).unwrap());
}

#[test]
fn law_rows_are_kept_at_ticks_however_long_the_trial() {
    // 333.3335 Hz is no third of 1 kHz: after 1000 s its rows would be half a tick off
    assert_eq!(Schedule::new(1000.0, 333.3335, 1e-3).unwrap_err().field, "record_rate");
    let schedule = Schedule::new(1000.0, 1000.0 / 3.0 * (1.0 + 9e-10), 1e-3).unwrap();
    for row in [0, 1, 77, 333_333] {
        assert!((schedule.time(row, 1e-3) - 3.0 * row as f64 * 1e-3).abs() < 1e-12);
    }
}
