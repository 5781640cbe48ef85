//! Whether the product of numbers from two rectangles can lie in a sector of a ring.
//!
//! A rectangle that is turned and stretched is enclosed in a larger one. The larger a rectangle is beside the numbers
//! that count, the more is lost: a stiff grip makes the real part of a factor a hundred times as large as near a
//! root. Rectangles are therefore halved until each piece has numbers of similar magnitude.

use num_complex::Complex64;

use super::value_set::{Rectangle, factors_of};

/// A wider range of angles (rad) excludes nothing.
const WIDEST_ANGLE: f64 = 2.0;
/// A piece whose largest number is at most this many times its smallest is not halved.
const SIMILAR: f64 = 2.0;
/// How often pieces are halved at most.
const MAX_HALVINGS: u32 = 10;

/// A sector of a ring in the complex plane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sector {
    /// The smallest and largest magnitude.
    pub magnitude: (f64, f64),
    /// The smallest and largest angle, rad; `None` for the whole ring.
    pub angle: Option<(f64, f64)>,
}

/// Pieces of two rectangles whose products are not excluded.
pub(super) struct Piece {
    /// Both pieces.
    pub rectangles: [Rectangle; 2],
    /// Two numbers whose product lies in or near the sector.
    pub factors: Option<[Complex64; 2]>,
}

impl Sector {
    /// Pieces of both rectangles whose products may lie in the sector; `None` if no product does.
    pub fn products(&self, first: &Rectangle, second: &Rectangle) -> Option<Piece> {
        self.products_of(*first, *second, MAX_HALVINGS)
    }

    fn products_of(&self, mut first: Rectangle, mut second: Rectangle, halvings: u32) -> Option<Piece> {
        // Each factor is at most as large as the other's smallest value allows.
        for _ in 0..2 {
            first = first.clipped(self.magnitude.1 / second.least())?;
            second = second.clipped(self.magnitude.1 / first.least())?;
        }
        if first.least() * second.least() > self.magnitude.1 * (1.0 + 1e-13)
            || first.greatest() * second.greatest() * (1.0 + 1e-13) < self.magnitude.0
        {
            return None;
        }
        let Some(angle) = self.angle else {
            return Some(Piece {
                rectangles: [first, second],
                factors: Some([first.nearest_to_zero(), second.nearest_to_zero()]),
            });
        };
        if angle.1 - angle.0 > WIDEST_ANGLE {
            return Some(Piece { rectangles: [first, second], factors: None });
        }
        let middle = (self.magnitude.0 * self.magnitude.1).sqrt();
        let logarithm = 0.5 * (self.magnitude.1 / self.magnitude.0).ln() + 1e-14;
        let target = Complex64::from_polar(middle, 0.5 * (angle.0 + angle.1));
        let turn = 0.5 * (angle.1 - angle.0) + 1e-14;
        let factors = if first.greatest() < second.greatest() {
            factors_of(target, &first.turned(logarithm, turn), &second)
        } else {
            factors_of(target, &first, &second.turned(logarithm, turn))
        }?;
        let spread = [&first, &second].map(|rectangle| rectangle.greatest() / rectangle.least());
        if halvings == 0 || spread[0].max(spread[1]) <= SIMILAR {
            return Some(Piece { rectangles: [first, second], factors: Some(factors) });
        }
        if spread[0] >= spread[1] {
            first.halves().into_iter().find_map(|first| self.products_of(first, second, halvings - 1))
        } else {
            second.halves().into_iter().find_map(|second| self.products_of(first, second, halvings - 1))
        }
    }
}
