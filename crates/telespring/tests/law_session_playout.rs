//! Laws of the play-out: what it plays, when, and what it says about it.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use telespring::session::playout::{Histogram, Playing, Sample};
use telespring::session::{AdaptiveDelay, Motion, PeerTime, Playout, PlayoutSettings, Span};

const PERIOD: u64 = 1_000_000;

fn at(x: f64) -> Motion {
    Motion { position: [x, -x], velocity: [2.0 * x, 0.0] }
}

fn fixed(delay: i64) -> Playout {
    Playout::new(PlayoutSettings::Fixed { delay: Span(delay) }, Span(1_000)).unwrap()
}

fn sample(sequence: u64, time: u64, x: f64) -> Sample {
    Sample { sequence, time: PeerTime(time), motion: at(x), signal: [x, 0.0] }
}

fn played(playout: &mut Playout, now: u64) -> Option<Motion> {
    playout.play(PeerTime(now)).map(|playing| playing.motion)
}

#[test]
fn law_the_playout_interpolates_between_samples() {
    let mut playout = fixed(10_000);
    for (n, (time, x)) in [(0, 0.0), (1_000, 1.0), (2_000, 5.0)].into_iter().enumerate() {
        playout.insert(PeerTime(0), sample(n as u64, time, x));
    }
    assert_eq!(played(&mut playout, 9_999), None);
    for (now, x) in
        [(10_000, 0.0), (10_250, 0.25), (11_000, 1.0), (11_500, 3.0), (12_000, 5.0), (99_000, 5.0)]
    {
        let playing = playout.play(PeerTime(now)).unwrap();
        assert_eq!((playing.motion, playing.signal), (at(x), [x, 0.0]), "{now}");
        assert_eq!(playing.held, now > 12_000);
        assert_eq!(playing.age, Span(if now > 12_000 { 97_000 } else { 10_000 }));
    }
}

#[test]
fn law_a_lost_sample_is_bridged_and_a_late_one_taken_up() {
    let mut playout = fixed(1_000);
    playout.insert(PeerTime(0), sample(0, 0, 0.0));
    // the sample of 1000 is missing: the one before is held …
    assert_eq!(played(&mut playout, 1_500), Some(at(0.0)));
    // … bridged by the one after it …
    playout.insert(PeerTime(1_600), sample(2, 2_000, 4.0));
    let playing = playout.play(PeerTime(1_600)).unwrap();
    assert_eq!((playing.motion, playing.ages), (at(1.2), (Span(-400), Span(1_600))));
    assert_eq!(playout.report().lost, 1);
    // … and used when it comes after all
    playout.insert(PeerTime(1_700), sample(1, 1_000, 1.0));
    assert_eq!(played(&mut playout, 1_700), Some(at(0.7)));
    assert_eq!(playout.report().lost, 0);
    // after its turn it changes nothing, and neither does a second one of the same time or number
    playout.insert(PeerTime(3_000), sample(3, 500, 9.0));
    playout.insert(PeerTime(3_000), sample(4, 2_000, 9.0));
    playout.insert(PeerTime(3_000), sample(2, 2_500, 9.0));
    assert_eq!(played(&mut playout, 3_000), Some(at(4.0)));
    let report = playout.report();
    assert_eq!((report.late, report.overtaken, report.repeated, report.received), (1, 1, 1, 5));
}

#[test]
fn law_the_playout_keeps_no_more_than_it_may_play() {
    let mut playout = fixed(5_000);
    for n in 0..1_000 {
        playout.insert(PeerTime(n * 1_000), sample(n, n * 1_000, 0.0));
        assert!(playout.len() <= 7, "{}", playout.len());
    }
    // samples that are never due are bounded too, and give way to those that are
    let mut playout = fixed(5_000);
    let far = 1 << 60;
    for n in 0..10_000 {
        playout.insert(PeerTime(10_000), sample(n, far + n, 0.0));
    }
    assert_eq!(playout.len(), playout.capacity());
    playout.insert(PeerTime(10_000), sample(10_000, 5_000, 3.0));
    assert_eq!(played(&mut playout, 10_000), Some(at(3.0)));
    assert_eq!(playout.report().crowded_out, 10_001 - playout.capacity() as u64);
}

/// What a network does to a packet: when it arrives, if it does, and once more if it is repeated.
type Fate<'a> = &'a mut dyn FnMut(u64) -> [Option<u64>; 2];

/// Sees a tick: the time, all that has arrived so far, and what is played.
type Sight<'a> = &'a mut dyn FnMut(u64, &[Sample], Option<Playing>);

