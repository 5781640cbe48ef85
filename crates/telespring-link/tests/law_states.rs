//! The states of a session in virtual time: who may be coupled when, what interrupts it, and that no force steps.

mod common;
mod states;

use common::Pair;
use states::{consent, consenting, run_smoothly, running, study};
use telespring::session::watchdog::Cause;
use telespring::session::{EventKind, Span, WatchdogState};
use telespring_link::console::Gauge;
use telespring_link::device::Fault;
use telespring_link::operator::{Mark, MarkKind, Order};
use telespring_link::site::{Happened, Interruption, Phase, Why};

#[test]
fn law_a_force_needs_the_consent_of_both() {
    let mut pair = consenting();
    pair.run(3000, |_, forces| assert_eq!(forces, [[0.0; 2]; 2]));
    pair.order(0, Order::Consent);
    pair.run(3000, |pair, forces| {
        assert_eq!(forces, [[0.0; 2]; 2]);
        assert_eq!(pair.phases(), [Phase::Consenting; 2]);
    });
    assert_eq!(pair.moment(0).consents, [true, false]);
    assert_eq!(pair.moment(1).consents, [false, true]);
    pair.order(1, Order::Consent);
    run_smoothly(&mut pair, 1200, false);
    assert_eq!(pair.phases(), [Phase::Running; 2]);
    // a second consent is none
    pair.order(0, Order::Consent);
    pair.tick();
    assert!(pair.happened(0, &Happened::OrderRefused { order: Order::Consent, phase: Phase::Running }));
}

#[test]
fn law_a_consent_taken_back_lets_both_forces_fall_and_both_are_asked_anew() {
    for is_early in [true, false] {
        let mut pair = if is_early { consenting() } else { running() };
        if is_early {
            pair.order(0, Order::Consent);
            pair.run(100, |_, _| {});
        }
        pair.order(0, Order::Withdraw);
        run_smoothly(&mut pair, 500, false);
        assert_eq!(pair.forces(), [[0.0; 2]; 2]);
        assert_eq!(pair.phases(), [Phase::Consenting; 2]);
        assert!(pair.happened(0, &Happened::ConsentLost));
        // one is not enough, whichever
        for side in [1, 0] {
            assert_eq!(pair.forces(), [[0.0; 2]; 2]);
            pair.order(side, Order::Consent);
            run_smoothly(&mut pair, 1200, false);
        }
        assert_eq!(pair.phases(), [Phase::Running; 2]);
    }
}

#[test]
fn law_whoever_withdraws_an_automatic_consent_is_asked_from_then_on() {
    let mut pair = Pair::new([&study(), &study()], 0.02);
    pair.run(1500, |_, _| {});
    pair.order(1, Order::Withdraw);
    run_smoothly(&mut pair, 3000, false);
    assert_eq!(pair.phases(), [Phase::Consenting; 2]);
    pair.order(1, Order::Consent);
    run_smoothly(&mut pair, 1200, false);
    assert_eq!(pair.phases(), [Phase::Running; 2]);
}

#[test]
fn law_no_coupling_begins_across_an_offset_and_both_are_told_where_to_go() {
    let mut pair = Pair::new([&study(), &study()], 0.02);
    pair.devices[1].change(|script| script.position = [0.034, -0.06]);
    pair.run(3000, |_, forces| assert_eq!(forces, [[0.0; 2]; 2]));
    assert_eq!(pair.phases(), [Phase::Aligning; 2]);
    for side in 0..2 {
        let sign = if side == 0 { 1.0 } else { -1.0 };
        let [x, y] = pair.moment(side).offset.unwrap();
        assert!((x - sign * 0.034).abs() < 1e-8 && (y + sign * 0.06).abs() < 1e-8, "{x} {y}");
        let told: Vec<[f64; 2]> = pair
            .site_of(side)
            .log()
            .entries()
            .iter()
            .filter_map(|(_, happened)| match happened {
                Happened::Offset(way) => Some(*way),
                _ => None,
            })
            .collect();
        // said once while nothing changes, and the same at both sites
        let [[x, y]] = told[..] else { panic!("{told:?}") };
        assert!((x + 0.034).abs() < 1e-8 && (y - 0.06).abs() < 1e-8, "{told:?}");
    }
    // in place, but moving
    pair.devices[1].change(|script| (script.position, script.velocity) = ([0.005, 0.0], [0.0, 0.06]));
    pair.run(500, |_, forces| assert_eq!(forces, [[0.0; 2]; 2]));
    assert_eq!(pair.phases(), [Phase::Aligning; 2]);
    pair.devices[1].change(|script| script.velocity = [0.0; 2]);
    run_smoothly(&mut pair, 1200, false);
    assert_eq!(pair.phases(), [Phase::Running; 2]);
}

