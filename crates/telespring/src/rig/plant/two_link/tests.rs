//! The arm against textbook formulas in joint angles, conservation laws and closed forms.

mod sticking;

use proptest::prelude::*;

use super::dynamics::ArmDynamics;
use super::friction::{Contact, consistent_contacts, motion_under};
use super::kinematics::{Pose, dot};
use super::{Halt, OutOfReach, TwoLinkPlant};
use crate::rig::{Elbow, Handle, TwoLinkArm};

const ROBOT: Handle = Handle { mass: [0.8334, 0.7257], damping: [7.7257, 6.1], coulomb: [0.0; 2] };
const BARE: Handle = Handle { mass: [0.8334, 0.7257], damping: [0.0; 2], coulomb: [0.0; 2] };
const ARM: TwoLinkArm = TwoLinkArm {
    // unequal everywhere, so that no mistake of an index cancels
    base: [0.03, -0.44],
    elbow: Elbow::Right,
    link_length: [0.34, 0.31],
    link_mass: [0.9, 0.4],
    link_centre: [0.25, 0.17],
    link_inertia: [0.0099, 0.0036],
    joint_damping: [0.4, 0.3],
    rotor_inertia: [0.02, 0.012],
    torque_limit: [f64::INFINITY; 2],
};
const MASSLESS: TwoLinkArm = TwoLinkArm {
    link_mass: [0.0; 2],
    link_inertia: [0.0; 2],
    joint_damping: [0.0; 2],
    rotor_inertia: [0.0; 2],
    ..ARM
};

fn arms() -> impl Strategy<Value = TwoLinkArm> {
    let pair = |low: f64, high: f64| [low..high, low..high];
    (
        any::<bool>(),
        pair(0.28, 0.36),
        pair(0.0, 2.0),
        pair(0.05, 0.3),
        pair(0.0, 0.02),
        pair(0.0, 0.5),
        pair(0.0, 0.05),
    )
        .prop_map(
            |(left, link_length, link_mass, link_centre, link_inertia, joint_damping, rotor_inertia)| {
                let elbow = if left { Elbow::Left } else { Elbow::Right };
                TwoLinkArm {
                    elbow,
                    link_length,
                    link_mass,
                    link_centre,
                    link_inertia,
                    joint_damping,
                    rotor_inertia,
                    ..ARM
                }
            },
        )
}

fn places() -> impl Strategy<Value = [f64; 2]> {
    [-0.1..0.1, -0.1..0.1]
}

fn vectors(size: f64) -> impl Strategy<Value = [f64; 2]> {
    [-size..size, -size..size]
}

/// The same rig in joint angles: M(θ) θ″ + C(θ, θ′) θ′ + D θ′ = τ + Jᵀ (robot), as in B. Siciliano et
/// al., Robotics, 2009, sections 7.3.2 (the two-link arm) and 3.1 (its Jacobian).
struct InJointAngles {
    arm: TwoLinkArm,
    handle: Handle,
    torque: [f64; 2],
    robot_force: [f64; 2],
}

impl InJointAngles {
    fn jacobian(&self, [t1, t2]: [f64; 2]) -> [[f64; 2]; 2] {
        let [a1, a2] = self.arm.link_length;
        [
            [-a1 * t1.sin() - a2 * (t1 + t2).sin(), -a2 * (t1 + t2).sin()],
            [a1 * t1.cos() + a2 * (t1 + t2).cos(), a2 * (t1 + t2).cos()],
        ]
    }

    fn handle_position(&self, [t1, t2]: [f64; 2]) -> [f64; 2] {
        let [a1, a2] = self.arm.link_length;
        [
            self.arm.base[0] + a1 * t1.cos() + a2 * (t1 + t2).cos(),
            self.arm.base[1] + a1 * t1.sin() + a2 * (t1 + t2).sin(),
        ]
    }

