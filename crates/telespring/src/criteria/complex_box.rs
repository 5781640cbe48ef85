//! Sets of complex numbers that enclose the factors of a characteristic function over a box.
//!
//! A rectangle is exact for factors whose real and imaginary parts are monotone. It bounds each part by itself:
//! next to an undamped motion one part is smaller than the other by many decades.

use std::f64::consts::PI;

use num_complex::Complex64;

/// A closed interval of real numbers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Interval {
    pub low: f64,
    pub high: f64,
}

impl Interval {
    /// The interval that holds one number.
    pub fn point(value: f64) -> Self {
        Self { low: value, high: value }
    }

    /// The interval between two numbers in any order.
    pub fn between(a: f64, b: f64) -> Self {
        Self { low: a.min(b), high: a.max(b) }
    }

    /// The smallest interval that holds all sums of two numbers.
    pub fn plus(self, other: Self) -> Self {
        Self { low: self.low + other.low, high: self.high + other.high }
    }

    /// The smallest interval that holds all products of two numbers.
    #[inline]
    pub fn times(self, other: Self) -> Self {
        if self.low >= 0.0 && other.low >= 0.0 {
            return Self { low: self.low * other.low, high: self.high * other.high };
        }
        let products =
            [self.low * other.low, self.low * other.high, self.high * other.low, self.high * other.high];
        products.into_iter().fold(Self::point(products[0]), |hull, product| Self {
            low: if product < hull.low { product } else { hull.low },
            high: if product > hull.high { product } else { hull.high },
        })
    }

    /// The negatives of all numbers.
    pub fn turned(self) -> Self {
        Self { low: -self.high, high: -self.low }
    }

    /// The interval widened by a distance on both sides.
    pub fn widened(self, distance: f64) -> Self {
        Self { low: self.low - distance, high: self.high + distance }
    }

    /// The smallest and the largest absolute value.
    pub fn absolute(self) -> (f64, f64) {
        let high = self.low.abs().max(self.high.abs());
        let low = if self.low <= 0.0 && self.high >= 0.0 { 0.0 } else { self.low.abs().min(self.high.abs()) };
        (low, high)
    }
}

/// All complex numbers with a real and an imaginary part in two intervals.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rectangle {
    pub re: Interval,
    pub im: Interval,
}

impl Rectangle {
    /// The rectangle that holds one number.
    pub fn point(value: Complex64) -> Self {
        Self { re: Interval::point(value.re), im: Interval::point(value.im) }
    }

    /// The smallest and the largest modulus.
    pub fn modulus(&self) -> (f64, f64) {
        let (re, im) = (self.re.absolute(), self.im.absolute());
        (re.0.hypot(im.0), re.1.hypot(im.1))
    }

    /// The arguments of all numbers, up to whole turns; a whole turn if 0 lies inside.
    pub fn argument(&self) -> Argument {
        let Self { re, im } = *self;
        if re.high < 0.0 {
            // Next to the negative axis the rest of a half turn keeps its digits.
            let opposite = Self { re: re.turned(), im: im.turned() };
            return Argument { half_turns: 1, rest: opposite.principal_argument() };
        }
        Argument { half_turns: 0, rest: self.principal_argument() }
    }

    /// The arguments of all numbers of a rectangle that does not lie left of the imaginary axis.
    fn principal_argument(&self) -> Interval {
        let Self { re, im } = *self;
        let corner = |at_real: f64, at_imaginary: f64| at_imaginary.atan2(at_real);
        if im.low == 0.0 && im.high == 0.0 && re.low > 0.0 {
            return Interval::point(0.0);
        }
        if im.low >= 0.0 {
            // The upper half-plane: the right edge has the smallest argument.
            let low = corner(re.high, if re.high > 0.0 { im.low } else { im.high });
            let high = corner(re.low, if re.low > 0.0 { im.high } else { im.low });
            return Interval { low, high };
        }
        if im.high <= 0.0 {
            return Self { re, im: im.turned() }.principal_argument().turned();
        }
        if re.low > 0.0 {
            return Interval { low: corner(re.low, im.low), high: corner(re.low, im.high) };
        }
        Interval { low: -PI, high: PI }
    }

