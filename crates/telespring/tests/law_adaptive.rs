//! Laws of the adaptive delay solver: order, proportionality to the tolerance, invariance, breaks landed on,
//! delays that vanish or jump, right-hand sides that switch.

mod adaptive_support;

use std::convert::Infallible;
use std::f64::consts::PI;

use adaptive_support::{Case, assert_accurate, error, run};
use proptest::prelude::*;
use telespring::dde::adaptive::{DelayKind, Discontinuity, Options, Solution, Status, solve};

/// Solves a scalar problem whose callbacks cannot fail.
fn scalar(
    slope: impl Fn(f64, f64, &[f64]) -> f64,
    delays: Vec<DelayKind<'_, Infallible>>,
    history: impl Fn(f64) -> f64,
    initial: Option<f64>,
    span: (f64, f64),
    options: &Options,
) -> Solution<Infallible> {
    solve(
        |t, y, delayed, out| {
            out[0] = slope(t, y[0], delayed.as_slice());
            Ok(())
        },
        delays,
        |t, out| {
            out[0] = history(t);
            Ok(())
        },
        1,
        initial.as_ref().map(std::slice::from_ref),
        span,
        options,
    )
    .expect("the problem is well posed")
}

fn at(solution: &Solution<Infallible>, t: f64) -> f64 {
    let mut y = [0.0];
    solution.evaluate(t, &mut y).expect("inside the solution");
    y[0]
}

fn tight() -> Options {
    Options { rtol: 1e-10.into(), atol: 1e-12.into(), ..Options::default() }
}

/// y' = −y(t − π/2), y = sin t, at fixed steps that divide the delay: the error falls with the fifth power, the
/// dense output's too, since the history is smooth.
#[test]
fn law_order_is_five() {
    let error_at = |steps: f64| {
        let step = PI / 2.0 / steps;
        let options = Options {
            rtol: 1e3.into(),
            atol: 1e3.into(),
            initial_step: Some(step),
            max_step: Some(step),
            ..Options::default()
        };
        let delays = vec![DelayKind::Constant(PI / 2.0)];
        let solution = scalar(|_, _, z| -z[0], delays, f64::sin, None, (0.0, 4.0 * PI), &options);
        assert_eq!(solution.steps, (8.0 * steps) as usize);
        (0..=200)
            .map(|i| 4.0 * PI * f64::from(i) / 200.0)
            .fold(0.0, |worst, t| f64::max(worst, (at(&solution, t.min(solution.end())) - t.sin()).abs()))
    };
    let errors: Vec<f64> = [8.0, 16.0, 32.0].map(error_at).to_vec();
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        // The next term of the error expansion moves the measured order by a few hundredths at these steps.
        assert!((order - 5.0).abs() < 0.2, "order {order} from {errors:?}");
    }
}

/// A regression of log error on log tolerance has slope one.
#[test]
fn law_error_falls_with_the_tolerance() {
    let case = Case {
        name: "sine",
        dimension: 1,
        span: (0.0, 10.0),
        initial: None,
        delays: Box::new(|| vec![DelayKind::Constant(PI / 2.0)]),
        slope: Box::new(|_, _, delayed, out| out[0] = -delayed[0][0]),
        history: Box::new(|t, out| out[0] = t.sin()),
        exact: Box::new(|t| vec![t.sin()]),
        breakpoints: vec![],
    };
    let points: Vec<(f64, f64)> = (8..=22)
        .map(|i| 10f64.powf(-0.5 * f64::from(i)))
        .map(|rtol| (rtol.ln(), error(&case, &run(&case, rtol)).ln()))
        .collect();
    let count = points.len() as f64;
    let (mean_x, mean_y) =
        (points.iter().map(|p| p.0).sum::<f64>() / count, points.iter().map(|p| p.1).sum::<f64>() / count);
    let slope = points.iter().map(|p| (p.0 - mean_x) * (p.1 - mean_y)).sum::<f64>()
        / points.iter().map(|p| (p.0 - mean_x).powi(2)).sum::<f64>();
    assert!((slope - 1.0).abs() < 0.1, "slope {slope}");
}

