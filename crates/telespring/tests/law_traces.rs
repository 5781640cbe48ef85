//! Laws of recorded traces that are played, read and written.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use telespring::rig::trace::{IrttDelay, TraceUnits};
use telespring::rig::{Trace, TraceRow};
use telespring::study::TraceFile;

const MS: f64 = 1e-3;

/// A random trace: packets at irregular times, delays that overtake each other, losses in a row.
fn random_trace(random: &mut ChaCha8Rng) -> Trace {
    let (mut time, mut lost) = (0.0, false);
    let rows = (0..60).map(|_| {
        time += MS * random.random_range(1..8) as f64;
        lost = random.random::<f64>() < if lost { 0.6 } else { 0.1 };
        TraceRow { time, delay: MS * random.random_range(0..40) as f64, lost }
    });
    Trace::new(rows.collect()).unwrap()
}

/// The ages in use at each tick of a session over a trace that is repeated without end, from the definition. Times are in
/// whole units of `unit` s, ticks `period` units apart from `phase` on.
fn ages_by_definition(trace: &Trace, delay: i64, unit: f64, period: i64, phase: i64) -> Vec<(i64, i64)> {
    let whole = |seconds: f64| (seconds / unit).round() as i64;
    let round = whole(trace.duration());
    let times: Vec<i64> = trace.rows().iter().map(|row| whole(row.time)).collect();
    let arrives = |sent: i64| {
        let row = trace.rows()[times.partition_point(|time| *time <= sent.rem_euclid(round)) - 1];
        if row.lost { i64::MAX } else { sent + whole(row.delay) }
    };
    (phase..round)
        .step_by(period as usize)
        .map(|now| {
            let due = now - delay;
            let played = now - (delay + period - 1) / period * period;
            let earlier = (0..).map(|n| played - n * period).find(|sent| arrives(*sent) <= now).unwrap();
            let next = played + period;
            if earlier == played && (played == due || next <= now && arrives(next) <= now) {
                return (delay, delay);
            }
            match (1..)
                .map(|n| played + n * period)
                .take_while(|sent| *sent <= now)
                .find(|sent| arrives(*sent) <= now)
            {
                None => (now - earlier, now - earlier),
                Some(later) => (now - later, now - earlier),
            }
        })
        .collect()
}

#[test]
fn cross_ages_as_played_follow_from_the_definition() {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    for _ in 0..40 {
        let trace = random_trace(&mut random);
        for delay in [0, 5, 12, 25, 39, 60] {
            let wanted = ages_by_definition(&trace, delay, MS, 1, 0);
            let late: Vec<_> = wanted.iter().filter(|ages| **ages != (delay, delay)).collect();
            let played = trace.play(delay as f64 * MS, MS).unwrap();
            let got: Vec<_> = played
                .late
                .iter()
                .map(|ages| ((ages[0] * 1e3).round() as i64, (ages[1] * 1e3).round() as i64))
                .collect();
            assert_eq!(played.ticks, wanted.len());
            assert!(got.iter().eq(late.iter().copied()), "{delay} ms");
            let extremes = wanted
                .iter()
                .fold((i64::MAX, 0), |(low, high), (newest, oldest)| (low.min(*newest), high.max(*oldest)));
            let [low, high] = played.ages();
            assert_eq!(((low * 1e3).round() as i64, (high * 1e3).round() as i64), extremes);
            let within = wanted.iter().filter(|(newest, oldest)| *newest >= 10 && *oldest <= 30).count();
            let share = within as f64 / wanted.len() as f64;
            assert!((played.share_within(9.5 * MS, 30.5 * MS) - share).abs() < 1e-12);
        }
    }
}

#[test]
fn cross_the_ages_hold_wherever_the_ticks_fall_between_recorded_packets() {
    let mut random = ChaCha8Rng::seed_from_u64(10);
    let (mut reached, mut cases, unit) = (0, 0, 1e-5);
    for case in 0..60 {
        // packets at any 10 µs; every other trace has some that are closer than the ticks
        let apart = if case % 2 == 0 { 100..700 } else { 20..300 };
        let (mut time, mut lost) = (0.0, false);
        let rows = (0..60).map(|_| {
            time += unit * f64::from(random.random_range(apart.clone()));
            lost = random.random::<f64>() < if lost { 0.6 } else { 0.1 };
            TraceRow { time, delay: unit * f64::from(random.random_range(0..3000)), lost }
        });
        let trace = Trace::new(rows.collect()).unwrap();
        for delay in [0, 150, 1000, 2500, 2530] {
            let played = trace.play(f64::from(delay) * unit, MS).unwrap();
            let [low, high] = played.ages();
            let [mut youngest, mut oldest] = [f64::INFINITY, 0.0_f64];
            for phase in (0..100).step_by(7) {
                for (newest, old) in ages_by_definition(&trace, i64::from(delay), unit, 100, phase) {
                    youngest = youngest.min(newest as f64 * unit);
                    oldest = oldest.max(old as f64 * unit);
                }
            }
            let rounding = 1e-9;
            assert!(
                low <= youngest + rounding && oldest <= high + rounding,
                "{case}: {low} {youngest} {oldest} {high}"
            );
            cases += 1;
            reached += usize::from(low >= youngest - MS - rounding && oldest >= high - MS - rounding);
        }
    }
    // they are not much too wide: within a tick in most cases
    assert!(2 * reached > cases, "{reached} of {cases}");
}

