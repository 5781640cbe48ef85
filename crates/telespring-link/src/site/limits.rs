//! What the force and the handle may do at most, for the robot and for the person.

use telespring::InvalidInput;
use telespring::session::Motion;

use super::Interruption;
use super::travel::Travel;

/// The limits of one site. Where robot and person have limits of their own, the tighter one holds ([`Limits::and`]).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// The largest force, N: a larger one is cut along its direction.
    pub force: f64,
    /// The steepest growth of the force, N/s: a steeper one is slowed. The force may fall at once.
    pub rise: f64,
    /// The largest speed of the handle while coupled, m/s: beyond it the force ramps out, and the session pauses.
    pub velocity: f64,
    /// The least and the largest position per axis, m, while coupled: outside the force ramps out, and the session pauses.
    pub workspace: [[f64; 2]; 2],
    /// The share of the force that acts, 0 to 1.
    pub scale: f64,
    /// Axes that are left out of the coupling, at both sites: along them no force acts, and the handles are where they like.
    pub lock: [bool; 2],
}

impl Default for Limits {
    /// 20 N, 1000 N/s, 2 m/s, everywhere, the whole force on both axes.
    fn default() -> Self {
        Self { force: 20.0, rise: 1000.0, velocity: 2.0, ..Self::NONE }
    }
}

impl Limits {
    /// No limit but that of the numbers themselves.
    pub const NONE: Self = Self {
        force: 1000.0,
        rise: 1e6,
        velocity: 100.0,
        workspace: [[f64::NEG_INFINITY, f64::INFINITY]; 2],
        scale: 1.0,
        lock: [false; 2],
    };

    /// The tighter of both, each for itself.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            force: self.force.min(other.force),
            rise: self.rise.min(other.rise),
            velocity: self.velocity.min(other.velocity),
            workspace: [0, 1].map(|axis| {
                let ([low, high], [least, most]) = (self.workspace[axis], other.workspace[axis]);
                [low.max(least), high.min(most)]
            }),
            scale: self.scale.min(other.scale),
            lock: [0, 1].map(|axis| self.lock[axis] || other.lock[axis]),
        }
    }

    /// Checks the values.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] with the field.
    pub fn check(&self) -> Result<(), InvalidInput> {
        let Self { force, rise, velocity, workspace, scale, .. } = *self;
        if !(force > 0.0 && force <= 1000.0) {
            let remedy = "Give the largest force that the person and the robot bear.";
            return Err(InvalidInput::new("limits.force", force, "a force above 0 N, up to 1000 N", remedy));
        }
        if !(rise > 0.0 && rise <= 1e6) {
            let remedy = "Give 1000: the usual largest force is then reached in 20 ms at the earliest.";
            return Err(InvalidInput::new("limits.rise", rise, "above 0, up to 1000000 N/s", remedy));
        }
        if !(velocity > 0.0 && velocity <= 100.0) {
            let remedy = "Give the largest speed at which a person may be coupled, for instance 1.";
            return Err(InvalidInput::new("limits.velocity", velocity, "above 0, up to 100 m/s", remedy));
        }
        if !(0.0..=1.0).contains(&scale) {
            let remedy = "Give 1 for the whole force, 0.5 for half of it.";
            return Err(InvalidInput::new("limits.scale", scale, "a share from 0 to 1", remedy));
        }
        if workspace.iter().any(|[least, most]| !(least < most)) {
            let value = format!("{workspace:?}");
            let remedy = "Write [least, most] for x and for y, robot and person together.";
            return Err(InvalidInput::new("limits.workspace", value, "a box with room in it", remedy));
        }
        Ok(())
    }

    /// Whether a handle is inside the workspace.
    pub(super) fn holds(&self, position: [f64; 2]) -> bool {
        position.iter().zip(self.workspace).all(|(value, [least, most])| (least..=most).contains(value))
    }

    /// The limit of the handle that this motion breaks; `travel` is what its positions show. What is not a number is
    /// for the endpoint to refuse.
    pub(super) fn broken(&self, motion: &Motion, travel: &Travel) -> Option<Interruption> {
        let [x, y] = motion.position;
        let [u, v] = motion.velocity;
        if x.is_finite() && y.is_finite() && !self.holds(motion.position) {
            Some(Interruption::Workspace)
        } else if travel.speed(motion.velocity, [false; 2]).unwrap_or(u.hypot(v)) > self.velocity {
            Some(Interruption::Velocity)
        } else {
            None
        }
    }
}
