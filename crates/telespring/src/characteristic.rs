//! The characteristic function of one axis, evaluated without cancellation near s = 0.
//!
//! χ(s) = P₁(s) P₂(s) − q(s)² e^(−T s) with Pᵢ(s) = mᵢ s² + (bᵢ + c) s + k + k_h,i and q = k + c s. With
//! free handles χ(0) = 0 for every stiffness and delay: the rigid-body root. The code works on N(s) =
//! χ(s)/s in that case, and on N = χ if an operator is grounded.
//!
//! Two forms of N lose different digits:
//!
//! * by sides, P₁ P₂ − q² e^(−T s): accurate near a resonance, where P₁ or P₂ is small;
//! * by remainder, R + q² (1 − e^(−T s)) with R = P₁ P₂ − q², whose coefficients are sums of nonnegative
//!   terms: accurate near s = 0.

use num_complex::Complex64;

use crate::model::DyadAxis;

/// The value and derivative of an analytic function.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Jet {
    pub value: Complex64,
    pub slope: Complex64,
}

/// e^z − 1 without cancellation near 0, for the delay term of a characteristic function.
pub(crate) fn exp_m1(z: Complex64) -> Complex64 {
    let grown = z.re.exp_m1();
    let (sin, cos) = (0.5 * z.im).sin_cos();
    let versine = 2.0 * sin * sin;
    Complex64::new(grown * (1.0 - versine) - versine, (grown + 1.0) * 2.0 * sin * cos)
}

/// ln(1 + z) without cancellation near 0, for the ratio of two factors of a characteristic function.
pub(crate) fn ln_1p(z: Complex64) -> Complex64 {
    if z.norm_sqr() < 0.25 {
        Complex64::new(0.5 * (z.re * (2.0 + z.re) + z.im * z.im).ln_1p(), z.im.atan2(1.0 + z.re))
    } else {
        (z + 1.0).ln()
    }
}

/// The delay factors e^(−T s) and 1 − e^(−T s) at one point s.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DelayExponential {
    /// 1 − e^(−T s).
    pub complement: Complex64,
    /// e^(−T s).
    pub decay: Complex64,
}

impl DelayExponential {
    /// The delay factors e^(−T s) and 1 − e^(−T s) at `s` for a round-trip delay (s).
    pub fn at(s: Complex64, round_trip: f64) -> Self {
        let less_one = exp_m1(-s * round_trip);
        Self { complement: -less_one, decay: less_one + 1.0 }
    }

    /// (1 − e^(−T s))/s and its derivative by s, finite at s = 0.
    pub fn integral(&self, s: Complex64, round_trip: f64) -> Jet {
        let (t, z) = (round_trip, s * round_trip);
        if z.norm_sqr() < 1e-6 {
            let value = (((z / 120.0 - 1.0 / 24.0) * z + 1.0 / 6.0) * z - 0.5) * z + 1.0;
            let slope = ((z / 30.0 - 0.125) * z + 1.0 / 3.0) * z - 0.5;
            return Jet { value: value * t, slope: slope * (t * t) };
        }
        let value = self.complement / s;
        Jet { value, slope: (self.decay * t - value) / s }
    }

    /// Bounds on |(1 − e^(−T s))/s|, the integral of e^(−u s) over 0 < u < T, and on its first two
    /// derivatives, for |s| ≥ `least` and |e^(−u s)| ≤ `growth`.
    pub fn integral_bounds(least: f64, round_trip: f64, growth: f64) -> [f64; 3] {
        let t = round_trip;
        let zeroth = (t * growth).min((1.0 + growth) / least);
        let first = (0.5 * t * t * growth).min((t * growth + zeroth) / least);
        let second = (t * t * t / 3.0 * growth).min((t * t * growth + 2.0 * first) / least);
        [zeroth, first, second]
    }
}

/// Pᵢ(s) = `mass` s² + `damping` s + `stiffness`: robot, operator and coupling of one side.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SideFactor {
    pub mass: f64,
    pub damping: f64,
    pub stiffness: f64,
}

