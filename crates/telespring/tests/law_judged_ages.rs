//! The ages that the verdicts judge contain those that a trial of the same study uses, on every kind of network.

use std::fmt::Write as _;
use std::sync::Arc;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use telespring::rig::{ConnectedMode, Schedule, Trace, TraceRow, Trial};
use telespring::study::{AgeSource, JudgedNetwork, Study};
use telespring::{Delay, InvalidInput};

const MS: f64 = 1e-3;
/// What computing may add to an age, s.
const ROUNDING: f64 = 2e-9;
/// Networks of each kind.
const NETWORKS: u64 = 40;

fn study(network: &str, session: &str) -> Study {
    let robots = "robot1 = {mass = [0.8, 1.1], damping = [7.7, 10.1]}\n\
                  robot2 = {mass = [0.8, 1.1], damping = [7.7, 10.1]}\ncoupling.stiffness = 5\n";
    let text = format!("{robots}[network]\n{network}\n[session]\n{session}\n");
    Study::from_toml(&text).unwrap_or_else(|refused| panic!("{refused}\n{text}"))
}

/// The smallest and the largest age of any sample that each way used in a trial of the study, s.
fn used(study: &Study, traces: [Option<Arc<Trace>>; 2], seed: u64, duration: f64) -> [[f64; 2]; 2] {
    let laboratory = study.laboratory_on(traces).unwrap();
    laboratory.check().unwrap();
    let delay = study.network().unwrap().delay();
    let coupling = Some(ConnectedMode { stiffness: 5.0, damping: 0.0, delay });
    let schedule = Schedule::new(duration, 10.0, laboratory.controller.sample_period).unwrap();
    let trial = Trial { laboratory: &laboratory, coupling, seed, schedule };
    let recording = trial.record::<InvalidInput>([None, None]).unwrap();
    let reports = recording.outcome.sessions.unwrap();
    // robot 2 receives on the way forward
    [1, 0].map(|side: usize| {
        let ages = reports[side].playout.ages.unwrap();
        [ages.smallest.seconds(), ages.largest.seconds()]
    })
}

/// Runs a trial of the study and compares; returns how much of the judged width it used.
fn compare(study: &Study, trace: Option<Arc<Trace>>, seed: u64, what: &str) -> (JudgedNetwork, f64) {
    let traces = [trace.clone(), trace];
    let judged = study.judged_network(None, traces.clone()).unwrap();
    assert!(judged.unjudged.is_empty(), "{what}");
    let Some(ages) = judged.ages else { return (judged, 0.0) };
    let mut share: f64 = 0.0;
    // where samples overtake each other, a motion lies between two that are up to a period apart from it
    let is_plain = judged.sources.iter().all(|source| *source == AgeSource::Playout);
    let neighbour = if is_plain { MS } else { 0.0 };
    for (used, [least, greatest]) in used(study, traces, seed, 3.0).into_iter().zip(ages) {
        assert!(
            used[0] >= least - neighbour - ROUNDING && used[1] <= greatest + ROUNDING,
            "{what}: used {used:?} s, judged {:?} s",
            [least, greatest]
        );
        share = share.max((used[1] - used[0]) / (greatest - least).max(MS));
    }
    (judged, share)
}

/// A random delay each way, often a whole number of periods, sometimes shorter than one.
fn delays(random: &mut ChaCha8Rng) -> String {
    let mut one = || match random.random_range(0..6) {
        0 => 0.0,
        1 => 1e-4 * random.random_range(1..10) as f64,
        2 => 1e-5 * random.random_range(100..8000) as f64,
        _ => MS * random.random_range(1..80) as f64,
    };
    format!("delay = {{forward = {:?}, backward = {:?}}}\n", one(), one())
}

fn jitter(random: &mut ChaCha8Rng) -> String {
    let largest = 1e-5 * random.random_range(1..4000) as f64;
    let order = if random.random::<bool>() { "any" } else { "fifo" };
    format!("jitter = {largest:?}\norder = \"{order}\"\nduplicate = 0.05\n")
}

fn loss(random: &mut ChaCha8Rng) -> String {
    format!("loss = {:?}\n", random.random_range(0.001..0.4))
}

fn burst(random: &mut ChaCha8Rng) -> String {
    let [to_bad, to_good] = [random.random_range(0.001..0.1), random.random_range(0.05..0.5)];
    let [good, bad] = [random.random_range(0.0..0.02), random.random_range(0.5..1.0)];
    format!("burst = {{to_bad = {to_bad}, to_good = {to_good}, loss_good = {good}, loss_bad = {bad}}}\n")
}

fn blackout(random: &mut ChaCha8Rng) -> String {
    let [start, duration] = [random.random_range(0.0..1.0), random.random_range(0.0..0.4)];
    format!("blackout = {{start = {start}, duration = {duration}, period = 1.1}}\n")
}

/// 1120 bits each: `least` to `most` ms for a packet.
fn rate(random: &mut ChaCha8Rng, least: f64, most: f64) -> String {
    let service = MS * random.random_range(least..most);
    format!("rate = {{bits_per_second = {:?}, queue = {}}}\n", 1120.0 / service, random.random_range(0..60))
}

