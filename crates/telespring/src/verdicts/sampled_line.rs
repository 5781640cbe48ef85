//! The sampled dyad on the unit circle z = e^(jθ), for the first stiffness at which a multiplier reaches it.
//!
//! A multiplier lies on the circle where (q₁ + n₁)(q₂ + n₂) = n₁ n₂ z^(−N) with nᵢ = k νᵢ + c μᵢ. Divided by z,
//! every factor is a polynomial in v = 1 − cos θ of degree 2 at most, plus j sin θ times one of degree 1, both
//! linear in k. Rectangles around the factors are therefore as tight as those of the continuous dyad.

use std::f64::consts::PI;

use num_complex::Complex64;

use super::Network;
use super::zero_order_hold::SampledPlant;
use crate::characteristic::ln_1p;
use crate::criteria::branch_and_bound::{
    FactorBox, Found, LineFunction, Logarithm, Region, SideFactors, SideSlopes, Wanted, crossing_parameters,
};
use crate::criteria::complex_box::{Interval, Rectangle};
use crate::model::{DyadAxis, Side};

/// A factor on the unit circle: re[0] + re[1] v + re[2] v² + j sin θ (im[0] + im[1] v), v = 1 − cos θ.
#[derive(Debug, Clone, Copy)]
pub(super) struct CircleFactor {
    pub re: [f64; 3],
    pub im: [f64; 2],
}

impl CircleFactor {
    /// z⁻¹ p(w) on the circle for a polynomial in w = z − 1 of degree 1, constant term first.
    pub fn linear(p0: f64, p1: f64) -> Self {
        Self { re: [p0, p1 - p0, 0.0], im: [p1 - p0, 0.0] }
    }

    /// z⁻² p(w) on the circle for a polynomial in w = z − 1 of degree 2, constant term first.
    pub fn quadratic(p0: f64, p1: f64, p2: f64) -> Self {
        // In y = 1 − z⁻¹ = v + j sin θ it is p0 + (p1 − 2 p0) y + (p0 − p1 + p2) y².
        let (first, second) = (p1 - 2.0 * p0, p0 - p1 + p2);
        Self { re: [p0, first - 2.0 * second, 2.0 * second], im: [first, 2.0 * second] }
    }

    /// a + k b.
    fn plus(a: &Self, k: f64, b: &Self) -> Self {
        Self { re: [0, 1, 2].map(|i| a.re[i] + k * b.re[i]), im: [0, 1].map(|i| a.im[i] + k * b.im[i]) }
    }

    /// The value at an angle with its v and sin θ, and the sum of the moduli of its terms.
    pub fn value(&self, v: f64, sine: f64) -> (Complex64, f64) {
        let value = Complex64::new(
            self.re[0] + v * (self.re[1] + v * self.re[2]),
            sine * (self.im[0] + v * self.im[1]),
        );
        let size = self.re[0].abs()
            + v * (self.re[1].abs() + v * self.re[2].abs())
            + sine * (self.im[0].abs() + v * self.im[1].abs());
        (value, size)
    }
}

/// An arc of the circle: v = 1 − cos θ, sin θ and cos θ over a range of angles.
struct Arc {
    v: Interval,
    sine: Interval,
    cosine: Interval,
}

impl Arc {
    /// The arc between two angles from 0 to π.
    fn new((from, to): (f64, f64)) -> Self {
        let sines = Interval::between(from.sin(), to.sin());
        let top = if from <= 0.5 * PI && to >= 0.5 * PI { 1.0 } else { sines.high };
        Self {
            v: Interval { low: versine(from), high: versine(to) },
            sine: Interval { low: sines.low.max(0.0), high: top },
            cosine: Interval { low: to.cos(), high: from.cos() },
        }
    }

    /// The hull of an expression at both ends of v for both ends of k. It is linear in k, and `bend` bounds its
    /// second derivative by v.
    fn hull(&self, ends: [&CircleFactor; 2], bend: f64, at: impl Fn(&CircleFactor, f64) -> f64) -> Interval {
        let mut hull = Interval::point(at(ends[0], self.v.low));
        for (end, v) in [(ends[0], self.v.high), (ends[1], self.v.low), (ends[1], self.v.high)] {
            let value = at(end, v);
            hull = Interval { low: hull.low.min(value), high: hull.high.max(value) };
        }
        let width = self.v.high - self.v.low;
        hull.widened(0.125 * bend * width * width)
    }

