//! The critical stiffness with a grounded operator: the lowest point of a curve, enclosed by subdivision
//! with Bernstein coefficients.

use crate::criteria::crossings::all_crossings;
use crate::model::DyadAxis;
use crate::poly::{Polynomial, Real, positive_roots};

/// The certified range ends this relative distance below the returned stiffness.
const RESOLUTION: f64 = 1e-9;

/// The largest number of ranges examined.
const MAX_ROUNDS: u32 = 64;

/// F(ξ, k) in powers of ξ = ω² (rows, to ξ⁴) and of k (columns, to k³: k⁴ cancels).
type Tensor = [[f64; 4]; 5];

/// The critical stiffness with a grounded operator, certified by subdivision.
pub(super) fn critical_stiffness(axis: &DyadAxis) -> f64 {
    let bound = stable_stiffness_bound(axis);
    // An undamped side still has the coupling damper: only the limit of a soft spring is left to check.
    let soft_spring = (axis.coupling_damping > 0.0).then(|| 1e-9 * stiffness_scale(axis));
    let Some(lowest) = bound.or(soft_spring) else { return 0.0 };
    let mut best = scan_frequencies(axis, lowest);
    let mut distance = RESOLUTION;
    // Each round proves F > 0 below `best`, finds a smaller stiffness with F ≤ 0, or, where rounding leaves it open,
    // proves less.
    for _ in 0..MAX_ROUNDS {
        let highest = best.stiffness * (1.0 - distance);
        // The crossings at one stiffness, in more digits, see what rounding hides from the coefficients.
        let negative = frequency_of_negative_value(axis, lowest, highest, best.squared_frequency)
            .or_else(|| all_crossings(axis, highest).first().map(|crossing| crossing.frequency.powi(2)));
        let Some(squared_frequency) = negative else {
            let proven = if distance > RESOLUTION { highest } else { best.stiffness };
            return if bound.is_none() && proven < 1e3 * lowest { 0.0 } else { proven };
        };
        let lower = descend_along_curve(axis, squared_frequency, best);
        if lower.stiffness < highest {
            best = lower;
        } else if distance < 0.5 {
            distance *= 10.0;
        } else {
            break;
        }
    }
    bound.unwrap_or(0.0)
}

/// A point on the curve F = 0.
#[derive(Clone, Copy)]
struct CurvePoint {
    squared_frequency: f64,
    stiffness: f64,
}

/// A stiffness up to which |Pᵢ(jω)|² ≥ k² + c²ω² on both grounded sides, so that F ≥ 0; else `None`.
fn stable_stiffness_bound(axis: &DyadAxis) -> Option<f64> {
    let c = axis.coupling_damping;
    let bound = axis.sides.iter().fold(f64::INFINITY, |bound, side| {
        // m²ξ² + (d − 2m(k + k_h))ξ + (k + k_h)² − k² has no sign change for
        // (k − d/2m)² ≤ k_h d/m, nor for d ≥ 2m(k + k_h); the two ranges join.
        let half = 0.5 * side.damping * (side.damping + 2.0 * c) / side.mass;
        bound.min(half + (2.0 * half * side.ground_stiffness).sqrt())
    });
    (bound > 0.0).then_some(bound)
}

/// A typical stiffness of the grounded sides without coupling, N/m.
fn stiffness_scale(axis: &DyadAxis) -> f64 {
    let loss = |damping: f64, mass: f64| (damping + axis.coupling_damping).powi(2) / mass;
    axis.sides.iter().map(|side| side.ground_stiffness + loss(side.damping, side.mass)).sum()
}

/// A starting point on the grounded dyad's curve: the smallest stiffness on a grid of frequencies around the
/// resonances.
fn scan_frequencies(axis: &DyadAxis, lowest: f64) -> CurvePoint {
    let mut best = CurvePoint { squared_frequency: f64::NAN, stiffness: f64::INFINITY };
    for side in &axis.sides {
        // At ω² = K/m the side's stiffness and inertia cancel; the smallest k lies near it.
        for step in -40..=120 {
            let stiffness = lowest * 1.25f64.powi(step);
            let squared_frequency = (stiffness + side.ground_stiffness) / side.mass;
            best = lower_stiffness(best, least_stiffness_at(axis, squared_frequency));
        }
    }
    descend_along_curve(axis, best.squared_frequency, best)
}

