//! Piecewise polynomials of time, given or fitted to a function.

use super::series::{Coefficients, reexpand};
use crate::error::{InvalidInput, Result};

/// The highest degree of a piece.
const MAX_PIECE_DEGREE: usize = 24;

/// A piecewise polynomial of time; beyond its pieces the nearest end value is held.
#[derive(Debug, Clone, PartialEq)]
pub struct PiecewisePolynomial {
    edges: Vec<f64>,
    /// Coefficients in powers of (t − middle)/(half length), which runs from −1 to 1.
    pieces: Vec<Vec<f64>>,
    /// False if an edge lies within a smooth function.
    breaks: Vec<bool>,
    error: f64,
    is_resolved: bool,
}

impl PiecewisePolynomial {
    /// Creates a piecewise polynomial from its edges (s, ascending) and the coefficients of each piece, in
    /// ascending powers of the time since its start (SI units).
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if edges are not ascending, counts do not match, a piece has no coefficient or more
    /// than 25, or a number is not finite or beyond 1e12.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::dde::linear::PiecewisePolynomial;
    /// // a ramp of 2 N/s for 0.5 s, then held
    /// let ramp = PiecewisePolynomial::new(vec![0.0, 0.5], &[vec![0.0, 2.0]])?;
    /// assert_eq!(ramp.value(0.25), 0.5);
    /// assert_eq!(ramp.value(3.0), 1.0);
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn new(edges: Vec<f64>, coefficients: &[Vec<f64>]) -> Result<Self> {
        check_edges("edges", &edges)?;
        if coefficients.len() + 1 != edges.len() {
            return Err(InvalidInput::new(
                "coefficients",
                format!("{} piece(s)", coefficients.len()),
                format!("{} edges bound {} piece(s)", edges.len(), edges.len() - 1),
                "Give one list of coefficients per piece.",
            ));
        }
        let mut pieces = Vec::with_capacity(coefficients.len());
        for (i, list) in coefficients.iter().enumerate() {
            let field = format!("coefficients[{i}]");
            if list.is_empty() || list.len() > MAX_PIECE_DEGREE + 1 {
                return Err(InvalidInput::new(
                    field,
                    format!("{} coefficient(s)", list.len()),
                    format!("a piece has 1 to {} coefficients", MAX_PIECE_DEGREE + 1),
                    "Split the piece into shorter ones of lower degree.",
                ));
            }
            let half = 0.5 * (edges[i + 1] - edges[i]);
            let mut centred: Coefficients = [0.0; super::series::STRIDE];
            reexpand(list, half, half, &mut centred);
            for value in list.iter().chain(&centred[..list.len()]) {
                check_value(&field, *value)?;
            }
            pieces.push(centred[..list.len()].to_vec());
        }
        let breaks = vec![true; edges.len()];
        Ok(Self { edges, pieces, breaks, error: 0.0, is_resolved: true })
    }

    /// Approximates `function` piece by piece from `start` to `end` (s) between its `breakpoints`, where it
    /// may jump or have kinks, by Chebyshev interpolation on pieces that are halved, the worst first, until
    /// their errors are negligible or as small as the rounding of the function allows.
    ///
    /// [`PiecewisePolynomial::error`] gives the error. It is measured between the nodes of every piece and
    /// every millisecond (every millionth of a span above 1000 s), and thus an estimate: a shorter feature
    /// can be missed unless a breakpoint is beside it. Jumps and kinks at other times are located by halving. The
    /// function is never evaluated at a breakpoint.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if the span or a breakpoint is not finite, or the function returns a value that is
    /// not finite or is beyond 1e12.
    pub fn from_function(
        function: &mut dyn FnMut(f64) -> f64,
        breakpoints: &[f64],
        start: f64,
        end: f64,
    ) -> Result<Self> {
        let mut edges = vec![start];
        for (i, &at) in breakpoints.iter().enumerate() {
            check_value(&format!("breakpoints[{i}]"), at)?;
            if at > start && at < end {
                edges.push(at);
            }
        }
        edges.push(end);
        edges.sort_by(f64::total_cmp);
        edges.dedup();
        check_edges("span", &edges)?;
        super::fit::fit(function, &edges)
    }

