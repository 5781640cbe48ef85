//! The handle with a lumped arm against closed forms, and with friction against a brute-force integration.

use proptest::prelude::*;
use telespring::rig::Handle;
use telespring::rig::plant::{LumpedPlant, RelaxingForce};

fn handle(mass: f64, damping: f64, coulomb: f64) -> Handle {
    Handle { mass: [mass; 2], damping: [damping; 2], coulomb: [coulomb; 2] }
}

fn plant(mass: f64, damping: f64, coulomb: f64) -> LumpedPlant {
    LumpedPlant::new(handle(mass, damping, coulomb), [0.0; 2], [0.0; 2], [0.0; 2])
}

#[track_caller]
fn close(got: f64, expected: f64, tolerance: f64) {
    assert!((got - expected).abs() <= tolerance * expected.abs(), "{got} is not {expected}");
}

#[test]
fn ref_a_constant_force_gives_the_closed_form() {
    // v = F/b (1 − e^(−bt/m)), x = F/b (t − m/b (1 − e^(−bt/m))), in one span or many
    let (mass, damping, force, time) = (0.8334, 7.7257, 2.5, 0.4_f64);
    let rate = damping / mass;
    let (v, x) = (
        force / damping * -(-rate * time).exp_m1(),
        force / damping * (time + (-rate * time).exp_m1() / rate),
    );
    for spans in [1, 7, 400] {
        let mut plant = plant(mass, damping, 0.0);
        for _ in 0..spans {
            plant.advance([force, -force], [0.0; 2], time / f64::from(spans));
        }
        // rounding of up to 400 steps
        close(plant.velocity()[0], v, 1e-13);
        close(plant.position()[0], x, 1e-13);
        assert_eq!(plant.position()[1], -plant.position()[0]);
    }
    // without damping: x = F t²/(2m)
    let mut plant = plant_undamped_pushed(mass, force, time);
    close(plant.velocity()[0], force * time / mass, 1e-15);
    close(plant.position()[0], 0.5 * force * time * time / mass, 1e-15);
    plant.advance([0.0; 2], [0.0; 2], 1.0);
    close(plant.velocity()[0], force * time / mass, 1e-15);
}

fn plant_undamped_pushed(mass: f64, force: f64, time: f64) -> LumpedPlant {
    let mut plant = plant(mass, 0.0, 0.0);
    plant.advance([force; 2], [0.0; 2], time);
    plant
}

#[test]
fn ref_below_the_friction_nothing_moves_and_the_handle_force_is_the_hands() {
    let mut plant = plant(1.0, 4.0, 2.0);
    for _ in 0..1000 {
        plant.advance([2.5, 0.0], [-0.5, 1.999], 1e-3);
    }
    assert_eq!(plant.position(), [0.0; 2]);
    assert_eq!(plant.velocity(), [0.0; 2]);
    assert_eq!(plant.handle_force([2.5, 0.0], [-0.5, 1.999]), [-0.5, 1.999]);
    plant.advance([2.0, 2.0 + 1e-9], [0.0; 2], 1e-3);
    assert_eq!(plant.position()[0], 0.0);
    assert!(plant.position()[1] > 0.0);
}

#[test]
fn ref_friction_stops_a_moving_handle_after_the_known_distance() {
    // m v' = −C: m v₀²/(2C); with damping m/b (v₀ − C/b ln(1 + b v₀/C))
    for (mass, damping, coulomb, span) in
        [(1.3, 0.0, 2.0, 1e-3), (1.3, 0.0, 2.0, 0.5), (0.8, 5.0, 1.5, 1e-3), (0.8, 1e-9, 1.5, 1e-3)]
    {
        let mut plant = plant(mass, damping, coulomb);
        plant.advance([30.0, -30.0], [0.0; 2], 0.02);
        let (start, speed) = (plant.position()[0], plant.velocity()[0]);
        for _ in 0..(1.0 / span) as usize {
            plant.advance([0.0; 2], [0.0; 2], span);
        }
        let distance = if damping < 1e-6 {
            0.5 * mass * speed * speed / coulomb
        } else {
            mass / damping * (speed - coulomb / damping * (damping * speed / coulomb).ln_1p())
        };
        assert_eq!(plant.velocity(), [0.0; 2]);
        // 1e-9 N·s/m is left out of the closed form
        close(plant.position()[0] - start, distance, 1e-9);
        assert_eq!(plant.position()[0], -plant.position()[1]);
    }
}

