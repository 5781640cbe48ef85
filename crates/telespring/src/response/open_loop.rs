//! The open loop on the imaginary axis, and the continuous argument of χ.

use num_complex::Complex64;
use std::f64::consts::{FRAC_PI_2, PI};

use crate::characteristic::{Characteristic, DelayExponential, SideFactor};
use crate::error::{InvalidInput, Result};
use crate::model::{Delay, DyadAxis};
use crate::quantity;

/// Relative rounding error allowed for a sum of a few terms, parameters included.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// The open loop L(s) = −(k + c s)² e^(−T s)/(P₁P₂) of one axis, and the argument of N(s), which is χ(s),
/// divided by s for free handles.
#[derive(Debug, Clone)]
pub(super) struct OpenLoop {
    pub chi: Characteristic,
    pub delay: Delay,
    /// |P₁P₂|² − |k + cjω|⁴ in powers of ω², and the sums of the magnitudes of its terms.
    excess: [f64; 5],
    excess_size: [f64; 5],
}

/// The continuous argument of N and its zeros on the axis.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FollowedArgument {
    /// The continuous argument of N at each node, 0 at rest.
    pub argument: Vec<f64>,
    /// Frequencies where N is zero within rounding.
    pub zeros: Vec<f64>,
}

impl OpenLoop {
    /// The open loop of a checked axis and stiffness.
    pub fn new(axis: &DyadAxis, stiffness: f64, delay: &Delay) -> Result<Self> {
        let k = quantity::STIFFNESS.check("stiffness", stiffness)?;
        axis.check()?;
        let c = axis.coupling_damping;
        let chi = Characteristic::new(axis, k, delay.round_trip());
        let [p, q] = chi.sides;
        let excess_of = |sign: f64| {
            let squared = |f: &SideFactor| {
                let middle = f.damping * f.damping + sign * 2.0 * f.mass * f.stiffness;
                [f.stiffness * f.stiffness, middle, f.mass * f.mass]
            };
            let ([p0, p1, p2], [q0, q1, q2]) = (squared(&p), squared(&q));
            [
                chi.remainder[0] * (p.stiffness * q.stiffness + k * k),
                p0 * q1 + p1 * q0 + sign * 2.0 * k * k * c * c,
                p0 * q2 + p2 * q0 + p1 * q1 + sign * c.powi(4),
                p1 * q2 + p2 * q1,
                p2 * q2,
            ]
        };
        Ok(Self { chi, delay: *delay, excess: excess_of(-1.0), excess_size: excess_of(1.0) })
    }

    /// The degree of the open loop's N at infinity: 3 for free handles, else 4.
    pub fn degree(&self) -> usize {
        self.chi.deflated_remainder().len() - 1
    }

    /// The open loop's excess, divided by ω² for free handles, and the magnitudes of its terms.
    fn deflated_excess(&self) -> (&[f64], &[f64]) {
        let first = usize::from(self.chi.rigid_body);
        (&self.excess[first..], &self.excess_size[first..])
    }

    /// The rigid-body factor χ/N of the open loop: s for free handles, else 1.
    pub fn rigid_body_factor(&self, s: Complex64) -> Complex64 {
        if self.chi.rigid_body { s } else { Complex64::ONE }
    }

    /// The open loop L(s) = −(k + c s)² e^(−T s)/(P₁P₂).
    pub fn value(&self, s: Complex64) -> Complex64 {
        let [one, two] = self.chi.sides.map(|side| self.chi.coupling(s) / side.value(s));
        -one * two * (-s * self.chi.round_trip).exp()
    }

    /// The return difference 1 + L(s) of the open loop, without cancellation near s = 0.
    pub fn return_difference(&self, s: Complex64) -> Complex64 {
        let [one, two] = self.chi.sides;
        (self.rigid_body_factor(s) / one.value(s)) * (self.chi.value(s) / two.value(s))
    }

    /// The continuous argument of −L at j`frequency` in closed form; 0 at rest.
    pub fn loop_phase(&self, frequency: f64) -> f64 {
        self.coupling_phase(frequency)
            - self.chi.sides[0].phase(frequency)
            - self.chi.sides[1].phase(frequency)
            - frequency * self.chi.round_trip
    }

