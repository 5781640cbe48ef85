//! The rule of an axis whose samples have an age in a range, as the sign of one function.
//!
//! With C = k + c s, Pᵢ = mᵢ s² + bᵢ s + k_h,i + C e^(−d₀ s), pᵢ = Pᵢ/C and D = p₁p₂ − e^(−T s) at s = jω, the rule is
//! f > 0 at every ω > 0 for some κ > 0:
//!
//! ```text
//! f = |D|² − ω² (α₂|p₁|² + α₁|p₂|²/κ + α₂/κ + α₁) + ω⁴ α₁α₂/κ
//! α₁ = J₂² + J₀J₂/r + κ (J₀² + J₀J₁/r),   α₂ = κ (J₁² + J₀J₁ r) + J₀² + J₀J₂ r,   r² = κ J₁/J₂.
//! ```
//!
//! T is the round trip of the mean ages, Jᵢ half the width of the range of the partner samples that side i uses, d₀ and
//! J₀ the mean age of the own sample and half its width. f is the determinant of a Hermitian matrix that is positive
//! definite for large ω; docs/age-range.md has the proof.

use num_complex::Complex64;

use super::jet::{Jet, cosine, minus, square};
use crate::criteria::complex_box::Interval;
use crate::verdicts::ranges::SideRange;

/// An axis, or all axes of a range of operators, and the ages of their samples.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rule {
    pub sides: [SideRange; 2],
    pub coupling_damping: f64,
    /// T: the sum of the mean ages of both directions, s.
    pub round_trip: f64,
    /// J: half the width of the range of ages that each side uses, s.
    pub reach: [f64; 2],
    /// d₀: the mean age of the own sample, s.
    pub own_delay: f64,
    /// J₀: half the width of the own sample's range, s.
    pub own_reach: f64,
}

/// The weights of the errors of both sides: κ, and α with which each side's motion enters.
#[derive(Debug, Clone, Copy)]
pub(super) struct Weights {
    pub ratio: f64,
    pub alpha: [f64; 2],
}

/// Mass (kg), damping (N·s/m) and stiffness to the ground (N/m) of both sides.
pub(super) type Pair = [[f64; 3]; 2];

/// What a cell of the search extends along: frequency (rad/s), stiffness (N/m), and each value of both sides.
pub(super) const DIRECTIONS: usize = 8;

/// A cell of the search.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cell(pub [(f64, f64); DIRECTIONS]);

/// The frequency's and the stiffness's place in a cell; the operators' values follow.
pub(super) const FREQUENCY: usize = 0;
pub(super) const STIFFNESS: usize = 1;

/// What f depends on at one frequency beside the weights.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample {
    frequency: f64,
    distance: f64,
    factors: [f64; 2],
}

/// A bound of f over a cell, and the direction along which to halve it.
pub(super) struct Enclosed {
    /// The rule holds in the cell if this is positive.
    pub least: f64,
    pub widest: usize,
}

/// Rounding in f, relative to its terms.
const ROUNDING: f64 = 1e-12;

/// sin(ωτ)/ω for 0 < ω ≤ `top`.
fn slow_sine(top: f64, delay: f64) -> Interval {
    let angle = top * delay;
    // sin(x)/x is never below −0.2173, its first minimum.
    let low = if angle <= std::f64::consts::PI { angle.sin() / top } else { -0.2173 * delay };
    Interval { low, high: delay }
}

impl Weights {
    /// The weights at a ratio κ of both sides' errors.
    pub fn new(rule: &Rule, ratio: f64) -> Self {
        let ([j1, j2], own) = (rule.reach, rule.own_reach);
        let r = if j1 > 0.0 && j2 > 0.0 { (ratio * j1 / j2).sqrt() } else { 1.0 };
        Self {
            ratio,
            alpha: [
                j2 * j2 + own * j2 / r + ratio * (own * own + own * j1 / r),
                ratio * (j1 * j1 + own * j1 * r) + own * own + own * j2 * r,
            ],
        }
    }

    /// The factors of |p₁|² and |p₂|², the constant term of the second power of ω, and that of the fourth.
    fn coefficients(&self) -> ([f64; 2], f64, f64) {
        let ([a1, a2], ratio) = (self.alpha, self.ratio);
        ([a2, a1 / ratio], a2 / ratio + a1, a1 * a2 / ratio)
    }

    /// The bracket of f at the squares of |pᵢ|.
    fn bracket(&self, squares: [f64; 2]) -> f64 {
        let ([first, second], constant, _) = self.coefficients();
        first * squares[0] + second * squares[1] + constant
    }
}

impl Cell {
    /// All frequencies (rad/s) and stiffnesses (N/m) of two ranges for both sides.
    pub fn new(frequency: (f64, f64), stiffness: (f64, f64), sides: &[SideRange; 2]) -> Self {
        let [first, second] = sides;
        Self([
            frequency,
            stiffness,
            first.mass,
            first.damping,
            first.stiffness,
            second.mass,
            second.damping,
            second.stiffness,
        ])
    }