#[test]
fn ref_a_reversal_inside_a_span_slips_on_with_the_friction_turned() {
    // stops after t₁ = m v₀/(F + C), starts back with F − C
    let (mass, coulomb, force, span) = (2.0, 1.0, 5.0, 0.3);
    let mut plant = plant(mass, 0.0, coulomb);
    plant.advance([7.0; 2], [0.0; 2], 0.1);
    let (x, v) = (plant.position()[0], plant.velocity()[0]);
    plant.advance([-force; 2], [0.0; 2], span);
    let stop = mass * v / (force + coulomb);
    let back = span - stop;
    close(plant.velocity()[0], -(force - coulomb) / mass * back, 1e-14);
    let turned = x + 0.5 * v * stop;
    close(plant.position()[0], turned - 0.5 * (force - coulomb) / mass * back * back, 1e-13);
}

/// Moreau's time stepping: per small step the friction impulse that the Coulomb law allows.
struct BruteForce {
    mass: f64,
    damping: f64,
    coulomb: f64,
    position: f64,
    velocity: f64,
}

impl BruteForce {
    fn advance(&mut self, force: f64, span: f64, steps: usize) {
        let h = span / steps as f64;
        for _ in 0..steps {
            let free = self.velocity + h / self.mass * (force - self.damping * self.velocity);
            let most = h * self.coulomb / self.mass;
            let next = free - free.clamp(-most, most);
            self.position += 0.5 * h * (self.velocity + next);
            self.velocity = next;
        }
    }
}

#[test]
fn cross_stick_slip_follows_a_brute_force_integration() {
    // a block drawn to and fro by a spring: it sticks at every turn until the spring is drawn far enough
    let (mass, damping, coulomb, stiffness) = (1.0, 0.8, 1.5, 60.0);
    let mut plant = plant(mass, damping, coulomb);
    let mut brute = BruteForce { mass, damping, coulomb, position: 0.0, velocity: 0.0 };
    let (mut worst, mut starts, mut stuck) = (0.0_f64, 0, true);
    for tick in 0..8_000 {
        let end = 0.08 * (3e-3 * f64::from(tick)).sin();
        let pull = stiffness * (end - plant.position()[0]);
        let brute_pull = stiffness * (end - brute.position);
        plant.advance([pull, 0.0], [0.0; 2], 1e-3);
        brute.advance(brute_pull, 1e-3, 1000);
        worst = worst.max((plant.position()[0] - brute.position).abs());
        let sticks = plant.velocity()[0] == 0.0;
        starts += usize::from(stuck && !sticks);
        stuck = sticks;
    }
    assert!(starts >= 6, "{starts}");
    // a start is decided at a tick: the first-order errors of the small steps (1 µs) must not move it
    assert!(worst < 1e-6, "{worst}");
}

#[test]
fn cross_a_relaxing_force_is_the_limit_of_short_steps() {
    for (damping, lag) in
        [(7.7, 0.005), (0.0, 0.02), (300.0, 1e-3), (7.7, 1e-5), (0.0, 1e-7), (7.7, 0.8 / 7.7)]
    {
        let (mass, span) = (0.8, 1e-3);
        let force = RelaxingForce { from: [3.0, -1.0], to: [-2.0, 4.0], time_constant: lag };
        let mut exact = plant(mass, damping, 0.0);
        let mut fine = plant(mass, damping, 0.0);
        exact.advance([5.0; 2], [0.0; 2], 0.1);
        fine.advance([5.0; 2], [0.0; 2], 0.1);
        let start = fine.position();
        exact.advance_relaxing(&force, [0.5; 2], span);
        // steps that are short beside lag and span, each with the mean of its force
        let mut now = force;
        let steps = 20_000;
        for _ in 0..steps {
            let short = span / f64::from(steps);
            fine.advance(now.mean(short), [0.5; 2], short);
            now.from = now.after(short);
        }
        for axis in 0..2 {
            // the mean over a short step misses the moment by (step/lag)²/12 of the change
            close(exact.velocity()[axis], fine.velocity()[axis], 1e-9);
            close(exact.position()[axis] - start[axis], fine.position()[axis] - start[axis], 1e-8);
        }
    }
}

