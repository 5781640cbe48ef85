//! Taylor series on one step, in powers of u = (t − start)/length, so that u runs from 0 to 1.

use multiversion::multiversion;
use multiversion::target::target_cfg_f;

/// Highest degree of a series; a step that would need more is halved instead.
pub(super) const MAX_DEGREE: usize = 39;
/// Coefficients stored per series.
pub(super) const STRIDE: usize = MAX_DEGREE + 1;
/// A series is long enough when its last two coefficients are below this part of its largest one.
const TAIL: f64 = 1.0 / (1_u64 << 56) as f64;

/// The coefficients of one step.
pub(super) type Coefficients = [f64; STRIDE];

/// One step's series: where it starts, how long it is, and which coefficients count.
#[derive(Debug, Clone, Copy)]
pub(super) struct Series {
    pub start: f64,
    pub length: f64,
    pub degree: usize,
    pub coefficients: Coefficients,
}

impl Series {
    pub(super) fn used(&self) -> &[f64] {
        &self.coefficients[..=self.degree]
    }
}

/// 1/n and 1/(n (n + 1)), so that the recurrences never divide.
struct Inverses {
    once: Coefficients,
    twice: Coefficients,
}

static INVERSES: Inverses = {
    let mut table = Inverses { once: [0.0; STRIDE], twice: [0.0; STRIDE] };
    let mut n = 0;
    while n < STRIDE {
        table.once[n] = 1.0 / (n + 2) as f64;
        table.twice[n] = 1.0 / ((n + 1) * (n + 2)) as f64;
        n += 1;
    }
    table
};

/// The degree at which e^ρ is resolved to rounding, ρ = fastest rate · step length.
pub(super) fn degree_for(rho: f64) -> usize {
    let mut term = 1.0;
    let mut degree = 0;
    while term > 1e-18 && degree < MAX_DEGREE {
        degree += 1;
        term *= rho / degree as f64;
    }
    degree.clamp(5, MAX_DEGREE)
}

/// One side divided by its mass: x'' = −damping x' − stiffness x + coupling·d + damper·d' + force·f,
/// d the delayed partner.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Rates {
    pub damping: f64,
    pub stiffness: f64,
    pub coupling: f64,
    pub damper: f64,
    pub force: f64,
}

impl Rates {
    /// The largest magnitude of this side's own two characteristic roots, 1/s.
    pub(super) fn fastest(&self) -> f64 {
        let half = 0.5 * self.damping;
        let discriminant = half * half - self.stiffness;
        if discriminant > 0.0 { half + discriminant.sqrt() } else { self.stiffness.sqrt() }
    }
}

/// Position (m) and velocity (m/s).
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct State {
    pub x: f64,
    pub v: f64,
}

#[inline(always)]
fn fused<const FMA: bool>(a: f64, b: f64, c: f64) -> f64 {
    if FMA { a.mul_add(b, c) } else { a * b + c }
}

macro_rules! with_or_without_fma {
    ($function:ident ( $($argument:expr),* )) => {
        if target_cfg_f!(target_feature = "fma") || cfg!(target_arch = "aarch64") {
            $function::<true>($($argument),*)
        } else {
            $function::<false>($($argument),*)
        }
    };
}

/// Fills `series` (up to its degree) for one side over one step and returns the state at its end, or
/// nothing where the last coefficients are not negligible.
#[multiversion(targets(
    "x86_64+avx512f+avx512vl+avx512dq+avx512bw+avx2+fma+bmi2",
    "x86_64+avx2+fma+bmi2",
    "aarch64+neon"
))]
pub(super) fn advance(
    rates: &Rates,
    from: State,
    length: f64,
    degree: usize,
    delayed: &[f64],
    force: &[f64],
    series: &mut Coefficients,
) -> Option<State> {
    with_or_without_fma!(advance_with(rates, from, length, degree, delayed, force, series))
}

