//! What holds for the roots of every dyad.

use nalgebra::{DMatrix, dmatrix};
use num_complex::Complex64;
use proptest::prelude::*;
use telespring::delay_system::DelaySystem;
use telespring::spectrum::{characteristic_roots, spectral_abscissa};
use telespring::{Delay, Dyad, DyadAxis, Operator, Robot};

/// m₁, b₁, m₂, b₂, k_h,1, k_h,2, c, k and both delays.
type Case = ([f64; 7], f64, [f64; 2]);

fn log_uniform(low: f64, high: f64) -> impl Strategy<Value = f64> {
    (low.ln()..high.ln()).prop_map(f64::exp)
}

fn case() -> impl Strategy<Value = Case> {
    let mass = || log_uniform(0.05, 20.0);
    let damping = || log_uniform(0.1, 50.0);
    let maybe = |high: f64| prop_oneof![Just(0.0), log_uniform(0.01 * high, high)];
    (
        (mass(), damping(), mass(), damping(), maybe(1000.0), maybe(1000.0), maybe(10.0)),
        log_uniform(1.0, 1000.0),
        (log_uniform(1e-3, 3.0), log_uniform(1e-3, 3.0)),
    )
        .prop_map(|(axis, k, delays)| {
            let (m1, b1, m2, b2, kh1, kh2, c) = axis;
            ([m1, b1, m2, b2, kh1, kh2, c], k, [delays.0, delays.1])
        })
}

fn axis([m1, b1, m2, b2, kh1, kh2, c]: [f64; 7]) -> DyadAxis {
    DyadAxis::with_operators(m1, b1, m2, b2, kh1, kh2, c).unwrap()
}

/// χ(s) as the model states it, its derivative, and the size of its terms.
fn chi(parameters: [f64; 7], k: f64, round_trip: f64, s: Complex64) -> (Complex64, Complex64, f64) {
    let [m1, b1, m2, b2, kh1, kh2, c] = parameters;
    let p1 = s * s * m1 + s * (b1 + c) + (k + kh1);
    let p2 = s * s * m2 + s * (b2 + c) + (k + kh2);
    let q = s * c + k;
    let delayed = q * q * (-s * round_trip).exp();
    let slope = (s * (2.0 * m1) + (b1 + c)) * p2 + (s * (2.0 * m2) + (b2 + c)) * p1
        - q * (2.0 * c) * (-s * round_trip).exp()
        + delayed * round_trip;
    let n = s.norm();
    let bulk = |m: f64, b: f64, k: f64| (m * n + b) * n + k;
    let size =
        bulk(m1, b1 + c, k + kh1) * bulk(m2, b2 + c, k + kh2) + delayed.norm() * (1.0 + round_trip * n);
    (p1 * p2 - delayed, slope, size)
}

