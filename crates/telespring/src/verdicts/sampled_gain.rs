//! Tier 1 for sampled controllers: the gain of the loop of one robot around its own sampled position.

use std::f64::consts::{PI, TAU};

use num_complex::Complex64;

use super::gain::{largest_holding, unit_gain_stiffness};
use super::zero_order_hold::SampledPlant;
use crate::characteristic::exp_m1;
use crate::model::{DyadAxis, Side};

/// The stiffness (N/m) up to which two free, sampled sides never widen their common hull.
///
/// Without a coupling damper this is where the two slow poles of the local loop cease to be real and
/// positive. Up to there its response to the partner is a weighted mean of the partner's past.
pub(super) fn free_stiffness(sides: &[SampledPlant; 2], damper: f64) -> f64 {
    if sides[0].has_computing_time {
        return sides.iter().map(breakaway_stiffness).fold(f64::INFINITY, f64::min);
    }
    largest_holding(|k| sides.iter().all(|side| keeps_hull(side, k, damper)))
}

/// True if one period maps x and y = x + v/λ of a side, together with the partner's x and y, to weighted
/// means of them, for the smallest possible λ.
///
/// All weights sum to 1, so only their signs matter. The weight of x in y⁺ is a quadratic in 1/λ; its
/// discriminant without damper is that of the poles of the local loop.
fn keeps_hull(side: &SampledPlant, stiffness: f64, damper: f64) -> bool {
    let [[_, travel], [_, lost]] = side.change;
    let [to_position, to_velocity] = side.new_force;
    let travel = travel - damper * to_position;
    let lost = -lost + damper * to_velocity - stiffness * to_position;
    let discriminant = lost * lost - 4.0 * travel * stiffness * to_velocity;
    if travel < 0.0 || lost <= 0.0 || discriminant < 0.0 {
        return false;
    }
    let rate = 2.0 * stiffness * to_velocity / (lost + discriminant.sqrt());
    let kept_velocity = 1.0 + side.change[1][1] - damper * to_velocity;
    damper * rate <= stiffness
        && 1.0 - stiffness * to_position - rate * travel >= 0.0
        && rate * travel + kept_velocity >= 0.0
}

/// The breakaway stiffness of the sampled gain: the two slow poles of a free side with a computing time meet.
///
/// On E < z < 1 (E = e^(−Bh/M), the pole of the velocity) a real pole lies at z for k = −z p(z)/n(z). This
/// is 0 at both ends and log-concave between (n has zeros only left of 0), so its single maximum is the
/// bound. The third pole stays small and negative; with it the response still has no negative sample.
fn breakaway_stiffness(side: &SampledPlant) -> f64 {
    let lost = -side.change[1][1];
    if lost == 0.0 {
        return 0.0;
    }
    let numerator = side.numerator(1.0, 0.0);
    let stiffness = |part: f64| {
        let w = -part * lost;
        let n = numerator.iter().rev().fold(0.0, |sum, &coefficient| sum * w + coefficient);
        part * (1.0 - part) * lost * lost * (1.0 + w) / n
    };
    // Golden-section search; near a maximum half of the digits of `part` give all digits of the value.
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let (left, right) = (high - ratio * (high - low), low + ratio * (high - low));
        if stiffness(left) < stiffness(right) { low = left } else { high = right }
    }
    stiffness(0.5 * (low + high))
}

/// The stiffness at which the product of both sampled gains reaches 1.
pub(super) struct UnitGain {
    /// Up to this stiffness (N/m) the product is proven to stay below 1.
    pub proven: f64,
    /// It reaches 1 at this stiffness (N/m), if not before.
    pub found: f64,
}

/// The levels that are tried before a bisection for the stiffness at which the gain reaches 1.
const LEVELS: u32 = 24;
/// The most steps of the proof.
const MAX_STEPS: u32 = 5000;

