//! Laws of the logs of `ping -D` that are read as traces.

use std::fmt::Write as _;

use proptest::prelude::*;
use telespring::rig::Trace;
use telespring::rig::trace::{IrttDelay, TraceFormat, TraceUnits};
use telespring::study::TraceFile;

/// When the first packet of a log is sent, s since 1970.
const START: i64 = 1_700_000_000;

/// One packet of a log that is written: sent every `interval` ms, answered after this time in ms, or never.
type Fate = Option<u32>;

/// The log that `ping -D -O` writes: lines in the order of arrival, times at the arrival, numbers of 16 bits.
fn log(first: u32, interval: u32, fates: &[Fate]) -> String {
    let mut lines: Vec<(u32, String)> = Vec::new();
    for (index, fate) in fates.iter().enumerate() {
        let sent = interval * index as u32;
        let number = (first + index as u32) % 65_536;
        let stamp = |ms: u32| format!("[{}.{:06}]", START + i64::from(ms / 1000), ms % 1000 * 1000);
        if fate.is_none_or(|taken| taken > interval) {
            let due = sent + interval;
            lines.push((due, format!("{} no answer yet for icmp_seq={number}", stamp(due))));
        }
        if let Some(taken) = fate {
            let came = sent + taken;
            let answer =
                format!("{} 64 bytes from 10.0.0.2: icmp_seq={number} ttl=64 time={taken} ms", stamp(came));
            lines.push((came, answer));
        }
    }
    lines.sort_by_key(|(time, _)| *time);
    let mut text = "PING host (10.0.0.2) 56(84) bytes of data.\n".to_owned();
    for (_, line) in lines {
        writeln!(text, "{line}").unwrap();
    }
    text
}

proptest! {
    #[test]
    fn law_a_log_is_read_back_as_written(
        fates in prop::collection::vec(prop::option::weighted(0.8, 1..400_u32), 3..80),
        interval in 1..300_u32,
        wraps in any::<bool>(),
    ) {
        let came: Vec<usize> = (0..fates.len()).filter(|index| fates[*index].is_some()).collect();
        prop_assume!(came.len() >= 2);
        // a log that begins at a high number has lost its header
        let text = log(if wraps { 65_500 } else { 1 }, interval, &fates);
        let text = if wraps { text.split_once('\n').unwrap().1 } else { &text };
        prop_assert_eq!(TraceFormat::of(text), TraceFormat::Ping);
        let trace = Trace::from_ping(text).unwrap();
        prop_assert_eq!(trace.rows().len(), fates.len());
        prop_assert!(trace.has_losses_recorded());
        for (index, (row, fate)) in trace.rows().iter().zip(&fates).enumerate() {
            prop_assert_eq!(row.lost, fate.is_none());
            // times are written in whole ms, and those of lost packets follow from their neighbours
            prop_assert!((row.time - 1e-3 * f64::from(interval) * index as f64).abs() < 1e-6);
            prop_assert!((row.delay - 1e-3 * f64::from(fate.unwrap_or(0))).abs() < 1e-12);
        }
        // a way that is not said to be a round trip has half of each
        let file = |is_round_trip| TraceFile { path: "ping.log".to_owned(), is_round_trip };
        prop_assert_eq!(&file(true).trace(text, true).unwrap(), &trace);
        prop_assert_eq!(file(false).trace(text, true).unwrap(), trace.halved());
    }

    #[test]
    fn law_no_text_makes_a_reader_panic(
        lines in prop::collection::vec(
            prop_oneof![
                "[\\[\\]0-9.a-z= ,%{}:\"\\-]{0,60}",
                "\\[[0-9]{1,22}(\\.[0-9]{0,20})?\\] 64 bytes from h: icmp_seq=[0-9]{1,12} ttl=64 time=[0-9.,]{0,25} ?ms",
                "[0-9]{1,20} packets transmitted, 3 received, 1% packet loss",
                "(\\[1[0-9]{0,3}\\] )?no answer yet for icmp_seq=[0-9]{1,5}",
                "PING h.*",
                "\\PC{0,40}",
            ],
            0..30,
        )
    ) {
        let text = lines.join("\n");
        let _ = TraceFormat::of(&text);
        for read in [
            Trace::from_ping(&text),
            Trace::from_irtt(&text, IrttDelay::RoundTrip),
            Trace::from_csv(&text, TraceUnits::default()),
            Trace::from_csv(&format!("time_s,delay_ms\n{text}"), TraceUnits::default()),
        ] {
            match read {
                Ok(trace) => prop_assert!(trace.statistics().sent >= 2),
                Err(refused) => prop_assert!(!refused.remedy.is_empty()),
            }
        }
    }
}

#[test]
fn ref_the_start_the_end_and_the_middle_of_a_log() {
    // the first two packets, two in the middle and the last three are lost; the summary counts them
    let answered = [3, 4, 5, 8, 9, 10];
    let mut text = "PING h (10.0.0.2) 56(84) bytes of data.\n".to_owned();
    for number in answered {
        let came = 100 * number + 20;
        writeln!(
            text,
            "[{}.{:03}] 64 bytes from 10.0.0.2: icmp_seq={number} ttl=64 time=20.0 ms",
            START + came / 1000,
            came % 1000
        )
        .unwrap();
    }
    text += "[1700000001.500] 64 bytes from 10.0.0.2: icmp_seq=9 ttl=64 time=520 ms (DUP!)\n";
    text += "From 10.0.0.1 icmp_seq=11 Destination Host Unreachable\n";
    let lost = |text: &str| {
        let trace = Trace::from_ping(text).unwrap();
        assert!(trace.rows().iter().filter(|row| !row.lost).all(|row| row.delay == 0.02));
        (0..).zip(trace.rows()).filter(|(_, row)| row.lost).map(|(index, _)| index + 1).collect::<Vec<i32>>()
    };
    assert_eq!(lost(&text), [1, 2, 6, 7, 11]);
    // of the last one nothing is known: it was on its way
    let summary =
        "\n--- h ping statistics ---\n13 packets transmitted, 6 received, 53% packet loss, time 1200ms\n";
    assert_eq!(lost(&format!("{text}{summary}")), [1, 2, 6, 7, 11, 12]);
    // without its beginning nothing says what was sent before
    assert_eq!(lost(text.split_once('\n').unwrap().1), [4, 5, 9].map(|number| number));
}

#[test]
fn law_a_log_that_says_too_little_is_refused_with_a_remedy() {
    let answer = "[1700000000.1] 64 bytes from h: icmp_seq=1 ttl=64 time=20 ms\n";
    let later = answer.replace("000.1", "001.1").replace("seq=1", "seq=2");
    assert!(Trace::from_ping(&format!("{answer}{later}")).is_ok());
    for (text, field) in [
        (answer.to_owned(), "ping log"),
        (answer.replace("[1700000000.1] ", ""), "ping log, line 1"),
        ("PING h (1.2.3.4)\nno answer yet for icmp_seq=1\n".to_owned(), "ping log"),
        ("Reply from 8.8.8.8: bytes=32 time=14ms TTL=118\n".to_owned(), "ping log"),
        // two logs in one file
        (format!("PING h\n{answer}{later}PING h\n{answer}"), "ping log, line 4"),
        // the clock was set back by a minute
        (
            format!("{answer}{}", later.replace("0001.1", "0000.0").replace("17000", "16999")),
            "ping log, icmp_seq 1",
        ),
    ] {
        let refused = Trace::from_ping(&text).unwrap_err();
        assert_eq!(refused.field, field, "{text}: {refused}");
        assert!(refused.remedy.len() > 20);
    }
}
