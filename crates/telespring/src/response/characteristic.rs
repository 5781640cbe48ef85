//! The factors of the coupled dyad on the imaginary axis, and the continuous argument of χ.

use num_complex::Complex64;
use std::f64::consts::{FRAC_PI_2, PI};

use crate::error::{InvalidInput, Result};
use crate::{Delay, DyadAxis, quantity};

/// Relative rounding error granted to a sum of a few terms, parameters included.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Pᵢ(s) = `mass` s² + `damping` s + `stiffness`, everything on one side counted.
#[derive(Debug, Clone, Copy)]
pub(super) struct SideFactor {
    pub mass: f64,
    pub damping: f64,
    pub stiffness: f64,
}

impl SideFactor {
    pub fn value(&self, s: Complex64) -> Complex64 {
        (s * self.mass + self.damping) * s + self.stiffness
    }

    /// Its argument at j `frequency`, from 0 at rest to π: the imaginary part never changes sign.
    pub fn phase(&self, frequency: f64) -> f64 {
        (self.damping * frequency).atan2(self.stiffness - self.mass * frequency * frequency)
    }
}

/// The characteristic function of one axis at one stiffness and delay, ready to be evaluated
/// without cancellation near s = 0.
///
/// χ(s) = A(s) + (k + c s)² (1 − e^(−T s)), where A = P₁P₂ − (k + c s)² has coefficients that are
/// sums of non-negative terms. Free handles make A(0) = 0, and N(s) = χ(s)/s is what is followed;
/// with an operator to the ground N = χ.
#[derive(Debug, Clone)]
pub(super) struct Characteristic {
    pub sides: [SideFactor; 2],
    pub stiffness: f64,
    pub coupling_damping: f64,
    pub delay: Delay,
    /// Coefficients of A(s), constant first.
    undelayed: [f64; 5],
    /// 1 for free handles (the rigid-body root is divided out), else 0.
    pub deflation: usize,
    /// |P₁P₂|² − |k + cjω|⁴ in powers of ω², and the sums of the terms' magnitudes.
    pub excess: [f64; 5],
    excess_size: [f64; 5],
}

/// What subdividing found on the way.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Followed {
    /// Continuous argument of N at each node, 0 at rest.
    pub argument: Vec<f64>,
    /// Frequencies where N is zero within rounding.
    pub zeros: Vec<f64>,
}

impl Characteristic {
    pub fn new(axis: &DyadAxis, stiffness: f64, delay: &Delay) -> Result<Self> {
        let k = quantity::STIFFNESS.check("stiffness", stiffness)?;
        let c = check_axis(axis)?.coupling_damping;
        let sides = axis.sides.map(|side| SideFactor {
            mass: side.mass,
            damping: side.damping + c,
            stiffness: k + side.ground_stiffness,
        });
        let [m1, m2] = axis.sides.map(|side| side.mass);
        let [b1, b2] = axis.sides.map(|side| side.damping);
        let [h1, h2] = axis.sides.map(|side| side.ground_stiffness);
        let undelayed = [
            k * (h1 + h2) + h1 * h2,
            b1 * (k + h2) + b2 * (k + h1) + c * (h1 + h2),
            m1 * (k + h2) + m2 * (k + h1) + b1 * b2 + c * (b1 + b2),
            m1 * (b2 + c) + m2 * (b1 + c),
            m1 * m2,
        ];
        let [p, q] = sides;
        let excess_of = |sign: f64| {
            let squared = |f: &SideFactor| {
                let middle = f.damping * f.damping + sign * 2.0 * f.mass * f.stiffness;
                [f.stiffness * f.stiffness, middle, f.mass * f.mass]
            };
            let ([p0, p1, p2], [q0, q1, q2]) = (squared(&p), squared(&q));
            [
                undelayed[0] * (p.stiffness * q.stiffness + k * k),
                p0 * q1 + p1 * q0 + sign * 2.0 * k * k * c * c,
                p0 * q2 + p2 * q0 + p1 * q1 + sign * c.powi(4),
                p1 * q2 + p2 * q1,
                p2 * q2,
            ]
        };
        Ok(Self {
            sides,
            stiffness: k,
            coupling_damping: c,
            delay: *delay,
            undelayed,
            deflation: usize::from(axis.is_free()),
            excess: excess_of(-1.0),
            excess_size: excess_of(1.0),
        })
    }