/// With a delay of zero, and with no delay, the equation is an ODE.
#[test]
fn law_zero_delay_is_the_ode() {
    let zero =
        scalar(|t, _, z| t.cos() - z[0], vec![DelayKind::Constant(0.0)], |_| 2.0, None, (0.0, 6.0), &tight());
    let none = scalar(|t, y, _| t.cos() - y, vec![], |_| 2.0, None, (0.0, 6.0), &tight());
    for i in 0..=60 {
        let t = 0.1 * f64::from(i);
        let exact = 1.5 * (-t).exp() + 0.5 * (t.sin() + t.cos());
        assert!((at(&zero, t.min(6.0)) - exact).abs() < 1e-9, "t = {t}");
        assert_eq!(at(&zero, t.min(6.0)), at(&none, t.min(6.0)));
    }
}

/// A delay far shorter than the steps: y' = −y(t − τ) follows e^{λt} with λ = −e^{−λτ}.
#[test]
fn law_steps_longer_than_the_delay() {
    let delay = 1e-4;
    let mut rate = -1.0f64;
    for _ in 0..50 {
        rate = -(-rate * delay).exp();
    }
    let exact = |t: f64| (rate * t).exp();
    let solution =
        scalar(|_, _, z| -z[0], vec![DelayKind::Constant(delay)], exact, None, (0.0, 5.0), &tight());
    assert_eq!(solution.status, Status::Completed);
    assert!(solution.steps < 200, "{} steps", solution.steps);
    assert!((at(&solution, 5.0) - exact(5.0)).abs() < 1e-10);
}

/// A hold: τ(t) = t − ⌊t/T⌋T jumps at the sampling times. y' = −y(⌊t/T⌋T) is linear between them, so
/// y((k + 1)T) = (1 − T) y(kT) exactly; it does not matter which side the delay's callback gives at a jump.
#[test]
fn law_delay_that_jumps_at_declared_times() {
    const PERIOD: f64 = 0.1;
    for later in [true, false] {
        let hold = move |t: f64| {
            let periods = t / PERIOD;
            t - PERIOD * if later { periods.floor() } else { (periods.ceil() - 1.0).max(0.0) }
        };
        let options = Options {
            breakpoints: (1..100).map(|k| Discontinuity::kink(f64::from(k) * PERIOD)).collect(),
            ..tight()
        };
        let solution =
            scalar(|_, _, z| -z[0], vec![DelayKind::time(hold)], |_| 1.0, None, (0.0, 10.0), &options);
        for k in 0..100 {
            let knot = f64::from(k) * PERIOD;
            assert!(solution.knots().contains(&knot), "no step ends at {knot}");
            let exact = (1.0 - PERIOD).powi(k);
            assert!((at(&solution, knot) - exact).abs() < 1e-12, "k = {k}: {}", at(&solution, knot) - exact);
        }
    }
}

/// A solution made to order, y = sin t, through a delay that swings between 0 and 0.6 and vanishes every 2π/5; the
/// history is the solution too, so that nothing breaks.
#[test]
fn law_delay_that_vanishes_again_and_again() {
    let delay = |t: f64| 0.3 * (1.0 + (5.0 * t).sin());
    let case = Case {
        name: "swinging delay",
        dimension: 1,
        span: (0.0, 10.0),
        initial: None,
        delays: Box::new(move || vec![DelayKind::time(delay)]),
        slope: Box::new(move |t, _, delayed, out| out[0] = t.cos() + (t - delay(t)).sin() - delayed[0][0]),
        history: Box::new(|t, out| out[0] = t.sin()),
        exact: Box::new(|t| vec![t.sin()]),
        breakpoints: vec![],
    };
    assert_accurate(&case, 10.0);
}

/// A constant delay given as a number, as a function of time and as a function of the state is the same delay, the
/// jump at the start included.
#[test]
fn law_three_ways_to_give_one_delay() {
    let solve_with =
        |delay| scalar(|_, y, z| -z[0] - 0.2 * y, vec![delay], |_| 0.0, Some(1.0), (0.0, 5.0), &tight());
    let number = solve_with(DelayKind::Constant(0.6));
    for other in [solve_with(DelayKind::time(|_| 0.6)), solve_with(DelayKind::state(|_, _| 0.6))] {
        assert_eq!(other.discontinuities.len(), number.discontinuities.len());
        for (a, b) in other.discontinuities.iter().zip(&number.discontinuities) {
            assert!((a.time - b.time).abs() < 1e-12 && a.order == b.order, "{a:?} {b:?}");
        }
        for i in 0..=50 {
            let t = 0.1 * f64::from(i);
            // Both are within a few tolerances of the truth.
            assert!((at(&other, t.min(5.0)) - at(&number, t.min(5.0))).abs() < 1e-9, "t = {t}");
        }
    }
}

