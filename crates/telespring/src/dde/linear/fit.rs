//! A piecewise polynomial through a function of time: pieces are halved where that helps most.
//!
//! The function is a black box whose values have their own rounding, and which may jump or have kinks anywhere.
//! So the piece with the largest error times width is halved first: a jump, whose error stays, but on ever
//! shorter pieces, cannot use up what the rest needs. No piece has to be better than the rounding of the function.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::MAGNITUDE_LIMIT;
use super::piecewise::PiecewisePolynomial;
use crate::error::{InvalidInput, Result};

/// The degree of the pieces.
const DEGREE: usize = 12;
const NODES: usize = DEGREE + 1;
/// The largest number of pieces.
const MAX_PIECES: usize = 200_000;
/// The largest number of evaluations of the function.
const MAX_EVALUATIONS: usize = 8_000_000;
/// The same for a function that jumps at almost every rounding of the time.
const MAX_EVALUATIONS_OF_NOISE: usize = 100_000;
/// The error at which a piece is good enough, relative to the largest value.
const NEGLIGIBLE: f64 = 1e-14;
/// The largest error of a fit that counts as resolved, relative to the largest value.
const RESOLVED: f64 = 1e-9;
/// The time over which errors are averaged, s: robots and hands respond more slowly.
const WINDOW: f64 = 1e-2;
/// A function that stays this close to its polynomials, relative to the largest value, and no closer on both halves
/// of a piece, has that much noise.
const NOISE: f64 = 1e-6;
/// The width of a piece, s, on which a jump has no effect.
const NARROWEST: f64 = 1e-12;
/// The longest time between two comparisons with the function, s.
const GLIMPSE: f64 = 1e-3;
/// The largest number of comparisons at that distance, all over the span.
const MAX_GLIMPSES: f64 = 1e6;
/// An edge may be a kink if one of its pieces is this many times narrower than the widest: only kinks and short
/// features are refined so far.
const REFINED: f64 = 64.0;

/// One piece: its coefficients, in powers of (t − middle)/(half width), and its largest error.
struct Piece {
    start: f64,
    end: f64,
    coefficients: [f64; NODES],
    error: f64,
    /// Whether halving it is useless: its error is negligible, or it cannot be halved.
    is_settled: bool,
    /// Whether it is as narrow as times can be distinguished: a jump is then located exactly.
    is_instant: bool,
}

impl Piece {
    fn width(&self) -> f64 {
        self.end - self.start
    }

    /// What halving the piece may gain.
    fn impulse(&self) -> f64 {
        self.error * self.width()
    }
}

impl PartialEq for Piece {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Piece {}

impl PartialOrd for Piece {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Piece {
    fn cmp(&self, other: &Self) -> Ordering {
        self.impulse().total_cmp(&other.impulse()).then(other.start.total_cmp(&self.start))
    }
}

/// A fit in progress.
struct Fit<'a> {
    function: &'a mut dyn FnMut(f64) -> f64,
    /// The largest value so far.
    scale: f64,
    evaluations: usize,
    most_evaluations: usize,
    /// The time between two comparisons, s.
    glimpse: f64,
}

/// Approximates `function` between neighbours of `edges` (s, ascending), where it may jump or have kinks.
pub(super) fn fit(function: &mut dyn FnMut(f64) -> f64, edges: &[f64]) -> Result<PiecewisePolynomial> {
    let span = edges[edges.len() - 1] - edges[0];
    let glimpse = GLIMPSE.max(span / MAX_GLIMPSES);
    let mut fit = Fit { function, scale: 0.0, evaluations: 0, most_evaluations: MAX_EVALUATIONS, glimpse };
    let (mut open, mut pieces) = (BinaryHeap::new(), Vec::new());
    fit.check_values(edges[0], edges[1])?;
    for pair in edges.windows(2) {
        open.push(fit.piece(pair[0], pair[1])?);
    }
    while let Some(worst) = open.pop() {
        let is_last = pieces.len() + open.len() + 1 >= MAX_PIECES || fit.evaluations >= fit.most_evaluations;
        if worst.is_settled || is_last {
            pieces.push(worst);
            continue;
        }
        let middle = 0.5 * (worst.start + worst.end);
        let mut halves = [fit.piece(worst.start, middle)?, fit.piece(middle, worst.end)?];
        let is_noise = worst.error <= NOISE * fit.scale
            && halves.iter().all(|half| !half.is_settled && half.error > 0.25 * worst.error);
        for half in &mut halves {
            half.is_settled |= is_noise;
        }
        open.extend(halves);
    }
    pieces.sort_by(|a, b| a.start.total_cmp(&b.start));
    let error = largest_average(&pieces, WINDOW.min(span));
    let breaks = breaks(&pieces, edges, fit.scale);
    let mut all_edges: Vec<f64> = pieces.iter().map(|piece| piece.start).collect();
    all_edges.push(edges[edges.len() - 1]);
    let coefficients = pieces.iter().map(|piece| piece.coefficients.to_vec()).collect();
    let is_resolved = error <= RESOLVED * fit.scale;
    Ok(PiecewisePolynomial::fitted(all_edges, coefficients, breaks, error, is_resolved))
}

impl Fit<'_> {
    /// The value of the function, checked.
    fn evaluate(&mut self, time: f64) -> Result<f64> {
        self.evaluations += 1;
        let value = (self.function)(time);
        if value.is_nan() || value.abs() > MAGNITUDE_LIMIT {
            return Err(InvalidInput::new(
                format!("function({time})"),
                value,
                format!("a function of time must return finite numbers up to {MAGNITUDE_LIMIT:e}"),
                "Check the function near this time.",
            ));
        }
        self.scale = self.scale.max(value.abs());
        Ok(value)
    }

