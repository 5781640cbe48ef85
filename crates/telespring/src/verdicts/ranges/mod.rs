//! Certified bounds over a range of operators.
//!
//! A grip varies, and the worst operator need not be at a corner of its range. The bounds here hold for every
//! operator of the range: a search excludes roots on the imaginary axis for the whole family at once (the
//! zero-exclusion principle of robust control), from the smallest value of the unknown on.
//!
//! | module | content |
//! |---|---|
//! | `value_set` | whether the products of two rectangles reach a number |
//! | `products` | the same for a sector of a ring, by halving the rectangles |
//! | `family` | the rectangles of all operators over a cell of frequencies and parameters |
//! | `slow_motion` | the lowest frequencies, with the rigid-body motion |
//! | `search` | branch and bound for the first root |

mod family;
mod products;
mod search;
mod slow_motion;
mod value_set;

pub(super) use family::{Family, Hold, SideRange};
pub(super) use search::Crossing;

use super::bounded_delay;
use family::Cell;
use search::Unknown;

/// A bound that holds for every member of a family.
#[derive(Debug, Clone, Copy)]
pub(super) struct CertifiedBound {
    /// The bound. For a search upwards no member has a root below it, for one downwards none above it.
    pub value: f64,
    /// The values of both sides (mass, damping, stiffness) with a root next to the bound, if one was found.
    pub sides: Option<[[f64; 3]; 2]>,
    /// False if the search was cut off: the bound holds, but may be far from the truth.
    pub is_finished: bool,
}

/// A delay that ends a search for the first unstable one, s.
const LONGEST_ROUND_TRIP: f64 = 1e5;

impl Family {
    /// Whether no member can move without loss, so that all are stable without delay.
    pub fn is_stable_without_delay(&self) -> bool {
        let [first, second] = &self.sides;
        // Both sides move as one where k_h,1 m₂ = k_h,2 m₁.
        let together = first.stiffness.0 * second.mass.0 <= second.stiffness.1 * first.mass.1
            && first.stiffness.1 * second.mass.1 >= second.stiffness.0 * first.mass.0;
        first.damping.0 > 0.0 || second.damping.0 > 0.0 || self.coupling_damping > 0.0 && !together
    }

    /// Whether some member has a side that resonates without loss: no stiffness is then stable at every delay.
    pub fn has_lossless_side(&self) -> bool {
        self.coupling_damping == 0.0 && self.sides.iter().any(|side| side.damping.0 == 0.0)
    }

    /// A stiffness (N/m) up to which every member is stable at every constant delay; 0 if none is known.
    pub fn soft_stiffness(&self) -> f64 {
        let c = self.coupling_damping;
        let loss = self.sides.map(|side| side.damping.0 * (side.damping.0 + 2.0 * c));
        // |Pᵢ|² ≥ |k + cs|² on both sides, as for a single axis.
        let own = (0..2).fold(f64::INFINITY, |least, i| {
            let (half, ground) = (0.5 * loss[i] / self.sides[i].mass.1, self.sides[i].stiffness.0);
            least.min(half + (2.0 * half * ground).sqrt())
        });
        if own > 0.0 || c == 0.0 {
            return own;
        }
        // One side has no damping of its own. |P₁P₂| > |k + cs|² for c b₂ ξ > k², since |P₁|² ≥ c²ξ and
        // |P₂|² ≥ (b₂ + c)²ξ; for smaller ξ it follows from the two conditions below.
        let [b, d, m_damped, m_other] = if loss[0] > 0.0 {
            [self.sides[0].damping.0, loss[0], self.sides[0].mass.1, self.sides[1].mass.1]
        } else {
            [self.sides[1].damping.0, loss[1], self.sides[1].mass.1, self.sides[0].mass.1]
        };
        0.99 * (0.25 * c * b / m_other).min(d / (4.0 * m_other + 2.0 * m_damped))
    }

    /// Whether tier 2's rule for continuous controllers applies: up to its bounds no passive operator has a root.
    fn is_passively_coupled(&self) -> bool {
        self.hold.is_none() && self.coupling_damping == 0.0
    }

