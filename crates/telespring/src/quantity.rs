//! The physical quantities of the model, each with its unit and allowed range.
//!
//! The ranges cover every rehabilitation robot, and no computation overflows within them: they bound what can
//! be computed. What a laboratory has is a second, narrower range, [`Quantity::check_usual`]: a delay of 80 or
//! a mass of 833.4 can be computed, but was probably meant in ms or g.

mod usual;

use crate::error::{InvalidInput, Result};

/// A physical quantity: name, unit and allowed range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quantity {
    name: &'static str,
    unit: &'static str,
    minimum: f64,
    maximum: f64,
    /// The unit most often confused with `unit`, and the factor from it to `unit`.
    slip: Option<(&'static str, f64)>,
}

/// A mass in kg.
pub const MASS: Quantity = Quantity::new("a mass", "kg", 1e-4, 1e4, Some(("g", 1e-3)));
/// An added mass in kg; 0 if absent (an operator's).
pub const ADDED_MASS: Quantity = Quantity::new("an added mass", "kg", 0.0, 1e4, Some(("g", 1e-3)));
/// A viscous damping in N·s/m.
pub const DAMPING: Quantity = Quantity::new("a damping", "N·s/m", 0.0, 1e6, None);
/// A wave impedance in N·s/m.
pub const IMPEDANCE: Quantity = Quantity::new("a wave impedance", "N·s/m", 1e-3, 1e6, None);
/// The combined mass of a robot and its operator in kg.
pub(crate) const SIDE_MASS: Quantity = Quantity::new("a mass", "kg", 1e-4, 2e4, Some(("g", 1e-3)));
/// The combined viscous damping of a robot and its operator in N·s/m.
pub(crate) const SIDE_DAMPING: Quantity = Quantity::new("a damping", "N·s/m", 0.0, 2e6, None);
/// The stiffness of the virtual spring in N/m.
pub const STIFFNESS: Quantity = Quantity::new("a coupling stiffness", "N/m", 1e-6, 1e7, None);
/// A stiffness to ground in N/m; 0 if absent (an operator's).
pub const GROUND_STIFFNESS: Quantity = Quantity::new("an operator stiffness", "N/m", 0.0, 1e7, None);
/// The stiffness of a spring between a robot and the ground in N/m; 0 if absent.
pub const ROBOT_SPRING: Quantity = Quantity::new("a robot's spring to the ground", "N/m", 0.0, 1e7, None);
/// The viscous damping of an operator in N·s/m.
pub const OPERATOR_DAMPING: Quantity = Quantity::new("an operator damping", "N·s/m", 0.0, 1e6, None);
/// A one-way delay in s.
pub const DELAY: Quantity = Quantity::new("a delay", "s", 0.0, 100.0, Some(("ms", 1e-3)));
/// A time span in s other than a network delay: jitter, gap, sample period.
pub const SPAN: Quantity = Quantity::new("a time span", "s", 0.0, 100.0, Some(("ms", 1e-3)));
/// The sample period of a controller in s; 0 for a continuous one.
pub const CONTROLLER_PERIOD: Quantity =
    Quantity::new("a controller's sample period", "s", 0.0, 100.0, Some(("ms", 1e-3)));