    fn acceleration(&self, angle: [f64; 2], rate: [f64; 2]) -> [f64; 2] {
        let TwoLinkArm {
            link_length,
            link_mass,
            link_centre,
            link_inertia,
            rotor_inertia,
            joint_damping,
            ..
        } = self.arm;
        let (a1, [c1, c2], [m1, m2]) = (link_length[0], link_centre, link_mass);
        let (cos, sin) = (angle[1].cos(), angle[1].sin());
        let b22 = link_inertia[1] + m2 * c2 * c2;
        let b12 = b22 + m2 * a1 * c2 * cos;
        let b11 = link_inertia[0] + m1 * c1 * c1 + m2 * a1 * a1 + b22 + 2.0 * m2 * a1 * c2 * cos;
        let h = -m2 * a1 * c2 * sin;
        let coriolis = [h * rate[1] * rate[0] + h * (rate[0] + rate[1]) * rate[1], -h * rate[0] * rate[0]];
        // the robot: its mass carried into the joints, with the Jacobian's own change
        let j = self.jacobian(angle);
        let (a2, w) = (link_length[1], rate[0] + rate[1]);
        let (s1, k1) = (angle[0].sin(), angle[0].cos());
        let (s12, k12) = ((angle[0] + angle[1]).sin(), (angle[0] + angle[1]).cos());
        let steady = [
            -a1 * k1 * rate[0] * rate[0] - a2 * k12 * w * w,
            -a1 * s1 * rate[0] * rate[0] - a2 * s12 * w * w,
        ];
        let velocity = [dot(j[0], rate), dot(j[1], rate)];
        let pull: Vec<f64> = (0..2)
            .map(|axis| {
                self.robot_force[axis]
                    - self.handle.damping[axis] * velocity[axis]
                    - self.handle.mass[axis] * steady[axis]
            })
            .collect();
        let mut b = [[b11 + rotor_inertia[0], b12], [b12, b22 + rotor_inertia[1]]];
        let mut right = [0.0; 2];
        for i in 0..2 {
            right[i] = self.torque[i] - coriolis[i] - joint_damping[i] * rate[i];
            for axis in 0..2 {
                right[i] += j[axis][i] * pull[axis];
                for k in 0..2 {
                    b[i][k] += self.handle.mass[axis] * j[axis][i] * j[axis][k];
                }
            }
        }
        let determinant = b[0][0] * b[1][1] - b[0][1] * b[1][0];
        [
            (b[1][1] * right[0] - b[0][1] * right[1]) / determinant,
            (b[0][0] * right[1] - b[1][0] * right[0]) / determinant,
        ]
    }

    /// Classical Runge-Kutta steps.
    fn run(&self, mut angle: [f64; 2], mut rate: [f64; 2], span: f64, steps: usize) -> ([f64; 2], [f64; 2]) {
        let h = span / steps as f64;
        let along = |a: [f64; 2], b: [f64; 2], s: f64| [a[0] + s * b[0], a[1] + s * b[1]];
        for _ in 0..steps {
            let (v1, a1) = (rate, self.acceleration(angle, rate));
            let (v2, a2) = (
                along(rate, a1, h / 2.0),
                self.acceleration(along(angle, v1, h / 2.0), along(rate, a1, h / 2.0)),
            );
            let (v3, a3) = (
                along(rate, a2, h / 2.0),
                self.acceleration(along(angle, v2, h / 2.0), along(rate, a2, h / 2.0)),
            );
            let (v4, a4) = (along(rate, a3, h), self.acceleration(along(angle, v3, h), along(rate, a3, h)));
            for i in 0..2 {
                angle[i] += h / 6.0 * (v1[i] + 2.0 * v2[i] + 2.0 * v3[i] + v4[i]);
                rate[i] += h / 6.0 * (a1[i] + 2.0 * a2[i] + 2.0 * a3[i] + a4[i]);
            }
        }
        (angle, rate)
    }
}

#[test]
fn cross_joint_angles_and_tiny_steps_move_the_handle_alike() {
    for elbow in [Elbow::Left, Elbow::Right] {
        let arm = TwoLinkArm { elbow, ..ARM };
        let mut plant = TwoLinkPlant::new(ROBOT, arm, [-0.09, -0.05]).unwrap().with_velocity([0.5, -0.2]);
        let (mut angle, mut rate) = (plant.joint_angles(), plant.joint_velocities());
        let (mut fastest, mut turning) = (0.0_f64, 0.0_f64);
        for tick in 0..600 {
            let t = f64::from(tick) * 1e-3;
            let target = [0.08 * (17.0 * t).cos(), 0.1 * (14.0 * t).sin() - 0.03];
            let force = [0, 1].map(|axis| 700.0 * (target[axis] - plant.position()[axis]));
            let robot_force = [3.0 * (7.0 * t).sin(), -2.0];
            let torque = plant.torque_for(force);
            plant.advance(robot_force, force, 1e-3).unwrap();
            let model = InJointAngles { arm, handle: ROBOT, torque, robot_force };
            // 20 steps a tick: 1.6e5 times closer than one, whose error is about 1e-10
            (angle, rate) = model.run(angle, rate, 1e-3, 20);
            let expected = model.handle_position(angle);
            for axis in 0..2 {
                let off = (plant.position()[axis] - expected[axis]).abs();
                // 1e-9 of the reach of the motion, 0.1 m
                assert!(off < 1e-10, "{elbow:?} tick {tick}: {off:e}");
            }
            fastest = fastest.max(dot(plant.velocity(), plant.velocity()).sqrt());
            turning = turning.max(rate[1].abs());
        }
        assert!(fastest > 1.0 && turning > 4.0, "the test is to be fast: {fastest} m/s, {turning} rad/s");
    }
}