impl SideFactor {
    /// The value of one side's factor Pᵢ(s) in the characteristic function.
    pub fn value(&self, s: Complex64) -> Complex64 {
        (s * self.mass + self.damping) * s + self.stiffness
    }

    /// The derivative of one side's factor Pᵢ(s) in the characteristic function.
    pub fn slope(&self, s: Complex64) -> Complex64 {
        s * (2.0 * self.mass) + self.damping
    }

    /// Upper bounds on |Pᵢ| and |Pᵢ′| of the characteristic function at this |s|.
    pub fn bounds(&self, size: f64) -> [f64; 2] {
        [(self.mass * size + self.damping) * size + self.stiffness, 2.0 * self.mass * size + self.damping]
    }

    /// The argument of Pᵢ at j`frequency`, from 0 at rest to π: the imaginary part never changes sign.
    pub fn phase(&self, frequency: f64) -> f64 {
        (self.damping * frequency).atan2(self.stiffness - self.mass * frequency * frequency)
    }
}

/// The characteristic function of one axis at one stiffness and round-trip delay.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Characteristic {
    pub sides: [SideFactor; 2],
    /// k, N/m.
    pub stiffness: f64,
    /// c, N·s/m.
    pub coupling_damping: f64,
    /// Coefficients of R = P₁P₂ − q², constant first.
    pub remainder: [f64; 5],
    /// T, the round-trip delay, s.
    pub round_trip: f64,
    /// True if s = 0 is a root for every stiffness and delay, and is divided out.
    pub rigid_body: bool,
}

impl Characteristic {
    /// The characteristic function of an axis at a stiffness (N/m) and a round-trip delay (s).
    pub fn new(axis: &DyadAxis, stiffness: f64, round_trip: f64) -> Self {
        let (k, c) = (stiffness, axis.coupling_damping);
        let [m1, m2] = axis.sides.map(|side| side.mass);
        let [b1, b2] = axis.sides.map(|side| side.damping);
        let [h1, h2] = axis.sides.map(|side| side.ground_stiffness);
        Self {
            sides: axis.sides.map(|side| SideFactor {
                mass: side.mass,
                damping: side.damping + c,
                stiffness: k + side.ground_stiffness,
            }),
            stiffness: k,
            coupling_damping: c,
            remainder: [
                k * (h1 + h2) + h1 * h2,
                b1 * (k + h2) + b2 * (k + h1) + c * (h1 + h2),
                m1 * (k + h2) + m2 * (k + h1) + b1 * b2 + c * (b1 + b2),
                m1 * (b2 + c) + m2 * (b1 + c),
                m1 * m2,
            ],
            round_trip,
            rigid_body: axis.is_free(),
        }
    }

    /// The same function divided by m₁ m₂: both masses become 1, the roots stay the same.
    pub fn normalised(self) -> Self {
        let [m1, m2] = self.sides.map(|side| side.mass);
        let product = m1 * m2;
        let root = product.sqrt();
        Self {
            sides: self.sides.map(|side| SideFactor {
                mass: 1.0,
                damping: side.damping / side.mass,
                stiffness: side.stiffness / side.mass,
            }),
            stiffness: self.stiffness / root,
            coupling_damping: self.coupling_damping / root,
            remainder: self.remainder.map(|coefficient| coefficient / product),
            ..self
        }
    }

    /// The characteristic function χ itself, with the rigid-body root.
    pub fn with_rigid_body(self) -> Self {
        Self { rigid_body: false, ..self }
    }

    /// The coupling impedance q(s) = k + c s in the characteristic function.
    pub fn coupling(&self, s: Complex64) -> Complex64 {
        s * self.coupling_damping + self.stiffness
    }

    /// Coefficients of the remainder R of the characteristic function, constant term first; of R/s if the
    /// rigid-body root is divided out.
    pub fn deflated_remainder(&self) -> &[f64] {
        &self.remainder[usize::from(self.rigid_body)..]
    }

