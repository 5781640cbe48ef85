//! Special functions of the distributions of a delay.

/// The distribution function of the standard normal distribution, for a trace's delays.
pub fn normal_cumulative(x: f64) -> f64 {
    // erfc(z) = Q(1/2, z²) for z ≥ 0
    let half = 0.5 * (1.0 - gamma_cumulative(0.5, 0.5 * x * x));
    if x > 0.0 { 1.0 - half } else { half }
}

/// The distribution function of the gamma distribution with this shape and scale 1, for a trace's delays: the
/// regularised lower incomplete gamma function.
///
/// By its series below shape + 1 and its continued fraction above: M. Abramowitz and I. A. Stegun, Handbook of
/// Mathematical Functions, 6.5.29 and 6.5.31.
pub fn gamma_cumulative(shape: f64, x: f64) -> f64 {
    const MOST_TERMS: usize = 1_000_000;
    if !(x > 0.0) {
        return 0.0;
    }
    let factor = (shape * x.ln() - x - ln_gamma(shape)).exp();
    if x < shape + 1.0 {
        let (mut term, mut sum) = (1.0 / shape, 1.0 / shape);
        for n in 1..MOST_TERMS {
            term *= x / (shape + n as f64);
            sum += term;
            if term < sum * f64::EPSILON {
                break;
            }
        }
        return (factor * sum).clamp(0.0, 1.0);
    }
    // the modified method of Lentz
    const TINY: f64 = 1e-300;
    let mut b = x + 1.0 - shape;
    let mut c = 1.0 / TINY;
    let mut d = 1.0 / b;
    let mut fraction = d;
    for n in 1..MOST_TERMS {
        let a = -(n as f64) * (n as f64 - shape);
        b += 2.0;
        d = 1.0 / not_zero(a * d + b);
        c = not_zero(b + a / c);
        fraction *= d * c;
        if (d * c - 1.0).abs() < 4.0 * f64::EPSILON {
            break;
        }
    }
    return (1.0 - factor * fraction).clamp(0.0, 1.0);

    fn not_zero(value: f64) -> f64 {
        if value.abs() < TINY { TINY } else { value }
    }
}

/// The logarithm of the gamma function above 0, for a trace's delays, by Stirling's series from 12 on (Abramowitz and
/// Stegun 6.1.41).
pub fn ln_gamma(x: f64) -> f64 {
    let (mut x, mut below) = (x, 1.0);
    while x < 12.0 {
        below *= x;
        x += 1.0;
    }
    let inverse = 1.0 / (x * x);
    let series = (1.0 / 12.0
        - inverse
            * (1.0 / 360.0 - inverse * (1.0 / 1260.0 - inverse * (1.0 / 1680.0 - inverse * (1.0 / 1188.0)))))
        / x;
    (x - 0.5) * x.ln() - x + 0.5 * (2.0 * std::f64::consts::PI).ln() + series - below.ln()
}

/// The digamma function above 0, for a trace's delays (Abramowitz and Stegun 6.3.18).
pub fn digamma(x: f64) -> f64 {
    let (mut x, mut below) = (x, 0.0);
    while x < 12.0 {
        below += 1.0 / x;
        x += 1.0;
    }
    let inverse = 1.0 / (x * x);
    let series = inverse
        * (1.0 / 12.0
            - inverse * (1.0 / 120.0 - inverse * (1.0 / 252.0 - inverse * (1.0 / 240.0 - inverse / 132.0))));
    x.ln() - 0.5 / x - series - below
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ref_special_functions_have_their_closed_forms() {
        // Γ(1/2) = √π, Γ(n) = (n − 1)!, ψ(1) = −γ, ψ(1/2) = −γ − 2 ln 2
        let gamma = 0.577_215_664_901_532_9;
        assert!((ln_gamma(0.5) - 0.5 * std::f64::consts::PI.ln()).abs() < 1e-14);
        assert!((ln_gamma(11.0) - 3_628_800_f64.ln()).abs() < 1e-13);
        assert!((digamma(1.0) + gamma).abs() < 1e-14);
        assert!((digamma(0.5) + gamma + 2.0 * 2.0_f64.ln()).abs() < 1e-14);
        // P(1, x) = 1 − e^−x and P(3, x) = 1 − e^−x (1 + x + x²/2)
        for x in [1e-3, 0.5, 2.0, 3.9, 4.1, 30.0] {
            let e = f64::exp(-x);
            assert!((gamma_cumulative(1.0, x) - (1.0 - e)).abs() < 1e-14, "{x}");
            assert!((gamma_cumulative(3.0, x) - (1.0 - e * (1.0 + x + 0.5 * x * x))).abs() < 1e-14, "{x}");
        }
        // Abramowitz and Stegun, table 26.1
        assert!((normal_cumulative(1.0) - 0.841_344_746_068_543).abs() < 1e-14);
        assert!((normal_cumulative(-2.0) - 0.022_750_131_948_179).abs() < 1e-14);
        assert_eq!(normal_cumulative(0.0), 0.5);
    }
}
