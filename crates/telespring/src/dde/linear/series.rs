//! Taylor series on one step, in powers of u = (t − start)/length from 0 to 1.

use multiversion::multiversion;
use multiversion::target::target_cfg_f;

/// The highest degree of a series; a step that needs more is halved.
pub(super) const MAX_DEGREE: usize = 39;
/// The number of coefficients stored per series.
pub(super) const STRIDE: usize = MAX_DEGREE + 1;
/// A series is resolved if its last two coefficients are below this fraction of its largest one.
const TAIL: f64 = 1.0 / (1_u64 << 56) as f64;

/// The coefficients of one step.
pub(super) type Coefficients = [f64; STRIDE];

/// The Taylor series of one step: start, length, degree and coefficients.
#[derive(Debug, Clone, Copy)]
pub(super) struct Series {
    pub start: f64,
    pub length: f64,
    pub degree: usize,
    pub coefficients: Coefficients,
}

impl Series {
    /// The coefficients of the Taylor series up to its degree.
    pub(super) fn used_coefficients(&self) -> &[f64] {
        &self.coefficients[..=self.degree]
    }
}

/// 1/n and 1/(n (n + 1)), so that the recurrences need no division.
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

/// The degree at which the Taylor series of e^ρ is resolved to rounding, ρ = fastest rate · step length.
pub(super) fn degree_for(rho: f64) -> usize {
    let mut term = 1.0;
    let mut degree = 0;
    while term > 1e-18 && degree < MAX_DEGREE {
        degree += 1;
        term *= rho / degree as f64;
    }
    degree.clamp(5, MAX_DEGREE)
}

/// One side divided by its mass: x'' = −damping x' − stiffness x + coupling·d + damper·d' + force·f, with
/// the delayed partner position d.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Rates {
    pub damping: f64,
    pub stiffness: f64,
    pub coupling: f64,
    pub damper: f64,
    pub force: f64,
}

impl Rates {
    /// The largest magnitude of the side's own two characteristic roots, which the series must resolve, 1/s.
    pub(super) fn fastest_rate(&self) -> f64 {
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

/// a · b + c for the Taylor series, fused if the processor supports it.
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

/// The recurrence coefficients of one side for one step length; reused while the length stays the same.
#[derive(Debug)]
pub(super) struct Recurrence {
    length: f64,
    damping: Coefficients,
    stiffness: Coefficients,
    drive: Coefficients,
}

impl Default for Recurrence {
    /// An empty recurrence for a Taylor series.
    fn default() -> Self {
        Self { length: f64::NAN, damping: [0.0; STRIDE], stiffness: [0.0; STRIDE], drive: [0.0; STRIDE] }
    }
}

/// Fills the Taylor series of one side over one step and returns the state at its end, or `None` if the
/// last coefficients are not negligible. `memory` must belong to this side.
#[multiversion(targets(
    "x86_64+avx512f+avx512vl+avx512dq+avx512bw+avx2+fma+bmi2",
    "x86_64+avx2+fma+bmi2",
    "aarch64+neon"
))]
#[expect(clippy::too_many_arguments, reason = "private and hot; a struct would only rename them")]
pub(super) fn advance(
    rates: &Rates,
    memory: &mut Recurrence,
    from: State,
    length: f64,
    degree: usize,
    delayed: &[f64],
    force: &[f64],
    series: &mut Coefficients,
) -> Option<State> {
    with_or_without_fma!(advance_with(rates, memory, from, length, degree, delayed, force, series))
}