/// Plays a partner at 1 kHz through a network, with the motion x = t; calls `see` at every tick.
fn through(playout: &mut Playout, ticks: u64, fate: Fate<'_>, see: Sight<'_>) {
    let (mut travelling, mut arrived) = (Vec::new(), Vec::new());
    for tick in 0..ticks {
        let now = tick * PERIOD;
        for arrival in fate(now).into_iter().flatten() {
            travelling.push((arrival, sample(tick, now, now as f64 * 1e-9)));
        }
        travelling.sort_by_key(|(arrival, _)| *arrival);
        while travelling.first().is_some_and(|(arrival, _)| *arrival <= now) {
            let (arrival, sample) = travelling.remove(0);
            playout.insert(PeerTime(arrival), sample);
            arrived.push(sample);
        }
        let playing = playout.play(PeerTime(now));
        if let Some(playing) = &playing {
            playout.count(playing);
        }
        see(now, &arrived, playing);
    }
}

/// A network with loss, jitter, repetitions and silences.
fn rough(random: &mut ChaCha8Rng, now: u64) -> [Option<u64>; 2] {
    let mut arrival = || now + 5_000_000 + random.random_range(0..30_000_000);
    let both = [Some(arrival()), Some(arrival())];
    let silent = now % 700_000_000 > 620_000_000;
    let lost = silent || random.random_bool(0.1);
    [both[0].filter(|_| !lost), both[1].filter(|_| !lost && random.random_bool(0.05))]
}

#[test]
fn cross_a_fixed_delay_plays_what_a_search_in_all_samples_finds() {
    // the same choice by another way: from all that has ever come, the latest up to now − delay and the one after it
    for (seed, delay) in [(1, 0_u64), (2, 12_300_000), (3, 31_000_000), (4, 80_000_000)] {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let settings = PlayoutSettings::Fixed { delay: Span(delay as i64) };
        let mut playout = Playout::new(settings, Span(PERIOD as i64)).unwrap();
        let (mut compared, mut held) = (0, 0);
        through(&mut playout, 5_000, &mut |now| rough(&mut random, now), &mut |now, arrived, playing| {
            let expected = now.checked_sub(delay).and_then(|due| {
                let earlier = arrived.iter().filter(|sample| sample.time.0 <= due).max_by_key(|s| s.time)?;
                let later = arrived.iter().filter(|sample| sample.time.0 > due).min_by_key(|s| s.time);
                let Some(later) = later else { return Some((earlier.motion, earlier.time.0 < due)) };
                let share = (due - earlier.time.0) as f64 / (later.time.0 - earlier.time.0) as f64;
                let between = |from: f64, to: f64| from + share * (to - from);
                let motion = Motion {
                    position: [0, 1].map(|i| between(earlier.motion.position[i], later.motion.position[i])),
                    velocity: [0, 1].map(|i| between(earlier.motion.velocity[i], later.motion.velocity[i])),
                };
                Some((motion, false))
            });
            assert_eq!(playing.map(|playing| (playing.motion, playing.held)), expected, "{delay}, {now}");
            compared += u64::from(expected.is_some());
            held += u64::from(expected.is_some_and(|(_, held)| held));
        });
        let report = playout.report();
        assert_eq!((report.ticks, report.held_ticks), (compared, held));
        assert!(compared > 4_000 && report.lost > 300 && report.repeated > 100, "{report:?}");
    }
}

#[test]
fn law_the_played_instant_never_goes_back_and_an_adaptive_one_never_jumps() {
    for seed in 0..8 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let slew = [0.02, 0.1, 0.5][seed as usize % 3];
        let adaptive = AdaptiveDelay { slew, window: Span(300_000_000), ..AdaptiveDelay::default() };
        let settings = if seed < 6 {
            PlayoutSettings::Adaptive(adaptive)
        } else {
            PlayoutSettings::Fixed { delay: Span(20_000_000) }
        };
        let mut playout = Playout::new(settings, Span(PERIOD as i64)).unwrap();
        let mut before: Option<Playing> = None;
        let mut holes = 0;
        through(&mut playout, 10_000, &mut |now| rough(&mut random, now), &mut |now, _, playing| {
            holes += u64::from(before.is_some() && playing.is_none());
            let Some(playing) = playing else { return };
            assert_eq!(playing.age, PeerTime(now) - playing.time);
            if let Some(before) = before {
                let step = playing.time - before.time;
                assert!(step >= Span(0), "{seed}, {now}: {step:?}");
                assert_eq!(playing.fresh, step > Span(0));
                if seed < 6 {
                    // the motion is x = t, so its step is that of the instant; one nanosecond of rounding
                    let most = PERIOD as f64 * (1.0 + slew) + 1.0;
                    assert!(step.0 as f64 <= most, "{seed}, {now}: {step:?}");
                    let moved = playing.motion.position[0] - before.motion.position[0];
                    assert!(moved <= most * 1e-9 + 1e-12, "{seed}, {now}: {moved}");
                }
            }
            before = Some(playing);
        });
        assert_eq!(holes, 0);
        assert!(before.is_some());
    }
}

