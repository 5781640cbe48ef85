//! The guard under every adversary in a trial of the laboratory: two H-MANs in nobody's hands, one of them pulled for a
//! second and let go.

use telespring::InvalidInput;
use telespring::rig::{
    Adversary, Agent, Arm, ConnectedMode, Laboratory, Network, Observation, Recording, Schedule, Trial,
};
use telespring::session::AccountSettings;
use telespring::session::architecture::{Architecture, GuardDesign, StrategyDesign};

use crate::bare_spring::adversary;
use crate::guard::{HONEST_ABOUT_ENERGY, LIAR};

const PERIOD: f64 = 1e-3;
const SECONDS: f64 = 20.0;

/// What a trial shows.
#[derive(Debug)]
struct Shown {
    /// The largest distance of a handle from the start along an axis, m.
    farthest: f64,
    /// The largest speed along an axis in the last second, m/s.
    last_speed: f64,
    /// The energy that the coupling gave out at any time beyond what both accounts held at the start and their share of what
    /// the dampings took until then, J.
    beyond: f64,
}

/// A trial with this strategy and an adversary each way.
fn pulled(strategy: StrategyDesign, kind: Adversary, stiffness: f64) -> (Recording, Laboratory) {
    let mut laboratory = Laboratory::paper();
    for station in &mut laboratory.stations {
        station.arm = Arm::Lumped { mass: [0.0; 2], damping: [0.0; 2] };
        station.agent = Agent::External;
    }
    laboratory.controller.sample_period = PERIOD;
    laboratory.network = Network::each_way(adversary(kind));
    laboratory.session.architecture = Architecture { strategy, ..Architecture::default() };
    laboratory.check().unwrap();
    let coupling =
        ConnectedMode { stiffness, damping: 0.0, delay: telespring::Delay::each_way(0.05).unwrap() };
    let schedule = Schedule::new(SECONDS, 1.0 / PERIOD, PERIOD).unwrap();
    let pull = |force: [f64; 2]| {
        move |seen: &Observation| -> Result<[f64; 2], InvalidInput> {
            Ok(if (1.0..2.0).contains(&seen.time) { force } else { [0.0; 2] })
        }
    };
    let (mut first, mut second) = (pull([5.0, -3.0]), pull([0.0; 2]));
    let trial = Trial { laboratory: &laboratory, coupling: Some(coupling), seed: 1, schedule };
    let recording = trial.record::<InvalidInput>([Some(&mut first), Some(&mut second)]).unwrap();
    (recording, laboratory)
}

/// What the trial of this strategy shows, with the energies from the motion of the handles alone.
fn shown(strategy: StrategyDesign, kind: Adversary, stiffness: f64) -> Shown {
    let (recording, laboratory) = pulled(strategy, kind, stiffness);
    let AccountSettings { share, capacity, .. } = AccountSettings::new(stiffness, [1.0; 2]);
    let (mut given, mut lost, mut beyond) = (0.0, 0.0, f64::NEG_INFINITY);
    for row in 1..recording.position.len() {
        for (side, station) in laboratory.stations.iter().enumerate() {
            for axis in 0..2 {
                let moved = recording.position[row][side][axis] - recording.position[row - 1][side][axis];
                // the force of a row acts from there on
                given += recording.coupling_force[row - 1][side][axis] * moved;
                let [from, to] = [row - 1, row].map(|row| recording.velocity[row][side][axis]);
                lost += station.handle.damping[axis] * PERIOD * (from * from + from * to + to * to) / 3.0;
            }
        }
        beyond = beyond.max(given - 2.0 * capacity - share * lost);
    }
    let largest = |rows: &[[[f64; 2]; 2]]| {
        rows.iter().flatten().flatten().fold(0.0, |most: f64, value| most.max(value.abs()))
    };
    let last = recording.velocity.len().saturating_sub((1.0 / PERIOD) as usize);
    Shown { farthest: largest(&recording.position), last_speed: largest(&recording.velocity[last..]), beyond }
}

#[test]
fn law_in_a_trial_the_guard_keeps_robots_near_and_at_rest_under_every_adversary() {
    let guard = StrategyDesign::Guard(GuardDesign::default());
    for stiffness in [142.0, 2000.0] {
        // an account may be overdrawn by the overdraft of a held force, ½ k |Δx|² at 1 m/s
        let overdraft = 2.0 * 0.5 * stiffness * PERIOD * PERIOD;
        for kind in HONEST_ABOUT_ENERGY {
            let (guarded, bare) =
                (shown(guard, kind, stiffness), shown(StrategyDesign::Spring, kind, stiffness));
            println!("{kind:?}, {stiffness} N/m: guard {guarded:?}, bare spring {bare:?}");
            assert!(bare.farthest > 9.0 || bare.last_speed > 0.1, "{kind:?}, {stiffness}: {bare:?}");
            assert!(bare.beyond > 0.1, "{kind:?}, {stiffness}: {bare:?}");
            assert!(
                guarded.farthest < 1.0 && guarded.last_speed < 1e-3,
                "{kind:?}, {stiffness}: {guarded:?}"
            );
            assert!(guarded.beyond < overdraft, "{kind:?}, {stiffness}: {guarded:?}");
        }
        // the liar about energy moves the robots with what each side takes in of its claims, and no farther
        let lied = shown(guard, LIAR, stiffness);
        println!("{LIAR:?}, {stiffness} N/m: guard {lied:?}");
        let intake = AccountSettings::new(stiffness, [1.0; 2]).intake;
        assert!(lied.farthest < 2.0, "{stiffness}: {lied:?}");
        assert!(lied.beyond < overdraft + 2.0 * intake * SECONDS, "{stiffness}: {lied:?}");
        assert!(lied.beyond > 0.1, "nothing was taken in: {lied:?}");
    }
}
