//! Characteristic roots against published values and closed forms.

use nalgebra::{DMatrix, dmatrix};
use num_complex::Complex64;
use telespring::delay_system::DelaySystem;
use telespring::spectrum::{characteristic_roots, spectral_abscissa};
use telespring::{Delay, DyadAxis, hman};

/// The delay in `bracket` at which a function of the delay changes sign.
fn crossing(bracket: (f64, f64), f: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = bracket;
    let start = f(low);
    assert!(start * f(high) < 0.0, "no sign change between {low} and {high}");
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if f(middle) * start > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

fn abscissa(a0: &DMatrix<f64>, a1: &DMatrix<f64>, delay: f64) -> f64 {
    let abscissa = DelaySystem::new(a0.clone(), vec![(delay, a1.clone())]).unwrap().spectral_abscissa();
    assert!(abscissa.certificate.is_complete(), "delay {delay}: {}", abscissa.certificate);
    abscissa.value
}

/// W₀(z) by Halley's iteration from `w`.
fn lambert(z: f64, mut w: Complex64) -> Complex64 {
    for _ in 0..60 {
        let e = w.exp();
        let f = w * e - z;
        w -= f / (e * (w + 1.0) - (w + 2.0) * f / (w * 2.0 + 2.0));
    }
    w
}

/// x′ = −x(t − τ): the rightmost roots are W(−τ)/τ, W the principal branch of Lambert's function
/// (Corless, Gonnet, Hare, Jeffrey and Knuth 1996, doi:10.1007/BF02124750, section 2).
#[test]
fn ref_scalar_roots_are_lamberts_function() {
    // W₀(−1) as printed there: −0.3181315052 + 1.3372357014 j
    let printed = Complex64::new(-0.3181315052047641, 1.3372357014306894);
    for delay in [0.1, 0.3, 0.5, 1.0, 1.5, 2.0, 5.0, 20.0] {
        let system = DelaySystem::new(dmatrix![0.0], vec![(delay, dmatrix![-1.0])]).unwrap();
        let spectrum = system.characteristic_roots(4).unwrap();
        assert!(spectrum.certificate.is_complete(), "delay {delay}: {}", spectrum.certificate);
        let start = if delay < 0.36 { Complex64::new(-delay, 0.0) } else { Complex64::new(-0.3, 1.3) };
        let w = lambert(-delay, start);
        // A root of W e^W is as well conditioned as 1/(1 + W) is small: 1e-13 is a few roundings.
        assert!((spectrum.roots[0] - w / delay).norm() < 1e-13 * (w / delay).norm(), "delay {delay}");
        if delay == 1.0 {
            assert!((w - printed).norm() < 1e-15);
        }
    }
}

/// Past e⁻¹ both real roots have met: at the delay 1/e the double root is −e.
#[test]
fn ref_scalar_double_root_counts_twice() {
    let delay = (-1.0_f64).exp();
    let system = DelaySystem::new(dmatrix![0.0], vec![(delay, dmatrix![-1.0])]).unwrap();
    let spectrum = system.characteristic_roots(4).unwrap();
    assert!(spectrum.certificate.is_complete(), "{}", spectrum.certificate);
    for root in &spectrum.roots[..2] {
        // Half of the digits are all that rounding leaves of a double root.
        assert!((root + 1.0_f64.exp()).norm() < 1e-6, "{root}");
    }
}

/// The published stability limits of three systems, with the digits recomputed to 1e-12 (Chebyshev
/// collocation and crossing frequencies from a matrix pencil).
#[test]
fn ref_published_limits_are_reached() {
    struct Published {
        name: &'static str,
        a0: DMatrix<f64>,
        a1: DMatrix<f64>,
        /// Where the abscissa crosses zero: a bracket and the delay.
        limits: Vec<((f64, f64), f64)>,
    }
    let systems = [
        Published {
            name: "scalar, tau < pi/2",
            a0: dmatrix![0.0],
            a1: dmatrix![-1.0],
            limits: vec![((1.0, 2.0), std::f64::consts::FRAC_PI_2)],
        },
        Published {
            name: "Gu, Kharitonov, Chen 2003 (Stability of Time-Delay Systems), p. 192, tau < 6.17258",
            a0: dmatrix![-2.0, 0.0; 0.0, -0.9],
            a1: dmatrix![-1.0, 0.0; -1.0, -1.0],
            limits: vec![((5.0, 7.0), 6.172581371221)],
        },
        Published {
            name: "Gu, Kharitonov, Chen 2003, p. 193, 0.100174 < tau < 1.71785",
            a0: dmatrix![0.0, 1.0; -2.0, 0.1],
            a1: dmatrix![0.0, 0.0; 1.0, 0.0],
            limits: vec![((0.05, 0.5), 0.100168268452), ((1.0, 2.0), 1.717858178297)],
        },
    ];
    for Published { name, a0, a1, limits } in systems {
        for (bracket, limit) in limits {
            let found = crossing(bracket, |delay| abscissa(&a0, &a1, delay));
            assert!((found - limit).abs() < 1e-9, "{name}: {found} for {limit}");
        }
    }
}

/// The H-MANs of Table III at twice K_xy, Eq. 5 on their x axis: the margins of both axes (x 167 ms,
/// y 232 ms in Fig. 5), recomputed from the paper's masses and dampings to eleven digits.
#[test]
fn ref_hman_loses_stability_at_the_known_delays() {
    let dyad = hman();
    let (mass, damping) = ((0.8334, 0.7776), (7.7257_f64, 7.4208_f64));
    let stiffness = (damping.0 * damping.0 + damping.1 * damping.1) / (mass.0 + mass.1);
    for (axis, limit) in [(0, 0.16718632424), (1, 0.23185110031)] {
        let axis = dyad.axis(axis).unwrap();
        let found = crossing((0.5 * limit, 1.5 * limit), |delay| {
            let abscissa = spectral_abscissa(&axis, stiffness, &Delay::each_way(delay).unwrap()).unwrap();
            assert!(abscissa.certificate.is_complete());
            abscissa.value
        });
        assert!((found - limit).abs() < 1e-10 * limit, "{found} for {limit}");
    }
}

/// m = 1, 1 and b = 1, 10 at 0.99 of the paper's critical stiffness 25.25 N/m: stable for every
/// constant delay by Eq. 5, in truth unstable from 0.1718 s on.
#[test]
fn ref_unequal_damping_is_unstable_below_the_papers_critical_stiffness() {
    let axis = DyadAxis::new(1.0, 1.0, 1.0, 10.0).unwrap();
    let value =
        |delay: f64| spectral_abscissa(&axis, 24.9975, &Delay::each_way(delay).unwrap()).unwrap().value;
    assert!(value(0.175) > 0.0);
    let limit = crossing((0.1, 0.175), value);
    assert!((limit - 0.1718).abs() < 5e-5, "{limit}");
}

/// Stability comes back at a longer delay: stable on [0, 0.8508) and (1.7738, 2.1128) s only.
#[test]
fn ref_stability_returns_at_a_longer_delay() {
    let axis = DyadAxis::new(0.97670822, 2.15372614, 0.30379312, 4.59594729).unwrap();
    let value =
        |delay: f64| spectral_abscissa(&axis, 9.174736188, &Delay::each_way(delay).unwrap()).unwrap().value;
    for (bracket, limit) in [((0.1, 1.2), 0.8508), ((1.2, 2.0), 1.7738), ((2.0, 2.3), 2.1128)] {
        let found = crossing(bracket, value);
        assert!((found - limit).abs() < 5e-5, "{found} for {limit}");
    }
}

/// Identical robots: |p(jω)| = k holds at ω² = (2mk − b²)/m² (the paper's Eq. 16, its prefactor mended),
/// and the first delay follows from the argument of p there.
#[test]
fn ref_identical_robots_cross_where_the_closed_form_says() {
    for (m, b, k) in [(1.0_f64, 4.0, 10.0), (0.5, 4.0, 60.0), (2.0, 15.0, 300.0)] {
        let frequency = ((2.0 * m * k - b * b) / (m * m)).sqrt();
        // m s² + b s + k = ± k e^(−sδ) at s = jω; both signs together: e^(−2jωδ) = (p/k)².
        let p = Complex64::new(k - m * frequency * frequency, b * frequency);
        let limit = (-(p * p).arg()).rem_euclid(std::f64::consts::TAU) / (2.0 * frequency);
        let axis = DyadAxis::new(m, b, m, b).unwrap();
        let found = crossing((0.5 * limit, 1.2 * limit), |delay| {
            spectral_abscissa(&axis, k, &Delay::each_way(delay).unwrap()).unwrap().value
        });
        // Only rounding separates the two: the abscissa crosses at a slope of about 1/s².
        assert!((found - limit).abs() < 1e-12 * limit.max(1.0), "{found} for {limit}");
        let roots = characteristic_roots(&axis, k, &Delay::each_way(limit).unwrap(), 2).unwrap().roots;
        assert!((roots[0] - Complex64::new(0.0, frequency)).norm() < 1e-12 * frequency);
    }
}

/// Two free robots without damping or delay swing against each other for ever, at √(k/m₁ + k/m₂).
#[test]
fn ref_undamped_robots_swing_at_their_natural_frequency() {
    let axis = DyadAxis::new(2.0, 0.0, 0.5, 0.0).unwrap();
    let spectrum = characteristic_roots(&axis, 40.0, &Delay::each_way(0.0).unwrap(), 8).unwrap();
    assert!(spectrum.certificate.is_complete());
    assert_eq!(spectrum.roots.len(), 3);
    let mut sizes: Vec<f64> = spectrum.roots.iter().map(|root| root.im).collect();
    sizes.sort_by(f64::total_cmp);
    // A pair at ±10 rad/s; the common motion drifts, a second root at 0 besides the rigid-body one.
    for (size, expected) in sizes.iter().zip([-10.0, 0.0, 10.0]) {
        assert!((size - expected).abs() < 1e-12);
    }
    assert!(spectrum.roots.iter().all(|root| root.re.abs() < 1e-13));
}

/// A critically damped relative motion: a double root besides that of the common motion's drag.
#[test]
fn ref_multiple_roots_without_delay_count_each_time() {
    // Identical free robots: s (s + b/m) (s² + (b/m) s + 2k/m); b² = 8 m k makes the pair a double.
    let axis = DyadAxis::new(1.0, 4.0, 1.0, 4.0).unwrap();
    let spectrum = characteristic_roots(&axis, 2.0, &Delay::each_way(0.0).unwrap(), 4).unwrap();
    assert!(spectrum.certificate.is_complete(), "{}", spectrum.certificate);
    for (root, expected) in spectrum.roots.iter().zip([-2.0, -2.0, -4.0]) {
        assert!((root - expected).norm() < 1e-7, "{root} for {expected}");
    }
}

/// Roots that count several times, without any delay and with one: ‖Δ⁻¹‖ grows like a power there.
#[test]
fn ref_multiple_roots_of_a_system_count_each_time() {
    let integrators = DelaySystem::new(dmatrix![0.0, 1.0; 0.0, 0.0], vec![]).unwrap();
    let spectrum = integrators.characteristic_roots(5).unwrap();
    assert!(spectrum.certificate.is_complete() && spectrum.depth == f64::NEG_INFINITY);
    assert_eq!(spectrum.roots, [Complex64::ZERO; 2]);
    let thrice = DelaySystem::new(DMatrix::zeros(3, 3), vec![(1.0, -DMatrix::identity(3, 3))]).unwrap();
    let spectrum = thrice.characteristic_roots(6).unwrap();
    assert!(spectrum.certificate.is_complete(), "{}", spectrum.certificate);
    let w = lambert(-1.0, Complex64::new(-0.3, 1.3));
    for root in &spectrum.roots {
        assert!((Complex64::new(root.re, root.im.abs()) - w).norm() < 1e-12, "{root} for {w}");
    }
}
