//! The states of a session in virtual time: who may be coupled when, what interrupts it, and that no force steps.

mod common;

use common::{Pair, hman_study};
use telespring::session::watchdog::Cause;
use telespring::session::{EventKind, Span, WatchdogState};
use telespring::study::Study;
use telespring_link::console::Gauge;
use telespring_link::device::Fault;
use telespring_link::hello::{Greeting, MAGIC};
use telespring_link::operator::{Mark, MarkKind, Order};
use telespring_link::site::{Happened, Interruption, Limit, Limits, Phase, Rules, SiteSettings, Why};

const GUARD: &str = "coupling.stiffness = 100\nnetwork.delay = 0.02\nsession.strategy = \"guard\"";
/// The force of the spring between two handles 2 cm apart, N.
const FORCE: f64 = 2.0;

fn study() -> Study {
    hman_study(GUARD)
}

/// A pair of people who consent by order, up to the consent.
fn consenting() -> Pair {
    let mut pair = Pair::with([&study(), &study()], 0.02, |settings| settings);
    pair.run(500, |_, forces| assert_eq!(forces, [[0.0; 2]; 2]));
    assert_eq!(pair.phases(), [Phase::Consenting; 2]);
    pair
}

/// Runs, and sees to it that no force steps: it changes by no more than the steepest ramps do, unless it is let go.
fn run_smoothly(pair: &mut Pair, milliseconds: usize, may_let_go: bool) {
    let mut before = pair.forces();
    pair.run(milliseconds, |_, forces| {
        for side in 0..2 {
            let step = (forces[side][0] - before[side][0]).abs();
            let is_let_go = may_let_go && forces[side] == [0.0; 2];
            assert!(is_let_go || step <= FORCE / 100.0 + FORCE / 78.0 + 1e-9, "{side}: {step} N");
        }
        before = forces;
    });
}

fn consent(pair: &mut Pair) {
    for side in 0..2 {
        pair.order(side, Order::Consent);
    }
    run_smoothly(pair, 1200, false);
    assert_eq!(pair.phases(), [Phase::Running; 2]);
    let [[first, _], [second, _]] = pair.forces();
    assert!((first - FORCE).abs() < 1e-9 && (second + FORCE).abs() < 1e-9, "{first} {second}");
}

fn running() -> Pair {
    let mut pair = consenting();
    consent(&mut pair);
    pair
}

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
    // a little is forgiven
    pair.devices[1].change(|script| script.position = [0.029, 0.0]);
    pair.run(200, |_, _| {});
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
fn law_a_partner_that_falls_silent_takes_its_consent_along() {
    let mut pair = consenting();
    pair.order(1, Order::Consent);
    pair.run(200, |_, _| {});
    assert_eq!(pair.moment(0).consents, [false, true]);
    pair.ends[0].wire.borrow_mut().is_cut = [true; 2];
    pair.run(1200, |_, _| {});
    assert_eq!(pair.phases(), [Phase::Connecting; 2]);
    pair.order(0, Order::Consent);
    pair.run(1200, |_, forces| assert_eq!(forces, [[0.0; 2]; 2]));
    pair.ends[0].wire.borrow_mut().is_cut = [false; 2];
    pair.run(500, |_, forces| assert_eq!(forces, [[0.0; 2]; 2]));
    assert_eq!(pair.phases(), [Phase::Consenting; 2]);
    assert_eq!(pair.moment(0).consents, [false; 2]);
}

