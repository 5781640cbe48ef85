//! Ryu, Artigas and Preusche (2010): out here never exceeds in there, but for what one tick cannot foresee.

use crate::driver::{Case, pair, run};
use telespring::session::Law;
use telespring::session::strategy::TimeDomainPassivity;

#[test]
fn law_the_observer_is_never_below_zero_by_more_than_one_tick() {
    for case in Case::with_and_without_hands() {
        let course = run(&case, pair("time-domain passivity", 0.0));
        let one_tick = course.most_in_a_tick();
        let lowest = course.0.iter().flatten().map(|tick| tick.report.balance.unwrap()).fold(0.0, f64::min);
        println!(
            "lowest {lowest:.1e} J, most in one tick {one_tick:.1e} J, given out {:.1e} J",
            course.most_given_out()
        );
        assert!(lowest >= -one_tick, "{lowest} {one_tick}");
        // both ports together are passive
        assert!(course.most_given_out() <= 2.0 * one_tick, "{}", course.most_given_out());
    }
}

#[test]
fn law_the_totals_of_both_ports_are_what_the_plants_received() {
    for case in Case::with_and_without_hands() {
        let course = run(&case, pair("time-domain passivity", 0.0));
        for ticks in &course.0 {
            for tick in ticks {
                let drawn = tick.report.energy_received - tick.report.balance.unwrap();
                let out = drawn - tick.report.energy_sent;
                assert!((out - tick.given_out).abs() < 1e-9, "{out} {}", tick.given_out);
            }
            let [one, two] = ticks;
            assert!(one.report.energy_received <= two.report.energy_sent);
            assert!(two.report.energy_received <= one.report.energy_sent);
        }
    }
}

#[test]
fn law_each_value_is_refused_with_its_field() {
    let law = Law { stiffness: 1.0, damping: 0.0 };
    let field = |law, damping| TimeDomainPassivity::new(law, damping).unwrap_err().field;
    assert_eq!(field(Law { stiffness: -1.0, ..law }, 1.0), "stiffness");
    assert_eq!(field(Law { damping: f64::NAN, ..law }, 1.0), "coupling_damping");
    assert_eq!(field(law, -1.0), "largest_damping");
}
