//! The exact simulation against Gauss-Legendre collocation: a different method, no shared code.
//!
//! The collocation's steps divide both delays, and its stages of a delayed step are the stages of an
//! earlier step, so it interpolates nothing either; it works on each robot's own clock with both delays
//! as they are. With 10 stages (order 20) and steps of 10 ms and less its own error is rounding.

mod linear_common;

use linear_common::{Collocation, close};
use telespring::dde::linear::{
    Force, History, Hold, PiecewisePolynomial, SampledForce, Sine, Status, simulate,
};
use telespring::{Delay, DyadAxis, hman};

/// Fifty times better than what is claimed (1e-11); measured are up to 6e-14, the rounding of both methods.
const CLAIM: f64 = 2e-13;

/// One case for both methods: delays in steps, forces and pasts in both forms.
struct Case<'a> {
    axis: DyadAxis,
    stiffness: f64,
    forces: [Force; 2],
    functions: [&'a dyn Fn(f64) -> f64; 2],
    histories: [History; 2],
    past: [&'a dyn Fn(f64) -> (f64, f64); 2],
}

impl<'a> Case<'a> {
    fn new(
        axis: DyadAxis,
        stiffness: f64,
        forces: [Force; 2],
        functions: [&'a dyn Fn(f64) -> f64; 2],
    ) -> Self {
        Self {
            axis,
            stiffness,
            forces,
            functions,
            histories: Default::default(),
            past: [&|_| (0.0, 0.0), &|_| (0.0, 0.0)],
        }
    }

    fn check(&self, delays: [usize; 2], step: f64, steps: usize) {
        let delay = Delay::new(delays[0] as f64 * step, delays[1] as f64 * step).unwrap();
        let (duration, rate) = (steps as f64 * step, 1.0 / step);
        let ours =
            simulate(&self.axis, self.stiffness, &delay, &self.forces, duration, rate, &self.histories);
        let ours = ours.unwrap();
        assert_eq!(ours.status, Status::Completed);
        let reference =
            Collocation::new(&self.axis, self.stiffness, delays, step).run(self.functions, self.past, steps);
        for i in 0..2 {
            let case = format!("robot {}, delays {delays:?} of {step} s", i + 1);
            close(&ours.position[i], &reference.position[i], CLAIM, &format!("position, {case}"));
            close(&ours.velocity[i], &reference.velocity[i], CLAIM, &format!("velocity, {case}"));
        }
    }
}

fn steps(f1: f64, f2: f64) -> [Force; 2] {
    [Force::Step(f1), Force::Step(f2)]
}

#[test]
fn cross_published_case_with_opposite_steps() {
    let case = Case::new(hman().axis(0).unwrap(), 2.0 * 35.615988, steps(1.0, -1.0), [&|_| 1.0, &|_| -1.0]);
    case.check([167, 167], 1e-3, 10_000);
}

#[test]
fn cross_delays_from_short_to_long() {
    let case = Case::new(hman().axis(1).unwrap(), 60.0, steps(1.0, 0.25), [&|_| 1.0, &|_| 0.25]);
    for (delay, step) in [
        (1, 1e-2),
        (1, 1e-4),
        (1, 1e-3),
        (2, 1e-3),
        (20, 1e-3),
        (30, 1e-3),
        (37, 1e-3),
        (20, 1e-2),
        (300, 1e-2),
    ] {
        case.check([delay, delay], step, 1500);
    }
}

#[test]
fn cross_unequal_delays_operators_and_damper() {
    let axis = DyadAxis::with_operators(0.8, 5.0, 1.7, 9.0, 40.0, 12.0, 2.5).unwrap();
    let case = Case::new(axis, 90.0, steps(1.0, -0.3), [&|_| 1.0, &|_| -0.3]);
    for delays in [[120, 70], [31, 94], [50, 0], [0, 50], [1, 0], [0, 3]] {
        case.check(delays, 2e-3, 2500);
    }
    for delays in [[1, 0], [0, 3], [2, 5]] {
        case.check(delays, 1e-4, 2500);
    }
}

#[test]
fn cross_unstable_growth() {
    let axis = DyadAxis::new(1.0, 1.0, 1.0, 10.0).unwrap();
    let case = Case::new(axis, 80.0, steps(1.0, -1.0), [&|_| 1.0, &|_| -1.0]);
    case.check([40, 30], 1e-2, 1000);
}

#[test]
fn cross_sines() {
    let sine = |amplitude, angular_frequency, phase| Sine { amplitude, angular_frequency, phase };
    let forces = [
        Force::Sines { constant: 0.5, sines: vec![sine(2.0, 3.0, 0.4), sine(0.3, 41.0, -1.0)] },
        Force::Sines { constant: 0.0, sines: vec![sine(1.0, 0.7, 2.0)] },
    ];
    let f1 = |t: f64| 0.5 + 2.0 * (3.0 * t + 0.4).sin() + 0.3 * (41.0 * t - 1.0).sin();
    let f2 = |t: f64| (0.7 * t + 2.0).sin();
    let case = Case::new(hman().axis(0).unwrap(), 50.0, forces, [&f1, &f2]);
    case.check([83, 83], 1e-3, 4000);
    case.check([1, 1], 1e-4, 4000);
}

/// A signal without pattern, deterministic.
fn noise(count: usize, seed: u64) -> Vec<f64> {
    let mut state = seed;
    (0..count)
        .map(|_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        })
        .collect()
}

fn sampled(values: &[f64], rate: f64, hold: Hold) -> Force {
    Force::Sampled(SampledForce::new(values.to_vec(), rate, hold).unwrap())
}

#[test]
fn cross_sampled_signals_of_both_holds() {
    let axis = DyadAxis::with_operators(0.8334, 7.7257, 0.7776, 7.4208, 0.0, 30.0, 1.0).unwrap();
    // samples every 8 ms and delays that are no multiple of it: every sample cuts at places of its own
    let values = [noise(200, 1), noise(150, 2)];
    for hold in [Hold::Zero, Hold::Linear] {
        let signal = |i: usize, t: f64| {
            let (place, last) = (t * 125.0, values[i].len() - 1);
            let index = (place as usize).min(last);
            let next = (index + 1).min(last);
            match hold {
                Hold::Zero => values[i][index],
                Hold::Linear => {
                    values[i][index] + (values[i][next] - values[i][index]) * (place - index as f64)
                }
            }
        };
        let functions: [&dyn Fn(f64) -> f64; 2] = [&|t| signal(0, t), &|t| signal(1, t)];
        let forces = [0, 1].map(|i| sampled(&values[i], 125.0, hold));
        let case = Case::new(axis, 71.0, forces, functions);
        for delays in [[51, 77], [3, 3], [1, 2], [0, 1]] {
            case.check(delays, 1e-3, 2000);
        }
        case.check([0, 0], 1e-3, 1000);
    }
}

#[test]
fn cross_a_thousand_samples_per_second() {
    let values = [noise(2001, 5), noise(2001, 6)];
    let signal = |i: usize, t: f64| values[i][(t * 1000.0) as usize];
    let functions: [&dyn Fn(f64) -> f64; 2] = [&|t| signal(0, t), &|t| signal(1, t)];
    let forces = [0, 1].map(|i| sampled(&values[i], 1000.0, Hold::Zero));
    // a delay half a sample off the samples
    Case::new(hman().axis(0).unwrap(), 71.0, forces, functions).check([335, 335], 5e-4, 4000);
}

#[test]
fn cross_functions_and_histories() {
    let f1 = |t: f64| if t < 0.5 { (4.0 * t).sin() } else { (-t).exp() };
    let f2 = |t: f64| 1.0 / (1.0 + t * t);
    let forces = [
        Force::from_function(&mut |t| f1(t), &[0.5], 4.0).unwrap(),
        Force::from_function(&mut |t| f2(t), &[], 4.0).unwrap(),
    ];
    assert!(forces.iter().all(|force| force.error() < 1e-13));
    let past1 = |t: f64| (0.3 * (2.0 * t).cos(), -0.6 * (2.0 * t).sin());
    let past2 = |t: f64| if t < -0.05 { (0.1, 0.0) } else { (0.1 + 2.0 * (t + 0.05), 2.0) };
    let mut case = Case::new(hman().axis(0).unwrap(), 65.0, forces, [&f1, &f2]);
    case.histories = [
        History::from_function(&mut |t| past1(t).0, &[], 0.2).unwrap().with_velocity(0.0).unwrap(),
        History::polynomial(PiecewisePolynomial::new(vec![-0.05, 0.0], &[vec![0.1, 2.0]]).unwrap()).unwrap(),
    ];
    case.past = [&past1, &past2];
    case.check([100, 100], 2e-3, 2000);
    case.check([75, 100], 2e-3, 2000);
    case.check([50, 25], 1e-3, 4000);
    case.check([1, 1], 1e-3, 2000);
}

#[test]
fn cross_velocity_jump_at_the_start() {
    let axis = DyadAxis::with_operators(0.8, 5.0, 1.7, 9.0, 40.0, 0.0, 2.5).unwrap();
    let start = |t: f64| (0.2, if t < 0.0 { 0.0 } else { 1.5 });
    let mut case = Case::new(axis, 65.0, steps(0.0, 0.0), [&|_| 0.0, &|_| 0.0]);
    case.histories = [History::rest(0.2).unwrap().with_velocity(1.5).unwrap(), History::default()];
    case.past = [&start, &|_| (0.0, 0.0)];
    case.check([60, 45], 1e-3, 2000);
    case.check([1, 1], 1e-3, 2000);
}
