//! What silence, loss and delay do to a session in virtual time.

mod common;
mod states;

use common::{Pair, hman_study};
use states::{FORCE, consenting, run_smoothly, running, study};
use telespring::session::Span;
use telespring_link::operator::Order;
use telespring_link::site::{Happened, Interruption, Phase};

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
