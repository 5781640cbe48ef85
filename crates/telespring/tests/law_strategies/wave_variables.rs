//! Niemeyer and Slotine (1991): a matched end, the line as a spring, any constant delay.

use crate::driver::{Case, PERIOD, STIFFNESS, pair, run};
use telespring::session::Motion;
use telespring::session::strategy::{PartnerView, Strategy, Tick, WaveSettings, WaveVariables};

/// A side with a handle held at 0 and what arrives.
fn tick(signal: f64, energy_sent: f64) -> Tick {
    let still = Motion::default();
    let partner = PartnerView {
        wanted: still,
        played: still,
        age: 0.1,
        fresh: true,
        signal: [signal, 0.0],
        energy_sent,
        stiffness: STIFFNESS,
    };
    Tick {
        elapsed: PERIOD,
        own: still,
        previous: still,
        acted: [0.0; 2],
        partner: Some(partner),
        enabled: 1.0,
    }
}

#[test]
fn ref_a_matched_end_reflects_nothing_at_first_and_a_held_handle_all_in_the_end() {
    // a constant wave w on a spring K = 2k and a damper b to the ground: the end moves as x' = (√(2b) w − K x)/(2b), and
    // b v − F = −K x leaves: the wave −w (1 − exp(−K t/2b))
    let (impedance, wave) = (10.0, 0.4);
    let mut side =
        WaveVariables::new(WaveSettings { filter: 0.0, ..WaveSettings::new(STIFFNESS, impedance) }).unwrap();
    let mut before = 0.0;
    side.settle(&tick(0.0, 0.0));
    side.force(&tick(0.0, 0.0));
    for n in 1..1000 {
        side.settle(&tick(0.0, 0.0));
        let sent = side.outgoing().signal[0];
        side.force(&tick(wave * PERIOD * n as f64, 100.0));
        let left = (sent - before) / PERIOD;
        before = sent;
        if n == 1 {
            continue; // nothing had arrived
        }
        let rate = 2.0 * STIFFNESS / (2.0 * impedance);
        let expected = -wave * (1.0 - (-rate * PERIOD * (n - 2) as f64).exp());
        // the end moves on in steps of one period
        assert!((left - expected).abs() < rate * PERIOD * wave, "{n}: {left} {expected}");
        assert!(n > 2 || left.abs() < 1e-12, "{left}");
    }
}

#[test]
fn ref_at_rest_the_line_is_a_spring_of_impedance_over_delay() {
    for delay in [20, 84, 200] {
        let case = Case { hands: [0.0, 300.0], pull: 5.0, velocity: 0.0, ..Case::free(delay, 60.0) };
        let course = run(&case, pair("wave variables", 0.0));
        let [one, two] = course.0.last().unwrap();
        let stretched = one.motion.position[0] - two.motion.position[0];
        let line = WaveVariables::new(WaveSettings::new(STIFFNESS, 10.0)).unwrap();
        let expected = line.static_stiffness(delay as f64 * PERIOD);
        println!("{delay} ms: {:.3} N/m, closed form {expected:.3} N/m", 5.0 / stretched);
        assert!((two.force[0] - 5.0).abs() < 1e-6 && (one.force[0] + 5.0).abs() < 1e-6);
        assert!((5.0 / stretched / expected - 1.0).abs() < 1e-6, "{delay}");
    }
}

#[test]
fn law_any_constant_delay_is_passive_where_the_bare_spring_is_not() {
    for delay in [10, 84, 334, 1000] {
        for hands in [[0.0; 2], [0.0, 300.0]] {
            let case = Case { hands, ..Case::free(delay, 30.0) };
            let (course, spring) = (run(&case, pair("wave variables", 0.0)), run(&case, pair("spring", 0.0)));
            println!(
                "{delay} ms, {hands:?}: {:.3} m, {:.1e} m/s, given out {:.1e} J; spring {:.1e} J",
                course.farthest(),
                course.last_speed(),
                course.most_given_out(),
                spring.most_given_out()
            );
            // the springs begin as stretched as one spring between both handles: half of its energy each, by halves
            let (begin, sent) = (&course.0[delay], &course.0[0]);
            let stretch = |side: usize| begin[side].motion.position[0] - sent[1 - side].motion.position[0];
            let held = 0.25 * STIFFNESS * (stretch(0).powi(2) + stretch(1).powi(2));
            assert!(course.most_given_out() <= held + 1e-9, "{} {held}", course.most_given_out());
            assert!(course.farthest() < 0.05 && course.last_speed() < 1e-3, "{}", course.last_speed());
            assert!(delay != 84 || hands != [0.0; 2] || spring.most_given_out() > 1.0);
        }
    }
}

#[test]
fn law_no_more_energy_arrives_than_was_sent() {
    // a jump of the integral, as after a gap: what the energy sent does not cover waits
    let mut side = WaveVariables::new(WaveSettings::new(STIFFNESS, 10.0)).unwrap();
    side.force(&tick(0.0, 0.0));
    let sent = 0.02;
    for n in 0..3000 {
        side.settle(&tick(5.0, sent));
        side.force(&tick(5.0, sent));
        assert!(side.report().energy_received <= sent * (1.0 + 1e-12), "{n}");
    }
    assert!((side.report().energy_received / sent - 1.0).abs() < 1e-9);
    assert!(side.report().limited_ticks > 2000);
}

#[test]
fn law_each_setting_is_refused_with_its_field() {
    let good = WaveSettings::new(100.0, 10.0);
    let field = |settings| WaveVariables::new(settings).unwrap_err().field;
    assert_eq!(field(WaveSettings { stiffness: 0.0, ..good }), "stiffness");
    assert_eq!(field(WaveSettings { impedance: 0.0, ..good }), "impedance");
    assert_eq!(field(WaveSettings { filter: -1.0, ..good }), "filter");
}
