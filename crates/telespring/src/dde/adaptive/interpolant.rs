//! The Dormand–Prince pair and its continuous extension: coefficients and the polynomial of one step.
//!
//! J. R. Dormand and P. J. Prince (1980), "A family of embedded Runge-Kutta formulae", J. Comput. Appl. Math. 6,
//! 19-26; continuous extension of order 4 by Shampine as in Hairer, Nørsett and Wanner (1993), "Solving Ordinary
//! Differential Equations I", 2nd ed., section II.6. A delay equation whose lookups carry a local error of h⁵
//! still converges with the pair's order 5, since the right-hand side is multiplied by h.

/// The order of the advancing formula.
pub(super) const ORDER: u32 = 5;

/// The stages of the pair; the last is the first of the next step unless a break lies between.
pub(super) const STAGES: usize = 7;

/// Polynomial coefficients per component and step.
pub(super) const COEFFICIENTS: usize = 5;

/// The nodes of the stages, as fractions of the step.
pub(super) const NODES: [f64; STAGES] = [0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0];

/// Row i has the weights of the earlier stages for stage i + 1; the last row is also the formula of order
/// 5.
pub(super) const WEIGHTS: [&[f64]; STAGES - 1] = [
    &[0.2],
    &[3.0 / 40.0, 9.0 / 40.0],
    &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
    &[19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0],
    &[9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0],
    &[35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];

/// The formula of order 5 minus the embedded formula of order 4.
pub(super) const ERROR: [f64; STAGES] =
    [71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339_200.0, 22.0 / 525.0, -1.0 / 40.0];

/// The weights that raise the cubic Hermite polynomial of a step to order 4.
const DENSE: [f64; STAGES] = [
    -12_715_105_075.0 / 11_282_082_432.0,
    0.0,
    87_487_479_700.0 / 32_700_410_799.0,
    -10_690_763_975.0 / 1_880_347_072.0,
    701_980_252_875.0 / 199_316_789_632.0,
    -1_453_857_185.0 / 822_651_844.0,
    69_997_945.0 / 29_380_423.0,
];

/// Writes the interpolant of a step of width `width` from `old` to `new` into `coefficients`: five blocks
/// with one value per component.
pub(super) fn fit_polynomial(
    width: f64,
    old: &[f64],
    new: &[f64],
    stages: &[Vec<f64>; STAGES],
    coefficients: &mut [f64],
) {
    let dimension = old.len();
    for i in 0..dimension {
        let rise = new[i] - old[i];
        let start = width * stages[0][i] - rise;
        let end = rise - width * stages[6][i] - start;
        let mut lift = 0.0;
        for (weight, stage) in DENSE.iter().zip(stages) {
            lift += weight * stage[i];
        }
        coefficients[i] = old[i];
        coefficients[dimension + i] = rise;
        coefficients[2 * dimension + i] = start;
        coefficients[3 * dimension + i] = end;
        coefficients[4 * dimension + i] = width * lift;
    }
}

/// Writes the straight line from `old` with slope `slope` as an interpolant of the same form.
pub(super) fn straight_line(width: f64, old: &[f64], slope: &[f64], coefficients: &mut [f64]) {
    let dimension = old.len();
    coefficients.fill(0.0);
    for i in 0..dimension {
        coefficients[i] = old[i];
        coefficients[dimension + i] = width * slope[i];
    }
}

/// The interpolant of a step at the fraction `theta` of its step.
pub(super) fn evaluate_polynomial(coefficients: &[f64], theta: f64, out: &mut [f64]) {
    let dimension = out.len();
    let rest = 1.0 - theta;
    for (i, value) in out.iter_mut().enumerate() {
        let c = |k: usize| coefficients[k * dimension + i];
        *value = c(0) + theta * (c(1) + rest * (c(2) + theta * (c(3) + rest * c(4))));
    }
}

/// The time derivative of the interpolant of a step of width `width`.
pub(super) fn differentiate_polynomial(coefficients: &[f64], theta: f64, width: f64, out: &mut [f64]) {
    let dimension = out.len();
    let rest = 1.0 - theta;
    for (i, value) in out.iter_mut().enumerate() {
        let c = |k: usize| coefficients[k * dimension + i];
        let inner = c(3) + rest * c(4);
        let middle = c(2) + theta * inner;
        let middle_slope = inner - theta * c(4);
        let outer = c(1) + rest * middle;
        let outer_slope = rest * middle_slope - middle;
        *value = (outer + theta * outer_slope) / width;
    }
}
