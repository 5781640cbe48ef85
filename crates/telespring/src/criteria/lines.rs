//! The characteristic function on a vertical line, with an unknown stiffness or an unknown added damping.
//!
//! At s = −σ + jω the factors are N = Pᵢ(s), D = k + c s (twice) and the growth e^(σT). With an unknown
//! stiffness the other variable is x = ω/√(k + k_h) with the ground stiffness k_h of one side. The resonance of
//! that side, and those of both under a stiff spring, then stay at one x for all k, and a box of x and k can be
//! as long in k as it is narrow in x.

use num_complex::Complex64;

use super::branch_and_bound::{FactorBox, LineFunction, Logarithm, Region, SideFactors, SideSlopes};
use super::complex_box::{Interval, Rectangle};
use crate::characteristic::ln_1p;
use crate::model::{DyadAxis, Side};

/// The line Re s = −σ of one axis at a round-trip delay.
#[derive(Debug, Clone, Copy)]
struct Line<'a> {
    axis: &'a DyadAxis,
    round_trip: f64,
    decay_rate: f64,
}

impl Line<'_> {
    /// L at a frequency, a stiffness and an added damping.
    fn logarithm(&self, frequency: f64, stiffness: f64, added: f64) -> Logarithm {
        let (sigma, c) = (self.decay_rate, self.axis.coupling_damping);
        let coupling = Complex64::new(stiffness - c * sigma, c * frequency);
        let size = frequency.hypot(sigma);
        let turn = frequency * self.round_trip;
        let mut value = Complex64::new(-sigma * self.round_trip, turn);
        let mut error = Complex64::new(sigma * self.round_trip, turn);
        let mut half_turns = 0;
        for side in &self.axis.sides {
            let (m, b) = (side.mass, side.damping + added);
            let alone = Complex64::new(
                side.ground_stiffness + (m * sigma - b) * sigma - m * frequency * frequency,
                frequency * (b - 2.0 * m * sigma),
            );
            let whole = alone + coupling;
            let terms = (m * size + b) * size + side.ground_stiffness;
            // Rounding in A and in D changes ln(1 + A/D) by the relative error of either times A/N.
            let spread = 1.0 + (stiffness + c * size) / coupling.norm();
            let by_ratio = terms * spread / whole.norm();
            value.re += ln_1p(alone / coupling).re;
            error.re += by_ratio;
            // The arguments of N and D by themselves: only the real part of N cancels.
            let is_left = whole.re < 0.0;
            let own = if is_left { -whole } else { whole };
            let (of_whole, of_coupling) = (own.arg(), coupling.arg());
            let (real, imaginary) = (terms + stiffness + c * sigma, frequency * (b + c + 2.0 * m * sigma));
            let lost = (real * whole.im.abs() + imaginary * whole.re.abs()) / whole.norm_sqr();
            let by_arguments = lost + of_whole.abs() + of_coupling.abs();
            if by_arguments < by_ratio {
                half_turns += i32::from(is_left);
                value.im += of_whole - of_coupling;
                error.im += by_arguments;
            } else {
                value.im += ln_1p(alone / coupling).im;
                error.im += by_ratio;
            }
        }
        Logarithm { value, half_turns, error: error * (4.0 * f64::EPSILON) }
    }
}

/// An imaginary number in the factors of a line.
fn imaginary(im: Interval) -> Rectangle {
    Rectangle { re: Interval::point(0.0), im }
}

/// A scale of frequencies that moves with the stiffness: ω = x √(f k + r).
#[derive(Debug, Clone, Copy)]
pub(super) struct FrequencyScale {
    /// f: 1, or 0 where x is the frequency itself.
    follow: f64,
    /// r: a ground stiffness, N/m; 1 where x is the frequency itself.
    reference: f64,
}

impl FrequencyScale {
    /// x is the frequency itself, rad/s.
    pub const FIXED: Self = Self { follow: 0.0, reference: 1.0 };

    /// x = ω/√(k + k_h): a resonance of a side with this ground stiffness stays at one x.
    pub fn following(ground_stiffness: f64) -> Self {
        Self { follow: 1.0, reference: ground_stiffness }
    }

    /// ω²/x² at a stiffness (N/m).
    pub fn square(&self, stiffness: f64) -> f64 {
        self.follow * stiffness + self.reference
    }
}

