//! What the softest springs do to a resonance that nothing damps.
//!
//! A side that is held to the ground and has no damping rings at ω² = k_h/m, and a soft spring moves that
//! root by a part k²: too little for a count of roots or for a search in ω and k. But P₁ is real there,
//! so that the root is on the axis exactly where the imaginary part of e^(−jωT)/P₂(jω) is zero, on the
//! frequencies m₁ω² = k_h + k − k² Re(e^(−jωT)/P₂); where it is positive the root is unstable.

use num_complex::Complex64;

use crate::model::DyadAxis;

/// Resonances closer than this part of the ground stiffness are taken for one.
const COINCIDENT: f64 = 1e-8;

/// An undamped side held to the ground, its partner elsewhere.
pub(super) struct Resonance<'a> {
    axis: &'a DyadAxis,
    side: usize,
    round_trip: f64,
    /// Up to this stiffness (N/m) the description here holds, with at most one change of stability.
    pub valid: f64,
}

/// The resonances that nothing damps, and whether two of them coincide (these are not listed).
pub(super) fn undamped_resonances(axis: &DyadAxis, round_trip: f64) -> (Vec<Resonance<'_>>, bool) {
    let mut coincident = false;
    let mut found = Vec::new();
    for (side, own) in axis.sides.iter().enumerate() {
        if own.damping > 0.0 || own.ground_stiffness == 0.0 || axis.coupling_damping > 0.0 {
            continue;
        }
        let other = &axis.sides[1 - side];
        let frequency = (own.ground_stiffness / own.mass).sqrt();
        let gap = Resonance::partner(axis, side, frequency, 0.0).norm();
        if gap < COINCIDENT * (own.ground_stiffness + other.ground_stiffness) {
            coincident = true;
            continue;
        }
        // The partner's factor changes by 1 %, the phase of the delay by 0.1.
        let valid = (0.01 * gap / (1.0 + other.mass / own.mass)).min(0.2 * own.mass * frequency / round_trip);
        found.push(Resonance { axis, side, round_trip, valid: valid.min(0.01 * own.ground_stiffness) });
    }
    (found, coincident)
}

/// A stiffness (N/m) below which no root but those of undamped resonances crosses, where a handle is held
/// to the ground and there is no coupling damper.
pub(super) fn crossings_above(axis: &DyadAxis, round_trip: f64) -> f64 {
    let [first, second] = &axis.sides;
    let least = [(0, first, second), (1, second, first)].into_iter().map(|(side, own, other)| {
        if own.ground_stiffness == 0.0 {
            // A free mass on the spring: the delay and the partner's damping turn its force by half a turn.
            let lag = round_trip + other.damping / other.ground_stiffness;
            own.mass / (lag * lag)
        } else if own.damping > 0.0 {
            // |P₁ P₂| = k² next to the damped resonance.
            let frequency = (own.ground_stiffness / own.mass).sqrt();
            (own.damping * frequency * Resonance::partner(axis, side, frequency, 0.0).norm()).sqrt()
        } else {
            f64::INFINITY
        }
    });
    0.1 * least.fold(f64::INFINITY, f64::min)
}

impl Resonance<'_> {
    fn partner(axis: &DyadAxis, side: usize, frequency: f64, stiffness: f64) -> Complex64 {
        let other = &axis.sides[1 - side];
        let elastic = stiffness + other.ground_stiffness - other.mass * frequency * frequency;
        Complex64::new(elastic, other.damping * frequency)
    }

    /// Positive where the spring feeds the resonance, negative where it damps it.
    fn feeding(&self, stiffness: f64) -> f64 {
        let own = &self.axis.sides[self.side];
        let mut returned = Complex64::ZERO;
        // Each round gains four digits or more.
        for _ in 0..8 {
            let elastic = own.ground_stiffness + stiffness - stiffness * stiffness * returned.re;
            let frequency = (elastic / own.mass).sqrt();
            let partner = Self::partner(self.axis, self.side, frequency, stiffness);
            returned = Complex64::from_polar(1.0, -frequency * self.round_trip) / partner;
        }
        returned.im
    }

    /// The stiffness up to `limit` at which the resonance first becomes unstable; None where it does not.
    pub fn first_loss(&self, limit: f64) -> Option<f64> {
        if self.feeding(1e-9 * limit) > 0.0 {
            return Some(0.0);
        }
        if self.feeding(limit) <= 0.0 {
            return None;
        }
        let (mut low, mut high) = (0.0, limit);
        while high - low > 1e-15 * high {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            if self.feeding(middle) > 0.0 { high = middle } else { low = middle }
        }
        Some(low)
    }

    /// The frequencies (rad/s) between which the resonance stays up to the stiffness `limit`.
    pub fn band(&self, limit: f64) -> (f64, f64) {
        let own = &self.axis.sides[self.side];
        let frequency = |shift: f64| ((own.ground_stiffness + shift * limit) / own.mass).sqrt();
        (frequency(-0.1), frequency(1.1))
    }
}
