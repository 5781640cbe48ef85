//! The lowest frequencies under a hold, where the rigid-body motion of free handles hides the other roots.

use std::f64::consts::PI;

use super::family::{Cell, Family, Hold, SideRange};

impl Family {
    /// Whether no root lies on the axis up to a low frequency under a hold: both factors 1 + B/(HC) have positive real and
    /// imaginary parts there, while e^(−jωT) lags by less than half a turn.
    pub(super) fn is_slow_motion_stable(&self, cell: &Cell, round_trip: (f64, f64)) -> bool {
        let Some(hold) = self.hold else { return false };
        let (frequency, c) = (cell.frequency.1, self.coupling_damping);
        let squared = frequency * frequency;
        if frequency * round_trip.1 >= PI || cell.stiffness.0 <= 0.0 {
            return false;
        }
        let damped = self.sides.iter().any(|side| side.damping.0 + cell.added.0 > 0.0);
        if !damped && c == 0.0 && round_trip.0 == 0.0 {
            return false;
        }
        if c > 0.0 {
            return self.is_slow_damper_stable(cell, &hold);
        }
        let lag = hold.lag();
        let angle = frequency * lag;
        if angle >= 1.0 || frequency * hold.period >= 1.0 {
            return false;
        }
        self.sides.iter().all(|side| {
            let Some([alias, _]) = side.aliases(&hold, frequency) else { return false };
            let damping = (side.damping.0 + cell.added.0, side.damping.1 + cell.added.1);
            // Both conditions are concave in the operator's stiffness: its ends decide.
            [side.stiffness.0, side.stiffness.1].into_iter().all(|ground| {
                let open = ground + side.mass.1 * squared + frequency * damping.1;
                let share = open * alias;
                if share >= 0.5 {
                    return false;
                }
                let error = open * share / (1.0 - share);
                let imaginary = ground * lag * angle.cos() - side.mass.1 * squared * lag
                    + damping.0 * angle.cos()
                    - error / frequency;
                let real = cell.stiffness.0 * hold.magnitude(frequency) + ground * angle.cos()
                    - side.mass.1 * squared
                    - frequency * damping.1 * angle
                    - error;
                imaginary > 0.0 && real > 0.0
            })
        })
    }

    /// The same with a coupling damper: operators so stiff that they turn the factor's imaginary part negative
    /// make it larger than 1 instead.
    fn is_slow_damper_stable(&self, cell: &Cell, hold: &Hold) -> bool {
        let (frequency, c) = (cell.frequency.1, self.coupling_damping);
        if frequency * hold.lag() >= 1.0 {
            return false;
        }
        // The ground stiffness up to which both parts are positive, and the least factors beyond it and in all.
        let mut limits = [(0.0, 0.0, 0.0); 2];
        for (limit, side) in limits.iter_mut().zip(&self.sides) {
            let Some([position, velocity]) = side.aliases(hold, frequency) else { return false };
            let aliases = [position / frequency, velocity];
            let Some(found) = self.slow_factor(side, cell, hold, aliases) else { return false };
            *limit = found;
        }
        [0, 1].into_iter().all(|i| {
            let (turning, beyond, _) = limits[i];
            let (_, _, other) = limits[1 - i];
            turning >= self.sides[i].stiffness.1 || other > 0.0 && beyond * other > 1.0 + 1e-12
        }) && c > 0.0
    }

    /// Of one factor 1 + B/(HC) in a cell of the lowest frequencies: the ground stiffness (N/m) up to which both of its
    /// parts are positive, its least magnitude with a stiffer operator, and with any. `aliases` bound ε by
    /// |B| (aliases₀ ω k + aliases₁ ω c)/|C|. `None` if nothing is known.
    fn slow_factor(
        &self,
        side: &SideRange,
        cell: &Cell,
        hold: &Hold,
        aliases: [f64; 2],
    ) -> Option<(f64, f64, f64)> {
        let (frequency, c, lag) = (cell.frequency.1, self.coupling_damping, hold.lag());
        let ((low, high), squared) = (cell.stiffness, frequency * frequency);
        let held = hold.magnitude(frequency);
        let cosine = (frequency * lag).cos();
        let damping = (side.damping.0 + cell.added.0, side.damping.1 + cell.added.1);
        let inertia = side.mass.1 * squared;
        // With B e^(jω lag) conj(C) = (x + jωb)(p + jq): p ≥ k cos, and q/ω lies between these.
        let turn = (low * lag * cosine - c, high * lag - c * cosine);
        let alias = aliases[0] * high + aliases[1] * c;
        let open = |ground: f64| ground + inertia + frequency * damping.1;
        // |B| |C| ε/(1 − ε)/ω, and ε itself.
        let error = |ground: f64| {
            let share = open(ground) * alias * frequency / low;
            let size = open(ground).powi(2) * alias / (1.0 - share);
            (if share < 0.5 { size } else { f64::INFINITY }, share)
        };
        // All of these are concave in the ground stiffness: the ends of an interval decide.
        let is_positive = |ground: f64| {
            let (error, _) = error(ground);
            let imaginary =
                damping.0 * low * cosine - ground * (-turn.0).max(0.0) - inertia * turn.1.max(0.0) - error;
            let real = held * low * low + ground * low * cosine
                - inertia * (high + frequency * c)
                - squared * damping.1 * turn.0.abs().max(turn.1.abs())
                - frequency * error;
            imaginary > 0.0 && real > 0.0
        };
        let lead = (1.0 + (c * frequency / low).powi(2)).sqrt();
        let magnitude = |ground: f64| {
            let (_, share) = error(ground);
            let lost = open(ground) / (held * low) * share / (1.0 - share);
            if share < 0.5 { (cosine + ground / high - inertia / low) / lead - lost } else { 0.0 }
        };
        let (least, most) = side.stiffness;
        let any = magnitude(least).min(magnitude(most));
        if is_positive(least) && is_positive(most) {
            return Some((most, f64::INFINITY, any));
        }
        let turning = 0.5 * damping.0 * low * cosine / (-turn.0).max(0.0);
        if !turning.is_finite() || turning > most {
            return None;
        }
        let starts = turning <= least;
        if !(starts || is_positive(least) && is_positive(turning)) {
            return None;
        }
        Some((turning, magnitude(turning.max(least)).min(magnitude(most)), any))
    }
}
