//! Trials on networks, and the energy that they cause.

use telespring::rig::{
    Agent, Arm, Blackout, ConnectedMode, GilbertElliott, JitterDistribution, Laboratory, NetworkModel,
    PacketOrder, RateLimit, Recording, Schedule, Status, Trial,
};
use telespring::{Delay, InvalidInput};

pub fn coupled(stiffness: f64, delay: f64) -> Option<ConnectedMode> {
    Some(ConnectedMode { stiffness, damping: 0.0, delay: Delay::each_way(delay).unwrap() })
}

fn run(laboratory: &Laboratory, coupling: Option<ConnectedMode>, duration: f64) -> Recording {
    laboratory.check().unwrap();
    let schedule = Schedule::new(duration, 1000.0, laboratory.controller.sample_period).unwrap();
    Trial { laboratory, coupling, seed: 1, schedule }.record::<InvalidInput>([None, None]).unwrap()
}

/// What the two robots gave out, by the balance of energies of each handle, which shares nothing with forces times
/// displacements: the kinetic energy and the viscous loss less the work of the hand. And that loss, J.
fn balance(recording: &Recording, laboratory: &Laboratory) -> (f64, f64) {
    let rows = recording.velocity.len();
    let period = laboratory.controller.sample_period;
    let (mut given, mut lost) = (0.0, 0.0);
    for side in 0..2 {
        for axis in 0..2 {
            let (m, b) =
                (laboratory.stations[side].handle.mass[axis], laboratory.stations[side].handle.damping[axis]);
            let velocity = |row: usize| recording.velocity[row][side][axis];
            given += 0.5 * m * (velocity(rows - 1).powi(2) - velocity(0).powi(2));
            for row in 0..rows - 1 {
                let (from, to) = (velocity(row), velocity(row + 1));
                // a velocity that changes evenly within a period
                lost += b * period * (from * from + from * to + to * to) / 3.0;
                given -= recording.agent_force[row][side][axis] * period * 0.5 * (from + to);
            }
        }
    }
    (given + lost, lost)
}

#[test]
fn law_the_observer_counts_what_the_handles_balance_says() {
    let mut laboratory = Laboratory::paper();
    for (stiffness, delay) in [(71.2, 0.0), (71.2, 0.084), (142.0, 0.084)] {
        let recording = run(&laboratory, coupled(stiffness, delay), 4.0);
        let observed = recording.outcome.coupling_energy;
        let (given, lost) = balance(&recording, &laboratory);
        let expected = -given;
        // the velocity between two ticks is not quite even
        let scale = 1e-4 * lost;
        assert!(
            (observed.total - expected).abs() < scale,
            "{stiffness}, {delay}: {observed:?}, not {expected}"
        );
        assert!(observed.minimum <= observed.total && observed.minimum <= 0.0);
    }
    // undelayed, a spring cannot give more than it took, but for the little that holding a force generates
    laboratory.stations[1].agent = Agent::Skilled { stiffness: 60.0, damping: 1.0 };
    let spring = run(&laboratory, coupled(71.2, 0.0), 4.0).outcome.coupling_energy;
    // over a delay it gives out what the handles then lose
    let mut free = Laboratory::paper();
    for station in &mut free.stations {
        station.arm = Arm::Lumped { mass: [0.0; 2], damping: [0.0; 2] };
    }
    free.stations[0].agent = Agent::Skilled { stiffness: 30.0, damping: 0.0 };
    free.stations[1].agent = Agent::Skilled { stiffness: 0.0, damping: 0.0 };
    let delayed = run(&free, coupled(142.0, 0.2), 4.0).outcome.coupling_energy;
    assert!(spring.minimum > -0.01, "{spring:?}");
    assert!(delayed.minimum < -0.1, "{delayed:?}");
    let alone = run(&laboratory, None, 1.0).outcome.coupling_energy;
    assert_eq!((alone.total, alone.minimum), (0.0, 0.0));
}

#[test]
fn law_a_trial_runs_on_every_network_and_is_repeatable() {
    let burst = GilbertElliott { to_bad: 0.01, to_good: 0.2, loss_good: 0.0, loss_bad: 1.0 };
    let rough = NetworkModel {
        jitter: 0.02,
        distribution: JitterDistribution::Gamma { mean: 0.004, sd: 0.003 },
        loss: 0.01,
        burst: Some(burst),
        duplicate: 0.02,
        order: PacketOrder::Fifo,
        rate: Some(RateLimit { bits_per_second: 2e6, queue: 50 }),
        blackout: Some(Blackout { start: 0.5, duration: 0.1, period: None }),
        ..NetworkModel::ideal()
    };
    let mut laboratory = Laboratory::paper();
    let clean = run(&laboratory, coupled(71.2, 0.05), 1.0);
    laboratory.network.forward = rough;
    let one_way = run(&laboratory, coupled(71.2, 0.05), 1.0);
    assert_eq!(one_way.outcome.status, Status::Completed);
    assert_eq!(one_way, run(&laboratory, coupled(71.2, 0.05), 1.0));
    assert_ne!(one_way.coupling_force, clean.coupling_force);
}
