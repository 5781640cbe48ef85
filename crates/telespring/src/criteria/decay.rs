//! The stiffnesses with a wanted decay rate.

use super::branch_and_bound::Wanted;
use super::critical::critical_stiffness;
use super::crossing_search::stiffness_crossings;
use super::crossings::all_crossings;
use crate::error::{InvalidInput, Result};
use crate::model::DyadAxis;
use crate::quantity;

/// The largest product of decay rate and delay: the cost of the search grows exponentially with it.
const FASTEST_DECAY: f64 = 5.0;

/// The stiffness intervals `(low, high)`, N/m, with which every characteristic root but the rigid-body one
/// lies left of −`decay_rate` (1/s) at a one-way delay (s). A softer spring is slow, a stiffer one
/// oscillates. Empty if no stiffness decays that fast. The search ends at 1e7 N/m; without delay `high` may
/// be infinite.
///
/// # Errors
///
/// [`InvalidInput`] if the delay or the decay rate is out of range, their product exceeds 5, the rate is 0 and
/// an undamped side makes the critical stiffness 0, or the search does not end, as for [`maximum_stiffness`](super::maximum_stiffness).
///
/// # Examples
///
/// ```
/// use telespring::{criteria::decay_stiffness, hman};
/// let ranges = decay_stiffness(&hman().axis(0)?, 0.02, 3.0)?;
/// let (soft, stiff) = ranges[0];
/// assert!(soft > 0.0 && stiff > soft);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
pub fn decay_stiffness(axis: &DyadAxis, delay: f64, decay_rate: f64) -> Result<Vec<(f64, f64)>> {
    quantity::DELAY.check("delay", delay)?;
    quantity::DECAY_RATE.check("decay_rate", decay_rate)?;
    if delay * decay_rate > FASTEST_DECAY {
        return Err(InvalidInput::new(
            "decay_rate",
            decay_rate,
            format!(
                "decay rate times delay may be at most {FASTEST_DECAY}, that is {} 1/s here",
                FASTEST_DECAY / delay
            ),
            "Choose a slower decay: a motion that crosses the network settles in several delays.",
        ));
    }
    // On the imaginary axis no root crosses below the critical stiffness.
    let lowest = if decay_rate > 0.0 { 0.0 } else { critical_stiffness(axis) * (1.0 - 1e-9) };
    if decay_rate == 0.0 && lowest == 0.0 {
        return Err(InvalidInput::new(
            "decay_rate",
            decay_rate,
            "a decay rate above 0 is required if an undamped side makes every stiffness critical",
            "Choose a small decay rate, or use the maximum stiffness at this delay.",
        ));
    }
    let round_trip = 2.0 * delay;
    let bound = unstable_stiffness_bound(axis, delay, decay_rate).max(2.0 * lowest);
    let limit = bound.min(quantity::STIFFNESS.maximum());
    let range = (lowest.max(1e-12 * limit), limit);
    let mut changes = stiffness_crossings(axis, round_trip, decay_rate, range, Wanted::All, &[])?;
    changes.extend(
        real_root_stiffnesses(axis, round_trip, decay_rate).into_iter().filter(|&k| k > 0.0 && k < limit),
    );
    changes.sort_by(f64::total_cmp);

    let mut ranges: Vec<(f64, f64)> = Vec::new();
    let mut low = 0.0;
    for high in changes.into_iter().chain(std::iter::once(limit)) {
        let middle = if low == 0.0 { 0.5 * high } else { (low * high).sqrt() };
        if high > low && crate::spectrum::largest_real_part(axis, middle, round_trip) < -decay_rate {
            let unbounded = high == limit && delay == 0.0;
            let end = if unbounded { f64::INFINITY } else { high };
            match ranges.last_mut() {
                Some(last) if last.1 == low => last.1 = end,
                _ => ranges.push((low, end)),
            }
        }
        low = high;
    }
    Ok(ranges)
}

/// A stiffness above which every dyad with a delay is unstable, or, without delay, nothing changes.
fn unstable_stiffness_bound(axis: &DyadAxis, delay: f64, decay_rate: f64) -> f64 {
    let [first, second] = &axis.sides;
    let ground = first.ground_stiffness + second.ground_stiffness;
    let own = |m: f64, b: f64| b * b / m + decay_rate * (b + decay_rate * m);
    let c = 2.0 * axis.coupling_damping;
    let scale = own(first.mass, first.damping + c) + own(second.mass, second.damping + c) + ground;
    if delay == 0.0 {
        return 1e4 * scale;
    }
    let mut limit = if ground > 0.0 { 1e3 * scale } else { 1e-3 * scale };
    // The highest crossing leaves at least δω/π − 1 times; the returning ones bring back at most δω/π + 1
    // pairs. Both diverge as the stiffness grows.
    loop {
        let crossings = all_crossings(axis, limit);
        let highest = crossings.last().map_or(0.0, |last| last.frequency);
        let returning = crossings
            .iter()
            .filter(|crossing| crossing.direction < 0)
            .fold(0.0, |highest: f64, crossing| highest.max(crossing.frequency));
        if delay * (highest - returning) > 2.0 * std::f64::consts::PI || limit > 1e100 {
            return limit;
        }
        limit *= 2.0;
    }
}

/// The stiffnesses at which a real root lies at −`decay_rate`.
fn real_root_stiffnesses(axis: &DyadAxis, round_trip: f64, decay_rate: f64) -> Vec<f64> {
    if decay_rate == 0.0 {
        return Vec::new();
    }
    let s = -decay_rate;
    let [a1, a2] = axis.sides.map(|side| (side.mass * s + side.damping) * s + side.ground_stiffness);
    // With κ = k + c s: (κ + a₁)(κ + a₂) = κ² e^(−s T).
    let square = -(decay_rate * round_trip).exp_m1();
    let linear = a1 + a2;
    let constant = a1 * a2;
    let shifted = if square == 0.0 {
        vec![-constant / linear]
    } else {
        let discriminant = linear * linear - 4.0 * square * constant;
        if discriminant < 0.0 {
            return Vec::new();
        }
        let larger = -0.5 * (linear + discriminant.sqrt().copysign(linear));
        vec![larger / square, constant / larger]
    };
    shifted
        .into_iter()
        .map(|kappa| kappa + axis.coupling_damping * decay_rate)
        .filter(|k| k.is_finite())
        .collect()
}
