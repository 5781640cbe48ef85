//! Inverse criteria: the maximum stiffness or minimum damping for a delay.

use num_complex::Complex64;

use super::branch_and_bound::{Curvature, LineFunction, LineJet, Region, Wanted, crossing_parameters};
use super::critical::critical_stiffness;
use super::crossings::all_crossings;
use super::intervals::{is_stable_without_delay, unstable_roots};
use super::undamped_resonance::{crossing_free_stiffness, undamped_resonances};
use crate::characteristic::{self, Characteristic, DelayExponential};
use crate::error::{InvalidInput, Result};
use crate::model::{DyadAxis, Side};
use crate::quantity;

/// The maximum stiffness K at a one-way delay (s): every k with 0 < k < K is stable, N/m.
///
/// Infinite without delay, 0 if even a soft spring is unstable. Some dyads become stable again at a larger
/// stiffness, which does not count. K is the smallest stiffness on the curve of crossings, all of which are
/// enclosed; it does not come from a bisection on stability.
///
/// # Errors
///
/// [`InvalidInput`] if the delay (s) is out of range.
///
/// # Examples
///
/// ```
/// use telespring::{criteria::{maximum_delay, maximum_stiffness}, hman};
/// let x = hman().axis(0)?;
/// let stiffness = maximum_stiffness(&x, 0.1)?;
/// assert!((maximum_delay(&x, stiffness)? - 0.1).abs() < 1e-12);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
pub fn maximum_stiffness(axis: &DyadAxis, delay: f64) -> Result<f64> {
    quantity::DELAY.check("delay", delay)?;
    if delay == 0.0 {
        return Ok(if is_stable_without_delay(axis) { f64::INFINITY } else { 0.0 });
    }
    let round_trip = 2.0 * delay;
    let critical = critical_stiffness(axis);
    let line = StiffnessLine { axis, round_trip, decay_rate: 0.0 };
    if critical > 0.0 {
        let low = critical * (1.0 - 1e-9);
        return Ok(first_crossing_stiffness(&line, low, 1e-3 * low));
    }
    let scale = stiffness_scale(axis, round_trip);
    let (resonances, coincident) = undamped_resonances(axis, round_trip);
    if resonances.is_empty() {
        let mut low = 1e-9 * scale;
        if coincident {
            // Both roots move in proportion to k here, so a count of roots still separates them.
            low = axis.sides.iter().fold(f64::INFINITY, |low, side| {
                let frequency = (side.ground_stiffness / side.mass).sqrt();
                low.min(1e-4 * side.ground_stiffness).min(0.1 * side.mass * frequency / round_trip)
            });
        } else if !axis.is_free() && axis.coupling_damping == 0.0 {
            low = low.max(crossing_free_stiffness(axis, round_trip));
        }
        if axis.is_free() && unstable_roots(axis, low, delay) > 0 {
            return Ok(0.0);
        }
        let stiffness = first_crossing_stiffness(&line, low, low);
        // No root crosses in between, so one stiffness represents all.
        return Ok(if unstable_roots(axis, 0.5 * stiffness, delay) > 0 { 0.0 } else { stiffness });
    }

    let soft = resonances.iter().map(|resonance| resonance.valid).fold(f64::INFINITY, f64::min);
    let mut first = resonances
        .iter()
        .filter_map(|resonance| resonance.first_unstable_stiffness(soft))
        .fold(f64::INFINITY, f64::min);
    // All other roots are stable with a soft spring; the search covers the frequencies between the
    // resonances.
    let mut bands: Vec<(f64, f64)> =
        resonances.iter().map(|resonance| resonance.frequency_band(soft)).collect();
    bands.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut from = 0.0;
    let end = crossing_frequency_bound(axis, soft).max(bands[bands.len() - 1].1);
    let lowest_crossing = crossing_free_stiffness(axis, round_trip).min(soft);
    for (start, next) in bands.into_iter().chain(std::iter::once((end, end))) {
        let high = soft.min(first);
        if start > from && lowest_crossing < high {
            let region = Region { frequency: (from, start), parameter: (lowest_crossing, high) };
            first = crossing_parameters(&line, region, Wanted::Least)
                .first()
                .copied()
                .unwrap_or(first)
                .min(first);
        }
        from = from.max(next);
    }
    Ok(if first.is_finite() { first } else { first_crossing_stiffness(&line, soft, soft) })
}

