//! Undamped resonances under a very soft spring.
//!
//! A grounded side without damping resonates at ω² = k_h/m. A soft spring moves that root only in
//! proportion to k², too little for a count of roots or for a search in ω and k. But P₁ is real there, so
//! the root lies on the axis exactly where the imaginary part of e^(−jωT)/P₂(jω) is zero, at the
//! frequencies m₁ω² = k_h + k − k² Re(e^(−jωT)/P₂). It is unstable where that part is positive.

use num_complex::Complex64;

use crate::model::DyadAxis;

/// Resonances closer than this fraction of the ground stiffness count as one.
const COINCIDENT: f64 = 1e-8;

/// The resonance of an undamped, grounded side that is not shared by its partner.
pub(super) struct Resonance<'a> {
    axis: &'a DyadAxis,
    side: usize,
    round_trip: f64,
    /// The description holds up to this stiffness (N/m), with at most one change of stability.
    pub valid: f64,
}

/// The undamped resonances of an axis, and whether two of them coincide (those are not listed).
pub(super) fn undamped_resonances(axis: &DyadAxis, round_trip: f64) -> (Vec<Resonance<'_>>, bool) {
    let mut coincident = false;
    let mut resonances = Vec::new();
    for (side, own) in axis.sides.iter().enumerate() {
        if own.damping > 0.0 || own.ground_stiffness == 0.0 || axis.coupling_damping > 0.0 {
            continue;
        }
        let other = &axis.sides[1 - side];
        let frequency = (own.ground_stiffness / own.mass).sqrt();
        let gap = Resonance::partner_factor(axis, side, frequency, 0.0).norm();
        if gap < COINCIDENT * (own.ground_stiffness + other.ground_stiffness) {
            coincident = true;
            continue;
        }
        // The partner's factor changes by 1 %, the delay phase by 0.1.
        let valid = (0.01 * gap / (1.0 + other.mass / own.mass)).min(0.2 * own.mass * frequency / round_trip);
        resonances.push(Resonance { axis, side, round_trip, valid: valid.min(0.01 * own.ground_stiffness) });
    }
    (resonances, coincident)
}

/// A stiffness (N/m) below which only roots of undamped resonances cross, for an axis with a grounded
/// operator and no coupling damper.
pub(super) fn crossing_free_stiffness(axis: &DyadAxis, round_trip: f64) -> f64 {
    let [first, second] = &axis.sides;
    let least = [(0, first, second), (1, second, first)].into_iter().map(|(side, own, other)| {
        if own.ground_stiffness == 0.0 {
            // A free mass on the spring: delay and partner damping turn its force by half a turn.
            let lag = round_trip + other.damping / other.ground_stiffness;
            own.mass / (lag * lag)
        } else if own.damping > 0.0 {
            // |P₁ P₂| = k² next to the damped resonance.
            let frequency = (own.ground_stiffness / own.mass).sqrt();
            (own.damping * frequency * Resonance::partner_factor(axis, side, frequency, 0.0).norm()).sqrt()
        } else {
            f64::INFINITY
        }
    });
    0.1 * least.fold(f64::INFINITY, f64::min)
}

impl Resonance<'_> {
    /// The partner's factor P₂(jω) at the frequency of an undamped resonance.
    fn partner_factor(axis: &DyadAxis, side: usize, frequency: f64, stiffness: f64) -> Complex64 {
        let other = &axis.sides[1 - side];
        let elastic = stiffness + other.ground_stiffness - other.mass * frequency * frequency;
        Complex64::new(elastic, other.damping * frequency)
    }

    /// The destabilising part of the returned spring force: positive if it feeds the resonance, negative if
    /// it damps it.
    fn destabilising_part(&self, stiffness: f64) -> f64 {
        let own = &self.axis.sides[self.side];
        let mut returned = Complex64::ZERO;
        // Each iteration gains four digits or more.
        for _ in 0..8 {
            let elastic = own.ground_stiffness + stiffness - stiffness * stiffness * returned.re;
            let frequency = (elastic / own.mass).sqrt();
            let partner = Self::partner_factor(self.axis, self.side, frequency, stiffness);
            returned = Complex64::from_polar(1.0, -frequency * self.round_trip) / partner;
        }
        returned.im
    }

    /// The smallest stiffness up to `limit` at which the undamped resonance becomes unstable; `None` if it stays
    /// stable.
    pub fn first_unstable_stiffness(&self, limit: f64) -> Option<f64> {
        if self.destabilising_part(1e-9 * limit) > 0.0 {
            return Some(0.0);
        }
        if self.destabilising_part(limit) <= 0.0 {
            return None;
        }
        let (mut low, mut high) = (0.0, limit);
        while high - low > 1e-15 * high {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            if self.destabilising_part(middle) > 0.0 { high = middle } else { low = middle }
        }
        Some(low)
    }

    /// The frequency range (rad/s) of the undamped resonance for stiffnesses up to `limit`.
    pub fn frequency_band(&self, limit: f64) -> (f64, f64) {
        let own = &self.axis.sides[self.side];
        let frequency = |shift: f64| ((own.ground_stiffness + shift * limit) / own.mass).sqrt();
        (frequency(-0.1), frequency(1.1))
    }
}
