//! Stability of one axis with a predictor in front of the bare spring, at one constant age.
//!
//! The controllers are continuous, and the age is the same each way: with different ages their difference matters, too,
//! and [`DyadAxis::predicted_delay_system`] gives the roots. Hold and a shared target leave the roots where they are.

mod counting;
mod line;
mod loop_polynomials;

use super::branch_and_bound::{Region, Wanted, crossing_parameters};
use super::crossing_search::finished;
use super::{intervals, inverse};
use crate::error::Result;
use crate::model::DyadAxis;
use crate::prediction::Prediction;
use crate::quantity::{DELAY, STIFFNESS};
use counting::unstable_roots;
use line::{PredictedLine, Unknown};
use loop_polynomials::PredictedLoop;

/// The softest and the stiffest spring of the searches, N/m, and the longest age, s: the ends of their ranges.
const SOFTEST: f64 = 1e-6;
const STIFFEST: f64 = 1e7;
const OLDEST: f64 = 100.0;

/// The loop of a predictor that changes it.
fn predicted_loop<'a>(axis: &'a DyadAxis, prediction: &Prediction) -> Option<PredictedLoop<'a>> {
    prediction.filter().map(|filter| PredictedLoop { axis, filter })
}

/// Counts the roots with positive real part of an axis with a predictor, by the argument principle, without the
/// rigid-body root.
///
/// # Errors
///
/// [`InvalidInput`](crate::InvalidInput) if the stiffness (N/m) or the delay (s) is out of range, or if the roots cannot be
/// counted.
///
/// # Examples
///
/// ```
/// use telespring::{criteria::predicted_unstable_root_count, hman, prediction::Prediction};
/// use telespring::session::architecture::PredictorDesign;
/// let x = hman().axis(0)?;
/// let hold = Prediction::new(PredictorDesign::Hold, 1e-3)?;
/// let linear = Prediction::new(PredictorDesign::Linear, 1e-3)?;
/// // At 50 ms a linear prediction makes a stiff spring stable, at 167 ms it makes a soft one unstable.
/// assert_eq!(predicted_unstable_root_count(&x, &hold, 200.0, 0.05)?, 2);
/// assert_eq!(predicted_unstable_root_count(&x, &linear, 200.0, 0.05)?, 0);
/// assert_eq!(predicted_unstable_root_count(&x, &hold, 60.0, 0.167)?, 0);
/// assert_eq!(predicted_unstable_root_count(&x, &linear, 60.0, 0.167)?, 2);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
pub fn predicted_unstable_root_count(
    axis: &DyadAxis,
    prediction: &Prediction,
    stiffness: f64,
    delay: f64,
) -> Result<u32> {
    STIFFNESS.check("stiffness", stiffness)?;
    DELAY.check("delay", delay)?;
    match predicted_loop(axis, prediction) {
        None => intervals::unstable_root_count(axis, stiffness, delay),
        Some(predicted) => unstable_roots(&predicted, stiffness, delay),
    }
}

/// The maximum stiffness of an axis with a predictor at a one-way delay (s): every smaller stiffness is stable, N/m.
///
/// Infinite if every stiffness of the model is stable, 0 if even the softest spring is not. All crossings are enclosed, as
/// for [`maximum_stiffness`](super::maximum_stiffness).
///
/// # Errors
///
/// [`InvalidInput`](crate::InvalidInput) if the delay is out of range, or if the search does not end.
///
/// # Examples
///
/// ```
/// use telespring::{criteria::predicted_maximum_stiffness, hman, prediction::Prediction};
/// use telespring::session::architecture::PredictorDesign;
/// let x = hman().axis(0)?;
/// let [hold, linear] = [PredictorDesign::Hold, PredictorDesign::Linear].map(|predictor| {
///     predicted_maximum_stiffness(&x, &Prediction::new(predictor, 1e-3)?, 0.05)
/// });
/// assert!(linear? > 1.4 * hold?);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
pub fn predicted_maximum_stiffness(axis: &DyadAxis, prediction: &Prediction, delay: f64) -> Result<f64> {
    DELAY.check("delay", delay)?;
    let Some(predicted) = predicted_loop(axis, prediction) else {
        return inverse::maximum_stiffness(axis, delay);
    };
    if !intervals::is_stable_without_delay(axis) || unstable_roots(&predicted, SOFTEST, delay)? > 0 {
        return Ok(0.0);
    }
    let damping = axis.sides.iter().map(|side| side.damping * side.damping / side.mass);
    let first = damping.fold(f64::INFINITY, f64::min).max(2.0 * SOFTEST);
    let count = |stiffness: f64| unstable_roots(&predicted, stiffness, delay);
    let high = first_unstable(first, STIFFEST, count)?;
    let line = PredictedLine { predicted, unknown: Unknown::Stiffness(delay) };
    let region = Region {
        frequency: (0.0, predicted.root_bound(high.unwrap_or(STIFFEST), delay)),
        parameter: (SOFTEST, high.unwrap_or(STIFFEST)),
    };
    let least = finished(axis, crossing_parameters(&line, region, Wanted::Least))?;
    Ok(least.first().copied().or(high).unwrap_or(f64::INFINITY))
}