    /// Whether the cell has one pair of operators only.
    pub fn is_one_pair(&self) -> bool {
        self.0[2..].iter().all(|(low, high)| low == high)
    }

    /// The pair in the middle.
    pub fn middle_pair(&self) -> Pair {
        let at = |i: usize| 0.5 * (self.0[i].0 + self.0[i].1);
        [[at(2), at(3), at(4)], [at(5), at(6), at(7)]]
    }
}

impl Rule {
    /// A bound of f over a cell.
    pub fn least(&self, cell: &Cell, weights: &Weights) -> Enclosed {
        if cell.0[FREQUENCY].0 == 0.0 {
            Enclosed { least: self.least_of_slow(cell, weights), widest: self.widest_of_slow(cell, weights) }
        } else if cell.is_one_pair() {
            self.least_by_slopes::<2>(cell, weights)
        } else {
            self.least_by_slopes::<DIRECTIONS>(cell, weights)
        }
    }

    /// The real and imaginary parts of p₁ and p₂ over a cell, with their derivatives.
    pub fn factors<const N: usize>(&self, cell: &Cell) -> [(Jet<N>, Jet<N>); 2] {
        let variable = |i: usize| Jet::<N>::variable(i, cell.0[i]);
        let (omega, k) = (variable(FREQUENCY), variable(STIFFNESS));
        let c = self.coupling_damping;
        let square = omega.squared();
        // 1/C = u − jωv.
        let (u, v) = if c == 0.0 {
            (k.inverse(), None)
        } else {
            let size = (k.squared() + square.scaled(c * c)).inverse();
            (k * size, Some(size.scaled(c)))
        };
        let own = omega.scaled(self.own_delay);
        let (own_re, own_im) =
            if self.own_delay == 0.0 { (Jet::constant(1.0), None) } else { (own.cosine(), Some(own.sine())) };
        [2, 5].map(|first| {
            let elastic = variable(first + 2) - variable(first) * square;
            let loss = variable(first + 1);
            let (mut re, mut rate) = (elastic * u + own_re, loss * u);
            if let Some(v) = v {
                re = re + square * loss * v;
                rate = rate - elastic * v;
            }
            let im = rate * omega;
            (re, own_im.map_or(im, |own| im - own))
        })
    }

    /// f over a cell with its derivatives.
    fn jet<const N: usize>(&self, cell: &Cell, weights: &Weights) -> Jet<N> {
        let [(r1, i1), (r2, i2)] = self.factors::<N>(cell);
        let omega = Jet::<N>::variable(FREQUENCY, cell.0[FREQUENCY]);
        let square = omega.squared();
        let turn = omega.scaled(self.round_trip);
        let re = r1 * r2 - i1 * i2 - turn.cosine();
        let im = r1 * i2 + r2 * i1 + turn.sine();
        let ([first, second], constant, fourth) = weights.coefficients();
        let bracket = (r1.squared() + i1.squared()).scaled(first)
            + (r2.squared() + i2.squared()).scaled(second)
            + Jet::constant(constant);
        re.squared() + im.squared() - square * bracket + square.squared().scaled(fourth)
    }

    /// A bound of f over a cell by the mean value theorem, which is of second order where f has its minimum.
    fn least_by_slopes<const N: usize>(&self, cell: &Cell, weights: &Weights) -> Enclosed {
        let jet = self.jet::<N>(cell, weights);
        let mut at = [0.0; DIRECTIONS];
        let mut change = 0.0;
        let mut widest = (FREQUENCY, f64::NEG_INFINITY);
        for (i, &(low, high)) in cell.0.iter().enumerate() {
            at[i] = 0.5 * (low + high);
            let Some(slope) = jet.slopes.get(i) else { continue };
            let width = high - low;
            let reach = width * slope.low.abs().max(slope.high.abs());
            if width > 0.0 && (reach > widest.1 || reach.is_nan()) {
                widest = (i, reach);
            }
            // A monotone direction has its minimum at one end.
            if slope.low >= 0.0 {
                at[i] = low;
            } else if slope.high <= 0.0 {
                at[i] = high;
            } else {
                change += 0.5 * reach;
            }
        }
        let sample = self.sample(at[0], at[1], &[[at[2], at[3], at[4]], [at[5], at[6], at[7]]]);
        let (value, size) = sample.value(weights);
        let least = (value - change - ROUNDING * size).max(jet.value.low - ROUNDING * size);
        Enclosed { least: if least.is_nan() { f64::NEG_INFINITY } else { least }, widest: widest.0 }
    }

