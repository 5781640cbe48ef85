//! What the guard is worth with a study's robots and controllers.

use super::rehearsal::QUANTILE;
use super::{Study, Uncertainty};
use crate::error::Result;
use crate::model::Robot;
use crate::quantity;
use crate::session::{AccountSettings, Overdraft};

impl Study {
    /// The mass that each robot has at least, per axis, kg: the lower end of its 95 % interval.
    pub fn least_mass(&self) -> [Vec<f64>; 2] {
        self.lower_ends(Robot::mass, |known| &known.mass_sd, quantity::MASS.minimum())
    }

    /// The damping that each robot has at least, per axis, N·s/m: the lower end of its 95 % interval, or 0.
    pub fn least_damping(&self) -> [Vec<f64>; 2] {
        self.lower_ends(Robot::damping, |known| &known.damping_sd, 0.0)
    }

    /// The lower ends of the 95 % intervals of a parameter of both robots, per axis, but not below `least`.
    fn lower_ends(
        &self,
        values: fn(&Robot) -> &[f64],
        deviations: fn(&Uncertainty) -> &Vec<f64>,
        least: f64,
    ) -> [Vec<f64>; 2] {
        [0, 1].map(|robot| {
            let known = self.robots[robot].uncertainty.as_ref().map(deviations);
            let values = values(&self.dyad.robots()[robot]).iter().enumerate();
            let end = |(axis, value)| value - known.map_or(0.0, |sd| QUANTILE * sd[axis]);
            values.map(|value| end(value).max(least)).collect()
        })
    }

    /// How far the guard's account can be overdrawn at a stiffness (N/m), on the axis with the least mass.
    ///
    /// Sample period, computing tick, lag of the actuators and encoder are those of the laboratory's controllers; a
    /// computing time of `[controller]` counts as a computing tick. What holds the handle only makes it less.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`](crate::InvalidInput) if the stiffness is out of range, or as [`Study::sample_period`].
    ///
    /// # Examples
    ///
    /// ```
    /// let overdraft = telespring::study::Study::paper().guard_overdraft(142.5)?;
    /// assert!(overdraft.is_proven() && overdraft.ratio < 2e-4);
    /// assert!((overdraft.proven_stiffness - 0.1 * 0.7776 / 1e-6).abs() < 5.0);
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn guard_overdraft(&self, stiffness: f64) -> Result<Overdraft> {
        let settings = AccountSettings {
            sample_period: self.sample_period()?,
            computing_tick: self.setup.computing_tick || self.network.computing_time() > 0.0,
            actuator_lag: self.setup.actuator_lag,
            encoder_step: self.setup.encoder_resolution,
            ..AccountSettings::new(stiffness, [0.0; 2])
        };
        let least = self.least_mass().into_iter().flatten().fold(f64::INFINITY, f64::min);
        settings.overdraft(least)
    }
}