    /// k + c s, what either side feels of the other.
    pub fn coupling(&self, s: Complex64) -> Complex64 {
        s * self.coupling_damping + self.stiffness
    }

    /// N(s): χ(s), divided by s for free handles.
    pub fn deflated(&self, s: Complex64) -> Complex64 {
        let mut polynomial = Complex64::ZERO;
        for &coefficient in self.undelayed[self.deflation..].iter().rev() {
            polynomial = polynomial * s + coefficient;
        }
        polynomial + self.coupling(s) * self.coupling(s) * self.lag(s)
    }

    /// (1 − e^(−T s))/s for free handles, its numerator otherwise.
    fn lag(&self, s: Complex64) -> Complex64 {
        let round_trip = self.delay.round_trip();
        let numerator = -expm1(-s * round_trip);
        match self.deflation {
            0 => numerator,
            _ if s == Complex64::ZERO => round_trip.into(),
            _ => numerator / s,
        }
    }

    /// L(s) = −(k + c s)² e^(−T s)/(P₁P₂).
    pub fn open_loop(&self, s: Complex64) -> Complex64 {
        let coupling = self.coupling(s);
        let lag = (-s * self.delay.round_trip()).exp();
        -(coupling / self.sides[0].value(s)) * (coupling / self.sides[1].value(s)) * lag
    }

    /// 1 + L(s), without cancellation near s = 0.
    pub fn return_difference(&self, s: Complex64) -> Complex64 {
        let rigid_body = if self.deflation == 1 { s } else { Complex64::ONE };
        (rigid_body / self.sides[0].value(s)) * (self.deflated(s) / self.sides[1].value(s))
    }

    /// The continuous argument of −L at j `frequency`; 0 at rest, in closed form.
    pub fn loop_phase(&self, frequency: f64) -> f64 {
        self.coupling_phase(frequency)
            - self.sides[0].phase(frequency)
            - self.sides[1].phase(frequency)
            - frequency * self.delay.round_trip()
    }

    /// The argument of (k + cjω)², from 0 to π.
    fn coupling_phase(&self, frequency: f64) -> f64 {
        2.0 * (self.coupling_damping * frequency).atan2(self.stiffness)
    }

    /// A frequency from which on |L| < 1: Kioustelidis' bound on the positive roots of the excess.
    pub fn loop_is_small_from(&self) -> f64 {
        let coefficients = &self.excess[self.deflation..];
        let size = &self.excess_size[self.deflation..];
        let degree = coefficients.len() - 1;
        let bound = (1..=degree)
            .map(|below| {
                let lowest = coefficients[degree - below] - ROUNDING * size[degree - below];
                (-lowest).max(0.0) / coefficients[degree]
            })
            .zip(1..)
            .map(|(ratio, below)| 2.0 * ratio.powf(1.0 / f64::from(below)))
            .fold(0.0, f64::max);
        let natural = self.sides.iter().map(|side| side.stiffness / side.mass).fold(0.0, f64::max);
        1.01 * bound.max(natural).sqrt()
    }

    /// The sign of |P₁P₂| − |k + cjω|² where it is proven to be the same on all of (low, high).
    fn excess_sign(&self, low: f64, high: f64) -> Option<f64> {
        let (bernstein, noise) = self.excess_bernstein(low * low, high * high);
        let used = &bernstein[..=4 - self.deflation];
        if used.iter().all(|&value| value > noise) {
            Some(1.0)
        } else if used.iter().all(|&value| value < -noise) {
            Some(-1.0)
        } else {
            None
        }
    }

