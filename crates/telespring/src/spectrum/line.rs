//! The number of characteristic roots right of a vertical line, by the argument principle in closed form.
//!
//! With pᵢ = Pᵢ/mᵢ and q = (k + c s)/√(m₁ m₂), let L = q² e^(−Ts) / (p₁ p₂) be the ratio of both terms on s
//! = σ + jy. Its modulus equals 1 at the zeros of a function of w = y² with few turning points. Where |L| ≤
//! 1 the argument of χ is that of p₁ p₂ within a right angle; where |L| ≥ 1 it is that of −q² e^(−Ts)
//! within a right angle. Both are known in closed form. The total change along the line thus follows from a
//! few crossings, for any delay, without steps that could skip a turn.

use num_complex::Complex64;
use std::f64::consts::{PI, TAU};

use super::polynomial::real_roots;
use crate::characteristic::Characteristic;

/// A point of the line where |L| passes through 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct ModulusCrossing {
    /// Imaginary part, rad/s.
    pub y: f64,
    /// The argument of L, continuous on an interval with |L| ≥ 1, rad.
    pub phase: f64,
}

/// A vertical line with the number of roots to its right.
#[derive(Debug, Clone)]
pub(super) struct VerticalLine {
    pub sigma: f64,
    /// The crossings of |L| = 1, ascending.
    pub crossings: Vec<ModulusCrossing>,
    /// The argument of L just above y = 0 if |L| > 1 there.
    pub start: Option<f64>,
    /// The number of sides whose mean root lies right of the line: there the argument of the side is
    /// negative above the real axis, 2π below twice that of s at infinity.
    pub left_of: f64,
    /// The number of roots to the right, without the rigid-body root; `None` if a root is too close to the
    /// line.
    pub count: Option<usize>,
    /// True if the line lies so deep that rounding cannot separate the roots to its right.
    pub crowded: bool,
}

/// A larger phase carries too much rounding error for counting.
const LARGEST_PHASE: f64 = 1e12;

/// |p₁ p₂| and |q² e^(−Ts)| on one line, as functions of w = y².
struct Moduli {
    /// pᵢ(σ) and pᵢ′(σ).
    value: [f64; 2],
    slope: [f64; 2],
    q0: f64,
    g1: f64,
    growth: f64,
}

impl Moduli {
    /// The modulus |p₁ p₂| of both sides on the vertical line at w = y².
    fn sides_modulus(&self, w: f64) -> f64 {
        let square = |i: usize| {
            let real = self.value[i] - w;
            real * real + self.slope[i] * self.slope[i] * w
        };
        square(0).sqrt() * square(1).sqrt()
    }

    /// The modulus of the coupling term q² e^(−Ts) on the vertical line at w = y².
    fn coupling_modulus(&self, w: f64) -> f64 {
        self.growth * (self.q0 * self.q0 + self.g1 * self.g1 * w)
    }

    /// The excess |p₁ p₂| − |q² e^(−Ts)| of the sides over the coupling on the vertical line.
    fn excess(&self, w: f64) -> f64 {
        self.sides_modulus(w) - self.coupling_modulus(w)
    }

    /// The derivative of the excess on the line with respect to w = y².
    fn excess_slope(&self, w: f64) -> f64 {
        let term = |i: usize| {
            let real = self.value[i] - w;
            let b2 = self.slope[i] * self.slope[i];
            (b2 - 2.0 * real) / (real * real + b2 * w)
        };
        0.5 * self.sides_modulus(w) * (term(0) + term(1)) - self.growth * self.g1 * self.g1
    }

    /// The turning points of |p₁ p₂| / |q|² along the vertical line at w > 0, ascending.
    fn turning_points(&self) -> Vec<f64> {
        let rising = |i: usize| self.slope[i] * self.slope[i] - 2.0 * self.value[i];
        if self.g1 == 0.0 && rising(0) >= 0.0 && rising(1) >= 0.0 {
            return Vec::new();
        }
        // The origin moves between the two resonances, so that close ones stay separate.
        let origin = (-0.25 * (rising(0) + rising(1))).max(0.0);
        let quadratic = |i: usize| {
            let real = self.value[i] - origin;
            let b2 = self.slope[i] * self.slope[i];
            [real * real + b2 * origin, b2 - 2.0 * real, 1.0]
        };
        let (u1, u2) = (quadratic(0), quadratic(1));
        let product =
            [u1[0] * u2[0], u1[0] * u2[1] + u1[1] * u2[0], u1[0] + u2[0] + u1[1] * u2[1], u1[1] + u2[1], 1.0];
        let slope = [product[1], 2.0 * product[2], 3.0 * product[3], 4.0];
        let roots = if self.g1 == 0.0 {
            real_roots(&slope)
        } else {
            // (p²)′ v − 2 p² v′ with v = v0 + v1 w; divided by v1, its quintic part vanishes.
            let v0 = (self.q0 / self.g1) * (self.q0 / self.g1) + origin;
            real_roots(&[
                slope[0] * v0 - 2.0 * product[0],
                slope[1] * v0 + slope[0] - 2.0 * product[1],
                slope[2] * v0 + slope[1] - 2.0 * product[2],
                slope[3] * v0 + slope[2] - 2.0 * product[3],
                slope[3] - 2.0 * product[4],
            ])
        };
        roots.into_iter().map(|v| v + origin).filter(|&w| w > 0.0).collect()
    }

