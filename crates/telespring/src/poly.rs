//! Positive real roots of polynomials of low degree; none is missed.
//!
//! Between two neighbouring roots of its derivative a polynomial is monotone. The signs there decide
//! whether a root lies between them, and a bracketed Halley iteration finds it. A sign counts only if the
//! value exceeds a bound on its rounding error. Otherwise, as next to a tangency, the search is repeated in
//! double-double arithmetic.

use std::ops::{Add, Mul, Neg, Sub};

use twofloat::TwoFloat;

/// The arithmetic of a root search.
pub(crate) trait Real:
    Copy
    + PartialOrd
    + From<f64>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Neg<Output = Self>
{
    /// Relative rounding error of one operation.
    const EPSILON: f64;
    /// Relative Halley step below which the next error is below `EPSILON`: the iteration is cubic.
    const SETTLED: f64;
    /// The value in f64, from the number type of the polynomial.
    fn to_f64(self) -> f64;
    /// The quotient in the number type of the polynomial.
    fn divided_by(self, divisor: Self) -> Self;
    /// The square root in the number type of the polynomial.
    fn sqrt(self) -> Self;
}

impl Real for f64 {
    const EPSILON: f64 = f64::EPSILON;
    const SETTLED: f64 = 1e-6;
    /// The value in f64: itself.
    fn to_f64(self) -> f64 {
        self
    }
    /// The quotient in f64.
    #[inline(always)]
    fn divided_by(self, divisor: Self) -> Self {
        self / divisor
    }
    /// The square root in f64.
    fn sqrt(self) -> Self {
        self.sqrt()
    }
}

impl Real for TwoFloat {
    const EPSILON: f64 = 1e-30;
    const SETTLED: f64 = 1e-11;
    /// The value in f64 of a double-double number.
    fn to_f64(self) -> f64 {
        self.into()
    }
    /// The quotient of two double-double numbers: Algorithm 17 of Joldes, Muller and Popescu (ACM TOMS 44,
    /// 2017), with a relative error below 1e-31. The crate's own division forms 1 − y (1/y) in f64, without
    /// the fused multiplication that the algorithm asks for, and has 16 digits only.
    fn divided_by(self, divisor: Self) -> Self {
        let quotient = self.hi() / divisor.hi();
        if !quotient.is_finite() || quotient == 0.0 {
            return Self::from(quotient);
        }
        let rest = self - divisor * quotient;
        Self::new_add(quotient, rest.hi() / divisor.hi())
    }
    /// The square root of a double-double number.
    fn sqrt(self) -> Self {
        self.sqrt()
    }
}

/// A polynomial by its coefficients, constant term first. `magnitude` is the sum of the absolute terms that
/// formed each coefficient, which is known to a few `EPSILON` of that sum.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Polynomial<R, const N: usize> {
    pub coefficient: [R; N],
    pub magnitude: [f64; N],
}

/// A positive real root; `slope` is the sign of the derivative there, 0 at a tangency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Root<R> {
    pub at: R,
    pub slope: i8,
}

/// The positive roots in ascending order.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Roots<R, const N: usize> {
    items: [Root<R>; N],
    length: usize,
}

impl<R: Real, const N: usize> Roots<R, N> {
    /// An empty list of roots.
    fn none() -> Self {
        Self { items: [Root { at: R::from(0.0), slope: 0 }; N], length: 0 }
    }

    /// Appends a root of the polynomial.
    fn push(&mut self, at: R, slope: i8) {
        self.items[self.length] = Root { at, slope };
        self.length += 1;
    }
}

impl<R, const N: usize> std::ops::Deref for Roots<R, N> {
    type Target = [Root<R>];
    /// The roots of a polynomial as a slice.
    fn deref(&self) -> &[Root<R>] {
        &self.items[..self.length]
    }
}

/// How to treat a value smaller than its rounding error.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum UncertainSign {
    /// Stop, so that the caller repeats the search in a finer arithmetic.
    GiveUp,
    /// Treat it as zero.
    Zero,
}

/// A simple root is recomputed in double-double if its error bound, about 16 times the usual error, exceeds
/// this relative value.
const ROOT_ACCURACY: f64 = 2e-12;

/// An upper bracket end that stands for infinity.
const FAR: f64 = 1e300;

