//! The stiffness below which no constant delay destabilises.

use super::polynomial::crossing_roots;
use crate::error::Result;
use crate::model::DyadAxis;
use crate::poly::{Polynomial, positive_roots};
use crate::quantity;

/// True where no constant delay can destabilise: no characteristic root ever reaches the imaginary
/// axis, and the undelayed dyad is stable.
///
/// # Errors
///
/// [`InvalidInput`](crate::InvalidInput) where the stiffness (N/m) is not in range.
pub fn is_delay_independent(axis: &DyadAxis, stiffness: f64) -> Result<bool> {
    quantity::STIFFNESS.check("stiffness", stiffness)?;
    Ok(crossing_roots(axis, stiffness).is_empty())
}

/// The critical stiffness k_m, N/m: below it no constant delay destabilises; 0 where every stiffness
/// has a destabilising delay.
///
/// It is the smallest stiffness at which F, the polynomial of the crossing frequencies (the paper's
/// Eq. 8 with operators and coupling damping), has a positive root. The paper's Eq. 5 only asks for
/// F(0) ≥ 0 and is too large where the robots' damping differs much.
///
/// Free handles: for a fixed ratio y = ω²/k, F falls as k grows, so that the roots appear once and
/// for all, either at y = 0 (Eq. 5) or as a tangency, the maximum of a quasi-concave function of y.
/// With an operator's stiffness the least k on the curve F = 0 is bounded by subdivision with
/// Bernstein coefficients, which enclose F on a whole box.
///
/// # Examples
///
/// ```
/// use telespring::{DyadAxis, criteria::critical_stiffness};
/// let k = critical_stiffness(&DyadAxis::new(1.0, 1.0, 1.0, 10.0)?);
/// assert!((k - 9.4610953).abs() < 1e-7);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
pub fn critical_stiffness(axis: &DyadAxis) -> f64 {
    if axis.is_free() { free::critical(axis) } else { grounded::critical(axis) }
}

/// Both handles free.
mod free {
    use crate::model::DyadAxis;

    /// The critical stiffness, from the largest compliance q = 1/k at which F touches zero.
    pub(super) fn critical(axis: &DyadAxis) -> f64 {
        let [first, second] = &axis.sides;
        let c = axis.coupling_damping;
        let (m1, m2) = (first.mass, second.mass);
        let (d1, d2) =
            (first.damping * (first.damping + 2.0 * c), second.damping * (second.damping + 2.0 * c));
        // Where F's lowest coefficient vanishes: Eq. 5, with the damper.
        let at_rest = 2.0 * (m1 + m2) / (d1 + d2);
        // An undamped side without a damper resonates at every stiffness.
        if !at_rest.is_finite() || c == 0.0 && d1 * d2 == 0.0 {
            return 0.0;
        }
        let curve = Touching { m1, m2, d1, d2, g: c * c };

        // There F/y² is a quadratic; two positive roots mean that F < 0 between them, already now.
        let [a2, a3, a4] = curve.quadratic(at_rest);
        let discriminant = a3 * a3 - 4.0 * a4 * a2;
        if a2 >= 0.0 && (a3 >= 0.0 || discriminant <= 0.0) {
            return 1.0 / at_rest;
        }
        let far = if a3 < 0.0 {
            0.5 * (discriminant.sqrt() - a3) / a4
        } else {
            -2.0 * a2 / (discriminant.sqrt() + a3)
        };
        // A vanishing lower end stands for the limit y → 0, where the compliance is `at_rest`.
        let near = (a2 / (a4 * far)).max(1e-9 * far);
        let middle = ((a3 * a3 - 3.0 * a4 * a2).sqrt() - a3) / (3.0 * a4);
        let largest = curve.tangency(middle, near, far);
        1.0 / largest.unwrap_or_else(|| curve.largest_compliance(near, far)).max(at_rest)
    }

    /// The curve F(y; q) = 0 over y = ω²/k, with q = 1/k.
    struct Touching {
        m1: f64,
        m2: f64,
        /// bᵢ² + 2 bᵢ c.
        d1: f64,
        d2: f64,
        /// c².
        g: f64,
    }