#[test]
fn law_whoever_moves_away_before_the_force_begins_must_align_and_consent_anew() {
    let mut pair = consenting();
    pair.order(0, Order::Consent);
    pair.run(100, |_, _| {});
    // a little is forgiven, slowly
    for _ in 0..300 {
        pair.devices[1].change(|script| script.position[0] += 3e-5);
        pair.tick();
    }
    assert_eq!(pair.phases(), [Phase::Consenting; 2]);
    pair.devices[1].change(|script| script.position = [0.031, 0.0]);
    pair.run(200, |_, _| {});
    assert_eq!(pair.phases(), [Phase::Aligning; 2]);
    assert!(pair.happened(0, &Happened::ConsentLost));
    pair.order(1, Order::Consent);
    pair.run(10, |_, _| {});
    assert!(pair.happened(1, &Happened::OrderRefused { order: Order::Consent, phase: Phase::Aligning }));
    pair.devices[1].change(|script| script.position = [0.02, 0.0]);
    pair.run(500, |_, forces| assert_eq!(forces, [[0.0; 2]; 2]));
    assert_eq!(pair.phases(), [Phase::Consenting; 2]);
    consent(&mut pair);
}

#[test]
fn law_a_pause_of_either_side_is_one_of_both_and_ends_by_its_own_order_and_two_consents() {
    for side in 0..2 {
        let mut pair = running();
        pair.order(side, Order::Pause);
        run_smoothly(&mut pair, 400, false);
        assert_eq!((pair.phases(), pair.forces()), ([Phase::Paused; 2], [[0.0; 2]; 2]));
        assert!(pair.happened(side, &Happened::Interrupted(Interruption::PauseOrdered)));
        assert!(pair.happened(1 - side, &Happened::Interrupted(Interruption::Partner(Why::Paused))));
        // neither a consent nor the other side ends it
        for order in [Order::Consent, Order::Resume] {
            pair.order(1 - side, order);
            pair.run(1000, |_, forces| assert_eq!(forces, [[0.0; 2]; 2]));
            assert!(pair.happened(1 - side, &Happened::OrderRefused { order, phase: Phase::Paused }));
        }
        // somebody moves meanwhile
        pair.devices[0].change(|script| script.position = [0.5, 0.0]);
        pair.order(side, Order::Resume);
        pair.run(500, |_, _| {});
        assert_eq!(pair.phases(), [Phase::Aligning; 2]);
        pair.devices[0].change(|script| script.position = [0.0; 2]);
        pair.run(500, |_, forces| assert_eq!(forces, [[0.0; 2]; 2]));
        assert_eq!(pair.phases(), [Phase::Consenting; 2]);
        consent(&mut pair);
        for site in 0..2 {
            assert_eq!(pair.site_of(site).tally().interruptions, 1);
            assert!(pair.site_of(site).tally().least_balance.unwrap() >= 0.0);
        }
    }
}

#[test]
fn law_an_emergency_stop_latches_on_both_sides_until_it_is_released_and_cleared() {
    let mut pair = running();
    pair.devices[1].change(|script| script.is_stopped = true);
    pair.tick();
    assert_eq!(pair.forces()[1], [0.0; 2]);
    run_smoothly(&mut pair, 500, true);
    assert_eq!((pair.phases(), pair.forces()), ([Phase::Stopped; 2], [[0.0; 2]; 2]));
    assert!(pair.happened(1, &Happened::EmergencyStop { is_own: true }));
    assert!(pair.happened(0, &Happened::EmergencyStop { is_own: false }));
    let refused = |phase| Happened::OrderRefused { order: Order::Clear, phase };
    // pressed: it cannot be cleared; and not from the other side
    for side in [1, 0] {
        pair.order(side, Order::Clear);
        pair.run(500, |pair, _| assert_eq!(pair.phases(), [Phase::Stopped; 2]));
        assert!(pair.happened(side, &refused(Phase::Stopped)));
    }
    // released: it stays latched
    pair.devices[1].change(|script| script.is_stopped = false);
    pair.run(2000, |pair, _| assert_eq!(pair.phases(), [Phase::Stopped; 2]));
    pair.order(1, Order::Clear);
    pair.run(500, |_, forces| assert_eq!(forces, [[0.0; 2]; 2]));
    assert_eq!(pair.phases(), [Phase::Consenting; 2]);
    consent(&mut pair);
    assert_eq!(pair.site_of(0).tally().emergency_stops, 1);
}