/// The smallest stiffness above `low` at which a root crosses, N/m.
///
/// With a positive delay every large stiffness is unstable, so some window holds a crossing. The windows
/// widen because at a long delay the first crossing lies just above the critical stiffness.
fn first_crossing_stiffness(line: &StiffnessLine, mut low: f64, mut width: f64) -> f64 {
    while low.is_finite() {
        let high = low + width;
        width *= 2.0;
        let region =
            Region { frequency: (0.0, crossing_frequency_bound(line.axis, high)), parameter: (low, high) };
        if let Some(&stiffness) = crossing_parameters(line, region, Wanted::Least).first() {
            return stiffness;
        }
        low = high;
    }
    f64::INFINITY
}

/// The smallest damping d, N·s/m, added to both robots, such that every larger addition is stable at this
/// stiffness (N/m) and one-way delay (s); 0 if every addition is stable.
///
/// # Errors
///
/// [`InvalidInput`] if the stiffness or the delay is out of range.
///
/// # Examples
///
/// ```
/// use telespring::{DyadAxis, criteria::{critical_stiffness, minimum_damping}};
/// // At a very long delay the smallest damping is that of the delay-independent dyad.
/// let axis = DyadAxis::new(1.0, 2.0, 1.0, 2.0)?;
/// let added = minimum_damping(&axis, 50.0, 100.0)?;
/// let damped = DyadAxis::new(1.0, 2.0 + added, 1.0, 2.0 + added)?;
/// assert!((critical_stiffness(&damped) - 50.0).abs() < 0.1);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
pub fn minimum_damping(axis: &DyadAxis, stiffness: f64, delay: f64) -> Result<f64> {
    quantity::STIFFNESS.check("stiffness", stiffness)?;
    quantity::DELAY.check("delay", delay)?;
    if delay == 0.0 {
        return Ok(0.0);
    }
    // With bᵢ² + 2 bᵢ c ≥ 2 mᵢ (k + k_h,i) on both sides no delay destabilises.
    let c = axis.coupling_damping;
    let enough = axis.sides.iter().fold(0.0f64, |enough, side| {
        let elastic = stiffness + side.ground_stiffness;
        enough.max((2.0 * side.mass * elastic + c * c).sqrt() - c - side.damping)
    });
    if enough == 0.0 {
        return Ok(0.0);
    }
    let line = DampingLine { axis, stiffness, round_trip: 2.0 * delay };
    let region = Region {
        frequency: (0.0, crossing_frequency_bound(axis, stiffness)),
        parameter: (0.0, enough * (1.0 + 1e-9)),
    };
    Ok(crossing_parameters(&line, region, Wanted::Greatest).first().copied().unwrap_or(0.0))
}

/// The largest product of decay rate and delay: the cost of the search grows exponentially with it.
const FASTEST_DECAY: f64 = 5.0;

