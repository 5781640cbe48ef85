use super::contour::{self, zeros_right_of};
use super::line::VerticalLine;
use super::*;

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

    fn choose<T: Copy>(&mut self, values: &[T]) -> T {
        values[(self.unit() * values.len() as f64) as usize]
    }

    /// Any dyad of the promised range: masses, damping, stiffness over six to nine decades.
    fn wide(&mut self) -> (DyadAxis, f64) {
        let k = self.log(1e-3, 1e6);
        let damping = |r: &mut Self, m: f64| {
            let natural = 2.0 * (m * k).sqrt();
            match (r.unit() * 8.0) as usize {
                0 => 0.0,
                1 => natural * r.log(1e-6, 1e6),
                _ => natural * r.log(0.01, 10.0),
            }
        };
        let m1 = self.log(1e-3, 1e3);
        let m2 = if self.unit() < 0.2 { m1 } else { self.log(1e-3, 1e3) };
        let b1 = damping(self, m1).min(1e6);
        let b2 = if m1 == m2 && self.unit() < 0.7 { b1 } else { damping(self, m2).min(1e6) };
        let ground = |r: &mut Self| match (r.unit() * 8.0) as usize {
            0..4 => 0.0,
            4 => (k * r.log(1e-9, 1e9)).min(1e7),
            _ => (k * r.log(1e-3, 1e3)).min(1e7),
        };
        let kh1 = ground(self);
        let kh2 = if m1 == m2 && self.unit() < 0.5 { kh1 } else { ground(self) };
        let c = if self.unit() < 0.5 { 0.0 } else { (m1 * k).sqrt() * self.log(1e-3, 10.0) };
        (DyadAxis::with_operators(m1, b1, m2, b2, kh1, kh2, c).unwrap(), k)
    }
}

#[test]
fn cross_closed_form_count_agrees_with_the_walked_contour() {
    let mut random = Random(1);
    let mut compared = 0;
    for _ in 0..3000 {
        let (axis, k) = random.wide();
        let natural = (k / axis.sides[0].mass.max(axis.sides[1].mass)).sqrt();
        let t = random.log(0.01, 30.0) / natural;
        let chi = Characteristic::new(&axis, k, t.min(200.0)).normalised();
        let sigma = natural * (2.0 * random.unit() - 1.0) * random.choose(&[0.01, 0.3, 2.0]);
        let line = VerticalLine::count_right_of(&chi, sigma);
        let Some(counted) = line.count else { continue };
        // Every root right of the line satisfies |p1 p2| <= |q|² e^(-T sigma).
        let growth = (-chi.round_trip * sigma).exp().max(1.0);
        let mut radius = natural;
        let small = |r: f64| {
            let side = |i: usize| r * r - chi.sides[i].damping * r - chi.sides[i].stiffness;
            let q = chi.stiffness + chi.coupling_damping * r;
            side(0) > 0.0 && side(1) > 0.0 && side(0) * side(1) > growth * q * q
        };
        while !small(radius) {
            radius *= 1.5;
        }
        match zeros_right_of(&chi, sigma, radius, 200_000) {
            Ok(walked) => {
                let rigid = usize::from(chi.rigid_body && sigma < 0.0);
                assert_eq!(counted + rigid, walked, "{axis:?} k={k} T={t} sigma={sigma}");
                compared += 1;
            }
            Err(contour::ContourError::StepsExhausted { .. }) => {}
            Err(stop) => panic!("{stop}: {axis:?} k={k} T={t} sigma={sigma}"),
        }
    }
    assert!(compared > 2700, "only {compared} lines were compared");
}

#[test]
fn law_every_list_of_roots_is_complete_across_the_decades() {
    let mut random = Random(2);
    let mut failed = Vec::new();
    let total = 20_000;
    for _ in 0..total {
        let (axis, k) = random.wide();
        let any = random.log(0.01, 2.0);
        let delay = random.choose(&[0.0, 1e-9, 1e-6, any, any, any, 20.0, 100.0]);
        let forward = delay * random.choose(&[0.2, 1.0]);
        let delay = Delay::new(forward, delay).unwrap();
        let count = random.choose(&[1, 2, 3, 8, 8, 20]);
        let spectrum = characteristic_roots(&axis, k, &delay, count).unwrap();
        let degree = if axis.is_free() { 3 } else { 4 };
        let expected = if delay.round_trip() == 0.0 { count.min(degree) } else { count };
        if !spectrum.certificate.is_complete() || spectrum.roots.len() != expected {
            failed.push((axis, k, delay, count, spectrum.certificate, spectrum.roots.len(), spectrum.depth));
        }
    }
    failed.truncate(12);
    assert!(failed.is_empty(), "of {total}, the first: {failed:#?}");
}
