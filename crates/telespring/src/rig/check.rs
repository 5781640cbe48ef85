//! The values of a laboratory, checked once at the door.

use super::{Agent, Arm, Controller, Handle, Laboratory, NetworkImpairments, Spots, Station, Target};
use crate::error::{InvalidInput, Result};
use crate::quantity::{self, Quantity};

fn pair(quantity: Quantity, field: &str, values: [f64; 2]) -> Result<()> {
    for (index, value) in values.into_iter().enumerate() {
        quantity.check(&format!("{field}[{index}]"), value)?;
    }
    Ok(())
}

impl Laboratory {
    /// The paper's: both H-MANs of Table III without Coulomb friction, ideal massless arms, the skilled
    /// agent of Eq. 13 and the less-skilled one of Eq. 14 with ten spots, the figure eight of Eq. 12,
    /// controllers at 1 kHz, and a network that does nothing beside its delay.
    ///
    /// A spot lives 0.2 s: by then the typical spot is 0.06 m off, about the size of the figure; a cloud
    /// much wider would not blur the target but hide it. The paper gives no lifetime.
    pub fn paper() -> Self {
        let dyad = crate::model::hman();
        let side = |index: usize, agent| {
            let robot = &dyad.robots()[index];
            let per_axis = |values: &[f64]| [values[0], values[1]];
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
        Self {
            stations: [
                side(0, Agent::Skilled { stiffness: 120.0, damping: 0.0 }),
                side(1, Agent::Blurred { stiffness: 120.0, spots }),
            ],
            target: Target::FigureEight { amplitude: [0.05, 0.1], angular_frequency: 2.59 },
            controller: Controller {
                sample_period: 1e-3,
                computing_tick: false,
                actuator_lag: 0.0,
                encoder_resolution: 0.0,
            },
            network: NetworkImpairments { jitter: 0.0, loss: 0.0 },
        }
    }

    /// Refuses the first value that is out of range, under the name it has in a study file, such as
    /// `arm1.link_length[0]`.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`].
    ///
    /// # Examples
    ///
    /// ```
    /// let mut laboratory = telespring::rig::Laboratory::paper();
    /// laboratory.check()?;
    /// laboratory.network.loss = 1.5;
    /// assert_eq!(laboratory.check().unwrap_err().field, "laboratory.loss");
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
        self.network.check().map_err(|refusal| refusal.within("laboratory"))?;
        let period = self.controller.sample_period;
        for (index, side) in self.stations.iter().enumerate() {
            if let Agent::Blurred { spots, .. } = side.agent
                && spots.lifetime < period
            {
                return Err(InvalidInput::new(
                    format!("agent{}.spot_lifetime", index + 1),
                    spots.lifetime,
                    format!("a spot lives for one sample period at least, here {period} s"),
                    "Give a lifetime in s, such as 0.2.",
                ));
            }
        }
        Ok(())
    }
}

impl Handle {
    /// Refuses what is out of range.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] with a field such as `coulomb[1]`.
    pub fn check(&self) -> Result<()> {
        pair(quantity::MASS, "mass", self.mass)?;
        pair(quantity::DAMPING, "damping", self.damping)?;
        pair(quantity::COULOMB, "coulomb", self.coulomb)
    }
}

impl Arm {
    /// Refuses what is out of range.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] with a field such as `mass[0]`.
    pub fn check(&self) -> Result<()> {
        match self {
            Self::Lumped { mass, damping } => {
                pair(quantity::ADDED_MASS, "mass", *mass)?;
                pair(quantity::DAMPING, "damping", *damping)
            }
            Self::TwoLink(arm) => arm.checked().map(|_| ()),
        }
    }
}

impl Agent {
    /// Refuses what is out of range.
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
    /// The most spots.
    pub const MAX_COUNT: usize = 10_000;

    /// Refuses what is out of range.
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
                "Give a whole number; for a single target that is not blurred choose kind = \"skilled\".",
            ));
        }
        quantity::SPEED.check("spot_velocity", self.velocity)?;
        quantity::LIFETIME.check("spot_lifetime", self.lifetime)?;
        Ok(())
    }
}

impl Target {
    /// Refuses what is out of range.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] with a field such as `amplitude[0]`.
    pub fn check(&self) -> Result<()> {
        match self {
            Self::FigureEight { amplitude, angular_frequency } => {
                pair(quantity::AMPLITUDE, "amplitude", *amplitude)?;
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
                        pair(quantity::PLACE, &format!("target[{index}]"), *position)?;
                    }
                }
            }
        }
        Ok(())
    }
}

impl Controller {
    /// The smallest step of a position sensor that is not none, m.
    pub const FINEST_RESOLUTION: f64 = 1e-12;

    /// Refuses what is out of range.
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
                "Write 0 for a sensor without steps.",
            ));
        }
        Ok(())
    }
}

impl NetworkImpairments {
    /// Refuses what is out of range.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] with the field.
    pub fn check(&self) -> Result<()> {
        quantity::SPAN.check("jitter", self.jitter)?;
        quantity::PROBABILITY.check("loss", self.loss)?;
        Ok(())
    }
}
