//! Limits of robot and person in virtual time: what they take of the force, and when they end a coupling.

mod common;
mod states;

use common::Pair;
use states::{running, study};
use telespring_link::hello::{Greeting, MAGIC};
use telespring_link::operator::Order;
use telespring_link::site::{Happened, Interruption, Limit, Limits, Phase, Rules, SiteSettings};

#[test]
fn law_a_handle_that_is_too_fast_or_outside_is_let_go_along_the_ramp() {
    for cause in [Interruption::Velocity, Interruption::Workspace] {
        let mut pair = Pair::with([&study(), &study()], 0.02, |settings| {
            let workspace = [[-0.1, 0.1], [f64::NEG_INFINITY, f64::INFINITY]];
            // the handle jumps, and the force with it
            let limits = Limits { workspace, rise: 1e6, ..settings.limits };
            SiteSettings { limits, ..settings.simulated() }
        });
        pair.run(1500, |_, _| {});
        assert_eq!(pair.phases(), [Phase::Running; 2]);
        pair.devices[1].change(|script| match cause {
            Interruption::Velocity => script.velocity = [0.0, -2.01],
            _ => script.position = [0.101, 0.0],
        });
        pair.run(1, |_, _| {});
        let mut before = pair.forces()[1][0];
        assert!(before < 0.0);
        pair.run(400, |_, forces| {
            assert!((before..=0.0).contains(&forces[1][0]), "{before} {forces:?}");
            before = forces[1][0];
        });
        assert_eq!((pair.phases(), pair.forces()), ([Phase::Paused; 2], [[0.0; 2]; 2]));
        assert!(pair.happened(1, &Happened::Interrupted(cause)));
        // outside nothing begins
        pair.order(1, Order::Resume);
        pair.devices[0].change(|script| script.position = pair.devices[1].0.get().position);
        pair.run(2000, |_, forces| assert_eq!(forces, [[0.0; 2]; 2]));
        assert_eq!(pair.phases(), [Phase::Aligning; 2]);
    }
}

#[test]
fn law_scale_and_lock_take_their_part_of_the_force_and_the_account_knows() {
    let mut pair = Pair::with([&study(), &study()], 0.02, |settings| {
        let limits = Limits { scale: 0.5, lock: [false, true], ..settings.limits };
        SiteSettings { limits, ..settings.simulated() }
    });
    pair.devices[1].change(|script| script.position = [0.012, 0.01]);
    pair.run(1500, |_, _| {});
    let [[x, y], _] = pair.forces();
    assert!((x - 0.6).abs() < 1e-7 && y == 0.0, "{x} {y}");
    let given = |pair: &Pair| pair.site_of(0).session_report().strategy.given_out;
    let before = given(&pair);
    let mut expected = 0.0;
    for step in 1..=200 {
        let way = f64::from(step) * 1e-5;
        expected += pair.forces()[0][0] * 1e-5;
        pair.devices[0].change(|script| script.position = [way, -way]);
        pair.tick();
    }
    assert!((given(&pair) - before - expected).abs() < 1e-12, "{} {expected}", given(&pair) - before);
    assert!(expected > 1e-4);
}

#[test]
fn law_what_limits_the_force_is_told_when_it_begins_and_when_it_is_over() {
    let mut pair = Pair::limited(&study(), 0.02, 1.0);
    pair.run(2000, |_, _| {});
    let told = |pair: &Pair, wanted: Happened| {
        pair.site_of(0).log().entries().iter().filter(|(_, happened)| *happened == wanted).count()
    };
    assert_eq!(told(&pair, Happened::Limiting(Limit::Force)), 1);
    // on and off at every tick: one time
    for step in 0..2000 {
        pair.devices[0].change(|script| script.position[0] = if step % 2 == 0 { 0.019 } else { 0.0 });
        pair.tick();
    }
    assert_eq!(told(&pair, Happened::Limiting(Limit::Force)), 1);
    pair.devices[0].change(|script| script.position[0] = 0.019);
    pair.run(2500, |_, _| {});
    assert_eq!(told(&pair, Happened::Unlimited(Limit::Force)), 1);
    assert!(pair.site_of(0).tally().cut_ticks > 1000);
}

#[test]
fn law_rules_and_limits_out_of_range_are_refused_with_the_field() {
    let usual = Rules::default();
    assert!(usual.check().is_ok() && Limits::default().check().is_ok());
    for (rules, field) in [
        (Rules { alignment: f64::NAN, ..usual }, "session.alignment"),
        (Rules { rest: 0.0, ..usual }, "session.rest"),
    ] {
        assert_eq!(rules.check().unwrap_err().field, field);
    }
    let robot = Limits { force: 5.0, workspace: [[-0.1, 0.1]; 2], lock: [true, false], ..Limits::default() };
    let person = Limits { force: 8.0, velocity: 0.5, workspace: [[0.0, 0.3]; 2], ..Limits::NONE };
    let both = robot.and(person);
    assert_eq!((both.force, both.velocity, both.lock), (5.0, 0.5, [true, false]));
    assert_eq!(both.workspace, [[0.0, 0.1]; 2]);
    let apart = Limits { workspace: [[0.2, 0.3]; 2], ..robot };
    assert_eq!(robot.and(apart).check().unwrap_err().field, "limits.workspace");
}

