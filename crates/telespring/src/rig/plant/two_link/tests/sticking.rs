//! Coulomb friction of the robot's axes in the arm.

use super::*;

const ROUGH: Handle = Handle { mass: [0.8334, 0.7257], damping: [7.7257, 6.1], coulomb: [1.2, 0.8] };
const POINT: TwoLinkArm = TwoLinkArm { link_mass: [0.0; 2], ..MASSLESS };

#[test]
fn law_below_its_level_friction_holds_for_ever_and_above_it_lets_go() {
    let mut plant = TwoLinkPlant::new(ROUGH, ARM, [0.03, -0.02]).unwrap();
    for tick in 0..500 {
        let t = f64::from(tick) * 1e-3;
        // the arm couples both axes: each holds its own share
        plant.advance([0.0; 2], [1.1 * (9.0 * t).sin(), 0.7 * (5.0 * t).cos()], 1e-3).unwrap();
        assert_eq!((plant.position(), plant.velocity()), ([0.03, -0.02], [0.0, 0.0]));
    }
    plant.advance([0.0; 2], [1.3, 0.0], 1e-3).unwrap();
    assert!(plant.velocity()[0] > 0.0);
    assert_eq!(plant.velocity()[1], 0.0, "the other axis still sticks");
}

#[test]
fn ref_a_slide_ends_when_and_where_the_closed_form_says() {
    // m v' = −b v − f: at rest after m/b ln(1 + b v0/f), having gone (m v0 − f t)/b
    let start = [-0.05, 0.04];
    let speed = [0.4, -0.3];
    let mut plant = TwoLinkPlant::new(ROUGH, POINT, start).unwrap().with_velocity(speed);
    let closed = |axis: usize| {
        let (m, b, f) = (ROUGH.mass[axis], ROUGH.damping[axis], ROUGH.coulomb[axis]);
        let time = m / b * (b * speed[axis].abs() / f).ln_1p();
        (time, start[axis] + speed[axis].signum() * (m * speed[axis].abs() - f * time) / b)
    };
    for tick in 1..=400 {
        plant.advance([0.0; 2], [0.0; 2], 1e-3).unwrap();
        for axis in 0..2 {
            let (time, place) = closed(axis);
            if f64::from(tick) * 1e-3 > time {
                assert_eq!(plant.velocity()[axis], 0.0);
                // 1e-12: about a hundred steps of 1e-13
                assert!((plant.position()[axis] - place).abs() < 1e-12);
            } else {
                assert!(plant.velocity()[axis] != 0.0);
            }
        }
    }
}

#[test]
fn law_spans_may_be_cut_anywhere() {
    // long spans hold several events each: both axes stop, stick, start and turn
    let mut whole = TwoLinkPlant::new(ROUGH, ARM, [0.0, -0.02]).unwrap().with_velocity([0.3, -0.2]);
    let mut cut = whole.clone();
    let (mut stuck, mut slipping) = (0, 0);
    for tick in 0..40 {
        let t = f64::from(tick) * 0.05;
        let torque = whole.torque_for([2.0 * (4.1 * t).sin(), 1.4 * (6.3 * t).cos()]);
        whole.advance_by_torque([0.1, 0.0], torque, 0.05).unwrap();
        for _ in 0..50 {
            cut.advance_by_torque([0.1, 0.0], torque, 0.001).unwrap();
        }
        for axis in 0..2 {
            // events are placed to 1e-15 s, steps to 1e-11: their sum over a second or two
            assert!((whole.position()[axis] - cut.position()[axis]).abs() < 1e-10, "{tick}");
            if whole.velocity()[axis] == 0.0 { stuck += 1 } else { slipping += 1 }
        }
    }
    assert!(stuck > 10 && slipping > 10, "{stuck} {slipping}");
}