    impl Touching {
        /// The coefficients of y², y³ and y⁴ of F at the compliance q.
        fn quadratic(&self, q: f64) -> [f64; 3] {
            let (f1, f2) = (self.d1 * q - 2.0 * self.m1, self.d2 * q - 2.0 * self.m2);
            let g = self.g * q;
            let (s1, s2) = (self.m1 * self.m1, self.m2 * self.m2);
            [s1 + s2 + f1 * f2 + g * (f1 + f2), (f1 + g) * s2 + (f2 + g) * s1, s1 * s2]
        }

        /// The one compliance q > 0 with F(y; q) = 0, for a y at which F(y; 0) ≤ 0.
        fn compliance(&self, y: f64) -> f64 {
            let (a1, a2) = ((1.0 - self.m1 * y).powi(2), (1.0 - self.m2 * y).powi(2));
            let square = (self.d1 * self.d2 + self.g * (self.d1 + self.d2)) * y * y;
            let linear = (a1 * self.d2 + a2 * self.d1 + self.g * (a1 + a2 - 2.0)) * y;
            // 1 − a₁a₂ from its factors, so that small y keeps its digits.
            let product = (1.0 - self.m1 * y) * (1.0 - self.m2 * y);
            let sum = y * (self.m1 + self.m2 - self.m1 * self.m2 * y);
            let constant = sum * (1.0 + product);
            let root = (linear * linear + 4.0 * square * constant).sqrt();
            if linear >= 0.0 { 2.0 * constant / (linear + root) } else { 0.5 * (root - linear) / square }
        }

        /// The compliance at which F only touches zero, by Newton's iteration in y and q on G = F/y and
        /// ∂G/∂y from the curve at `y`; None where it does not settle between `near` and `far` within a
        /// few steps. Between them the compliance has but one stationary point, its maximum.
        fn tangency(&self, mut y: f64, near: f64, far: f64) -> Option<f64> {
            let (s1, s2) = (self.m1 * self.m1, self.m2 * self.m2);
            let mut q = self.compliance(y);
            for _ in 0..8 {
                let (f1, f2) = (self.d1 * q - 2.0 * self.m1, self.d2 * q - 2.0 * self.m2);
                let [a2, a3, a4] = self.quadratic(q);
                // derivatives of the coefficients by q
                let by_q1 = self.d1 + self.d2;
                let by_q2 = self.d1 * f2 + self.d2 * f1 + self.g * (f1 + f2 + q * by_q1);
                let by_q3 = (self.d1 + self.g) * s2 + (self.d2 + self.g) * s1;
                let value = f1 + f2 + y * (a2 + y * (a3 + y * a4));
                let slope = a2 + y * (2.0 * a3 + y * 3.0 * a4);
                let curvature = 2.0 * a3 + 6.0 * a4 * y;
                let value_by_q = by_q1 + y * (by_q2 + y * by_q3);
                let slope_by_q = by_q2 + 2.0 * y * by_q3;
                let scale = 1.0 / (slope * slope_by_q - value_by_q * curvature);
                let step = (value_by_q * slope - value * slope_by_q) * scale;
                q += (value * curvature - slope * slope) * scale;
                y += step;
                if !(near < y && y < far) {
                    return None;
                }
                // The next step would be of the order of the square; an error ε in y costs ε² in q.
                if step.abs() <= 1e-6 * y {
                    return Some(self.compliance(y));
                }
            }
            None
        }