    /// Bernstein coefficients of the (deflated) excess over a range of ω²; they bound it, and their
    /// sign variations bound its roots there. The second value is what rounding may change.
    fn excess_bernstein(&self, low: f64, high: f64) -> ([f64; 5], f64) {
        let degree = 4 - self.deflation;
        let mut shifted = [0.0; 5];
        shifted[..=degree].copy_from_slice(&self.excess[self.deflation..]);
        for start in 0..degree {
            for i in (start..degree).rev() {
                shifted[i] += low * shifted[i + 1];
            }
        }
        let mut power = 1.0;
        for coefficient in &mut shifted {
            *coefficient *= power;
            power *= high - low;
        }
        let mut bernstein = [0.0; 5];
        for (j, value) in bernstein.iter_mut().enumerate().take(degree + 1) {
            let mut weight = 1.0; // C(j, i)/C(degree, i)
            for (i, coefficient) in shifted.iter().enumerate().take(j + 1) {
                *value += weight * coefficient;
                if i < j {
                    weight *= (j - i) as f64 / (degree - i) as f64;
                }
            }
        }
        let size = self.excess_size[self.deflation..].iter().rev().fold(0.0, |sum, &c| sum * high + c);
        (bernstein, ROUNDING * size)
    }

    /// All ω > 0 with |L(jω)| = 1, ascending; a pair that rounding cannot separate is given once.
    pub fn gain_crossovers(&self) -> Vec<f64> {
        let largest = self.loop_is_small_from();
        let mut found = Vec::new();
        let mut touching_until = -1.0;
        let mut pending = vec![(0.0, largest * largest)];
        while let Some((low, high)) = pending.pop() {
            let (bernstein, noise) = self.excess_bernstein(low, high);
            let used = &bernstein[..=4 - self.deflation];
            let variations = used
                .iter()
                .filter(|&&value| value != 0.0)
                .map(|value| value.signum())
                .collect::<Vec<_>>()
                .windows(2)
                .filter(|pair| pair[0] != pair[1])
                .count();
            let (first, last) = (used[0], used[used.len() - 1]);
            let middle = 0.5 * (low + high);
            if variations == 0 {
                // A root exactly at the upper end belongs to this range, one at the lower end to the last.
                if last == 0.0 {
                    found.push(high);
                }
            } else if variations == 1 && first != 0.0 && last != 0.0 {
                found.push(self.excess_root(low, high, first > 0.0));
            } else if middle <= low || middle >= high || used.iter().all(|value| value.abs() <= noise) {
                if low > touching_until {
                    found.push(middle);
                }
                touching_until = high;
            } else {
                pending.push((middle, high));
                pending.push((low, middle));
            }
        }
        found.dedup_by(|next, previous| *next - *previous <= 8.0 * f64::EPSILON * *next);
        found.retain(|&square| square > 0.0);
        found.iter().map(|square| square.sqrt()).collect()
    }