/// The positive roots of a polynomial: in f64 if every sign is certain, else in double-double.
///
/// `precise` forms the same polynomial in double-double from the same data.
pub(crate) fn positive_roots<const N: usize>(
    polynomial: &Polynomial<f64, N>,
    precise: impl FnOnce() -> Polynomial<TwoFloat, N>,
) -> Roots<f64, N> {
    let mut roots = Roots::none();
    if isolate_roots(polynomial, 0, N, UncertainSign::GiveUp, &mut roots).is_none() {
        roots.length = 0;
        let mut fine = Roots::none();
        let resolved = isolate_roots(&precise(), 0, N, UncertainSign::Zero, &mut fine);
        debug_assert!(resolved.is_some(), "only UncertainSign::GiveUp ends a search early");
        for root in fine.iter() {
            roots.push(root.at.to_f64(), root.slope);
        }
    }
    roots
}

impl<R: Real, const N: usize> Polynomial<R, N> {
    /// The value at `x` > 0 of the polynomial with coefficients `low..high`, and a bound on its error.
    #[inline(always)]
    fn value(&self, low: usize, high: usize, x: R) -> (R, f64) {
        let at = x.to_f64();
        let mut value = self.coefficient[high - 1];
        let mut magnitude = self.magnitude[high - 1];
        for i in (low..high - 1).rev() {
            value = value * x + self.coefficient[i];
            magnitude = magnitude * at + self.magnitude[i];
        }
        (value, 16.0 * R::EPSILON * magnitude)
    }

    /// The sign of the polynomial at `x`, 0 if uncertain.
    fn sign_at(&self, low: usize, high: usize, x: R) -> i8 {
        let (value, bound) = self.value(low, high, x);
        if bound.is_finite() { sign_of(value, bound) } else { self.sign_at_large(low, high, x) }
    }

    /// The sign at an `x` whose powers overflow, from the value divided by the highest power.
    #[cold]
    fn sign_at_large(&self, low: usize, high: usize, x: R) -> i8 {
        let reciprocal = R::from(1.0).divided_by(x);
        let mut value = self.coefficient[low];
        let mut magnitude = self.magnitude[low];
        for i in low + 1..high {
            value = value * reciprocal + self.coefficient[i];
            magnitude = magnitude * reciprocal.to_f64() + self.magnitude[i];
        }
        sign_of(value, 16.0 * R::EPSILON * magnitude)
    }

    /// The sign of a coefficient of the polynomial, 0 if uncertain.
    fn coefficient_sign(&self, i: usize) -> i8 {
        sign_of(self.coefficient[i], 16.0 * R::EPSILON * self.magnitude[i])
    }

    /// The derivative of the polynomial with coefficients `low..high`.
    fn derivative(&self, low: usize, high: usize) -> Self {
        let mut derivative = *self;
        for i in low + 1..high {
            let power = (i - low) as f64;
            derivative.coefficient[i] = self.coefficient[i] * R::from(power);
            derivative.magnitude[i] = self.magnitude[i] * power;
        }
        derivative
    }
}

