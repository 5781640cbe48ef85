//! The Nyquist locus and what it proves.

use num_complex::Complex64;
use std::f64::consts::{PI, TAU};

use super::grid::{GridStatus, refine};
use super::open_loop::OpenLoop;
use crate::criteria::{Crossing, Crossings, crossings};
use crate::error::Result;
use crate::{Delay, DyadAxis};

/// Between neighbouring points of the locus no factor changes by more than about this ratio.
const RESOLUTION: f64 = 0.1;
/// The locus is drawn up to where |L| has fallen below this.
const SMALL: f64 = 1e-3;
/// Most points of a locus; reached where round trip times bandwidth exceeds some 10⁴.
const LIMIT: usize = 400_000;

/// A margin or distance and the angular frequency where it is taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Margin {
    /// Its size, in the unit told beside the field.
    pub value: f64,
    /// The angular frequency, rad/s.
    pub frequency: f64,
}

/// How the count ended.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum NyquistStatus {
    /// Proven: no root lies on the imaginary axis, the rigid-body root apart.
    Counted,
    /// A root lies on the imaginary axis within the rounding of the parameters: the dyad is marginal.
    /// Such roots are not counted among the unstable ones. The lowest such frequency, rad/s.
    OnTheAxis {
        /// Where on the imaginary axis, rad/s; 0 where undamped robots drift apart or off together.
        frequency: f64,
    },
}

/// The Nyquist locus of one axis, the count of unstable roots and the margins.
#[derive(Debug, Clone, PartialEq)]
pub struct Nyquist {
    /// Angular frequencies of the locus from 0 on, rad/s; where `locus_status` is resolved, fine enough that no turn is skipped.
    pub frequency: Vec<f64>,
    /// L(jω) at each; points where it is infinite (undamped sides) are left out.
    pub locus: Vec<Complex64>,
    /// Net clockwise encirclements of −1 over −∞ < ω < ∞, with the indentations told in [`nyquist()`].
    pub encirclements: i64,
    /// Characteristic roots in the open right half-plane.
    pub unstable_roots: usize,
    /// True for free handles: L(0) = −1 exactly, the root s = 0 both robots drift with; deflated.
    pub rigid_body: bool,
    /// The least of all local minima of |L(jω) + 1| over ω > 0 and of its limit, 1 at ω = ∞; for a
    /// grounded dyad also its value at ω = 0, which for free handles is the deflated 0.
    pub minimum_distance: Margin,
    /// Smallest factor above 1 on L, away from ω = 0, that brings a root onto the imaginary axis.
    /// Like the other margins `None` where no finite one exists or the dyad is not stable.
    pub gain_margin: Option<Margin>,
    /// Largest factor below 1 on L, away from ω = 0, that brings a root onto the imaginary axis.
    pub gain_reduction_margin: Option<Margin>,
    /// Smallest rotation of L, rad, either way, that does.
    pub phase_margin: Option<Margin>,
    /// Smallest addition to the mean one-way delay, s, that does; where it ends the stable interval.
    pub delay_margin: Option<Margin>,
    /// How the count ended.
    pub status: NyquistStatus,
    /// Whether the drawn locus has its resolution; the count does not depend on it.
    pub locus_status: GridStatus,
}

impl Nyquist {
    /// True where every root but the rigid-body one is proven to lie in the open left half-plane.
    pub fn is_stable(&self) -> bool {
        self.unstable_roots == 0 && self.status == NyquistStatus::Counted
    }
}