#[inline(always)]
fn advance_with<const FMA: bool>(
    rates: &Rates,
    from: State,
    length: f64,
    degree: usize,
    delayed: &[f64],
    force: &[f64],
    series: &mut Coefficients,
) -> Option<State> {
    let degree = degree.clamp(2, MAX_DEGREE);
    let terms = degree - 1;
    let square = length * length;
    let mut drive = [0.0; STRIDE];
    drive_series::<FMA>(rates, length, delayed, force, terms, &mut drive);
    let mut damping = [0.0; STRIDE];
    let mut stiffness = [0.0; STRIDE];
    let (p, q) = (-rates.damping * length, -rates.stiffness * square);
    for n in 0..terms {
        damping[n] = p * INVERSES.once[n];
        stiffness[n] = q * INVERSES.twice[n];
        drive[n] *= INVERSES.twice[n];
    }
    let (mut lower, mut upper) = (from.x, from.v * length);
    series[0] = lower;
    series[1] = upper;
    // the sums run from the third term on, so that the state itself is rounded only once
    let (mut sum, mut slope, mut order) = (0.0, 0.0, 2.0);
    for n in 0..terms {
        let next = fused::<FMA>(damping[n], upper, fused::<FMA>(stiffness[n], lower, drive[n]));
        series[n + 2] = next;
        sum += next;
        slope = fused::<FMA>(order, next, slope);
        order += 1.0;
        lower = upper;
        upper = next;
    }
    resolved(&series[..=degree])
        .then(|| State { x: from.x + fused::<FMA>(from.v, length, sum), v: from.v + slope / length })
}

/// Writes coupling·d + damper·d' + force·f, times length², into `drive`.
#[inline(always)]
fn drive_series<const FMA: bool>(
    rates: &Rates,
    length: f64,
    delayed: &[f64],
    force: &[f64],
    terms: usize,
    drive: &mut Coefficients,
) {
    let square = length * length;
    let gain = rates.coupling * square;
    for (g, d) in drive[..terms].iter_mut().zip(delayed) {
        *g = gain * d;
    }
    if rates.damper > 0.0 {
        let gain = rates.damper * length;
        for (n, (g, d)) in drive[..terms].iter_mut().zip(delayed.iter().skip(1)).enumerate() {
            *g = fused::<FMA>(gain * (n + 1) as f64, *d, *g);
        }
    }
    let gain = rates.force * square;
    for (g, f) in drive[..terms].iter_mut().zip(force) {
        *g = fused::<FMA>(gain, *f, *g);
    }
}

/// True where the last two coefficients are negligible beside the largest.
#[inline(always)]
fn resolved(series: &[f64]) -> bool {
    let mut lanes = [0.0_f64; 8];
    let mut chunks = series.chunks_exact(8);
    for chunk in &mut chunks {
        for (lane, value) in lanes.iter_mut().zip(chunk) {
            *lane = if value.abs() > *lane { value.abs() } else { *lane };
        }
    }
    let largest = lanes.iter().chain(chunks.remainder()).fold(0.0_f64, |m, a| m.max(a.abs()));
    let last = series.len() - 1;
    series[last].abs().max(series[last - 1].abs()) <= TAIL * largest
}

/// As [`advance`] for both sides at once without delay, each partner's delayed series being its own
/// series plus `lag`. Returns the states and whether both series are resolved.
pub(super) fn advance_both(
    rates: &[Rates; 2],
    from: [State; 2],
    length: f64,
    degree: usize,
    lag: &[Coefficients; 2],
    force: [&[f64]; 2],
    series: &mut [Coefficients; 2],
) -> ([State; 2], bool) {
    let terms = degree - 1;
    let square = length * length;
    let mut drive = [[0.0; STRIDE]; 2];
    for i in 0..2 {
        drive_series::<false>(&rates[i], length, &lag[1 - i][..=degree], force[i], terms, &mut drive[i]);
        series[i][0] = from[i].x;
        series[i][1] = from[i].v * length;
    }
    let mut sum = [0.0; 2];
    let mut slope = [0.0; 2];
    for n in 0..terms {
        let order = (n + 1) as f64;
        for i in 0..2 {
            let (own, partner, r) = (&series[i], &series[1 - i], &rates[i]);
            let first = length * order * (r.damper * partner[n + 1] - r.damping * own[n + 1]);
            let zeroth = square * (r.coupling * partner[n] - r.stiffness * own[n]);
            let next = (first + zeroth + drive[i][n]) * INVERSES.twice[n];
            series[i][n + 2] = next;
            sum[i] += next;
            slope[i] += (order + 1.0) * next;
        }
    }
    let states = [0, 1]
        .map(|i| State { x: from[i].x + (from[i].v * length + sum[i]), v: from[i].v + slope[i] / length });
    (states, resolved(&series[0][..=degree]) && resolved(&series[1][..=degree]))
}

