//! Roots of small polynomials: starts for the root search and turning points for the root count.

use num_complex::Complex64;

/// All complex roots of a real polynomial of low degree, constant coefficient first, by the simultaneous
/// iteration of Ehrlich and Aberth from radii on the Newton polygon (Bini 1996).
pub(super) fn complex_roots(coefficients: &[f64]) -> Vec<Complex64> {
    let zeros = coefficients.iter().take_while(|c| **c == 0.0).count();
    let polynomial = &coefficients[zeros..];
    let mut roots = vec![Complex64::ZERO; zeros.min(coefficients.len().saturating_sub(1))];
    if polynomial.len() < 2 {
        return roots;
    }
    let mut iterates = polygon_starts(polynomial);
    let evaluate = |x: Complex64| {
        polynomial
            .iter()
            .rev()
            .fold((Complex64::ZERO, Complex64::ZERO), |(value, slope), &c| (value * x + c, slope * x + value))
    };
    for _ in 0..100 {
        let mut moved = false;
        for i in 0..iterates.len() {
            let x = iterates[i];
            let (value, slope) = evaluate(x);
            if value == Complex64::ZERO {
                continue;
            }
            let repulsion: Complex64 = iterates
                .iter()
                .enumerate()
                .filter(|&(j, other)| j != i && *other != x)
                .map(|(_, &other)| (x - other).inv())
                .sum();
            let step = value / (slope - value * repulsion);
            if step.norm().is_finite() {
                iterates[i] = x - step;
                moved |= step.norm() > 1e-15 * x.norm();
            }
        }
        if !moved {
            break;
        }
    }
    roots.append(&mut iterates);
    roots
}

/// One start per root of the polynomial, on circles whose radii follow from the upper hull of (i, ln|aᵢ|).
fn polygon_starts(polynomial: &[f64]) -> Vec<Complex64> {
    let heights: Vec<f64> = polynomial.iter().map(|c| c.abs().ln()).collect();
    let degree = polynomial.len() - 1;
    let mut starts = Vec::with_capacity(degree);
    let mut from = 0;
    while from < degree {
        let slope = |to: usize| (heights[to] - heights[from]) / (to - from) as f64;
        let mut to = from + 1;
        for next in from + 2..=degree {
            if slope(next) >= slope(to) {
                to = next;
            }
        }
        let radius = (-slope(to)).exp();
        for i in 0..to - from {
            // An irregular first angle: no start may lie on an axis of symmetry.
            let angle = std::f64::consts::TAU * i as f64 / (to - from) as f64 + 0.7 + from as f64;
            starts.push(Complex64::from_polar(radius, angle));
        }
        from = to;
    }
    starts
}

/// The real roots, ascending, of a polynomial of degree up to four with a nonzero leading coefficient,
/// constant coefficient first. The roots of the derivative separate those of the polynomial.
///
/// A double root that rounding lifts off the axis is omitted; one that rounding splits appears twice.
pub(super) fn real_roots(coefficients: &[f64]) -> Vec<f64> {
    let degree = coefficients.len() - 1;
    let leading = coefficients[degree];
    match degree {
        0 => return Vec::new(),
        1 => return vec![-coefficients[0] / leading],
        2 => {
            let half = -0.5 * coefficients[1] / leading;
            let constant = coefficients[0] / leading;
            let discriminant = half * half - constant;
            if discriminant < 0.0 {
                return Vec::new();
            }
            let far = half + discriminant.sqrt().copysign(half);
            let near = if far == 0.0 { 0.0 } else { constant / far };
            return vec![far.min(near), far.max(near)];
        }
        _ => {}
    }
    let derivative: Vec<f64> = (1..=degree).map(|i| i as f64 * coefficients[i]).collect();
    let turns = real_roots(&derivative);
    let evaluate = |x: f64| {
        coefficients.iter().rev().fold((0.0, 0.0), |(value, slope), c| (value * x + c, slope * x + value))
    };
    // Fujiwara's bound on the modulus of every root.
    let bound = (0..degree)
        .map(|i| (coefficients[i] / leading).abs().powf(1.0 / (degree - i) as f64))
        .fold(0.0, f64::max)
        * 2.0;
    if bound == 0.0 {
        return vec![0.0];
    }
    let mut roots = Vec::new();
    let mut edges = vec![-bound];
    edges.extend(turns.into_iter().map(|x| x.clamp(-bound, bound)));
    edges.push(bound);
    for edge in edges.windows(2) {
        let (mut low, mut high) = (edge[0], edge[1]);
        let low_negative = evaluate(low).0 < 0.0;
        if low_negative == (evaluate(high).0 < 0.0) {
            continue;
        }
        let mut x = 0.5 * (low + high);
        for _ in 0..100 {
            let (value, slope) = evaluate(x);
            if (value < 0.0) == low_negative {
                low = x;
            } else {
                high = x;
            }
            let newton = x - value / slope;
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            let done = (next - x).abs() <= 1e-14 * x.abs() || next == low || next == high;
            x = next;
            if done {
                break;
            }
        }
        roots.push(x);
    }
    roots
}
