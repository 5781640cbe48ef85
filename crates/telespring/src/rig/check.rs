//! Checks of the values of a laboratory.

use super::{
    Agent, Arm, Controller, Handle, Laboratory, Network, NetworkModel, SessionPlan, Spots, Station, Target,
};
use crate::error::{InvalidInput, Result};
use crate::quantity::{self, Quantity};

/// Checks the x and y values of a quantity in a laboratory.
fn check_per_axis(quantity: Quantity, field: &str, values: [f64; 2]) -> Result<()> {
    for (index, value) in values.into_iter().enumerate() {
        quantity.check(&format!("{field}[{index}]"), value)?;
    }
    Ok(())
}

impl Laboratory {
    /// The paper's laboratory, all values in range: both H-MAN robots of Table III without Coulomb friction,
    /// ideal massless arms, the skilled agent of Eq. 13 and the less-skilled agent of Eq. 14 with ten spots,
    /// the figure of eight of Eq. 12, controllers at 1 kHz, and a network with a constant delay only.
    ///
    /// A spot lives 0.2 s: by then a typical spot is 0.06 m away, about the size of the figure. A much
    /// wider cloud would hide the target rather than blur it. The paper gives no lifetime.
    pub fn paper() -> Self {
        let dyad = crate::model::hman();
        let per_axis = |values: &[f64]| [values[0], values[1]];
        let side = |index: usize, agent| {
            let robot = &dyad.robots()[index];
            Station {
                handle: Handle {
                    mass: per_axis(robot.mass()),
                    damping: per_axis(robot.damping()),
                    coulomb: [0.0; 2],
                },
                arm: Arm::Lumped { mass: [0.0; 2], damping: [0.0; 2] },
                agent,
            }
        };
        let spots = Spots { count: 10, velocity: 0.3, lifetime: 0.2 };
        let stations = [
            side(0, Agent::Skilled { stiffness: 120.0, damping: 0.0 }),
            side(1, Agent::Blurred { stiffness: 120.0, spots }),
        ];
        Self {
            stations,
            target: Target::FigureEight { amplitude: [0.05, 0.1], angular_frequency: 2.59 },
            controller: Controller {
                sample_period: 1e-3,
                computing_tick: false,
                actuator_lag: 0.0,
                encoder_resolution: 0.0,
            },
            network: Network::each_way(NetworkModel::ideal()),
            session: SessionPlan::spring(stations.map(|station| station.handle)),
        }
    }

    /// Checks all values of the laboratory; errors use field names of a study file, such as `arm1.link_length[0]`.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] for the first value out of range.
    ///
    /// # Examples
    ///
    /// ```
    /// let mut laboratory = telespring::rig::Laboratory::paper();
    /// laboratory.check()?;
    /// laboratory.network.forward.loss = 1.5;
    /// assert_eq!(laboratory.check().unwrap_err().field, "network.loss.forward");
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn check(&self) -> Result<()> {
        for (index, side) in self.stations.iter().enumerate() {
            let number = index + 1;
            side.handle.check().map_err(|refusal| refusal.within(&format!("robot{number}")))?;
            side.arm.check().map_err(|refusal| refusal.within(&format!("arm{number}")))?;
            side.agent.check().map_err(|refusal| refusal.within(&format!("agent{number}")))?;
        }
        self.target.check().map_err(|refusal| refusal.within("task"))?;
        self.controller.check().map_err(|refusal| refusal.within("laboratory"))?;
        self.network.check().map_err(|refusal| refusal.within("network"))?;
        self.session.check().map_err(|refusal| refusal.within("session"))?;
        let period = self.controller.sample_period;
        for (index, side) in self.stations.iter().enumerate() {
            if let Agent::Blurred { spots, .. } = side.agent
                && spots.lifetime < period
            {
                return Err(InvalidInput::new(
                    format!("agent{}.spot_lifetime", index + 1),
                    spots.lifetime,
                    format!("a spot must live for at least one sample period, here {period} s"),
                    "Give a lifetime in s, such as 0.2.",
                ));
            }
        }
        Ok(())
    }
}

impl SessionPlan {
    /// Checks what the controllers of a laboratory may count on; its architecture is checked with a trial's condition.
    fn check(&self) -> Result<()> {
        for (index, damping) in self.least_damping.into_iter().enumerate() {
            check_per_axis(quantity::DAMPING, &format!("least_damping[{index}]"), damping)?;
        }
        for (index, mass) in self.least_mass.into_iter().enumerate() {
            check_per_axis(quantity::MASS, &format!("least_mass[{index}]"), mass)?;
        }
        check_per_axis(quantity::SPAN, "lateness", self.lateness)
    }
}