/// Appends the positive roots of the polynomial with coefficients `low..high`, constant term first; `None`
/// if a sign is uncertain and [`UncertainSign::GiveUp`] is set.
fn isolate_roots<R: Real, const N: usize>(
    p: &Polynomial<R, N>,
    mut low: usize,
    mut high: usize,
    uncertain: UncertainSign,
    roots: &mut Roots<R, N>,
) -> Option<()> {
    // A zero constant term is a root at 0, a zero leading coefficient a root at infinity: neither is
    // positive.
    while low < high && p.coefficient_sign(low) == 0 {
        if uncertain == UncertainSign::GiveUp && p.magnitude[low] != 0.0 {
            return None;
        }
        low += 1;
    }
    while low < high && p.coefficient_sign(high - 1) == 0 {
        if uncertain == UncertainSign::GiveUp && p.magnitude[high - 1] != 0.0 {
            return None;
        }
        high -= 1;
    }
    if high - low < 2 {
        return Some(());
    }
    let first = p.coefficient_sign(low);
    let last = p.coefficient_sign(high - 1);

    // Descartes' rule of signs: no sign change means no positive root, one sign change exactly one.
    let (changes, certain) = match (&p.coefficient[low..high], &p.magnitude[low..high]) {
        // A length known at compile time lets the compiler unroll the count.
        ([c0, c1, c2, c3], [m0, m1, m2, m3]) => sign_changes(&[*c0, *c1, *c2, *c3], &[*m0, *m1, *m2, *m3]),
        (coefficients, magnitudes) => sign_changes(coefficients, magnitudes),
    };
    if certain && changes == 0 {
        return Some(());
    }
    let one_root = certain && changes == 1;

    if high - low == 2 {
        let at = -p.coefficient[low].divided_by(p.coefficient[low + 1]);
        if at.to_f64().is_finite() {
            roots.push(at, last);
        }
        return Some(());
    }
    if high - low == 3
        && let Some(certain) = quadratic_roots(p, low, last)
    {
        let accurate = |root: &Root<R>| {
            let slope = quadratic_slope(&p.coefficient[low..high], root.at);
            uncertain == UncertainSign::Zero || is_accurate(p, low, high, root.at, slope)
        };
        if !certain.iter().all(accurate) {
            return None;
        }
        certain.iter().for_each(|root| roots.push(root.at, root.slope));
        return Some(());
    }
    if one_root {
        roots.push(root_in_bracket(p, low, high, R::from(0.0), R::from(FAR), first, uncertain)?, last);
        return Some(());
    }
    let mut splits = Roots::none();
    isolate_roots(&p.derivative(low, high), low + 1, high, UncertainSign::Zero, &mut splits)?;

    // The last interval is open: extend its upper end until the leading term dominates.
    let start = splits.last().map_or_else(|| typical_root(p, low, high), |s| s.at * R::from(2.0));
    let mut outer = start;
    while p.sign_at(low, high, outer) != last {
        let farther = outer * R::from(16.0);
        if !farther.to_f64().is_finite() {
            if uncertain == UncertainSign::GiveUp {
                return None;
            }
            // A root beyond the largest number does not count.
            break;
        }
        outer = farther;
    }

    let mut left = R::from(0.0);
    let mut left_sign = first;
    let mut touching: Option<R> = None;
    for split in splits.iter().map(|root| root.at).chain(std::iter::once(outer)) {
        let sign = p.sign_at(low, high, split);
        if sign == 0 {
            if uncertain == UncertainSign::GiveUp {
                return None;
            }
            touching.get_or_insert(split);
            continue;
        }
        match touching.take() {
            Some(at) => roots.push(at, if sign == left_sign { 0 } else { sign }),
            None if sign != left_sign => {
                let at = root_in_bracket(p, low, high, left, split, left_sign, uncertain)?;
                roots.push(at, sign);
            }
            None => {}
        }
        left = split;
        left_sign = sign;
    }
    Some(())
}

/// The sign of a polynomial's value with an error bound; 0 if uncertain.
#[inline(always)]
fn sign_of<R: Real>(value: R, bound: f64) -> i8 {
    let value = value.to_f64();
    i8::from(value > bound) - i8::from(value < -bound)
}

/// The number of sign changes of a polynomial's coefficients, and whether every sign is certain.
#[inline(always)]
fn sign_changes<R: Real>(coefficients: &[R], magnitudes: &[f64]) -> (u32, bool) {
    let mut changes = 0;
    let mut certain = true;
    let mut previous = 0;
    for (&coefficient, &magnitude) in coefficients.iter().zip(magnitudes) {
        let sign = sign_of(coefficient, 16.0 * R::EPSILON * magnitude);
        certain &= sign != 0 || magnitude == 0.0;
        changes += u32::from(sign * previous < 0);
        previous = if sign == 0 { previous } else { sign };
    }
    (changes, certain)
}

/// A starting scale for a polynomial: a power of two near the geometric mean of the root magnitudes.
#[inline(always)]
fn typical_root<R: Real, const N: usize>(p: &Polynomial<R, N>, low: usize, high: usize) -> R {
    let exponent = |x: f64| ((x.to_bits() >> 52) & 0x7ff) as i64;
    let ratio = exponent(p.coefficient[low].to_f64()) - exponent(p.coefficient[high - 1].to_f64());
    let power = ratio / (high - 1 - low) as i64;
    R::from(f64::from_bits(((1023 + power) as u64) << 52))
}