/// Ten thousand declared breaks, each sent on through the delay: a delay measured a thousand times a second. Held
/// between the samples, the argument is t − τ_k, and y' = 1 − y(t − τ) from rest keeps y = t on the first delay.
#[test]
fn law_many_declared_breaks() {
    let sample = |t: f64| (t * 1000.0 + 0.5 * f64::EPSILON).floor();
    let delay = move |t: f64| 0.2 + 0.0005 * (0.7 * sample(t)).sin();
    let options = Options {
        rtol: 1e-6.into(),
        breakpoints: (1..10_000).map(|k| Discontinuity::kink(f64::from(k) / 1000.0)).collect(),
        max_steps: 400_000,
        ..Options::default()
    };
    let solution =
        scalar(|_, _, z| 1.0 - z[0], vec![DelayKind::time(delay)], |_| 0.0, None, (0.0, 10.0), &options);
    assert_eq!(solution.status, Status::Completed);
    assert!((at(&solution, 0.19) - 0.19).abs() < 1e-12);
    // A constant delay of 0.2 would settle at 1 as e^{−1.3 t}; the swing of 0.0005 moves it by less than that.
    assert!((at(&solution, 10.0) - 1.0).abs() < 1e-3, "{}", at(&solution, 10.0));
}

/// A force switched at declared times, whichever side its callback assigns them to.
#[test]
fn law_declared_force_switches() {
    for inclusive in [true, false] {
        let force = move |t: f64| if t > 0.3 || (inclusive && t == 0.3) { 1.0 } else { 0.0 };
        let options = Options { breakpoints: vec![Discontinuity::kink(0.3)], ..tight() };
        // The delay brings the kink at 0.3 back at 0.8, one order smoother.
        let solution = scalar(
            |t, _, z| force(t) - z[0],
            vec![DelayKind::Constant(0.5)],
            |_| 0.0,
            None,
            (0.0, 1.3),
            &options,
        );
        for t in [0.1, 0.3, 0.5, 0.8, 1.0, 1.3] {
            let exact = f64::max(t - 0.3, 0.0) - 0.5 * f64::max(t - 0.8, 0.0).powi(2);
            assert!((at(&solution, t) - exact).abs() < 1e-14, "t = {t}");
        }
        assert!(solution.knots().contains(&0.3) && solution.knots().contains(&0.8));
    }
}

/// Breaks through a varying delay are landed on to rounding: with τ(t) = 1 + t/2 the roots of t − τ(t) = ξ are
/// t = 2(ξ + 1), so 0 → 2 → 6 → 14, one order smoother each time.
#[test]
fn law_breaks_through_a_varying_delay() {
    let solution = scalar(
        |_, _, z| -z[0],
        vec![DelayKind::time(|t| 1.0 + 0.5 * t)],
        |_| 1.0,
        Some(2.0),
        (0.0, 15.0),
        &tight(),
    );
    let expected = [(0.0, 0), (2.0, 1), (6.0, 2), (14.0, 3)];
    let found: Vec<_> = solution.discontinuities.iter().map(|d| (d.time, d.order)).collect();
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (got, want) in found.iter().zip(expected) {
        assert!((got.0 - want.0).abs() <= 4.0 * f64::EPSILON * want.0 && got.1 == want.1, "{found:?}");
    }
    // On [0, 2] the history gives y = 2 − t, so on [2, 6] y' = −(2 − (t/2 − 1)) and y(6) = −4.
    assert!((at(&solution, 6.0) + 4.0).abs() < 1e-12);
}

/// Saturation sat(y(t − 1)) from y = 3/2: closed form piece by piece; the kinks at 3/2 and 5/2 come from the state,
/// not from the delay.
#[test]
fn law_saturation() {
    let case = Case {
        name: "saturation",
        dimension: 1,
        span: (0.0, 3.5),
        initial: None,
        delays: Box::new(|| vec![DelayKind::Constant(1.0)]),
        slope: Box::new(|_, _, delayed, out| out[0] = -delayed[0][0].clamp(-1.0, 1.0)),
        history: Box::new(|_, out| out[0] = 1.5),
        exact: Box::new(|t: f64| {
            vec![if t < 1.5 {
                1.5 - t
            } else if t < 2.5 {
                0.5 * ((2.5 - t).powi(2) - 1.0)
            } else {
                -0.5 + ((3.5 - t).powi(3) - 1.0) / 6.0 + 0.5 * (t - 2.5)
            }]
        }),
        breakpoints: vec![],
    };
    assert_accurate(&case, 30.0);
}