/// A band of frequencies in some scale.
#[derive(Debug, Clone, Copy)]
pub(super) struct Band {
    pub scale: FrequencyScale,
    pub ends: (f64, f64),
}

/// The characteristic function on Re s = −σ as a function of x = ω/√(f k + r) and the stiffness, without some
/// bands of frequencies.
#[derive(Debug, Clone)]
pub(super) struct StiffnessLine<'a> {
    line: Line<'a>,
    pub scale: FrequencyScale,
    pub excluded: Vec<Band>,
}

impl<'a> StiffnessLine<'a> {
    /// The line Re s = −`decay_rate` (1/s) of an axis with an unknown stiffness.
    pub fn new(axis: &'a DyadAxis, round_trip: f64, decay_rate: f64, scale: FrequencyScale) -> Self {
        Self { line: Line { axis, round_trip, decay_rate }, scale, excluded: Vec::new() }
    }
}

impl LineFunction for StiffnessLine<'_> {
    /// The factors over a box of scaled frequencies and stiffnesses, all divided by e = f k + r.
    fn factors(&self, region: &Region) -> FactorBox {
        let Line { axis, round_trip, decay_rate: sigma } = self.line;
        let c = axis.coupling_damping;
        let FrequencyScale { follow, reference } = self.scale;
        let x = Interval { low: region.frequency.0, high: region.frequency.1 };
        let (k0, k1) = region.parameter;
        let (e0, e1) = (self.scale.square(k0), self.scale.square(k1));
        let root = Interval { low: e0.sqrt(), high: e1.sqrt() };
        let inverse = Interval { low: 1.0 / e1, high: 1.0 / e0 };
        let inverse_root = Interval { low: 1.0 / root.high, high: 1.0 / root.low };
        let over_square = Interval { low: inverse.low * inverse.low, high: inverse.high * inverse.high };
        let scaled = |factor: f64, by: Interval| Interval::between(factor * by.low, factor * by.high);
        let slow = Interval { low: x.low * inverse_root.low, high: x.high * inverse_root.high };
        // ∂(x/√e)/∂k and ∂ω/∂k; f is 0 or 1.
        let half = 0.5 * follow;
        let slow_by_k =
            scaled(-half, Interval { low: slow.low * inverse.low, high: slow.high * inverse.high });
        let omega_by_k = scaled(half, slow);
        let square = Interval { low: x.low * x.low, high: x.high * x.high };

        // (k + g)/e for a constant g: monotone in k.
        let elastic = |constant: f64| {
            if follow == 0.0 {
                Interval { low: k0 + constant, high: k1 + constant }
            } else {
                scaled(constant - reference, inverse).plus(Interval::point(1.0))
            }
        };
        let coupling = Rectangle { re: elastic(-c * sigma), im: scaled(c, slow) };
        let coupling_by_k =
            Rectangle { re: scaled(reference + follow * c * sigma, over_square), im: scaled(c, slow_by_k) };
        let of_side = |side: &Side| {
            let (m, b) = (side.mass, side.damping);
            (m, side.ground_stiffness + (m * sigma - b) * sigma, b - 2.0 * m * sigma)
        };
        let sides = axis.sides.each_ref().map(|side| {
            let (m, constant, rate) = of_side(side);
            let inertia = scaled(-m, square);
            SideFactors {
                alone: Rectangle { re: scaled(constant, inverse).plus(inertia), im: scaled(rate, slow) },
                coupling,
                whole: Rectangle {
                    re: elastic(constant - c * sigma).plus(inertia),
                    im: scaled(rate + c, slow),
                },
            }
        });
        let by_frequency = axis.sides.each_ref().map(|side| {
            let (m, _, rate) = of_side(side);
            SideSlopes {
                alone: Rectangle { re: scaled(-2.0 * m, x), im: scaled(rate, inverse_root) },
                coupling: imaginary(scaled(c, inverse_root)),
            }
        });
        let by_parameter = axis.sides.each_ref().map(|side| {
            let (_, constant, rate) = of_side(side);
            SideSlopes {
                alone: Rectangle { re: scaled(-follow * constant, over_square), im: scaled(rate, slow_by_k) },
                coupling: coupling_by_k,
            }
        });
        FactorBox {
            sides,
            turn: Interval { low: round_trip * x.low * root.low, high: round_trip * x.high * root.high },
            by_frequency: (by_frequency, scaled(round_trip, root)),
            by_parameter: (by_parameter, scaled(round_trip, omega_by_k)),
        }
    }

    /// L at a scaled frequency and a stiffness.
    fn logarithm(&self, frequency: f64, stiffness: f64) -> Logarithm {
        self.line.logarithm(frequency * self.scale.square(stiffness).sqrt(), stiffness, 0.0)
    }

    /// ln g = σT of the line with an unknown stiffness.
    fn log_growth(&self) -> f64 {
        self.line.decay_rate * self.line.round_trip
    }

    /// Both sides hold the same spring and damper.
    fn has_common_coupling(&self) -> bool {
        true
    }

    /// With an unknown stiffness the function is real at ω = 0.
    fn is_real_at(&self, frequency: f64) -> bool {
        frequency == 0.0
    }

    /// Whether a box lies in an excluded band at each of its stiffnesses.
    fn is_excluded(&self, region: &Region) -> bool {
        let ((x0, x1), (k0, k1)) = (region.frequency, region.parameter);
        let lowest = x0 * self.scale.square(k0).sqrt();
        let highest = x1 * self.scale.square(k1).sqrt();
        self.excluded.iter().any(|band| {
            lowest >= band.ends.0 * band.scale.square(k1).sqrt()
                && highest <= band.ends.1 * band.scale.square(k0).sqrt()
        })
    }
}