fn stretch_timed(random: &mut ChaCha8Rng) -> String {
    let longest = 1e-5 * random.random_range(1..30_000) as f64;
    let jitter = MS * random.random_range(0..5) as f64;
    format!("jitter = {jitter:?}\nadversary = {{kind = \"stretch-timed\", longest = {longest:?}}}\n")
}

fn playout(random: &mut ChaCha8Rng) -> String {
    let later = match random.random_range(0..2) {
        0 => MS * random.random_range(0..150) as f64,
        _ => 1e-5 * random.random_range(0..15_000) as f64,
    };
    format!("playout = {{kind = \"fixed\", delay = {later:?}}}\n")
}

fn adaptive(random: &mut ChaCha8Rng) -> String {
    let [quantile, slew] = [random.random_range(0.0..1.0), random.random_range(0.05..0.9)];
    let smallest = MS * random.random_range(0..50) as f64;
    let largest = smallest + MS * random.random_range(1..200) as f64;
    let window = random.random_range(0.05..2.0);
    format!(
        "playout = {{kind = \"adaptive\", quantile = {quantile}, margin = 0.002, smallest = {smallest:?}, \
         largest = {largest:?}, slew = {slew}, window = {window}}}\n"
    )
}

fn recording(random: &mut ChaCha8Rng) -> Arc<Trace> {
    let (mut time, mut lost) = (0.0, false);
    let [step, slowest] = [random.random_range(1..30), random.random_range(1..150)];
    let losses = if random.random::<bool>() { 0.05 } else { 0.0 };
    let rows = (0..400).map(|_| {
        time += 1e-4 * random.random_range(8..20) as f64 * step as f64;
        lost = random.random::<f64>() < if lost { 0.6 } else { losses };
        TraceRow { time, delay: MS * random.random_range(0.0..f64::from(slowest)), lost }
    });
    Arc::new(Trace::new(rows.collect()).unwrap())
}

/// For every kind of impairment, networks with it alone, and with a play-out of their own.
fn every_network_of(seed: u64, impairment: impl Fn(&mut ChaCha8Rng) -> String) -> f64 {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut most: f64 = 0.0;
    for n in 0..NETWORKS {
        let network = delays(&mut random) + &impairment(&mut random);
        let session = match n % 4 {
            0 => playout(&mut random),
            1 => adaptive(&mut random),
            _ => String::new(),
        };
        let buffered = if n % 4 == 2 { "playout_buffer = true\n" } else { "" };
        let study = study(&format!("{network}{buffered}"), &session);
        let (_, share) = compare(&study, None, n, &format!("{network}{buffered}{session}"));
        most = most.max(share);
    }
    most
}

#[test]
fn law_trials_keep_the_judged_ages_without_impairments_and_with_jitter() {
    every_network_of(1, |_| String::new());
    assert!(every_network_of(2, jitter) > 0.9);
}

#[test]
fn law_trials_keep_the_judged_ages_with_losses() {
    // the longest row of an hour is longer than that of a trial
    assert!(every_network_of(3, loss) > 0.3);
    assert!(every_network_of(4, burst) > 0.1);
    assert!(every_network_of(5, blackout) > 0.9);
}

#[test]
fn law_trials_keep_the_judged_ages_behind_a_link() {
    every_network_of(6, |random| rate(random, 0.01, 0.99));
    assert!(every_network_of(7, |random| rate(random, 1.01, 9.0)) > 0.9);
}

#[test]
fn law_trials_keep_the_judged_ages_behind_an_adversary_that_withholds_packets() {
    assert!(every_network_of(10, stretch_timed) > 0.5);
}

#[test]
fn law_trials_keep_the_judged_ages_with_everything_at_once() {
    every_network_of(8, |random| {
        let mut all = String::new();
        for part in [jitter(random), loss(random), burst(random), blackout(random), rate(random, 0.1, 4.0)] {
            if random.random::<f64>() < 0.6 {
                write!(all, "{part}").unwrap();
            }
        }
        all
    });
}

#[test]
fn law_trials_keep_the_judged_ages_on_recordings() {
    let mut random = ChaCha8Rng::seed_from_u64(9);
    for n in 0..NETWORKS {
        let trace = recording(&mut random);
        let network = format!("{}trace = \"a.csv\"\n", delays(&mut random));
        let session = match n % 3 {
            0 => playout(&mut random),
            1 => adaptive(&mut random),
            _ => String::new(),
        };
        let study = study(&network, &session);
        compare(&study, Some(trace), n, &format!("recording {n}\n{network}{session}"));
    }
}