    /// The sum of two rectangles.
    pub fn plus(self, other: Self) -> Self {
        Self { re: self.re.plus(other.re), im: self.im.plus(other.im) }
    }

    /// The difference of two rectangles.
    pub fn minus(self, other: Self) -> Self {
        Self { re: self.re.plus(other.re.turned()), im: self.im.plus(other.im.turned()) }
    }

    /// A rectangle that holds all products of two rectangles.
    pub fn times(self, other: Self) -> Self {
        Self {
            re: self.re.times(other.re).plus(self.im.times(other.im).turned()),
            im: self.re.times(other.im).plus(self.im.times(other.re)),
        }
    }

    /// The smallest rectangle that holds the reciprocals of all numbers; `None` if 0 is one of them.
    pub fn reciprocal(self) -> Option<Self> {
        let Self { re, im } = self;
        if im.low == 0.0 && im.high == 0.0 && re.low > 0.0 {
            return Some(Self { re: Interval { low: 1.0 / re.high, high: 1.0 / re.low }, im });
        }
        let is_zero_inside = re.low <= 0.0 && re.high >= 0.0 && im.low <= 0.0 && im.high >= 0.0;
        (!is_zero_inside)
            .then(|| Self { re: part_of_reciprocal(re, im), im: part_of_reciprocal(im, re).turned() })
    }

    /// The centre of a rectangle.
    pub fn centre(&self) -> Complex64 {
        Complex64::new(0.5 * (self.re.low + self.re.high), 0.5 * (self.im.low + self.im.high))
    }

    /// Half of the width of both parts of a rectangle.
    pub fn radii(&self) -> (f64, f64) {
        (0.5 * (self.re.high - self.re.low), 0.5 * (self.im.high - self.im.low))
    }
}

/// The range of a/(a² + b²), one part of the reciprocal of the numbers of a rectangle without 0.
fn part_of_reciprocal(a: Interval, b: Interval) -> Interval {
    let (nearest, farthest) = b.absolute();
    // Divided by the larger one, so that no square overflows.
    let value = |a: f64, b: f64| {
        if a.abs() >= b { 1.0 / (a + b * (b / a)) } else { (a / b) / (a * (a / b) + b) }
    };
    // Over b the largest modulus lies at the smallest |b|; over a it lies at |a| = |b|.
    let largest = |low: f64, high: f64| value(nearest.clamp(low, high), nearest);
    let smallest = |low: f64, high: f64| value(low, farthest).min(value(high, farthest));
    if a.low >= 0.0 {
        Interval { low: smallest(a.low, a.high), high: largest(a.low, a.high) }
    } else if a.high <= 0.0 {
        Interval { low: -largest(-a.high, -a.low), high: -smallest(-a.high, -a.low) }
    } else {
        Interval { low: -largest(0.0, -a.low), high: largest(0.0, a.high) }
    }
}

/// The arguments of a set of numbers: a whole number of half turns and the rest, so that the rest keeps its digits
/// next to the negative axis.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Argument {
    pub half_turns: i32,
    pub rest: Interval,
}

impl Argument {
    /// The difference of two arguments.
    pub fn minus(self, other: Self) -> Self {
        Self { half_turns: self.half_turns - other.half_turns, rest: self.rest.plus(other.rest.turned()) }
    }

    /// The sum of two arguments.
    pub fn plus(self, other: Self) -> Self {
        Self { half_turns: self.half_turns + other.half_turns, rest: self.rest.plus(other.rest) }
    }

    /// The width of the rest.
    pub fn width(&self) -> f64 {
        self.rest.high - self.rest.low
    }
}
