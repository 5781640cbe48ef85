//! The count of unstable roots against the eigenvalues of a collocated generator: no shared code.

use nalgebra::DMatrix;
use num_complex::Complex64;
use telespring::response::{GridStatus, NyquistStatus, frequency_grid, nyquist, open_loop};
use telespring::{Delay, DyadAxis};

/// SplitMix64, so that every run sees the same dyads.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) as f64 / 2f64.powi(64)
    }

    /// Log-uniform.
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.unit())
    }
}

#[derive(Debug, Clone, Copy)]
struct Case {
    mass: [f64; 2],
    damping: [f64; 2],
    ground: [f64; 2],
    coupling_damping: f64,
    stiffness: f64,
    delay: [f64; 2],
}

impl Case {
    fn random(random: &mut Random) -> Self {
        let mass = [random.between(0.1, 10.0), random.between(0.1, 10.0)];
        let damping = [random.between(0.1, 10.0), random.between(0.1, 10.0)];
        let paper = (damping[0].powi(2) + damping[1].powi(2)) / (2.0 * (mass[0] + mass[1]));
        let stiffness = paper * random.between(0.2, 60.0);
        let grounded = (4.0 * random.unit()) as u32;
        let ground = [0, 1]
            .map(|i| if grounded & (1 << i) != 0 { stiffness * random.between(0.01, 10.0) } else { 0.0 });
        let coupling_damping = if random.unit() < 0.5 { 0.0 } else { damping[0] * random.between(0.05, 2.0) };
        let longest = 6.0 * (mass[0].min(mass[1]) / stiffness).sqrt().min(6.0);
        let delay = [longest * random.unit(), longest * random.unit()];
        Self { mass, damping, ground, coupling_damping, stiffness, delay }
    }

    fn axis(&self) -> DyadAxis {
        let [[m1, m2], [b1, b2], [h1, h2]] = [self.mass, self.damping, self.ground];
        DyadAxis::with_operators(m1, b1, m2, b2, h1, h2, self.coupling_damping).unwrap()
    }

    fn delay(&self) -> Delay {
        Delay::new(self.delay[0], self.delay[1]).unwrap()
    }

    /// Eigenvalues of the infinitesimal generator, collocated at `degree` + 1 Chebyshev points
    /// (Breda, Maset and Vermiglio 2005), the one nearest 0 left out for free handles.
    fn eigenvalues(&self, degree: usize) -> Vec<Complex64> {
        let span = self.delay[0].max(self.delay[1]);
        let count = degree + 1;
        let unit: Vec<f64> =
            (0..count).map(|j| (std::f64::consts::PI * j as f64 / degree as f64).cos()).collect();
        let weight = |j: usize| {
            let end = if j == 0 || j == degree { 2.0 } else { 1.0 };
            end * if j.is_multiple_of(2) { 1.0 } else { -1.0 }
        };
        let mut generator = DMatrix::<f64>::zeros(4 * count, 4 * count);
        for i in 1..count {
            let mut diagonal = 0.0;
            for j in (0..count).filter(|&j| j != i) {
                let slope = weight(i) / weight(j) / (unit[i] - unit[j]);
                diagonal -= slope;
                for state in 0..4 {
                    generator[(4 * i + state, 4 * j + state)] = 2.0 * slope / span;
                }
            }
            for state in 0..4 {
                generator[(4 * i + state, 4 * i + state)] = 2.0 * diagonal / span;
            }
        }
        let at = |ago: f64| -> Vec<f64> {
            let place = 1.0 - 2.0 * ago / span;
            if let Some(hit) = unit.iter().position(|&u| (u - place).abs() < 1e-14) {
                return (0..count).map(|j| f64::from(j == hit)).collect();
            }
            let terms: Vec<f64> = (0..count).map(|j| 1.0 / (weight(j) * (place - unit[j]))).collect();
            let sum: f64 = terms.iter().sum();
            terms.iter().map(|term| term / sum).collect()
        };
        for i in 0..2 {
            let (row, other) = (2 * i + 1, 2 * (1 - i));
            generator[(2 * i, row)] = 1.0;
            generator[(row, 2 * i)] = -(self.stiffness + self.ground[i]) / self.mass[i];
            generator[(row, row)] = -(self.damping[i] + self.coupling_damping) / self.mass[i];
            // Towards robot 1 acts the backward delay, towards robot 2 the forward one.
            for (j, part) in at(self.delay[1 - i]).iter().enumerate() {
                generator[(row, 4 * j + other)] += part * self.stiffness / self.mass[i];
                generator[(row, 4 * j + other + 1)] += part * self.coupling_damping / self.mass[i];
            }
        }
        let mut values: Vec<Complex64> = generator.complex_eigenvalues().iter().copied().collect();
        if self.ground == [0.0, 0.0] {
            values.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
            let rigid_body = values.remove(0);
            assert!(rigid_body.norm() < 1e-6, "{rigid_body}");
        }
        values
    }
}

#[test]
fn cross_unstable_roots_are_the_collocated_eigenvalues() {
    let mut random = Random(7);
    let (mut compared, mut unstable) = (0, 0);
    for _ in 0..400 {
        let case = Case::random(&mut random);
        let values = case.eigenvalues(18);
        let natural = (case.stiffness / case.mass[0].min(case.mass[1])).sqrt();
        // Collocation at 19 points is good to some 1e-7 at these ωδ; nearer the axis it cannot tell.
        if values.iter().any(|value| value.re.abs() < 1e-5 * natural) {
            continue;
        }
        let expected = values.iter().filter(|value| value.re > 0.0).count();
        let plot = nyquist(&case.axis(), case.stiffness, &case.delay()).unwrap();
        assert_eq!(plot.unstable_roots, expected, "{case:?}");
        assert_eq!(plot.status, NyquistStatus::Counted, "{case:?}");
        compared += 1;
        unstable += usize::from(expected > 0);
    }
    assert!(compared > 380 && unstable > 60 && compared - unstable > 60, "{compared} {unstable}");
}