    /// The smallest damping on both sides, N·s/m.
    fn least_damping(&self) -> [f64; 2] {
        self.sides.map(|side| side.damping.0)
    }

    /// The cell of all parameters at one value each.
    fn at(stiffness: f64, round_trip: Option<f64>) -> Cell {
        Cell {
            frequency: (0.0, 0.0),
            stiffness: (stiffness, stiffness),
            round_trip: round_trip.map(|trip| (trip, trip)),
            added: (0.0, 0.0),
        }
    }

    /// The first stiffness (N/m) from `start` to `limit` at which some member has a root on the axis, at a round trip
    /// (s) or, with `None`, at any.
    pub fn first_stiffness(&self, round_trip: Option<f64>, start: f64, limit: f64) -> CertifiedBound {
        let mut start = start;
        if let Some(round_trip) = round_trip
            && self.is_passively_coupled()
        {
            let [forward, backward] = [0.5 * round_trip; 2];
            start = start.max(bounded_delay::stiffness_bound(self.least_damping(), [forward, backward], 0.0));
        }
        self.search(Unknown::Stiffness, &Self::at(start, round_trip), start, start, limit)
    }

    /// The first round trip (s) up to `limit` at which some member has a root on the axis at a stiffness (N/m).
    pub fn first_round_trip(&self, stiffness: f64, limit: f64) -> CertifiedBound {
        let fastest = Self { hold: None, ..*self }.frequency_bound(stiffness);
        let limit = limit.min(LONGEST_ROUND_TRIP);
        let start = if self.is_passively_coupled() {
            bounded_delay::round_trip_bound(self.least_damping(), stiffness)
        } else {
            0.0
        };
        self.search(Unknown::RoundTrip, &Self::at(stiffness, Some(0.0)), start, 1.0 / fastest, limit)
    }

    /// Whether no member has a root on the axis at a stiffness (N/m) for any round trip of a range (s).
    pub fn excludes_round_trips(&self, stiffness: f64, (from, to): (f64, f64)) -> bool {
        if to <= from {
            return self.crossing(stiffness, Some(from)) == Crossing::Excluded;
        }
        let found = self.search(Unknown::RoundTrip, &Self::at(stiffness, Some(from)), from, to - from, to);
        found.is_finished && found.value >= to
    }

    /// Whether no member has a root on the axis at a round trip (s) for any stiffness of a range (N/m).
    pub fn excludes_stiffnesses(&self, (from, to): (f64, f64), round_trip: f64) -> bool {
        let found = self.search(Unknown::Stiffness, &Self::at(from, Some(round_trip)), from, to - from, to);
        found.is_finished && found.value >= to
    }

    /// The damping (N·s/m), added to both robots, above which no member has a root on the axis up to `most`.
    pub fn last_damping(&self, stiffness: f64, round_trip: f64, most: f64) -> CertifiedBound {
        let mut most = most;
        if self.is_passively_coupled() {
            let added = bounded_delay::added_damping(self.least_damping(), stiffness, round_trip);
            most = most.min(added * (1.0 + 1e-9));
        }
        let given = Self::at(stiffness, Some(round_trip));
        let missing = self.search(Unknown::Damping { most }, &given, 0.0, most, most);
        CertifiedBound { value: most - missing.value, ..missing }
    }

    /// Runs a search and names the member that it ends at.
    fn search(&self, unknown: Unknown, given: &Cell, start: f64, width: f64, end: f64) -> CertifiedBound {
        let found = self.first_root(unknown, given, start, width, end);
        CertifiedBound {
            value: found.bound,
            sides: found.at.map(|(cell, factors)| self.sides_of(&cell, factors)),
            is_finished: found.is_finished,
        }
    }

    /// Whether some member has a root on the axis at a stiffness (N/m) and a round trip (s) or, with `None`, any.
    pub fn crossing(&self, stiffness: f64, round_trip: Option<f64>) -> Crossing {
        self.find_crossing(&Self::at(stiffness, round_trip))
    }
}
