//! The dyad under two sampled controllers: the spectral radius of the one-period map.
//!
//! Both controllers read position and velocity every h, hold the force over one period and see the
//! partner N_f or N_b whole periods late. With qᵢ and nᵢ the exact held plant and the force it returns
//! ([`HeldSide`]), the multipliers z solve
//! (q₁ + n₁)(q₂ + n₂) − n₁ n₂ z^(−N) = 0, N = N_f + N_b; no matrix with N delay lines is formed.
//! The search runs in s = ln(z)/h and bisects on a count of the multipliers outside a circle, so that a
//! delay of 100 s at 1 kHz costs milliseconds and none is missed.

use num_complex::Complex64;

use super::Network;
use super::contour::{self, Ended};
use super::held::HeldSide;
use crate::error::{InvalidInput, Result};
use crate::model::DyadAxis;
use crate::quantity;

/// The slowest multiplier of the sampled dyad; the rigid-body multiplier z = 1 is set apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampledSpectrum {
    /// The largest |z|: below 1 the sampled dyad is stable.
    pub radius: f64,
    /// ln(radius)/h, 1/s: to compare with the spectral abscissa of the continuous dyad.
    pub abscissa_equivalent: f64,
    /// |arg z|/h, rad/s: the frequency at which this multiplier turns.
    pub frequency: f64,
    /// What is proven about it.
    pub certificate: SampledCertificate,
}

impl SampledSpectrum {
    /// True where all multipliers but the rigid-body one lie inside the unit circle.
    pub fn is_stable(&self) -> bool {
        self.radius < 1.0
    }
}

/// What is proven about a [`SampledSpectrum`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum SampledCertificate {
    /// A multiplier was refined at this radius, and a count on a circle just outside found no other.
    Complete,
    /// All multipliers lie within this radius; none was resolved on it (they decay within a few ticks).
    UpperBound,
    /// The count ended before it could decide: the radius is the best found, a larger one may exist.
    Incomplete,
}

/// The characteristic function of one sampled axis in s, the rigid-body root divided out.
#[derive(Debug, Clone)]
pub(super) struct Characteristic {
    /// q₁ q₂ + q₁ n₂ + q₂ n₁ in w = z − 1 (over w where the handles are free), constant term first.
    pub undelayed: Vec<f64>,
    /// n₁ n₂ in w.
    pub delayed: Vec<f64>,
    /// N, the round trip in periods.
    pub ticks: f64,
    /// h, s.
    pub period: f64,
    /// True where w has been divided out.
    pub deflated: bool,
}

/// e^x − 1 without cancellation.
pub(super) fn exp_m1(x: Complex64) -> Complex64 {
    let half = (0.5 * x.im).sin();
    Complex64::new(x.re.exp_m1() * x.im.cos() - 2.0 * half * half, x.re.exp() * x.im.sin())
}

fn multiply(a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; a.len() + b.len() - 1];
    for (i, x) in a.iter().enumerate() {
        for (j, y) in b.iter().enumerate() {
            product[i + j] += x * y;
        }
    }
    product
}

/// Value and derivative of a polynomial, constant term first.
fn evaluate(polynomial: &[f64], w: Complex64) -> (Complex64, Complex64) {
    let zero = Complex64::ZERO;
    polynomial
        .iter()
        .rev()
        .fold((zero, zero), |(value, slope), &coefficient| (value * w + coefficient, slope * w + value))
}

impl Characteristic {
    pub fn new(axis: &DyadAxis, stiffness: f64, network: &Network) -> Self {
        let [q, n]: [Vec<Vec<f64>>; 2] = {
            let sides = axis
                .sides
                .map(|side| HeldSide::new(&side, network.sample_period(), network.computing_time()));
            [
                sides.iter().map(HeldSide::denominator).collect(),
                sides.iter().map(|side| side.numerator(stiffness, axis.coupling_damping)).collect(),
            ]
        };
        let mut undelayed = multiply(&q[0], &q[1]);
        for product in [multiply(&q[0], &n[1]), multiply(&q[1], &n[0])] {
            for (sum, part) in undelayed.iter_mut().zip(product) {
                *sum += part;
            }
        }
        let deflated = axis.is_free();
        if deflated {
            // Exactly 0: q₁ and q₂ both carry the factor w.
            undelayed.remove(0);
        }
        let [forward, backward] = network.whole_ticks();
        Self {
            undelayed,
            delayed: multiply(&n[0], &n[1]),
            ticks: (forward + backward) as f64,
            period: network.sample_period(),
            deflated,
        }
    }

