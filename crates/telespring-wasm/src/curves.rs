//! The Nyquist locus of an axis, and how its roots move as the delay grows.

use serde_json::{Value, json};
use telespring::response::{Margin, nyquist};
use telespring::spectrum::characteristic_roots;
use telespring::study::Study;
use telespring::{Delay, DyadAxis, Result};

use crate::answer::{at_mean, cases};

/// The most points of a locus that are handed over.
const MOST_POINTS: usize = 1500;
/// The roots that are followed.
const ROOTS: usize = 8;
/// The most delays of a root locus.
const MOST_STEPS: usize = 400;

/// An axis of the dyad as it is held, over ranges of operators with the middle of each.
fn axis_of(study: &Study, axis: usize) -> Result<DyadAxis> {
    study.dyad().axis(axis)
}

/// The Nyquist locus at the study's stiffness and constant delay, for continuous controllers.
///
/// # Errors
///
/// [`InvalidInput`](telespring::InvalidInput) if there is no such axis, stiffness or delay.
pub fn nyquist_locus(study: &Study, axis: usize) -> Result<Value> {
    let cases = cases(study, None)?;
    let [forward, backward] = cases.first().map_or([0.0; 2], |question| question.network.buffered());
    let found =
        nyquist(&axis_of(study, axis)?, study.coupling()?.stiffness, &Delay::new(forward, backward)?)?;
    let stride = found.locus.len().div_ceil(MOST_POINTS).max(1);
    let points = || found.locus.iter().zip(&found.frequency).step_by(stride);
    let margin = |margin: Option<Margin>| {
        margin.map(|found| json!({ "value": found.value, "frequency": found.frequency }))
    };
    Ok(json!({
        "real": points().map(|(point, _)| point.re).collect::<Vec<_>>(),
        "imaginary": points().map(|(point, _)| point.im).collect::<Vec<_>>(),
        "frequency": points().map(|(_, frequency)| *frequency).collect::<Vec<_>>(),
        "unstable_roots": found.unstable_roots,
        "rigid_body": found.rigid_body,
        "gain_margin": margin(found.gain_margin),
        "phase_margin": margin(found.phase_margin),
        "delay_margin": margin(found.delay_margin),
        "minimum_distance": found.minimum_distance.value,
        "delay": 0.5 * (forward + backward),
    }))
}

/// The rightmost roots, 1/s, at `steps` + 1 mean delays from 0 to the longest (s), at the study's stiffness, for continuous
/// controllers.
///
/// # Errors
///
/// [`InvalidInput`](telespring::InvalidInput) if there is no such axis or stiffness, or the delay is out of range.
pub fn root_locus(study: &Study, axis: usize, longest: f64, steps: usize) -> Result<Value> {
    let (own, k) = (axis_of(study, axis)?, study.coupling()?.stiffness);
    let steps = steps.clamp(1, MOST_STEPS);
    let columns = (0..=steps)
        .map(|step| {
            let delay = longest * step as f64 / steps as f64;
            let found = characteristic_roots(&own, k, &at_mean(study, delay)?, ROOTS)?;
            let upper = found.roots.iter().filter(|root| root.im >= 0.0).map(|root| [root.re, root.im]);
            Ok(json!({ "delay": delay, "roots": upper.collect::<Vec<_>>() }))
        })
        .collect::<Result<Vec<_>>>()?;
    Ok(json!({ "delays": columns }))
}