/// [`advance`] with or without fused multiply-add.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "private and hot; a struct would only rename them")]
fn advance_with<const FMA: bool>(
    rates: &Rates,
    memory: &mut Recurrence,
    from: State,
    length: f64,
    degree: usize,
    delayed: &[f64],
    force: &[f64],
    series: &mut Coefficients,
) -> Option<State> {
    let degree = degree.clamp(2, MAX_DEGREE);
    let terms = degree - 1;
    if memory.length != length {
        memory.length = length;
        let (p, q) = (-rates.damping * length, -rates.stiffness * length * length);
        for n in 0..STRIDE {
            memory.damping[n] = p * INVERSES.once[n];
            memory.stiffness[n] = q * INVERSES.twice[n];
        }
    }
    let Recurrence { damping, stiffness, drive, .. } = memory;
    drive_series::<FMA>(rates, length, delayed, force, terms, drive);
    let (mut lower, mut upper) = (from.x, from.v * length);
    series[0] = lower;
    series[1] = upper;
    // The sums start with the third term, so that the state itself is rounded only once.
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
    is_resolved(&series[..=degree])
        .then(|| State { x: from.x + fused::<FMA>(from.v, length, sum), v: from.v + slope / length })
}

/// Writes the driving Taylor series length²·(coupling·d + damper·d' + force·f), each coefficient divided by (n +
/// 1)(n + 2).
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
    let known = terms.min(delayed.len());
    let gain = rates.coupling * square;
    for n in 0..known {
        drive[n] = gain * INVERSES.twice[n] * delayed[n];
    }
    drive[known..terms].fill(0.0);
    if rates.damper > 0.0 {
        let gain = rates.damper * length;
        for n in 0..terms.min(delayed.len().saturating_sub(1)) {
            drive[n] = fused::<FMA>(gain * INVERSES.once[n], delayed[n + 1], drive[n]);
        }
    }
    let gain = rates.force * square;
    for n in 0..terms.min(force.len()) {
        drive[n] = fused::<FMA>(gain * INVERSES.twice[n], force[n], drive[n]);
    }
}

/// True if the last two coefficients of a Taylor series are negligible relative to the largest.
#[inline(always)]
pub(super) fn is_resolved(series: &[f64]) -> bool {
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

/// The input of [`advance_both`].
pub(super) struct CoupledStep<'a> {
    pub rates: &'a [Rates; 2],
    pub delay: f64,
    /// The product of fastest rate and delay, which bounds the terms that a shift by the delay needs.
    pub small: f64,
    pub from: [State; 2],
    pub length: f64,
    pub degree: usize,
    pub force: [&'a [f64]; 2],
    /// False for the columns of a map, of which only the sum must be resolved.
    pub must_resolve: bool,
}

/// The maximum number of iterations of [`advance_both`] before the step is rejected.
const MAX_ITERATIONS: usize = 60;

/// Fills the Taylor series of both sides over one step on which both motions are smooth, also one delay
/// before its start: the delayed series of each partner is its own series shifted by the delay.
///
/// The first terms of the shift enter the recurrence itself (they couple the two new coefficients through a
/// 2×2 matrix). The rest, of third order in the delay (second order for the damper), is iterated.
#[multiversion(targets(
    "x86_64+avx512f+avx512vl+avx512dq+avx512bw+avx2+fma+bmi2",
    "x86_64+avx2+fma+bmi2",
    "aarch64+neon"
))]
pub(super) fn advance_both(pair: &CoupledStep, series: &mut [Coefficients; 2]) -> Option<[State; 2]> {
    with_or_without_fma!(advance_both_with(pair, series))
}

