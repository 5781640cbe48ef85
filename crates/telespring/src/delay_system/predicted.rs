//! A dyad with a predictor as a delay system.

use nalgebra::DMatrix;

use super::DelaySystem;
use crate::error::Result;
use crate::model::{Delay, DyadAxis};
use crate::prediction::{Prediction, PredictionFilter};
use crate::quantity;

impl DyadAxis {
    /// This axis with a predictor as a delay system: states x₁, v₁, x₂, v₂ (m, m/s) and, with a Kalman filter, the
    /// estimates of side 1 and of side 2, each derivative divided by one more cut-off frequency (m).
    ///
    /// Each side predicts over the age of what it receives, the `backward` delay at side 1 and the `forward` delay at side
    /// 2; `stiffness` is in N/m.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`](crate::InvalidInput) if the stiffness or a field of the axis is out of range.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::{Delay, DyadAxis, prediction::Prediction};
    /// use telespring::session::architecture::PredictorDesign;
    /// let linear = Prediction::new(PredictorDesign::Linear, 1e-3)?;
    /// let axis = DyadAxis::new(1.0, 4.0, 2.0, 4.0)?;
    /// let system = axis.predicted_delay_system(10.0, &Delay::new(0.1, 0.2)?, &linear)?;
    /// // robot 2 is pulled towards x₁(t − 0.1) + 0.1 v₁(t − 0.1)
    /// let delayed = &system.delayed()[0].1;
    /// assert_eq!([delayed[(3, 0)], delayed[(3, 1)]], [5.0, 0.5]);
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn predicted_delay_system(
        &self,
        stiffness: f64,
        delay: &Delay,
        prediction: &Prediction,
    ) -> Result<DelaySystem> {
        let Some(filter) = prediction.filter() else { return self.delay_system(stiffness, delay) };
        quantity::STIFFNESS.check("stiffness", stiffness)?;
        let c = self.coupling_damping;
        let cutoff = prediction.cutoff();
        let states = if cutoff.is_some() { filter.order + 1 } else { 0 };
        let size = 4 + 2 * states;
        let mut a0 = DMatrix::zeros(size, size);
        let mut terms = Vec::with_capacity(2);
        for (own, partner, age) in [(0, 1, delay.backward()), (1, 0, delay.forward())] {
            let side = self.sides[own];
            let (x, v) = (2 * own, 2 * own + 1);
            a0[(x, v)] = 1.0;
            a0[(v, x)] = -(stiffness + side.ground_stiffness) / side.mass;
            a0[(v, v)] = -(side.damping + c) / side.mass;
            let mut delayed = DMatrix::zeros(size, size);
            match cutoff {
                None => {
                    delayed[(v, 2 * partner)] = stiffness / side.mass;
                    delayed[(v, 2 * partner + 1)] = (stiffness * age + c) / side.mass;
                }
                Some(cutoff) => {
                    let first = 4 + own * states;
                    let gains = gains(&filter, states, cutoff);
                    for (row, gain) in gains.into_iter().enumerate() {
                        a0[(first + row, first)] -= gain;
                        delayed[(first + row, 2 * partner)] = gain;
                        if row + 1 < states {
                            a0[(first + row, first + row + 1)] += cutoff;
                        }
                        // the force: k Σ ageⁿ/n! x⁽ⁿ⁾ + c Σ ageⁿ⁻¹/(n−1)! x⁽ⁿ⁾, states are x⁽ⁿ⁾/cutoffⁿ
                        let scale = cutoff.powi(row as i32);
                        let ahead = [1.0, age, 0.5 * age * age];
                        let damped = if row > 0 { c * ahead[row - 1] } else { 0.0 };
                        a0[(v, first + row)] = (stiffness * ahead[row] + damped) * scale / side.mass;
                    }
                }
            }
            terms.push((age, delayed));
        }
        DelaySystem::new(a0, terms)
    }
}

/// The gains of a Kalman filter that has settled, 1/s, for its scaled states.
fn gains(filter: &PredictionFilter, states: usize, cutoff: f64) -> Vec<f64> {
    let leading = filter.denominator[states];
    (0..states).map(|row| filter.denominator[states - 1 - row] / leading / cutoff.powi(row as i32)).collect()
}
