//! The search for the stiffnesses at which a root lies on a line.

use super::branch_and_bound::{Found, Region, Wanted, crossing_parameters};
use super::lines::{Band, FrequencyScale, StiffnessLine};
use crate::error::{InvalidInput, Result};
use crate::model::DyadAxis;

/// The stiffnesses of a range (N/m) at which a root lies on the line Re s = −`decay_rate`, ascending, without
/// bands of frequencies (rad/s); one at most if only an extreme is wanted.
///
/// Two searches follow one resonance each: near that of the stiffer ground, and everywhere else.
pub(super) fn stiffness_crossings(
    axis: &DyadAxis,
    round_trip: f64,
    decay_rate: f64,
    range: (f64, f64),
    wanted: Wanted,
    excluded: &[(f64, f64)],
) -> Result<Vec<f64>> {
    let [first, second] = &axis.sides;
    let (softer, stiffer) =
        if first.ground_stiffness <= second.ground_stiffness { (first, second) } else { (second, first) };
    let line_in = |scale| {
        let mut line = StiffnessLine::new(axis, round_trip, decay_rate, scale);
        let fixed = |&ends: &(f64, f64)| Band { scale: FrequencyScale::FIXED, ends };
        line.excluded = excluded.iter().map(fixed).collect();
        line
    };
    let mut found = Vec::new();
    let mut rest = line_in(FrequencyScale::following(softer.ground_stiffness));
    if stiffer.ground_stiffness > softer.ground_stiffness {
        let resonance = 1.0 / stiffer.mass.sqrt();
        let scale = FrequencyScale::following(stiffer.ground_stiffness);
        let band = Band { scale, ends: (0.5 * resonance, 2.0 * resonance) };
        let region = Region { frequency: band.ends, parameter: range };
        found = finished(axis, crossing_parameters(&line_in(scale), region, wanted))?;
        rest.excluded.push(band);
    }
    // The first search may have found the first crossing already.
    let range = match (wanted, found.first()) {
        (Wanted::Least, Some(&first)) => (range.0, first),
        _ => range,
    };
    let highest = [range.0, range.1]
        .map(|k| root_magnitude_bound(axis, k, round_trip, decay_rate) / rest.scale.square(k).sqrt());
    let region = Region { frequency: (0.0, highest[0] + highest[1]), parameter: range };
    found.extend(finished(axis, crossing_parameters(&rest, region, wanted))?);
    found.sort_by(f64::total_cmp);
    found.dedup_by(|next, last| (*next - *last).abs() <= 1e-9 * *last);
    Ok(found)
}

/// The crossings of a finished search; a refusal of the axis if it did not finish.
pub(super) fn finished(axis: &DyadAxis, found: Found) -> Result<Vec<f64>> {
    match found {
        Found::All(parameters) => Ok(parameters),
        Found::Unfinished(_) => Err(unsearchable(axis, "did not end")),
    }
}

/// The refusal of an axis whose crossings could not be searched, with what the search did.
pub(super) fn unsearchable(axis: &DyadAxis, outcome: &str) -> InvalidInput {
    let [first, second] = &axis.sides;
    let value = format!(
        "m1 {:?}, b1 {:?}, kh1 {:?}, m2 {:?}, b2 {:?}, kh2 {:?}, c {:?}",
        first.mass,
        first.damping,
        first.ground_stiffness,
        second.mass,
        second.damping,
        second.ground_stiffness,
        axis.coupling_damping
    );
    InvalidInput::new(
        "axis",
        value,
        format!("the search for its crossings {outcome}: these values, or the delay, span too many decades"),
        "Set values that are negligible to 0, shorten the delay, or test single stiffnesses with the maximum \
         delay, which needs no search.",
    )
}

/// An upper bound on |s| of every root right of −`decay_rate`, for all stiffnesses up to `stiffness`.
fn root_magnitude_bound(axis: &DyadAxis, stiffness: f64, round_trip: f64, decay_rate: f64) -> f64 {
    let growth = (0.5 * decay_rate * round_trip).exp();
    let c = axis.coupling_damping;
    axis.sides.iter().fold(0.0f64, |bound, side| {
        // m r² − (b + c) r − (k + k_h) ≥ (k + c r) growth beyond its positive root r.
        let loss = side.damping + c + c * growth;
        let elastic = stiffness + side.ground_stiffness + stiffness * growth;
        bound.max(0.5 * (loss + (loss * loss + 4.0 * side.mass * elastic).sqrt()) / side.mass)
    })
}