    /// Refuses a function that returns another value at the same time, as a random one, and notices one that has
    /// nothing in common with its values a few roundings later.
    fn check_values(&mut self, start: f64, end: f64) -> Result<()> {
        let mut jumps = 0;
        for i in 0..NODES {
            let time = 0.5 * (start + end) + 0.5 * (end - start) * chebyshev_node(i, NODES);
            let (first, second) = (self.evaluate(time)?, self.evaluate(time)?);
            if first != second {
                return Err(InvalidInput::new(
                    format!("function({time})"),
                    format!("{first}, and then {second}"),
                    "a function of time must return the same value again",
                    "Compute its values once, and pass them as a sampled signal.",
                ));
            }
            let later = self.evaluate(time * (1.0 + 4.0 * f64::EPSILON))?;
            jumps += usize::from((later - first).abs() > 1e-3 * self.scale);
        }
        if 2 * jumps > NODES {
            self.most_evaluations = MAX_EVALUATIONS_OF_NOISE;
        }
        Ok(())
    }

    /// The polynomial through the function at Chebyshev nodes.
    fn piece(&mut self, start: f64, end: f64) -> Result<Piece> {
        let (middle, half) = (0.5 * (start + end), 0.5 * (end - start));
        let mut values = [0.0; NODES];
        for (i, value) in values.iter_mut().enumerate() {
            *value = self.evaluate(middle + half * chebyshev_node(i, NODES))?;
        }
        let mut coefficients = interpolant(&values);
        let mut error = 0.0_f64;
        // the nodes of the next degree lie between those of the fit
        for i in 0..=NODES {
            error = error.max(self.deviation(&coefficients, middle, half, chebyshev_node(i, NODES + 1))?);
        }
        // a jump just inside an end is between no nodes; the end itself may be a breakpoint
        let margin = 8.0 * f64::EPSILON * start.abs().max(end.abs()) / half;
        if margin < 0.1 {
            for place in [margin - 1.0, 1.0 - margin] {
                error = error.max(self.deviation(&coefficients, middle, half, place)?);
            }
        }
        let tolerance = self.tolerance(&values, middle, half);
        if error <= tolerance {
            // a short feature may lie between the nodes; irregular places, so that no period hides from them
            let looks = (2.0 * half / self.glimpse).ceil();
            for j in 0..if looks > NODES as f64 { 2 * looks as usize } else { 0 } {
                let place = (j as f64 + (j as f64 * GOLDEN).fract()) / (2.0 * looks);
                error = error.max(self.deviation(&coefficients, middle, half, 2.0 * place - 1.0)?);
            }
        }
        let largest = start.abs().max(end.abs());
        let is_instant = end - start <= 4.0 * f64::EPSILON * largest || !(start < middle && middle < end);
        let is_settled = error <= tolerance
            || error * (end - start) <= NEGLIGIBLE * self.scale * WINDOW
            || end - start <= NARROWEST
            || is_instant;
        if is_settled && error > NOISE * self.scale && end - start <= 1e3 * NARROWEST {
            // a jump: its polynomial would swing far beyond the values if a step ended a rounding outside the piece
            coefficients = [0.0; NODES];
            coefficients[0] = values.iter().sum::<f64>() / NODES as f64;
        }
        Ok(Piece { start, end, coefficients, error, is_settled, is_instant })
    }

    /// The distance of the polynomial from the function at one place from −1 to 1.
    fn deviation(&mut self, coefficients: &[f64; NODES], middle: f64, half: f64, place: f64) -> Result<f64> {
        let exact = self.evaluate(middle + half * place)?;
        Ok((coefficients.iter().rev().fold(0.0, |value, c| value * place + c) - exact).abs())
    }

    /// The error that a piece need not fall below: negligible, or what the rounding of the time changes.
    fn tolerance(&self, values: &[f64; NODES], middle: f64, half: f64) -> f64 {
        let slope = |i: usize| {
            let step = chebyshev_node(i, NODES) - chebyshev_node(i + 1, NODES);
            (values[i + 1] - values[i]).abs() / (step * half)
        };
        let steepest = (0..NODES - 1).map(slope).fold(0.0, f64::max);
        (NEGLIGIBLE * self.scale).max(2.0 * f64::EPSILON * (middle.abs() + half) * steepest)
    }
}

