//! Lee and Huang (2010): the reservoir pays ½k|x − ȳ|² − ½k|x − ȳ⁻|² for each jump of the set position, and is never overdrawn.

use crate::driver::{Case, STIFFNESS, Tick, run};
use telespring::session::strategy::{SetPositionModulation, SetPositionSettings, StrategyChoice};

/// Little enough that the reservoir runs empty, N·s/m.
const DAMPING: f64 = 0.3;
const CEILING: f64 = 0.002;

fn modulated() -> [StrategyChoice; 2] {
    let settings = SetPositionSettings { ceiling: CEILING, ..SetPositionSettings::new(STIFFNESS, DAMPING) };
    [(); 2].map(|()| StrategyChoice::SetPositionModulation(SetPositionModulation::new(settings).unwrap()))
}

/// The set position in use, from the force −B v − k (x − ȳ).
fn set_position(tick: &Tick) -> [f64; 2] {
    let (x, v) = (tick.motion.position, tick.motion.velocity);
    [0, 1].map(|axis| x[axis] + (tick.force[axis] + DAMPING * v[axis]) / STIFFNESS)
}

fn spring_energy(x: [f64; 2], y: [f64; 2]) -> f64 {
    0.5 * STIFFNESS * ((x[0] - y[0]).powi(2) + (x[1] - y[1]).powi(2))
}

#[test]
fn law_the_reservoir_pays_each_jump_of_the_set_position() {
    let mut jumps = 0.0;
    for case in Case::with_and_without_hands() {
        let course = run(&case, modulated());
        for pair in course.0.windows(2) {
            for side in 0..2 {
                let (before, after) = (&pair[0][side], &pair[1][side]);
                if before.report.ticks == 0 {
                    continue; // no spring yet
                }
                let (old, new) = (set_position(before), set_position(after));
                let (x, y) = (before.motion.position, after.motion.position);
                let moved = [y[0] - x[0], y[1] - x[1]];
                let velocity = before.motion.velocity;
                let jump = spring_energy(y, new) - spring_energy(y, old);
                // what the damper took, less what the hold of the spring gave out beyond its energy
                let damper = DAMPING * (velocity[0] * moved[0] + velocity[1] * moved[1]);
                let hold = spring_energy(y, x);
                let received = after.report.energy_received - before.report.energy_received;
                let sent = after.report.energy_sent - before.report.energy_sent;
                let expected = before.report.balance.unwrap() + damper - hold + received - sent - jump;
                let reservoir = after.report.balance.unwrap();
                // the set position is known to about 1e-16 m, of an energy of up to k·0.1 m·1e-16 m
                assert!((reservoir - expected).abs() < 1e-12, "{reservoir} {expected}");
                jumps += jump.max(0.0);
            }
        }
    }
    // more than both reservoirs held at the start
    assert!(jumps > 2.0 * CEILING, "{jumps}");
}

#[test]
fn law_the_reservoir_is_never_below_zero_nor_above_its_ceiling() {
    for case in Case::with_and_without_hands() {
        let course = run(&case, modulated());
        let levels = course.0.iter().flatten().map(|tick| tick.report.balance.unwrap());
        let (least, most) = levels.fold((1.0_f64, 0.0_f64), |(a, b), level| (a.min(level), b.max(level)));
        println!("{least:.1e} to {most:.3} J, limited {:.3}", course.limited_share());
        assert!(least >= -1e-15 && most <= CEILING + 1e-15, "{least} {most}");
        // both sides give out no more than both reservoirs held
        assert!(course.most_given_out() <= 2.0 * CEILING + 1e-12, "{}", course.most_given_out());
    }
}

#[test]
fn law_each_setting_is_refused_with_its_field() {
    let good = SetPositionSettings::new(100.0, 5.0);
    let field = |settings| SetPositionModulation::new(settings).unwrap_err().field;
    assert_eq!(field(SetPositionSettings { stiffness: 0.0, ..good }), "stiffness");
    assert_eq!(field(SetPositionSettings { damping: -1.0, ..good }), "damping");
    assert_eq!(field(SetPositionSettings { ceiling: f64::NAN, ..good }), "ceiling");
}