    /// The values of a factor between its two ends in k.
    fn values(&self, ends: [&CircleFactor; 2]) -> Rectangle {
        let bend = 2.0 * ends[0].re[2].abs().max(ends[1].re[2].abs());
        let re = self.hull(ends, bend, |f, v| f.re[0] + v * (f.re[1] + v * f.re[2]));
        let im = self.hull(ends, 0.0, |f, v| f.im[0] + v * f.im[1]).times(self.sine);
        Rectangle { re, im }
    }

    /// The derivatives by θ of a factor between its two ends in k.
    fn slopes(&self, ends: [&CircleFactor; 2]) -> Rectangle {
        let re = self.hull(ends, 0.0, |f, v| f.re[1] + 2.0 * v * f.re[2]).times(self.sine);
        let level = self.hull(ends, 0.0, |f, v| f.im[0] + v * f.im[1]).times(self.cosine);
        let tilt = self.hull(ends, 0.0, |f, _| f.im[1]).times(self.sine).times(self.sine);
        Rectangle { re, im: level.plus(tilt) }
    }
}

/// 1 − cos θ without cancellation, for an angle on the unit circle.
pub(super) fn versine(angle: f64) -> f64 {
    let half = (0.5 * angle).sin();
    2.0 * half * half
}

/// The factors of one side on the unit circle.
#[derive(Debug, Clone, Copy)]
pub(super) struct CircleSide {
    /// q: the side alone.
    pub alone: CircleFactor,
    /// ν: the returned force per unit of stiffness.
    spring: CircleFactor,
    /// c μ: the returned force of the coupling damper.
    damper: CircleFactor,
}

impl CircleSide {
    /// The factors of one side under a network's controllers with a coupling damper.
    pub fn new(side: &Side, network: &Network, damper: f64) -> Self {
        let period = network.sample_period();
        let plant = SampledPlant::new(side, period, network.computing_time());
        let force = |stiffness: f64, damping: f64| match plant.numerator(stiffness, damping)[..] {
            [n0, n1, n2] => CircleFactor::quadratic(n0, n1, n2),
            [n0, n1] => CircleFactor::linear(n0, n1),
            _ => unreachable!("a numerator has two or three coefficients"),
        };
        let [[a, b], [c, d]] = plant.change;
        // 1 − e^(−B h/M), the lost part of the product of both poles.
        let lost = -(-side.damping / side.mass * period).exp_m1();
        Self {
            alone: CircleFactor { re: [a * d - b * c, lost - 2.0, 0.0], im: [lost, 0.0] },
            spring: force(1.0, 0.0),
            damper: force(0.0, damper),
        }
    }

    /// n and q + n at a stiffness.
    pub fn at(&self, stiffness: f64) -> [CircleFactor; 2] {
        let coupling = CircleFactor::plus(&self.damper, stiffness, &self.spring);
        [coupling, CircleFactor::plus(&self.alone, 1.0, &coupling)]
    }
}

/// The characteristic function of a sampled axis on the unit circle as a function of angle and stiffness.
#[derive(Debug, Clone, Copy)]
struct CircleLine {
    sides: [CircleSide; 2],
    /// N, the round trip in sample periods.
    ticks: f64,
}

impl LineFunction for CircleLine {
    /// The factors over a box of angles and stiffnesses.
    fn factors(&self, region: &Region) -> FactorBox {
        let arc = Arc::new(region.frequency);
        let zero = Rectangle::point(Complex64::ZERO);
        let ends = self.sides.map(|side| [side.at(region.parameter.0), side.at(region.parameter.1)]);
        let mut by_frequency = [SideSlopes { alone: zero, coupling: zero }; 2];
        let mut by_parameter = by_frequency;
        let mut sides = [SideFactors { alone: zero, coupling: zero, whole: zero }; 2];
        for (i, [[coupling0, whole0], [coupling1, whole1]]) in ends.iter().enumerate() {
            let CircleSide { alone, spring, .. } = &self.sides[i];
            sides[i] = SideFactors {
                alone: arc.values([alone, alone]),
                coupling: arc.values([coupling0, coupling1]),
                whole: arc.values([whole0, whole1]),
            };
            by_frequency[i] = SideSlopes {
                alone: arc.slopes([alone, alone]),
                coupling: arc.slopes([coupling0, coupling1]),
            };
            by_parameter[i] = SideSlopes { alone: zero, coupling: arc.values([spring, spring]) };
        }
        let (from, to) = region.frequency;
        FactorBox {
            sides,
            turn: Interval { low: from * self.ticks, high: to * self.ticks },
            by_frequency: (by_frequency, Interval::point(self.ticks)),
            by_parameter: (by_parameter, Interval::point(0.0)),
        }
    }