        /// The maximum of the compliance between `near` and `far`, where it is quasi-concave: F/y is
        /// a cubic in y, so that {q > q₀} is one interval for every q₀ above the value at both ends.
        fn largest_compliance(&self, near: f64, far: f64) -> f64 {
            // The sign of ∂(F/y)/∂y on the curve is that of −dq/dy; false position with the
            // Anderson–Björck weight finds its zero. An error ε in y costs only ε² in q.
            let slope = |y: f64| {
                let q = self.compliance(y);
                let [a2, a3, a4] = self.quadratic(q);
                (a2 + y * (2.0 * a3 + y * 3.0 * a4), q)
            };
            let (mut older, mut newer) = (near, far);
            let (mut at_older, q_near) = slope(older);
            let (mut at_newer, q_far) = slope(newer);
            let mut best = q_near.max(q_far);
            for _ in 0..200 {
                let proposed = (older * at_newer - newer * at_older) / (at_newer - at_older);
                let between = (proposed - older) * (proposed - newer) < 0.0;
                let y = if between { proposed } else { 0.5 * (older + newer) };
                let (value, q) = slope(y);
                best = best.max(q);
                let moved = (y - newer).abs();
                if value * at_newer < 0.0 {
                    (older, at_older) = (newer, at_newer);
                } else {
                    let weight = 1.0 - value / at_newer;
                    at_older *= if weight > 0.0 { weight } else { 0.5 };
                }
                (newer, at_newer) = (y, value);
                if value == 0.0 || moved.min((newer - older).abs()) <= 1e-8 * y {
                    break;
                }
            }
            best
        }
    }
}

/// At least one handle held to the ground.
mod grounded {
    use super::{Polynomial, positive_roots};
    use crate::model::DyadAxis;
    use crate::poly::Real;

    /// The certified range ends this far (relative) below the stiffness that is returned.
    const RESOLUTION: f64 = 1e-9;

    /// F(ξ, k) in powers of ξ = ω² (rows, to ξ⁴) and of k (columns, to k³: k⁴ cancels).
    type Tensor = [[f64; 4]; 5];

    pub(super) fn critical(axis: &DyadAxis) -> f64 {
        let Some(lowest) = stable_below(axis) else { return 0.0 };
        let mut best = scan(axis, lowest);
        // Each round either proves that F > 0 below `best` or finds a smaller stiffness with F ≤ 0.
        for _ in 0..64 {
            match negative_point(axis, lowest, best.stiffness * (1.0 - RESOLUTION), best.squared_frequency) {
                None => return best.stiffness,
                Some(squared_frequency) => best = descend(axis, squared_frequency, best),
            }
        }
        best.stiffness
    }

    /// A point on the curve F = 0.
    #[derive(Clone, Copy)]
    struct Point {
        squared_frequency: f64,
        stiffness: f64,
    }

    /// A stiffness up to which each |Pᵢ(jω)|² ≥ k² + c²ω², so that F ≥ 0; None where there is none.
    fn stable_below(axis: &DyadAxis) -> Option<f64> {
        let c = axis.coupling_damping;
        let bound = axis.sides.iter().fold(f64::INFINITY, |bound, side| {
            // m²ξ² + (d − 2m(k + k_h))ξ + (k + k_h)² − k² has no sign change for
            // (k − d/2m)² ≤ k_h d/m, nor for d ≥ 2m(k + k_h); the two ranges join.
            let half = 0.5 * side.damping * (side.damping + 2.0 * c) / side.mass;
            bound.min(half + (2.0 * half * side.ground_stiffness).sqrt())
        });
        (bound > 0.0).then_some(bound)
    }

    /// A first point of the curve: the least stiffness over a grid of frequencies about the resonances.
    fn scan(axis: &DyadAxis, lowest: f64) -> Point {
        let mut best = Point { squared_frequency: f64::NAN, stiffness: f64::INFINITY };
        for side in &axis.sides {
            // At ω² = K/m the side's own stiffness and inertia cancel; the least k lies near it.
            for step in -40..=120 {
                let stiffness = lowest * 1.25f64.powi(step);
                let squared_frequency = (stiffness + side.ground_stiffness) / side.mass;
                best = lower(best, on_curve(axis, squared_frequency));
            }
        }
        descend(axis, best.squared_frequency, best)
    }

    fn lower(best: Point, candidate: Option<Point>) -> Point {
        candidate.filter(|point| point.stiffness < best.stiffness).unwrap_or(best)
    }

    /// The least stiffness with F = 0 at this frequency.
    fn on_curve(axis: &DyadAxis, squared_frequency: f64) -> Option<Point> {
        let tensor = expand::<f64>(axis);
        let fine = || {
            let tensor = expand::<twofloat::TwoFloat>(axis);
            along_stiffness(&tensor, squared_frequency)
        };
        let roots = positive_roots(&along_stiffness(&tensor, squared_frequency), fine);
        let stiffness = roots.first()?.at;
        Some(Point { squared_frequency, stiffness })
    }