/// The stiffness intervals `(low, high)`, N/m, with which every characteristic root but the rigid-body one
/// lies left of −`decay_rate` (1/s) at a one-way delay (s). A softer spring is slow, a stiffer one
/// oscillates. Empty if no stiffness decays that fast. The search ends at 1e7 N/m; without delay `high` may
/// be infinite.
///
/// # Errors
///
/// [`InvalidInput`] if the delay or the decay rate is out of range, their product exceeds 5, or the rate is
/// 0 and an undamped side makes the critical stiffness 0.
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
    let line = StiffnessLine { axis, round_trip, decay_rate };
    let highest = root_magnitude_bound(axis, limit, round_trip, decay_rate);
    let region =
        Region { frequency: (1e-9 * highest, highest), parameter: (lowest.max(1e-12 * limit), limit) };
    let mut changes = crossing_parameters(&line, region, Wanted::All);
    changes.extend(
        real_root_stiffnesses(axis, round_trip, decay_rate).into_iter().filter(|&k| k > 0.0 && k < limit),
    );
    changes.sort_by(f64::total_cmp);

    let mut ranges: Vec<(f64, f64)> = Vec::new();
    let mut low = 0.0;
    for high in changes.into_iter().chain(std::iter::once(limit)) {
        let middle = if low == 0.0 { 0.5 * high } else { (low * high).sqrt() };
        if high > low && decays_faster_than(axis, middle, delay, decay_rate)? {
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

/// Whether, in the search for a stiffness, every root but the rigid-body one lies left of −`decay_rate`.
fn decays_faster_than(axis: &DyadAxis, stiffness: f64, delay: f64, decay_rate: f64) -> Result<bool> {
    let delay = crate::model::Delay::each_way(delay)?;
    Ok(crate::spectrum::spectral_abscissa(axis, stiffness, &delay)?.value < -decay_rate)
}

/// A typical stiffness for the inverse criteria, N/m, for dyads whose critical stiffness is 0.
fn stiffness_scale(axis: &DyadAxis, round_trip: f64) -> f64 {
    let [first, second] = &axis.sides;
    let mass = first.mass + second.mass;
    let damping = first.damping + second.damping + 2.0 * axis.coupling_damping;
    damping * damping / mass + mass / (round_trip * round_trip)
}

/// A frequency above every crossing for all stiffnesses up to `stiffness`, rad/s.
fn crossing_frequency_bound(axis: &DyadAxis, stiffness: f64) -> f64 {
    let squared = if axis.is_free() {
        // Free handles: ω²/k of the highest crossing grows with k, and so does ω.
        all_crossings(axis, stiffness).last().map_or(0.0, |last| last.frequency.powi(2))
    } else {
        0.0
    };
    if squared > 0.0 {
        return squared.sqrt() * (1.0 + 1e-6);
    }
    // From mω² ≥ 2k + k_h on, |P| exceeds |k + cjω|.
    axis.sides
        .iter()
        .map(|side| (2.0 * stiffness + side.ground_stiffness) / side.mass)
        .fold(0.0, f64::max)
        .sqrt()
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

/// N(s) and its derivative for the inverse criteria; N is χ(s), divided by s for free handles.
fn characteristic_jet(
    chi: &Characteristic,
    s: Complex64,
    exponential: &DelayExponential,
) -> characteristic::Jet {
    if chi.rigid_body { chi.jet_by_remainder(s, exponential) } else { chi.jet_by_sides(s, exponential) }
}

/// Whether |P₁P₂| and |k + c s|² e^(σT) differ everywhere in a box of frequencies on the line Re s = −σ,
/// for the given ranges of stiffness and added damping.
fn magnitudes_differ(
    axis: &DyadAxis,
    frequency: (f64, f64),
    stiffness: (f64, f64),
    added: (f64, f64),
    round_trip: f64,
    decay_rate: f64,
) -> bool {
    let c = axis.coupling_damping;
    let squares = (frequency.0 * frequency.0, frequency.1 * frequency.1);
    // The smallest and largest value of x² on an interval.
    let square = |(low, high): (f64, f64)| {
        let greatest = (low * low).max(high * high);
        (if low <= 0.0 && high >= 0.0 { 0.0 } else { (low * low).min(high * high) }, greatest)
    };
    let sides = axis.sides.map(|side| {
        let (m, sigma) = (side.mass, decay_rate);
        let loss = (side.damping + added.0 + c, side.damping + added.1 + c);
        let elastic = side.ground_stiffness + m * sigma * sigma;
        let real = (
            stiffness.0 + elastic - loss.1 * sigma - m * squares.1,
            stiffness.1 + elastic - loss.0 * sigma - m * squares.0,
        );
        let imaginary = square((loss.0 - 2.0 * m * sigma, loss.1 - 2.0 * m * sigma));
        let real = square(real);
        (real.0 + imaginary.0 * squares.0, real.1 + imaginary.1 * squares.1)
    });
    let spring = square((stiffness.0 - c * decay_rate, stiffness.1 - c * decay_rate));
    let growth = (decay_rate * round_trip).exp();
    let returned = ((spring.0 + c * c * squares.0) * growth, (spring.1 + c * c * squares.1) * growth);
    let product = (sides[0].0 * sides[1].0, sides[0].1 * sides[1].1);
    // The factor keeps the rounding of these bounds from deciding.
    product.0 > returned.1 * returned.1 * (1.0 + 1e-12) || product.1 * (1.0 + 1e-12) < returned.0 * returned.0
}

/// The smallest and largest |s| of a box on the line Re s = −σ of an inverse criterion.
fn magnitude_range(region: &Region, decay_rate: f64) -> (f64, f64) {
    (region.frequency.0.hypot(decay_rate), region.frequency.1.hypot(decay_rate))
}

/// The characteristic function on Re s = −σ as a function of frequency and stiffness.
struct StiffnessLine<'a> {
    axis: &'a DyadAxis,
    round_trip: f64,
    decay_rate: f64,
}

impl LineFunction for StiffnessLine<'_> {
    /// The value and derivatives for an unknown stiffness on the line Re s = −σ.
    fn jet(&self, frequency: f64, stiffness: f64) -> LineJet {
        let s = Complex64::new(-self.decay_rate, frequency);
        let chi = Characteristic::new(self.axis, stiffness, self.round_trip);
        let exponential = DelayExponential::at(s, self.round_trip);
        let jet = characteristic_jet(&chi, s, &exponential);
        let spring = chi.coupling(s);
        let [one, two] = self.axis.sides;
        let by_parameter = if chi.rigid_body {
            s * (one.mass + two.mass)
                + (one.damping + two.damping)
                + spring * exponential.integral(s, self.round_trip).value * 2.0
        } else {
            chi.sides[0].value(s) + chi.sides[1].value(s) - spring * exponential.decay * 2.0
        };
        LineJet { value: jet.value, by_frequency: jet.slope * Complex64::I, by_parameter }
    }

    /// Whether no stiffness of the box puts a root on the line.
    fn magnitudes_differ(&self, region: &Region) -> bool {
        let Region { frequency, parameter } = *region;
        magnitudes_differ(self.axis, frequency, parameter, (0.0, 0.0), self.round_trip, self.decay_rate)
    }

    /// Bounds on the second derivatives over a box of stiffnesses and frequencies.
    fn curvature(&self, region: &Region) -> Curvature {
        let (least, most) = magnitude_range(region, self.decay_rate);
        let chi = Characteristic::new(self.axis, region.parameter.1, self.round_trip);
        let growth = (self.decay_rate * self.round_trip).exp();
        let frequency = chi.curvature(least, most, growth);
        let c = chi.coupling_damping;
        let spring = chi.stiffness + c * most;
        if chi.rigid_body {
            let [held, first, _] = DelayExponential::integral_bounds(least, self.round_trip, growth);
            Curvature {
                frequency,
                mixed: chi.sides[0].mass + chi.sides[1].mass + 2.0 * (c * held + spring * first),
                parameter: 2.0 * held,
            }
        } else {
            let slopes: f64 = chi.sides.iter().map(|side| side.bounds(most)[1]).sum();
            Curvature {
                frequency,
                mixed: slopes + 2.0 * growth * (c + self.round_trip * spring),
                parameter: 2.0 * (1.0 + growth),
            }
        }
    }
}

/// The characteristic function on the imaginary axis as a function of frequency and added damping.
struct DampingLine<'a> {
    axis: &'a DyadAxis,
    stiffness: f64,
    round_trip: f64,
}

