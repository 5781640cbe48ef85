//! The general delay system beside the solver made for dyads, where delays are tiny, long or unequal:
//! the two share the contour that counts, but neither the function counted nor any start.

use nalgebra::{DMatrix, dmatrix};
use num_complex::Complex64;
use telespring::delay_system::DelaySystem;
use telespring::{Delay, DyadAxis, hman, spectrum};

/// From 20 µs to 142 s there and back: there the chain of roots is a million times farther away than
/// the robots' own, here it has hundreds of roots nearer to the axis.
const DELAYS: [(f64, f64); 6] =
    [(6e-6, 1.4e-5), (6e-5, 1.4e-4), (6e-4, 1.4e-3), (0.1, 0.2), (3.0, 7.0), (43.0, 99.0)];

#[test]
fn cross_a_dyad_has_the_roots_of_its_delay_system_at_any_delay() {
    let x = hman().axis(0).unwrap();
    for (forward, backward) in DELAYS {
        let delay = Delay::new(forward, backward).unwrap();
        for stiffness in [20.0, 71.2, 300.0] {
            let place = format!("k = {stiffness}, delays {forward} and {backward}");
            let system = x.delay_system(stiffness, &delay).unwrap();
            let found = system.characteristic_roots(8).unwrap();
            let expected = spectrum::characteristic_roots(&x, stiffness, &delay, 8).unwrap();
            assert!(found.certificate.is_complete(), "{place}: {}", found.certificate);
            let moving: Vec<_> = found.roots.iter().filter(|root| root.norm() > 0.0).collect();
            assert!(moving.len() >= 7, "{place}: {:?}", found.roots);
            for (found, expected) in moving.iter().zip(&expected.roots) {
                // Roots lie 1e-4 apart relatively at the least; both solvers promise 1e-12 of |s|.
                assert!(
                    (*found - expected).norm() <= 1e-11 * expected.norm(),
                    "{place}: {found}, {expected}"
                );
            }
        }
    }
}

#[test]
fn cross_the_abscissa_without_zero_is_the_dyad_s() {
    let x = hman().axis(0).unwrap();
    for (forward, backward) in DELAYS {
        let delay = Delay::new(forward, backward).unwrap();
        for stiffness in [20.0, 71.2, 300.0] {
            let system = x.delay_system(stiffness, &delay).unwrap();
            let found = system.spectral_abscissa_without_zero();
            let expected = spectrum::spectral_abscissa(&x, stiffness, &delay).unwrap().value;
            assert!(found.certificate.is_complete(), "{forward} {backward}: {}", found.certificate);
            // The root's modulus is up to 20 1/s where its real part is 1e-6.
            assert!((found.value - expected).abs() <= 1e-13 * (expected.abs() + 20.0));
            assert_eq!(system.roots_at_zero(), 1);
            let whole = system.spectral_abscissa().value;
            if expected < 0.0 {
                assert_eq!(whole, 0.0, "the rigid-body root is exactly zero");
            } else {
                assert!((whole - expected).abs() <= 1e-13 * (expected + 20.0));
            }
        }
    }
}

#[test]
fn ref_a_held_handle_leaves_no_root_at_zero() {
    // 1e-6 N/m beside a spring of 100 N/m: χ(0) is far above rounding still.
    for held in [1e-6, 1.0, 1e4] {
        let axis = DyadAxis::with_operators(1.0, 4.0, 2.0, 4.0, held, 0.0, 0.0).unwrap();
        let system = axis.delay_system(100.0, &Delay::new(0.01, 0.02).unwrap()).unwrap();
        assert_eq!(system.roots_at_zero(), 0, "{held}");
        assert_eq!(system.spectral_abscissa(), system.spectral_abscissa_without_zero());
    }
}

#[test]
fn ref_roots_at_zero_count_as_often_as_they_are() {
    // A chain of n integrators: det Δ = sⁿ.
    for n in 1..=6 {
        let chain = DMatrix::from_fn(n, n, |i, j| if j == i + 1 { 3.0 } else { 0.0 });
        let system = DelaySystem::new(chain, vec![]).unwrap();
        assert_eq!(system.roots_at_zero(), n);
        assert_eq!(system.characteristic_roots(n).unwrap().roots, vec![Complex64::ZERO; n]);
        assert_eq!(system.spectral_abscissa_without_zero().value, f64::NEG_INFINITY);
    }
    // x′ = a (x − x(t − 1)): s − a + a e⁻ˢ = (1 − a) s + a s²/2 − …, a double zero at a = 1 only.
    for (a, multiplicity) in [(0.5, 1), (1.0, 2), (1.0 + 1e-9, 1), (2.0, 1)] {
        let system = DelaySystem::new(dmatrix![a], vec![(1.0, dmatrix![-a])]).unwrap();
        assert_eq!(system.roots_at_zero(), multiplicity, "{a}");
    }
    // No root at all: s = -1 only.
    assert_eq!(DelaySystem::new(dmatrix![-1.0], vec![]).unwrap().roots_at_zero(), 0);
}

#[test]
fn cross_two_dyads_side_by_side_have_both_spectra() {
    // Nothing couples them, so that the engine sees eight states, three delays and two chains.
    let (slow, fast) = (Delay::new(5.0, 11.0).unwrap(), Delay::new(0.3, 5.0).unwrap());
    let (x, y) = (hman().axis(0).unwrap(), hman().axis(1).unwrap());
    let parts = [x.delay_system(71.2, &slow).unwrap(), y.delay_system(40.0, &fast).unwrap()];
    let place = |part: usize, matrix: &DMatrix<f64>| {
        let mut whole = DMatrix::zeros(8, 8);
        whole.view_mut((4 * part, 4 * part), (4, 4)).copy_from(matrix);
        whole
    };
    let a0 = place(0, parts[0].instantaneous()) + place(1, parts[1].instantaneous());
    let delayed = (0..2)
        .flat_map(|i| parts[i].delayed().iter().map(move |(delay, matrix)| (i, *delay, matrix)))
        .map(|(i, delay, matrix)| (delay, place(i, matrix)))
        .collect();
    let system = DelaySystem::new(a0, delayed).unwrap();
    assert_eq!(system.roots_at_zero(), 2);
    let found = system.characteristic_roots(20).unwrap();
    assert!(found.certificate.is_complete(), "{}", found.certificate);
    let mut expected: Vec<Complex64> = [(&x, 71.2, &slow), (&y, 40.0, &fast)]
        .into_iter()
        .flat_map(|(axis, stiffness, delay)| {
            spectrum::characteristic_roots(axis, stiffness, delay, 20).unwrap().roots
        })
        .chain([Complex64::ZERO; 2])
        .collect();
    expected.sort_by(|a, b| b.re.total_cmp(&a.re));
    for (found, expected) in found.roots.iter().zip(&expected) {
        // Order within a pair is free here.
        assert!((found.re - expected.re).abs() <= 1e-11 * (1.0 + expected.norm()));
        assert!((found.im.abs() - expected.im.abs()).abs() <= 1e-11 * (1.0 + expected.norm()));
    }
}
