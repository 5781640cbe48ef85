//! Tier 1 for sampled controllers: the gain of the loop of one robot around its own sampled position.

use super::gain::{largest_holding, unit_gain_stiffness};
use super::zero_order_hold::SampledPlant;
use crate::model::DyadAxis;

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
///
/// It is not proven that the sampled gain grows with k. The levels below the continuous bound are therefore
/// checked in order, and the first that fails starts the bisection.
pub(super) fn grounded_stiffness(axis: &DyadAxis, sides: &[SampledPlant; 2]) -> f64 {
    const LEVELS: u32 = 24;
    let continuous = unit_gain_stiffness(&axis.sides);
    let holds = |k: f64| {
        let [first, second] = sides.each_ref().map(|side| sampled_gain(side, k));
        first * second < 1.0
    };
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
    low
}

/// A matrix of the sampled local loop on (position, velocity, previous force).
type Loop = [[f64; 3]; 3];

/// The product of two matrices of the sampled local loop, for its gain.
fn loop_product(a: &Loop, b: &Loop) -> Loop {
    a.map(|row| {
        let mut out = [0.0; 3];
        for (weight, line) in row.iter().zip(b) {
            for (sum, value) in out.iter_mut().zip(line) {
                *sum += weight * value;
            }
        }
        out
    })
}

/// The row-sum norm of a matrix of the sampled local loop, for its gain.
fn row_sum_norm(a: &Loop) -> f64 {
    a.iter().map(|row| row.iter().map(|value| value.abs()).sum::<f64>()).fold(0.0, f64::max)
}

/// The gain of one sampled side: the l¹ norm of the map from partner position to own position. A proven
/// bound on the part not summed is added, at most 1e-13 of it unless the loop is so slow that the sum stops
/// after 2^18 samples; the value is then still an upper bound. Infinite if the loop is unstable.
pub(super) fn sampled_gain(side: &SampledPlant, stiffness: f64) -> f64 {
    // Units of velocity and force that make all entries similar in size: m per period and N per N/m.
    let unit = side.change[0][1];
    let [[a, b], [c, d]] = side.change;
    let [new, old] = [side.new_force, side.old_force].map(|[x, v]| [stiffness * x, stiffness * v * unit]);
    let step: Loop =
        [[1.0 + a - new[0], b / unit, old[0]], [c * unit - new[1], 1.0 + d, old[1]], [-1.0, 0.0, 0.0]];
    // Powers 1, 2, 4, … until one contracts.
    let mut powers = vec![step];
    while row_sum_norm(&powers[powers.len() - 1]) > 0.5 {
        let last = &powers[powers.len() - 1];
        if powers.len() > 60 || !row_sum_norm(last).is_finite() {
            return f64::INFINITY;
        }
        powers.push(loop_product(last, last));
    }
    let mut state = [new[0], new[1], 1.0];
    let mut row = [1.0, 0.0, 0.0];
    let mut sum = 0.0;
    let mut rows = 0.0;
    let mut summed = 1_u64;
    loop {
        // One more sample of the response, and of the row that maps any state to a position.
        sum += state[0].abs();
        rows += row.iter().map(|value: &f64| value.abs()).sum::<f64>();
        state = step.map(|line| line.iter().zip(state).map(|(weight, value)| weight * value).sum());
        let previous = row;
        row = [0, 1, 2].map(|column| (0..3).map(|i| previous[i] * step[i][column]).sum());
        if summed.is_power_of_two() {
            let tail = tail_bound(&powers, summed.trailing_zeros() as usize, rows, &state);
            if tail <= 1e-13 * sum || summed >= 1 << 18 {
                return sum + tail;
            }
        }
        summed += 1;
    }
}

/// An upper bound on the tail of the sampled gain's sum Σ|position| over all future samples from `state`,
/// given the summed row norms over the first 2^doublings samples.
fn tail_bound(powers: &[Loop], doublings: usize, rows: f64, state: &[f64; 3]) -> f64 {
    let size = state.iter().map(|value| value.abs()).fold(0.0, f64::max);
    // Over 2^(j+1) samples the rows sum to at most (1 + ‖M^(2^j)‖) times those over 2^j.
    let rows: f64 = powers.iter().skip(doublings).fold(rows, |sum, power| sum * (1.0 + row_sum_norm(power)));
    let contraction = row_sum_norm(&powers[powers.len() - 1]);
    rows * size / (1.0 - contraction)
}