    /// L at an angle and a stiffness.
    fn logarithm(&self, frequency: f64, stiffness: f64) -> Logarithm {
        let (v, sine) = (versine(frequency), frequency.sin());
        let mut value = Complex64::new(0.0, frequency * self.ticks);
        let mut error = value.im;
        for side in &self.sides {
            let [coupling, _] = side.at(stiffness);
            let (alone, size) = side.alone.value(v, sine);
            let (coupling, coupling_size) = coupling.value(v, sine);
            value += ln_1p(alone / coupling);
            let spread = 1.0 + coupling_size / coupling.norm();
            error += size * spread / (alone + coupling).norm();
        }
        let error = 4.0 * f64::EPSILON * error;
        Logarithm { value, half_turns: 0, error: Complex64::new(error, error) }
    }

    /// ln g = 0 on the unit circle.
    fn log_growth(&self) -> f64 {
        0.0
    }

    /// On the circle the function is real at z = 1 and z = −1.
    fn is_real_at(&self, frequency: f64) -> bool {
        frequency == 0.0 || frequency == PI
    }

    /// A box of the sampled dyad takes about twice as long as one of the continuous dyad.
    fn most_boxes(&self) -> usize {
        120_000
    }

    /// Crossings are wanted on the whole circle.
    fn is_excluded(&self, _: &Region) -> bool {
        false
    }
}

impl CircleLine {
    /// The smallest stiffness of a range at which z = −1 is a multiplier of the sampled dyad.
    fn first_alternating_stiffness(&self, (low, high): (f64, f64)) -> Option<f64> {
        let sign = if self.ticks % 2.0 == 0.0 { 1.0 } else { -1.0 };
        let [[q1, n1, c1], [q2, n2, c2]] =
            self.sides.map(|side| [side.alone, side.spring, side.damper].map(|f| f.value(2.0, 0.0).0.re));
        // (q₁ + c₁ + k n₁)(q₂ + c₂ + k n₂) − sign (c₁ + k n₁)(c₂ + k n₂), in powers of k.
        let rest = 1.0 - sign;
        let a = rest * n1 * n2;
        let b = q1 * n2 + q2 * n1 + rest * (c1 * n2 + c2 * n1);
        let c = q1 * q2 + q1 * c2 + q2 * c1 + rest * c1 * c2;
        let roots = if a == 0.0 {
            [-c / b, f64::NAN]
        } else {
            let half = -0.5 * (b + (b * b - 4.0 * a * c).sqrt().copysign(b));
            [half / a, c / half]
        };
        roots.into_iter().filter(|&k| k > low && k < high).reduce(f64::min)
    }
}

/// The smallest stiffness (N/m) of a range at which a multiplier of the sampled axis lies on the unit circle, or
/// the upper end of the range. If the search does not end, the stiffness up to which there is none.
pub(super) fn first_crossing_stiffness(axis: &DyadAxis, network: &Network, range: (f64, f64)) -> f64 {
    let [forward, backward] = network.whole_ticks();
    let line = CircleLine {
        sides: axis.sides.map(|side| CircleSide::new(&side, network, axis.coupling_damping)),
        ticks: (forward + backward) as f64,
    };
    let high = line.first_alternating_stiffness(range).unwrap_or(range.1);
    let region = Region { frequency: (0.0, PI), parameter: (range.0, high) };
    match crossing_parameters(&line, region, Wanted::Least) {
        Found::All(stiffnesses) => stiffnesses.first().copied().unwrap_or(high),
        Found::Unfinished(proven) => proven,
    }
}
