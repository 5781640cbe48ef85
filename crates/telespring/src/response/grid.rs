//! Frequency grids fine enough that no resonance falls between two points.

use num_complex::Complex64;

use super::open_loop::{OpenLoop, check_frequency};
use crate::error::{InvalidInput, Result};
use crate::model::{Delay, DyadAxis};

/// How the refinement of a grid ended.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum GridStatus {
    /// Every interval meets the resolution.
    Resolved,
    /// A factor is zero within rounding at these frequencies (rad/s): an undamped resonance or a root on
    /// the imaginary axis. The resolution is met everywhere else.
    PolesOnAxis(Vec<f64>),
    /// The limit on the number of points was reached; the intervals are coarser than requested.
    TooManyPoints,
}

/// Ascending angular frequencies and their status.
#[derive(Debug, Clone, PartialEq)]
pub struct FrequencyGrid {
    /// Angular frequencies, rad/s, ascending; the first is `low`, the last `high`.
    pub frequency: Vec<f64>,
    /// Whether the intervals meet the resolution.
    pub status: GridStatus,
}

/// A frequency grid over [`low`, `high`] rad/s on which every curve of this module is smooth from point to
/// point.
///
/// Between neighbouring points each of the four factors P₁, P₂, (k + cs)² and χ (divided by s for free
/// handles) provably stays in a disc around its value in the middle with half the `resolution` as relative
/// radius, and the delay phase changes by at most `resolution` rad. Thus no resonance, however narrow,
/// falls between two points. The number of points grows with the logarithm of the sharpness of a resonance,
/// and in proportion to (round trip)·`high`: a round trip of 200 s up to 10 rad/s takes about 20 000 points
/// at a resolution of 0.1.
///
/// # Errors
///
/// [`InvalidInput`] if an argument is out of range; 0 ≤ `low` < `high`, and `resolution` from 1e-3 to 1.
///
/// # Examples
///
/// ```
/// use telespring::response::{GridStatus, frequency_grid};
/// use telespring::{Delay, DyadAxis};
/// let axis = DyadAxis::new(1.0, 1e-3, 1.0, 1e-3)?;
/// let grid = frequency_grid(&axis, 10.0, &Delay::each_way(0.1)?, 0.1, 100.0, 0.1, 100_000)?;
/// assert_eq!(grid.status, GridStatus::Resolved);
/// assert!(grid.frequency.is_sorted());
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
pub fn frequency_grid(
    axis: &DyadAxis,
    stiffness: f64,
    delay: &Delay,
    low: f64,
    high: f64,
    resolution: f64,
    limit: usize,
) -> Result<FrequencyGrid> {
    let open_loop = OpenLoop::new(axis, stiffness, delay)?;
    check_frequency("low", low)?;
    check_frequency("high", high)?;
    if low >= high {
        return Err(InvalidInput::new(
            "high",
            high,
            format!("must be above low = {low} rad/s"),
            "Swap them or widen the range.",
        ));
    }
    if !(1e-3..=1.0).contains(&resolution) {
        return Err(InvalidInput::new(
            "resolution",
            resolution,
            "must be a number from 0.001 to 1",
            "0.1 draws smooth curves.",
        ));
    }
    if limit < 2 {
        return Err(InvalidInput::new("limit", limit, "a grid has at least 2 points", "Allow more points."));
    }
    Ok(refine_grid(&open_loop, low, high, resolution, limit))
}

#[derive(PartialEq)]
enum Interval {
    Fine,
    Coarse,
    /// A factor is zero within rounding.
    Pole,
}

/// Halves every interval of the frequency grid that is too coarse, all of them once before any of them twice,
/// so that the limit leaves an even grid.
pub(super) fn refine_grid(
    open_loop: &OpenLoop,
    low: f64,
    high: f64,
    resolution: f64,
    limit: usize,
) -> FrequencyGrid {
    let floor = 1e-24 * open_loop.crossover_bound();
    // Points, each with whether the interval that starts there needs another check.
    let mut points = vec![(low, true), (high, false)];
    let mut poles: Vec<f64> = Vec::new();
    loop {
        let mut next = Vec::with_capacity(2 * points.len());
        let mut coarse = 0;
        for (i, &(start, open)) in points.iter().enumerate() {
            let Some(&(end, _)) = points.get(i + 1).filter(|_| open) else {
                next.push((start, false));
                continue;
            };
            match classify_interval(open_loop, start, end, resolution, floor) {
                Interval::Fine => next.push((start, false)),
                Interval::Pole => {
                    next.push((start, false));
                    poles.push(0.5 * (start + end));
                }
                Interval::Coarse => {
                    coarse += 1;
                    // In a wide range of positive frequencies, split on a logarithmic axis.
                    let middle = if start > 0.0 && end > 2.0 * start {
                        start.sqrt() * end.sqrt()
                    } else {
                        0.5 * (start + end)
                    };
                    next.push((start, true));
                    next.push((middle, true));
                }
            }
        }
        if next.len() > limit {
            let frequency = points.into_iter().map(|(w, _)| w).collect();
            return FrequencyGrid { frequency, status: GridStatus::TooManyPoints };
        }
        points = next;
        if coarse == 0 {
            break;
        }
    }
    poles.sort_by(f64::total_cmp);
    poles.dedup_by(|next, previous| *next - *previous <= 1e-9 * *next);
    let status = if poles.is_empty() { GridStatus::Resolved } else { GridStatus::PolesOnAxis(poles) };
    FrequencyGrid { frequency: points.into_iter().map(|(w, _)| w).collect(), status }
}

/// Decides whether an interval of the frequency grid is fine, too coarse, or holds a pole.
fn classify_interval(open_loop: &OpenLoop, low: f64, high: f64, resolution: f64, floor: f64) -> Interval {
    let half = 0.5 * (high - low);
    let middle = Complex64::new(0.0, 0.5 * (low + high));
    let mut result = Interval::Fine;
    let mut judge = |size: f64, slope: f64, undecidable: &dyn Fn() -> bool| {
        let fine = half * slope <= 0.5 * resolution * size;
        if !fine {
            let pole = undecidable() || high <= floor;
            if pole && result == Interval::Fine {
                result = Interval::Pole;
            } else if !pole {
                result = Interval::Coarse;
            }
        }
    };
    for side in &open_loop.chi.sides {
        let slope = side.bounds(high)[1];
        let noise = 4.0 * f64::EPSILON * (side.stiffness + high * (side.damping + side.mass * high));
        judge(side.value(middle).norm(), slope, &|| half * slope <= 2.0 * noise);
    }
    judge(open_loop.chi.value(middle).norm(), open_loop.slope_bound(low, high), &|| {
        open_loop.is_undecidable(low, high)
    });
    let chi = &open_loop.chi;
    judge(chi.coupling(middle).norm(), 2.0 * chi.coupling_damping, &|| false);
    judge(1.0, chi.round_trip, &|| false);
    if result == Interval::Coarse && (middle.im <= low || middle.im >= high) {
        return Interval::Pole;
    }
    result
}
