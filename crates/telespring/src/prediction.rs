//! What a predictor does to the loop: a rational filter in front of the delay.
//!
//! At a constant age δ the partner's motion of one age ago becomes H(s) e^(−δ s) times the partner's motion now:
//!
//! * hold: H = 1;
//! * linear: H = 1 + δ s;
//! * Kalman, after it has settled: with the estimates x̂, v̂, â of the filter H = x̂ + δ v̂ (+ ½ δ² â);
//! * shared target: H = 1. The target does not depend on the robots, so that it adds an input and changes no root.
//!
//! The settled filter is that of Kalman and Bucy (1961): in continuous time the error covariance of n integrators behind
//! white noise q, with position noise of density r, gives a Butterworth filter d(s) of cut-off ω = (q/r)^(1/2n), n = 2
//! for constant velocity and 3 for constant acceleration. Samples of standard deviation σ at every period h have the
//! density r = σ² h. With d(0) = 1 the estimates are the truncations of d: x̂ = \[d\]₀ⁿ⁻¹, v̂ = s \[d\]₀ⁿ⁻², â = s² \[d\]₀ⁿ⁻³.

use num_complex::Complex64;

use crate::error::{InvalidInput, Result};
use crate::quantity;
use crate::session::architecture::{KalmanDesign, PredictorDesign};
use crate::session::predictor::{Kalman, MotionModel};

/// The coefficients of a polynomial of degree up to 3 in s, constant first.
pub(crate) type Cubic = [f64; 4];

/// The largest cut-off times the sample period: beyond it, the sampled filter is slower than the continuous one says.
const LARGEST_CUTOFF: f64 = 1.0;

/// A predictor as a part of the loop, for its verdicts.
///
/// # Examples
///
/// ```
/// use telespring::prediction::Prediction;
/// use telespring::session::architecture::PredictorDesign;
/// let linear = Prediction::new(PredictorDesign::Linear, 1e-3)?;
/// let response = linear.response(10.0, 0.1); // (1 + 1j) e^(−1j)
/// assert!((response.norm() - 2.0_f64.sqrt()).abs() < 1e-15);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prediction {
    predictor: PredictorDesign,
    sample_period: f64,
}

impl Prediction {
    /// A predictor that gets a sample every `sample_period` (s). Only a Kalman filter depends on it.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if a noise is not positive and finite, if the sample period is out of range, or if the filter
    /// follows its samples so closely that its settled form in continuous time says too little about it.
    pub fn new(predictor: PredictorDesign, sample_period: f64) -> Result<Self> {
        quantity::SAMPLE_PERIOD.check("sample_period", sample_period)?;
        let prediction = Self { predictor, sample_period };
        let PredictorDesign::Kalman(KalmanDesign { model, noise }) = predictor else { return Ok(prediction) };
        Kalman::new(model, noise)?;
        let cutoff = prediction.cutoff().unwrap_or(0.0);
        if cutoff * sample_period <= LARGEST_CUTOFF {
            return Ok(prediction);
        }
        Err(InvalidInput::new(
            "predictor.position",
            noise.position,
            format!(
                "the filter follows its samples with {cutoff:.0} rad/s, and the verdict holds up to \
                 {:.0} rad/s at this sample period",
                LARGEST_CUTOFF / sample_period
            ),
            "Give the noise that the position really has: at least the step of its sensor divided by √12.",
        ))
    }

    /// The predictor.
    pub fn predictor(&self) -> PredictorDesign {
        self.predictor
    }

    /// The cut-off frequency of a Kalman filter that has settled, rad/s; `None` for the other predictors.
    pub fn cutoff(&self) -> Option<f64> {
        let PredictorDesign::Kalman(KalmanDesign { model, noise }) = self.predictor else { return None };
        let ratio = noise.process / (noise.position * noise.position * self.sample_period);
        Some(match model {
            MotionModel::ConstantVelocity => ratio.sqrt().sqrt(),
            MotionModel::ConstantAcceleration => ratio.sqrt().cbrt(),
        })
    }

    /// The predicted position over the true one at a frequency (rad/s) and an age (s): 1 for a perfect prediction.
    ///
    /// For a shared target this is the response to a partner that leaves the target.
    pub fn response(&self, frequency: f64, age: f64) -> Complex64 {
        let s = Complex64::new(0.0, frequency);
        let delayed = (-s * age).exp();
        let Some(filter) = self.filter() else { return delayed };
        let at = |cubic: &Cubic| cubic.iter().rev().fold(Complex64::ZERO, |sum, &c| sum * s + c);
        at(&filter.position(age)) / at(&filter.denominator) * delayed
    }

    /// The filter of a predictor; `None` if it leaves the loop as it is.
    pub(crate) fn filter(&self) -> Option<PredictionFilter> {
        let cutoff = self.cutoff().unwrap_or(0.0);
        let (denominator, order) = match self.predictor {
            PredictorDesign::Hold | PredictorDesign::SharedTarget => return None,
            PredictorDesign::Linear => ([1.0, 0.0, 0.0, 0.0], 1),
            PredictorDesign::Kalman(KalmanDesign { model: MotionModel::ConstantVelocity, .. }) => {
                ([1.0, 2.0_f64.sqrt() / cutoff, cutoff.powi(-2), 0.0], 1)
            }
            PredictorDesign::Kalman(KalmanDesign { model: MotionModel::ConstantAcceleration, .. }) => {
                ([1.0, 2.0 / cutoff, 2.0 * cutoff.powi(-2), cutoff.powi(-3)], 2)
            }
        };
        Some(PredictionFilter { denominator, order })
    }
}

/// The filter of a predictor: its denominator d(s) with d(0) = 1, and the order of the motion that it follows without
/// error, 1 for a constant velocity and 2 for a constant acceleration.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PredictionFilter {
    pub denominator: Cubic,
    pub order: usize,
}

impl PredictionFilter {
    /// The numerator of the `derivative`-th derivative of the partner's position, as estimated.
    pub fn estimate(&self, derivative: usize) -> Cubic {
        std::array::from_fn(|power| {
            let is_known = (derivative..=self.order).contains(&power);
            if is_known { self.denominator[power - derivative] } else { 0.0 }
        })
    }

    /// The numerator of the predicted position at an age (s). No coefficient falls with the age.
    pub fn position(&self, age: f64) -> Cubic {
        let [x, v, a] = [0, 1, 2].map(|derivative| self.estimate(derivative));
        std::array::from_fn(|power| x[power] + age * (v[power] + 0.5 * age * a[power]))
    }

    /// The numerator of the predicted velocity at an age (s), which is the derivative of `position` by the age.
    pub fn velocity(&self, age: f64) -> Cubic {
        let [v, a] = [1, 2].map(|derivative| self.estimate(derivative));
        std::array::from_fn(|power| v[power] + age * a[power])
    }

    /// Denominator less the numerator of the predicted position, formed without cancellation. No coefficient rises with
    /// the age (s).
    pub fn missing(&self, age: f64) -> Cubic {
        let [v, a] = [1, 2].map(|derivative| self.estimate(derivative));
        std::array::from_fn(|power| {
            let beyond = if power > self.order { self.denominator[power] } else { 0.0 };
            beyond - age * (v[power] + 0.5 * age * a[power])
        })
    }
}