/// [`advance_both`] with or without fused multiply-add.
#[inline(always)]
fn advance_both_with<const FMA: bool>(
    pair: &CoupledStep,
    series: &mut [Coefficients; 2],
) -> Option<[State; 2]> {
    let CoupledStep { rates, delay, length, degree, .. } = *pair;
    let terms = degree - 1;
    let square = length * length;
    let mut fixed = [[0.0; STRIDE]; 2];
    for i in 0..2 {
        drive_series::<FMA>(&rates[i], length, &[], pair.force[i], terms, &mut fixed[i]);
        series[i][0] = pair.from[i].x;
        series[i][1] = pair.from[i].v * length;
    }
    // The contribution of the own and the partner's last two coefficients, with the 2×2 matrix solved.
    let second = [0, 1].map(|i| (0.5 * rates[i].coupling * delay - rates[i].damper) * delay);
    let determinant = 1.0 / (1.0 - second[0] * second[1]);
    let own = [0, 1].map(|i| [-rates[i].damping * length, -rates[i].stiffness * square]);
    let partner =
        [0, 1].map(|i| [(rates[i].damper - rates[i].coupling * delay) * length, rates[i].coupling * square]);
    let mut from_own = [[[0.0; STRIDE]; 2]; 2];
    let mut from_partner = [[[0.0; STRIDE]; 2]; 2];
    for i in 0..2 {
        for (back, inverse) in [&INVERSES.once, &INVERSES.twice].into_iter().enumerate() {
            let a = determinant * (own[i][back] + second[i] * partner[1 - i][back]);
            let b = determinant * (partner[i][back] + second[i] * own[1 - i][back]);
            for n in 0..STRIDE {
                from_own[i][back][n] = a * inverse[n];
                from_partner[i][back][n] = b * inverse[n];
            }
        }
    }
    let shift = delay / length;
    // Whether the iterated rest is negligible.
    let damped = rates.iter().any(|r| r.damper > 0.0);
    let negligible = pair.small.powi(if damped { 2 } else { 3 }) < 1e-17;
    let mut lagged = fixed;
    let mut drive = [[0.0; STRIDE]; 2];
    let mut before: Option<([State; 2], f64)> = None;
    for _ in 0..MAX_ITERATIONS {
        for i in 0..2 {
            for n in 0..STRIDE {
                drive[i][n] = determinant * fused::<FMA>(second[i], lagged[1 - i][n], lagged[i][n]);
            }
        }
        let (mut sum, mut slope, mut order) = ([0.0; 2], [0.0; 2], 2.0);
        let mut lower = [series[0][0], series[1][0]];
        let mut upper = [series[0][1], series[1][1]];
        for n in 0..terms {
            let next = [0, 1].map(|i| {
                let (own, partner) = (&from_own[i], &from_partner[i]);
                let old =
                    fused::<FMA>(own[1][n], lower[i], fused::<FMA>(partner[1][n], lower[1 - i], drive[i][n]));
                fused::<FMA>(own[0][n], upper[i], fused::<FMA>(partner[0][n], upper[1 - i], old))
            });
            for i in 0..2 {
                series[i][n + 2] = next[i];
                sum[i] += next[i];
                slope[i] = fused::<FMA>(order, next[i], slope[i]);
            }
            (lower, upper) = (upper, next);
            order += 1.0;
        }
        let states = [0, 1].map(|i| State {
            x: pair.from[i].x + fused::<FMA>(pair.from[i].v, length, sum[i]),
            v: pair.from[i].v + slope[i] / length,
        });
        let mut settled = negligible;
        let mut latest = f64::INFINITY;
        if let Some((old, change_before)) = before {
            let (mut change, mut size) = (0.0_f64, 0.0_f64);
            for (old, new) in old.iter().zip(&states) {
                change = change.max((old.x - new.x).abs()).max((old.v - new.v).abs() * length);
                size = size.max(new.x.abs()).max(new.v.abs() * length);
            }
            // At the level of rounding the change stops shrinking.
            settled = change <= 2.0 * f64::EPSILON * size
                || (change >= change_before && change <= 64.0 * f64::EPSILON * size);
            latest = change;
        }
        if settled {
            let enough = !pair.must_resolve || series.iter().all(|series| is_resolved(&series[..=degree]));
            return enough.then_some(states);
        }
        before = Some((states, latest));
        for i in 0..2 {
            let partner = &series[1 - i][..=degree];
            let mut lag = [0.0; STRIDE];
            shift_remainder::<FMA>(partner, shift, pair.small, 3, &mut lag);
            let gain = rates[i].coupling * square;
            for n in 0..terms {
                lagged[i][n] = fused::<FMA>(gain * INVERSES.twice[n], lag[n], fixed[i][n]);
            }
            if rates[i].damper > 0.0 {
                shift_remainder::<FMA>(partner, shift, pair.small, 2, &mut lag);
                for n in 0..terms {
                    let gain = rates[i].damper * length * INVERSES.once[n];
                    lagged[i][n] = fused::<FMA>(gain, lag[n + 1], lagged[i][n]);
                }
            }
        }
    }
    None
}