/// The curve point of the grounded dyad with the smaller stiffness.
fn lower_stiffness(best: CurvePoint, candidate: Option<CurvePoint>) -> CurvePoint {
    candidate.filter(|point| point.stiffness < best.stiffness).unwrap_or(best)
}

/// The smallest stiffness with F = 0 at a frequency, with a grounded operator.
fn least_stiffness_at(axis: &DyadAxis, squared_frequency: f64) -> Option<CurvePoint> {
    let tensor = crossing_tensor::<f64>(axis);
    let fine = || {
        let tensor = crossing_tensor::<twofloat::TwoFloat>(axis);
        polynomial_in_stiffness(&tensor, squared_frequency)
    };
    let roots = positive_roots(&polynomial_in_stiffness(&tensor, squared_frequency), fine);
    let stiffness = roots.first()?.at;
    Some(CurvePoint { squared_frequency, stiffness })
}

/// The crossing polynomial F of a grounded dyad at a fixed frequency, as a polynomial in the stiffness k.
fn polynomial_in_stiffness<R: Real>(tensor: &[[R; 4]; 5], squared_frequency: f64) -> Polynomial<R, 4> {
    let xi = R::from(squared_frequency);
    let mut coefficient = [R::from(0.0); 4];
    let mut magnitude = [0.0; 4];
    for row in tensor.iter().rev() {
        for j in 0..4 {
            coefficient[j] = coefficient[j] * xi + row[j];
            magnitude[j] = magnitude[j] * squared_frequency + row[j].to_f64().abs();
        }
    }
    Polynomial { coefficient, magnitude }
}

/// Follows the grounded dyad's curve from a frequency to a local minimum of the stiffness, by golden-section
/// search on the logarithm of the frequency.
fn descend_along_curve(axis: &DyadAxis, squared_frequency: f64, best: CurvePoint) -> CurvePoint {
    let start = match least_stiffness_at(axis, squared_frequency) {
        Some(point) => point,
        None => return best,
    };
    let at = |logarithm: f64| {
        least_stiffness_at(axis, logarithm.exp())
            .unwrap_or(CurvePoint { squared_frequency: logarithm.exp(), stiffness: f64::INFINITY })
    };
    // A bracket around the start, widened downhill.
    let mut middle = start;
    let mut width = 1e-3;
    let (mut left, mut right) =
        (at(start.squared_frequency.ln() - width), at(start.squared_frequency.ln() + width));
    for _ in 0..200 {
        if left.stiffness < middle.stiffness {
            (right, middle) = (middle, left);
            width *= 1.6;
            left = at(middle.squared_frequency.ln() - width);
        } else if right.stiffness < middle.stiffness {
            (left, middle) = (middle, right);
            width *= 1.6;
            right = at(middle.squared_frequency.ln() + width);
        } else {
            break;
        }
    }
    let golden = 0.381_966_011_250_105;
    for _ in 0..120 {
        let (l, x, r) =
            (left.squared_frequency.ln(), middle.squared_frequency.ln(), right.squared_frequency.ln());
        if r - l < 1e-9 {
            break;
        }
        let trial = at(if r - x > x - l { x + golden * (r - x) } else { x - golden * (x - l) });
        let ahead = trial.squared_frequency > middle.squared_frequency;
        if trial.stiffness < middle.stiffness {
            if ahead {
                left = middle
            } else {
                right = middle
            }
            middle = trial;
        } else if ahead {
            right = trial;
        } else {
            left = trial;
        }
    }
    lower_stiffness(best, Some(middle))
}

