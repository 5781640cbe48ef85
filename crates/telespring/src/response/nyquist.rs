//! The Nyquist locus, its encirclements of −1 and the stability margins.

use num_complex::Complex64;
use std::f64::consts::{PI, TAU};

use super::grid::{GridStatus, refine_grid};
use super::open_loop::OpenLoop;
use crate::criteria::{Crossing, Crossings, crossings};
use crate::error::Result;
use crate::model::{Delay, DyadAxis};

/// No factor changes by more than about this ratio between neighbouring points of the locus.
const RESOLUTION: f64 = 0.1;
/// The locus ends where |L| falls below this value.
const SMALL: f64 = 1e-3;
/// The maximum number of points; reached if round trip times bandwidth exceeds about 10⁴.
const LIMIT: usize = 400_000;

/// A stability margin or distance, and its angular frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Margin {
    /// The value, in the unit given with the field.
    pub value: f64,
    /// The angular frequency, rad/s.
    pub frequency: f64,
}

/// The status of the count of unstable roots.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum NyquistStatus {
    /// Proven: no root but the rigid-body root lies on the imaginary axis.
    Counted,
    /// A root lies on the imaginary axis within the rounding of the parameters: the dyad is marginally
    /// stable. Such roots do not count as unstable.
    OnTheAxis {
        /// The lowest frequency of such a root, rad/s; 0 if undamped robots drift.
        frequency: f64,
    },
}

/// The Nyquist locus of one axis, the number of unstable roots and the margins.
#[derive(Debug, Clone, PartialEq)]
pub struct Nyquist {
    /// Angular frequencies of the locus from 0, rad/s; fine enough that no turn is skipped if
    /// `locus_status` is resolved.
    pub frequency: Vec<f64>,
    /// L(jω) at each frequency; infinite points (undamped sides) are omitted.
    pub locus: Vec<Complex64>,
    /// Net clockwise encirclements of −1 over −∞ < ω < ∞, with the indentations described at [`nyquist()`].
    pub encirclements: i64,
    /// The number of characteristic roots in the open right half-plane.
    pub unstable_roots: usize,
    /// True for free handles: L(0) = −1 exactly, from the rigid-body root s = 0, which is divided out.
    pub rigid_body: bool,
    /// The smallest |L(jω) + 1| over the local minima at ω > 0 and the limit 1 at ω = ∞; with a grounded
    /// operator also at ω = 0.
    pub minimum_distance: Margin,
    /// The smallest factor above 1 on L that brings a root onto the imaginary axis at ω > 0. As for all
    /// margins, `None` if there is no finite one or the dyad is unstable.
    pub gain_margin: Option<Margin>,
    /// The largest factor below 1 on L that brings a root onto the imaginary axis at ω > 0.
    pub gain_reduction_margin: Option<Margin>,
    /// The smallest rotation of L, rad, in either direction, that brings a root onto the imaginary axis.
    pub phase_margin: Option<Margin>,
    /// The smallest increase of the mean one-way delay, s, that brings a root onto the imaginary axis;
    /// there the stable interval ends.
    pub delay_margin: Option<Margin>,
    /// The status of the count of unstable roots.
    pub status: NyquistStatus,
    /// The status of the locus; the count does not depend on it.
    pub locus_status: GridStatus,
}

impl Nyquist {
    /// True if, by its Nyquist locus, every root but the rigid-body one provably lies in the open left half-plane.
    pub fn is_stable(&self) -> bool {
        self.unstable_roots == 0 && self.status == NyquistStatus::Counted
    }
}