/// The duration of a simulation in s.
pub const DURATION: Quantity = Quantity::new("a duration", "s", 1e-9, 1e6, None);
/// A sampling rate in Hz.
pub const RATE: Quantity = Quantity::new("a rate", "Hz", 1e-6, 1e9, Some(("kHz", 1e3)));
/// A decay rate in 1/s.
pub const DECAY_RATE: Quantity = Quantity::new("a decay rate", "1/s", 0.0, 1e6, None);
/// The sample period of a controller in s.
pub const SAMPLE_PERIOD: Quantity = Quantity::new("a sample period", "s", 1e-6, 1.0, Some(("ms", 1e-3)));
/// A Coulomb friction in N.
pub const COULOMB: Quantity = Quantity::new("a Coulomb friction", "N", 0.0, 1e6, None);
/// A force in N.
pub const FORCE: Quantity = Quantity::new("a force", "N", -1e9, 1e9, None);
/// A velocity along an axis, m/s.
pub const VELOCITY: Quantity = Quantity::new("a velocity", "m/s", -1e3, 1e3, Some(("mm/s", 1e-3)));
/// A position on an axis in m.
pub const PLACE: Quantity = Quantity::new("a position", "m", -10.0, 10.0, Some(("mm", 1e-3)));
/// The amplitude of a movement, m.
pub const AMPLITUDE: Quantity = Quantity::new("an amplitude", "m", 0.0, 10.0, Some(("mm", 1e-3)));
/// The length of a link, m.
pub const LENGTH: Quantity = Quantity::new("a link length", "m", 1e-2, 10.0, Some(("mm", 1e-3)));
/// The mass of a link in kg.
pub const LINK_MASS: Quantity = Quantity::new("a link mass", "kg", 0.0, 1e3, Some(("g", 1e-3)));
/// A distance along a link, m.
pub const OFFSET: Quantity = Quantity::new("a distance", "m", -10.0, 10.0, Some(("mm", 1e-3)));
/// The resolution of a position sensor in m.
pub const RESOLUTION: Quantity = Quantity::new("an encoder resolution", "m", 0.0, 0.1, Some(("µm", 1e-6)));
/// An energy in J.
pub const ENERGY: Quantity = Quantity::new("an energy", "J", 0.0, 1e3, Some(("mJ", 1e-3)));
/// A power in W.
pub const POWER: Quantity = Quantity::new("a power", "W", 0.0, 1e3, Some(("mW", 1e-3)));
/// How far a partner that lies moves its position, m.
pub const POSITION_SHIFT: Quantity =
    Quantity::new("a shift of a position", "m", 0.0, 10.0, Some(("mm", 1e-3)));
/// How far a partner that lies moves its time stamps, s; negative makes its motion older.
pub const STAMP_SHIFT: Quantity =
    Quantity::new("a shift of a time stamp", "s", -100.0, 100.0, Some(("ms", 1e-3)));
/// A moment of inertia in kg·m².
pub const INERTIA: Quantity = Quantity::new("a moment of inertia", "kg·m²", 0.0, 1e3, None);
/// The viscous damping of a joint in N·m·s/rad.
pub const JOINT_DAMPING: Quantity = Quantity::new("a joint damping", "N·m·s/rad", 0.0, 1e4, None);
/// A torque limit in N·m; infinite if there is none.
pub const TORQUE: Quantity = Quantity::new("a torque limit", "N·m", 1e-6, f64::INFINITY, None);
/// The standard deviation of a velocity in m/s.
pub const SPEED: Quantity =
    Quantity::new("a standard deviation of velocity", "m/s", 0.0, 100.0, Some(("mm/s", 1e-3)));