#[test]
fn ref_an_adaptive_delay_is_the_quantile_of_the_ages_one_period_and_the_margin() {
    // ages exponentially distributed above 10 ms with a mean of 5 ms more: the quantile q is 10 − 5 ln(1 − q) ms
    for quantile in [0.5, 0.9, 0.99] {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let adaptive = AdaptiveDelay { quantile, margin: Span(2_000_000), ..AdaptiveDelay::default() };
        let mut playout = Playout::new(PlayoutSettings::Adaptive(adaptive), Span(PERIOD as i64)).unwrap();
        let mut fate = |now| {
            let age = 10e6 - 5e6 * (1.0 - random.random::<f64>()).ln();
            [Some(now + age as u64), None]
        };
        through(&mut playout, 20_000, &mut fate, &mut |_, _, _| {});
        let expected = 10e-3 - 5e-3 * (1.0 - quantile).ln() + 1e-3 + 2e-3;
        let delay = playout.delay().seconds();
        // the bins are a 32nd wide; four standard errors of the quantile of 10⁴ ages
        let error = 4.0 * 5e-3 * (quantile / (1.0 - quantile) / 1e4).sqrt();
        assert!(
            (expected - error..(expected + error) * (1.0 + 1.0 / 32.0)).contains(&delay),
            "{quantile}: {delay}"
        );
        let report = playout.report();
        let held = report.held_share();
        assert!(held < (1.0 - quantile) / 2.0, "{quantile}: {held}");
        // those that are still on their way
        assert!(report.lost < 60, "{}", report.lost);
    }
}

#[test]
fn law_an_adaptive_delay_follows_a_network_that_gets_slower_and_faster() {
    let adaptive = AdaptiveDelay { window: Span(1_000_000_000), ..AdaptiveDelay::default() };
    let mut playout = Playout::new(PlayoutSettings::Adaptive(adaptive), Span(PERIOD as i64)).unwrap();
    let way = |now: u64| if (4_000_000_000..8_000_000_000).contains(&now) { 60_000_000 } else { 20_000_000 };
    let mut ages = Vec::new();
    through(&mut playout, 14_000, &mut |now| [Some(now + way(now)), None], &mut |_, _, playing| {
        ages.push(playing.map(|playing| playing.age.seconds()));
    });
    // the way, a period and the margin of 1 ms each; the bins are a 32nd wide, and an age is met to a period
    for (tick, way) in [(3_900, 20e-3), (7_900, 60e-3), (13_900, 20e-3)] {
        let (age, wanted) = (ages[tick].unwrap(), way + 2e-3);
        assert!((wanted - 1e-6..wanted * 33.0 / 32.0 + 1e-3).contains(&age), "{tick}: {age}");
    }
    let report = playout.report();
    assert!(report.ages.unwrap().largest >= Span(60_000_000), "{report:?}");
}

#[test]
fn law_the_report_agrees_with_a_list_of_all_ages() {
    let mut random = ChaCha8Rng::seed_from_u64(9);
    let settings = PlayoutSettings::Fixed { delay: Span(25_000_000) };
    let mut playout = Playout::new(settings, Span(PERIOD as i64)).unwrap();
    assert_eq!(playout.report().ages, None);
    let (mut ages, mut oldest, mut newest) = (Vec::new(), Span(0), Span(i64::MAX));
    through(&mut playout, 8_000, &mut |now| rough(&mut random, now), &mut |_, _, playing| {
        if let Some(playing) = playing {
            ages.push(playing.age);
            (newest, oldest) = (newest.min(playing.ages.0), oldest.max(playing.ages.1));
        }
    });
    ages.sort();
    let report = playout.report().ages.unwrap();
    let mean = ages.iter().map(|age| age.0 as f64).sum::<f64>() / ages.len() as f64;
    assert!((report.mean.0 as f64 - mean).abs() <= 1.0);
    assert_eq!((report.smallest, report.largest), (newest, oldest));
    for (quantile, reported) in [(0.5, report.median), (0.9, report.quantile_90), (0.99, report.quantile_99)]
    {
        let exact = ages[(quantile * ages.len() as f64).ceil() as usize - 1];
        assert!(exact <= reported && reported.0 <= exact.0 + exact.0 / 32 + 1_024, "{quantile}");
    }
    // all ages lie in [d − J, d + J]
    let (middle, half) = report.range();
    assert!(middle - half <= newest && middle + half == oldest && (newest - (middle - half)) <= Span(1));
}

#[test]
fn law_a_histogram_finds_every_span_within_a_32nd() {
    for power in 0..50 {
        for offset in [-1, 0, 1, 12_345] {
            let span = Span((1_i64 << power) + offset).max(Span(0));
            let mut one = Histogram::new();
            one.add(span);
            let found = one.quantile(0.5).unwrap();
            let within = span.0 / 32 + 1_024;
            assert!(power > 44 || (span < found && found.0 <= span.0 + within), "{span:?}: {found:?}");
            one.remove(span);
            assert!(one.is_empty() && one.quantile(0.5).is_none());
        }
    }
}