#[test]
fn ref_what_has_no_bound_or_is_not_judged_is_said() {
    let judged = |network: &str, session: &str| {
        study(&format!("delay = 0.05\n{network}"), session).judged_network(None, [None, None]).unwrap()
    };
    let words = |judged: &JudgedNetwork| {
        let sources: Vec<_> = judged.sources.iter().map(|source| source.word()).collect();
        let unjudged: Vec<_> = judged.unjudged.iter().map(|word| word.word()).collect();
        (sources.join(", "), unjudged.join(", "))
    };
    let lost = judged("loss = 1", "");
    assert_eq!((lost.ages, words(&lost).0.as_str()), (None, "loss"));
    for forged in ["oldest-sample", "most-harmful-sample"] {
        let forged = judged(&format!("adversary = {{kind = \"{forged}\", memory = 0.1}}"), "");
        assert_eq!((forged.ages, words(&forged)), (None, ("adversary".to_owned(), String::new())));
    }
    let liar = judged("adversary = {kind = \"lying-peer\", position = 0.01, stamp = 0, power = 0}", "");
    assert_eq!((liar.ages, words(&liar).1.as_str()), (None, "lying peer"));
    assert_eq!(judged("burst = {to_bad = 0.1, to_good = 0}", "").ages, None);
    assert_eq!(judged("blackout = {duration = 101}", "").ages, None);
    let unread = judged("trace = \"a.csv\"", "");
    assert_eq!((unread.ages, words(&unread).1.as_str()), (None, "unread trace"));
    assert_eq!(words(&judged("", "predictor = \"linear\"")).1, "predictor");
    assert_eq!(words(&judged("", "predictor = \"shared-target\"")).1, "");
    assert_eq!(words(&judged("", "strategy = \"wave-variables\"")).1, "strategy");
    assert!(judged("", "strategy = \"guard\"\npredictor = \"linear\"").is_guard_predicted);
    let plain = judged("jitter = 0.02\nmax_gap = 0.01", "");
    assert!(plain.is_as_stated && plain.ages.unwrap()[0][1] > 0.0799);
    // the larger of the stated gap and that of the losses counts
    let short = judged("loss = 0.01\nmax_gap = 0.001", "");
    assert_eq!(words(&short).0, "loss, stated gap too short");
    let long = judged("loss = 0.01\nmax_gap = 0.5", "");
    assert!((long.ages.unwrap()[0][1] - 0.551).abs() < 1e-9, "{long:?}");
}

#[test]
fn ref_a_later_or_earlier_playout_makes_the_age() {
    let ages =
        |network: &str, session: &str| study(network, session).judged_network(None, [None, None]).unwrap();
    let later = ages("delay = 0.05", "playout = {kind = \"fixed\", delay = 0.3}");
    assert_eq!((later.ages, later.network.is_constant()), (Some([[0.3; 2]; 2]), true));
    assert_eq!(later.network.delay(), Delay::each_way(0.3).unwrap());
    let buffered = ages("delay = 0.05\njitter = 0.02", "playout = {kind = \"fixed\", delay = 0.07}");
    assert_eq!(buffered.ages, Some([[0.07; 2]; 2]));
    let earlier = ages(
        "delay = 0.05\njitter = {forward = 0.02}\norder = \"fifo\"",
        "playout = {kind = \"fixed\", delay = 0.06}",
    );
    assert_eq!(earlier.ages, Some([[0.06, 0.07], [0.06, 0.06]]));
}

#[test]
fn ref_a_promise_of_a_buffer_that_the_playout_breaks_is_refused() {
    let text = |playout: &str| {
        let robots = "robot1 = {mass = [1, 1], damping = 5}\nrobot2 = {mass = [1, 1], damping = 5}\n";
        format!(
            "{robots}network = {{delay = 0.05, jitter = 0.02, playout_buffer = true}}\nsession.playout = {playout}"
        )
    };
    for broken in ["\"adaptive\"", "{kind = \"fixed\", delay = 0.05}"] {
        let refused = Study::from_toml(&text(broken)).unwrap_err();
        assert_eq!(refused.field, "network.playout_buffer", "{refused}");
    }
    for kept in ["\"fixed\"", "{kind = \"fixed\", delay = 0.07}", "{kind = \"fixed\", delay = 0.2}"] {
        Study::from_toml(&text(kept)).unwrap();
    }
}

/// Damping injection is sized for what is lost and what waits, too.
#[test]
fn ref_the_laboratory_counts_on_what_is_missing() {
    let missing = |network: &str| {
        let lost = study(&format!("delay = 0.05\n{network}"), "strategy = \"injected-damping\"");
        lost.laboratory().unwrap().session.missing
    };
    assert_eq!(missing("jitter = 0.02"), [0.0; 2]);
    // six packets in a row, and the period to the next
    let [forward, backward] = missing("loss = {forward = 0.01}");
    assert!((forward - 0.007).abs() < 1e-12 && backward == 0.0);
    // 1.12 ms for a packet behind 100 others; every second one finds the queue full at times
    let [queued, _] = missing("rate = {bits_per_second = 1e6, queue = 100}");
    assert!((queued - (101.0 * 1.12e-3 + 2.0 * MS)).abs() < 1e-12, "{queued}");
    assert_eq!(missing("loss = 1"), [0.0; 2]);
}