impl DampingLine<'_> {
    /// The characteristic function with the unknown damping added to both sides.
    fn characteristic(&self, added: f64) -> Characteristic {
        let sides = self.axis.sides.map(|side| Side { damping: side.damping + added, ..side });
        Characteristic::new(&DyadAxis { sides, ..*self.axis }, self.stiffness, self.round_trip)
    }
}

impl LineFunction for DampingLine<'_> {
    /// The value and derivatives for an unknown damping, at j`frequency`.
    fn jet(&self, frequency: f64, added: f64) -> LineJet {
        let s = Complex64::new(0.0, frequency);
        let chi = self.characteristic(added);
        let jet = characteristic_jet(&chi, s, &DelayExponential::at(s, self.round_trip));
        let [one, two] = chi.sides;
        let by_parameter = if chi.rigid_body {
            (s * (one.mass + two.mass) + (one.damping + two.damping)) * s + 2.0 * self.stiffness
        } else {
            (one.value(s) + two.value(s)) * s
        };
        LineJet { value: jet.value, by_frequency: jet.slope * Complex64::I, by_parameter }
    }

    /// Whether no damping of the box puts a root on the axis.
    fn magnitudes_differ(&self, region: &Region) -> bool {
        let Region { frequency, parameter } = *region;
        let stiffness = (self.stiffness, self.stiffness);
        magnitudes_differ(self.axis, frequency, stiffness, parameter, self.round_trip, 0.0)
    }

    /// Bounds on the second derivatives over a box of dampings and frequencies.
    fn curvature(&self, region: &Region) -> Curvature {
        let (least, most) = magnitude_range(region, 0.0);
        let chi = self.characteristic(region.parameter.1);
        let frequency = chi.curvature(least, most, 1.0);
        let [one, two] = chi.sides;
        let mass = one.mass + two.mass;
        let loss = one.damping + two.damping;
        if chi.rigid_body {
            Curvature { frequency, mixed: 2.0 * mass * most + loss, parameter: 2.0 * most }
        } else {
            let mixed = (3.0 * mass * most + 2.0 * loss) * most + one.stiffness + two.stiffness;
            Curvature { frequency, mixed, parameter: 2.0 * most * most }
        }
    }
}