#[test]
fn ref_massless_arm_passes_the_force_on_exactly() {
    // Eqs. 13 and 14 with the ideal arm: J⁻ᵀ (Jᵀ F) = F
    for (position, force) in
        [([0.0, 0.0], [3.0, -7.0]), ([0.05, -0.1], [-1e-3, 40.0]), ([-0.08, 0.09], [0.0, 1.0])]
    {
        let plant = TwoLinkPlant::new(ROBOT, MASSLESS, position).unwrap().with_velocity([0.7, -0.4]);
        let felt = plant.handle_force([5.0, 6.0], force);
        for axis in 0..2 {
            assert!((felt[axis] - force[axis]).abs() < 1e-14 * 40.0, "{felt:?} {force:?}");
        }
    }
}

#[test]
fn ref_all_mass_at_the_handle_is_a_point_mass() {
    // a point mass m' at the end of massless links: (m + m') v' = f − b v on each axis apart
    let extra = 0.6;
    let arm = TwoLinkArm { link_mass: [0.0, extra], link_centre: [0.1, ARM.link_length[1]], ..MASSLESS };
    let (mass, damping) = arm.operator_at([0.04, 0.02]).unwrap();
    for (matrix, expected) in [(mass, extra), (damping, 0.0)] {
        for i in 0..2 {
            for j in 0..2 {
                let expected = if i == j { expected } else { 0.0 };
                assert!((matrix[i][j] - expected).abs() < 1e-14, "{matrix:?}");
            }
        }
    }
    let force = [2.0, -1.5];
    let mut plant = TwoLinkPlant::new(ROBOT, arm, [-0.05, 0.05]).unwrap();
    for _ in 0..400 {
        plant.advance(force, [0.0; 2], 1e-3).unwrap();
    }
    for axis in 0..2 {
        let decay = ROBOT.damping[axis] / (ROBOT.mass[axis] + extra);
        let velocity = -force[axis] / ROBOT.damping[axis] * (-decay * 0.4_f64).exp_m1();
        let position = [-0.05, 0.05][axis] + force[axis] / ROBOT.damping[axis] * 0.4 - velocity / decay;
        // 1e-11: a hundred times the error that each of 400 steps may make
        assert!((plant.velocity()[axis] - velocity).abs() < 1e-11);
        assert!((plant.position()[axis] - position).abs() < 1e-11);
    }
}

#[test]
fn ref_a_rotor_alone_weighs_as_its_lever_says() {
    // only the shoulder's rotor I: the handle feels I/r² across the line of the lower link through the
    // shoulder's lever; moving along the upper link's normal is free of it otherwise
    let arm = TwoLinkArm { rotor_inertia: [0.03, 0.0], ..MASSLESS };
    let position = [0.02, 0.05];
    let (mass, _) = arm.operator_at(position).unwrap();
    let pose = Pose::at(&arm, position).unwrap();
    // the handle moves freely across the lower link: then the upper one stands still
    let across = [-pose.link[1][1], pose.link[1][0]];
    let along = pose.link[1];
    let times = |v: [f64; 2]| [dot(mass[0], v), dot(mass[1], v)];
    assert!(dot(across, times(across)).abs() < 1e-14);
    let lever = arm.link_length[0] * pose.sine;
    assert!((dot(along, times(along)) - 0.03 / (lever * lever)).abs() < 1e-12);
}

#[test]
fn law_energy_stays_without_damping_and_torque() {
    let arm = TwoLinkArm { joint_damping: [0.0; 2], ..ARM };
    let mut plant = TwoLinkPlant::new(BARE, arm, [-0.1, -0.12]).unwrap().with_velocity([1.2, 0.9]);
    let energy = plant.kinetic_energy();
    let mut furthest = 0.0_f64;
    for _ in 0..120 {
        plant.advance([0.0; 2], [0.0; 2], 1e-3).unwrap();
        // 120 steps of at most 1e-11 each
        assert!((plant.kinetic_energy() / energy - 1.0).abs() < 1e-9);
        furthest = furthest.max((plant.velocity()[0] - 1.2).abs());
    }
    assert!(furthest > 0.05, "the arm is to turn the motion: {furthest}");
}

