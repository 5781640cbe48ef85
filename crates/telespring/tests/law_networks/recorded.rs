//! Recorded traces: read, described, replayed, fitted to the models.

use std::sync::Arc;

use telespring::InvalidInput;
use telespring::rig::trace::{IrttDelay, TimeUnit, TraceUnits};
use telespring::rig::{GilbertElliott, JitterDistribution, NetworkModel, Trace, TraceRow};

use crate::passage::{passage, passage_towards};

#[test]
fn law_a_recorded_trace_is_played_in_a_circle_from_a_place_of_the_seed() {
    let row = |time, delay, lost| TraceRow { time, delay, lost };
    let rows = vec![row(0.0, 0.005, false), row(0.01, 0.0, true), row(0.02, 0.03, false)];
    let trace = Arc::new(Trace::new(rows).unwrap());
    assert_eq!(trace.duration(), 0.03);
    let model = NetworkModel { trace: Some(trace), ..NetworkModel::ideal() };
    // packets every ms: the place shows to the ms
    let place = |seed: u64, side: usize| {
        let mut came = passage_towards(&model, seed, side, 60, 1_000_000);
        came.sort_unstable();
        let expected = |place: u64| {
            (0..60).filter_map(move |n| match (n + place) % 30 {
                0..10 => Some((n, 5_000_000)),
                10..20 => None,
                _ => Some((n, 30_000_000)),
            })
        };
        (0..30).find(|place| came.iter().copied().eq(expected(*place))).expect("the trace from some place on")
    };
    let places: Vec<_> = (0..40).map(|seed| place(seed, 0)).collect();
    // both ways were recorded at the same time
    assert!((0..40).all(|seed| place(seed, 1) == places[seed as usize]));
    // of 30 places, 40 seeds draw 22 on average
    let distinct = places.iter().collect::<std::collections::BTreeSet<_>>();
    assert!(distinct.len() > 15, "{places:?}");
}

/// A trace of this text, or its refusal.
pub fn read(text: &str) -> Result<Trace, InvalidInput> {
    Trace::from_csv(text, TraceUnits::default())
}

#[test]
fn ref_a_table_is_read_with_its_units_and_separators() {
    let expected = read("time_s,delay_s,lost\n0,0.025,0\n0.02,,1\n0.05,0.03,0\n").unwrap();
    for text in [
        "time(ms) delay(ms) lost other\n1723189086537 25 0 x\n1723189086557 nan true x\n1723189086587 30 no x\n",
        "\u{feff}# recorded\nlost;delay [ms];sent [us]\n0;25,0;0\n1;;20000\n0;30,0;50000\n",
        "pub_time_ns\trtt_us\n0\t25000\n20000000\t\n50000000\t30000\n",
    ] {
        let trace = read(text).unwrap();
        for (row, wanted) in trace.rows().iter().zip(expected.rows()) {
            assert!(
                (row.time - wanted.time).abs() < 1e-12 && (row.delay - wanted.delay).abs() < 1e-12,
                "{text}"
            );
            assert_eq!(row.lost, wanted.lost, "{text}");
        }
        assert_eq!(trace.rows().len(), 3);
    }
    let units = TraceUnits { time: Some(TimeUnit::Seconds), delay: Some(TimeUnit::Milliseconds) };
    assert_eq!(Trace::from_csv("time,delay\n0,1\n1,2\n", units).unwrap().rows()[1].delay, 0.002);
    assert_eq!(expected.halved().rows()[2].delay, 0.015);
}

#[test]
fn law_a_trace_that_says_nothing_is_refused_with_its_place() {
    for (text, field) in [
        ("", "trace, column time"),
        ("when,delay_s\n0,1\n", "trace, column time"),
        ("time_s,lost\n0,1\n", "trace, column delay"),
        ("time,delay_ms\n0,1\n1,1\n", "trace, unit of time"),
        ("time_s,delay\n0,1\n1,1\n", "trace, unit of delay"),
        ("time_s,delay_s\n0,1\n1,x\n", "trace, line 3, delay"),
        ("time_s,delay_s,lost\n0,1,2\n", "trace, line 2, lost"),
        ("time_s,delay_s\n0,1\n2,1\n1,1\n", "trace row 3, time"),
        ("time_s,delay_s\n0,1\n1,-0.001\n", "trace row 2, delay"),
        ("time_s,delay_s\n0,1\n1,101\n", "trace row 2, delay"),
        ("time_s,delay_s\n0,1\nnan,1\n", "trace row 2, time"),
        ("time_s,delay_s\n0,1\n", "trace"),
        ("time_s,delay_s,lost\n0,1,1\n1,1,1\n", "trace"),
        ("time_s,delay_s\n0,1\n0,1\n", "trace"),
    ] {
        let refused = read(text).unwrap_err();
        assert_eq!(refused.field, field, "{text:?}: {refused}");
    }
    assert_eq!(Trace::from_irtt("{}", IrttDelay::RoundTrip).unwrap_err().field, "trace");
}