#[test]
fn law_a_device_that_comes_back_is_asked_for_consent_and_no_program_is_started_anew() {
    for is_silent in [true, false] {
        let mut pair = running();
        pair.devices[0].change(|script| {
            script.fault = is_silent.then_some(Fault::Silent);
            script.is_ready = is_silent;
        });
        pair.tick();
        assert_eq!(pair.forces()[0], [0.0; 2]);
        run_smoothly(&mut pair, 3000, true);
        assert_eq!(pair.phases(), [Phase::Homing; 2]);
        pair.devices[0].change(|script| (script.fault, script.is_ready) = (None, true));
        pair.run(500, |_, forces| assert_eq!(forces, [[0.0; 2]; 2]));
        assert_eq!(pair.phases(), [Phase::Consenting; 2]);
        consent(&mut pair);
    }
}

#[test]
fn law_a_partner_that_starts_anew_needs_new_consents() {
    let mut pair = running();
    pair.restart(&study(), 1, 77);
    run_smoothly(&mut pair, 2000, true);
    assert_eq!((pair.phases(), pair.forces()), ([Phase::Consenting; 2], [[0.0; 2]; 2]));
    pair.order(1, Order::Consent);
    pair.run(2000, |_, forces| assert_eq!(forces, [[0.0; 2]; 2]));
    pair.order(0, Order::Consent);
    run_smoothly(&mut pair, 1200, false);
    assert_eq!(pair.phases(), [Phase::Running; 2]);
}

#[test]
fn law_markers_are_events_at_any_time() {
    let mut pair = consenting();
    let mark = Mark::new(MarkKind::Participant, "P-07").unwrap();
    for phase in 0..2 {
        pair.order(phase, Order::Mark(mark));
        pair.tick();
        assert!(pair.happened(phase, &Happened::Mark(mark)));
        pair.order(phase, Order::unknown("consnt"));
        pair.tick();
        let refused = Happened::OrderRefused { order: Order::unknown("consnt"), phase: Phase::Consenting };
        assert!(pair.happened(phase, &refused));
    }
    pair.order(0, Order::Stop);
    pair.run(200, |_, _| {});
    assert_eq!(pair.site_of(0).phase(), Phase::Ended);
}

#[test]
fn law_the_watchdog_and_the_phase_agree() {
    let mut pair = consenting();
    for side in 0..2 {
        pair.order(side, Order::Consent);
    }
    let mut seen = Vec::new();
    pair.run(1500, |pair, _| {
        let moment = pair.moment(0);
        if seen.last() != Some(&moment.phase) {
            seen.push(moment.phase);
        }
        assert_eq!(moment.phase == Phase::Running, moment.state == WatchdogState::Engaged, "{moment:?}");
    });
    assert_eq!(seen, [Phase::Consenting, Phase::RampingIn, Phase::Running]);
}

#[test]
fn law_a_device_that_reported_nonsense_for_long_is_asked_for_consent() {
    let mut pair = running();
    pair.devices[1].change(|script| script.velocity = [f64::NAN, 0.0]);
    // it may pass: the force is held, and falls along a ramp
    run_smoothly(&mut pair, 80, false);
    assert_ne!(pair.forces()[1], [0.0; 2]);
    run_smoothly(&mut pair, 1000, true);
    assert_eq!(pair.phases(), [Phase::Homing; 2]);
    assert!(pair.happened(1, &Happened::Interrupted(Interruption::Device(Fault::Impossible))));
    assert!(pair.happened(1, &Happened::Session(EventKind::Disengaged(Cause::OwnMeasurement))));
    pair.devices[1].change(|script| script.velocity = [0.0; 2]);
    pair.run(3000, |_, forces| assert_eq!(forces, [[0.0; 2]; 2]));
    assert_eq!(pair.phases(), [Phase::Consenting; 2]);
    consent(&mut pair);
    // a single value that cannot be is passed over
    pair.devices[1].change(|script| script.position = [f64::INFINITY, 0.0]);
    pair.run(3, |_, _| {});
    pair.devices[1].change(|script| script.position = [0.02, 0.0]);
    run_smoothly(&mut pair, 1000, false);
    assert_eq!(pair.phases(), [Phase::Running; 2]);
}