#[test]
fn law_a_handle_that_moves_too_fast_is_seen_whatever_velocity_the_device_reports() {
    // a device that reports no velocity, or a sensor that jumps
    for (steps, way, is_let_go) in [(100, 3e-3, true), (1, 0.05, true), (100, 1.8e-3, false)] {
        let mut pair = Pair::new([&study(), &study()], 0.02);
        pair.run(1500, |_, _| {});
        assert_eq!(pair.phases(), [Phase::Running; 2]);
        for _ in 0..steps {
            pair.devices[0].change(|script| script.position[1] += way);
            pair.tick();
        }
        pair.run(15, |_, _| {});
        let is_told = pair.happened(0, &Happened::Interrupted(Interruption::Velocity));
        assert_eq!(is_told, is_let_go, "{way} m in a tick");
    }
}

#[test]
fn law_a_handle_that_moves_is_not_at_rest_whatever_velocity_the_device_reports() {
    let mut pair = Pair::with([&study(), &study()], 0.02, |settings| settings);
    pair.run(200, |_, _| {});
    assert_eq!(pair.phases(), [Phase::Consenting; 2]);
    // within the distance all the time, at 0.2 m/s, by a device that reports no velocity
    let mut phases = Vec::new();
    for _ in 0..90 {
        pair.devices[0].change(|script| script.position[0] += 2e-4);
        pair.tick();
        phases.push(pair.phases()[0]);
    }
    assert!(phases[15..].iter().all(|phase| *phase == Phase::Aligning), "{phases:?}");
    // it rests again
    pair.run(100, |_, _| {});
    assert_eq!(pair.phases(), [Phase::Consenting; 2]);
}

#[test]
fn law_a_limit_that_stays_broken_is_told_once_and_asks_for_no_greeting_at_every_tick() {
    let mut pair = running();
    pair.devices[0].change(|script| script.velocity = [0.0, -3.0]);
    let mut greetings = 0;
    for _ in 0..90 {
        pair.tick();
        let latest = pair.ends[0].wire.borrow_mut().latest[1].take();
        greetings += usize::from(latest.is_some_and(|datagram| datagram.starts_with(&MAGIC)));
    }
    assert!(greetings <= 6, "{greetings} greetings in 90 ms");
    let told = Happened::Interrupted(Interruption::Velocity);
    assert_eq!(pair.site_of(0).log().entries().iter().filter(|(_, happened)| *happened == told).count(), 1);
}

/// Two sites whose people consent by themselves, of which `side` locks y.
fn locked(side: u8) -> Pair {
    Pair::with([&study(), &study()], 0.02, move |settings| {
        let lock = [false, settings.terms.side == side];
        SiteSettings { limits: Limits { lock, ..settings.limits }, ..settings.simulated() }
    })
}

#[test]
fn law_an_axis_that_one_site_locks_is_out_of_the_coupling_at_both() {
    for side in [1, 2] {
        let mut pair = locked(side);
        // far apart along the locked axis, and moving along it: one robot has no such axis
        pair.devices[0].change(|script| (script.position, script.velocity) = ([0.0, 0.3], [0.0, 0.4]));
        pair.devices[1].change(|script| script.position = [0.015, -0.2]);
        pair.run(1500, |pair, forces| {
            assert_eq!(forces.map(|[_, y]| y), [0.0; 2]);
            // nor does it cost any of the account
            assert_eq!([0, 1].map(|side| pair.site_of(side).session_report().strategy.limited_ticks), [0; 2]);
        });
        assert_eq!(pair.phases(), [Phase::Running; 2]);
        let [[x, _], [u, _]] = pair.forces();
        assert!((x - 1.5).abs() < 1e-6 && (u + 1.5).abs() < 1e-6, "{x} {u}");
        for (at, by) in [[side == 1, side == 2], [side == 2, side == 1]].into_iter().enumerate() {
            assert!(pair.happened(at, &Happened::AxisLocked { axis: 1, by }));
        }
        // each robot is still watched along it
        pair.devices[0].change(|script| script.velocity = [0.0, 2.1]);
        pair.run(300, |_, _| {});
        assert!(pair.happened(0, &Happened::Interrupted(Interruption::Velocity)));
    }
    // nobody locks it
    let mut pair = locked(3);
    pair.devices[1].change(|script| script.position = [0.015, -0.2]);
    pair.run(1500, |_, forces| assert_eq!(forces, [[0.0; 2]; 2]));
    assert_eq!(pair.phases(), [Phase::Aligning; 2]);
}

#[test]
fn law_a_lock_of_the_partner_holds_for_its_session_only() {
    let mut pair = locked(2);
    pair.run(1500, |_, _| {});
    assert_eq!(pair.phases(), [Phase::Running; 2]);
    // a greeting of the same session with another lock changes nothing
    let mut greeting = Greeting::decode(&pair.ends[0].wire.borrow().latest[0].unwrap());
    for _ in 0..200 {
        pair.tick();
        greeting = greeting.or(Greeting::decode(&pair.ends[0].wire.borrow().latest[0].unwrap()));
    }
    let mut greeting = greeting.unwrap();
    assert_eq!(greeting.terms.lock, [false, true]);
    greeting.terms.lock = [true, false];
    greeting.stamps.sent += 1_000_000_000;
    pair.ends[0].wire.borrow_mut().injected[0].push(greeting.encode().to_vec());
    pair.devices[0].change(|script| script.position = [0.0, 0.1]);
    pair.run(5, |_, [[x, y], _]| assert!(y == 0.0 && x > 0.5, "{x} {y}"));
}