#[test]
fn law_power_in_is_power_stored_and_lost() {
    let mut plant = TwoLinkPlant::new(ROBOT, ARM, [-0.08, -0.04]).unwrap().with_velocity([0.8, -0.3]);
    let (robot_force, hand_force, h) = ([2.0, -3.0], [15.0, 25.0], 1e-5);
    for _ in 0..20 {
        let mut before = plant.clone();
        let torque = plant.torque_for(hand_force);
        plant.advance_by_torque(robot_force, torque, h).unwrap();
        let gained = (plant.kinetic_energy() - before.kinetic_energy()) / h;
        before.advance_by_torque(robot_force, torque, h / 2.0).unwrap();
        let (v, rate) = (before.velocity(), before.joint_velocities());
        let mut power = dot(robot_force, v) + dot(torque, rate);
        for i in 0..2 {
            power -= ROBOT.damping[i] * v[i] * v[i] + ARM.joint_damping[i] * rate[i] * rate[i];
        }
        // the midpoint misses h² times third derivatives, about 1e-10·1e4, and rounding over h, 1e-10
        assert!((gained - power).abs() < 1e-5 * power.abs().max(1.0), "{gained} {power}");
        for _ in 0..9 {
            plant.advance(robot_force, hand_force, 1e-3).unwrap();
        }
    }
}

#[test]
fn law_leaving_the_reach_is_told_and_leaves_the_handle_inside() {
    let mut plant = TwoLinkPlant::new(ROBOT, TwoLinkArm::HEBI_X8, [0.0, 0.1]).unwrap();
    let halt = (0..5000).find_map(|_| plant.advance([0.0, 30.0], [0.0; 2], 1e-3).err());
    let Some(Halt::OutOfReach(OutOfReach { position })) = halt else { panic!("the handle is pushed away") };
    assert_eq!(position, plant.position());
    assert!((0.19..0.2).contains(&position[1]), "{position:?}");
    assert!(plant.handle_force([0.0; 2], [1.0, 1.0]).iter().all(|force| force.is_finite()));
    for wrong in [f64::NAN, f64::INFINITY] {
        let mut plant = TwoLinkPlant::new(ROBOT, ARM, [0.0, 0.0]).unwrap();
        assert!(plant.advance([wrong, 0.0], [0.0; 2], 1e-3).is_err());
        assert_eq!(plant.position(), [0.0, 0.0]);
    }
    assert!(TwoLinkPlant::new(ROBOT, ARM, [0.0, 0.3]).is_err());
    assert!(TwoLinkPlant::new(ROBOT, ARM, [f64::NAN, 0.0]).is_err());
}

#[test]
fn law_a_torque_limit_cuts_each_joint_apart() {
    let arm = TwoLinkArm { torque_limit: [2.0, 1.5], ..ARM };
    let (free, limited) =
        (TwoLinkPlant::new(ROBOT, ARM, [0.0; 2]).unwrap(), TwoLinkPlant::new(ROBOT, arm, [0.0; 2]).unwrap());
    for force in [[1.0, 0.5], [40.0, -3.0], [-8.0, 60.0]] {
        let (wanted, given) = (free.torque_for(force), limited.torque_for(force));
        for joint in 0..2 {
            assert_eq!(given[joint], wanted[joint].clamp(-arm.torque_limit[joint], arm.torque_limit[joint]));
        }
    }
}