proptest! {
    // one axis nearly at rest beside a fast one: it stops, sticks, is pulled loose
    #[test]
    fn law_one_long_span_or_a_thousand_short_ones(
        arm in arms(), slow in 0.0..0.005, fast in -0.8..0.8, push in vectors(4.0),
    ) {
        let start = TwoLinkPlant::new(ROUGH, arm, [0.0, -0.02]).unwrap().with_velocity([slow, fast]);
        let (mut whole, mut cut) = (start.clone(), start);
        let torque = whole.torque_for([0.0; 2]);
        if whole.advance_by_torque(push, torque, 0.1).is_err() { return Ok(()) }
        for _ in 0..1000 {
            cut.advance_by_torque(push, torque, 1e-4).unwrap();
        }
        for axis in 0..2 {
            // steps to 1e-11 m/s for 0.1 s, and what is said at `first_event`
            let off = (whole.position()[axis] - cut.position()[axis]).abs();
            prop_assert!(off < 1e-10, "{off:e}");
        }
    }
}

#[test]
fn pin_an_axis_lets_go_once() {
    // rounding once left this axis neither stuck nor slipping, 64 events long, and then without friction
    let arm = TwoLinkArm {
        link_length: [0.2858603128552258, 0.3382086894070268],
        link_mass: [0.6798471584607139, 1.7185036906929754],
        link_centre: [0.27674258926155854, 0.09636874918354299],
        link_inertia: [0.015539699401390957, 0.004168340283901343],
        joint_damping: [0.49187688115810807, 0.11034691414591413],
        rotor_inertia: [0.03784721404518464, 0.02202679163485342],
        ..ARM
    };
    let velocity = [0.012155072679212817, -0.26738566729188323];
    let push = [-3.415366572224291, 1.9254393295320968];
    let mut whole = TwoLinkPlant::new(ROUGH, arm, [0.0, -0.02]).unwrap().with_velocity(velocity);
    let mut cut = whole.clone();
    whole.advance_by_torque(push, [0.0; 2], 0.1).unwrap();
    for _ in 0..1000 {
        cut.advance_by_torque(push, [0.0; 2], 1e-4).unwrap();
    }
    for axis in 0..2 {
        // it was 5e-10
        assert!((whole.position()[axis] - cut.position()[axis]).abs() < 1e-11);
    }
}

#[test]
fn law_a_stuck_axis_is_set_loose_by_the_other_ones_motion() {
    // y is pushed close to its level; then x is thrown, and the arm's coupling breaks y loose
    let hold = [0.0, 0.79];
    let still = TwoLinkPlant::new(ROUGH, ARM, [0.06, 0.02]).unwrap();
    let mut one = still.clone();
    one.advance(hold, [0.0; 2], 1e-3).unwrap();
    assert_eq!(one.velocity(), [0.0; 2]);
    let mut thrown = still;
    thrown.advance([6.0, 0.79], [0.0; 2], 1e-3).unwrap();
    let mut pulled = TwoLinkPlant::new(ROUGH, ARM, [0.06, 0.02]).unwrap();
    pulled.advance([-6.0, 0.79], [0.0; 2], 1e-3).unwrap();
    // the coupling pushes y forward in one of both directions and back in the other
    let forward = [thrown.velocity()[1] > 0.0, pulled.velocity()[1] > 0.0];
    assert!(forward[0] != forward[1], "{thrown:?} {pulled:?}");
}

#[test]
fn law_friction_only_takes_energy() {
    let arm = TwoLinkArm { joint_damping: [0.0; 2], ..ARM };
    let handle = Handle { damping: [0.0; 2], ..ROUGH };
    let mut plant = TwoLinkPlant::new(handle, arm, [-0.08, -0.1]).unwrap().with_velocity([0.4, 0.3]);
    let start = plant.kinetic_energy();
    let (mut energy, mut work) = (start, 0.0);
    while energy > 0.0 {
        let before = plant.position();
        plant.advance([0.0; 2], [0.0; 2], 1e-4).unwrap();
        let now = plant.kinetic_energy();
        assert!(now <= energy);
        energy = now;
        for axis in 0..2 {
            work += handle.coulomb[axis] * (plant.position()[axis] - before[axis]).abs();
        }
    }
    // level times way; 1e-7: an axis that turns around inside a tick goes a little further
    assert!((work - start).abs() < 1e-7 * start, "{work} {start}");
    assert_eq!(plant.velocity(), [0.0; 2]);
}