    /// Value and derivative by s.
    fn value(&self, s: Complex64) -> (Complex64, Complex64) {
        let w = exp_m1(s * self.period);
        let (c, c_slope) = evaluate(&self.undelayed, w);
        let (b, b_slope) = evaluate(&self.delayed, w);
        let (e, e_slope) = self.echo(s, w);
        let slope = c_slope + b_slope * e + b * e_slope;
        (c + b * e, slope * (w + 1.0) * self.period)
    }

    /// 1 − z^(−N), over w where deflated, and its derivative by w.
    pub fn echo(&self, s: Complex64, w: Complex64) -> (Complex64, Complex64) {
        let n = self.ticks;
        let lost = -exp_m1(-s * (self.period * n));
        let turned = (1.0 - lost) * n / (1.0 + w);
        if !self.deflated {
            return (lost, turned);
        }
        if w.norm() * n.max(1.0) < 1e-3 {
            let value = if w == Complex64::ZERO { Complex64::from(n) } else { lost / w };
            // Two terms of Σ_j −j z^(−j−1): only the speed of Newton's method hangs on them.
            return (value, -0.5 * n * (n + 1.0) + w * (n * (n + 1.0) * (n + 2.0) / 3.0));
        }
        let value = lost / w;
        (value, (turned - value) / w)
    }

    /// Newton from `s`: the root and the size of the last step, where it converges.
    fn refine(&self, start: Complex64, scale: f64) -> Option<(Complex64, f64)> {
        let mut s = start;
        let mut step = f64::INFINITY;
        for _ in 0..60 {
            let (value, slope) = self.value(s);
            let change = value / slope;
            if !change.is_finite() {
                return (value == Complex64::ZERO).then_some((s, 0.0));
            }
            s -= change;
            let previous = step;
            step = change.norm();
            if step <= 1e-15 * scale || (step <= 1e-11 * scale && step >= 0.5 * previous) {
                return Some((s, step));
            }
        }
        (step <= 1e-6 * scale).then_some((s, step))
    }

    /// A rate (1/s) on which the fastest part of the loop and the round trip act.
    fn scale(&self, axis: &DyadAxis, stiffness: f64) -> f64 {
        let fastest = axis
            .sides
            .iter()
            .map(|side| {
                (side.damping + axis.coupling_damping) / side.mass
                    + ((stiffness + side.ground_stiffness) / side.mass).sqrt()
            })
            .fold(0.0, f64::max);
        1.0 / (self.ticks * self.period + 1.0 / fastest)
    }

    /// The deepest decay rate (1/s) at which powers of z stay in range.
    fn floor(&self) -> f64 {
        -(600.0 / (self.ticks + 8.0)).min(40.0) / self.period
    }

    /// The count of multipliers with |z| > e^(σ h) and places near which they may lie. Where a root lies
    /// on the circle, a circle beside it by 1e-9 of `scale` is taken.
    fn count(&self, rate: f64, scale: f64) -> Option<(usize, Vec<Complex64>)> {
        for shift in [0.0, 1e-9, -1.7e-9, 1.3e-8] {
            match contour::count_outside(self, rate + shift * scale) {
                Ok(count) => return Some(count),
                Err(Ended::TooLong) => return None,
                Err(Ended::RootOnCircle) => {}
            }
        }
        None
    }

    /// The rightmost s = ln(z)/h.
    fn rightmost(&self, scale: f64) -> (Complex64, SampledCertificate) {
        let incomplete = |s: Complex64| (s, SampledCertificate::Incomplete);
        let Some((outside, mut places)) = self.count(0.0, scale) else {
            return incomplete(Complex64::ZERO);
        };
        // Bracket: some multiplier right of `low`, none right of `high`.
        let (mut low, mut high) = (0.0, 0.0);
        let mut reach = scale;
        loop {
            let rate = if outside == 0 { (-reach).max(self.floor()) } else { reach };
            match self.count(rate, scale) {
                Some((0, _)) if outside == 0 => high = rate,
                Some((_, found)) if outside == 0 => {
                    (low, places) = (rate, found);
                    break;
                }
                Some((0, _)) => {
                    high = rate;
                    break;
                }
                Some((_, found)) => (low, places) = (rate, found),
                None => return incomplete(Complex64::from(high.max(low))),
            }
            if rate <= self.floor() {
                return (Complex64::from(high), SampledCertificate::UpperBound);
            }
            reach *= 2.0;
        }
        for _ in 0..80 {
            if let Some((root, error)) = self.best_root(&places, low, high, scale) {
                let beside = root.re + (1e-9 * (scale + root.norm())).max(10.0 * error);
                match contour::count_outside(self, beside) {
                    Ok((0, _)) => return (root, SampledCertificate::Complete),
                    Ok((_, found)) => {
                        (low, places) = (beside, found);
                        high = high.max(low);
                    }
                    Err(_) => return incomplete(root),
                }
            }
            let middle = 0.5 * (low + high);
            if high - low <= 1e-12 * (scale + high.abs()) {
                break;
            }
            match self.count(middle, scale) {
                Some((0, _)) => high = middle,
                Some((_, found)) => (low, places) = (middle, found),
                None => break,
            }
        }
        incomplete(Complex64::from(high))
    }