fn close(a: &[Complex64], b: &[Complex64], tolerance: f64) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).norm() <= tolerance * a.norm().max(1e-3))
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(400) })]

    #[test]
    fn law_every_root_is_one((parameters, k, delays) in case(), count in 1_usize..14) {
        let delay = Delay::new(delays[0], delays[1]).unwrap();
        let spectrum = characteristic_roots(&axis(parameters), k, &delay, count).unwrap();
        prop_assert!(spectrum.certificate.is_complete(), "{}", spectrum.certificate);
        prop_assert_eq!(spectrum.roots.len(), count);
        for root in &spectrum.roots {
            let (value, slope, size) = chi(parameters, k, delay.round_trip(), *root);
            // The distance to the true root, beyond what evaluating χ here loses to rounding.
            let off = (value.norm() - 16.0 * f64::EPSILON * size) / slope.norm();
            prop_assert!(off <= 1e-12 * root.norm(), "{root}: {off:e} away");
            prop_assert!(root.re > spectrum.depth && *root != Complex64::ZERO);
        }
    }

    #[test]
    fn law_roots_stand_in_order_and_in_pairs((parameters, k, delays) in case()) {
        let delay = Delay::new(delays[0], delays[1]).unwrap();
        let roots = characteristic_roots(&axis(parameters), k, &delay, 9).unwrap().roots;
        prop_assert!(roots.windows(2).all(|two| two[0].re >= two[1].re));
        let mut next = 0;
        while next + 1 < roots.len() {
            if roots[next].im == 0.0 {
                next += 1;
                continue;
            }
            prop_assert!(roots[next].im > 0.0);
            prop_assert_eq!(roots[next].conj(), roots[next + 1]);
            next += 2;
        }
        let abscissa = spectral_abscissa(&axis(parameters), k, &delay).unwrap();
        prop_assert!(abscissa.certificate.is_complete());
        // Found from other starts: rounding apart, the same.
        prop_assert!((abscissa.value - roots[0].re).abs() <= 1e-11 * roots[0].norm());
    }

    #[test]
    fn law_partners_may_be_exchanged_and_only_the_sum_of_delays_counts((p, k, delays) in case()) {
        let [m1, b1, m2, b2, kh1, kh2, c] = p;
        let roots = |parameters, a, b| {
            characteristic_roots(&axis(parameters), k, &Delay::new(a, b).unwrap(), 6).unwrap().roots
        };
        let here = roots(p, delays[0], delays[1]);
        let there = roots([m2, b2, m1, b1, kh2, kh1, c], delays[1], delays[0]);
        let mean = 0.5 * (delays[0] + delays[1]);
        // Ill-conditioned roots (a near double one) lose half of their digits.
        prop_assert!(close(&here, &there, 1e-7), "{here:?} {there:?}");
        prop_assert!(close(&here, &roots(p, mean, mean), 1e-7));
    }

    #[test]
    fn law_time_scales((p, k, delays) in case(), power in -3_i32..4) {
        // s → s/a with a a power of two: T a, b/a, k/a². Nothing but exponents changes, so the roots
        // agree to rounding of the search's own path.
        let a = f64::from(power).exp2();
        let [m1, b1, m2, b2, kh1, kh2, c] = p;
        let roots = |parameters, k, x, y| {
            characteristic_roots(&axis(parameters), k, &Delay::new(x, y).unwrap(), 6).unwrap().roots
        };
        let here = roots(p, k, delays[0], delays[1]);
        let scaled = [m1, b1 / a, m2, b2 / a, kh1 / (a * a), kh2 / (a * a), c / a];
        let there: Vec<Complex64> =
            roots(scaled, k / (a * a), delays[0] * a, delays[1] * a).iter().map(|root| root * a).collect();
        prop_assert!(close(&here, &there, 1e-7), "{here:?} {there:?}");
    }

    /// Identical robots: p(s) = ±k e^(−sδ). With the lower sign p and its derivative are linear in k and
    /// b, and a double root at s = −x needs k = m x² / (1 + e^(xδ)(1 − xδ)) and b = 2 m x + k δ e^(xδ).
    #[test]
    fn law_a_constructed_double_root_counts_twice(x in 0.5_f64..20.0, product in 0.05_f64..0.9) {
        let delay = product / x;
        let grown = product.exp();
        let k = x * x / (1.0 + grown * (1.0 - product));
        let b = 2.0 * x + k * delay * grown;
        let axis = DyadAxis::new(1.0, b, 1.0, b).unwrap();
        let spectrum = characteristic_roots(&axis, k, &Delay::each_way(delay).unwrap(), 6).unwrap();
        prop_assert!(spectrum.certificate.is_complete(), "{}", spectrum.certificate);
        // Rounding of k and b parts the two by the square root of 1e-16 at least.
        let near = spectrum.roots.iter().filter(|root| (*root + x).norm() < 1e-5 * x).count();
        prop_assert_eq!(near, 2, "{:?}", spectrum.roots);
    }
}