/// The positive roots of a quadratic in closed form; `None` if the sign of its discriminant is uncertain.
fn quadratic_roots<R: Real, const N: usize>(
    p: &Polynomial<R, N>,
    low: usize,
    last: i8,
) -> Option<Roots<R, N>> {
    let [c, b, a] = [0, 1, 2].map(|i| p.coefficient[low + i]);
    let [c_size, b_size, a_size] = [0, 1, 2].map(|i| p.magnitude[low + i]);
    let discriminant = b * b - R::from(4.0) * a * c;
    let size = b_size * b_size + 4.0 * a_size * c_size;
    let sign = sign_of(discriminant, 64.0 * R::EPSILON * size);
    // Beyond this range, products overflow or lose digits.
    if sign == 0 || !(1e-250..1e250).contains(&size) {
        return None;
    }
    let mut roots = Roots::none();
    if sign < 0 {
        return Some(roots);
    }
    let zero = R::from(0.0);
    let square_root = discriminant.sqrt();
    let sum = if b < zero { b - square_root } else { b + square_root } * R::from(-0.5);
    let (one, other) = (sum.divided_by(a), c.divided_by(sum));
    let (smaller, larger) = if one < other { (one, other) } else { (other, one) };
    for (at, slope) in [(smaller, -last), (larger, last)] {
        if at > zero && at.to_f64().is_finite() {
            roots.push(at, slope);
        }
    }
    Some(roots)
}

/// The derivative of a quadratic polynomial.
fn quadratic_slope<R: Real>(coefficients: &[R], x: R) -> f64 {
    coefficients[1].to_f64() + 2.0 * coefficients[2].to_f64() * x.to_f64()
}

/// Whether the rounding error of the polynomial's value displaces a root by less than [`ROOT_ACCURACY`].
#[inline(always)]
fn is_accurate<R: Real, const N: usize>(
    p: &Polynomial<R, N>,
    low: usize,
    high: usize,
    at: R,
    slope: f64,
) -> bool {
    p.value(low, high, at).1 <= ROOT_ACCURACY * (slope * at.to_f64()).abs()
}

/// The polynomial's root between `left` (sign `left_sign`) and `right`, by a bracketed Halley iteration.
fn root_in_bracket<R: Real, const N: usize>(
    p: &Polynomial<R, N>,
    low: usize,
    high: usize,
    left: R,
    right: R,
    left_sign: i8,
    uncertain: UncertainSign,
) -> Option<R> {
    let typical = typical_root(p, low, high);
    let start = if typical > left && typical <= right { typical } else { point_in_bracket(left, right) };
    let (at, slope) = match p.coefficient[low..high] {
        // A length known at compile time lets the compiler unroll the evaluation.
        [c0, c1, c2, c3] => halley(&[c0, c1, c2, c3], left, right, left_sign, start),
        ref coefficients => halley(coefficients, left, right, left_sign, start),
    };
    // A slope of 0 means that the iteration did not converge.
    let trusted = uncertain == UncertainSign::Zero || is_accurate(p, low, high, at, slope);
    trusted.then_some(at)
}

/// A point well inside a bracket of a polynomial's root: the geometric mean if it spans decades.
fn point_in_bracket<R: Real>(left: R, right: R) -> R {
    if right >= R::from(FAR) {
        left * R::from(16.0)
    } else if left <= R::from(0.0) {
        right * R::from(0.0625)
    } else if right > left * R::from(4.0) {
        (left * right).sqrt()
    } else {
        (left + right) * R::from(0.5)
    }
}

/// Halley's iteration for a polynomial: the root and the derivative next to it, 0 if it did not converge.
#[inline(always)]
fn halley<R: Real>(coefficients: &[R], mut left: R, mut right: R, left_sign: i8, mut x: R) -> (R, f64) {
    let zero = R::from(0.0);
    let mut previous = f64::INFINITY;
    // Every second step at least halves the bracket; the limit only guards the loop.
    for _ in 0..2200 {
        let (mut value, mut slope, mut curvature) = (zero, zero, zero);
        for &coefficient in coefficients.iter().rev() {
            curvature = curvature * x + slope;
            slope = slope * x + value;
            value = value * x + coefficient;
        }
        if (value.to_f64() < 0.0) == (left_sign < 0) {
            left = x;
        } else {
            right = x;
        }
        // `curvature` is half of the second derivative.
        let square = slope * slope;
        let bend = value * curvature;
        let step = (value * slope).divided_by(square - bend);
        let mut next = x - step;
        let size = step.to_f64().abs();
        let inner = next > left && next < right;
        if inner && size <= R::SETTLED * x.to_f64() && bend.to_f64().abs() <= R::SETTLED * square.to_f64() {
            return (next, slope.to_f64());
        }
        if !inner || size > 0.7 * previous {
            next = point_in_bracket(left, right);
            previous = f64::INFINITY;
        } else {
            previous = size;
        }
        if next == left || next == right || next == x {
            return (next, slope.to_f64());
        }
        x = next;
    }
    (x, 0.0)
}

#[cfg(test)]
mod tests;