    /// The phase of the open loop's coupling term (k + cjω)², from 0 to π.
    fn coupling_phase(&self, frequency: f64) -> f64 {
        2.0 * (self.chi.coupling_damping * frequency).atan2(self.chi.stiffness)
    }

    /// A frequency above which the open loop has |L| < 1, from Kioustelidis' bound on the excess's positive roots.
    pub fn crossover_bound(&self) -> f64 {
        let (coefficients, size) = self.deflated_excess();
        let degree = coefficients.len() - 1;
        let bound = (1..=degree)
            .map(|below| {
                let lowest = coefficients[degree - below] - ROUNDING * size[degree - below];
                (-lowest).max(0.0) / coefficients[degree]
            })
            .zip(1..)
            .map(|(ratio, below)| 2.0 * ratio.powf(1.0 / f64::from(below)))
            .fold(0.0, f64::max);
        let natural = self.chi.sides.iter().map(|side| side.stiffness / side.mass).fold(0.0, f64::max);
        1.01 * bound.max(natural).sqrt()
    }

    /// The sign of the open loop's |P₁P₂| − |k + cjω| if it is provably constant on (low, high).
    fn excess_sign(&self, low: f64, high: f64) -> Option<f64> {
        let (bernstein, noise) = self.excess_bernstein(low * low, high * high);
        let used = &bernstein[..=self.degree()];
        if used.iter().all(|&value| value > noise) {
            Some(1.0)
        } else if used.iter().all(|&value| value < -noise) {
            Some(-1.0)
        } else {
            None
        }
    }

    /// Bernstein coefficients of the open loop's deflated excess over a range of ω², which bound it, and
    /// their rounding error.
    fn excess_bernstein(&self, low: f64, high: f64) -> ([f64; 5], f64) {
        let degree = self.degree();
        let (coefficients, sizes) = self.deflated_excess();
        let mut shifted = [0.0; 5];
        shifted[..=degree].copy_from_slice(coefficients);
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
        let size = sizes.iter().rev().fold(0.0, |sum, &c| sum * high + c);
        (bernstein, ROUNDING * size)
    }

    /// An upper bound on |dN/dω| of the open loop on j[`low`, `high`].
    pub fn slope_bound(&self, low: f64, high: f64) -> f64 {
        let mut slope = 0.0;
        for (power, &coefficient) in self.chi.deflated_remainder().iter().enumerate().skip(1).rev() {
            slope = slope * high + power as f64 * coefficient;
        }
        let c = self.chi.coupling_damping;
        let coupling = self.chi.stiffness.hypot(c * high);
        let [lag, lag_slope] = self.lag_bounds(low, high);
        slope + coupling * (2.0 * c * lag + coupling * lag_slope)
    }

    /// Upper bounds, for the open loop, on |1 − e^(−T s)|, divided by |s| for free handles, and on its slope
    /// on j[`low`, `high`].
    fn lag_bounds(&self, low: f64, high: f64) -> [f64; 2] {
        let round_trip = self.chi.round_trip;
        if !self.chi.rigid_body {
            return [2f64.min(round_trip * high), round_trip];
        }
        let [value, slope, _] = DelayExponential::integral_bounds(low, round_trip, 1.0);
        [value, slope]
    }

    /// The rounding error of the open loop's N on j[`low`, `high`].
    pub fn rounding_error(&self, low: f64, high: f64) -> f64 {
        let round_trip = self.chi.round_trip;
        let polynomial = self.chi.deflated_remainder().iter().rev().fold(0.0, |sum, &c| sum * high + c);
        let coupling = self.chi.stiffness.hypot(self.chi.coupling_damping * high);
        let turn = if self.chi.rigid_body { round_trip } else { round_trip * high };
        ROUNDING * (polynomial + coupling * coupling * self.lag_bounds(low, high)[0])
            + f64::EPSILON * coupling * coupling * turn
    }

