//! A steady pull at one side is felt at the other.

use crate::case::{Case, CaseSide};
use crate::run::run;
use crate::withstand_common::pair::SideClock;
use telespring::hman;
use telespring::rig::{Network, NetworkModel};
use telespring::session::{AccountSettings, ClockSettings, Law, PlayoutSettings, Span};

/// The pull, N; the stiffness of the hand that feels it, N/m; the one-way delay, s.
const PULL: f64 = 10.0;
const HAND: f64 = 300.0;
const DELAY: f64 = 0.2;

/// Two H-MANs at a stiffness (N/m), the first pulled along x from 0 s on, the second in the hand.
fn pulled(stiffness: f64, capacity: f64, intake: f64, seconds: f64) -> Case {
    let robots = hman();
    let sides = [0, 1].map(|side: usize| {
        let robot = &robots.robots()[side];
        let damping = [robot.damping()[0], robot.damping()[1]];
        let settings = AccountSettings { capacity, intake, ..AccountSettings::new(stiffness, damping) };
        let pull = if side == 0 { PULL } else { 0.0 };
        CaseSide {
            mass: [robot.mass()[0], robot.mass()[1]],
            damping,
            ground: [if side == 1 { HAND } else { 0.0 }; 2],
            velocity: [0.0; 2],
            settings,
            hand: [(pull, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0)],
        }
    });
    let period = Span(1_000_000);
    let ticks = (seconds * 1e3).round() as usize;
    Case {
        period,
        ticks,
        let_go: ticks + 1,
        law: Law { stiffness, damping: 0.0 },
        sides,
        network: Network::each_way(NetworkModel::ideal()),
        travel: [Span::from_seconds(DELAY) - period; 2],
        has_liar: [false; 2],
        playout: PlayoutSettings::Fixed { delay: Span::from_seconds(DELAY) },
        clock: ClockSettings::default(),
        clocks: [SideClock::TRUE; 2],
        is_watched: false,
        predictor: 0,
        wrong_target: (1.0, 0.0),
        force_limit: f64::INFINITY,
        lag: 0.0,
    }
}

/// The force that the hand feels at every tick, N.
fn felt(stiffness: f64, capacity: f64, intake: f64, seconds: f64) -> Vec<f64> {
    let outcome = run(&pulled(stiffness, capacity, intake, seconds), 1, &[]).unwrap();
    outcome.positions.iter().map(|positions| HAND * positions[1][0]).collect()
}

/// The force that the account can pay at a time, N, if it gets the set power from the delay on: the energy of both springs,
/// ½ F² (1/k + 1/k_hand), is all that it has.
fn payable(stiffness: f64, capacity: f64, intake: f64, time: f64) -> f64 {
    let energy = capacity + intake * (time - DELAY);
    (2.0 * energy / (1.0 / stiffness + 1.0 / HAND)).sqrt()
}

/// While the account fills, the hand feels what it can pay; the rest of the way is motion and loss.
#[test]
fn ref_the_force_of_a_filling_account_is_that_of_its_energy() {
    for (stiffness, intake) in
        [(36.0, 0.3), (50.0, 0.3), (71.0, 0.3), (100.0, 0.3), (142.0, 0.2), (142.0, 0.3)]
    {
        let (force, expected) =
            (felt(stiffness, 0.05, intake, 2.0)[2000], payable(stiffness, 0.05, intake, 2.0));
        println!("{stiffness} N/m, {intake} W: {force:.2} N after 2 s, {expected:.2} N by its energy");
        assert!((0.97 * expected..expected).contains(&force), "{force} {expected}");
    }
}

/// A softer spring stores more energy for a force. With a capacity and an intake in inverse proportion to the stiffness,
/// which leaves the force of the first pull as it is, 10 N are felt as 9.5 N or more from 2 s on at 100 N/m and above, and as 9 N
/// or more at a softer spring.
#[test]
fn law_a_steady_pull_is_felt_within_two_seconds() {
    for (stiffness, least) in [(36.0, 9.3), (50.0, 9.0), (71.0, 9.0), (100.0, 9.5), (142.0, 9.5)] {
        let usual = AccountSettings::new(142.0, [0.0; 2]);
        let softer = 142.0 / stiffness;
        let (capacity, intake) = (usual.capacity * softer, usual.intake * softer);
        let force = felt(stiffness, capacity, intake, 8.0);
        println!(
            "{stiffness} N/m, {capacity:.3} J, {intake:.2} W: {:.2} N after 2 s, {:.2} N after 8 s",
            force[2000], force[8000]
        );
        assert!(payable(stiffness, capacity, intake, 2.0) >= 9.5);
        assert!(force[2000..].iter().all(|force| *force >= least), "{stiffness} N/m");
        // without what the partner sends the account cannot pay for it
        assert!(felt(stiffness, capacity, 0.0, 8.0)[2000..].iter().all(|force| *force < 6.0));
    }
}

/// The settings of 142 N/m at 71 N/m: too little power at first, and at rest too little energy, since none flows then.
#[test]
fn law_at_half_the_stiffness_the_same_settings_pay_for_less() {
    let usual = AccountSettings::new(71.0, [0.0; 2]);
    let slow = felt(71.0, usual.capacity, usual.intake, 8.0);
    let small = felt(71.0, usual.capacity, 2.0 * usual.intake, 8.0);
    println!("71 N/m: {:.2} N after 2 s, {:.2} N after 8 s", slow[2000], slow[8000]);
    println!("71 N/m, twice the power: {:.2} N after 2 s, {:.2} N after 8 s", small[2000], small[8000]);
    for force in [slow, small] {
        assert!(force[2000] < 9.5 && force[8000] < 9.5);
    }
}