/// The characteristic function on the imaginary axis as a function of frequency and added damping.
#[derive(Debug, Clone, Copy)]
pub(super) struct DampingLine<'a> {
    line: Line<'a>,
    stiffness: f64,
}

impl<'a> DampingLine<'a> {
    /// The imaginary axis of an axis of a dyad with an unknown damping added to both sides.
    pub fn new(axis: &'a DyadAxis, round_trip: f64, stiffness: f64) -> Self {
        Self { line: Line { axis, round_trip, decay_rate: 0.0 }, stiffness }
    }
}

impl LineFunction for DampingLine<'_> {
    /// The factors over a box of frequencies and dampings.
    fn factors(&self, region: &Region) -> FactorBox {
        let Line { axis, round_trip, .. } = self.line;
        let c = axis.coupling_damping;
        let (w0, w1) = region.frequency;
        let (d0, d1) = region.parameter;
        let omega = Interval { low: w0, high: w1 };
        let coupling =
            Rectangle { re: Interval::point(self.stiffness), im: Interval { low: c * w0, high: c * w1 } };
        let sides = axis.sides.each_ref().map(|side| {
            let (m, b) = (side.mass, side.damping);
            let re = Interval {
                low: side.ground_stiffness - m * w1 * w1,
                high: side.ground_stiffness - m * w0 * w0,
            };
            let loss = |extra: f64| Interval { low: (b + d0 + extra) * w0, high: (b + d1 + extra) * w1 };
            SideFactors {
                alone: Rectangle { re, im: loss(0.0) },
                coupling,
                whole: Rectangle { re: re.plus(Interval::point(self.stiffness)), im: loss(c) },
            }
        });
        let by_frequency = axis.sides.each_ref().map(|side| SideSlopes {
            alone: Rectangle {
                re: Interval { low: -2.0 * side.mass * w1, high: -2.0 * side.mass * w0 },
                im: Interval { low: side.damping + d0, high: side.damping + d1 },
            },
            coupling: imaginary(Interval::point(c)),
        });
        let by_parameter =
            SideSlopes { alone: imaginary(omega), coupling: Rectangle::point(Complex64::ZERO) };
        FactorBox {
            sides,
            turn: Interval { low: w0 * round_trip, high: w1 * round_trip },
            by_frequency: (by_frequency, Interval::point(round_trip)),
            by_parameter: ([by_parameter; 2], Interval::point(0.0)),
        }
    }

    /// L at a frequency and an added damping.
    fn logarithm(&self, frequency: f64, added: f64) -> Logarithm {
        self.line.logarithm(frequency, self.stiffness, added)
    }

    /// ln g = 0 on the imaginary axis with an unknown damping.
    fn log_growth(&self) -> f64 {
        0.0
    }

    /// Both sides hold the same spring and damper.
    fn has_common_coupling(&self) -> bool {
        true
    }

    /// With an unknown damping the function is real at ω = 0.
    fn is_real_at(&self, frequency: f64) -> bool {
        frequency == 0.0
    }

    /// With an unknown damping crossings are wanted everywhere.
    fn is_excluded(&self, _: &Region) -> bool {
        false
    }
}
