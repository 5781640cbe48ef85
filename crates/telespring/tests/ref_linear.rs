//! The exact simulation against closed forms.

mod linear_common;

use linear_common::close;
use nalgebra::{Matrix5, Vector5};
use num_complex::Complex64;
use telespring::dde::linear::{Force, History, Sine, Status, simulate};
use telespring::{Delay, DyadAxis, hman};

/// The rounding of both sides: a few hundred units in the last place.
const ROUNDING: f64 = 2e-13;

fn steps(f1: f64, f2: f64) -> [Force; 2] {
    [Force::Step(f1), Force::Step(f2)]
}

/// x and x' of m x'' + b x' + s x = f from rest at 0, with s > b²/(4m) (any textbook on vibration).
fn step_response(m: f64, b: f64, s: f64, f: f64, t: f64) -> (f64, f64) {
    let decay = b / (2.0 * m);
    let omega = (s / m - decay * decay).sqrt();
    let (sin, cos) = (omega * t).sin_cos();
    let e = (-decay * t).exp();
    (f / s * (1.0 - e * (cos + decay / omega * sin)), f / (m * omega) * e * sin)
}

#[test]
fn ref_uncoupled_masses_with_dampers() {
    // m x'' + b x' = f from rest: x = f/b (t − m/b (1 − e^(−b t/m)))
    let axis = hman().axis(0).unwrap();
    for delay in [0.0, 1e-9, 0.05, 0.4] {
        let delay = Delay::each_way(delay).unwrap();
        let result =
            simulate(&axis, 0.0, &delay, &steps(2.0, -1.0), 5.0, 500.0, &Default::default()).unwrap();
        for (i, f) in [2.0, -1.0].into_iter().enumerate() {
            let (m, b) = (axis.sides[i].mass, axis.sides[i].damping);
            let time = (0..=2500).map(|n| n as f64 / 500.0);
            let x: Vec<f64> = time.clone().map(|t| f / b * (t + m / b * (-b * t / m).exp_m1())).collect();
            let v: Vec<f64> = time.map(|t| -f / b * (-b * t / m).exp_m1()).collect();
            close(&result.position[i], &x, ROUNDING, "position");
            close(&result.velocity[i], &v, ROUNDING, "velocity");
        }
    }
}

#[test]
fn ref_zero_delay_is_the_matrix_exponential() {
    let (m1, b1, m2, b2, kh1, kh2, c, k) = (0.8, 4.0, 1.5, 6.0, 20.0, 0.0, 1.5, 80.0);
    let axis = DyadAxis::with_operators(m1, b1, m2, b2, kh1, kh2, c).unwrap();
    let (f1, f2) = (1.0, -0.7);
    #[rustfmt::skip]
    let matrix = Matrix5::new(
        0.0, 1.0, 0.0, 0.0, 0.0,
        -(k + kh1) / m1, -(b1 + c) / m1, k / m1, c / m1, f1 / m1,
        0.0, 0.0, 0.0, 1.0, 0.0,
        k / m2, c / m2, -(k + kh2) / m2, -(b2 + c) / m2, f2 / m2,
        0.0, 0.0, 0.0, 0.0, 0.0,
    );
    let histories = [History::rest(0.1).unwrap(), History::default().with_velocity(0.5).unwrap()];
    let delay = Delay::each_way(0.0).unwrap();
    let result = simulate(&axis, k, &delay, &steps(f1, f2), 4.0, 20.0, &histories).unwrap();
    let start = Vector5::new(0.1, 0.0, 0.0, 0.5, 1.0);
    let states: Vec<_> = (0..=80).map(|n| (matrix * (n as f64 / 20.0)).exp() * start).collect();
    for i in 0..2 {
        let x: Vec<f64> = states.iter().map(|s| s[2 * i]).collect();
        let v: Vec<f64> = states.iter().map(|s| s[2 * i + 1]).collect();
        // the exponential's scaling and squaring loses two digits
        close(&result.position[i], &x, 1e-12, "position");
        close(&result.velocity[i], &v, 1e-12, "velocity");
    }
}

#[test]
fn ref_first_delay_is_a_plain_mass_damper_spring() {
    // until the partner's motion arrives each robot hangs on a spring to the partner's resting place
    let axis = DyadAxis::new(0.8334, 3.0, 0.7776, 2.0).unwrap();
    let k = 71.0;
    for (forward, backward) in [(0.31, 0.31), (0.4, 0.2), (0.2, 0.4), (100.0, 100.0)] {
        let delay = Delay::new(forward, backward).unwrap();
        let result = simulate(&axis, k, &delay, &steps(1.0, 0.5), 0.2, 5000.0, &Default::default()).unwrap();
        for (i, f) in [1.0, 0.5].into_iter().enumerate() {
            let (m, b) = (axis.sides[i].mass, axis.sides[i].damping);
            let exact = |n: usize| step_response(m, b, k, f, n as f64 / 5000.0);
            close(
                &result.position[i],
                &(0..=1000).map(|n| exact(n).0).collect::<Vec<_>>(),
                ROUNDING,
                "position",
            );
            close(
                &result.velocity[i],
                &(0..=1000).map(|n| exact(n).1).collect::<Vec<_>>(),
                ROUNDING,
                "velocity",
            );
        }
    }
}

