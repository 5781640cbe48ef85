//! The energy that passes through the coupling and through the hands of a trial.

#![allow(clippy::disallowed_macros, reason = "the tests print what they measure")]

use telespring::rig::{Arm, ConnectedMode, Laboratory, Recording, Schedule, Trial, TwoLinkArm};
use telespring::{Delay, InvalidInput};

fn coupled(stiffness: f64, delay: f64) -> Option<ConnectedMode> {
    Some(ConnectedMode { stiffness, damping: 0.0, delay: Delay::each_way(delay).unwrap() })
}

fn run(laboratory: &Laboratory, coupling: Option<ConnectedMode>, duration: f64) -> Recording {
    laboratory.check().unwrap();
    let schedule = Schedule::new(duration, 1000.0, laboratory.controller.sample_period).unwrap();
    Trial { laboratory, coupling, seed: 1, schedule }.record::<InvalidInput>([None, None]).unwrap()
}

/// What each hand got by the recorded forces of the agents and motion of the handles, J.
fn hand_energy_by_signals(recording: &Recording) -> [f64; 2] {
    let mut got = [0.0; 2];
    for row in 1..recording.position.len() {
        for (robot, got) in got.iter_mut().enumerate() {
            for axis in 0..2 {
                let moved = recording.position[row][robot][axis] - recording.position[row - 1][robot][axis];
                *got -= recording.agent_force[row - 1][robot][axis] * moved;
            }
        }
    }
    got
}

/// What hands and coupling gave is in the motion or lost: without losses, exactly.
#[test]
fn law_the_hands_and_the_coupling_give_what_the_handles_have() {
    for lag in [0.0, 5e-3] {
        let mut laboratory = Laboratory::paper();
        laboratory.controller.actuator_lag = lag;
        let mut mass = [[0.0; 2]; 2];
        for (station, mass) in laboratory.stations.iter_mut().zip(&mut mass) {
            let added = [0.4, 0.7];
            station.arm = Arm::Lumped { mass: added, damping: [0.0; 2] };
            station.handle.damping = [0.0; 2];
            *mass = [station.handle.mass[0] + added[0], station.handle.mass[1] + added[1]];
        }
        let recording = run(&laboratory, coupled(71.2, 0.02), 2.0);
        let [first, last] = [0, recording.velocity.len() - 1].map(|row| {
            let squares =
                (0..4).map(|at| mass[at / 2][at % 2] * recording.velocity[row][at / 2][at % 2].powi(2));
            0.5 * squares.sum::<f64>()
        });
        let outcome = &recording.outcome;
        let given = -outcome.hand_energy[0] - outcome.hand_energy[1] - outcome.coupling_energy.total;
        // behind a lag the mean force of each period counts
        let tolerance = if lag > 0.0 { 1e-3 } else { 1e-9 };
        println!("lag {lag}: {given} J given, {} J gained", last - first);
        assert!(last > 1e-3 && (given - (last - first)).abs() < tolerance * last, "{given} {last} {first}");
        let expected = hand_energy_by_signals(&recording);
        for (got, expected) in outcome.hand_energy.into_iter().zip(expected) {
            assert!((got - expected).abs() < 1e-9 * expected.abs(), "{got} {expected}");
        }
    }
}

/// In a two-link arm the torques are held, not the force; alone as well as coupled.
#[test]
fn law_the_hands_of_two_link_arms_give_torque_times_turn() {
    let mut laboratory = Laboratory::paper();
    for station in &mut laboratory.stations {
        station.arm = Arm::TwoLink(TwoLinkArm::HEBI_X8);
    }
    for coupling in [coupled(71.2, 0.02), None] {
        let recording = run(&laboratory, coupling, 2.0);
        let expected = hand_energy_by_signals(&recording);
        for (got, expected) in recording.outcome.hand_energy.into_iter().zip(expected) {
            println!("{got} J, {expected} J");
            assert!(got.abs() > 1e-3 && (got - expected).abs() < 0.01 * expected.abs(), "{got} {expected}");
            assert!(got != expected);
        }
    }
}