#[test]
fn ref_a_massless_arm_passes_the_hands_force_on_and_a_heavy_one_keeps_its_share() {
    let handle = handle(0.8, 7.0, 0.0);
    let mut ideal = LumpedPlant::new(handle, [0.0; 2], [0.0; 2], [0.0; 2]);
    ideal.advance([1.0, 2.0], [-3.0, 0.7], 0.05);
    assert_eq!(ideal.handle_force([1.0, 2.0], [-3.0, 0.7]), [-3.0, 0.7]);
    // the robot alone has m a = F_robot + F_handle − b v
    let mut heavy = LumpedPlant::new(handle, [1.2, 0.4], [2.0, 0.0], [0.0; 2]);
    let (robot, hand) = ([1.0, 2.0], [-3.0, 0.7]);
    heavy.advance(robot, hand, 0.05);
    let before = heavy.velocity();
    let force = heavy.handle_force(robot, hand);
    let short = 1e-7;
    let mut later = heavy.clone();
    later.advance(robot, hand, short);
    for axis in 0..2 {
        let acceleration = (later.velocity()[axis] - before[axis]) / short;
        // difference quotient
        close(0.8 * acceleration, robot[axis] + force[axis] - 7.0 * before[axis], 1e-5);
    }
}

proptest! {
    #[test]
    fn law_friction_and_damping_never_create_energy(
        mass in 0.1..5.0_f64,
        damping in 0.0..20.0_f64,
        coulomb in 0.0..5.0_f64,
        forces in prop::collection::vec((-10.0..10.0_f64, 1e-4..0.2_f64), 1..40),
    ) {
        let mut plant = plant(mass, damping, coulomb);
        for (force, span) in forces {
            let (x, v) = (plant.position()[0], plant.velocity()[0]);
            plant.advance([force, 0.0], [0.0; 2], span);
            let gained = 0.5 * mass * (plant.velocity()[0].powi(2) - v * v);
            let given = force * (plant.position()[0] - x);
            // rounding
            prop_assert!(gained <= given + 1e-12 * (1.0 + given.abs() + mass * v * v));
        }
    }

    #[test]
    fn law_a_span_may_be_cut_anywhere(
        coulomb in 0.0..3.0_f64,
        damping in 0.0..10.0_f64,
        first in -8.0..8.0_f64,
        second in -8.0..8.0_f64,
        cut in 0.0..1.0_f64,
    ) {
        let mut whole = plant(1.0, damping, coulomb);
        whole.advance([first, 0.0], [0.0; 2], 0.1);
        let mut parts = whole.clone();
        whole.advance([second, 0.0], [0.0; 2], 0.2);
        parts.advance([second, 0.0], [0.0; 2], 0.2 * cut);
        parts.advance([second, 0.0], [0.0; 2], 0.2 * (1.0 - cut));
        // rounding
        prop_assert!((whole.position()[0] - parts.position()[0]).abs() < 1e-13);
        prop_assert!((whole.velocity()[0] - parts.velocity()[0]).abs() < 1e-12);
    }
}

#[test]
fn ref_a_force_equal_to_the_friction_lets_the_handle_coast_to_rest() {
    // the net force is exactly 0, and e^(−bt/m) = e^(−1000) is a rounded 0: x = v m/b, v = 0
    let (mass, damping, coulomb) = (1e-4, 100.0, 3.0);
    let mut plant = plant(mass, damping, coulomb).with_velocity([0.2, -0.2]);
    plant.advance([coulomb, -coulomb], [0.0; 2], 1e-3);
    assert_eq!(plant.velocity().map(f64::abs), [0.0; 2]);
    close(plant.position()[0], 0.2 * mass / damping, 1e-13);
    close(plant.position()[1], -0.2 * mass / damping, 1e-13);
    plant.advance([0.0; 2], [0.0; 2], 1e-3);
    assert_eq!(plant.velocity().map(f64::abs), [0.0; 2]);
}
