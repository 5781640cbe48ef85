//! The console: the status of a site in virtual time, and the lines of the program.

mod common;

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, Stdio};

use common::{Pair, hman_study};
use serde_json::Value;
use telespring::session::Span;
use telespring_link::console::{Gauge, Status};

const GUARD: &str = "coupling.stiffness = 142.0\nnetwork.delay = 0.02\n\
                     session = {strategy = \"guard\", playout = \"adaptive\"}";

/// Ticks both sites for this many milliseconds; the statuses of the first, whose ticks are late and left out as `pace` says.
fn statuses(
    pair: &mut Pair,
    gauge: &mut Gauge,
    milliseconds: u64,
    mut before: impl FnMut(&mut Pair, u64),
    pace: impl Fn(u64) -> (Span, u64),
) -> Vec<Status> {
    let mut told = Vec::new();
    for tick in 0..milliseconds {
        before(pair, tick);
        pair.tick();
        let (lateness, overruns) = pace(tick);
        told.extend(gauge.take(&pair.moment(0), lateness, overruns));
    }
    told
}

fn on_time(_: u64) -> (Span, u64) {
    (Span(0), 0)
}

#[test]
fn law_a_status_comes_ten_times_per_second_and_speaks_of_the_last_second() {
    let study = hman_study(GUARD);
    let mut pair = Pair::new([&study; 2], 0.02);
    let mut gauge = Gauge::new(1);
    let told = statuses(
        &mut pair,
        &mut gauge,
        6000,
        // one packet of four is lost from 2 to 4 s
        |pair, tick| pair.ends[0].wire.borrow_mut().is_cut[0] = (2000..4000).contains(&tick) && tick % 4 == 0,
        // 0 to 99 µs late; 7 ticks left out after 3 s
        |tick| (Span((tick % 100 * 1000).cast_signed()), if tick < 3000 { 0 } else { 7 }),
    );
    assert_eq!(told.len(), 60);
    let at = |seconds: f64| told.iter().find(|status| status.time >= seconds - 1e-9).unwrap();
    assert!(told.windows(2).all(|pair| (pair[1].time - pair[0].time - 0.1).abs() < 1e-9));
    assert_eq!(told[0].stiffness_in_use, 0.0);
    assert!(told.iter().any(|status| (1.0..141.0).contains(&status.stiffness_in_use)), "no ramp");
    let (quiet, lossy, after) = (at(1.9), at(3.5), at(5.5));
    assert_eq!((quiet.phase, quiet.watchdog), ("running", "engaged"));
    assert_eq!((quiet.stiffness, quiet.stiffness_in_use), (142.0, 142.0));
    assert_eq!([quiet.loss, after.loss], [Some(0.0); 2]);
    assert!((lossy.loss.unwrap() - 0.25).abs() < 0.01, "{lossy:?}");
    assert_eq!([quiet.overruns, lossy.overruns, after.overruns], [0, 7, 0]);
    // 99 of 100, as in the second before
    assert!((lossy.lateness.median - 5e-5).abs() < 1.5e-6, "{lossy:?}");
    assert!((lossy.lateness.quantile_99 - 9.8e-5).abs() < 1.5e-6, "{lossy:?}");
    assert!((lossy.lateness.largest - 9.9e-5).abs() < 1e-12, "{lossy:?}");
    // the wire takes 19 ms each way
    assert!((quiet.round_trip.unwrap() - 0.038).abs() < 1.5e-3, "{quiet:?}");
    assert!((quiet.age.unwrap() - 0.02).abs() < 0.02, "{quiet:?}");
    let stages = quiet.latency.network.unwrap() + quiet.latency.playout.unwrap();
    assert!((stages - quiet.age.unwrap()).abs() < 2e-3, "{quiet:?}");
    assert!(quiet.force > 0.0 && quiet.balance.is_some());
}

