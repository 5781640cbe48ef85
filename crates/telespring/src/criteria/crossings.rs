//! Crossings: where characteristic roots meet the imaginary axis.

use std::f64::consts::TAU;
use std::ops::Deref;

use super::polynomial::crossing_roots;
use crate::error::Result;
use crate::model::DyadAxis;
use crate::quantity;

/// A frequency at which a pair of characteristic roots crosses the imaginary axis, and the delay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// The smallest one-way delay of the crossing, s (the mean of both directions if they differ).
    pub delay: f64,
    /// The crossing frequency ω_c, rad/s.
    pub frequency: f64,
    /// +1 if the pair leaves the stable half-plane as the delay grows, −1 if it returns, 0 if it only
    /// touches the axis.
    pub direction: i8,
}

impl Crossing {
    /// The period of one-way delays after which the crossing recurs, s.
    pub fn period(&self) -> f64 {
        0.5 * TAU / self.frequency
    }

    /// All one-way delays of the crossing, s, ascending without end.
    pub fn delays(&self) -> impl Iterator<Item = f64> + use<> {
        let Self { delay, .. } = *self;
        let period = self.period();
        (0..).map(move |turn| delay + f64::from(turn) * period)
    }
}

/// Up to four crossings, ascending by frequency; dereferences to a slice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossings {
    items: [Crossing; 4],
    length: usize,
}

impl Deref for Crossings {
    type Target = [Crossing];
    /// The crossings as a slice.
    fn deref(&self) -> &[Crossing] {
        &self.items[..self.length]
    }
}

/// All frequencies at which roots cross the imaginary axis at some delay, ascending.
///
/// Each crossing recurs at `delay + n π / frequency`. Without a crossing no constant delay destabilises.
/// The frequencies are the square roots of the positive roots of the paper's Eq. 8, with operators and
/// coupling damping added. The phase replaces Eq. 9, which fails where its B is zero.
///
/// # Errors
///
/// [`InvalidInput`](crate::InvalidInput) if the stiffness (N/m) is out of range.
///
/// # Examples
///
/// ```
/// use telespring::{DyadAxis, criteria::crossings};
/// let axis = DyadAxis::new(0.97670822, 2.15372614, 0.30379312, 4.59594729)?;
/// let found = crossings(&axis, 9.174736188)?;
/// assert_eq!(found.iter().map(|c| c.direction).collect::<Vec<_>>(), [-1, 1]);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
pub fn crossings(axis: &DyadAxis, stiffness: f64) -> Result<Crossings> {
    quantity::STIFFNESS.check("stiffness", stiffness)?;
    Ok(all_crossings(axis, stiffness))
}

/// The crossings of an axis whose stiffness has been checked.
pub(super) fn all_crossings(axis: &DyadAxis, stiffness: f64) -> Crossings {
    let mut crossings =
        Crossings { items: [Crossing { delay: 0.0, frequency: 0.0, direction: 0 }; 4], length: 0 };
    for root in crossing_roots(axis, stiffness).iter() {
        let frequency = (root.at * stiffness).sqrt();
        crossings.items[crossings.length] = Crossing {
            delay: first_crossing_delay(axis, stiffness, frequency),
            frequency,
            direction: root.slope,
        };
        crossings.length += 1;
    }
    crossings
}

/// The smallest one-way delay with which the loop phase closes at a crossing frequency, s.
fn first_crossing_delay(axis: &DyadAxis, stiffness: f64, frequency: f64) -> f64 {
    let c = axis.coupling_damping;
    let multiply = |a: (f64, f64), b: (f64, f64)| (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0);
    let [first, second] = axis.sides.map(|side| {
        (
            stiffness + side.ground_stiffness - side.mass * frequency * frequency,
            (side.damping + c) * frequency,
        )
    });
    let mut product = multiply(first, second);
    if c > 0.0 {
        let conjugate = (stiffness, -c * frequency);
        product = multiply(product, multiply(conjugate, conjugate));
    }
    let turn = -product.1.atan2(product.0);
    // An undamped dyad oscillates without delay: its phase is zero up to rounding.
    let undamped = axis.sides.iter().all(|side| side.damping == 0.0);
    if undamped && turn.abs() < 1e-12 {
        return 0.0;
    }
    let turn = if turn < 0.0 { turn + TAU } else { turn };
    0.5 * turn / frequency
}
