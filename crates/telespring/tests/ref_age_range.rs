//! Age in a range: the bound compared with a frequency grid that shares no code, and its laws.

use num_complex::Complex64;
use telespring::verdicts::{AgeRange, age_range_stiffness};
use telespring::{DyadAxis, criteria, hman};

/// An axis with free or grounded handles, as plain numbers: m, b, k_h of both sides, and the coupling damper.
struct Plain {
    sides: [[f64; 3]; 2],
    damper: f64,
}

impl Plain {
    fn of(axis: &DyadAxis) -> Self {
        let [first, second] = axis.sides;
        Self {
            sides: [first, second].map(|side| [side.mass, side.damping, side.ground_stiffness]),
            damper: axis.coupling_damping,
        }
    }

    /// sup σ_max of the scaled 2×2 matrix on a grid, by the singular values of the matrix itself, with both delays.
    fn gain(&self, k: f64, delays: [f64; 2], reach: [f64; 2], scale: f64) -> f64 {
        let top = self
            .sides
            .iter()
            .map(|[m, _, kh]| ((4.0 * k + kh) / m).sqrt())
            .fold(1.0, f64::max)
            .max(20.0 * self.damper);
        let count = 40_000;
        (0..count)
            .map(|i| {
                let w = 1e-3 * (top * 1e3).powf(f64::from(i) / f64::from(count - 1));
                let s = Complex64::new(0.0, w);
                let c = k + s * self.damper;
                let [p1, p2] = self.sides.map(|[m, b, kh]| s * s * m + s * b + c + kh);
                let [e1, e2] = delays.map(|d| (-s * d).exp());
                let common = s * c / (p1 * p2 - c * c * e1 * e2);
                let a = [
                    [common * c * e2 * reach[0], common * p1 * reach[0] / scale],
                    [common * p2 * reach[1] * scale, common * c * e1 * reach[1]],
                ];
                let trace: f64 = a.iter().flatten().map(|x| x.norm_sqr()).sum();
                let determinant = (a[0][0] * a[1][1] - a[0][1] * a[1][0]).norm();
                (0.5 * (trace + (trace * trace - 4.0 * determinant * determinant).max(0.0).sqrt())).sqrt()
            })
            .fold(0.0, f64::max)
    }

    /// The smallest gain over all scales.
    fn least_gain(&self, k: f64, delays: [f64; 2], reach: [f64; 2]) -> f64 {
        let golden = 0.5 * (5f64.sqrt() - 1.0);
        let (mut low, mut high) = (-5.0, 5.0);
        let f = |x: f64| self.gain(k, delays, reach, x.exp());
        let (mut x, mut y) = (high - golden * (high - low), low + golden * (high - low));
        let (mut fx, mut fy) = (f(x), f(y));
        while high - low > 1e-3 {
            if fx < fy {
                (high, y, fy) = (y, x, fx);
                x = high - golden * (high - low);
                fx = f(x);
            } else {
                (low, x, fx) = (x, y, fy);
                y = low + golden * (high - low);
                fy = f(y);
            }
        }
        fx.min(fy)
    }
}

fn bound(axis: &DyadAxis, ages: [(f64, f64); 2]) -> f64 {
    let ages = ages.map(|(middle, reach)| AgeRange::new(middle - reach, middle + reach).unwrap());
    let found = age_range_stiffness(axis, &ages).unwrap();
    let failing = found.failing.expect("the search ends at a failure of the rule");
    assert!(failing >= found.stiffness && failing <= found.stiffness * 1.01, "{found:?}");
    found.stiffness
}

#[test]
fn ref_identical_arms_of_the_hman() {
    // Computed before on a frequency grid with a search over the scale, N/m, by mean age and half width in ms.
    let axis = DyadAxis::new(0.8334, 7.7257, 0.8334, 7.7257).unwrap();
    for (middle, reach, expected) in
        [(0.05, 0.02, 118.69), (0.1, 0.005, 94.61), (0.1, 0.02, 77.55), (0.25, 0.01, 51.65)]
    {
        let found = bound(&axis, [(middle, reach); 2]);
        assert!((found - expected).abs() < 0.02, "{found} instead of {expected}");
    }
}

/// Random numbers for tests, by a linear congruential generator.
struct Draw(u64);

impl Draw {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Between two numbers, evenly in their logarithm.
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.unit())
    }
}

#[test]
fn cross_the_bound_is_where_a_grid_of_frequencies_finds_it() {
    let mut draw = Draw(7);
    for case in 0..12 {
        let mut side = || (draw.between(0.3, 4.0), draw.between(1.0, 20.0));
        let ((m1, b1), (m2, b2)) = (side(), side());
        let grounded = case % 3 == 1;
        let damper = if case % 3 == 2 { draw.between(0.1, 3.0) } else { 0.0 };
        let kh = if grounded { [draw.between(5.0, 300.0), draw.between(5.0, 300.0)] } else { [0.0; 2] };
        let axis = DyadAxis::with_operators(m1, b1, m2, b2, kh[0], kh[1], damper).unwrap();
        let delays = [draw.between(0.03, 0.3), draw.between(0.03, 0.3)];
        let reach = [delays[0] * draw.between(0.05, 0.9), delays[1] * draw.between(0.05, 0.9)];
        let found = bound(&axis, [(delays[0], reach[0]), (delays[1], reach[1])]);
        let plain = Plain::of(&axis);
        let below = plain.least_gain(found * 0.99, delays, reach);
        let above = plain.least_gain(found * 1.01, delays, reach);
        assert!(below < 1.0 && above > 1.0, "case {case}: {found} N/m, {below}, {above}");
    }
}

#[test]
fn law_without_a_width_it_is_the_limit_of_the_constant_delay() {
    let axis = hman().axis(0).unwrap();
    let constant = criteria::maximum_stiffness(&axis, 0.1).unwrap();
    for (reach, part) in [(1e-4, 0.01), (1e-6, 3e-4)] {
        let found = bound(&axis, [(0.1, reach); 2]);
        assert!(found <= constant && found > constant * (1.0 - part), "{found} {constant}");
    }
}
