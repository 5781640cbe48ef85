//! Products of two rectangles in the complex plane: whether they reach a number.
//!
//! At one frequency the mass and stiffness of an operator only move the real part of a side's factor, its damping
//! only the imaginary part. All operators of a range thus give a rectangle, and both sides reach a number
//! exactly if one rectangle meets the image of the other under u ↦ target/u, whose edges are arcs.

use num_complex::Complex64;

/// Rounding: how far outside a rectangle a point may lie, relative to its size.
const ROUNDING: f64 = 1e-12;

/// A closed rectangle in the complex plane, parallel to the axes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rectangle {
    pub real: (f64, f64),
    pub imaginary: (f64, f64),
}

/// The smallest and the largest magnitude of the numbers in an interval.
fn magnitudes((low, high): (f64, f64)) -> (f64, f64) {
    let least = if low <= 0.0 && high >= 0.0 { 0.0 } else { low.abs().min(high.abs()) };
    (least, low.abs().max(high.abs()))
}

/// An interval widened by an amount on both ends.
fn widened((low, high): (f64, f64), by: f64) -> (f64, f64) {
    (low - by, high + by)
}

impl Rectangle {
    /// The smallest magnitude of the numbers in the rectangle.
    pub fn least(&self) -> f64 {
        magnitudes(self.real).0.hypot(magnitudes(self.imaginary).0)
    }

    /// The largest magnitude of the numbers in the rectangle.
    pub fn greatest(&self) -> f64 {
        magnitudes(self.real).1.hypot(magnitudes(self.imaginary).1)
    }

    /// The number of the rectangle with the smallest magnitude.
    pub fn nearest_to_zero(&self) -> Complex64 {
        Complex64::new(
            0.0_f64.clamp(self.real.0, self.real.1),
            0.0_f64.clamp(self.imaginary.0, self.imaginary.1),
        )
    }

    /// The rectangle widened on all sides.
    pub fn widened(&self, by: f64) -> Self {
        Self { real: widened(self.real, by), imaginary: widened(self.imaginary, by) }
    }

    /// A rectangle around all products of the numbers in this one with e^(x + jy), |x| ≤ `logarithm` and |y| ≤ `angle`.
    pub fn turned(&self, logarithm: f64, angle: f64) -> Self {
        let (real, imaginary) = (magnitudes(self.real).1, magnitudes(self.imaginary).1);
        let stretch = logarithm.exp_m1();
        let along = stretch + 0.5 * angle * angle * (1.0 + stretch);
        let across = angle * (1.0 + stretch);
        Self {
            real: widened(self.real, along * real + across * imaginary),
            imaginary: widened(self.imaginary, along * imaginary + across * real),
        }
    }

    /// The part of the rectangle with both components at most `size` in magnitude; `None` if it is empty.
    pub fn clipped(&self, size: f64) -> Option<Self> {
        let clip = |(low, high): (f64, f64)| (low.max(-size), high.min(size));
        let (real, imaginary) = (clip(self.real), clip(self.imaginary));
        (real.0 <= real.1 && imaginary.0 <= imaginary.1).then_some(Self { real, imaginary })
    }

    /// The rectangle cut across its wider side: at zero, or where the magnitude is the geometric mean of both ends'.
    pub fn halves(&self) -> [Self; 2] {
        let cut = |(low, high): (f64, f64)| {
            let (a, b) = (low.abs(), high.abs());
            if low < 0.0 && high > 0.0 {
                0.0
            } else if a.min(b) > 0.0 {
                (a * b).sqrt().copysign(low)
            } else {
                0.5 * (low + high)
            }
        };
        if self.real.1 - self.real.0 >= self.imaginary.1 - self.imaginary.0 {
            let at = cut(self.real);
            [(self.real.0, at), (at, self.real.1)].map(|real| Self { real, ..*self })
        } else {
            let at = cut(self.imaginary);
            [(self.imaginary.0, at), (at, self.imaginary.1)].map(|imaginary| Self { imaginary, ..*self })
        }
    }