/// Net clockwise turns of a sampled locus around −1 over all frequencies, closed at both ends.
fn turns(locus: &[Complex64], free: bool) -> f64 {
    let difference: Vec<Complex64> = locus.iter().map(|value| value + 1.0).collect();
    let start = usize::from(free);
    let mut turned = difference[start].arg() - if free { std::f64::consts::FRAC_PI_2 } else { 0.0 };
    for pair in difference[start..].windows(2) {
        turned += (pair[1] * pair[0].conj()).arg();
    }
    turned -= difference[difference.len() - 1].arg();
    -turned / std::f64::consts::PI - if free { 0.5 } else { 0.0 }
}

#[test]
fn cross_the_drawn_locus_turns_as_counted() {
    // 1 + L runs from +j·0 (free) or from a positive number to 1, and turns −Z/2 times on the way.
    let mut random = Random(8);
    for _ in 0..200 {
        let case = Case::random(&mut random);
        let plot = nyquist(&case.axis(), case.stiffness, &case.delay()).unwrap();
        assert_eq!(plot.locus_status, GridStatus::Resolved, "{case:?}");
        let turned = turns(&plot.locus, plot.rigid_body);
        assert!((turned - plot.encirclements as f64).abs() < 1e-6, "{turned} {case:?}");
    }
}

#[test]
fn cross_margins_bring_a_root_onto_the_axis() {
    let mut random = Random(9);
    let mut tried = 0;
    for _ in 0..300 {
        let case = Case::random(&mut random);
        let axis = case.axis();
        let plot = nyquist(&axis, case.stiffness, &case.delay()).unwrap();
        let at = |w: f64| open_loop(&axis, case.stiffness, &case.delay(), &[w]).unwrap().value[0];
        for margin in [plot.gain_margin, plot.gain_reduction_margin].into_iter().flatten() {
            assert!((at(margin.frequency) * margin.value + 1.0).norm() < 1e-9, "{case:?}");
        }
        if let Some(margin) = plot.phase_margin {
            let rotated = [1.0, -1.0]
                .map(|sign| (at(margin.frequency) * Complex64::cis(sign * margin.value) + 1.0).norm());
            assert!(rotated[0].min(rotated[1]) < 1e-9, "{case:?}");
        }
        let Some(margin) = plot.delay_margin.filter(|margin| margin.value < 40.0) else { continue };
        let later = |factor: f64| {
            let [forward, backward] = case.delay;
            let delay = Delay::new(forward + 2.0 * factor * margin.value, backward).unwrap();
            nyquist(&axis, case.stiffness, &delay).unwrap()
        };
        assert!(later(0.5).is_stable() && later(0.9999).is_stable(), "{case:?}");
        assert_eq!(later(1.0001).unstable_roots, 2, "{case:?}");
        tried += 1;
    }
    assert!(tried > 50, "{tried}");
}

#[test]
fn cross_minimum_distance_against_a_dense_scan() {
    let mut random = Random(10);
    for _ in 0..60 {
        let case = Case::random(&mut random);
        let plot = nyquist(&case.axis(), case.stiffness, &case.delay()).unwrap();
        let high = plot.frequency[plot.frequency.len() - 1];
        let scan: Vec<f64> = (0..40_000).map(|i| high * (f64::from(i) / 40_000.0).powi(2)).collect();
        let away: Vec<f64> = open_loop(&case.axis(), case.stiffness, &case.delay(), &scan)
            .unwrap()
            .value
            .iter()
            .map(|value| (value + 1.0).norm())
            .collect();
        let mut least = if plot.rigid_body { 1.0 } else { away[0].min(1.0) };
        for trio in away.windows(3).skip(2) {
            if trio[1] < trio[0] && trio[1] < trio[2] {
                least = least.min(trio[1]);
            }
        }
        let found = plot.minimum_distance.value;
        assert!(found <= least + 1e-9 && found > least - 1e-3, "{found} {least} {case:?}");
    }
}

#[test]
fn cross_the_grid_resolves_what_a_finer_grid_shows() {
    let mut random = Random(11);
    for round in 0..60 {
        let mut case = Case::random(&mut random);
        if round < 30 {
            case.damping = case.damping.map(|damping| 1e-4 * damping);
        }
        // The round trip turns up to 2 000 rad, or the range is wide.
        let high = (2e3 / case.delay().round_trip()).min(1e4);
        let grid = |resolution: f64| {
            frequency_grid(&case.axis(), case.stiffness, &case.delay(), 0.0, high, resolution, 1_000_000)
                .unwrap()
        };
        let (coarse, fine) = (grid(0.2), grid(0.05));
        assert_eq!(
            (&coarse.status, &fine.status),
            (&GridStatus::Resolved, &GridStatus::Resolved),
            "{case:?}"
        );
        let peak = |frequency: &[f64]| {
            let curve = open_loop(&case.axis(), case.stiffness, &case.delay(), frequency).unwrap();
            (turns(&curve.value, case.ground == [0.0, 0.0]), curve.magnitude.into_iter().fold(0.0, f64::max))
        };
        let ((turns1, peak1), (turns2, peak2)) = (peak(&coarse.frequency), peak(&fine.frequency));
        assert!((turns1 - turns2).abs() < 1e-6, "{case:?}");
        // Near a peak the response is flat: a factor within a tenth of the width misses 1 % at most, two of them 2 %.
        assert!((peak1 / peak2 - 1.0).abs() < 0.02, "{peak1} {peak2} {case:?}");
    }
}