impl Handle {
    /// Checks that the laboratory's handle has mass, damping and friction in range.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] with a field such as `coulomb[1]`.
    pub fn check(&self) -> Result<()> {
        check_per_axis(quantity::MASS, "mass", self.mass)?;
        check_per_axis(quantity::DAMPING, "damping", self.damping)?;
        check_per_axis(quantity::COULOMB, "coulomb", self.coulomb)
    }
}

impl Arm {
    /// Checks that all values of the laboratory's arm are in range.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] with a field such as `mass[0]`.
    pub fn check(&self) -> Result<()> {
        match self {
            Self::Lumped { mass, damping } => {
                check_per_axis(quantity::ADDED_MASS, "mass", *mass)?;
                check_per_axis(quantity::DAMPING, "damping", *damping)
            }
            Self::TwoLink(arm) => arm.checked().map(|_| ()),
        }
    }
}

impl Agent {
    /// Checks that all values of the laboratory's agent are in range.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] with a field such as `spot_velocity`.
    pub fn check(&self) -> Result<()> {
        match *self {
            Self::Skilled { stiffness, damping } => {
                quantity::GROUND_STIFFNESS.check("stiffness", stiffness)?;
                quantity::DAMPING.check("damping", damping)?;
            }
            Self::Blurred { stiffness, spots } => {
                quantity::GROUND_STIFFNESS.check("stiffness", stiffness)?;
                spots.check()?;
            }
            Self::External => {}
        }
        Ok(())
    }
}

impl Spots {
    /// The maximum number of spots.
    pub const MAX_COUNT: usize = 10_000;

    /// Checks that number, velocity and lifetime of the laboratory's spots are in range.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] with the field.
    pub fn check(&self) -> Result<()> {
        if self.count == 0 || self.count > Self::MAX_COUNT {
            return Err(InvalidInput::new(
                "spots",
                self.count,
                format!("a cloud has 1 to {} spots", Self::MAX_COUNT),
                "Give a whole number; for a single sharp target choose kind = \"skilled\".",
            ));
        }
        quantity::SPEED.check("spot_velocity", self.velocity)?;
        quantity::LIFETIME.check("spot_lifetime", self.lifetime)?;
        Ok(())
    }
}

impl Target {
    /// Checks that all values of the laboratory's target are in range.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] with a field such as `amplitude[0]`.
    pub fn check(&self) -> Result<()> {
        match self {
            Self::FigureEight { amplitude, angular_frequency } => {
                check_per_axis(quantity::AMPLITUDE, "amplitude", *amplitude)?;
                quantity::ANGULAR_FREQUENCY.check("angular_frequency", *angular_frequency)?;
            }
            Self::Sampled(samples) => {
                if samples.is_empty() {
                    return Err(InvalidInput::new(
                        "target",
                        "no samples",
                        "a sampled target has one position per tick",
                        "Give at least one.",
                    ));
                }
                for (index, position) in samples.iter().enumerate() {
                    if !position.iter().all(|value| value.abs() <= quantity::PLACE.maximum()) {
                        check_per_axis(quantity::PLACE, &format!("target[{index}]"), *position)?;
                    }
                }
            }
        }
        Ok(())
    }
}

impl Controller {
    /// The finest nonzero resolution of a position sensor, m.
    pub const FINEST_RESOLUTION: f64 = 1e-12;

    /// Checks that all values of the laboratory's controller are in range.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] with the field.
    pub fn check(&self) -> Result<()> {
        quantity::SAMPLE_PERIOD.check("sample_period", self.sample_period)?;
        quantity::SPAN.check("actuator_lag", self.actuator_lag)?;
        quantity::RESOLUTION.check("encoder_resolution", self.encoder_resolution)?;
        let resolution = self.encoder_resolution;
        if resolution > 0.0 && resolution < Self::FINEST_RESOLUTION {
            return Err(InvalidInput::new(
                "encoder_resolution",
                format!("{resolution:?}"),
                format!(
                    "an encoder resolution is 0 for none, or {:?} to {:?} m",
                    Self::FINEST_RESOLUTION,
                    quantity::RESOLUTION.maximum()
                ),
                "Write 0 for a sensor without quantisation.",
            ));
        }
        Ok(())
    }
}