#[test]
fn law_a_consent_that_ends_is_told_whatever_ended_it() {
    type End = fn(&mut Pair);
    let ends: [(&str, End); 6] = [
        ("the device", |pair| pair.devices[0].change(|script| script.is_ready = false)),
        ("the stop", |pair| pair.devices[0].change(|script| script.is_stopped = true)),
        ("a pause", |pair| pair.order(0, Order::Pause)),
        ("the handle", |pair| pair.devices[0].change(|script| script.position = [0.5, 0.0])),
        ("another partner", |pair| pair.restart(&study(), 1, 77)),
        ("a withdrawal", |pair| pair.order(0, Order::Withdraw)),
    ];
    for (name, end) in ends {
        for is_coupled in [false, true] {
            let mut pair = if is_coupled { running() } else { consenting() };
            pair.order(0, Order::Consent);
            pair.run(100, |_, _| {});
            assert!(pair.moment(0).consents[0]);
            end(&mut pair);
            let (mut consents, mut losses) = (true, 0);
            pair.run(1500, |pair, _| {
                let news = pair.site_of(0).log().news();
                losses += news.iter().filter(|(_, happened)| *happened == Happened::ConsentLost).count();
                consents = pair.moment(0).consents[0];
            });
            assert_eq!((consents, losses), (false, 1), "{name} {is_coupled}");
        }
    }
}

#[test]
fn law_orders_of_the_console_and_of_the_device_take_turns() {
    let mut pair = consenting();
    let (mut console, orders) = rtrb::RingBuffer::new(64);
    pair.sites[0].as_mut().unwrap().obey(orders);
    let note = Mark::new(MarkKind::Note, "again").unwrap();
    for _ in 0..200 {
        while console.push(Order::Mark(note)).is_ok() {}
        pair.tick();
    }
    while console.push(Order::Mark(note)).is_ok() {}
    pair.order(0, Order::Pause);
    pair.tick();
    assert_eq!(pair.phases()[0], Phase::Paused);
}

#[test]
fn law_a_machine_that_was_suspended_lets_go_at_once_and_both_consent_anew() {
    let mut pair = running();
    // a jitter of the two clocks is none
    for wobble in [3_000_000, -5_000_000, 0] {
        pair.clock.1.set(wobble);
        run_smoothly(&mut pair, 5, false);
    }
    pair.clock.1.set(60_000_000_000);
    pair.tick();
    assert_eq!(pair.forces(), [[0.0; 2]; 2]);
    assert!(pair.happened(0, &Happened::Interrupted(Interruption::Suspended)));
    pair.run(2000, |_, forces| assert_eq!(forces, [[0.0; 2]; 2]));
    assert_eq!(pair.phases(), [Phase::Consenting; 2]);
    consent(&mut pair);
}

#[test]
fn law_what_is_missing_at_the_start_is_told_once() {
    let pair = consenting();
    assert!(!pair.happened(0, &Happened::PartnerAwaited) && !pair.happened(0, &Happened::DeviceAwaited));
    let mut pair = Pair::new([&study(), &study()], 0.02);
    pair.sites[1] = None;
    pair.devices[0].change(|script| script.is_measured = false);
    pair.run(20_000, |_, _| {});
    for happened in [Happened::PartnerAwaited, Happened::DeviceAwaited] {
        let entries = pair.site_of(0).log().entries();
        assert_eq!(entries.iter().filter(|(_, one)| *one == happened).count(), 1, "{happened:?}");
    }
}

#[test]
fn law_a_status_says_who_wants_a_pause_and_nothing_of_an_earlier_time() {
    let mut pair = running();
    let now = |pair: &Pair, side: usize| Gauge::new(1).take(&pair.moment(side), Span(0), 0).unwrap();
    assert!(now(&pair, 0).round_trip.is_some_and(|trip| (0.03..0.06).contains(&trip)));
    pair.order(1, Order::Pause);
    pair.run(400, |_, _| {});
    assert_eq!([now(&pair, 0).pauses, now(&pair, 1).pauses], [[false, true], [true, false]]);
    let status = now(&pair, 0);
    assert_eq!((status.watchdog, status.watchdog_cause, status.age), ("disengaged", None, None));
    // the greetings go on, and their round trip is of now
    assert!(status.round_trip.is_some_and(|trip| (0.03..0.06).contains(&trip)), "{status:?}");
    pair.sites[1] = None;
    pair.run(1500, |_, _| {});
    assert_eq!(now(&pair, 0).round_trip, None);
}

#[test]
fn law_an_impossible_value_is_told_with_its_place_in_the_row() {
    let mut pair = running();
    pair.devices[0].change(|script| script.velocity[1] = f64::NAN);
    pair.run(10, |_, _| {});
    let told = |happened: &Happened| matches!(happened, Happened::ImpossibleValue { what, .. } if *what == "velocity in y (place 6)");
    assert!(pair.site_of(0).log().entries().iter().any(|(_, happened)| told(happened)));
    // and the events are in the order of their times
    assert!(pair.site_of(0).log().entries().is_sorted_by_key(|(time, _)| *time));
}