/// The lifetime of a spot in s.
pub const LIFETIME: Quantity = Quantity::new("a lifetime", "s", 1e-3, 1e6, Some(("ms", 1e-3)));
/// An angular frequency in rad/s.
pub const ANGULAR_FREQUENCY: Quantity = Quantity::new("an angular frequency", "rad/s", 0.0, 1e4, None);
/// A probability.
pub const PROBABILITY: Quantity = Quantity::new("a probability", "", 0.0, 1.0, Some(("%", 1e-2)));
/// The rate of a network's link in bit/s.
pub const BIT_RATE: Quantity = Quantity::new("a rate", "bit/s", 1.0, 1e15, Some(("kbit/s", 1e3)));
/// The standard deviation of a mass in kg.
pub const MASS_SD: Quantity = Quantity::new("a standard deviation of a mass", "kg", 0.0, 1e4, None);
/// The standard deviation of a damping in N·s/m.
pub const DAMPING_SD: Quantity = Quantity::new("a standard deviation of a damping", "N·s/m", 0.0, 1e6, None);
/// A share of something.
pub const SHARE: Quantity = Quantity::new("a share", "", 0.0, 1.0, Some(("%", 1e-2)));
/// A ratio of two stiffnesses.
pub const RATIO: Quantity = Quantity::new("a ratio", "", 1e-3, 1e3, None);
/// A damping per energy that is missing, N·s/m for each J.
pub const FILLING: Quantity = Quantity::new("a damping per energy", "N·s/m per J", 0.0, 1e9, None);
/// The spectral density of the noise of a motion: m²/s³ of the acceleration, m²/s⁵ of the jerk.
pub const PROCESS_NOISE: Quantity = Quantity::new(
    "a process noise",
    "m²/s³ (of a velocity) or m²/s⁵ (of an acceleration)",
    1e-12,
    1e12,
    None,
);
/// The standard deviation of a measured position in m.
pub const POSITION_NOISE: Quantity =
    Quantity::new("a standard deviation of a position", "m", 1e-12, 1e3, None);
/// The correlation of two estimates.
pub const CORRELATION: Quantity = Quantity::new("a correlation", "", -1.0, 1.0, None);
/// A part of a trial in s; 0 for none.
pub const SPAN_OF_TRIAL: Quantity = Quantity::new("a part of a trial", "s", 0.0, 3600.0, Some(("ms", 1e-3)));
/// The duration of a trial in s.
pub const TRIAL_DURATION: Quantity =
    Quantity::new("a trial's duration", "s", 1e-3, 3600.0, Some(("ms", 1e-3)));

impl Quantity {
    /// A quantity with its unit and its range.
    const fn new(
        name: &'static str,
        unit: &'static str,
        minimum: f64,
        maximum: f64,
        slip: Option<(&'static str, f64)>,
    ) -> Self {
        Self { name, unit, minimum, maximum, slip }
    }

    /// The unit of the quantity; empty if it is dimensionless.
    pub const fn unit(&self) -> &'static str {
        self.unit
    }

    /// The smallest allowed value of the quantity.
    pub const fn minimum(&self) -> f64 {
        self.minimum
    }

    /// The largest allowed value of the quantity.
    pub const fn maximum(&self) -> f64 {
        self.maximum
    }

    /// Whether a value lies in the range of the quantity.
    #[inline]
    fn contains(&self, value: f64) -> bool {
        value >= self.minimum && value <= self.maximum
    }

    /// Checks that `value` is finite and within the range of the quantity, and returns it.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] with `field`, the value, the range with its unit, and the unit probably meant.
    #[inline]
    pub fn check(&self, field: &str, value: f64) -> Result<f64> {
        if self.contains(value) { Ok(value) } else { Err(self.refusal(field, value)) }
    }

    /// The refusal of a value out of the quantity's range; inlined, it would slow loops over many axes.
    #[cold]
    #[inline(never)]
    fn refusal(&self, field: &str, value: f64) -> InvalidInput {
        let remedy = match self.slip {
            Some((unit, factor))
                if (value > self.maximum || self.minimum < 0.0)
                    && (self.minimum..=self.maximum).contains(&(value * factor)) =>
            {
                format!(
                    "Everything is in SI units: if {value} was meant in {unit}, write {}.",
                    value * factor
                )
            }
            _ if value.is_nan() => "Replace the missing value by a number.".to_owned(),
            _ if value < 0.0 => "Check the sign and the unit.".to_owned(),
            _ if self.unit.is_empty() => "Check the value.".to_owned(),
            _ => format!("Check the unit: {} is expected.", self.unit),
        };
        let range = format!("{} to {} {}", self.minimum, self.maximum, self.unit);
        InvalidInput::new(
            field,
            value,
            format!("{} must be a number from {}", self.name, range.trim_end()),
            remedy,
        )
    }
}
