//! The dyad's roots (Newton with a closed-form count) against the delay system's (collocation with a
//! walked contour), and against eigenvalues: methods that share no code.

use nalgebra::DMatrix;
use num_complex::Complex64;
use telespring::delay_system::DelaySystem;
use telespring::spectrum::characteristic_roots;
use telespring::{Delay, DyadAxis};

/// SplitMix64: the same cases on every machine.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn log(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.unit())
    }

    /// A dyad over two decades, free or grounded, with and without a coupling damper.
    fn dyad(&mut self) -> (DyadAxis, f64) {
        let (m1, m2) = (self.log(0.1, 10.0), self.log(0.1, 10.0));
        let (b1, b2) = (self.log(0.5, 50.0), self.log(0.5, 50.0));
        let k = (b1 * b1 + b2 * b2) / (2.0 * (m1 + m2)) * self.log(0.2, 6.0);
        let ground = |r: &mut Self| if r.unit() < 0.5 { 0.0 } else { k * r.log(0.1, 10.0) };
        let (kh1, kh2) = (ground(self), ground(self));
        let c = if self.unit() < 0.5 { 0.0 } else { self.log(0.05, 2.0) * b1.min(b2) };
        (DyadAxis::with_operators(m1, b1, m2, b2, kh1, kh2, c).unwrap(), k)
    }
}

/// The distance from `root` to the nearest of `others`.
fn nearest(root: Complex64, others: &[Complex64]) -> f64 {
    others.iter().map(|other| (other - root).norm()).fold(f64::INFINITY, f64::min)
}

#[test]
fn cross_dyad_and_delay_system_find_the_same_roots() {
    let mut random = Random(11);
    for case in 0..200 {
        let (axis, k) = random.dyad();
        let natural = (axis.sides[0].mass.max(axis.sides[1].mass) / k).sqrt();
        let delay = Delay::new(random.log(0.02, 6.0) * natural, random.log(0.02, 6.0) * natural).unwrap();
        let dyad = characteristic_roots(&axis, k, &delay, 6).unwrap();
        assert!(dyad.certificate.is_complete(), "case {case}: {}", dyad.certificate);
        let system = axis.delay_system(k, &delay).unwrap().characteristic_roots(9).unwrap();
        assert!(system.certificate.is_complete(), "case {case}: {}", system.certificate);
        let scale = (k / axis.sides[0].mass.min(axis.sides[1].mass)).sqrt();
        for root in &dyad.roots {
            // Both are refined to rounding; that of the determinant grows with the system's size.
            let off = nearest(*root, &system.roots);
            assert!(off <= 1e-8 * (root.norm() + 1e-3 * scale), "case {case}: {root} is {off:e} away");
        }
        let zeros = system.roots.iter().filter(|root| root.norm() < 1e-9 * scale).count();
        assert_eq!(zeros, usize::from(axis.is_free()), "case {case}: {:?}", system.roots);
    }
}

#[test]
fn cross_roots_without_delay_are_the_eigenvalues() {
    let mut random = Random(12);
    for case in 0..500 {
        let (axis, k) = random.dyad();
        let delay = Delay::each_way(0.0).unwrap();
        let found = characteristic_roots(&axis, k, &delay, 8).unwrap();
        assert!(found.certificate.is_complete());
        assert_eq!(found.roots.len(), if axis.is_free() { 3 } else { 4 });
        let system = axis.delay_system(k, &delay).unwrap();
        let eigenvalues: Vec<Complex64> =
            system.instantaneous().complex_eigenvalues().iter().copied().collect();
        let scale = system.instantaneous().norm();
        for root in &found.roots {
            // The eigenvalues of an unbalanced matrix are good to its norm times rounding, or the
            // square root of that where two nearly meet.
            assert!(nearest(*root, &eigenvalues) < 1e-6 * scale, "case {case}: {root}");
        }
        let sum: f64 = found.roots.iter().map(|root| root.re).sum();
        let trace = system.instantaneous().trace();
        assert!((sum - trace).abs() < 1e-12 * trace.abs(), "case {case}: {sum} for {trace}");
    }
}

/// Three partners in a ring, as one system: the circulant splits into three scalar equations.
#[test]
fn cross_three_partners_split_into_their_modes() {
    let (m, b, k, delay) = (1.2, 3.0, 20.0, 0.15);
    let mut a0 = DMatrix::zeros(6, 6);
    let mut a1 = DMatrix::zeros(6, 6);
    for i in 0..3 {
        a0[(2 * i, 2 * i + 1)] = 1.0;
        a0[(2 * i + 1, 2 * i)] = -2.0 * k / m;
        a0[(2 * i + 1, 2 * i + 1)] = -b / m;
        for j in (0..3).filter(|&j| j != i) {
            a1[(2 * i + 1, 2 * j)] = k / m;
        }
    }
    let system = DelaySystem::new(a0, vec![(delay, a1)]).unwrap();
    let spectrum = system.characteristic_roots(12).unwrap();
    assert!(spectrum.certificate.is_complete(), "{}", spectrum.certificate);
    // Eigenvalues of the ring without self-loops: 2, −1, −1. The last two are one double mode.
    for root in &spectrum.roots {
        let own = root * root * m + root * b + 2.0 * k;
        let shift = (-root * delay).exp() * k;
        let residual = (own - shift * 2.0).norm().min((own + shift).norm());
        assert!(residual < 1e-10 * (own.norm() + shift.norm()), "{root}: {residual:e}");
    }
    let double = |root: &Complex64| {
        let own = root * root * m + root * b + 2.0 * k;
        (own + (-root * delay).exp() * k).norm() < 1e-9 * own.norm()
    };
    let (twice, once): (Vec<Complex64>, Vec<Complex64>) = spectrum.roots.iter().partition(|r| double(r));
    assert!(twice.len() >= 4 && !once.is_empty());
    for root in &twice[..4] {
        assert_eq!(twice.iter().filter(|other| (*other - root).norm() < 1e-9).count(), 2, "{root}");
    }
}
