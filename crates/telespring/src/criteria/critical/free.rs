//! The critical stiffness with both handles free: the maximum of a quasi-concave function.

use crate::model::DyadAxis;

/// The critical stiffness with free handles, from the largest compliance q = 1/k at which F touches zero.
pub(super) fn critical_stiffness(axis: &DyadAxis) -> f64 {
    let [first, second] = &axis.sides;
    let c = axis.coupling_damping;
    let (m1, m2) = (first.mass, second.mass);
    let (d1, d2) = (first.damping * (first.damping + 2.0 * c), second.damping * (second.damping + 2.0 * c));
    // At this compliance F's lowest coefficient vanishes: Eq. 5, with the damper.
    let at_rest = 2.0 * (m1 + m2) / (d1 + d2);
    // Without a damper, an undamped side resonates at every stiffness.
    if !at_rest.is_finite() || c == 0.0 && d1 * d2 == 0.0 {
        return 0.0;
    }
    let curve = TangencyCurve { m1, m2, d1, d2, g: c * c };

    // Here F/y² is a quadratic; two positive roots mean that F < 0 between them.
    let [a2, a3, a4] = curve.quadratic_coefficients(at_rest);
    let discriminant = a3 * a3 - 4.0 * a4 * a2;
    if a2 >= 0.0 && (a3 >= 0.0 || discriminant <= 0.0) {
        return 1.0 / at_rest;
    }
    let far =
        if a3 < 0.0 { 0.5 * (discriminant.sqrt() - a3) / a4 } else { -2.0 * a2 / (discriminant.sqrt() + a3) };
    // A lower end near zero stands for the limit y → 0, where the compliance is `at_rest`.
    let near = (a2 / (a4 * far)).max(1e-9 * far);
    let middle = ((a3 * a3 - 3.0 * a4 * a2).sqrt() - a3) / (3.0 * a4);
    let largest = curve.tangent_compliance(middle, near, far);
    1.0 / largest.unwrap_or_else(|| curve.largest_compliance(near, far)).max(at_rest)
}

/// The curve F(y; q) = 0 over y = ω²/k, with q = 1/k.
struct TangencyCurve {
    m1: f64,
    m2: f64,
    /// bᵢ² + 2 bᵢ c.
    d1: f64,
    d2: f64,
    /// c².
    g: f64,
}

impl TangencyCurve {
    /// The coefficients of y², y³ and y⁴ of F with free handles at the compliance q.
    fn quadratic_coefficients(&self, q: f64) -> [f64; 3] {
        let (f1, f2) = (self.d1 * q - 2.0 * self.m1, self.d2 * q - 2.0 * self.m2);
        let g = self.g * q;
        let (s1, s2) = (self.m1 * self.m1, self.m2 * self.m2);
        [s1 + s2 + f1 * f2 + g * (f1 + f2), (f1 + g) * s2 + (f2 + g) * s1, s1 * s2]
    }

    /// The unique compliance q > 0 with F(y; q) = 0 with free handles, for a y with F(y; 0) ≤ 0.
    fn compliance(&self, y: f64) -> f64 {
        let (a1, a2) = ((1.0 - self.m1 * y).powi(2), (1.0 - self.m2 * y).powi(2));
        let square = (self.d1 * self.d2 + self.g * (self.d1 + self.d2)) * y * y;
        let linear = (a1 * self.d2 + a2 * self.d1 + self.g * (a1 + a2 - 2.0)) * y;
        // 1 − a₁a₂ from its factors keeps the digits at small y.
        let product = (1.0 - self.m1 * y) * (1.0 - self.m2 * y);
        let sum = y * (self.m1 + self.m2 - self.m1 * self.m2 * y);
        let constant = sum * (1.0 + product);
        let root = (linear * linear + 4.0 * square * constant).sqrt();
        if linear >= 0.0 { 2.0 * constant / (linear + root) } else { 0.5 * (root - linear) / square }
    }

    /// The compliance at which F touches zero with free handles, by Newton's iteration in y and q on G = F/y
    /// and ∂G/∂y from the curve at `y`; `None` if it does not converge between `near` and `far` in a few
    /// steps. Between them the compliance has one stationary point, its maximum.
    fn tangent_compliance(&self, mut y: f64, near: f64, far: f64) -> Option<f64> {
        let (s1, s2) = (self.m1 * self.m1, self.m2 * self.m2);
        let mut q = self.compliance(y);
        for _ in 0..8 {
            let (f1, f2) = (self.d1 * q - 2.0 * self.m1, self.d2 * q - 2.0 * self.m2);
            let [a2, a3, a4] = self.quadratic_coefficients(q);
            // Derivatives of the coefficients with respect to q.
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
            // The next step would be about the square of this one; an error ε in y costs ε² in q.
            if step.abs() <= 1e-6 * y {
                return Some(self.compliance(y));
            }
        }
        None
    }

    /// The maximum compliance with free handles between `near` and `far`. It is quasi-concave there: F/y is a
    /// cubic in y, so that {q > q₀} is one interval for every q₀ above the end values.
    fn largest_compliance(&self, near: f64, far: f64) -> f64 {
        // The sign of ∂(F/y)/∂y on the curve is that of −dq/dy; false position with the
        // Anderson–Björck weight finds its zero. An error ε in y costs only ε² in q.
        let slope = |y: f64| {
            let q = self.compliance(y);
            let [a2, a3, a4] = self.quadratic_coefficients(q);
            (a2 + y * (2.0 * a3 + y * 3.0 * a4), q)
        };
        let (mut older, mut newer) = (near, far);
        let (mut at_older, q_near) = slope(older);
        let (mut at_newer, q_far) = slope(newer);
        let mut best = q_near.max(q_far);
        // Halving alone narrows the range from `far` to 1e-8 of `near` within 60 steps.
        for step in 0..120 {
            let proposed = (older * at_newer - newer * at_older) / (at_newer - at_older);
            let between = step < 60 && (proposed - older) * (proposed - newer) < 0.0;
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