#[test]
fn ref_steady_state_is_the_transfer_function() {
    // X1/F1 = P2/χ and X2/F1 = (k + c s) e^(−forward s)/χ (Eq. 2, its diagonal corrected)
    let (kh1, kh2, c, k, omega) = (15.0, 8.0, 0.8, 60.0, 5.3);
    let axis = DyadAxis::with_operators(0.8334, 7.7257, 0.7776, 7.4208, kh1, kh2, c).unwrap();
    for (forward, backward) in [(0.03, 0.05), (0.0, 0.0), (1e-4, 3e-4), (0.11, 0.02)] {
        let delay = Delay::new(forward, backward).unwrap();
        let sine = Sine { amplitude: 1.0, angular_frequency: omega, phase: 0.0 };
        let forces = [Force::Sines { constant: 0.0, sines: vec![sine] }, Force::Step(0.0)];
        let result = simulate(&axis, k, &delay, &forces, 60.0, 100.0, &Default::default()).unwrap();
        let s = Complex64::new(0.0, omega);
        let p = [0, 1].map(|i| {
            let side = axis.sides[i];
            s * s * side.mass + s * (side.damping + c) + k + side.ground_stiffness
        });
        let link = s * c + k;
        let chi = p[0] * p[1] - link * link * (-s * (forward + backward)).exp();
        let response = [p[1] / chi, link * (-s * forward).exp() / chi];
        for (i, response) in response.into_iter().enumerate() {
            let time = (5900..=6000).map(|n| n as f64 / 100.0);
            let exact: Vec<f64> = time.map(|t| (response * (s * t).exp()).im).collect();
            close(&result.position[i][5900..], &exact, 1e-12, "position");
        }
    }
}

#[test]
fn ref_divergence_is_a_status_with_its_time() {
    // m=1,1 b=1,10: unstable at 24.9975 N/m from a one-way delay of 0.1718 s on; here far beyond
    let axis = DyadAxis::new(1.0, 1.0, 1.0, 10.0).unwrap();
    let delay = Delay::each_way(0.5).unwrap();
    let result =
        simulate(&axis, 200.0, &delay, &steps(1.0, -1.0), 1000.0, 100.0, &Default::default()).unwrap();
    let Status::Diverged { at } = result.status else { panic!("{:?}", result.status) };
    assert!(at > 1.0 && at < 1000.0);
    for values in result.position.iter().chain(&result.velocity) {
        assert_eq!(values.len(), result.len());
        assert!(values.iter().all(|x| x.is_finite()));
    }
    assert!(result.time(result.len()) >= at && result.time(result.len() - 1) < at);
    assert!(result.position[0].last().unwrap().abs() > 1e10);
}

#[test]
fn ref_stiff_corner() {
    // damping/mass = 1e6 1/s: the closed form of the uncoupled side, and a partner that hardly feels it
    let axis = DyadAxis::new(1e-3, 1e3, 1.0, 5.0).unwrap();
    let delay = Delay::each_way(1e-3).unwrap();
    let result = simulate(&axis, 0.0, &delay, &steps(2.0, 1.0), 0.02, 1e4, &Default::default()).unwrap();
    let exact: Vec<f64> =
        (0..=200).map(|n| 2e-3 * (f64::from(n) * 1e-4 + 1e-6 * (-100.0 * f64::from(n)).exp_m1())).collect();
    close(&result.position[0], &exact, 1e-11, "position");
}

#[test]
fn ref_bad_input_names_the_field() {
    let axis = hman().axis(0).unwrap();
    let delay = Delay::each_way(0.1).unwrap();
    let refused = |k: f64, f: f64, duration: f64, rate: f64| {
        simulate(&axis, k, &delay, &steps(f, 0.0), duration, rate, &Default::default()).unwrap_err().field
    };
    assert_eq!(refused(-1.0, 1.0, 1.0, 100.0), "stiffness");
    assert_eq!(refused(1.0, f64::NAN, 1.0, 100.0), "forces[0]");
    assert_eq!(refused(1.0, 1.0, -1.0, 100.0), "duration");
    assert_eq!(refused(1.0, 1.0, 1.0, 0.0), "rate");
    assert_eq!(refused(1.0, 1.0, 1e6, 1e9), "rate");
    let mut broken = axis;
    broken.sides[1].mass = 0.0;
    let refused =
        simulate(&broken, 1.0, &delay, &steps(0.0, 0.0), 1.0, 1.0, &Default::default()).unwrap_err();
    assert_eq!(refused.field, "axis.sides[1].mass");
    assert!(History::rest(f64::INFINITY).is_err());
    assert!(Force::from_function(&mut |t| 1.0 / (t - t), &[], 1.0).is_err());
}
