//! Intervals with the intervals of their first derivatives: the mean value theorem then bounds a function over a cell with
//! an error of second order in its width.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::ops::{Add, Mul, Sub};

use crate::criteria::complex_box::Interval;

/// The values of a function over a cell, and of its derivatives in N directions.
#[derive(Debug, Clone, Copy)]
pub(super) struct Jet<const N: usize> {
    pub value: Interval,
    pub slopes: [Interval; N],
}

/// The interval of no width at 0.
const ZERO: Interval = Interval { low: 0.0, high: 0.0 };

/// An interval's square.
pub(super) fn square(x: Interval) -> Interval {
    let (low, high) = (x.low * x.low, x.high * x.high);
    let least = if x.low <= 0.0 && x.high >= 0.0 { 0.0 } else { low.min(high) };
    Interval { low: least, high: low.max(high) }
}

/// The difference of two intervals.
pub(super) fn minus(x: Interval, y: Interval) -> Interval {
    Interval { low: x.low - y.high, high: x.high - y.low }
}

/// The cosines of an interval of angles.
pub(super) fn cosine(angle: Interval) -> Interval {
    if angle.high - angle.low >= TAU {
        return Interval { low: -1.0, high: 1.0 };
    }
    let mut hull = Interval::between(angle.low.cos(), angle.high.cos());
    if (angle.low / TAU).ceil() <= (angle.high / TAU).floor() {
        hull.high = 1.0;
    }
    if ((angle.low - PI) / TAU).ceil() <= ((angle.high - PI) / TAU).floor() {
        hull.low = -1.0;
    }
    hull
}

/// The sines of an interval of angles.
pub(super) fn sine(angle: Interval) -> Interval {
    cosine(Interval { low: angle.low - FRAC_PI_2, high: angle.high - FRAC_PI_2 })
}

/// An interval times a number.
fn times(x: Interval, by: f64) -> Interval {
    Interval::between(by * x.low, by * x.high)
}

impl<const N: usize> Jet<N> {
    /// A number.
    pub fn constant(value: f64) -> Self {
        Self { value: Interval::point(value), slopes: [ZERO; N] }
    }

    /// The variable of a direction over a range; a constant range where the direction is not one of the N.
    pub fn variable(direction: usize, (low, high): (f64, f64)) -> Self {
        let mut slopes = [ZERO; N];
        if let Some(slope) = slopes.get_mut(direction) {
            *slope = Interval::point(1.0);
        }
        Self { value: Interval { low, high }, slopes }
    }

    /// A function of this one with its derivative.
    fn chained(self, value: Interval, derivative: Interval) -> Self {
        Self { value, slopes: self.slopes.map(|slope| slope.times(derivative)) }
    }

    pub fn scaled(self, by: f64) -> Self {
        Self { value: times(self.value, by), slopes: self.slopes.map(|slope| times(slope, by)) }
    }

    pub fn squared(self) -> Self {
        self.chained(square(self.value), times(self.value, 2.0))
    }

    /// 1/x of a positive function.
    pub fn inverse(self) -> Self {
        let value = Interval { low: 1.0 / self.value.high, high: 1.0 / self.value.low };
        self.chained(value, Interval { low: -value.high * value.high, high: -value.low * value.low })
    }

    pub fn cosine(self) -> Self {
        self.chained(cosine(self.value), times(sine(self.value), -1.0))
    }

    pub fn sine(self) -> Self {
        self.chained(sine(self.value), cosine(self.value))
    }
}

impl<const N: usize> Add for Jet<N> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let mut slopes = self.slopes;
        for (slope, more) in slopes.iter_mut().zip(other.slopes) {
            *slope = slope.plus(more);
        }
        Self { value: self.value.plus(other.value), slopes }
    }
}

impl<const N: usize> Sub for Jet<N> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        let mut slopes = self.slopes;
        for (slope, less) in slopes.iter_mut().zip(other.slopes) {
            *slope = minus(*slope, less);
        }
        Self { value: minus(self.value, other.value), slopes }
    }
}

impl<const N: usize> Mul for Jet<N> {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let mut slopes = self.slopes;
        for (slope, theirs) in slopes.iter_mut().zip(other.slopes) {
            *slope = slope.times(other.value).plus(theirs.times(self.value));
        }
        Self { value: self.value.times(other.value), slopes }
    }
}
