//! What adversaries do to the bare spring in a trial: two equal free handles, held apart at rest and let go.

use telespring::rig::{
    Adversary, Agent, Arm, Blackout, ConnectedMode, Laboratory, Network, NetworkModel, Observation, Schedule,
    Trial,
};
use telespring::verdicts::{Network as Described, Tier, verdicts};
use telespring::{Delay, Dyad, InvalidInput, Robot};

/// How far from the middle both handles are held, m, and how long, s.
const REACH: f64 = 0.05;
const HELD: f64 = 6.0;

/// Mass (kg) and damping (N·s/m) of the H-MAN's x, and b²/m, N/m.
const HMAN: [f64; 2] = [0.8334, 7.7257];
const SCALE: f64 = HMAN[1] * HMAN[1] / HMAN[0];

/// Two equal handles of this mass and damping without arms, moved from outside.
fn free_robots([mass, damping]: [f64; 2], period: f64, network: NetworkModel) -> Laboratory {
    let mut laboratory = Laboratory::paper();
    for station in &mut laboratory.stations {
        station.handle.mass = [mass; 2];
        station.handle.damping = [damping; 2];
        station.arm = Arm::Lumped { mass: [0.0; 2], damping: [0.0; 2] };
        station.agent = Agent::External;
    }
    laboratory.controller.sample_period = period;
    laboratory.network = Network::each_way(network);
    laboratory
}

fn adversary(adversary: Adversary) -> NetworkModel {
    NetworkModel { adversary: Some(adversary), ..NetworkModel::ideal() }
}

/// The positions of both handles along x at every tick from the one at which they are let go.
fn let_go(laboratory: &Laboratory, stiffness: f64, delay: f64, seconds: f64) -> Vec<[f64; 2]> {
    laboratory.check().unwrap();
    let period = laboratory.controller.sample_period;
    let schedule = Schedule::new(HELD + seconds, (1.0 / period).round(), period).unwrap();
    let coupling = ConnectedMode { stiffness, damping: 0.0, delay: Delay::each_way(delay).unwrap() };
    let hold = |place: f64| {
        move |seen: &Observation| -> Result<[f64; 2], InvalidInput> {
            if seen.time > HELD - 0.5 * period {
                return Ok([0.0; 2]);
            }
            let from = [place - seen.position[0], -seen.position[1]];
            Ok([0, 1].map(|axis| 400.0 * from[axis] - 40.0 * seen.velocity[axis]))
        }
    };
    let (mut first, mut second) = (hold(REACH), hold(-REACH));
    let trial = Trial { laboratory, coupling: Some(coupling), seed: 1, schedule };
    let recording = trial.record::<InvalidInput>([Some(&mut first), Some(&mut second)]).unwrap();
    let from = (HELD / period).round() as usize;
    recording.position.iter().skip(from).map(|[one, two]| [one[0], two[0]]).collect()
}

/// The largest distance from the middle in each window of so many ticks.
fn windows(course: &[[f64; 2]], ticks: usize) -> Vec<f64> {
    let most = |part: &[[f64; 2]]| part.iter().flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
    course.chunks_exact(ticks).map(most).collect()
}

/// How much larger the largest distance in a window of 4 s becomes than in the first.
fn growth(kind: Adversary, share: f64, seconds: f64) -> f64 {
    let course = let_go(&free_robots(HMAN, 1e-3, adversary(kind)), share * SCALE, 0.0, seconds);
    let sizes = windows(&course, 4000);
    sizes.iter().copied().fold(0.0, f64::max) / sizes[0]
}

#[test]
fn ref_the_most_harmful_sample_makes_equal_arms_grow() {
    let kind = Adversary::MostHarmfulSample { memory: 2.0 };
    let [half, less] = [(0.5, 30.0), (0.4, 60.0)].map(|(share, seconds)| growth(kind, share, seconds));
    println!("most harmful sample of 2 s: {half:.2} at 0.5 b²/m in 30 s, {less:.2} at 0.4 b²/m in 60 s");
    assert!(half > 1.5 && less > 1.5, "{half}, {less}");
}

#[test]
fn law_at_a_quarter_no_adversary_leaves_the_hull() {
    // critically damped arms go straight towards what pulls them: no sample is outside, so no arm ever is
    for kind in [
        Adversary::MostHarmfulSample { memory: 2.0 },
        Adversary::OldestSample { memory: 2.0 },
        Adversary::StretchTimed { longest: 2.0 },
    ] {
        let course = let_go(&free_robots(HMAN, 4e-3, adversary(kind)), 0.25 * SCALE, 0.0, 600.0);
        let start = course[0][0].abs().max(course[0][1].abs());
        let most = windows(&course, course.len())[0];
        assert!(course.len() == 150_001 && most <= start * (1.0 + 1e-9), "{kind:?}: {most} after {start}");
    }
}

#[test]
fn law_the_oldest_sample_is_a_constant_delay_and_harms_above_its_critical_stiffness_only() {
    // equal free arms are stable at every constant delay up to b²/(2m), and at 2 s hardly above it
    let kind = Adversary::OldestSample { memory: 2.0 };
    let last = |share: f64| {
        let course = let_go(&free_robots(HMAN, 2e-3, adversary(kind)), share * SCALE, 0.0, 80.0);
        let sizes = windows(&course, 4000);
        sizes[9] / sizes[4]
    };
    let (below, above) = (last(0.4), last(0.7));
    assert!(below < 0.95 && above > 1.2, "{below}, {above}");
}

/// By how much more the arms swing out than the time before, at the end of a course.
fn last_swing(course: &[[f64; 2]]) -> f64 {
    let turns = course.windows(3).filter(|at| (at[1][0] - at[0][0]) * (at[2][0] - at[1][0]) < 0.0);
    let turns: Vec<f64> = turns.map(|at| at[1][0].abs()).collect();
    turns[turns.len() - 1] / turns[turns.len() - 2]
}

