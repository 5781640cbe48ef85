//! Laws of the linear dyad in time.

mod linear_common;

use linear_common::close;
use proptest::prelude::*;
use telespring::dde::linear::{
    Force, History, Hold, SampledForce, Simulation, Sine, Trajectory, Workspace, output_count, simulate,
};
use telespring::{Delay, DyadAxis, hman};

/// Two runs of the same method: rounding only.
const ROUNDING: f64 = 1e-12;

fn steps(f1: f64, f2: f64) -> [Force; 2] {
    [Force::Step(f1), Force::Step(f2)]
}

fn run(
    axis: &DyadAxis,
    k: f64,
    forward: f64,
    backward: f64,
    forces: &[Force; 2],
    duration: f64,
) -> Trajectory {
    let delay = Delay::new(forward, backward).unwrap();
    simulate(axis, k, &delay, forces, duration, 250.0, &Default::default()).unwrap()
}

fn axes() -> impl Strategy<Value = DyadAxis> {
    let ground = prop_oneof![Just(0.0), 1.0..80.0];
    let damper = prop_oneof![Just(0.0), 0.1..4.0];
    (0.3..3.0, 2.0..15.0, 0.3..3.0, 2.0..15.0, ground.clone(), ground, damper).prop_map(
        |(m1, b1, m2, b2, kh1, kh2, c)| DyadAxis::with_operators(m1, b1, m2, b2, kh1, kh2, c).unwrap(),
    )
}

fn delays() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), 1e-9..1e-3, 1e-3..0.05, 0.05..0.4]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn law_superposition(axis in axes(), k in 5.0..80.0, there in delays(), back in delays()) {
        let sine = Sine { amplitude: 0.7, angular_frequency: 4.0, phase: 0.3 };
        let second = [Force::Step(0.0), Force::Sines { constant: 0.0, sines: vec![sine] }];
        let both = [Force::Step(1.0), second[1].clone()];
        let one = run(&axis, k, there, back, &steps(1.0, 0.0), 2.0);
        let two = run(&axis, k, there, back, &second, 2.0);
        let sum = run(&axis, k, there, back, &both, 2.0);
        for i in 0..2 {
            let added: Vec<f64> = one.position[i].iter().zip(&two.position[i]).map(|(a, b)| a + b).collect();
            close(&sum.position[i], &added, 1e-11, "position");
        }
    }

    #[test]
    fn law_exchange_of_partners(axis in axes(), k in 5.0..80.0, there in delays(), back in delays()) {
        let mut exchanged = axis;
        exchanged.sides.swap(0, 1);
        let a = run(&axis, k, there, back, &steps(1.0, -0.4), 2.0);
        let b = run(&exchanged, k, back, there, &steps(-0.4, 1.0), 2.0);
        for i in 0..2 {
            close(&a.position[i], &b.position[1 - i], ROUNDING, "position");
            close(&a.velocity[i], &b.velocity[1 - i], ROUNDING, "velocity");
        }
    }

    #[test]
    fn law_only_the_sum_of_delays_acts_on_the_robot_that_is_pushed(
        axis in axes(), k in 5.0..80.0, there in delays(), back in delays()
    ) {
        let a = run(&axis, k, there, back, &steps(1.0, 0.0), 2.0);
        let b = run(&axis, k, 0.5 * (there + back), 0.5 * (there + back), &steps(1.0, 0.0), 2.0);
        close(&a.position[0], &b.position[0], ROUNDING, "position");
    }

    #[test]
    fn law_time_scaling(axis in axes(), k in 5.0..80.0, delay in delays(), scale in 0.2..5.0) {
        // time in units of `scale`: masses m/a², dampings b/a
        let mut scaled = axis;
        for side in &mut scaled.sides {
            side.mass *= scale * scale;
            side.damping *= scale;
        }
        scaled.coupling_damping *= scale;
        let plain = run(&axis, k, delay, delay, &steps(1.0, -0.4), 2.0);
        let delay = Delay::each_way(delay * scale).unwrap();
        let slow = simulate(&scaled, k, &delay, &steps(1.0, -0.4), 2.0 * scale, 250.0 / scale, &Default::default()).unwrap();
        let count = plain.len().min(slow.len());
        for i in 0..2 {
            close(&plain.position[i][..count], &slow.position[i][..count], ROUNDING, "position");
        }
    }
}

#[test]
fn law_time_shift() {
    // the same push half a second later, over a delay that does not divide it
    let axis = hman().axis(0).unwrap();
    let pulse = |wait: usize| {
        let values: Vec<f64> =
            (0..400).map(|i| if (wait..wait + 30).contains(&i) { 1.0 } else { 0.0 }).collect();
        [Force::Sampled(SampledForce::new(values, 100.0, Hold::Zero).unwrap()), Force::Step(0.0)]
    };
    for delay in [0.167, 0.0731, 0.004, 1e-5] {
        let (early, late) =
            (run(&axis, 60.0, delay, delay, &pulse(0), 4.0), run(&axis, 60.0, delay, delay, &pulse(50), 4.0));
        for i in 0..2 {
            assert!(late.position[i][..=125].iter().all(|&x| x == 0.0));
            close(&late.position[i][125..], &early.position[i][..early.len() - 125], ROUNDING, "position");
        }
    }
}