proptest! {
    #[test]
    fn law_the_handles_inertia_holds_the_links_kinetic_energy(
        arm in arms(), position in places(), velocity in vectors(1.5),
    ) {
        // the velocities of every link from two poses a moment apart
        let at = |t: f64| Pose::at(&arm, [position[0] + t * velocity[0], position[1] + t * velocity[1]]);
        let h = 1e-5;
        let (Ok(past), Ok(future)) = (at(-h), at(h)) else { return Ok(()) };
        let centres = |pose: &Pose| {
            let [u1, u2] = pose.link;
            let first = [arm.link_centre[0] * u1[0], arm.link_centre[0] * u1[1]];
            let second = [0, 1].map(|i| arm.link_length[0] * u1[i] + arm.link_centre[1] * u2[i]);
            [first, second]
        };
        let rate = |past: f64, future: f64| (future - past) / (2.0 * h);
        let turn = |a: [f64; 2], b: [f64; 2]| (a[0] * b[1] - a[1] * b[0]).asin() / (2.0 * h);
        let (before, after) = (centres(&past), centres(&future));
        let turning = [0, 1].map(|link| turn(past.link[link], future.link[link]));
        let mut energy = 0.0;
        for link in 0..2 {
            let v = [0, 1].map(|i| rate(before[link][i], after[link][i]));
            energy += 0.5 * arm.link_mass[link] * dot(v, v) + 0.5 * arm.link_inertia[link] * turning[link].powi(2);
        }
        energy += 0.5 * arm.rotor_inertia[0] * turning[0].powi(2)
            + 0.5 * arm.rotor_inertia[1] * (turning[1] - turning[0]).powi(2);
        let lost = arm.joint_damping[0] * turning[0].powi(2)
            + arm.joint_damping[1] * (turning[1] - turning[0]).powi(2);
        let (mass, damping) = arm.operator_at(position).unwrap();
        let form = |m: [[f64; 2]; 2]| dot(velocity, [dot(m[0], velocity), dot(m[1], velocity)]);
        // h² of the curvature, (5 rad/s)² each way near the limit of reach a hundredfold
        prop_assert!((0.5 * form(mass) - energy).abs() < 1e-5 * energy.max(1e-6));
        prop_assert!((form(damping) - lost).abs() < 1e-5 * lost.max(1e-6));
    }

    #[test]
    fn law_a_mirrored_arm_moves_mirrored(
        arm in arms(), position in places(), velocity in vectors(0.5), force in vectors(20.0), push in vectors(5.0),
        coulomb in [0.0..2.0, 0.0..2.0],
    ) {
        let handle = Handle { coulomb, ..ROBOT };
        let flip = |v: [f64; 2]| [-v[0], v[1]];
        let other = TwoLinkArm {
            base: flip(arm.base),
            elbow: if arm.elbow == Elbow::Left { Elbow::Right } else { Elbow::Left },
            ..arm
        };
        let (Ok(one), Ok(two)) =
            (TwoLinkPlant::new(handle, arm, position), TwoLinkPlant::new(handle, other, flip(position)))
        else { return Ok(()) };
        let (mut one, mut two) = (one.with_velocity(velocity), two.with_velocity(flip(velocity)));
        for _ in 0..50 {
            let (a, b) = (one.advance(push, force, 1e-3), two.advance(flip(push), flip(force), 1e-3));
            if a.is_err() || b.is_err() {
                break;
            }
            for axis in 0..2 {
                // 1e-12: both are rounded alike but for the sign of zero-sum terms
                prop_assert!((one.position()[axis] - flip(two.position())[axis]).abs() < 1e-12);
                prop_assert!((one.velocity()[axis] - flip(two.velocity())[axis]).abs() < 1e-10);
            }
        }
    }

    #[test]
    fn law_the_arms_force_is_what_moves_the_robot(
        arm in arms(), position in places(), velocity in vectors(1.0), force in vectors(20.0), push in vectors(5.0),
    ) {
        let Ok(plant) = TwoLinkPlant::new(ROBOT, arm, position) else { return Ok(()) };
        let plant = plant.with_velocity(velocity);
        let felt = plant.handle_force(push, force);
        let mut later = plant.clone();
        if later.advance(push, force, 1e-6).is_err() { return Ok(()) }
        for axis in 0..2 {
            let acceleration = (later.velocity()[axis] - velocity[axis]) / 1e-6;
            let needed = ROBOT.mass[axis] * acceleration + ROBOT.damping[axis] * velocity[axis] - push[axis];
            // 1e-6 s of a jerk of up to 1e5 m/s³ near the limit of reach, and rounding over 1e-6 s
            prop_assert!((felt[axis] - needed).abs() < 1e-3 * (1.0 + felt[axis].abs()), "{felt:?} {needed}");
        }
    }

    #[test]
    fn law_exactly_one_pair_of_contacts_is_consistent(
        arm in arms(), position in places(), torque in vectors(4.0), push in vectors(10.0),
        coulomb in [0.1..5.0, 0.1..5.0],
    ) {
        let rig = ArmDynamics::new(Handle { coulomb, ..ROBOT }, arm);
        let Ok(balance) = rig.force_balance(position, [0.0; 2], torque, push) else { return Ok(()) };
        let chosen = consistent_contacts(&balance, [0.0; 2], coulomb);
        let all = [Contact::Stuck, Contact::Forward, Contact::Backward];
        let consistent: Vec<_> = all.iter().flat_map(|&x| all.map(|y| [x, y])).filter(|&pair| {
            let moved = motion_under(&balance, pair, coulomb);
            (0..2).all(|axis| match pair[axis] {
                Contact::Stuck => moved.friction[axis].abs() <= coulomb[axis],
                other => other.direction() * moved.acceleration[axis] > 0.0,
            })
        }).collect();
        prop_assert_eq!(consistent, vec![chosen]);
    }
}