#[test]
fn ref_packets_at_the_turns_of_a_swing_make_it_grow_as_by_the_closed_form() {
    // held until it turns, an arm overshoots by exp(−π b/√(4mk − b²)) of twice its swing
    for (robot, stiffness) in [([1.0, 4.0], 5.0), ([1.0, 4.0], 6.0), ([1.0, 4.0], 12.0), (HMAN, 0.5 * SCALE)]
    {
        let [m, b] = robot;
        let turning = (4.0 * m * stiffness - b * b).sqrt();
        let expected = 2.0 * (-std::f64::consts::PI * b / turning).exp();
        // the longest wait that it needs, half a swing; and a little more
        let longest = 2.0 * m * std::f64::consts::PI / turning + 0.1;
        let laboratory = free_robots(robot, 5e-4, adversary(Adversary::StretchTimed { longest }));
        let grown = last_swing(&let_go(&laboratory, stiffness, 0.0, 40.0)) - 1.0;
        println!("{robot:?}, {stiffness} N/m: swings grow by {grown:.5}, closed form {expected:.5}");
        assert!((grown / expected - 1.0).abs() < 0.05, "{robot:?}, {stiffness}: {grown}, not {expected}");
    }
}

#[test]
fn ref_a_packet_every_half_swing_makes_arms_grow_below_the_critical_stiffness() {
    // m = 1, b = 4, k = 6 < b²/(2m) = 8: by 1.0235 a period
    let (period, packets) = (2e-4, 2.2214);
    let blackout = Blackout { start: 1e-4, duration: packets - period, period: Some(packets) };
    let network = NetworkModel { blackout: Some(blackout), ..NetworkModel::ideal() };
    let course = let_go(&free_robots([1.0, 4.0], period, network), 6.0, 0.0, 40.0);
    let at = |n: usize| course[n * 11_107 - 30_000][0];
    for n in 8..18 {
        let ratio = at(n + 1) / at(n);
        assert!((ratio + 1.0235).abs() < 2e-4, "{ratio}");
    }
}

#[test]
fn cross_stretch_timed_flips_grow_between_the_verdict_and_the_constant_delay() {
    let [m, b] = HMAN;
    let robot = Robot::new(vec![m], vec![b], None).unwrap();
    let dyad = Dyad::new(robot.clone(), robot, None, 0.0).unwrap();
    for (least, most, stiffness) in [(0.03, 0.07, 133.0), (0.08, 0.12, 87.0), (0.24, 0.26, 55.0)] {
        let width = most - least;
        let found = |least: f64, jitter: f64| {
            let network = Described::new(Delay::each_way(least).unwrap(), jitter, 0.0, 1e-3, 0.0).unwrap();
            verdicts(&dyad, None, 10.0, &network).unwrap()
        };
        // every constant delay of the range is stable, and sampled
        let constant = found(most, 0.0).tier(Tier::ConstantDelay).stiffness_bound.unwrap();
        let safe = found(least, width).tier(Tier::AgeInRange).stiffness_bound.unwrap();
        assert!(safe < stiffness && stiffness < constant, "{safe}, {constant}");
        let kind = adversary(Adversary::StretchTimed { longest: width });
        let laboratory = free_robots(HMAN, 1e-3, kind);
        let last = |stiffness: f64| {
            let sizes = windows(&let_go(&laboratory, stiffness, least, 48.0), 8000);
            sizes[5] / sizes[2]
        };
        let (below, above) = (last(0.99 * safe), last(stiffness));
        println!(
            "ages {least} to {most} s: verdict {safe:.1}, constant {constant:.1} N/m; three windows of 8 s: {below:.3} \
             below the verdict, {above:.3} at {stiffness} N/m"
        );
        assert!(below < 0.9 && above > 1.1, "{below}, {above}");
    }
}

#[test]
fn law_adversaries_make_the_bare_spring_give_out_energy() {
    let given = |kind: Option<Adversary>| {
        let network = NetworkModel { adversary: kind, ..NetworkModel::ideal() };
        let mut laboratory = free_robots(HMAN, 1e-3, network);
        laboratory.stations[0].agent = Agent::Skilled { stiffness: 30.0, damping: 0.0 };
        laboratory.stations[1].agent = Agent::Skilled { stiffness: 0.0, damping: 0.0 };
        laboratory.check().unwrap();
        let coupling = ConnectedMode { stiffness: 71.2, damping: 0.0, delay: Delay::each_way(0.02).unwrap() };
        let schedule = Schedule::new(6.0, 1000.0, 1e-3).unwrap();
        let trial = Trial { laboratory: &laboratory, coupling: Some(coupling), seed: 1, schedule };
        trial.record::<InvalidInput>([None, None]).unwrap().outcome.coupling_energy.total
    };
    let none = given(None);
    let worst = given(Some(Adversary::MostHarmfulSample { memory: 0.5 }));
    let oldest = given(Some(Adversary::OldestSample { memory: 0.3 }));
    let flips = given(Some(Adversary::StretchTimed { longest: 0.5 }));
    let liar = given(Some(Adversary::LyingPeer { position: 0.05, stamp: 0.0, power: 1.0 }));
    println!(
        "{none:.2} J taken; most harmful {worst:.2}, oldest {oldest:.2}, flips {flips:.2}, liar {liar:.2}"
    );
    assert!(none > 0.0 && worst < -1.0 && flips < -1.0, "{none}, {worst}, {flips}");
    assert!(oldest < 0.0 && liar < -1.0, "{none}, {oldest}, {liar}");
}