/// The stiffness at which the product of both sampled gains reaches 1, with at least one grounded side.
///
/// A search finds it; it is not known that the gains grow with k. The proof therefore walks up to it. With T = kG/(1 + kG)
/// the response of a side, dT/dk = T (1 − T)/k, so that the gain γ = ‖T‖₁ satisfies |dγ/d ln k| ≤ γ (1 + γ): up to r k the
/// quotient γ/(1 + γ) grows at most r-fold. From a product below 1 it thus stays below 1 up to
/// r = 1/(γ₁/(1 + γ₁) + γ₂/(1 + γ₂)), which exceeds 1.
pub(super) fn grounded_stiffness(axis: &DyadAxis, sides: &[SampledPlant; 2]) -> UnitGain {
    let continuous = unit_gain_stiffness(&axis.sides);
    let gains = |k: f64| sides.each_ref().map(|side| log_gain(side, k));
    let holds = |k: f64| gains(k).iter().sum::<f64>() < 0.0;
    let mut low = 0.0;
    let mut high = continuous;
    for level in 1..=LEVELS {
        let k = continuous * f64::from(level) / f64::from(LEVELS);
        if !holds(k) {
            high = k;
            break;
        }
        low = k;
    }
    while high - low > 1e-13 * high {
        let middle = 0.5 * (low + high);
        if holds(middle) { low = middle } else { high = middle }
    }
    let found = low;
    let mut proven = proven_start(axis, sides, found);
    for _ in 0..MAX_STEPS {
        let gains = gains(proven);
        let product = gains.iter().sum::<f64>();
        if proven == 0.0 || !(product < 0.0) || proven >= found * (1.0 - 1e-12) {
            break;
        }
        let [first, second] = gains.map(|gain| 1.0 / (1.0 + (-gain).exp()));
        // r − 1 without cancellation.
        let growth = -product.exp_m1() * (1.0 - first) * (1.0 - second) / (first + second);
        proven *= 1.0 + growth * (1.0 - 1e-9);
    }
    UnitGain { proven: proven.min(found), found }
}

/// A stiffness (N/m) up to which the product of both sampled gains is known to stay below 1; 0 if none is.
///
/// Without computing time no response overshoots up to k + k_h = the bound of the side without ground. Otherwise: a free side
/// has gain 1 up to its bound. A grounded one with a gain γ below 1/3 at some k has k ‖G‖₁ ≤ γ/(1 − γ) < 1/2 there and at
/// any smaller k, and so a gain of at most k ‖G‖₁/(1 − k ‖G‖₁) < 1.
fn proven_start(axis: &DyadAxis, sides: &[SampledPlant; 2], found: f64) -> f64 {
    let mut start = found;
    for (side, plant) in axis.sides.iter().zip(sides) {
        let ungrounded = Side { ground_stiffness: 0.0, ..*side };
        let free = if plant.has_computing_time {
            if side.ground_stiffness > 0.0 { 0.0 } else { breakaway_stiffness(plant) }
        } else {
            let alone = SampledPlant::new(&ungrounded, plant.period, 0.0);
            largest_holding(|k| keeps_hull(&alone, k, 0.0))
        };
        let mut own = free - side.ground_stiffness;
        if side.ground_stiffness > 0.0 {
            let mut soft = found;
            while soft > 1e-12 * found && !(log_gain(plant, soft) < -(3.0_f64.ln())) {
                soft *= 0.5;
            }
            own = own.max(if soft > 1e-12 * found { soft } else { 0.0 });
        }
        start = start.min(own.max(0.0));
    }
    start
}

/// The poles of the sampled local loop: a pair, w² + `linear` w + `constant` with w = z − 1, and with a computing
/// time a third one, z = `third`.
struct LoopPoles {
    linear: f64,
    constant: f64,
    third: f64,
}

impl LoopPoles {
    /// The poles of the loop of one side around its own sampled position, for its gain.
    fn new(side: &SampledPlant, stiffness: f64) -> Self {
        let [[a, b], [c, d]] = side.change;
        let (p0, p1) = (a * d - b * c, -(a + d));
        let numerator = side.numerator(stiffness, 0.0);
        if !side.has_computing_time {
            return Self { linear: p1 + numerator[1], constant: p0 + numerator[0], third: 0.0 };
        }
        let [d0, d1, d2] = [p0 + numerator[0], p0 + p1 + numerator[1], p1 + 1.0 + numerator[2]];
        // The leftmost real root of the cubic in w: from the left Newton's iteration only moves right.
        let mut w = -1.0 - d0.abs().max(d1.abs()).max(d2.abs());
        for _ in 0..200 {
            let value = ((w + d2) * w + d1) * w + d0;
            let slope = (3.0 * w + 2.0 * d2) * w + d1;
            let next = w - value / slope;
            if !(next > w) {
                break;
            }
            w = next;
        }
        let constant = -d0 / w;
        Self { linear: (constant - d1) / w, constant, third: 1.0 + w }
    }