    /// Follows the continuous argument of the open loop's N from rest along the ascending `nodes`.
    ///
    /// Each piece is accepted by one of three proofs, or halved: |L| < 1 on it (1 + L stays in the right
    /// half-plane); |L| > 1 on it (1 + 1/L does, and the argument of L is known); or N stays in a disc that
    /// excludes zero. The first two hold for any speed of the delay phase, so the work hardly grows with
    /// the delay. If all three fail down to rounding, N may have a zero on the axis: it is reported, and
    /// the argument continues as if it lay just to the left.
    pub fn follow_argument(&self, nodes: &[f64]) -> FollowedArgument {
        let floor = 1e-24 * self.crossover_bound();
        let mut followed = FollowedArgument { argument: Vec::with_capacity(nodes.len()), zeros: Vec::new() };
        if self.chi.value(Complex64::ZERO) == Complex64::ZERO {
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
                if self.is_undecidable(low, high) || high <= floor || middle <= low || middle >= high {
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

    /// True if no finer subdivision of j[`low`, `high`] can distinguish the open loop's N from zero.
    pub fn is_undecidable(&self, low: f64, high: f64) -> bool {
        let noise = self.rounding_error(low, high);
        0.5 * (high - low) * self.slope_bound(low, high) <= 2.0 * noise
            || [low, 0.5 * (low + high), high]
                .iter()
                .all(|&w| self.chi.value(Complex64::new(0.0, w)).norm() <= self.rounding_error(w, w))
    }

    /// The change of the argument of the open loop's N from `low` to `high`, if one of the three proofs holds.
    fn proven_turn(&self, low: f64, high: f64) -> Option<f64> {
        let sides = |w: f64| self.chi.sides[0].phase(w) + self.chi.sides[1].phase(w);
        match self.excess_sign(low, high) {
            Some(sign) if sign > 0.0 => {
                let remainder = |w| self.principal_argument(w, FRAC_PI_2, |s| self.return_difference(s));
                Some(sides(high) - sides(low) + remainder(high) - remainder(low))
            }
            Some(_) => {
                // χ = −(k + cs)² e^(−Ts) (1 + 1/L), and 1 + 1/L = (1 + L)/L.
                let remainder = |w| {
                    self.principal_argument(w, -FRAC_PI_2, |s| {
                        let coupling = self.chi.coupling(s);
                        let chi = self.chi.value(s) * self.rigid_body_factor(s);
                        -(chi / coupling) * (s * self.chi.round_trip).exp() / coupling
                    })
                };
                let known = |w| self.coupling_phase(w) - w * self.chi.round_trip;
                Some(known(high) - known(low) + remainder(high) - remainder(low))
            }
            None => {
                let centre = self.chi.value(Complex64::new(0.0, 0.5 * (low + high)));
                let reach = 0.5 * (high - low) * self.slope_bound(low, high) + self.rounding_error(low, high);
                (reach <= 0.9 * centre.norm()).then(|| self.argument_change(low, high))
            }
        }
    }

    /// The principal argument of the open loop's `value` at j`frequency`, or its limit at rest, where it is
    /// zero for free handles.
    fn principal_argument(
        &self,
        frequency: f64,
        at_rest: f64,
        value: impl Fn(Complex64) -> Complex64,
    ) -> f64 {
        if frequency == 0.0 {
            return if self.chi.rigid_body { at_rest } else { 0.0 };
        }
        value(Complex64::new(0.0, frequency)).arg()
    }

    /// The change of the argument of the open loop's N over an interval on which it is less than π.
    fn argument_change(&self, low: f64, high: f64) -> f64 {
        let at = |w| self.chi.value(Complex64::new(0.0, w));
        (at(high) * at(low).conj()).arg()
    }

    /// The change of the open loop's argument past a zero on the axis, counted as lying on the left: about +π.
    fn turn_past_zero(&self, low: f64, high: f64) -> f64 {
        let turn = if low == 0.0 {
            self.chi.value(Complex64::new(0.0, high)).arg()
        } else {
            self.argument_change(low, high)
        };
        if turn < -FRAC_PI_2 { turn + 2.0 * PI } else { turn }
    }

    /// The change of the argument of the open loop's N from `frequency` to infinity, where |L| < 1.
    pub fn remaining_turn(&self, frequency: f64) -> f64 {
        let s = Complex64::new(0.0, frequency);
        2.0 * PI
            - self.chi.sides[0].phase(frequency)
            - self.chi.sides[1].phase(frequency)
            - self.return_difference(s).arg()
    }
}

/// Checks an angular frequency (rad/s) of the open loop.
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