/// Re-expands a Taylor series: the coefficients of p(shift + scale·u) from those of p(u).
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

/// n! and 1/n!.
static FACTORIAL: (Coefficients, Coefficients) = {
    let mut table = ([1.0; STRIDE], [1.0; STRIDE]);
    let mut n = 1;
    while n < STRIDE {
        table.0[n] = table.0[n - 1] * n as f64;
        table.1[n] = 1.0 / table.0[n];
        n += 1;
    }
    table
};

/// The Taylor terms of p(u − shift) in shift^l with l ≥ `order`; `small` bounds their decay, about small^l / l!.
#[inline(always)]
fn shift_remainder<const FMA: bool>(
    series: &[f64],
    shift: f64,
    small: f64,
    order: usize,
    into: &mut Coefficients,
) {
    // On derivatives instead of coefficients a shift is a convolution.
    let mut derivatives = [0.0; 2 * STRIDE];
    for (n, value) in series.iter().enumerate() {
        derivatives[n] = value * FACTORIAL.0[n];
    }
    into.fill(0.0);
    let (mut weight, mut size) = (1.0, 1.0);
    for l in 1..series.len() {
        weight *= -shift / l as f64;
        size *= small / l as f64;
        if l >= order {
            for n in 0..STRIDE {
                into[n] = fused::<FMA>(weight, derivatives[n + l], into[n]);
            }
            if size < 1e-19 {
                break;
            }
        }
    }
    for (value, inverse) in into.iter_mut().zip(&FACTORIAL.1) {
        *value *= inverse;
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

/// Evaluates a Taylor series at u = first + i·spacing into `out`.
#[multiversion(targets(
    "x86_64+avx512f+avx512vl+avx512dq+avx512bw+avx2+fma+bmi2",
    "x86_64+avx2+fma+bmi2",
    "aarch64+neon"
))]
pub(super) fn evaluate(series: &[f64], first: f64, spacing: f64, out: &mut [f64]) {
    with_or_without_fma!(evaluate_with(series, first, spacing, out))
}

/// [`evaluate`] with or without fused multiply-add.
#[inline(always)]
fn evaluate_with<const FMA: bool>(series: &[f64], first: f64, spacing: f64, out: &mut [f64]) {
    let mut done = 0;
    while out.len() - done >= LANES {
        let values = horner::<FMA, LANES>(series, first, spacing, done);
        out[done..done + LANES].copy_from_slice(&values);
        done += LANES;
    }
    while done < out.len() {
        // Padded lanes: the result at a point must not depend on the number of points.
        let values = horner::<FMA, 8>(series, first, spacing, done);
        let count = (out.len() - done).min(8);
        out[done..done + count].copy_from_slice(&values[..count]);
        done += count;
    }
}

/// Horner's rule for a Taylor series on `N` points at once: points innermost, so that it vectorises.
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

/// A time as the sum of two numbers, so that long simulations keep full precision within a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Instant {
    pub high: f64,
    pub low: f64,
}

impl Instant {
    /// The time multiple · unit + offset, without rounding error, at which a series is expanded.
    pub(super) fn new(multiple: f64, unit: f64, offset: f64) -> Self {
        let product = multiple * unit;
        let error = multiple.mul_add(unit, -product);
        let high = product + offset;
        let back = high - product;
        let low = (product - (high - back)) + (offset - back);
        Self { high, low: low + error }
    }
}