/// The Nyquist locus L(jω) = −(k + cjω)² e^(−jωT)/(P₁P₂), its encirclements of −1 and the stability
/// margins.
///
/// With free handles the locus starts at −1 for all parameters, so a plain count is undefined. The count is
/// therefore made on N(s) = χ(s)/s (on χ(s) with a grounded operator). N has degree n at infinity (3 or 4)
/// and Z zeros right of the axis; by Mikhailov's argument
///
/// ```text
/// Z = n/2 − (arg N(j∞) − arg N(0))/π
/// ```
///
/// The argument is followed by subdividing [0, ω_max]. A piece is accepted only if N provably has no zero
/// on it, and its turn is known. Beyond ω_max |P₁P₂| > |k + cjω|² (a bound on the roots of their
/// difference), and the remaining turn is known in closed form. If no subdivision can distinguish N from
/// zero, the status says so.
///
/// P₁ and P₂ never have roots with positive real part. With the locus indented to the right of s = 0 (free
/// handles) and of the imaginary poles of undamped sides (b = c = 0: infinite points of L), its net
/// clockwise encirclements of −1 equal the number of unstable roots.
///
/// Gain margins of free handles are taken over ω > 0 only: another gain at rest would move the rigid-body
/// root itself. Phase and delay margins are taken where |L(jω)| = 1, at the frequencies of
/// [`criteria::crossings`](crate::criteria::crossings()).
///
/// # Errors
///
/// [`InvalidInput`](crate::InvalidInput) if an argument is out of range.
///
/// # Examples
///
/// ```
/// use telespring::response::nyquist;
/// use telespring::{Delay, DyadAxis};
/// let axis = DyadAxis::new(0.8334, 7.7257, 0.7776, 7.4208)?; // the H-MANs' x axis
/// let plot = nyquist(&axis, 71.231976, &Delay::each_way(0.15)?)?;
/// assert!(plot.is_stable());
/// // Stability is lost at 167.186 ms.
/// assert!((0.15 + plot.delay_margin.unwrap().value - 0.167186).abs() < 1e-6);
/// assert_eq!(nyquist(&axis, 71.231976, &Delay::each_way(0.18)?)?.unstable_roots, 2);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
pub fn nyquist(axis: &DyadAxis, stiffness: f64, delay: &Delay) -> Result<Nyquist> {
    let open_loop = OpenLoop::new(axis, stiffness, delay)?;
    let (unstable_roots, status) = count_unstable_roots(&open_loop);
    let mut high = open_loop.crossover_bound();
    while open_loop.value(Complex64::new(0.0, high)).norm() > SMALL {
        high *= 1.5;
    }
    let grid = refine_grid(&open_loop, 0.0, high, RESOLUTION, LIMIT);
    let (frequency, locus): (Vec<f64>, Vec<Complex64>) = grid
        .frequency
        .iter()
        .map(|&w| (w, open_loop.value(Complex64::new(0.0, w))))
        .filter(|(_, value)| value.is_finite())
        .unzip();
    let minimum_distance = minimum_distance(&open_loop, &frequency);
    // |L(jω)| = 1 exactly where roots cross the axis at some delay.
    let crossings = crossings(axis, stiffness)?;
    let stable = unstable_roots == 0 && status == NyquistStatus::Counted;
    let [gain_margin, gain_reduction_margin] =
        if stable { gain_margins(&open_loop, &frequency) } else { [None, None] };
    let [phase_margin, delay_margin] =
        if stable { crossover_margins(&open_loop, &crossings) } else { [None, None] };
    Ok(Nyquist {
        frequency,
        locus,
        encirclements: unstable_roots as i64,
        unstable_roots,
        rigid_body: open_loop.chi.rigid_body,
        minimum_distance,
        gain_margin,
        gain_reduction_margin,
        phase_margin,
        delay_margin,
        status,
        locus_status: grid.status,
    })
}

/// The number of characteristic roots with positive real part, and whether a root lies on the imaginary
/// axis.
fn count_unstable_roots(open_loop: &OpenLoop) -> (usize, NyquistStatus) {
    let high = open_loop.crossover_bound();
    let followed = open_loop.follow_argument(&[high]);
    let degree = open_loop.degree() as f64;
    let turn = followed.argument.iter().sum::<f64>() + open_loop.remaining_turn(high);
    let zeros = 0.5 * degree - turn / PI;
    let status = match followed.zeros.first() {
        Some(&frequency) => NyquistStatus::OnTheAxis { frequency },
        None => NyquistStatus::Counted,
    };
    (zeros.round().max(0.0) as usize, status)
}

/// The distance |L(jω) + 1| of the Nyquist locus from the critical point.
fn critical_point_distance(open_loop: &OpenLoop, frequency: f64) -> f64 {
    open_loop.return_difference(Complex64::new(0.0, frequency)).norm()
}

/// The smallest distance of the Nyquist locus from −1.
fn minimum_distance(open_loop: &OpenLoop, frequency: &[f64]) -> Margin {
    let sampled: Vec<f64> = frequency.iter().map(|&w| critical_point_distance(open_loop, w)).collect();
    let mut least = Margin { value: 1.0, frequency: f64::INFINITY };
    if !open_loop.chi.rigid_body && sampled[0] < least.value {
        least = Margin { value: sampled[0], frequency: 0.0 };
    }
    for (w, d) in frequency.windows(3).zip(sampled.windows(3)) {
        // No factor changes by more than a tenth between neighbours, so a minimum far above the best stays
        // above it.
        if d[1] <= d[0] && d[1] <= d[2] && d[1] < 1.5 * least.value {
            let frequency = golden_section(w[0], w[2], |w| critical_point_distance(open_loop, w));
            let value = critical_point_distance(open_loop, frequency);
            if value < least.value {
                least = Margin { value, frequency };
            }
        }
    }
    least
}

