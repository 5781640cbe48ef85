//! Branch and bound for the first root of a family on the imaginary axis.
//!
//! The characteristic roots of a connected family move continuously. While none of them lies on the imaginary
//! axis, all members have as many unstable roots as one of them: none. A cell is discarded only if its enclosures prove
//! that it holds no root, and cells are examined from the smallest value of the unknown on. Whenever the search
//! ends, all values below the first cell left are therefore proven to be free of roots.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use num_complex::Complex64;

use super::family::{Cell, Content, Family};

/// The relative accuracy of the first root after few cells, see [`Unknown::scale`].
const RESOLUTION: f64 = 1e-5;
/// The most cells that one search examines.
const MAX_CELLS: usize = 60_000;
/// A motion slower than this part of the fastest that counts stands for the limit of slow motions.
const SLOWEST: f64 = 1e-12;
/// No search goes beyond this, in N/m, s or N·s/m.
const LARGEST: f64 = 1e13;

/// The unknown of a search.
#[derive(Debug, Clone, Copy)]
pub(super) enum Unknown {
    /// The spring's stiffness, upwards.
    Stiffness,
    /// The round trip, upwards.
    RoundTrip,
    /// The damping added to both robots, from `most` (N·s/m) downwards: the unknown is what is missing from it.
    Damping {
        /// Where the search starts.
        most: f64,
    },
}

/// The first root of a family on the imaginary axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct FirstRoot {
    /// No member has a root for a smaller value of the unknown.
    pub bound: f64,
    /// The cell with the root and the factors there, if the search found one.
    pub at: Option<(Cell, [Complex64; 2])>,
    /// False if the search was cut off: the bound may then be far from any root.
    pub is_finished: bool,
}

/// Whether a family has a root on the imaginary axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::verdicts) enum Crossing {
    /// No member has one.
    Excluded,
    /// One has, or comes so close that rounding decides.
    Found,
    /// The search was cut off.
    Unresolved,
}

/// A cell that waits, with the smallest value of the unknown in it.
struct Waiting {
    from: f64,
    cell: Cell,
}

impl PartialEq for Waiting {
    /// The order alone counts.
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Waiting {}

impl PartialOrd for Waiting {
    /// A total order.
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Waiting {
    /// The smallest value first, then the lowest frequency.
    fn cmp(&self, other: &Self) -> Ordering {
        other
            .from
            .total_cmp(&self.from)
            .then_with(|| other.cell.frequency.0.total_cmp(&self.cell.frequency.0))
    }
}

impl Unknown {
    /// The range of the unknown in a cell.
    fn range(self, cell: &Cell) -> (f64, f64) {
        match self {
            Self::Stiffness => cell.stiffness,
            Self::RoundTrip => cell.round_trip.expect("a search for a delay has one"),
            Self::Damping { most } => (most - cell.added.1, most - cell.added.0),
        }
    }

    /// What an accuracy at a value of the unknown is relative to: for a damping the larger part of `most`, so that
    /// neither of the two needs all digits.
    fn scale(self, value: f64) -> f64 {
        match self {
            Self::Stiffness | Self::RoundTrip => value,
            Self::Damping { most } => value.max(most - value),
        }
    }

    /// The cell with another range of the unknown.
    fn with_range(self, cell: &Cell, range: (f64, f64)) -> Cell {
        match self {
            Self::Stiffness => Cell { stiffness: range, ..*cell },
            Self::RoundTrip => Cell { round_trip: Some(range), ..*cell },
            Self::Damping { most } => Cell { added: (most - range.1, most - range.0), ..*cell },
        }
    }
}

/// The relative accuracy asked of the first root: it is relaxed while cells are spent, to 1 % at the end.
fn resolution(examined: usize) -> f64 {
    RESOLUTION * (1.0 + examined as f64 / 2000.0).powi(2)
}

/// The middle of an interval.
fn middle((low, high): (f64, f64)) -> f64 {
    0.5 * (low + high)
}

/// Halves of an interval.
fn halves(interval: (f64, f64)) -> [(f64, f64); 2] {
    let middle = middle(interval);
    [(interval.0, middle), (middle, interval.1)]
}

impl Family {
    /// The first root above `start` up to `end`, in windows that double from `width` on. `given` holds the other
    /// parameters.
    pub(super) fn first_root(
        &self,
        unknown: Unknown,
        given: &Cell,
        start: f64,
        width: f64,
        end: f64,
    ) -> FirstRoot {
        let (mut low, mut width) = (start, width);
        let mut examined = 0;
        while low < end.min(LARGEST) {
            let high = (low + width).min(end);
            width *= 2.0;
            let window = unknown.with_range(given, (low, high));
            let frequency = (0.0, self.frequency_bound(window.stiffness.1));
            let found = self.first_root_within(unknown, &Cell { frequency, ..window }, &mut examined);
            if found.at.is_some() || !found.is_finished {
                return found;
            }
            low = high;
        }
        FirstRoot { bound: low, at: None, is_finished: true }
    }