/// Coulomb friction: x'' + x = −μ sign(x'), x(0) = 1, μ = 0.1: half cycles of cosine about ±μ, each turning point
/// 2μ nearer, until it sticks after t = 5π; solved up to the fourth turn.
#[test]
fn law_coulomb_friction_slides() {
    let case = Case {
        name: "Coulomb friction",
        dimension: 2,
        span: (0.0, 4.0 * PI),
        initial: None,
        delays: Box::new(Vec::new),
        slope: Box::new(|_, y, _, out| {
            out[0] = y[1];
            out[1] = -y[0] - if y[1] > 0.0 { 0.1 } else { -0.1 };
        }),
        history: Box::new(|_, out| out.copy_from_slice(&[1.0, 0.0])),
        exact: Box::new(|t: f64| {
            let half = (t / PI).floor().min(3.0);
            let side = if half % 2.0 == 0.0 { 1.0 } else { -1.0 };
            let amplitude = 0.9 - 0.2 * half;
            vec![amplitude * t.cos() + 0.1 * side, -amplitude * t.sin()]
        }),
        breakpoints: vec![],
    };
    assert_accurate(&case, 100.0);
}

/// The derivative belongs to the value: it meets the equation at the knots and the difference quotient between.
#[test]
fn law_derivative_of_the_dense_output() {
    let delays = vec![DelayKind::Constant(1.0)];
    let solution = scalar(|_, _, z| -z[0], delays, f64::cos, None, (0.0, 5.0), &tight());
    let mut slope = [0.0];
    for i in 0..100 {
        let t = 1.01 + 0.039 * f64::from(i);
        solution.derivative(t, &mut slope).expect("inside");
        let quotient = (at(&solution, t + 1e-6) - at(&solution, t - 1e-6)) / 2e-6;
        // The quotient's own rounding is 1e-10.
        assert!((slope[0] - quotient).abs() < 1e-8, "t = {t}");
        assert!((slope[0] + at(&solution, t - 1.0)).abs() < 1e-7, "t = {t}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    /// Moving a problem in time moves its solution, breaks included.
    #[test]
    fn law_time_shift(shift in -50.0..50.0f64, delay in 0.05..2.0f64, gain in 0.1..1.5f64, kink in 0.1..4.0f64) {
        let solve_at = |origin: f64| scalar(
            |t, y, z| -gain * z[0] - 0.3 * y.powi(3) + if t - origin > kink { 1.0 } else { 0.0 },
            vec![DelayKind::Constant(delay), DelayKind::time(move |t| 0.4 + 0.3 * (t - origin).sin())],
            |t| (t - origin).cos(),
            Some(0.5),
            (origin, origin + 5.0),
            &Options { breakpoints: vec![Discontinuity::kink(origin + kink)], ..tight() },
        );
        let (here, there) = (solve_at(0.0), solve_at(shift));
        prop_assert_eq!(here.status, Status::Completed);
        for i in 1..50 {
            let t = 0.1 * f64::from(i);
            // Both are within a few tolerances of the truth; the shift itself rounds times to 1e-14.
            prop_assert!((at(&here, t) - at(&there, t + shift)).abs() < 1e-8);
        }
    }

    /// Scaling a linear problem in value scales its solution; scaling time and delays together stretches it.
    #[test]
    fn law_time_scale(stretch in 0.01..100.0f64, delay in 0.1..1.5f64) {
        let solve_at = |stretch: f64| scalar(
            move |_, _, z| -z[0] / stretch,
            vec![DelayKind::Constant(delay * stretch)],
            |_| 1.0,
            None,
            (0.0, 6.0 * stretch),
            &tight(),
        );
        let (unit, scaled) = (solve_at(1.0), solve_at(stretch));
        for i in 0..60 {
            let t = 0.1 * f64::from(i);
            prop_assert!((at(&unit, t) - at(&scaled, t * stretch)).abs() < 1e-8);
        }
    }
}