#[test]
fn law_bad_input_is_refused_by_name() {
    let axis = DyadAxis::new(1.0, 4.0, 1.0, 4.0).unwrap();
    let delay = Delay::each_way(0.1).unwrap();
    assert_eq!(characteristic_roots(&axis, 0.0, &delay, 4).unwrap_err().field, "stiffness");
    assert_eq!(characteristic_roots(&axis, f64::NAN, &delay, 4).unwrap_err().field, "stiffness");
    assert_eq!(characteristic_roots(&axis, 10.0, &delay, 0).unwrap_err().field, "count");
    let mut broken = axis;
    broken.sides[1].mass = f64::NAN;
    assert_eq!(spectral_abscissa(&broken, 10.0, &delay).unwrap_err().field, "m2");
}

#[test]
fn law_every_dyad_that_can_be_built_has_a_spectrum() {
    // A robot and its operator at the upper end of both ranges.
    let robot = || Robot::new(vec![1e4], vec![1e6], None).unwrap();
    let operator = || Operator::new(vec![1e4], vec![1e6], vec![1e7]).unwrap();
    let dyad = Dyad::new(robot(), robot(), Some([operator(), operator()]), 1e6).unwrap();
    let delay = Delay::each_way(0.1).unwrap();
    let axis = dyad.axis(0).unwrap();
    assert!(characteristic_roots(&axis, 1e7, &delay, 4).unwrap().certificate.is_complete());
}

#[test]
fn law_a_system_that_is_no_system_is_refused() {
    let field = |a0, delayed| DelaySystem::new(a0, delayed).unwrap_err().field;
    let one = || dmatrix![1.0];
    assert_eq!(field(DMatrix::zeros(2, 3), vec![]), "a0");
    assert_eq!(field(DMatrix::zeros(0, 0), vec![]), "a0");
    assert_eq!(field(dmatrix![0.0, f64::INFINITY; 0.0, 0.0], vec![]), "a0[0][1]");
    assert_eq!(field(one(), vec![(0.1, one()), (0.2, DMatrix::zeros(2, 2))]), "delayed[1].matrix");
    assert_eq!(field(one(), vec![(-0.1, one())]), "delayed[0].delay");
    assert_eq!(field(one(), vec![(101.0, one())]), "delayed[0].delay");
    let refused = DelaySystem::new(one(), vec![(f64::NAN, one())]).unwrap_err();
    assert!(refused.to_string().contains("from 0 to 100 s"), "{refused}");
    assert!(DelaySystem::new(one(), vec![]).unwrap().characteristic_roots(0).is_err());
}

#[test]
fn law_terms_of_one_delay_are_one_term() {
    let part = |x: f64| dmatrix![x];
    let split = DelaySystem::new(
        part(-1.0),
        vec![(2.0, part(0.25)), (0.0, part(0.5)), (1.0, part(-1.0)), (2.0, part(0.5))],
    );
    let whole = DelaySystem::new(part(-0.5), vec![(1.0, part(-1.0)), (2.0, part(0.75))]);
    assert_eq!(split, whole);
}

/// Some 300 roots lie right of where the first four of collocation are found.
#[test]
fn law_too_long_a_delay_for_collocation_is_searched_on() {
    let axis = DyadAxis::new(0.8334, 7.7257, 0.7776, 7.4208).unwrap();
    let delay = Delay::each_way(100.0).unwrap();
    let system = axis.delay_system(71.2, &delay).unwrap().characteristic_roots(4).unwrap();
    assert!(system.certificate.is_complete(), "{}", system.certificate);
    let dyad = characteristic_roots(&axis, 71.2, &delay, 4).unwrap();
    for (system, dyad) in system.roots.iter().zip(&dyad.roots) {
        assert!((system - dyad).norm() <= 1e-11 * dyad.norm());
    }
}

/// Some thirty thousand roots lie in a narrow band: there is no silence about those not found.
#[test]
fn law_what_cannot_be_counted_is_told() {
    let system = DelaySystem::new(dmatrix![-1000.0], vec![(100.0, dmatrix![-990.0])]).unwrap();
    let spectrum = system.characteristic_roots(900).unwrap();
    assert!(!spectrum.certificate.is_complete());
}
