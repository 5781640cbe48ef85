//! The rule over a range of operators, by the directions of the motion.
//!
//! f > 0 says that no motion (x₁, x₂) fits into the errors: with ξ = x₁/x₂ (turned by the delays),
//!
//! ```text
//! κ|ξ|² |p₁ − e^(−jωT)/ξ|² + |p₂ − ξ|² > ω² (α₂ + α₁|ξ|²)   for every ξ.
//! ```
//!
//! At one frequency the operators of a range move p₁ and p₂ over a rectangle each, apart from each other, so that the left
//! side has its minimum at the nearest points of both. The search therefore goes over ω, k and ln ξ: four numbers, however
//! wide the range of operators is.

use std::f64::consts::PI;

use num_complex::Complex64;

use super::rule::{Cell, Pair, Rule, Weights};
use super::search::{Failure, Step, halves, middle};
use crate::criteria::complex_box::Rectangle;

/// A cell: frequency (rad/s), stiffness (N/m), ln|ξ| and arg ξ.
type Ray = [(f64, f64); 4];

/// The most cells of one step.
const MOST_CELLS: usize = 8_000;
/// Cells from ω = 0 on reach to the highest frequency over this, or over further eights of it.
const SLOW: f64 = 64.0;

/// The point of a rectangle nearest to a number.
fn nearest(rectangle: &Rectangle, to: Complex64) -> Complex64 {
    let Rectangle { re, im } = rectangle;
    Complex64::new(to.re.clamp(re.low, re.high), to.im.clamp(im.low, im.high))
}

impl Rule {
    /// Whether the rule holds for all stiffnesses of a range (N/m), all operators and all frequencies from `slowest` on.
    pub(super) fn step_over_range(
        &self,
        stiffness: (f64, f64),
        slowest: f64,
        weights: &Weights,
        examined: &mut usize,
    ) -> Step {
        let open = Step::Open(self.middle_pair());
        let Some(highest) = self.highest_frequency(stiffness.1, weights) else { return open };
        let mut start = slowest;
        if slowest == 0.0 {
            let Some(slow) = self.slow_frequency(stiffness, highest, weights, examined) else { return open };
            start = slow;
        }
        let before = *examined;
        let mut waiting = vec![((start, highest), stiffness)];
        while let Some((frequency, springs)) = waiting.pop() {
            *examined += 1;
            let ray: Ray = [frequency, springs, (0.0, 0.0), (0.0, 0.0)];
            let rectangles = self.rectangles(&ray);
            let Some((from, to)) = self.sizes(&rectangles, frequency.1, weights) else {
                if *examined - before > MOST_CELLS || frequency.1 - frequency.0 <= 1e-9 * frequency.1 {
                    return open;
                }
                let at = middle(frequency);
                let springs_at = middle(springs);
                let both = [(frequency.0, at), (at, frequency.1)].map(|frequency| {
                    [(springs.0, springs_at), (springs_at, springs.1)].map(|springs| (frequency, springs))
                });
                waiting.extend(both.into_iter().flatten());
                continue;
            };
            match self.rays([frequency, springs, (from, to), (-PI, PI)], weights, before, examined) {
                Step::Proven => {}
                other => return other,
            }
        }
        Step::Proven
    }

    /// Branch and bound over all directions of a range of sizes.
    fn rays(&self, whole: Ray, weights: &Weights, before: usize, examined: &mut usize) -> Step {
        // The factors do not depend on the direction, and are kept when a cell is halved along it.
        let mut waiting = vec![(whole, self.rectangles(&whole), None)];
        while let Some((ray, rectangles, thinner)) = waiting.pop() {
            *examined += 1;
            if self.least_along(&ray, &rectangles, weights) > 0.0 {
                continue;
            }
            let at = ray.map(|(low, high)| 0.5 * (low + high));
            if let Some(pair) = self.failing_pair(at, weights) {
                return Step::Fails(Failure { frequency: at[0], stiffness: at[1], pair });
            }
            if *examined - before > MOST_CELLS {
                return Step::Open(self.nearest_pair(at));
            }
            let thinner: [[Rectangle; 2]; 2] = thinner.unwrap_or_else(|| self.thinner(&ray));
            let mut best = (0, f64::NEG_INFINITY);
            for direction in 0..4 {
                if ray[direction].0 == ray[direction].1 {
                    continue;
                }
                let mut thin = ray;
                thin[direction] = (at[direction], at[direction]);
                let least = self.least_along(&thin, thinner.get(direction).unwrap_or(&rectangles), weights);
                if least > best.1 {
                    best = (direction, least);
                }
            }
            let range = ray[best.0];
            let split = if best.0 < 2 { middle(range) } else { at[best.0] };
            for part in [(range.0, split), (split, range.1)] {
                let mut next = ray;
                next[best.0] = part;
                waiting.push(if best.0 < 2 {
                    (next, self.rectangles(&next), None)
                } else {
                    (next, rectangles, Some(thinner))
                });
            }
        }
        Step::Proven
    }

    /// The rectangles over a cell at its middle frequency, and at its middle stiffness.
    fn thinner(&self, ray: &Ray) -> [[Rectangle; 2]; 2] {
        [0, 1].map(|direction| {
            let mut thin = *ray;
            let middle = 0.5 * (ray[direction].0 + ray[direction].1);
            thin[direction] = (middle, middle);
            self.rectangles(&thin)
        })
    }