    /// The corners of the rectangle.
    fn corners(&self) -> [Complex64; 4] {
        let ((left, right), (lower, upper)) = (self.real, self.imaginary);
        [(left, lower), (right, lower), (left, upper), (right, upper)].map(|(re, im)| Complex64::new(re, im))
    }

    /// Whether the rectangle contains a number, up to rounding.
    fn contains(&self, u: Complex64) -> bool {
        let inside = |(low, high): (f64, f64), x: f64| {
            let slack = ROUNDING * (low.abs() + high.abs() + u.norm());
            x >= low - slack && x <= high + slack
        };
        inside(self.real, u.re) && inside(self.imaginary, u.im)
    }
}

/// The real roots of a x² + b x + c; a repeated or barely missed root counts.
fn quadratic_roots(a: f64, b: f64, c: f64) -> [Option<f64>; 2] {
    let discriminant = b * b - 4.0 * a * c;
    let scale = b * b + (4.0 * a * c).abs();
    if discriminant < -ROUNDING * scale {
        return [None, None];
    }
    let larger = -0.5 * (b + discriminant.max(0.0).sqrt().copysign(b));
    let valid = |x: f64| x.is_finite().then_some(x);
    [valid(larger / a), valid(c / larger)]
}

/// Numbers u₁ and u₂ of two rectangles with u₁ u₂ = `target` ≠ 0; `None` if there are none.
///
/// The second rectangle has a connected image under u ↦ target/u. Two connected sets meet if their boundaries do, or
/// if one contains a point of the other.
pub(super) fn factors_of(target: Complex64, first: &Rectangle, second: &Rectangle) -> Option<[Complex64; 2]> {
    for u in first.corners() {
        let partner = target / u;
        if second.contains(partner) {
            return Some([u, partner]);
        }
    }
    for u in second.corners() {
        let partner = target / u;
        if first.contains(partner) {
            return Some([partner, u]);
        }
    }
    let (wr, wi) = (target.re, target.im);
    let within = |(low, high): (f64, f64), x: f64| {
        let slack = ROUNDING * (low.abs() + high.abs());
        x >= low - slack && x <= high + slack
    };
    // u₁ = x + jy on an edge of the first rectangle: the real part of target/u₁ is
    // (wr x + wi y)/(x² + y²), the imaginary part (wi x − wr y)/(x² + y²).
    for x in [first.real.0, first.real.1] {
        let conditions = [second.real.0, second.real.1]
            .map(|p| (p, -wi, p * x * x - wr * x))
            .into_iter()
            .chain([second.imaginary.0, second.imaginary.1].map(|q| (q, wr, q * x * x - wi * x)));
        for (a, b, c) in conditions {
            for y in quadratic_roots(a, b, c).into_iter().flatten() {
                let u = Complex64::new(x, y);
                if within(first.imaginary, y) && second.contains(target / u) {
                    return Some([u, target / u]);
                }
            }
        }
    }
    for y in [first.imaginary.0, first.imaginary.1] {
        let conditions = [second.real.0, second.real.1]
            .map(|p| (p, -wr, p * y * y - wi * y))
            .into_iter()
            .chain([second.imaginary.0, second.imaginary.1].map(|q| (q, -wi, q * y * y + wr * y)));
        for (a, b, c) in conditions {
            for x in quadratic_roots(a, b, c).into_iter().flatten() {
                let u = Complex64::new(x, y);
                if within(first.real, x) && second.contains(target / u) {
                    return Some([u, target / u]);
                }
            }
        }
    }
    None
}