    /// The zero of the excess on the vertical line between `low` and `high`, where its signs differ.
    fn excess_zero(&self, mut low: f64, mut high: f64, low_is_large: bool) -> f64 {
        let mut w = high;
        for _ in 0..200 {
            let excess = self.excess(w);
            if (excess < 0.0) == low_is_large {
                low = w;
            } else {
                high = w;
            }
            let newton = w - excess / self.excess_slope(w);
            let next = if newton > low && newton < high {
                newton
            } else if low > 0.0 && high > 16.0 * low {
                (low * high).sqrt()
            } else {
                0.5 * (low + high)
            };
            if (next - w).abs() <= 2.0 * f64::EPSILON * w || next == low || next == high {
                return next;
            }
            w = next;
        }
        w
    }
}

impl VerticalLine {
    /// Counts the characteristic roots right of Re s = `sigma` in closed form.
    pub(super) fn count_right_of(chi: &Characteristic, sigma: f64) -> Self {
        let t = chi.round_trip;
        let moduli = Moduli {
            value: chi.sides.map(|side| (sigma + side.damping) * sigma + side.stiffness),
            slope: chi.sides.map(|side| 2.0 * sigma + side.damping),
            q0: chi.stiffness + chi.coupling_damping * sigma,
            g1: chi.coupling_damping,
            growth: (-t * sigma).exp(),
        };
        let mut clear = true;
        let same_sign = (moduli.value[0] > 0.0) == (moduli.value[1] > 0.0);
        let (real, real_noise) = chi.value_on_real_axis(sigma);
        if real.abs() <= real_noise {
            clear = false;
        }
        let start_large = if same_sign { real < 0.0 } else { moduli.excess(0.0) < 0.0 };

        // Between turning points the excess changes sign at most once.
        let mut zeros: Vec<f64> = Vec::new();
        let (mut low, mut large) = (0.0, start_large);
        for turn in moduli.turning_points() {
            let excess = moduli.excess(turn);
            if excess.abs() <= 16.0 * f64::EPSILON * moduli.coupling_modulus(turn) {
                // A tangency: harmless unless L is near 1 there, which is not worth distinguishing.
                clear = false;
            }
            if (excess < 0.0) != large {
                zeros.push(moduli.excess_zero(low, turn, large));
                large = !large;
            }
            low = turn;
        }
        if large {
            let scale = (moduli.growth.sqrt() * moduli.q0.abs()).max(moduli.growth * moduli.g1 * moduli.g1);
            let mut high = (2.0 * low).max(scale + moduli.value[0].abs() + moduli.value[1].abs());
            while high.is_finite() && moduli.excess(high) < 0.0 {
                high *= 4.0;
            }
            if !high.is_finite() {
                return Self {
                    sigma,
                    crossings: Vec::new(),
                    start: None,
                    left_of: 0.0,
                    count: None,
                    crowded: true,
                };
            }
            zeros.push(moduli.excess_zero(low, high, true));
        }

        // The argument of each factor above the real axis; none of them jumps there.
        let arguments = |y: f64| {
            let side = |i: usize| (y * moduli.slope[i]).atan2(moduli.value[i] - y * y);
            let q = if moduli.g1 == 0.0 { 0.0 } else { (y * moduli.g1).atan2(moduli.q0) };
            (side(0) + side(1), q)
        };
        let phase = |y: f64| {
            let (sides, q) = arguments(y);
            2.0 * q - t * y - sides
        };
        // The change of arg χ from y = 0 to infinity, in half turns.
        let sign = |i: usize| if moduli.slope[i] < 0.0 { -1_i64 } else { 1 };
        let below = |i: usize| if moduli.value[i] < 0.0 { sign(i) } else { 0 };
        let q_below = i64::from(moduli.q0 < 0.0);
        let mut half_turns = sign(0) + sign(1) - if start_large { 2 * q_below } else { below(0) + below(1) };
        let mut large = start_large;
        let mut crossings = Vec::with_capacity(zeros.len());
        for w in zeros {
            let y = w.sqrt();
            let theta = phase(y);
            if theta.is_nan() || theta.abs() > LARGEST_PHASE {
                return Self {
                    sigma,
                    crossings: Vec::new(),
                    start: None,
                    left_of: 0.0,
                    count: None,
                    crowded: true,
                };
            }
            let turns = (theta / TAU).floor();
            let gap = (theta - TAU * turns).min(TAU * (turns + 1.0) - theta);
            let noise = 8.0 * f64::EPSILON * moduli.coupling_modulus(w);
            let s = Complex64::new(sigma, y);
            let rate =
                t + chi.sides.iter().map(|side| side.slope(s).norm() / side.value(s).norm()).sum::<f64>();
            let y_error = (noise / moduli.excess_slope(w).abs()) / (2.0 * y) + f64::EPSILON * y;
            let error = 1e-12 + 8.0 * f64::EPSILON * theta.abs() + 4.0 * rate * y_error;
            clear &= gap > error;
            let odd = 2 * turns as i64 + 1;
            half_turns += if large { odd } else { -odd };
            large = !large;
            crossings.push(ModulusCrossing { y, phase: theta });
        }
        let start = start_large.then(|| (2 * q_below - below(0) - below(1)) as f64 * PI);
        let all = 2 - half_turns;
        let rigid = i64::from(chi.rigid_body && sigma < 0.0);
        let count = usize::try_from(all - rigid).ok().filter(|_| clear);
        let left_of = moduli.slope.iter().filter(|slope| **slope < 0.0).count() as f64;
        Self { sigma, crossings, start, left_of, count, crowded: false }
    }
}
