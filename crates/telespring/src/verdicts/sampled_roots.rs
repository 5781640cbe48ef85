//! The slowest multiplier of a sampled axis, found by counting the multipliers outside circles.
//!
//! The search runs in s = ln(z)/h and bisects on the count. A delay of 100 s at 1 kHz takes milliseconds,
//! and no multiplier is missed.

use num_complex::Complex64;

use super::contour::{self, CountFailure};
use super::sampled_characteristic::SampledCharacteristic;

/// The slowest multiplier of the sampled dyad, apart from the rigid-body multiplier z = 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampledSpectrum {
    /// The largest |z|.
    pub radius: f64,
    /// ln(radius)/h, 1/s, comparable with the spectral abscissa of the continuous dyad: the sampled dyad is stable
    /// if it is negative.
    pub abscissa_equivalent: f64,
    /// |arg z|/h, rad/s: the frequency of this multiplier.
    pub frequency: f64,
    /// What is proven about it.
    pub certificate: SampledCertificate,
}

impl SampledSpectrum {
    /// True if all multipliers but the rigid-body one lie inside the unit circle. The rate decides: the radius of
    /// a slow motion rounds to 1.
    pub fn is_stable(&self) -> bool {
        self.abscissa_equivalent < 0.0
    }
}

/// What is proven about a [`SampledSpectrum`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum SampledCertificate {
    /// A multiplier was refined at this radius, and a count on a circle just outside found no other.
    Complete,
    /// All multipliers lie within this radius; none was resolved (they decay within a few periods).
    UpperBound,
    /// The count failed before it could decide: a larger multiplier may exist.
    Incomplete,
}

impl SampledCharacteristic {
    /// Newton's method from `start`: the root and the size of the last step, if it converges.
    fn refine_multiplier(&self, start: Complex64, scale: f64) -> Option<(Complex64, f64)> {
        let mut s = start;
        let mut step = f64::INFINITY;
        for _ in 0..60 {
            let (value, slope) = self.value_and_derivative(s);
            let change = value / slope;
            if !change.is_finite() {
                return (value == Complex64::ZERO).then_some((s, 0.0));
            }
            s -= change;
            let previous = step;
            step = change.norm();
            // Relative to the root: the sign of a slow motion's rate decides on stability.
            if step <= 1e-15 * s.norm() || (step <= 1e-11 * scale && step >= 0.5 * previous) {
                return Some((s, step));
            }
        }
        (step <= 1e-6 * scale).then_some((s, step))
    }

    /// The number of multipliers, roots of the sampled axis, with |z| > e^(σ h), and points near which they
    /// may lie. If a root lies on the circle, a circle 1e-9 of `scale` away from it is used.
    fn count_right_of(&self, rate: f64, scale: f64) -> Option<(usize, Vec<Complex64>)> {
        for shift in [0.0, 1e-9, -1.7e-9, 1.3e-8] {
            match contour::count_outside_circle(self, rate + shift * scale) {
                Ok(count) => return Some(count),
                Err(CountFailure::TooLong) => return None,
                Err(CountFailure::RootOnCircle) => {}
            }
        }
        None
    }

    /// The rightmost s = ln(z)/h of the sampled axis, with its certificate.
    pub fn rightmost_root(&self, scale: f64) -> (Complex64, SampledCertificate) {
        let incomplete = |s: Complex64| (s, SampledCertificate::Incomplete);
        let Some((outside, mut places)) = self.count_right_of(0.0, scale) else {
            return incomplete(Complex64::ZERO);
        };
        // Bracket: some multiplier right of `low`, none right of `high`.
        let (mut low, mut high) = (0.0, 0.0);
        let mut reach = scale;
        loop {
            let rate = if outside == 0 { (-reach).max(self.deepest_rate()) } else { reach };
            match self.count_right_of(rate, scale) {
                Some((0, _)) if outside == 0 => high = rate,
                Some((_, next_places)) if outside == 0 => {
                    (low, places) = (rate, next_places);
                    break;
                }
                Some((0, _)) => {
                    high = rate;
                    break;
                }
                Some((_, next_places)) => (low, places) = (rate, next_places),
                None => return incomplete(Complex64::from(high.max(low))),
            }
            if rate <= self.deepest_rate() {
                return (Complex64::from(high), SampledCertificate::UpperBound);
            }
            reach *= 2.0;
        }
        for _ in 0..80 {
            if let Some((root, error)) = self.rightmost_refined(&places, low, high, scale) {
                let beside = root.re + (1e-9 * (scale + root.norm())).max(10.0 * error);
                match contour::count_outside_circle(self, beside) {
                    Ok((0, _)) => return (root, SampledCertificate::Complete),
                    Ok((_, next_places)) => {
                        (low, places) = (beside, next_places);
                        high = high.max(low);
                    }
                    Err(_) => return incomplete(root),
                }
            }
            let middle = 0.5 * (low + high);
            if high - low <= 1e-12 * (scale + high.abs()) {
                break;
            }
            match self.count_right_of(middle, scale) {
                Some((0, _)) => high = middle,
                Some((_, next_places)) => (low, places) = (middle, next_places),
                None => break,
            }
        }
        incomplete(Complex64::from(high))
    }

    /// The rightmost root to which Newton's method converges from the given points, within the bracket.
    fn rightmost_refined(
        &self,
        places: &[Complex64],
        low: f64,
        high: f64,
        scale: f64,
    ) -> Option<(Complex64, f64)> {
        let slack = 1e-8 * scale;
        places
            .iter()
            .filter_map(|&place| self.refine_multiplier(place, scale + place.norm()))
            .filter(|(root, _)| root.re >= low - slack && root.re <= high + slack)
            .max_by(|a, b| a.0.re.total_cmp(&b.0.re))
    }
}