#[test]
fn ref_statistics_of_a_small_trace_by_hand() {
    // the second is still under way when the fifth comes
    let text = "time_ms,delay_ms,lost\n0,20,0\n10,55,0\n20,,1\n30,,1\n40,20,0\n50,,1\n60,40,0\n";
    let statistics = read(text).unwrap().statistics();
    assert_eq!((statistics.sent, statistics.interval), (7, 0.01));
    assert!((statistics.loss - 3.0 / 7.0).abs() < 1e-15);
    assert_eq!(statistics.burst_length, 1.5);
    // packet 2 arrives at 65 ms, packet 5 at 60 ms: one of four was overtaken
    assert_eq!(statistics.reordered, 0.25);
    assert!((statistics.mean - 0.03375).abs() < 1e-15);
    assert!((statistics.median - 0.03).abs() < 1e-15);
    assert_eq!((statistics.minimum, statistics.maximum), (0.02, 0.055));
    let trace = read(text).unwrap();
    // sorted 20, 20, 40, 55: three quarters lie at place 2.25
    assert!((trace.quantile(0.75) - 0.04375).abs() < 1e-15);
}

/// A trace that the emulator makes: packets every ms.
fn recorded(model: &NetworkModel, packets: u64) -> Trace {
    let mut rows: Vec<TraceRow> =
        (0..packets).map(|n| TraceRow { time: n as f64 * 1e-3, delay: 0.0, lost: true }).collect();
    for (number, delay) in passage(model, 21, packets, 10_000) {
        rows[number as usize] = TraceRow { delay: delay as f64 * 1e-9, lost: false, ..rows[number as usize] };
    }
    Trace::new(rows).unwrap()
}

#[test]
fn law_the_fit_finds_the_model_that_made_the_trace() {
    let burst = GilbertElliott { to_bad: 0.02, to_good: 0.4, loss_good: 0.0, loss_bad: 1.0 };
    for distribution in [
        JitterDistribution::Uniform,
        JitterDistribution::Normal { mean: 0.01, sd: 0.002 },
        JitterDistribution::Gamma { mean: 0.006, sd: 0.003 },
        JitterDistribution::LogNormal { mean: 0.006, sd: 0.004 },
    ] {
        let model = NetworkModel { jitter: 0.04, distribution, burst: Some(burst), ..NetworkModel::ideal() };
        let trace = recorded(&model, 6000);
        let fit = trace.fit();
        let best = fit.jitter[0];
        // not told apart with certainty: gamma and log-normal resemble a normal distribution far from 0
        assert!(best.distance < 0.02, "{distribution:?}: {best:?}");
        let mut quantiles = 0.0_f64;
        for share in 1..100 {
            let at = trace.quantile(f64::from(share) / 100.0);
            let fitted = best.distribution.cumulative(at - best.delay, best.jitter);
            quantiles = quantiles.max((fitted - f64::from(share) / 100.0).abs());
        }
        assert!(quantiles < 0.025, "{distribution:?}: {quantiles}");
        let same = fit
            .jitter
            .iter()
            .find(|one| std::mem::discriminant(&one.distribution) == std::mem::discriminant(&distribution))
            .unwrap();
        assert!(same.distance < 0.02, "{distribution:?}: {same:?}");
        // the wrong end of the list fits visibly worse
        assert!(fit.jitter.last().unwrap().distance > 2.0 * best.distance, "{:?}", fit.jitter);
        let found = fit.burst.unwrap();
        // 4 standard errors of a share
        assert!((found.model.to_bad - 0.02).abs() < 4.0 * (0.02_f64 / 5700.0).sqrt(), "{found:?}");
        assert!((found.model.to_good - 0.4).abs() < 4.0 * (0.24_f64 / 290.0).sqrt(), "{found:?}");
        assert!(found.distance < 0.1, "{found:?}");
        let (delay, fitted) = fit.model();
        fitted.check().unwrap();
        assert!(delay > 0.0 && delay < 0.0205 + 0.01, "{delay}");
    }
}