/// The smallest and largest value of the cosine on an interval.
fn cosine_range((low, high): (f64, f64)) -> (f64, f64) {
    use std::f64::consts::{PI, TAU};
    if high - low >= TAU {
        return (-1.0, 1.0);
    }
    let (a, b) = (low.cos(), high.cos());
    let holds = |peak: f64| ((high - peak) / TAU).floor() * TAU + peak >= low;
    (if holds(PI) { -1.0 } else { a.min(b) }, if holds(0.0) { 1.0 } else { a.max(b) })
}

/// A rectangle around all r e^(jφ) for ranges of r ≥ 0 and of φ.
pub(super) fn sector(radius: (f64, f64), angle: (f64, f64)) -> Rectangle {
    let times = |(low, high): (f64, f64)| {
        (
            low * if low > 0.0 { radius.0 } else { radius.1 },
            high * if high > 0.0 { radius.1 } else { radius.0 },
        )
    };
    let quarter = std::f64::consts::FRAC_PI_2;
    Rectangle {
        real: times(cosine_range(angle)),
        imaginary: times(cosine_range((angle.0 - quarter, angle.1 - quarter))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rectangle(real: (f64, f64), imaginary: (f64, f64)) -> Rectangle {
        Rectangle { real, imaginary }
    }

    #[test]
    fn cross_products_of_rectangles_are_those_that_a_grid_finds() {
        // A generator of its own keeps the cases the same everywhere.
        let mut state = 7_u64;
        let mut random = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let (mut reached, mut missed) = (0, 0);
        for case in 0..400 {
            let mut interval = |low: f64, size: f64| {
                let start = low + (3.0 - low) * random();
                (start, start + size * random())
            };
            let first = rectangle(interval(-3.0, 4.0), interval(0.0, 1.0));
            let second = rectangle(interval(-3.0, 4.0), interval(0.0, 1.0));
            // Every other target is the product of two numbers in or next to the rectangles.
            let mut near = |rectangle: &Rectangle| {
                let mut part = |(low, high): (f64, f64)| low - 0.1 + (high - low + 0.2) * random();
                Complex64::new(part(rectangle.real), part(rectangle.imaginary))
            };
            let product = near(&first) * near(&second);
            let turn = if case % 2 == 0 { 1.0 } else { 2.0 * random() };
            let target = product * Complex64::from_polar(1.0, turn - 1.0);
            const POINTS: u32 = 160;
            let part =
                |(low, high): (f64, f64), i: u32| low + (high - low) * f64::from(i) / f64::from(POINTS);
            // How far the image of the first rectangle's points stays outside the second one.
            let mut gap = f64::INFINITY;
            for i in 0..=POINTS {
                for j in 0..=POINTS {
                    let u = target / Complex64::new(part(first.real, i), part(first.imaginary, j));
                    let outside = |(low, high): (f64, f64), x: f64| (low - x).max(x - high).max(0.0);
                    gap = gap.min(outside(second.real, u.re).hypot(outside(second.imaginary, u.im)));
                }
            }
            match factors_of(target, &first, &second) {
                Some([u, v]) => {
                    reached += 1;
                    assert!((u * v - target).norm() < 1e-9 && first.contains(u) && second.contains(v));
                    assert!(gap < 0.2, "{gap} {first:?} {second:?} {target}");
                }
                None => {
                    missed += 1;
                    assert!(gap > 0.0, "{first:?} {second:?} {target}");
                }
            }
        }
        assert!(reached > 60 && missed > 60, "{reached} {missed}");
    }

    #[test]
    fn law_a_sector_contains_its_points() {
        for i in 0..400 {
            let low = 0.037 * f64::from(i) - 7.0;
            let angle = (low, low + 0.011 * f64::from(i));
            let bounds = sector((0.5, 2.0), angle);
            for j in 0..=20 {
                let at = low + (angle.1 - low) * f64::from(j) / 20.0;
                for radius in [0.5, 1.3, 2.0] {
                    assert!(bounds.contains(Complex64::from_polar(radius, at)), "{angle:?} {at}");
                }
            }
        }
    }
}