/// The fractional part of the golden ratio: its multiples are spread most evenly.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// The largest error of the pieces, averaged over any `window` (s). A jump located to the rounding of time is exact.
fn largest_average(pieces: &[Piece], window: f64) -> f64 {
    let error = |piece: &Piece| if piece.is_instant { 0.0 } else { piece.error };
    let (mut total, mut sums) = (0.0, vec![0.0]);
    for piece in pieces {
        total += error(piece) * piece.width();
        sums.push(total);
    }
    let first = pieces[0].start;
    let last = pieces[pieces.len() - 1].end;
    // the integral of the error up to a time
    let up_to = |time: f64| {
        let index = pieces.partition_point(|piece| piece.end <= time);
        pieces.get(index).map_or(total, |piece| sums[index] + error(piece) * (time - piece.start).max(0.0))
    };
    // an average that is largest begins or ends at an edge
    let starts = pieces.iter().flat_map(|piece| [piece.start, piece.end - window]);
    starts
        .filter(|&start| start >= first && start + window <= last)
        .chain([first])
        .map(|start| (up_to(start + window) - up_to(start)).max(0.0) / window)
        .fold(0.0, f64::max)
}

/// Which edges of the pieces may be kinks: those given, those that were refined far, and those where the polynomials
/// of both sides differ by more than their errors. A jump may lie on an edge by chance.
fn breaks(pieces: &[Piece], given: &[f64], scale: f64) -> Vec<bool> {
    let widest = pieces.iter().map(Piece::width).fold(0.0, f64::max);
    let is_refined = |piece: &Piece| piece.width() * REFINED <= widest;
    let is_given = |edge: f64| given.binary_search_by(|given| given.total_cmp(&edge)).is_ok();
    let inner = pieces.windows(2).map(|pair| {
        is_given(pair[1].start) || pair.iter().any(is_refined) || has_kink(&pair[0], &pair[1], scale)
    });
    [true].into_iter().chain(inner).chain([true]).collect()
}

/// Whether value or derivatives, up to the fourth, of neighbouring polynomials differ by more than their errors.
fn has_kink(before: &Piece, after: &Piece, scale: f64) -> bool {
    let error = 8.0 * before.error.max(after.error).max(0.1 * NEGLIGIBLE * scale);
    let narrower = before.width().min(after.width());
    // Tₙ⁽ᵏ⁾(1)/k!: how much of an error of the piece the k-th term of its Taylor series may have
    let mut share = 1.0;
    for order in 0..5 {
        let term = |piece: &Piece, place: f64| {
            // Σ C(n, k) cₙ placeⁿ⁻ᵏ
            let mut sum = 0.0;
            for (n, c) in piece.coefficients.iter().enumerate().skip(order) {
                let binomial: f64 = (0..order).map(|j| (n - j) as f64 / (j + 1) as f64).product();
                sum += binomial * c * if (n - order) % 2 == 0 { 1.0 } else { place };
            }
            sum * (narrower / piece.width()).powi(order as i32)
        };
        if (term(before, 1.0) - term(after, -1.0)).abs() > error * share {
            return true;
        }
        let (n, k) = (DEGREE as f64, order as f64);
        share *= (n * n - k * k) / ((2.0 * k + 1.0) * (k + 1.0));
    }
    false
}

/// The i-th Chebyshev node of the first kind on a piece, never an end of the interval.
fn chebyshev_node(i: usize, count: usize) -> f64 {
    ((2 * i + 1) as f64 * std::f64::consts::PI / (2 * count) as f64).cos()
}

/// The power coefficients on [−1, 1] of the polynomial through the values at the Chebyshev nodes.
fn interpolant(values: &[f64; NODES]) -> [f64; NODES] {
    let mut powers = [0.0; NODES];
    // T₀, T₁, … in powers, by their recurrence
    let (mut previous, mut current) = ([0.0; NODES], [0.0; NODES]);
    previous[0] = 1.0;
    current[1] = 1.0;
    for k in 0..NODES {
        let sum: f64 = (0..NODES)
            .map(|i| {
                let angle = (k * (2 * i + 1)) as f64 * std::f64::consts::PI / (2 * NODES) as f64;
                values[i] * angle.cos()
            })
            .sum();
        let weight = if k == 0 { 1.0 } else { 2.0 } * sum / NODES as f64;
        for (power, t) in powers.iter_mut().zip(&previous) {
            *power += weight * t;
        }
        let mut next = [0.0; NODES];
        for n in 0..NODES {
            next[n] = if n > 0 { 2.0 * current[n - 1] } else { 0.0 } - previous[n];
        }
        previous = current;
        current = next;
    }
    powers
}