/// Re-expands a series: the coefficients of p(shift + scale·u) from those of p(u).
pub(super) fn reexpand(from: &[f64], shift: f64, scale: f64, into: &mut Coefficients) {
    let count = from.len();
    into[..count].copy_from_slice(from);
    if shift != 0.0 {
        for low in 0..count.saturating_sub(1) {
            for n in (low..count - 1).rev() {
                into[n] += shift * into[n + 1];
            }
        }
    }
    if scale != 1.0 {
        let mut power = scale;
        for value in &mut into[1..count] {
            *value *= power;
            power *= scale;
        }
    }
}

/// p(u − shift) − p(u) for a small shift, without cancellation.
pub(super) fn lag_of(series: &[f64], shift: f64, into: &mut Coefficients) {
    let count = series.len();
    for n in 0..count {
        let (mut weight, mut total) = (1.0, 0.0);
        for (l, value) in series.iter().enumerate().skip(n + 1) {
            weight *= -shift * l as f64 / (l - n) as f64;
            total += weight * value;
            if weight.abs() < 1e-18 {
                break;
            }
        }
        into[n] = total;
    }
}

const LANES: usize = 32;
static LANE: [f64; LANES] = {
    let mut lane = [0.0; LANES];
    let mut i = 0;
    while i < LANES {
        lane[i] = i as f64;
        i += 1;
    }
    lane
};

/// Evaluates a series at u = first + i·spacing into `out`.
#[multiversion(targets(
    "x86_64+avx512f+avx512vl+avx512dq+avx512bw+avx2+fma+bmi2",
    "x86_64+avx2+fma+bmi2",
    "aarch64+neon"
))]
pub(super) fn evaluate(series: &[f64], first: f64, spacing: f64, out: &mut [f64]) {
    with_or_without_fma!(evaluate_with(series, first, spacing, out))
}

#[inline(always)]
fn evaluate_with<const FMA: bool>(series: &[f64], first: f64, spacing: f64, out: &mut [f64]) {
    let mut done = 0;
    while out.len() - done >= LANES {
        let values = horner::<FMA, LANES>(series, first, spacing, done);
        out[done..done + LANES].copy_from_slice(&values);
        done += LANES;
    }
    while done < out.len() {
        // padded lanes: the result of a point must not depend on how many are asked for
        let values = horner::<FMA, 8>(series, first, spacing, done);
        let count = (out.len() - done).min(8);
        out[done..done + count].copy_from_slice(&values[..count]);
        done += count;
    }
}

/// Horner's rule on `N` points at once: coefficients outside, points inside, so that it vectorises.
#[inline(always)]
fn horner<const FMA: bool, const N: usize>(
    series: &[f64],
    first: f64,
    spacing: f64,
    done: usize,
) -> [f64; N] {
    let offset = done as f64;
    let mut u = [0.0; N];
    for (u, lane) in u.iter_mut().zip(&LANE) {
        *u = fused::<FMA>(offset + lane, spacing, first);
    }
    let mut values = [0.0; N];
    for &coefficient in series.iter().rev() {
        for (value, u) in values.iter_mut().zip(&u) {
            *value = fused::<FMA>(*value, *u, coefficient);
        }
    }
    values
}

/// A time as a sum of two numbers, so that long simulations keep full precision inside a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Instant {
    pub high: f64,
    pub low: f64,
}

impl Instant {
    /// multiple · unit + offset.
    pub(super) fn new(multiple: f64, unit: f64, offset: f64) -> Self {
        let product = multiple * unit;
        let error = multiple.mul_add(unit, -product);
        let high = product + offset;
        let back = high - product;
        let low = (product - (high - back)) + (offset - back);
        Self { high, low: low + error }
    }
}