/// The Nyquist locus L(jω) = −(k + cjω)² e^(−jωT)/(P₁P₂), its encirclements of −1 and the margins.
///
/// With free handles the locus starts at −1 whatever the parameters, so a plain count is undefined.
/// Here the count is made on N(s) = χ(s)/s (χ(s) with an operator to the ground): N has degree n at
/// infinity (3 or 4) and finitely many zeros right of the axis, Z of them; by Mikhailov's argument
///
/// ```text
/// Z = n/2 − (arg N(j∞) − arg N(0))/π
/// ```
///
/// The argument is followed by subdividing [0, ω_max]; a piece is taken only once it is proven that N
/// has no zero on it and by how much it turns. From ω_max on |P₁P₂| > |k + cjω|² (a bound on the roots
/// of their difference), and the rest of the turn follows in closed form. Where no subdivision can tell N from
/// zero, that is the status.
///
/// P₁ and P₂ never have roots with positive real part. Where the locus is indented to the right of s = 0 (free
/// handles) and of the imaginary poles of undamped sides (b = c = 0: infinite points of L), its net
/// clockwise encirclements of −1 therefore equal the unstable roots.
///
/// Gain margins of free handles are taken over ω > 0 only: any other gain at rest would move the
/// rigid-body root itself. Phase and delay margins are taken where |L(jω)| = 1, which is at the
/// frequencies of [`criteria::crossings`](crate::criteria::crossings()).
///
/// # Errors
///
/// [`InvalidInput`](crate::InvalidInput) where an argument is out of range.
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
    let (unstable_roots, status) = count(&open_loop);
    let mut high = open_loop.loop_is_small_from();
    while open_loop.value(Complex64::new(0.0, high)).norm() > SMALL {
        high *= 1.5;
    }
    let grid = refine(&open_loop, 0.0, high, RESOLUTION, LIMIT);
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

/// The number of zeros of N with positive real part, those on the axis left out.
fn count(open_loop: &OpenLoop) -> (usize, NyquistStatus) {
    let high = open_loop.loop_is_small_from();
    let followed = open_loop.follow(&[high]);
    let degree = open_loop.degree() as f64;
    let turn = followed.argument.iter().sum::<f64>() + open_loop.remaining_turn(high);
    let zeros = 0.5 * degree - turn / PI;
    let status = match followed.zeros.first() {
        Some(&frequency) => NyquistStatus::OnTheAxis { frequency },
        None => NyquistStatus::Counted,
    };
    (zeros.round().max(0.0) as usize, status)
}

fn distance(open_loop: &OpenLoop, frequency: f64) -> f64 {
    open_loop.return_difference(Complex64::new(0.0, frequency)).norm()
}

fn minimum_distance(open_loop: &OpenLoop, frequency: &[f64]) -> Margin {
    let sampled: Vec<f64> = frequency.iter().map(|&w| distance(open_loop, w)).collect();
    let mut least = Margin { value: 1.0, frequency: f64::INFINITY };
    if !open_loop.chi.rigid_body && sampled[0] < least.value {
        least = Margin { value: sampled[0], frequency: 0.0 };
    }
    for (w, d) in frequency.windows(3).zip(sampled.windows(3)) {
        // No factor changes by more than a tenth between neighbours: a minimum far above the best stays above.
        if d[1] <= d[0] && d[1] <= d[2] && d[1] < 1.5 * least.value {
            let found = golden_section(w[0], w[2], |w| distance(open_loop, w));
            let value = distance(open_loop, found);
            if value < least.value {
                least = Margin { value, frequency: found };
            }
        }
    }
    least
}

/// The place of the minimum of a function that first falls, then rises on (low, high).
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

/// The factors nearest 1, above and below, that put L(jω), ω > 0, onto −1.
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
        for w in whole_turns(&phase, pair[0], pair[1]) {
            offer(w);
        }
    }
    let round_trip = open_loop.chi.round_trip;
    if let Some(&last) = frequency.last()
        && round_trip > 0.0
    {
        // |L| only falls from here on; the first crossing there is less than 4 half-turns of the other factors away.
        if let Some(w) = whole_turns(&phase, last, last + 3.0 * TAU / round_trip).into_iter().next() {
            offer(w);
        }
    }
    nearest
}

/// Where a phase that is monotone on (low, high] meets a multiple of 2π; at most the first three.
fn whole_turns(phase: &impl Fn(f64) -> f64, low: f64, high: f64) -> Vec<f64> {
    let (start, end) = (phase(low), phase(high));
    let falling = end < start;
    let (least, most) = if falling { (end, start) } else { (start, end) };
    let (first, last) = ((least / TAU).ceil() as i64, (most / TAU).floor() as i64);
    let mut found: Vec<f64> = (first..=last)
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
    found.sort_by(f64::total_cmp);
    found
}

/// The smallest rotation and the smallest added mean one-way delay that put L(jω) onto −1.
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