    /// F at a fixed frequency, as a polynomial in k.
    fn along_stiffness<R: Real>(tensor: &[[R; 4]; 5], squared_frequency: f64) -> Polynomial<R, 4> {
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

    /// Follows the curve from a frequency to a local minimum of the stiffness, by golden section on
    /// the logarithm of the frequency.
    fn descend(axis: &DyadAxis, squared_frequency: f64, best: Point) -> Point {
        let start = match on_curve(axis, squared_frequency) {
            Some(point) => point,
            None => return best,
        };
        let at = |logarithm: f64| {
            on_curve(axis, logarithm.exp())
                .unwrap_or(Point { squared_frequency: logarithm.exp(), stiffness: f64::INFINITY })
        };
        // A bracket about the start, widened downhill.
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
        lower(best, Some(middle))
    }

    /// F(ξ, k) expanded; formed in the arithmetic asked for.
    fn expand<R: Real>(axis: &DyadAxis) -> [[R; 4]; 5] {
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

    /// A frequency at which F < 0 for some stiffness from `lowest` to `highest`, or None where F > 0
    /// on that whole range of stiffness and at every frequency.
    fn negative_point(axis: &DyadAxis, lowest: f64, highest: f64, scale: f64) -> Option<f64> {
        // ξ = scale · u/(1 − u) maps all frequencies onto 0 ≤ u ≤ 1.
        let lowest = lowest.min(highest);
        let mut boxes = vec![(bernstein(axis, lowest, highest, scale), 0.0, 1.0, 0u32)];
        while let Some((tensor, left, right, depth)) = boxes.pop() {
            let size = tensor.iter().flatten().fold(0.0f64, |size, value| size.max(value.abs()));
            let least = tensor.iter().flatten().fold(f64::INFINITY, |least, &value| least.min(value));
            // The coefficients enclose F on the box; those at the corners are values of F.
            if least > -1e-14 * size {
                continue;
            }
            let corners = [(0, left), (4, right)];
            for (row, u) in corners {
                if tensor[row][0].min(tensor[row][3]) < -1e-13 * size && u > 0.0 && u < 1.0 {
                    return Some(scale * u / (1.0 - u));
                }
            }
            // A box of this depth is narrower than rounding: what is left in it is rounding.
            if depth > 120 {
                continue;
            }
            if spread_over_frequency(&tensor) >= spread_over_stiffness(&tensor) {
                let middle = 0.5 * (left + right);
                let (low, high) = split_rows(&tensor);
                boxes.push((low, left, middle, depth + 1));
                boxes.push((high, middle, right, depth + 1));
            } else {
                let (low, high) = split_columns(&tensor);
                boxes.push((low, left, right, depth + 1));
                boxes.push((high, left, right, depth + 1));
            }
        }
        None
    }

    /// The Bernstein coefficients of F (1 − u)⁴ over u in 0..1 and k in `lowest..highest`.
    fn bernstein(axis: &DyadAxis, lowest: f64, highest: f64, scale: f64) -> Tensor {
        let binomial_4 = [1.0, 4.0, 6.0, 4.0, 1.0];
        let width = highest - lowest;
        let mut tensor = expand::<f64>(axis);
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

    fn spread_over_frequency(tensor: &Tensor) -> f64 {
        let mut spread = 0.0f64;
        for i in 0..4 {
            for j in 0..4 {
                spread = spread.max((tensor[i + 1][j] - tensor[i][j]).abs());
            }
        }
        spread
    }

    fn spread_over_stiffness(tensor: &Tensor) -> f64 {
        let mut spread = 0.0f64;
        for row in tensor {
            for j in 0..3 {
                spread = spread.max((row[j + 1] - row[j]).abs());
            }
        }
        spread
    }

    /// De Casteljau's halving over the rows (frequency).
    fn split_rows(tensor: &Tensor) -> (Tensor, Tensor) {
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

    /// De Casteljau's halving over the columns (stiffness).
    fn split_columns(tensor: &Tensor) -> (Tensor, Tensor) {
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
}
