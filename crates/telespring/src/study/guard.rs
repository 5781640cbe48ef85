//! What the guard is worth with a study's robots and controllers.

use super::Study;
use super::rehearsal::QUANTILE;
use crate::error::Result;
use crate::quantity;
use crate::session::{AccountSettings, Overdraft};

impl Study {
    /// The mass that each robot has at least, per axis, kg: the lower end of its 95 % interval.
    pub(super) fn least_mass(&self, robot: usize) -> Vec<f64> {
        let mass = self.dyad.robots()[robot].mass();
        let sd = self.robots[robot].uncertainty.as_ref().map(|known| &known.mass_sd);
        let least = |axis: usize| mass[axis] - sd.map_or(0.0, |sd| QUANTILE * sd[axis]);
        (0..mass.len()).map(|axis| least(axis).max(quantity::MASS.minimum())).collect()
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
        let least = (0..2).flat_map(|robot| self.least_mass(robot)).fold(f64::INFINITY, f64::min);
        settings.overdraft(least)
    }
}