#[test]
fn law_a_long_silence_pauses_and_a_short_one_does_not() {
    for (silence, phase) in [(1900, Phase::Running), (2200, Phase::Paused)] {
        let mut pair = Pair::new([&study(), &study()], 0.02);
        pair.run(1500, |_, _| {});
        pair.ends[0].wire.borrow_mut().is_cut = [true; 2];
        run_smoothly(&mut pair, silence, false);
        assert_eq!(pair.forces(), [[0.0; 2]; 2]);
        pair.ends[0].wire.borrow_mut().is_cut = [false; 2];
        // a pause because of the network never ends by itself
        run_smoothly(&mut pair, 8000, false);
        assert_eq!(pair.phases(), [phase; 2]);
        if phase == Phase::Paused {
            for side in 0..2 {
                assert!(pair.happened(side, &Happened::Interrupted(Interruption::Network)));
                pair.order(side, Order::Resume);
            }
            run_smoothly(&mut pair, 1500, false);
            assert_eq!(pair.phases(), [Phase::Running; 2]);
        }
    }
}

#[test]
fn law_a_bad_network_softens_then_pauses_and_a_good_one_restores() {
    for is_long in [false, true] {
        let mut pair = Pair::new([&study(), &study()], 0.02);
        pair.run(3000, |_, _| {});
        let mut random = 1_u64;
        let mut lose = |pair: &Pair| {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            pair.ends[0].wire.borrow_mut().is_cut[0] = (random >> 33) % 100 < 30;
        };
        let mut least = f64::INFINITY;
        let mut before = FORCE;
        for _ in 0..if is_long { 6000 } else { 2500 } {
            lose(&pair);
            pair.tick();
            let force = pair.forces()[0][0];
            assert!((force - before).abs() <= FORCE / 50.0, "{before} {force}");
            least = least.min(force);
            before = force;
        }
        pair.ends[0].wire.borrow_mut().is_cut[0] = false;
        let softened = |happened: &Happened| matches!(happened, Happened::Softened(_));
        let log = pair.site_of(0).log().entries();
        assert_eq!(log.iter().filter(|(_, happened)| softened(happened)).count(), 1, "{log:?}");
        run_smoothly(&mut pair, 6000, false);
        assert!(pair.site_of(0).tally().softened_ticks > 1000);
        assert!(pair.site_of(0).tally().least_balance.unwrap() >= 0.0);
        // the partner hears well
        assert!(!pair.site_of(1).log().entries().iter().any(|(_, happened)| softened(happened)));
        if is_long {
            assert_eq!(pair.phases(), [Phase::Paused; 2]);
            assert_eq!(least, 0.0);
        } else {
            assert_eq!(pair.phases(), [Phase::Running; 2]);
            assert!((0.4..0.6).contains(&(least / FORCE)), "{least}");
            assert!(pair.happened(0, &Happened::Restored));
            assert!((pair.forces()[0][0] - FORCE).abs() < 1e-9);
        }
    }
}

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
fn law_an_imposed_delay_is_the_age_realised_and_one_below_the_network_is_refused() {
    let imposed = |delay: f64| {
        hman_study(&format!(
            "coupling.stiffness = 100\nnetwork.delay = 0.02\n\
             session = {{strategy = \"guard\", playout = {{kind = \"fixed\", delay = {delay}}}}}"
        ))
    };
    let study = imposed(0.08);
    let mut pair = Pair::new([&study, &study], 0.02);
    pair.run(3000, |_, _| {});
    assert_eq!(pair.phases(), [Phase::Running; 2]);
    pair.run(500, |pair, _| {
        // the clock of the partner is known to half of the round trip
        let age = pair.moment(0).age.unwrap();
        assert!((age - 0.08).abs() <= 0.001, "{age}");
    });
    // slower than imposed
    let study = imposed(0.03);
    let mut pair = Pair::new([&study, &study], 0.05);
    pair.run(4000, |_, forces| assert_eq!(forces, [[0.0; 2]; 2]));
    assert_eq!(pair.phases(), [Phase::Ended; 2]);
    let told = pair.site_of(0).log().entries().iter().find_map(|(_, happened)| match happened {
        Happened::DelayTooShort { imposed, measured } => Some((*imposed, *measured)),
        _ => None,
    });
    let (imposed, measured) = told.unwrap();
    assert!(imposed == 0.03 && (measured - 0.049).abs() <= 0.002, "{imposed} {measured}");
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
fn law_what_a_partner_sent_while_nothing_was_coupled_is_no_loss() {
    // a stop here: the partner goes on for its ramp and one way, and begins earlier or later the next time
    for delay in [0.02, 0.15] {
        let study = hman_study(&format!(
            "coupling.stiffness = 100\nnetwork.delay = {delay}\nsession.strategy = \"guard\""
        ));
        let mut pair = Pair::new([&study, &study], delay);
        pair.run(3000, |_, _| {});
        for _ in 0..3 {
            pair.devices[0].change(|script| script.is_stopped = true);
            pair.run(1000, |_, _| {});
            pair.devices[0].change(|script| script.is_stopped = false);
            pair.order(0, Order::Clear);
            pair.run(4000, |_, _| {});
            assert_eq!(pair.phases(), [Phase::Running; 2]);
        }
        for side in 0..2 {
            let (site, moment) = (pair.site_of(side), pair.moment(side));
            assert!(site.tally().early_datagrams > 100 || side == 1);
            assert_eq!(site.session_report().playout.lost, 0, "{delay} s, site {}", side + 1);
            assert_eq!(moment.session.playout.lost, 0);
            let log = site.log().entries();
            let is_softened = |happened: &Happened| matches!(happened, Happened::Softened(_));
            assert!(!log.iter().any(|(_, happened)| is_softened(happened)), "{delay} s: {log:?}");
        }
        // one that is lost still counts
        pair.ends[0].wire.borrow_mut().is_cut[0] = true;
        pair.run(5, |_, _| {});
        pair.ends[0].wire.borrow_mut().is_cut[0] = false;
        pair.run(500, |_, _| {});
        assert_eq!(pair.site_of(0).session_report().playout.lost, 5, "{delay} s");
    }
}

#[test]
fn law_packets_that_the_transport_leaves_out_are_no_loss() {
    for every in [2, 4] {
        let mut pair = Pair::new([&study(), &study()], 0.02);
        pair.run(1500, |_, _| {});
        pair.ends[0].wire.borrow_mut().every = [every; 2];
        run_smoothly(&mut pair, 8000, false);
        assert_eq!(pair.phases(), [Phase::Running; 2]);
        for side in 0..2 {
            assert_eq!(pair.site_of(side).session_report().playout.lost, 0, "one of {every}");
            assert_eq!(pair.site_of(side).tally().softened_ticks, 0, "one of {every}");
        }
    }
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
fn law_a_delay_that_is_refused_ends_both_sides_whoever_finds_it_first() {
    let study = hman_study(
        "coupling.stiffness = 100\nnetwork.delay = 0.002\n\
         session = {strategy = \"guard\", playout = {kind = \"fixed\", delay = 0.005}}",
    );
    // a greeting that is lost on one way: the side there knows the delay later
    for (deaf, lost) in [(0, 0), (0, 60), (1, 60), (0, 200), (1, 200)] {
        let mut pair = Pair::new([&study, &study], 0.01);
        pair.run(150, |_, _| {});
        pair.ends[0].wire.borrow_mut().is_cut[deaf] = true;
        pair.run(lost, |_, _| {});
        pair.ends[0].wire.borrow_mut().is_cut[deaf] = false;
        pair.run(4000, |_, forces| assert_eq!(forces, [[0.0; 2]; 2]));
        let causes = [0, 1].map(|side| pair.site_of(side).cause());
        assert_eq!(causes, [Some(telespring_link::site::Cause::DelayRefused); 2], "{lost} ms towards {deaf}");
    }
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

#[test]
fn law_while_nothing_is_coupled_no_age_of_before_is_shown() {
    let mut pair = running();
    assert!(pair.moment(0).age.is_some());
    pair.order(0, Order::Pause);
    pair.run(500, |_, _| {});
    for side in 0..2 {
        let moment = pair.moment(side);
        let latency = moment.latency(Span(0));
        assert_eq!((moment.age, latency.network, latency.playout), (None, None, None));
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