/// The coefficients of the grounded dyad's crossing polynomial F(ξ, k), in the requested arithmetic.
fn crossing_tensor<R: Real>(axis: &DyadAxis) -> [[R; 4]; 5] {
    let number = R::from;
    let two = number(2.0);
    let c = axis.coupling_damping;
    // |Pᵢ|² = (k + a)² + w with a = k_h − mξ, w = (b + c)²ξ: polynomials in ξ, low order first.
    let [first, second] = axis.sides.map(|side| {
        let (m, ground) = (number(side.mass), number(side.ground_stiffness));
        let loss = number(side.damping) + number(c);
        let a = [ground, -m];
        let g = [ground * ground, loss * loss - two * ground * m, m * m];
        (a, g)
    });
    let product = |p: &[R], q: &[R]| {
        let mut out = [number(0.0); 5];
        for (i, &x) in p.iter().enumerate() {
            for (j, &y) in q.iter().enumerate() {
                out[i + j] = out[i + j] + x * y;
            }
        }
        out
    };
    let (a1, g1) = first;
    let (a2, g2) = second;
    let square = number(c) * number(c);
    let (aa, ag, ga, gg) = (product(&a1, &a2), product(&a1, &g2), product(&a2, &g1), product(&g1, &g2));
    let mut tensor = [[number(0.0); 4]; 5];
    for i in 0..5 {
        let pick = |p: &[R]| p.get(i).copied().unwrap_or(number(0.0));
        tensor[i][0] = gg[i];
        tensor[i][1] = two * (ag[i] + ga[i]);
        tensor[i][2] = number(4.0) * aa[i] + pick(&g1) + pick(&g2);
        tensor[i][3] = two * (pick(&a1) + pick(&a2));
    }
    tensor[2][0] = tensor[2][0] - square * square;
    tensor[1][2] = tensor[1][2] - two * square;
    tensor
}

/// A frequency at which the grounded dyad's F < 0 for some stiffness between `lowest` and `highest`; `None`
/// if F > 0 there at every frequency.
fn frequency_of_negative_value(axis: &DyadAxis, lowest: f64, highest: f64, scale: f64) -> Option<f64> {
    // ξ = scale · u/(1 − u) maps all frequencies onto 0 ≤ u ≤ 1.
    let lowest = lowest.min(highest);
    let frequency = |u: f64| scale * u / (1.0 - u);
    let whole = (lowest, highest);
    let mut boxes = vec![(bernstein_tensor(axis, lowest, highest, scale), 0.0, 1.0, whole, 0u32)];
    while let Some((tensor, left, right, stiffness, depth)) = boxes.pop() {
        if is_positive(axis, (frequency(left), frequency(right)), stiffness) {
            continue;
        }
        let size = tensor.iter().flatten().fold(0.0f64, |size, value| size.max(value.abs()));
        let least = tensor.iter().flatten().fold(f64::INFINITY, |least, &value| least.min(value));
        // The coefficients enclose F on the box; the corner coefficients are values of F.
        if least > -1e-14 * size {
            continue;
        }
        let corners = [(0, left), (4, right)];
        for (row, u) in corners {
            if tensor[row][0].min(tensor[row][3]) < -1e-13 * size && u > 0.0 && u < 1.0 {
                return Some(frequency(u));
            }
        }
        // A box of this depth is narrower than rounding.
        if depth > 120 {
            continue;
        }
        if spread_over_frequency(&tensor) >= spread_over_stiffness(&tensor) {
            let middle = 0.5 * (left + right);
            let (low, high) = halve_frequency_range(&tensor);
            boxes.push((low, left, middle, stiffness, depth + 1));
            boxes.push((high, middle, right, stiffness, depth + 1));
        } else {
            let (low, high) = halve_stiffness_range(&tensor);
            let middle = 0.5 * (stiffness.0 + stiffness.1);
            boxes.push((low, left, right, (stiffness.0, middle), depth + 1));
            boxes.push((high, left, right, (middle, stiffness.1), depth + 1));
        }
    }
    None
}

