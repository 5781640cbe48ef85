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

/// The ages in use at each tick, ms, from the definition: `None` before the first sample is due and there.
fn ages_by_definition(trace: &Trace, delay: i64) -> Vec<Option<(i64, i64)>> {
    let whole = |seconds: f64| (seconds * 1e3).round() as i64;
    let ticks = whole(trace.duration());
    let fate = |sent: i64| *trace.rows().iter().rfind(|row| whole(row.time) <= sent).unwrap();
    (0..ticks)
        .map(|now| {
            let arrived = |sent: &i64| {
                let row = fate(*sent);
                !row.lost && sent + whole(row.delay) <= now
            };
            let due = now - delay;
            let earlier = (0..=due).rev().find(arrived)?;
            if earlier == due {
                return Some((delay, delay));
            }
            match (due + 1..=now).find(arrived) {
                None => Some((now - earlier, now - earlier)),
                Some(later) => Some((now - later, now - earlier)),
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
            let wanted: Vec<_> = ages_by_definition(&trace, delay).into_iter().flatten().collect();
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
    for (delay, period, field) in [
        (0.05, MS, "trace"),
        (-1.0, MS, "delay"),
        (0.01, 0.0, "sample_period"),
        (0.01, 1e-10, "sample_period"),
    ] {
        assert_eq!(trace.play(delay, period).unwrap_err().field, field, "{delay} {period}");
    }
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