    fn excess_root(&self, mut low: f64, mut high: f64, falling: bool) -> f64 {
        loop {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                return middle;
            }
            let value = self.excess[self.deflation..].iter().rev().fold(0.0, |sum, &c| sum * middle + c);
            if (value > 0.0) == falling {
                low = middle;
            } else {
                high = middle;
            }
        }
    }

    /// An upper bound of |dN/dω| on j[`low`, `high`].
    pub fn steepness(&self, low: f64, high: f64) -> f64 {
        let mut slope = 0.0;
        for (power, &coefficient) in self.undelayed[self.deflation..].iter().enumerate().skip(1).rev() {
            slope = slope * high + power as f64 * coefficient;
        }
        let coupling = self.stiffness.hypot(self.coupling_damping * high);
        let (lag, lag_slope) = self.lag_bounds(low, high);
        slope + coupling * (2.0 * self.coupling_damping * lag + coupling * lag_slope)
    }

    /// Upper bounds of [`Characteristic::lag`] and of its slope on j[`low`, `high`]:
    /// (1 − e^(−Ts))/s is the integral of e^(−us) over 0 < u < T.
    fn lag_bounds(&self, low: f64, high: f64) -> (f64, f64) {
        let round_trip = self.delay.round_trip();
        if self.deflation == 0 {
            return (2f64.min(round_trip * high), round_trip);
        }
        let bound = round_trip.min(2.0 / low);
        (bound, (0.5 * round_trip * round_trip).min((round_trip + bound) / low))
    }

    /// What rounding may change of N anywhere on j[`low`, `high`].
    pub fn noise(&self, low: f64, high: f64) -> f64 {
        let round_trip = self.delay.round_trip();
        let polynomial = self.undelayed[self.deflation..].iter().rev().fold(0.0, |sum, &c| sum * high + c);
        let coupling = self.stiffness.hypot(self.coupling_damping * high);
        let turn = if self.deflation == 1 { round_trip } else { round_trip * high };
        ROUNDING * (polynomial + coupling * coupling * self.lag_bounds(low, high).0)
            + f64::EPSILON * coupling * coupling * turn
    }

    /// Follows the argument of N from rest along the ascending `nodes`.
    ///
    /// Each piece is accepted by one of three proofs, else halved: |L| < 1 on it (1 + L stays in the
    /// right half-plane), |L| > 1 on it (so does 1 + 1/L, and the argument of L is known), or N
    /// stays in a disc that excludes zero. The first two do not care how fast the delay turns, so
    /// the work hardly grows with it. Where all three fail down to rounding, N has a zero on the
    /// axis for all we can tell: it is reported and passed as if it lay just to the left.
    pub fn follow(&self, nodes: &[f64]) -> Followed {
        let floor = 1e-24 * self.loop_is_small_from();
        let mut followed = Followed { argument: Vec::with_capacity(nodes.len()), zeros: Vec::new() };
        if self.deflated(Complex64::ZERO) == Complex64::ZERO {
            followed.zeros.push(0.0);
        }
        let mut here = 0.0;
        let mut argument = 0.0;
        let mut unresolved_since: Option<f64> = None;
        let mut pending = Vec::new();
        for &node in nodes {
            pending.push((here, node));
            while let Some((low, high)) = pending.pop() {
                if high <= low {
                    continue;
                }
                if let Some(turn) = self.proven_turn(low, high) {
                    if let Some(start) = unresolved_since.take() {
                        argument += self.turn_past_zero(start, low);
                        followed.zeros.push(0.5 * (start + low));
                    }
                    argument += turn;
                    continue;
                }
                let middle = 0.5 * (low + high);
                if self.undecidable(low, high) || high <= floor || middle <= low || middle >= high {
                    unresolved_since.get_or_insert(low);
                } else {
                    pending.push((middle, high));
                    pending.push((low, middle));
                }
            }
            here = node;
            followed.argument.push(argument);
        }
        if let Some(start) = unresolved_since {
            if let Some(last) = followed.argument.last_mut() {
                *last += self.turn_past_zero(start, here);
            }
            followed.zeros.push(0.5 * (start + here));
        }
        followed
    }

    /// True where no finer subdivision of j[`low`, `high`] can tell N from zero.
    pub fn undecidable(&self, low: f64, high: f64) -> bool {
        let noise = self.noise(low, high);
        0.5 * (high - low) * self.steepness(low, high) <= 2.0 * noise
            || [low, 0.5 * (low + high), high]
                .iter()
                .all(|&w| self.deflated(Complex64::new(0.0, w)).norm() <= self.noise(w, w))
    }

    /// The change of the argument of N from `low` to `high`, where one of the three proofs holds.
    fn proven_turn(&self, low: f64, high: f64) -> Option<f64> {
        let sides = |w: f64| self.sides[0].phase(w) + self.sides[1].phase(w);
        match self.excess_sign(low, high) {
            Some(sign) if sign > 0.0 => {
                let remainder = |w| self.remainder(w, FRAC_PI_2, |s| self.return_difference(s));
                Some(sides(high) - sides(low) + remainder(high) - remainder(low))
            }
            Some(_) => {
                // χ = −(k + cs)² e^(−Ts) (1 + 1/L), and 1 + 1/L = (1 + L)/L.
                let remainder = |w| {
                    self.remainder(w, -FRAC_PI_2, |s| {
                        let coupling = self.coupling(s);
                        let chi = self.deflated(s) * if self.deflation == 1 { s } else { Complex64::ONE };
                        -(chi / coupling) * (s * self.delay.round_trip()).exp() / coupling
                    })
                };
                let known = |w| self.coupling_phase(w) - w * self.delay.round_trip();
                Some(known(high) - known(low) + remainder(high) - remainder(low))
            }
            None => {
                let centre = self.deflated(Complex64::new(0.0, 0.5 * (low + high)));
                let reach = 0.5 * (high - low) * self.steepness(low, high) + self.noise(low, high);
                (reach <= 0.9 * centre.norm()).then(|| self.turn_between(low, high))
            }
        }
    }

    /// The principal argument of `value` at j`frequency`; at rest, where free handles make it zero,
    /// its limit.
    fn remainder(&self, frequency: f64, at_rest: f64, value: impl Fn(Complex64) -> Complex64) -> f64 {
        if frequency == 0.0 {
            return if self.deflation == 1 { at_rest } else { 0.0 };
        }
        value(Complex64::new(0.0, frequency)).arg()
    }

    fn turn_between(&self, low: f64, high: f64) -> f64 {
        let at = |w| self.deflated(Complex64::new(0.0, w));
        (at(high) * at(low).conj()).arg()
    }

    /// The turn past a zero that counts as lying on the left: about +π.
    fn turn_past_zero(&self, low: f64, high: f64) -> f64 {
        let turn = if low == 0.0 {
            self.deflated(Complex64::new(0.0, high)).arg()
        } else {
            self.turn_between(low, high)
        };
        if turn < -FRAC_PI_2 { turn + 2.0 * PI } else { turn }
    }

    /// The turn of N from `frequency` on to infinity, where |L| < 1 all the way.
    pub fn remaining_turn(&self, frequency: f64) -> f64 {
        let s = Complex64::new(0.0, frequency);
        2.0 * PI
            - self.sides[0].phase(frequency)
            - self.sides[1].phase(frequency)
            - self.return_difference(s).arg()
    }
}