    /// The result of a fit, already checked.
    pub(super) fn fitted(
        edges: Vec<f64>,
        pieces: Vec<Vec<f64>>,
        breaks: Vec<bool>,
        error: f64,
        is_resolved: bool,
    ) -> Self {
        Self { edges, pieces, breaks, error, is_resolved }
    }

    /// The estimated approximation error in the unit of the values: the largest average over 10 ms of the distance
    /// from the function; 0 for given polynomials.
    pub fn error(&self) -> f64 {
        self.error
    }

    /// Whether that error is at most 1e-9 of the largest value of the function. It is not for noise, or for
    /// more oscillations or kinks than 200,000 pieces can follow.
    pub fn is_resolved(&self) -> bool {
        self.is_resolved
    }

    /// The value of the piecewise polynomial at `time` (s).
    pub fn value(&self, time: f64) -> f64 {
        let mut local = [0.0; super::series::STRIDE];
        self.series(time, 0.0, time, &mut local);
        local[0]
    }

    /// The edges of the pieces of a piecewise polynomial, ascending, s.
    pub fn edges(&self) -> &[f64] {
        &self.edges
    }

    /// False if the piecewise polynomial is smooth at an edge.
    pub(super) fn is_break(&self, edge: usize) -> bool {
        self.breaks[edge]
    }

    /// The slope of the piecewise polynomial just before the last edge.
    pub(super) fn final_slope(&self) -> f64 {
        let piece = self.pieces.len() - 1;
        let half = 0.5 * (self.edges[piece + 1] - self.edges[piece]);
        self.pieces[piece].iter().enumerate().map(|(n, c)| n as f64 * c).sum::<f64>() / half
    }

    /// Writes the Taylor series of the polynomial piece around `middle` over [start, start + length]; returns the
    /// number of coefficients.
    pub(super) fn series(&self, start: f64, length: f64, middle: f64, into: &mut Coefficients) -> usize {
        let (first, last) = (self.edges[0], self.edges[self.edges.len() - 1]);
        let held = if middle < first {
            Some((0, -1.0))
        } else if middle > last {
            Some((self.pieces.len() - 1, 1.0))
        } else {
            None
        };
        if let Some((piece, w)) = held {
            into[0] = self.pieces[piece].iter().rev().fold(0.0, |value, c| value * w + c);
            return 1;
        }
        let piece = self.edges.partition_point(|&edge| edge <= middle).clamp(1, self.pieces.len()) - 1;
        let half = 0.5 * (self.edges[piece + 1] - self.edges[piece]);
        let shift = ((start - self.edges[piece]) - half) / half;
        reexpand(&self.pieces[piece], shift, length / half, into);
        self.pieces[piece].len()
    }
}

/// Checks that a number of a piecewise polynomial is finite and not too large.
fn check_value(field: &str, value: f64) -> Result<()> {
    if value.abs() <= super::MAGNITUDE_LIMIT {
        return Ok(());
    }
    Err(InvalidInput::new(
        field,
        value,
        format!("a number must be finite and at most {:e} in magnitude", super::MAGNITUDE_LIMIT),
        "Check the unit: SI units are expected.",
    ))
}

/// Checks that the edges of a piecewise polynomial ascend.
fn check_edges(field: &str, edges: &[f64]) -> Result<()> {
    for (i, &edge) in edges.iter().enumerate() {
        check_value(&format!("{field}[{i}]"), edge)?;
    }
    if edges.len() >= 2 && edges.windows(2).all(|pair| pair[0] < pair[1]) {
        return Ok(());
    }
    Err(InvalidInput::new(
        field,
        format!("{} time(s)", edges.len()),
        "at least two times are required, each later than the one before",
        "Sort the times and drop repeated ones.",
    ))
}
