//! Franken et al. (2011): the energy in both tanks and under way is what it was, less what came out; the force is limited by
//! the tank.

use crate::driver::{Case, STIFFNESS, run, spring_law};
use telespring::session::strategy::{StrategyChoice, TankSettings, TwoLayer};

fn layers(settings: TankSettings) -> [StrategyChoice; 2] {
    [(); 2].map(|()| StrategyChoice::TwoLayer(TwoLayer::new(spring_law(), settings).unwrap()))
}

#[test]
fn law_the_energy_in_both_tanks_under_way_and_given_out_never_changes() {
    let settings = TankSettings::new(STIFFNESS);
    for case in Case::with_and_without_hands() {
        for ticks in run(&case, layers(settings)).0 {
            let [one, two] = ticks;
            let tanks = one.report.balance.unwrap() + two.report.balance.unwrap();
            let sent = one.report.energy_sent + two.report.energy_sent;
            let under_way = sent - one.report.energy_received - two.report.energy_received;
            let all = tanks + under_way + one.given_out + two.given_out;
            assert!((all - 2.0 * settings.level).abs() < 1e-9, "{all}");
            assert!(under_way >= -1e-12, "{under_way}");
        }
    }
}

#[test]
fn law_the_force_is_limited_by_the_tank() {
    // without the damper that fills the tank, all force is that of the upper layer
    let settings = TankSettings { filling: 0.0, ..TankSettings::new(STIFFNESS) };
    let mut limited = 0;
    for case in Case::with_and_without_hands() {
        let course = run(&case, layers(settings));
        let one_tick = course.most_in_a_tick();
        for tick in course.0.iter().flatten() {
            let tank = tick.report.balance.unwrap();
            let most = (2.0 * settings.saturation_stiffness * tank.max(0.0)).sqrt();
            let [x, y] = tick.force;
            assert!(x.hypot(y) <= most * (1.0 + 1e-12), "{x} {y} {most}");
            let [u, v] = tick.motion.velocity;
            assert!((x * u + y * v) * 1e-3 <= tank.max(0.0) + 1e-15);
            // it is empty at worst, but for what one tick cannot foresee
            assert!(tank >= -one_tick, "{tank} {one_tick}");
        }
        limited += course.0.last().unwrap()[0].report.limited_ticks;
    }
    assert!(limited > 10_000, "{limited}");
}

#[test]
fn law_a_side_without_energy_moves_nothing_until_its_hand_fills_the_tank() {
    let empty = TankSettings { level: 0.0, ..TankSettings::new(STIFFNESS) };
    let case = Case { velocity: 0.0, pull: 5.0, ..Case::free(84, 3.0) };
    assert!(run(&case, layers(empty)).0.iter().flatten().all(|tick| tick.force == [0.0; 2]));
    // the damper of the first side takes energy from its hand, and a share of it moves the second handle
    let filled = TankSettings { level: 0.02, ..TankSettings::new(STIFFNESS) };
    let mut sides = layers(empty);
    sides[0] = layers(filled)[0].clone();
    let course = run(&case, sides);
    let [one, two] = course.0.last().unwrap();
    println!("{:.3} m pulled, {:.3} m followed", one.motion.position[0], two.motion.position[0]);
    assert!(two.given_out > 1e-3 && two.motion.position[0] > 0.1, "{}", two.given_out);
}

#[test]
fn law_each_setting_is_refused_with_its_field() {
    let good = TankSettings::new(100.0);
    let field = |settings| TwoLayer::new(spring_law(), settings).unwrap_err().field;
    assert_eq!(field(TankSettings { level: -1.0, ..good }), "level");
    assert_eq!(field(TankSettings { transfer_rate: f64::NAN, ..good }), "transfer_rate");
    assert_eq!(field(TankSettings { filling: f64::INFINITY, ..good }), "filling");
    assert_eq!(field(TankSettings { largest_damping: -1.0, ..good }), "largest_damping");
    assert_eq!(field(TankSettings { saturation_stiffness: 0.0, ..good }), "saturation_stiffness");
}