    /// The rectangles of p₁ and p₂ over frequencies and stiffnesses.
    fn rectangles(&self, ray: &Ray) -> [Rectangle; 2] {
        let cell = Cell::new(ray[0], ray[1], &self.sides);
        self.factors::<0>(&cell).map(|(re, im)| Rectangle { re: re.value, im: im.value })
    }

    /// The logarithms of |ξ| between which the rule can fail; `None` if that is not decided.
    fn sizes(
        &self,
        [first, second]: &[Rectangle; 2],
        frequency: f64,
        weights: &Weights,
    ) -> Option<(f64, f64)> {
        let ((p1, most1), (p2, most2)) = (first.modulus(), second.modulus());
        let ([a1, a2], square) = (weights.alpha, frequency * frequency);
        let gap = |x: f64| x.max(0.0).powi(2);
        // |ξ| below `low`, and 1/|ξ| below `high`.
        let (low, high) = (0.01 / (1.0 + most1), 0.01 / (1.0 + most2));
        let small = weights.ratio * gap(1.0 - low * most1) + gap(p2 - low) > square * (a2 + a1 * low * low);
        let large =
            weights.ratio * gap(p1 - high) + gap(1.0 - high * most2) > square * (a1 + a2 * high * high);
        (small && large).then(|| (low.ln(), -high.ln()))
    }

    /// A number below the difference of both sides of the rule over a cell, divided by |ξ|².
    fn least_along(&self, ray: &Ray, [first, second]: &[Rectangle; 2], weights: &Weights) -> f64 {
        let [(w0, w1), _, (l0, l1), (a0, a1)] = *ray;
        let (size, angle) = (0.5 * (l0 + l1), 0.5 * (a0 + a1));
        let (half_size, half_angle) = (0.5 * (l1 - l0), 0.5 * (a1 - a0));
        let half_turn = 0.5 * self.round_trip * (w1 - w0);
        // e^(−jωT)/ξ and ξ lie in discs.
        let distance = |rectangle: &Rectangle, size: f64, angle: f64, half_angle: f64| {
            let centre = Complex64::from_polar(size.exp(), angle);
            let radius = size.exp() * half_size.hypot(half_angle).exp_m1();
            ((nearest(rectangle, centre) - centre).norm() - radius).max(0.0)
        };
        let turn = -0.5 * self.round_trip * (w0 + w1) - angle;
        let d1 = distance(first, -size, turn, half_angle + half_turn);
        let d2 = distance(second, size, angle, half_angle);
        let [alpha1, alpha2] = weights.alpha;
        let scale = (-l1).exp();
        weights.ratio * d1 * d1 + (d2 * scale).powi(2)
            - w1 * w1 * (alpha2 * (-2.0 * l0).exp() + alpha1) * (1.0 + 1e-12)
            - 1e-13 * (weights.ratio * first.modulus().1.powi(2) + (second.modulus().1 * scale).powi(2))
    }

    /// The operators nearest to a failure at a frequency, a stiffness and a direction.
    fn nearest_pair(&self, [frequency, stiffness, size, angle]: [f64; 4]) -> Pair {
        let point = |x: f64| (x, x);
        let rectangles = self.rectangles(&[point(frequency), point(stiffness), point(size), point(angle)]);
        let turn = -frequency * self.round_trip - angle;
        let wanted = [Complex64::from_polar((-size).exp(), turn), Complex64::from_polar(size.exp(), angle)];
        let coupling = Complex64::new(stiffness, self.coupling_damping * frequency);
        let own = Complex64::from_polar(1.0, -frequency * self.own_delay);
        [0, 1].map(|i| {
            let side = &self.sides[i];
            let open = (nearest(&rectangles[i], wanted[i]) - own) * coupling;
            let square = frequency * frequency;
            let (low, high) =
                (side.stiffness.0 - side.mass.1 * square, side.stiffness.1 - side.mass.0 * square);
            let part = if high > low { ((open.re - low) / (high - low)).clamp(0.0, 1.0) } else { 0.0 };
            [
                side.mass.1 - part * (side.mass.1 - side.mass.0),
                (open.im / frequency).clamp(side.damping.0, side.damping.1),
                side.stiffness.0 + part * (side.stiffness.1 - side.stiffness.0),
            ]
        })
    }

    /// The operators for which the rule fails at a frequency, a stiffness and a direction.
    fn failing_pair(&self, at: [f64; 4], weights: &Weights) -> Option<Pair> {
        let pair = self.nearest_pair(at);
        (self.sample(at[0], at[1], &pair).relative(weights) <= 0.0).then_some(pair)
    }

    /// A frequency (rad/s) up to which the rule holds for all operators, by the bound for slow motions.
    fn slow_frequency(
        &self,
        stiffness: (f64, f64),
        highest: f64,
        weights: &Weights,
        examined: &mut usize,
    ) -> Option<f64> {
        let mut slow = highest / SLOW;
        for _ in 0..10 {
            let mut waiting = vec![Cell::new((0.0, slow), stiffness, &self.sides)];
            let mut count = 0;
            while let Some(cell) = waiting.pop() {
                count += 1;
                let enclosed = self.least_of_slow(&cell, weights);
                if enclosed > 0.0 {
                    continue;
                }
                let direction = self.widest_of_slow(&cell, weights);
                if count > 500 || direction == 0 {
                    waiting.push(cell);
                    break;
                }
                waiting.extend(halves(&cell, direction));
            }
            *examined += count;
            if waiting.is_empty() {
                return Some(slow);
            }
            slow *= 0.125;
        }
        None
    }
}
