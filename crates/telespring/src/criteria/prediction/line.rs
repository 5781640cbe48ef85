//! The characteristic function of a loop with a predictor on the imaginary axis, with an unknown stiffness or age.

use num_complex::Complex64;

use super::loop_polynomials::{PredictedLoop, Quintic};
use crate::characteristic::ln_1p;
use crate::criteria::branch_and_bound::{
    FactorBox, LineFunction, Logarithm, Region, SideFactors, SideSlopes,
};
use crate::criteria::complex_box::{Interval, Rectangle};

/// What is unknown, and the value of the other one.
#[derive(Debug, Clone, Copy)]
pub(super) enum Unknown {
    /// The stiffness, at this age (s).
    Stiffness(f64),
    /// The age, at this stiffness (N/m).
    Age(f64),
}

/// The imaginary axis of a loop with a predictor.
#[derive(Debug, Clone, Copy)]
pub(super) struct PredictedLine<'a> {
    pub predicted: PredictedLoop<'a>,
    pub unknown: Unknown,
}

/// The coefficients of a polynomial over a box: each between its two ends.
type Band = [Interval; 6];

/// The band between two polynomials.
fn between(one: &Quintic, other: &Quintic) -> Band {
    std::array::from_fn(|power| Interval::between(one[power], other[power]))
}

/// A real polynomial at jω for all ω of an interval.
fn on_axis(band: &Band, omega: Interval) -> Rectangle {
    let square = Interval { low: -omega.high * omega.high, high: -omega.low * omega.low };
    let [c0, c1, c2, c3, c4, c5] = *band;
    Rectangle {
        re: c4.times(square).plus(c2).times(square).plus(c0),
        im: c5.times(square).plus(c3).times(square).plus(c1).times(omega),
    }
}

/// The derivative of a polynomial at jω by ω, j p′(jω).
fn slope_on_axis(band: &Band, omega: Interval) -> Rectangle {
    let mut derivative = [Interval::point(0.0); 6];
    for power in 1..6 {
        derivative[power - 1] = band[power].times(Interval::point(power as f64));
    }
    let Rectangle { re, im } = on_axis(&derivative, omega);
    Rectangle { re: Interval { low: -im.high, high: -im.low }, im: re }
}

/// A polynomial at a point jω.
fn at(polynomial: &Quintic, omega: f64) -> Complex64 {
    let s = Complex64::new(0.0, omega);
    polynomial.iter().rev().fold(Complex64::ZERO, |sum, &c| sum * s + c)
}

/// A bound on the terms of a polynomial at jω.
fn size(polynomial: &Quintic, omega: f64) -> f64 {
    polynomial.iter().rev().fold(0.0, |sum, c| sum * omega + c.abs())
}

impl PredictedLine<'_> {
    /// Stiffness (N/m) and age (s) where the unknown one has this value.
    fn point(&self, unknown: f64) -> (f64, f64) {
        match self.unknown {
            Unknown::Stiffness(age) => (unknown, age),
            Unknown::Age(stiffness) => (stiffness, unknown),
        }
    }
}

impl LineFunction for PredictedLine<'_> {
    /// The factors over a box of frequencies and of the unknown. Every coefficient is monotone in it.
    fn factors(&self, region: &Region) -> FactorBox {
        let omega = Interval { low: region.frequency.0, high: region.frequency.1 };
        let (low, high) = (self.point(region.parameter.0), self.point(region.parameter.1));
        let ages = Interval { low: low.1, high: high.1 };
        let predicted = &self.predicted;
        let bands = predicted.axis.sides.each_ref().map(|side| {
            let (one, other) = (predicted.side(side, low.0, low.1), predicted.side(side, high.0, high.1));
            (
                between(&one.alone, &other.alone),
                between(&one.coupling, &other.coupling),
                between(&one.whole, &other.whole),
            )
        });
        let sides = bands.each_ref().map(|(alone, coupling, whole)| SideFactors {
            alone: on_axis(alone, omega),
            coupling: on_axis(coupling, omega),
            whole: on_axis(whole, omega),
        });
        let by_frequency = bands.each_ref().map(|(alone, coupling, _)| SideSlopes {
            alone: slope_on_axis(alone, omega),
            coupling: slope_on_axis(coupling, omega),
        });
        let twice = Interval::point(2.0);
        let (slopes, turn) = match self.unknown {
            Unknown::Stiffness(age) => {
                let whole = |cubic: [f64; 4]| {
                    let band: Quintic = std::array::from_fn(|power| cubic.get(power).copied().unwrap_or(0.0));
                    on_axis(&between(&band, &band), omega)
                };
                let slopes = SideSlopes {
                    alone: whole(predicted.filter.missing(age)),
                    coupling: whole(predicted.filter.position(age)),
                };
                (slopes, Interval::point(0.0))
            }
            Unknown::Age(stiffness) => {
                let [one, other] = [ages.low, ages.high].map(|age| predicted.coupling_by_age(stiffness, age));
                let coupling = on_axis(&between(&one, &other), omega);
                let turned = |interval: Interval| Interval { low: -interval.high, high: -interval.low };
                let alone = Rectangle { re: turned(coupling.re), im: turned(coupling.im) };
                (SideSlopes { alone, coupling }, omega.times(twice))
            }
        };
        FactorBox {
            sides,
            turn: omega.times(ages).times(twice),
            by_frequency: (by_frequency, ages.times(twice)),
            by_parameter: ([slopes; 2], turn),
        }
    }

    /// L at a frequency and a value of the unknown.
    fn logarithm(&self, frequency: f64, unknown: f64) -> Logarithm {
        let (stiffness, age) = self.point(unknown);
        let turn = 2.0 * age * frequency;
        let (mut value, mut error) = (Complex64::new(0.0, turn), turn);
        for side in &self.predicted.axis.sides {
            let polynomials = self.predicted.side(side, stiffness, age);
            let coupling = at(&polynomials.coupling, frequency);
            let whole = at(&polynomials.whole, frequency);
            value += ln_1p(at(&polynomials.alone, frequency) / coupling);
            let spread = 1.0 + size(&polynomials.coupling, frequency) / coupling.norm();
            error += size(&polynomials.alone, frequency) * spread / whole.norm();
        }
        let error = 16.0 * f64::EPSILON * error;
        Logarithm { value, half_turns: 0, error: Complex64::new(error, error) }
    }

    /// The delayed term does not grow on the imaginary axis.
    fn log_growth(&self) -> f64 {
        0.0
    }

    /// The function is real at ω = 0.
    fn is_real_at(&self, frequency: f64) -> bool {
        frequency == 0.0
    }

    /// Crossings are wanted everywhere.
    fn is_excluded(&self, _: &Region) -> bool {
        false
    }
}
