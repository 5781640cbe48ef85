//! The positions of a robot before t = 0.

use super::force::{Break, SMOOTH_EDGE, check_magnitude};
use super::piecewise::PiecewisePolynomial;
use super::series::{Coefficients, State};
use crate::error::{InvalidInput, Result};

/// The positions of one robot before its t = 0, which its partner receives during the first delay.
///
/// Its value at 0 is the initial position of the robot.
///
/// # Examples
///
/// ```
/// use telespring::dde::linear::History;
/// let still = History::rest(0.1)?;
/// let swing = History::from_function(&mut |t| 0.1 * (2.0 * t).cos(), &[], 0.2)?;
/// # assert!(swing.error() < 1e-13 && still.error() == 0.0);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct History {
    position: PastPosition,
    velocity: f64,
}

#[derive(Debug, Clone, PartialEq)]
enum PastPosition {
    Constant(f64),
    Pieces(PiecewisePolynomial),
}

impl Default for History {
    /// The history of a robot at rest at 0.
    fn default() -> Self {
        Self { position: PastPosition::Constant(0.0), velocity: 0.0 }
    }
}

impl History {
    /// The history of a robot at rest at `position` (m) at all times before 0.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if the position is not finite or beyond 1e12 m.
    pub fn rest(position: f64) -> Result<Self> {
        check_magnitude("position", position, "m")?;
        Ok(Self { position: PastPosition::Constant(position), velocity: 0.0 })
    }

    /// A history of positions (m) as polynomials of time (s, negative), the last piece ending at 0. Before the first
    /// piece its first value is held. The velocity at 0 is the final slope.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if the last piece does not end at 0.
    pub fn polynomial(position: PiecewisePolynomial) -> Result<Self> {
        let end = position.edges().last().copied().unwrap_or(f64::NAN);
        if end != 0.0 {
            return Err(InvalidInput::new(
                "position.edges",
                end,
                "a history ends at t = 0",
                "Shift its times so that the last edge is 0.",
            ));
        }
        Ok(Self { velocity: position.final_slope(), position: PastPosition::Pieces(position) })
    }

    /// A history of positions (m) as a function of time on −`span` to 0 (s), which may jump or have kinks at
    /// `breakpoints`; see [`PiecewisePolynomial::from_function`].
    ///
    /// The velocity at 0 is the slope of the approximation; set a known velocity with
    /// [`History::with_velocity`].
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if the span is not positive or a value is not finite.
    pub fn from_function(
        function: &mut dyn FnMut(f64) -> f64,
        breakpoints: &[f64],
        span: f64,
    ) -> Result<Self> {
        Self::polynomial(PiecewisePolynomial::from_function(function, breakpoints, -span, 0.0)?)
    }

    /// The same history with this velocity (m/s) at t = 0.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if the velocity is not finite or beyond 1e12 m/s.
    pub fn with_velocity(mut self, velocity: f64) -> Result<Self> {
        check_magnitude("velocity", velocity, "m/s")?;
        self.velocity = velocity;
        Ok(self)
    }

    /// The estimated approximation error of the history, m; 0 unless it came from a function.
    pub fn error(&self) -> f64 {
        self.pieces().map_or(0.0, PiecewisePolynomial::error)
    }

    /// Whether that error is small; see [`PiecewisePolynomial::is_resolved`].
    pub fn is_resolved(&self) -> bool {
        self.pieces().is_none_or(PiecewisePolynomial::is_resolved)
    }

    /// Position and velocity of the robot at the end of its history, t = 0.
    pub(super) fn start(&self) -> State {
        let x = match &self.position {
            PastPosition::Constant(position) => *position,
            PastPosition::Pieces(pieces) => pieces.value(0.0),
        };
        State { x, v: self.velocity }
    }

    /// The pieces of the history; `None` for a robot at rest.
    fn pieces(&self) -> Option<&PiecewisePolynomial> {
        match &self.position {
            PastPosition::Constant(_) => None,
            PastPosition::Pieces(pieces) => Some(pieces),
        }
    }

    /// The number of break points of the history before 0.
    pub(super) fn break_count(&self) -> usize {
        self.pieces().map_or(0, |pieces| pieces.edges().len() - 1)
    }

    /// A break point of the robot's history before 0, in ascending order.
    pub(super) fn break_at(&self, index: usize) -> Option<Break> {
        let pieces = self.pieces().filter(|_| index < self.break_count())?;
        let effect = if pieces.is_break(index) { 1.0 } else { SMOOTH_EDGE };
        Some(Break { time: pieces.edges()[index], order: 0, effect })
    }

    /// Writes the Taylor series of the history over [start, start + length]; returns the number of
    /// coefficients.
    pub(super) fn series(&self, start: f64, length: f64, into: &mut Coefficients) -> usize {
        match &self.position {
            PastPosition::Constant(position) => {
                into[0] = *position;
                1
            }
            PastPosition::Pieces(pieces) => pieces.series(start, length, start + 0.5 * length, into),
        }
    }
}
