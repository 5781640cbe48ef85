//! The energy account is told what acted, or the worst that may have acted: in virtual time.

mod common;

use common::{Pair, anywhere, hman_study};
use telespring::study::Study;
use telespring_link::device::Fault;
use telespring_link::operator::Order;
use telespring_link::site::{Happened, Limits, Phase, SiteSettings};

/// The force of the spring between two handles 2 cm apart, N.
const FORCE: f64 = 2.0;

fn study(lines: &str) -> Study {
    hman_study(&format!(
        "coupling.stiffness = 100\nnetwork.delay = 0.02\nsession.strategy = \"guard\"\n{lines}"
    ))
}

/// A pair with the full force, and no limit that a step of a handle breaks.
fn running(lines: &str, limits: Limits) -> Pair {
    let study = study(lines);
    let limits = Limits { velocity: 100.0, ..limits };
    let mut pair =
        Pair::with([&study, &study], 0.02, move |settings| SiteSettings { limits, ..anywhere(settings) });
    pair.run(1500, |_, _| {});
    assert_eq!(pair.phases(), [Phase::Running; 2]);
    pair
}

fn given(pair: &Pair) -> f64 {
    pair.site_of(0).session_report().strategy.given_out
}

fn step(pair: &mut Pair, way: f64) {
    pair.devices[0].change(|script| {
        script.position[0] += way;
        script.is_measured = true;
    });
    pair.tick();
}

#[test]
fn law_where_a_device_was_silent_the_account_takes_the_worst_that_may_have_acted() {
    for lines in ["", "laboratory.computing_tick = true"] {
        for way in [0.01, -0.01] {
            for is_paused in [false, true] {
                let mut pair = running(lines, Limits::default());
                let before = given(&pair);
                pair.devices[0].change(|script| script.is_measured = false);
                if is_paused {
                    pair.order(0, Order::Pause);
                }
                let mut forces = vec![pair.forces()[0][0]];
                pair.run(70, |_, [[force, _], _]| forces.push(force));
                let [least, most] =
                    [f64::min, f64::max].map(|pick| forces.iter().copied().reduce(pick).unwrap());
                assert!((most - FORCE).abs() < 1e-9 && least < 0.8 * FORCE, "{least} {most}");
                step(&mut pair, way);
                // nobody knows when in this time the handle moved
                let worst = way * if way > 0.0 { most } else { least };
                let taken = given(&pair) - before;
                assert!((taken - worst).abs() < 3e-4, "{lines} {way} {is_paused}: {taken} J of {worst} J");
            }
        }
    }
}

#[test]
fn law_the_account_takes_the_last_moment_before_a_sudden_end() {
    for lines in ["", "laboratory.computing_tick = true"] {
        for way in [0.01, -0.01] {
            // the emergency stop is pressed in the row that says how far the handle has gone
            let mut pair = running(lines, Limits::default());
            let before = given(&pair);
            pair.devices[0].change(|script| script.is_stopped = true);
            step(&mut pair, way);
            assert_eq!((pair.phases()[0], pair.forces()[0]), (Phase::Stopped, [0.0; 2]));
            let taken = given(&pair) - before;
            assert!((taken - way * FORCE).abs() < 1e-9, "{lines} {way}: {taken} J");
            // with a computing tick the last command acts once more; nothing does after that
            step(&mut pair, way);
            let all = if lines.is_empty() { way } else { 2.0 * way };
            for _ in 0..50 {
                step(&mut pair, way);
            }
            let taken = given(&pair) - before;
            assert!((taken - all * FORCE).abs() < 1e-9, "{lines} {way}: {taken} J after the end");
        }
    }
}

#[test]
fn law_the_account_takes_the_worst_of_a_device_that_fell_silent_once_it_is_back() {
    for (way, worst) in [(0.01, 0.01 * FORCE), (-0.01, 0.0)] {
        let mut pair = running("", Limits::default());
        let before = given(&pair);
        pair.devices[0].change(|script| script.fault = Some(Fault::Silent));
        pair.run(300, |_, forces| assert_eq!(forces[0], [0.0; 2]));
        assert_eq!(pair.phases()[0], Phase::Homing);
        pair.devices[0].change(|script| script.fault = None);
        step(&mut pair, way);
        let taken = given(&pair) - before;
        assert!((taken - worst).abs() < 1e-9, "{way}: {taken} J of {worst} J");
        // once
        step(&mut pair, way);
        assert!((given(&pair) - before - worst).abs() < 1e-9);
    }
}

#[test]
fn law_where_no_command_came_for_long_the_account_gets_nothing_for_a_force_that_may_have_ended() {
    for (way, worst) in [(0.01, 0.01 * FORCE), (-0.01, 0.0)] {
        let mut pair = running("", Limits::default());
        let before = given(&pair);
        // the machine stood still: the device has let go by itself, or it has not
        pair.clock.0.set(pair.clock.0.get() + 500_000_000);
        step(&mut pair, way);
        let taken = given(&pair) - before;
        assert!((taken - worst).abs() < 1e-9, "{way}: {taken} J of {worst} J");
    }
    // a tick that is late is none of this
    let mut pair = running("", Limits::default());
    let before = given(&pair);
    pair.clock.0.set(pair.clock.0.get() + 3_000_000);
    step(&mut pair, -0.001);
    assert!((given(&pair) - before + 0.001 * FORCE).abs() < 1e-9);
}

#[test]
fn law_a_measured_force_that_cannot_be_is_not_believed() {
    for bad in [f64::NAN, f64::INFINITY, -1e12, 1001.0] {
        // the endpoint wants 2 N, and half of it acts
        let mut pair = running("", Limits { force: 1.0, ..Limits::default() });
        pair.devices[0].change(|script| script.acted = Some([bad, 0.0]));
        let before = given(&pair);
        for _ in 0..100 {
            step(&mut pair, -1e-5);
        }
        let taken = given(&pair) - before;
        assert!((taken + 1.0 * 1e-3).abs() < 1e-5, "{bad} N: {taken} J");
        let is_told = |happened: &Happened| matches!(happened, Happened::ImpossibleValue { value, .. } if value.to_bits() == bad.to_bits());
        let log = pair.site_of(0).log().entries();
        assert_eq!(log.iter().filter(|(_, happened)| is_told(happened)).count(), 1, "{bad} N: {log:?}");
    }
    // what can be is
    let mut pair = running("", Limits::default());
    pair.devices[0].change(|script| script.acted = Some([0.5, 0.0]));
    let before = given(&pair);
    step(&mut pair, 1e-3);
    assert!((given(&pair) - before - 0.5e-3).abs() < 1e-9);
}