#[test]
fn law_it_does_not_matter_where_a_recording_begins() {
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let mut lost = false;
    let mut row = |_| {
        lost = random.random::<f64>() < if lost { 0.9 } else { 0.05 };
        (MS * f64::from(random.random_range(0..400)), lost)
    };
    let fates: Vec<(f64, bool)> = (0..80).map(&mut row).collect();
    let turned = |by: usize| {
        let fate = |n: usize| fates[(n + by) % fates.len()];
        let row = |n| TraceRow { time: 5.0 * MS * n as f64, delay: fate(n).0, lost: fate(n).1 };
        Trace::new((0..fates.len()).map(row).collect()).unwrap()
    };
    for delay in [0.0, 0.05, 0.3] {
        let played = turned(0).play(delay, MS).unwrap();
        for by in [1, 17, 40, 79] {
            let again = turned(by).play(delay, MS).unwrap();
            assert_eq!(
                (again.ages(), again.ticks, again.late.len()),
                (played.ages(), played.ticks, played.late.len())
            );
            let half = again.ages()[1] / 2.0;
            assert_eq!(again.share_within(0.0, half), played.share_within(0.0, half));
        }
    }
}

#[test]
fn ref_an_outage_at_the_start_and_a_packet_after_the_end_count() {
    let row = |n: u32, lost, delay| TraceRow { time: 0.01 * f64::from(n), delay, lost };
    // nothing came for the first second
    let start = Trace::new((0..300).map(|n| row(n, n < 100, 0.02)).collect()).unwrap();
    // the last motion before the second came 20 ms after its measurement; then one was sent every ms
    assert_eq!(start.play(0.02, MS).unwrap().ages(), [0.02, 1.02]);
    assert_eq!(start.statistics().loss, 1.0 / 3.0);
    // all that was sent in the last 100 ms takes 500 ms
    let end =
        Trace::new((0..300).map(|n| row(n, false, if n < 290 { 0.02 } else { 0.5 })).collect()).unwrap();
    let [low, high] = end.play(0.02, MS).unwrap().ages();
    assert_eq!(low, 0.02);
    assert!((high - 0.12).abs() < 1e-9, "{high}");
}

#[test]
fn law_a_play_out_beyond_all_delays_makes_them_constant() {
    let mut random = ChaCha8Rng::seed_from_u64(8);
    let rows = (0..200).map(|n| TraceRow {
        time: 5.0 * MS * f64::from(n),
        delay: MS * random.random_range(10.0..50.0),
        lost: false,
    });
    let trace = Trace::new(rows.collect()).unwrap();
    let played = trace.play(0.05, MS).unwrap();
    assert_eq!((played.in_time(), played.ages(), played.held_ticks), (1.0, [0.05, 0.05], 0));
    assert_eq!(played.share_within(0.05, 0.05), 1.0);
    assert_eq!(played.share_within(0.0, 0.04), 0.0);
}

#[test]
fn law_what_cannot_be_played_is_refused() {
    let row = |time| TraceRow { time, delay: 0.02, lost: false };
    let trace = Trace::new(vec![row(0.0), row(0.01)]).unwrap();
    for (delay, period, field) in
        [(-1.0, MS, "delay"), (0.01, 0.0, "sample_period"), (0.01, 1e-10, "sample_period")]
    {
        assert_eq!(trace.play(delay, period).unwrap_err().field, field, "{delay} {period}");
    }
    // every other packet is lost, twice in each period: a session would send the lost ones only
    let lost = |n: u32| TraceRow { time: 5e-4 * f64::from(n), delay: 0.0, lost: n % 2 == 1 };
    let close = Trace::new((0..100).map(lost).collect()).unwrap();
    assert_eq!(close.play(0.01, MS).unwrap_err().field, "sample_period");
    let long = Trace::new(vec![row(0.0), row(1e6)]).unwrap();
    assert_eq!(long.play(0.05, MS).unwrap_err().field, "sample_period");
}

#[test]
fn law_a_trace_is_read_back_as_written() {
    let mut random = ChaCha8Rng::seed_from_u64(9);
    for _ in 0..20 {
        let trace = random_trace(&mut random).with_losses_recorded();
        assert_eq!(Trace::from_csv(&trace.to_csv(), TraceUnits::default()).unwrap(), trace);
    }
}

#[test]
fn law_a_recording_says_whether_it_has_rows_for_losses() {
    let read = |text: &str| Trace::from_csv(text, TraceUnits::default()).unwrap();
    assert!(!read("time_s,delay_s\n0,1\n1,1\n").has_losses_recorded());
    assert!(read("time_s,delay_s,lost\n0,1,0\n1,1,0\n").has_losses_recorded());
    assert!(read("time_s,delay_s\n0,1\n1,\n").has_losses_recorded());
    assert!(
        read("time_s,delay_s\n0,1\n1,1\n3,1\n").with_missing_rows(1.0, 5.0).unwrap().has_losses_recorded()
    );
    let irtt = r#"{"round_trips": [
        {"lost": "false", "timestamps": {"client": {"send": {"wall": 0}}}, "delay": {"rtt": 20000000}},
        {"lost": "false", "timestamps": {"client": {"send": {"wall": 5000000}}}, "delay": {"rtt": 20000000}}]}"#;
    assert!(Trace::from_irtt(irtt, IrttDelay::RoundTrip).unwrap().has_losses_recorded());
}

#[test]
fn law_a_column_of_round_trips_is_not_taken_as_one_way() {
    let file = |is_round_trip| TraceFile { path: "p.csv".to_owned(), is_round_trip };
    let text = "time_s;rtt_ms\n0;20\n1;22\n";
    let refused = file(false).trace(text, true).unwrap_err();
    assert_eq!(refused.field, "p.csv, trace, column delay");
    assert_eq!(file(true).trace(text, true).unwrap().rows()[1].delay, 0.022);
    assert!(file(false).trace("time_s;rtt_ms;delay_ms\n0;20;9\n1;22;9\n", true).is_ok());
}
