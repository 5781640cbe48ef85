//! Whole trials of the virtual laboratory in two-link arms.

use telespring::rig::{Arm, Coupling, Laboratory, Recording, Schedule, Status, Trial, TwoLinkArm};
use telespring::{Delay, InvalidInput};

fn record(arm: Arm) -> Recording {
    let mut laboratory = Laboratory::paper();
    for side in &mut laboratory.sides {
        side.arm = arm;
    }
    let coupling = Coupling { stiffness: 71.2, damping: 0.0, delay: Delay::each_way(0.084).unwrap() };
    let schedule = Schedule::new(3.0, 100.0, laboratory.controller.sample_period).unwrap();
    let trial = Trial { laboratory: &laboratory, coupling: Some(coupling), seed: 1, schedule };
    let recording = trial.record::<InvalidInput>([None, None]).unwrap();
    assert_eq!(recording.ending.status, Status::Completed);
    recording
}

fn furthest_apart(one: &Recording, two: &Recording) -> f64 {
    let all =
        |recording: &Recording| recording.position.iter().flatten().flatten().copied().collect::<Vec<_>>();
    all(one).into_iter().zip(all(two)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn law_a_two_link_arm_without_mass_is_the_ideal_arm() {
    let massless = TwoLinkArm {
        link_mass: [0.0; 2],
        link_inertia: [0.0; 2],
        joint_damping: [0.0; 2],
        rotor_inertia: [0.0; 2],
        torque_limit: [f64::INFINITY; 2],
        ..TwoLinkArm::HEBI_X8
    };
    let ideal = record(Arm::Lumped { mass: [0.0; 2], damping: [0.0; 2] });
    let off = furthest_apart(&ideal, &record(Arm::TwoLink(massless)));
    // torques are held for 1 ms, while the pose turns by 1e-3 rad: a thousandth of the force, half of it lasting
    assert!(off > 0.0 && off < 1e-3 * 0.1, "{off:e}");
}

#[test]
fn law_a_trial_in_the_example_arm_completes_and_repeats() {
    let [one, two] = [0, 1].map(|_| record(Arm::TwoLink(TwoLinkArm::HEBI_X8)));
    assert_eq!(one.position, two.position);
    let ideal = record(Arm::Lumped { mass: [0.0; 2], damping: [0.0; 2] });
    assert!(furthest_apart(&ideal, &one) > 0.005, "its inertia and damping are felt");
}