    /// Whether all poles of the loop lie in the unit circle.
    fn are_stable(&self) -> bool {
        let Self { linear, constant, third } = *self;
        constant > 0.0 && linear > constant && 4.0 - 2.0 * linear + constant > 0.0 && third.abs() < 1.0
    }
}

/// ln of the gain of one sampled side, to the last digits even where it is close to 0.
///
/// The signed response sums to the static gain k/(k + k_h), so that only its negative samples are needed. A pair
/// of real poles leaves none after the first few samples; a complex pair leaves one run of them per turn, which
/// has a sum in closed form.
fn log_gain(side: &SampledPlant, stiffness: f64) -> f64 {
    let poles = LoopPoles::new(side, stiffness);
    let LoopPoles { linear, constant, third } = poles;
    if !poles.are_stable() {
        return f64::INFINITY;
    }
    let [[a, b], [c, d]] = side.change;
    let ground = (a * d - b * c) / side.numerator(stiffness, 0.0)[0];
    // ln |z| of the pair's slower pole.
    let discriminant = linear * linear - 4.0 * constant;
    let is_turning = discriminant < 0.0;
    let slower = if is_turning {
        0.5 * (constant - linear).ln_1p()
    } else {
        if linear >= 2.0 {
            return f64::INFINITY;
        }
        (-2.0 * constant / (linear + discriminant.sqrt())).ln_1p()
    };
    // The first samples directly, until the third pole has died away beside the pair.
    let direct = if third == 0.0 { 2.0 } else { 2.0 + 45.0 / (slower - third.abs().ln()) };
    if !(direct > 0.0 && direct < 1e5) {
        return f64::INFINITY;
    }
    let (mut position, mut velocity, mut previous) = (0.0, 0.0, 0.0);
    let (mut last, mut negative) = (0.0, 0.0);
    for sample in 0..=direct as u32 {
        last = position;
        let force = stiffness * (f64::from(u8::from(sample == 0)) - position);
        let [new, old] = [side.new_force, side.old_force];
        (position, velocity) = (
            position + a * position + b * velocity + new[0] * force + old[0] * previous,
            velocity + c * position + d * velocity + new[1] * force + old[1] * previous,
        );
        previous = force;
        negative += (-position).max(0.0);
    }
    if is_turning {
        let turn = (0.5 * (-discriminant).sqrt()).atan2(1.0 - 0.5 * linear);
        // The last sample has been counted; the runs start after it.
        negative += negative_runs(last, position, slower, turn);
    }
    let static_gain = ground.ln_1p();
    (2.0 * negative * (1.0 + ground)).ln_1p() - static_gain
}

/// The sum of −xₙ over all negative samples of the sampled loop's response after `newer`, for two successive samples
/// of xₙ = C e^(−αn) sin(φn + ψ), with α = −`decay` and φ = `turn`: at most the true sum, plus what lies beyond a
/// fixed number of turns, as an upper bound.
fn negative_runs(older: f64, newer: f64, decay: f64, turn: f64) -> f64 {
    const MOST_TURNS: u32 = 1 << 13;
    let (sin, cos) = turn.sin_cos();
    // The amplitude with n = 0 at `older`.
    let amplitude = Complex64::new((newer / decay.exp() - older * cos) / sin, older);
    let (size, phase) = (amplitude.norm(), amplitude.arg().rem_euclid(TAU));
    let pole = Complex64::new(decay, turn);
    let from_one = -exp_m1(pole);
    // A run of half a turn sums to less than its first factor times 1/sin(φ/2).
    let largest_run = size / (0.5 * turn).sin();
    let kept_per_turn = (decay * TAU / turn).exp();
    let mut sum = 0.0;
    for count in 0..MOST_TURNS {
        let starts = (f64::from(count) * TAU + PI - phase) / turn;
        let first = starts.ceil().max(2.0);
        let last = (starts + PI / turn).floor();
        let reach = largest_run * (decay * first).exp();
        if reach <= 1e-18 * (sum + size) || reach < f64::MIN_POSITIVE {
            return sum;
        }
        if last >= first {
            let power = |n: f64| (pole * n + Complex64::new(0.0, phase)).exp();
            let run = ((power(first) - power(last + 1.0)) / from_one).im * size;
            sum += (-run).max(0.0);
        }
    }
    let first = (f64::from(MOST_TURNS) * TAU + PI - phase) / turn;
    sum + largest_run * (decay * (first - 1.0)).exp() / (1.0 - kept_per_turn)
}