    /// The first root in a window; without one the bound is the window's end.
    fn first_root_within(&self, unknown: Unknown, window: &Cell, examined: &mut usize) -> FirstRoot {
        let (_, end) = unknown.range(window);
        let mut waiting = BinaryHeap::from([Waiting { from: unknown.range(window).0, cell: *window }]);
        let mut least: Option<(f64, Cell, [Complex64; 2])> = None;
        while let Some(Waiting { from, cell }) = waiting.pop() {
            if let Some((value, at, factors)) = least
                && from >= value - resolution(*examined) * unknown.scale(value)
            {
                return FirstRoot { bound: from.min(value), at: Some((at, factors)), is_finished: true };
            }
            *examined += 1;
            if *examined > MAX_CELLS {
                let at = least.map(|(_, at, factors)| (at, factors));
                return FirstRoot { bound: from, at, is_finished: false };
            }
            let Content::Possible { mut by_frequency, mut by_parameter, factors } = self.content(&cell)
            else {
                continue;
            };
            let range = unknown.range(&cell);
            let accuracy = resolution(*examined);
            let fine = range.1 - range.0 <= accuracy * unknown.scale(range.1);
            if cell.frequency.0 == 0.0 && !fine {
                // Slow motions: halve the unknown if its smallest value alone would be excluded.
                let smallest = unknown.with_range(&cell, (range.0, range.0));
                if matches!(self.content(&smallest), Content::Nothing) {
                    (by_frequency, by_parameter) = (0.0, f64::INFINITY);
                }
            }
            let frequency = middle(cell.frequency);
            let at = Cell { frequency: (frequency, frequency), ..cell };
            let before = least.map_or(f64::INFINITY, |(before, ..)| before);
            if let Some(root) = self.least_root_at(unknown, &at, range.0, middle(range).min(before), accuracy)
            {
                least = Some(root);
            }
            let narrow = cell.frequency.1 - cell.frequency.0 <= 1e-12 * cell.frequency.1
                || cell.frequency.1 <= SLOWEST * window.frequency.1;
            let split_frequency = !narrow && by_frequency > if fine { accuracy } else { by_parameter };
            if !split_frequency && fine {
                // A root, or too close to one for a decision.
                let at =
                    factors.map(|factors| (cell, factors)).or(least.map(|(_, at, factors)| (at, factors)));
                return FirstRoot { bound: from, at, is_finished: at.is_some() };
            }
            for part in 0..2 {
                let cell = if split_frequency {
                    Cell { frequency: halves(cell.frequency)[part], ..cell }
                } else {
                    unknown.with_range(&cell, halves(range)[part])
                };
                waiting.push(Waiting { from: unknown.range(&cell).0, cell });
            }
        }
        match least {
            Some((value, at, factors)) => {
                let bound = value - resolution(*examined) * unknown.scale(value);
                FirstRoot {
                    bound: bound.max(unknown.range(window).0),
                    at: Some((at, factors)),
                    is_finished: true,
                }
            }
            None => FirstRoot { bound: end, at: None, is_finished: true },
        }
    }

    /// A root at one frequency, for a value of the unknown below `before` and as small as a bisection finds it.
    fn least_root_at(
        &self,
        unknown: Unknown,
        at: &Cell,
        from: f64,
        before: f64,
        accuracy: f64,
    ) -> Option<(f64, Cell, [Complex64; 2])> {
        let root = |value: f64| {
            let point = unknown.with_range(at, (value, value));
            self.root_at(&point).map(|factors| (value, point, factors))
        };
        let mut found = root(before)?;
        let mut low = from;
        while found.0 - low > 0.1 * accuracy * unknown.scale(found.0) {
            let value = middle((low, found.0));
            match root(value) {
                Some(smaller) => found = smaller,
                None => low = value,
            }
        }
        Some(found)
    }

    /// Whether some member has a root on the imaginary axis at one value of all parameters.
    pub(super) fn find_crossing(&self, given: &Cell) -> Crossing {
        let whole = Cell { frequency: (0.0, self.frequency_bound(given.stiffness.1)), ..*given };
        let mut waiting = vec![whole];
        let mut examined = 0;
        while let Some(cell) = waiting.pop() {
            examined += 1;
            if examined > MAX_CELLS {
                return Crossing::Unresolved;
            }
            let Content::Possible { factors, .. } = self.content(&cell) else { continue };
            if cell.frequency.1 <= SLOWEST * whole.frequency.1 {
                return Crossing::Unresolved;
            }
            let frequency = middle(cell.frequency);
            let point = Cell { frequency: (frequency, frequency), ..cell };
            if self.root_at(&point).is_some() {
                return Crossing::Found;
            }
            if cell.frequency.1 - cell.frequency.0 <= 1e-11 * cell.frequency.1 {
                return if factors.is_some() { Crossing::Found } else { Crossing::Unresolved };
            }
            waiting.extend(halves(cell.frequency).map(|frequency| Cell { frequency, ..cell }));
        }
        Crossing::Excluded
    }
}
