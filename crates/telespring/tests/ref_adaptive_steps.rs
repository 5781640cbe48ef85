//! Problems with constant delays that the method of steps solves in closed form: those of DDEProblemLibrary
//! (SciML/DiffEqProblemLibrary.jl, lib/DDEProblemLibrary/src/constant_delays.jl) and the linear dyad.
//!
//! X(s) = 1/(s − a + Σ b_j e^{−sτ_j}) expands in powers of the delayed terms, which gives one term per delay passed.

mod adaptive_support;

use adaptive_support::{Case, assert_accurate, error, run};
use telespring::dde::adaptive::{DelayKind, Discontinuity};

fn factorial(n: i32) -> f64 {
    (1..=n).map(f64::from).product()
}

fn scalar<'a>(
    name: &'static str,
    end: f64,
    delays: &'a [f64],
    slope: impl Fn(f64, &[f64]) -> f64 + 'a,
    exact: impl Fn(f64) -> f64 + 'a,
) -> Case<'a> {
    Case {
        name,
        dimension: 1,
        span: (0.0, end),
        initial: Some(vec![1.0]),
        delays: Box::new(move || delays.iter().map(|&d| DelayKind::Constant(d)).collect()),
        slope: Box::new(move |_, y, delayed, out| out[0] = slope(y[0], delayed.as_slice())),
        history: Box::new(|_, out| out[0] = 0.0),
        exact: Box::new(move |t| vec![exact(t)]),
        breakpoints: vec![],
    }
}

/// y' = −y(t − 1), y = 0 before 0 and y(0) = 1: Σ (−1)^k (t − k)^k / k!.
fn one_delay(t: f64) -> f64 {
    (0..=t as i32).map(|k| (f64::from(k) - t).powi(k) / factorial(k)).sum()
}

#[test]
fn ref_ddelib_one_delay() {
    // The library's printed polynomial for 9 <= t <= 10, in exact fractions, agrees with the series.
    let z: f64 = 9.5;
    let printed = [
        23_615_939.0 / 13440.0,
        -23_602_499.0 / 13440.0,
        7_761_511.0 / 10080.0,
        -279_533.0 / 1440.0,
        89_269.0 / 2880.0,
        -1873.0 / 576.0,
        323.0 / 1440.0,
        -11.0 / 1120.0,
        1.0 / 4032.0,
        -1.0 / 362_880.0,
    ];
    let polynomial: f64 = printed.iter().rev().fold(0.0, |sum, c| sum * z + c);
    // Terms of size 1e4 cancel to 0.1 in either form.
    assert!((polynomial - one_delay(z)).abs() < 1e-10, "{polynomial} {}", one_delay(z));
    assert_accurate(&scalar("ddelib 1delay", 10.0, &[1.0], |_, z| -z[0], one_delay), 3.0);
}

/// y' = y − y(t − 1/5): Σ (−1)^k (t − k/5)^k e^{t − k/5} / k!, which settles at the residue 1/(1 − 1/5) of the
/// root s = 0; the next root, −13.6, is spent to 1e-17 at t = 3, while the series still has 13 good digits there.
#[test]
fn ref_ddelib_one_delay_long() {
    let exact = |t: f64| {
        if t > 3.0 {
            return 1.25;
        }
        (0..=(t * 5.0) as i32)
            .map(|k| {
                let rest = t - f64::from(k) / 5.0;
                (-rest).powi(k) * rest.exp() / factorial(k)
            })
            .sum()
    };
    assert_accurate(&scalar("ddelib 1delay_long", 100.0, &[0.2], |y, z| y - z[0], exact), 3.0);
}

/// y' = −y(t − 1/3) − y(t − 1/5): a term for every pair of counts of the two delays.
#[test]
fn ref_ddelib_two_delays() {
    let exact = |t: f64| {
        let mut sum = 0.0;
        for m in 0..40 {
            for n in 0..40 {
                let rest = t - f64::from(m) / 3.0 - f64::from(n) / 5.0;
                if rest >= 0.0 {
                    sum += (-rest).powi(m + n) / (factorial(m) * factorial(n));
                }
            }
        }
        sum
    };
    // The library prints 7942/3375 − 128/25 z + 17/5 z² − 2/3 z³ for 11/15 <= z < 4/5.
    let z: f64 = 0.77;
    let printed = 7942.0 / 3375.0 - 128.0 / 25.0 * z + 17.0 / 5.0 * z * z - 2.0 / 3.0 * z.powi(3);
    assert!((exact(z) - printed).abs() < 1e-14);
    assert_accurate(&scalar("ddelib 2delays", 4.0, &[1.0 / 3.0, 0.2], |_, z| -z[0] - z[1], exact), 3.0);
}

/// Tracking is what makes the polynomials exact: a polynomial of degree at most 4 between breaks is reproduced to
/// rounding at any tolerance, and the steps end on the multiples of the delay.
#[test]
fn ref_ddelib_polynomials_are_exact_at_any_tolerance() {
    let case = scalar("ddelib 1delay, loose", 4.9, &[1.0], |_, z| -z[0], one_delay);
    let solution = run(&case, 1e-2);
    assert!(error(&case, &solution) < 1e-14, "{}", error(&case, &solution));
    for order in 0..=4 {
        let expected = Discontinuity { time: f64::from(order), order };
        assert_eq!(solution.discontinuities[order as usize], expected);
        assert!(solution.knots().contains(&expected.time));
    }
}

/// Two identical robots, m = 1, b = 3, k = 2, so that P = (s + 1)(s + 2), with a unit step of force on the first:
/// X1 = (1/P + k² e^{−2sδ}/P³ + …)/s and X2 = (k e^{−sδ}/P² + …)/s (paper, Eq. 2, diagonal corrected), partial
/// fractions by hand.
#[test]
fn ref_dyad_on_the_first_delays() {
    const DELAY: f64 = 0.7;
    let first = |t: f64| 0.5 - (-t).exp() + 0.5 * (-2.0 * t).exp();
    let second = |t: f64| 0.25 + (1.0 - t) * (-t).exp() - (1.25 + 0.5 * t) * (-2.0 * t).exp();
    let third = |t: f64| {
        0.125
            + (-4.0 + 2.0 * t - 0.5 * t * t) * (-t).exp()
            + (3.875 + 1.75 * t + 0.25 * t * t) * (-2.0 * t).exp()
    };
    let from = |f: &dyn Fn(f64) -> f64, t: f64| if t > 0.0 { f(t) } else { 0.0 };
    let case = Case {
        name: "linear dyad, positions",
        dimension: 4,
        span: (0.0, 3.0 * DELAY),
        initial: None,
        delays: Box::new(|| vec![DelayKind::Constant(DELAY)]),
        slope: Box::new(|_, y, delayed, out| {
            let z = &delayed[0];
            out[0] = y[2];
            out[1] = y[3];
            out[2] = 2.0 * (z[1] - y[0]) - 3.0 * y[2] + 1.0;
            out[3] = 2.0 * (z[0] - y[1]) - 3.0 * y[3];
        }),
        history: Box::new(|_, out| out.fill(0.0)),
        exact: Box::new(move |t| {
            vec![
                first(t) + 4.0 * from(&third, t - 2.0 * DELAY),
                2.0 * from(&second, t - DELAY),
                f64::NAN,
                f64::NAN,
            ]
        }),
        breakpoints: vec![],
    };
    // f64::max passes over the NaN of the velocities, whose closed form is not needed.
    assert_accurate(&case, 3.0);
}