/// The maximum delay of an axis with a predictor: every shorter one-way delay is stable at this stiffness (N/m), s.
///
/// Infinite if every delay of the model is stable, 0 if short ones are not.
///
/// # Errors
///
/// [`InvalidInput`](crate::InvalidInput) if the stiffness is out of range, or if the search does not end.
///
/// # Examples
///
/// ```
/// use telespring::{criteria::predicted_maximum_delay, hman, prediction::Prediction};
/// use telespring::session::architecture::PredictorDesign;
/// let hold = Prediction::new(PredictorDesign::Hold, 1e-3)?;
/// let linear = Prediction::new(PredictorDesign::Linear, 1e-3)?;
/// // Below its critical stiffness the bare spring is stable at every delay, the linear prediction at none that is long.
/// let x = hman().axis(0)?;
/// assert_eq!(predicted_maximum_delay(&x, &hold, 30.0)?, f64::INFINITY);
/// assert!(predicted_maximum_delay(&x, &linear, 30.0)? < 0.3);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
pub fn predicted_maximum_delay(axis: &DyadAxis, prediction: &Prediction, stiffness: f64) -> Result<f64> {
    STIFFNESS.check("stiffness", stiffness)?;
    let Some(predicted) = predicted_loop(axis, prediction) else {
        return intervals::maximum_delay(axis, stiffness);
    };
    if !intervals::is_stable_without_delay(axis) || unstable_roots(&predicted, stiffness, 0.0)? > 0 {
        return Ok(0.0);
    }
    let high = first_unstable(1e-3, OLDEST, |age| unstable_roots(&predicted, stiffness, age))?;
    let line = PredictedLine { predicted, unknown: Unknown::Age(stiffness) };
    let region = Region {
        frequency: (0.0, predicted.root_bound(stiffness, high.unwrap_or(OLDEST))),
        parameter: (0.0, high.unwrap_or(OLDEST)),
    };
    let least = finished(axis, crossing_parameters(&line, region, Wanted::Least))?;
    Ok(least.first().copied().or(high).unwrap_or(f64::INFINITY))
}

/// The first unstable value of a doubling sequence up to the last one; `None` if all are stable.
fn first_unstable(first: f64, last: f64, count: impl Fn(f64) -> Result<u32>) -> Result<Option<f64>> {
    let mut value = first.min(last);
    loop {
        if count(value)? > 0 {
            return Ok(Some(value));
        }
        if value >= last {
            return Ok(None);
        }
        value = (2.0 * value).min(last);
    }
}

/// The stability with a predictor of every pair of stiffness and one-way delay, row by row, one row per stiffness.
///
/// # Errors
///
/// [`InvalidInput`](crate::InvalidInput) as for [`predicted_unstable_root_count`].
///
/// # Examples
///
/// ```
/// use telespring::{criteria::predicted_stability_map, hman, prediction::Prediction};
/// use telespring::session::architecture::PredictorDesign;
/// let x = hman().axis(0)?;
/// let linear = Prediction::new(PredictorDesign::Linear, 1e-3)?;
/// let map = predicted_stability_map(&x, &linear, &[60.0, 200.0], &[0.05, 0.167])?;
/// assert_eq!(map, [true, false, true, false]);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
pub fn predicted_stability_map(
    axis: &DyadAxis,
    prediction: &Prediction,
    stiffness: &[f64],
    delay: &[f64],
) -> Result<Vec<bool>> {
    for (i, &value) in stiffness.iter().enumerate() {
        STIFFNESS.check(&format!("stiffness[{i}]"), value)?;
    }
    for (i, &value) in delay.iter().enumerate() {
        DELAY.check(&format!("delay[{i}]"), value)?;
    }
    let Some(predicted) = predicted_loop(axis, prediction) else {
        return intervals::stability_map(axis, stiffness, delay);
    };
    let is_damped = intervals::is_stable_without_delay(axis);
    let mut stable = Vec::with_capacity(stiffness.len() * delay.len());
    for &k in stiffness {
        for &age in delay {
            stable.push(is_damped && unstable_roots(&predicted, k, age)? == 0);
        }
    }
    Ok(stable)
}
