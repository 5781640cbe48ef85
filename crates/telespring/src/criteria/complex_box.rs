//! Sets of complex numbers that enclose the factors of a characteristic function over a box.
//!
//! A rectangle is exact for factors whose real and imaginary parts are monotone. A disc is simple to multiply
//! and to invert, which is all that the derivatives need.

use std::f64::consts::{PI, TAU};

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
    pub fn times(self, other: Self) -> Self {
        let products =
            [self.low * other.low, self.low * other.high, self.high * other.low, self.high * other.high];
        products.into_iter().fold(Self::point(products[0]), |hull, product| Self {
            low: hull.low.min(product),
            high: hull.high.max(product),
        })
    }

    /// The interval widened by a distance on both sides.
    pub fn widened(self, distance: f64) -> Self {
        Self { low: self.low - distance, high: self.high + distance }
    }

    /// The smallest and the largest absolute value.
    fn absolute(self) -> (f64, f64) {
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

    /// An interval that holds the arguments of all numbers, up to whole turns; a whole turn if 0 lies inside.
    pub fn argument(&self) -> Interval {
        let Self { re, im } = *self;
        let corner = |at_real: f64, at_imaginary: f64| at_imaginary.atan2(at_real);
        if im.low >= 0.0 {
            // The upper half-plane: the right edge has the smallest argument.
            let low = corner(re.high, if re.high > 0.0 { im.low } else { im.high });
            let high = corner(re.low, if re.low > 0.0 { im.high } else { im.low });
            return Interval { low, high };
        }
        if im.high <= 0.0 {
            let Interval { low, high } =
                Self { re, im: Interval { low: -im.high, high: -im.low } }.argument();
            return Interval { low: -high, high: -low };
        }
        if re.low > 0.0 {
            return Interval { low: corner(re.low, im.low), high: corner(re.low, im.high) };
        }
        if re.high < 0.0 {
            return Interval { low: corner(re.high, im.high), high: corner(re.high, im.low) + TAU };
        }
        Interval { low: -PI, high: PI }
    }
}

/// All complex numbers within a distance of a centre.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Disc {
    pub centre: Complex64,
    pub radius: f64,
}

impl Disc {
    /// The smallest disc around a rectangle.
    pub fn around(rectangle: &Rectangle) -> Self {
        let Rectangle { re, im } = *rectangle;
        Self {
            centre: Complex64::new(0.5 * (re.low + re.high), 0.5 * (im.low + im.high)),
            radius: (0.5 * (re.high - re.low)).hypot(0.5 * (im.high - im.low)),
        }
    }

    /// The sum of two discs.
    pub fn plus(self, other: Self) -> Self {
        Self { centre: self.centre + other.centre, radius: self.radius + other.radius }
    }

    /// The difference of two discs.
    pub fn minus(self, other: Self) -> Self {
        Self { centre: self.centre - other.centre, radius: self.radius + other.radius }
    }

    /// A disc that holds all products of two discs.
    pub fn times(self, other: Self) -> Self {
        Self {
            centre: self.centre * other.centre,
            radius: self.centre.norm() * other.radius
                + other.centre.norm() * self.radius
                + self.radius * other.radius,
        }
    }

    /// The reciprocals of all numbers of the disc; `None` if 0 is one of them.
    pub fn reciprocal(self) -> Option<Self> {
        let size = self.centre.norm();
        // Factored, so that neither square overflows.
        let gap = (size - self.radius) * (1.0 + self.radius / size);
        (gap > 0.0)
            .then(|| Self { centre: self.centre.conj() / size / gap, radius: self.radius / size / gap })
    }
}