/// e^z − 1 without cancellation for small z.
fn expm1(z: Complex64) -> Complex64 {
    let half = (0.5 * z.im).sin();
    Complex64::new(z.re.exp_m1() * z.im.cos() - 2.0 * half * half, z.re.exp() * z.im.sin())
}

/// An axis whose fields were filled in by hand may hold anything.
fn check_axis(axis: &DyadAxis) -> Result<&DyadAxis> {
    let refuse = |field: String, value: f64, allowed: &str| {
        Err(InvalidInput::new(field, value, allowed, "Build the axis with `DyadAxis::with_operators`."))
    };
    let upper = 1e8;
    for (i, side) in (1..).zip(&axis.sides) {
        if !(1e-6..=upper).contains(&side.mass) {
            return refuse(format!("m{i}"), side.mass, "a mass must be a positive number in kg");
        }
        for (name, value) in [("b", side.damping), ("kh", side.ground_stiffness)] {
            if !(0.0..=upper).contains(&value) {
                return refuse(format!("{name}{i}"), value, "must be a number not below 0");
            }
        }
    }
    if !(0.0..=upper).contains(&axis.coupling_damping) {
        return refuse("c".to_owned(), axis.coupling_damping, "must be a number not below 0");
    }
    Ok(axis)
}

/// Refuses what is no angular frequency.
pub(super) fn check_frequency(field: &str, value: f64) -> Result<f64> {
    if (0.0..=1e12).contains(&value) {
        return Ok(value);
    }
    Err(InvalidInput::new(
        field,
        value,
        "an angular frequency must be a number from 0 to 1e12 rad/s",
        "Give rad/s, that is 2π times the frequency in Hz.",
    ))
}