#[test]
fn law_samples_are_a_sum_of_steps() {
    let axis = DyadAxis::with_operators(0.8, 5.0, 1.7, 9.0, 0.0, 12.0, 0.5).unwrap();
    let values = [1.0, 1.0, -0.5, 0.25, 2.0];
    let sampled = |values: &[f64]| {
        [Force::Sampled(SampledForce::new(values.to_vec(), 7.0, Hold::Zero).unwrap()), Force::Step(0.0)]
    };
    for delay in [0.2, 0.013, 1e-4] {
        let whole = run(&axis, 60.0, delay, delay, &sampled(&values), 3.0);
        let mut sum = [vec![0.0; whole.len()], vec![0.0; whole.len()]];
        for n in 0..values.len() {
            let rise = values[n] - if n == 0 { 0.0 } else { values[n - 1] };
            let step: Vec<f64> = (0..values.len()).map(|i| if i >= n { rise } else { 0.0 }).collect();
            let part = run(&axis, 60.0, delay, delay, &sampled(&step), 3.0);
            for (sum, part) in sum.iter_mut().zip(&part.position) {
                sum.iter_mut().zip(part).for_each(|(s, x)| *s += x);
            }
        }
        for (whole, sum) in whole.position.iter().zip(&sum) {
            close(whole, sum, ROUNDING, "position");
        }
    }
}

#[test]
fn law_short_delays_join_without_a_jump() {
    // x(δ) is smooth in δ: second differences over equal steps of δ vanish as their square, across the
    // change of method (0.35 over the fastest rate, 0.03776 s here) and down to none
    let axis = hman().axis(0).unwrap();
    let end = |delay: f64| run(&axis, 60.0, delay, delay, &steps(1.0, -1.0), 1.0).position[0][250];
    for middle in [0.03776, 0.01, 1e-4, 1e-6] {
        let h = 1e-3 * middle;
        let bend = end(middle + h) - 2.0 * end(middle) + end(middle - h);
        assert!(bend.abs() < 20.0 * h * h + 1e-15, "{middle}: {bend}");
    }
    let gap = (end(1e-9) - end(0.0)).abs();
    assert!(gap > 0.0 && gap < 1e-9, "{gap}");
}

#[test]
fn law_late_decay_is_the_rightmost_root() {
    let axis = DyadAxis::with_operators(1.0, 4.0, 1.0, 4.0, 2.0, 2.0, 0.0).unwrap();
    let (k, delay) = (10.0, 0.8);
    let result = run(&axis, k, delay, delay, &steps(1.0, 1.0), 60.0);
    // equal robots pushed alike: x'' + 4 x' + 12 x = 10 x(t − 0.8) + 1, one real or complex pair dominates
    let rest = 1.0 / 2.0;
    let gap: Vec<f64> = result.position[0].iter().map(|x| x - rest).collect();
    let peak = |from: usize, to: usize| gap[from..to].iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let rate = (peak(12_500, 15_000) / peak(7_500, 10_000)).ln() / 20.0;
    let mut s = rate;
    for _ in 0..50 {
        let e = (-s * delay).exp();
        s -= (s * s + 4.0 * s + 12.0 - k * e) / (2.0 * s + 4.0 + k * delay * e);
    }
    assert!((s - rate).abs() < 1e-9, "{s} {rate}");
}

#[test]
fn law_energy_balance_without_delay() {
    // the work of both forces is stored or lost in the dampers
    let axis = DyadAxis::with_operators(0.9, 3.0, 1.4, 5.0, 20.0, 0.0, 1.2).unwrap();
    let (k, rate, f) = (90.0, 4000.0, [1.0, -0.5]);
    let delay = Delay::each_way(0.0).unwrap();
    let r = simulate(&axis, k, &delay, &steps(f[0], f[1]), 2.0, rate, &Default::default()).unwrap();
    let power = |n: usize| {
        let v = [r.velocity[0][n], r.velocity[1][n]];
        axis.sides[0].damping * v[0] * v[0]
            + axis.sides[1].damping * v[1] * v[1]
            + 1.2 * (v[0] - v[1]).powi(2)
    };
    // Simpson's rule at 0.25 ms: error about 1e-13 here
    let last = r.len() - 1;
    let inner: f64 = (1..last).map(|n| if n % 2 == 1 { 4.0 } else { 2.0 } * power(n)).sum();
    let lost = (power(0) + inner + power(last)) / (3.0 * rate);
    let (x, v) = ([r.position[0][last], r.position[1][last]], [r.velocity[0][last], r.velocity[1][last]]);
    let stored: f64 = (0..2)
        .map(|i| 0.5 * axis.sides[i].mass * v[i] * v[i] + 0.5 * axis.sides[i].ground_stiffness * x[i] * x[i])
        .sum::<f64>()
        + 0.5 * k * (x[0] - x[1]).powi(2);
    let work = f[0] * x[0] + f[1] * x[1];
    assert!((work - lost - stored).abs() < 1e-11 * work.abs(), "{work} {lost} {stored}");
}

#[test]
fn law_arrays_and_workspace_change_nothing() {
    let axis = hman().axis(0).unwrap();
    let delay = Delay::new(0.1, 0.15).unwrap();
    let (forces, histories) = (steps(1.0, -1.0), [History::rest(0.01).unwrap(), History::default()]);
    let s = Simulation {
        axis: &axis,
        stiffness: 71.0,
        delay: &delay,
        forces: &forces,
        histories: &histories,
        duration: 3.0,
        rate: 777.0,
    };
    let mut workspace = Workspace::default();
    let once = s.run(&mut workspace).unwrap();
    let count = output_count(3.0, 777.0).unwrap();
    let (mut a, mut b) = (vec![0.0; count], vec![0.0; count]);
    let ending = s.run_into([&mut a, &mut b], None, &mut workspace).unwrap();
    assert_eq!((ending.outputs, &a, &b), (count, &once.position[0], &once.position[1]));
    assert!(s.run_into([&mut a[1..], &mut b], None, &mut workspace).is_err());
}