    /// The rightmost root that Newton's method finds from the places, within the bracket.
    fn best_root(&self, places: &[Complex64], low: f64, high: f64, scale: f64) -> Option<(Complex64, f64)> {
        let slack = 1e-8 * scale;
        places
            .iter()
            .filter_map(|&place| self.refine(place, scale + place.norm()))
            .filter(|(root, _)| root.re >= low - slack && root.re <= high + slack)
            .max_by(|a, b| a.0.re.total_cmp(&b.0.re))
    }
}

/// The spectral radius of the one-period map of one axis under sampled controllers.
///
/// `stiffness` in N/m. The delays are those behind a playout buffer
/// ([`Network::buffered`]), rounded up to whole periods as a sampled controller sees them.
///
/// # Errors
///
/// [`InvalidInput`] where the stiffness is out of range or the network has no sample period.
///
/// # Examples
///
/// ```
/// use telespring::{Delay, DyadAxis};
/// use telespring::criteria::verdicts::{Network, sampled_spectral_radius};
/// let axis = DyadAxis::new(0.8334, 7.7257, 0.7776, 7.4208)?;
/// let network = Network::new(Delay::each_way(0.1)?, 0.0, 0.0, 0.001, 0.0)?;
/// assert!(sampled_spectral_radius(&axis, 71.2, &network)?.is_stable());
/// let network = Network::new(Delay::each_way(0.2)?, 0.0, 0.0, 0.001, 0.0)?;
/// assert!(!sampled_spectral_radius(&axis, 71.2, &network)?.is_stable());
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
pub fn sampled_spectral_radius(
    axis: &DyadAxis,
    stiffness: f64,
    network: &Network,
) -> Result<SampledSpectrum> {
    quantity::STIFFNESS.check("stiffness", stiffness)?;
    if network.sample_period() == 0.0 {
        return Err(InvalidInput::new(
            "network.sample_period",
            0.0,
            "a sampled verdict needs a sample period above 0",
            "State the period of the controllers, such as 0.001, or use the continuous verdict.",
        ));
    }
    let characteristic = Characteristic::new(axis, stiffness, network);
    let (root, certificate) = characteristic.rightmost(characteristic.scale(axis, stiffness));
    Ok(SampledSpectrum {
        radius: (root.re * network.sample_period()).exp(),
        abscissa_equivalent: root.re,
        frequency: root.im.abs(),
        certificate,
    })
}

/// The largest stiffness (N/m) up to `limit` below which the sampled dyad is stable, from a count on the
/// unit circle at levels and a bisection below the first level that fails.
///
/// `limit` infinite stands for the stiffness beyond which no held spring can be stable.
pub(super) fn stiffness_bound(axis: &DyadAxis, network: &Network, limit: f64) -> f64 {
    const LEVELS: i32 = 40;
    // A held spring on a free mass without damping diverges at any k; with damping, above 2 B/h or so.
    let strongest = axis
        .sides
        .iter()
        .map(|side| {
            let h = network.sample_period();
            8.0 * (side.mass / (h * h) + side.damping / h) + side.ground_stiffness
        })
        .fold(0.0, f64::max);
    let limit = limit.min(strongest);
    if limit <= 0.0 {
        return 0.0;
    }
    // Unknown where the count cannot be ended: the search stops at what is proven.
    let holds = |k: f64| match contour::count_outside(&Characteristic::new(axis, k, network), 0.0) {
        Ok((outside, _)) => Some(outside == 0),
        Err(Ended::RootOnCircle) => Some(false),
        Err(Ended::TooLong) => None,
    };
    let mut low = 0.0;
    let mut high = None;
    for level in 0..=LEVELS {
        // The last level stands just inside: the limit itself may be a boundary.
        let k = limit * (1.0 - 1e-9) * 1e4_f64.powf(f64::from(level - LEVELS) / f64::from(LEVELS));
        match holds(k) {
            Some(true) => low = k,
            Some(false) => {
                high = Some(k);
                break;
            }
            None => return low,
        }
    }
    let Some(mut high) = high else { return limit };
    // Without a level that held the search starts far below any stiffness that is of use.
    if low == 0.0 {
        low = 1e-6;
        if low >= high || holds(low) != Some(true) {
            return 0.0;
        }
    }
    while high - low > 1e-12 * high {
        let middle = 0.5 * (low + high);
        match holds(middle) {
            Some(true) => low = middle,
            Some(false) => high = middle,
            None => break,
        }
    }
    low
}