/// The minimiser of a unimodal function on (low, high), here the Nyquist locus's distance, by golden section.
fn golden_section(mut low: f64, mut high: f64, function: impl Fn(f64) -> f64) -> f64 {
    const RATIO: f64 = 0.618_033_988_749_894_9;
    let mut points = [high - RATIO * (high - low), low + RATIO * (high - low)];
    let mut values = points.map(&function);
    while high - low > 1e-12 * high {
        if values[0] <= values[1] {
            high = points[1];
            points = [high - RATIO * (high - low), points[0]];
            values = [function(points[0]), values[0]];
        } else {
            low = points[0];
            points = [points[1], low + RATIO * (high - low)];
            values = [values[1], function(points[1])];
        }
    }
    0.5 * (low + high)
}

/// The gain margins: the factors nearest 1, above and below, that put L(jω), ω > 0, onto −1.
fn gain_margins(open_loop: &OpenLoop, frequency: &[f64]) -> [Option<Margin>; 2] {
    let mut nearest: [Option<Margin>; 2] = [None, None];
    let mut offer = |w: f64| {
        let response = open_loop.value(Complex64::new(0.0, w));
        // The phase also jumps past multiples of 2π at the infinite points of undamped sides.
        if !(-response).is_finite() || (-response).arg().abs() > 1e-3 {
            return;
        }
        let value = 1.0 / response.norm();
        let place = usize::from(value < 1.0);
        let nearer = nearest[place].is_none_or(|best| (value < best.value) == (place == 0));
        if nearer {
            nearest[place] = Some(Margin { value, frequency: w });
        }
    };
    let phase = |w: f64| open_loop.loop_phase(w);
    // At rest the phase is 0: a crossing there is the rigid-body root or the static loop gain.
    for pair in frequency.windows(2) {
        for w in phase_crossings(&phase, pair[0], pair[1]) {
            offer(w);
        }
    }
    let round_trip = open_loop.chi.round_trip;
    if let Some(&last) = frequency.last()
        && round_trip > 0.0
    {
        // Beyond this point |L| only falls; its first crossing is less than 4 half-turns of the other
        // factors away.
        if let Some(w) = phase_crossings(&phase, last, last + 3.0 * TAU / round_trip).into_iter().next() {
            offer(w);
        }
    }
    nearest
}

/// The frequencies where a phase of the Nyquist locus that is monotone on (low, high] equals a multiple of
/// 2π; at most the first three.
fn phase_crossings(phase: &impl Fn(f64) -> f64, low: f64, high: f64) -> Vec<f64> {
    let (start, end) = (phase(low), phase(high));
    let falling = end < start;
    let (least, most) = if falling { (end, start) } else { (start, end) };
    let (first, last) = ((least / TAU).ceil() as i64, (most / TAU).floor() as i64);
    let mut crossings: Vec<f64> = (first..=last)
        .map(|turn| turn as f64 * TAU)
        .filter(|&target| target != start)
        .map(|target| {
            let (mut low, mut high) = (low, high);
            loop {
                let middle = 0.5 * (low + high);
                if middle <= low || middle >= high {
                    return middle;
                }
                if (phase(middle) > target) == falling {
                    low = middle;
                } else {
                    high = middle;
                }
            }
        })
        .collect();
    crossings.sort_by(f64::total_cmp);
    crossings
}

/// The phase margin and the delay margin: the smallest rotation and added mean one-way delay that put L(jω)
/// onto −1.
fn crossover_margins(open_loop: &OpenLoop, crossings: &Crossings) -> [Option<Margin>; 2] {
    let mut smallest: [Option<Margin>; 2] = [None, None];
    for &Crossing { frequency, .. } in crossings.iter() {
        let lag = open_loop.loop_phase(frequency).rem_euclid(TAU);
        for (best, value) in smallest.iter_mut().zip([lag.min(TAU - lag), 0.5 * lag / frequency]) {
            if best.is_none_or(|best: Margin| value < best.value) {
                *best = Some(Margin { value, frequency });
            }
        }
    }
    smallest
}
