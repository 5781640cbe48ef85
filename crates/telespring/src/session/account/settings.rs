//! The settings of an energy account.

use crate::error::{InvalidInput, Result};
use crate::quantity;

/// The settings of an energy account.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AccountSettings {
    /// The stiffness of the virtual spring, N/m.
    pub stiffness: f64,
    /// The damping that the robot has at least, per axis, N·s/m: the lower end of its identified interval.
    pub damping: [f64; 2],
    /// The share of the loss in this damping that the spring may give out again, from 0 to below 1.
    pub share: f64,
    /// What the account holds at the start, and at most beyond the energy of the spring, J.
    pub capacity: f64,
    /// The largest power at which energy of the partner is taken in, W. What would have to wait longer than 5 s is lost.
    pub intake: f64,
    /// The step of the position sensor, m; 0 for none.
    pub encoder_step: f64,
    /// Whether a force acts only one sample period after the motion it was computed from.
    pub computing_tick: bool,
    /// The time between two measurements, s.
    pub sample_period: f64,
    /// The time constant with which the device's force follows the commanded one, s; 0 for none. What is settled is then
    /// the mean force that acted, not the commanded one.
    pub actuator_lag: f64,
}

impl AccountSettings {
    /// The usual settings for a spring (N/m) and a robot's least damping (N·s/m): a share of 0.7, 0.05 J, 0.3 W, 1 kHz,
    /// no encoder step, no computing tick and no lag.
    pub fn new(stiffness: f64, damping: [f64; 2]) -> Self {
        Self {
            stiffness,
            damping,
            share: 0.7,
            capacity: 0.05,
            intake: 0.3,
            encoder_step: 0.0,
            computing_tick: false,
            sample_period: 1e-3,
            actuator_lag: 0.0,
        }
    }

    /// The settings, if each is in range.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] for the first setting out of range.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::session::AccountSettings;
    ///
    /// let settings = AccountSettings { share: 1.0, ..AccountSettings::new(100.0, [6.0, 6.0]) };
    /// assert_eq!(settings.checked().unwrap_err().field, "share");
    /// ```
    pub fn checked(self) -> Result<Self> {
        quantity::STIFFNESS.check("stiffness", self.stiffness)?;
        let [x, y] = self.damping;
        quantity::DAMPING.check("damping[0]", x)?;
        quantity::DAMPING.check("damping[1]", y)?;
        if !(self.share >= 0.0 && self.share < 1.0) {
            return Err(InvalidInput::new(
                "share",
                self.share,
                "the share of the loss that may be spent must be a number from 0 to below 1",
                "With a share of 1 a motion never dies out: 0.7 leaves three tenths of the loss.",
            ));
        }
        quantity::ENERGY.check("capacity", self.capacity)?;
        quantity::POWER.check("intake", self.intake)?;
        quantity::RESOLUTION.check("encoder_step", self.encoder_step)?;
        quantity::SAMPLE_PERIOD.check("sample_period", self.sample_period)?;
        quantity::SPAN.check("actuator_lag", self.actuator_lag)?;
        Ok(self)
    }
}