#[test]
fn law_what_holds_the_force_back_is_named() {
    let study = hman_study(GUARD);
    let mut pair = Pair::limited(&study, 0.02, 0.5);
    let mut gauge = Gauge::new(1);
    let told = statuses(&mut pair, &mut gauge, 3000, |_, _| {}, on_time);
    let last = told.last().unwrap();
    // 2 cm at 142 N/m
    assert!(last.limits.contains(&"force") && (last.force - 0.5).abs() < 1e-9, "{last:?}");
    assert_eq!(told[0].limits, Vec::<&str>::new());
    // the partner falls silent
    let told = statuses(
        &mut pair,
        &mut gauge,
        1500,
        |pair, _| pair.ends[0].wire.borrow_mut().is_cut[0] = true,
        on_time,
    );
    assert!(told.iter().any(|status| status.limits.contains(&"held")), "{told:?}");
    let last = told.last().unwrap();
    assert_eq!((last.watchdog, last.watchdog_cause), ("disengaged", Some("silence")));
    assert_eq!((last.force, last.stiffness_in_use), (0.0, 0.0));
    assert_eq!(last.loss, None);
}

#[test]
fn law_a_strategy_that_limits_is_named() {
    let study = hman_study(GUARD);
    let mut pair = Pair::limited(&study, 0.02, 1000.0);
    let mut gauge = Gauge::new(1);
    // far beyond what the account pays
    pair.devices[1].change(|script| script.position = [0.2, 0.0]);
    let told = statuses(&mut pair, &mut gauge, 3000, |_, _| {}, on_time);
    let last = told.last().unwrap();
    assert!(last.limits.contains(&"strategy"), "{last:?}");
    assert!(last.limited_share.unwrap() > 0.5, "{last:?}");
}

fn demo(seconds: &str) -> Child {
    Command::new(env!("CARGO_BIN_EXE_telespring-link"))
        .args(["demo", "--console", "--delay", "0.02", "--seconds", seconds])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

#[test]
fn law_every_line_is_an_object_and_the_last_one_is_the_summary() {
    let mut child = demo("2");
    let _input = child.stdin.take();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let text = String::from_utf8(output.stdout).unwrap();
    let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let (summary, lines) = lines.split_last().unwrap();
    assert_eq!(summary["type"], "summary");
    assert_eq!(summary["sites"].as_array().unwrap().len(), 2);
    for side in [1, 2] {
        let of = |kind: &str| -> Vec<&Value> {
            lines.iter().filter(|line| line["type"] == kind && line["side"] == side).collect()
        };
        let times: Vec<f64> = of("status").iter().map(|line| line["time"].as_f64().unwrap()).collect();
        assert!(times.len() > 5 && times.is_sorted(), "{times:?}");
        // the console tells the events of the summary, in its words
        let of_summary = summary["sites"][side - 1]["events"].as_array().unwrap();
        let told: Vec<&Value> = of("event").iter().map(|line| &line["event"]).collect();
        assert_eq!(told, of_summary.iter().map(|entry| &entry["event"]).collect::<Vec<_>>());
    }
}

#[test]
fn law_whoever_watched_the_session_may_go_and_it_is_left_in_order() {
    // its input ends: the parent is gone
    let mut child = demo("600");
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    while !lines.next().unwrap().unwrap().contains("\"phase\":\"running\"") {}
    drop(child.stdin.take());
    let summary: Value = serde_json::from_str(&lines.map(Result::unwrap).last().unwrap()).unwrap();
    let causes = [0, 1].map(|side| summary["sites"][side]["cause"].as_str().unwrap());
    assert!(causes.contains(&"stop-requested"), "{causes:?}");
    assert!(child.wait().unwrap().success());
}

#[test]
fn law_a_reader_that_has_gone_does_not_end_the_session() {
    let mut child = demo("2");
    let _input = child.stdin.take();
    drop(child.stdout.take());
    let mut errors = String::new();
    child.stderr.take().unwrap().read_to_string(&mut errors).unwrap();
    assert!(child.wait().unwrap().success(), "{errors}");
    assert_eq!(errors, "");
    // an input that nobody writes has no end that means anything
    let output = Command::new(env!("CARGO_BIN_EXE_telespring-link"))
        .args(["demo", "--console", "--delay", "0.02", "--seconds", "1.5"])
        .stdin(Stdio::null())
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
    let last = String::from_utf8(output.stdout).unwrap().lines().last().unwrap().to_owned();
    let summary: Value = serde_json::from_str(&last).unwrap();
    assert!(summary["sites"][0]["seconds"].as_f64().unwrap() >= 1.5, "{summary}");
}