    /// A bound of f/ω² over a cell from ω = 0 on.
    pub fn least_of_slow(&self, cell: &Cell, weights: &Weights) -> f64 {
        let (top, c) = (cell.0[FREQUENCY].1, self.coupling_damping);
        let (k0, k1) = cell.0[STIFFNESS];
        let squares = Interval { low: 0.0, high: top * top };
        let size = Interval { low: k0 * k0, high: k1 * k1 + c * c * top * top };
        let u = Interval { low: if c == 0.0 { 1.0 / k1 } else { k0 / size.high }, high: 1.0 / k0 };
        let v = Interval { low: c / size.high, high: c / size.low };
        let range = |i: usize| Interval { low: cell.0[i].0, high: cell.0[i].1 };
        let own = cosine(Interval { low: 0.0, high: top * self.own_delay });
        // Real parts, and imaginary parts divided by ω.
        let [(r1, i1), (r2, i2)] = [2, 5].map(|first| {
            let (mass, damping, ground) = (range(first), range(first + 1), range(first + 2));
            let elastic = minus(ground, mass.times(squares));
            let re = elastic.times(u).plus(squares.times(damping).times(v)).plus(own);
            let rate = minus(damping.times(u), elastic.times(v));
            (re, minus(rate, slow_sine(top, self.own_delay)))
        });
        let turn = cosine(Interval { low: 0.0, high: top * self.round_trip });
        let re = minus(minus(r1.times(r2), squares.times(i1.times(i2))), turn);
        let im = r1.times(i2).plus(r2.times(i1)).plus(slow_sine(top, self.round_trip));
        let moduli = [(r1, i1), (r2, i2)].map(|(re, im)| square(re).high + square(im).high * squares.high);
        // Re D is of second order in ω between free handles: its rounding must not be divided by ω².
        let re = (re.low.max(-re.high) - ROUNDING * (1.0 + moduli[0] * moduli[1])).max(0.0);
        let least = square(im).low * (1.0 - ROUNDING) + re * re / squares.high;
        least - weights.bracket(moduli) * (1.0 + ROUNDING)
    }

    /// The direction whose width hides most of f in a cell from ω = 0 on.
    pub fn widest_of_slow(&self, cell: &Cell, weights: &Weights) -> usize {
        let mut best = (FREQUENCY, f64::NEG_INFINITY);
        for (i, &(low, high)) in cell.0.iter().enumerate() {
            if low == high {
                continue;
            }
            let mut thin = *cell;
            thin.0[i] =
                if i == FREQUENCY { (0.0, 0.125 * high) } else { (0.5 * (low + high), 0.5 * (low + high)) };
            let least = self.least_of_slow(&thin, weights);
            if least > best.1 {
                best = (i, least);
            }
        }
        best.0
    }

    /// What f depends on at one frequency (rad/s), stiffness (N/m) and pair.
    pub fn sample(&self, frequency: f64, stiffness: f64, pair: &Pair) -> Sample {
        let coupling = Complex64::new(stiffness, self.coupling_damping * frequency);
        let own = Complex64::from_polar(1.0, -frequency * self.own_delay);
        let [first, second] = pair.map(|[mass, damping, ground]| {
            Complex64::new(ground - mass * frequency * frequency, damping * frequency) / coupling + own
        });
        let partner = Complex64::from_polar(1.0, -frequency * self.round_trip);
        Sample {
            frequency,
            distance: (first * second - partner).norm_sqr(),
            factors: [first.norm_sqr(), second.norm_sqr()],
        }
    }

    /// A frequency (rad/s) from which on the rule holds for every stiffness up to this one (N/m), by the moduli alone.
    pub fn highest_frequency(&self, stiffness: f64, weights: &Weights) -> Option<f64> {
        let c = self.coupling_damping;
        let mut frequency = self
            .sides
            .iter()
            .map(|side| ((2.0 * stiffness + side.stiffness.1) / side.mass.0).sqrt())
            .fold(c / self.sides[0].mass.0.min(self.sides[1].mass.0), f64::max);
        for _ in 0..60 {
            let size = stiffness.hypot(c * frequency);
            let [first, second] = self
                .sides
                .each_ref()
                .map(|side| (side.mass.0 * frequency * frequency - side.stiffness.1) / size - 1.0);
            let distance = first * second - 1.0;
            if first > 0.0 && second > 0.0 && distance > 0.0 {
                // Beside |D|² every term falls from here on.
                let lost = frequency * frequency * weights.bracket([first * first, second * second]);
                if lost < 0.9 * distance * distance {
                    return Some(frequency);
                }
            }
            frequency *= 1.5;
        }
        None
    }
}

impl Sample {
    /// f, and the size of its terms.
    fn value(&self, weights: &Weights) -> (f64, f64) {
        let square = self.frequency * self.frequency;
        let lost = square * weights.bracket(self.factors);
        let gained = square * square * weights.coefficients().2;
        (self.distance - lost + gained, self.factors[0] * self.factors[1] + 1.0 + lost + gained)
    }

    /// f divided by |D|²: 1 where the errors do not matter, 0 or less where the rule fails.
    pub fn relative(&self, weights: &Weights) -> f64 {
        let square = self.frequency * self.frequency;
        let product = square * square * weights.coefficients().2;
        if product >= self.distance {
            // Both gains are above 1, or one of them.
            return (1.0 - product / self.distance).min(0.0);
        }
        self.value(weights).0 / self.distance
    }
}