    /// The value of the characteristic function N(s), by remainder.
    pub fn value(&self, s: Complex64) -> Complex64 {
        let exponential = DelayExponential::at(s, self.round_trip);
        let lag = if self.rigid_body {
            exponential.integral(s, self.round_trip).value
        } else {
            exponential.complement
        };
        let polynomial = self.deflated_remainder().iter().rev().fold(Complex64::ZERO, |sum, &c| sum * s + c);
        let coupling = self.coupling(s);
        polynomial + coupling * coupling * lag
    }

    /// The characteristic function N(s) and its derivative, by remainder.
    pub fn jet_by_remainder(&self, s: Complex64, exponential: &DelayExponential) -> Jet {
        let lag = if self.rigid_body {
            exponential.integral(s, self.round_trip)
        } else {
            Jet { value: exponential.complement, slope: exponential.decay * self.round_trip }
        };
        let zero = Complex64::ZERO;
        let (value, slope) = self
            .deflated_remainder()
            .iter()
            .rev()
            .fold((zero, zero), |(value, slope), &c| (value * s + c, slope * s + value));
        let q = self.coupling(s);
        let q2 = q * q;
        Jet {
            value: value + q2 * lag.value,
            slope: slope + q * lag.value * (2.0 * self.coupling_damping) + q2 * lag.slope,
        }
    }

    /// The characteristic function N(s) and its derivative, by sides.
    pub fn jet_by_sides(&self, s: Complex64, exponential: &DelayExponential) -> Jet {
        let [one, two] = self.sides;
        let (p1, p2, q) = (one.value(s), two.value(s), self.coupling(s));
        let returned = q * exponential.decay;
        let value = p1 * p2 - q * returned;
        let slope = one.slope(s) * p2 + two.slope(s) * p1
            - returned * (q * -self.round_trip + 2.0 * self.coupling_damping);
        if !self.rigid_body {
            return Jet { value, slope };
        }
        let value = value / s;
        Jet { value, slope: (slope - value) / s }
    }

    /// The characteristic function N(s) and its derivative, in the form that loses fewer digits at `s`.
    pub fn jet(&self, s: Complex64) -> Jet {
        let exponential = DelayExponential::at(s, self.round_trip);
        let q2 = self.coupling(s).norm_sqr();
        let size = s.norm();
        let [one, two] = self.sides;
        let whole = self.remainder.iter().rev().fold(0.0, |sum, c| sum * size + c);
        let by_remainder = whole + q2 * exponential.complement.norm();
        let by_sides = one.value(s).norm() * two.bounds(size)[0]
            + two.value(s).norm() * one.bounds(size)[0]
            + q2 * exponential.decay.norm();
        if by_sides < by_remainder {
            self.jet_by_sides(s, &exponential)
        } else {
            self.jet_by_remainder(s, &exponential)
        }
    }

    /// An upper bound on |N″| for `least` ≤ |s| ≤ `most` and |e^(−u s)| ≤ `growth`, 0 ≤ u ≤ T.
    pub fn curvature(&self, least: f64, most: f64, growth: f64) -> f64 {
        let (t, c) = (self.round_trip, self.coupling_damping);
        let q = self.stiffness + c * most;
        if self.rigid_body {
            let [held, first, second] = DelayExponential::integral_bounds(least, t, growth);
            return 6.0 * self.remainder[4] * most
                + 2.0 * self.remainder[3]
                + 2.0 * c * c * held
                + 4.0 * c * q * first
                + q * q * second;
        }
        let [[value1, slope1], [value2, slope2]] = self.sides.map(|side| side.bounds(most));
        let [m1, m2] = self.sides.map(|side| side.mass);
        2.0 * (m1 * value2 + slope1 * slope2 + m2 * value1)
            + growth * (2.0 * c * c + t * q * (4.0 * c + t * q))
    }
}

#[cfg(test)]
mod tests;