/// Whether the magnitudes of both sides prove F > 0 in a box of ξ = ω² and the stiffness.
///
/// The Bernstein coefficients alone see the narrow valley along an almost undamped resonance only in boxes as narrow.
fn is_positive(axis: &DyadAxis, squared_frequency: (f64, f64), stiffness: (f64, f64)) -> bool {
    let c = axis.coupling_damping;
    let least = axis.sides.iter().fold(1.0, |least, side| {
        let real = (
            stiffness.0 + side.ground_stiffness - side.mass * squared_frequency.1,
            stiffness.1 + side.ground_stiffness - side.mass * squared_frequency.0,
        );
        let elastic = if real.0 <= 0.0 && real.1 >= 0.0 { 0.0 } else { real.0.abs().min(real.1.abs()) };
        least * (elastic * elastic + (side.damping + c).powi(2) * squared_frequency.0)
    });
    let coupling = stiffness.1 * stiffness.1 + if c > 0.0 { c * c * squared_frequency.1 } else { 0.0 };
    least > coupling * coupling * (1.0 + 1e-9)
}

/// The Bernstein coefficients of the grounded dyad's F (1 − u)⁴ over u in 0..1 and k in `lowest..highest`.
fn bernstein_tensor(axis: &DyadAxis, lowest: f64, highest: f64, scale: f64) -> Tensor {
    let binomial_4 = [1.0, 4.0, 6.0, 4.0, 1.0];
    let width = highest - lowest;
    let mut tensor = crossing_tensor::<f64>(axis);
    for (i, row) in tensor.iter_mut().enumerate() {
        let factor = scale.powi(i as i32) / binomial_4[i];
        let [c0, c1, c2, c3] = row.map(|value| value * factor);
        // Shift to k = lowest + width·v, then power basis to Bernstein basis of degree 3.
        let d0 = c0 + lowest * (c1 + lowest * (c2 + lowest * c3));
        let d1 = width * (c1 + lowest * (2.0 * c2 + 3.0 * lowest * c3));
        let d2 = width * width * (c2 + 3.0 * lowest * c3);
        let d3 = width * width * width * c3;
        *row = [d0, d0 + d1 / 3.0, d0 + (2.0 * d1 + d2) / 3.0, d0 + d1 + d2 + d3];
    }
    tensor
}

/// The largest difference of a grounded dyad's Bernstein coefficients along the frequency.
fn spread_over_frequency(tensor: &Tensor) -> f64 {
    let mut spread = 0.0f64;
    for i in 0..4 {
        for j in 0..4 {
            spread = spread.max((tensor[i + 1][j] - tensor[i][j]).abs());
        }
    }
    spread
}

/// The largest difference of a grounded dyad's Bernstein coefficients along the stiffness.
fn spread_over_stiffness(tensor: &Tensor) -> f64 {
    let mut spread = 0.0f64;
    for row in tensor {
        for j in 0..3 {
            spread = spread.max((row[j + 1] - row[j]).abs());
        }
    }
    spread
}

/// De Casteljau subdivision of the grounded dyad's Bernstein coefficients along the frequency (rows).
fn halve_frequency_range(tensor: &Tensor) -> (Tensor, Tensor) {
    let (mut low, mut high) = (*tensor, *tensor);
    for j in 0..4 {
        for step in 1..5 {
            for i in (step..5).rev() {
                low[i][j] = 0.5 * (low[i - 1][j] + low[i][j]);
            }
            for i in 0..5 - step {
                high[i][j] = 0.5 * (high[i][j] + high[i + 1][j]);
            }
        }
    }
    (low, high)
}

/// De Casteljau subdivision of the grounded dyad's Bernstein coefficients along the stiffness (columns).
fn halve_stiffness_range(tensor: &Tensor) -> (Tensor, Tensor) {
    let (mut low, mut high) = (*tensor, *tensor);
    for i in 0..5 {
        for step in 1..4 {
            for j in (step..4).rev() {
                low[i][j] = 0.5 * (low[i][j - 1] + low[i][j]);
            }
            for j in 0..4 - step {
                high[i][j] = 0.5 * (high[i][j] + high[i][j + 1]);
            }
        }
    }
    (low, high)
}
