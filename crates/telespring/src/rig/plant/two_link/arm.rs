//! The two-link arm: checks, an example, and its apparent mass and damping at the handle.

use super::OutOfReach;
use super::dynamics::ArmDynamics;
use super::kinematics::Pose;
use crate::error::Result;
use crate::quantity;
use crate::rig::{Elbow, Handle, TwoLinkArm};

impl TwoLinkArm {
    /// Two links of HEBI X-series parts, 0.45 m behind the middle of the task. This is an assumed stand-in:
    /// the paper gives neither lengths nor inertias of its arms.
    ///
    /// | what | from |
    /// |---|---|
    /// | links of 0.325 m | the X-series arm kits of HEBI Robotics' `hebi-hrdf` |
    /// | tube: 0.402 kg, its centre in the middle, a thin rod's inertia | `link.xacro` of their `hebi_description`: 0.4 (length + 0.03) + 0.26 kg |
    /// | elbow actuator X8-9: 0.480 kg, 0.463 g·m², 20 N·m, damping 0.5 N·m·s/rad | `actuator.xacro` there; it hangs at the end of the upper link and is counted with it |
    /// | rotor inertia 0.01 kg·m² | assumed: what the series-elastic torque loop leaves of it is not published |
    /// | shoulder at (0, −0.45) m, elbow on the right | assumed; the figure of eight then stays 0.1 m or more inside the reach |
    ///
    /// `actuator.xacro` itself calls its damping untuned, and 20 N·m exceeds the continuous torque: replace
    /// both by identified values.
    pub const HEBI_X8: Self = Self {
        base: [0.0, -0.45],
        elbow: Elbow::Right,
        link_length: [0.325, 0.325],
        link_mass: [0.882, 0.402],
        link_centre: [0.2509, 0.1625],
        link_inertia: [0.00986, 0.00362],
        joint_damping: [0.5, 0.5],
        rotor_inertia: [0.01, 0.01],
        torque_limit: [20.0, 20.0],
    };

    /// The same two-link arm if every value is in range.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`](crate::InvalidInput) for the first value out of range.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::rig::TwoLinkArm;
    /// let arm = TwoLinkArm { link_mass: [-1.0, 0.4], ..TwoLinkArm::HEBI_X8 };
    /// assert_eq!(arm.checked().unwrap_err().field, "link_mass[0]");
    /// ```
    pub fn checked(self) -> Result<Self> {
        let pairs = [
            ("base", quantity::PLACE, self.base),
            ("link_length", quantity::LENGTH, self.link_length),
            ("link_mass", quantity::LINK_MASS, self.link_mass),
            ("link_centre", quantity::OFFSET, self.link_centre),
            ("link_inertia", quantity::INERTIA, self.link_inertia),
            ("joint_damping", quantity::JOINT_DAMPING, self.joint_damping),
            ("rotor_inertia", quantity::INERTIA, self.rotor_inertia),
            ("torque_limit", quantity::TORQUE, self.torque_limit),
        ];
        for (field, quantity, pair) in pairs {
            for (index, value) in pair.into_iter().enumerate() {
                quantity.check(&format!("{field}[{index}]"), value)?;
            }
        }
        Ok(self)
    }

    /// The apparent mass matrix (kg) and damping matrix (N·s/m) of the arm at the handle, in the pose that
    /// holds it at `position` (m): J⁻ᵀ M J⁻¹ and J⁻ᵀ D J⁻¹, symmetric, in the axes x and y.
    ///
    /// # Errors
    ///
    /// [`OutOfReach`] if no pose, or only one too close to straight or folded, holds it there.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::rig::TwoLinkArm;
    /// let (mass, damping) = TwoLinkArm::HEBI_X8.operator_at([0.0, 0.0]).unwrap();
    /// assert_eq!(mass[0][1], mass[1][0]);
    /// assert!(mass[0][0] > 0.0 && damping[1][1] > 0.0);
    /// assert!(TwoLinkArm::HEBI_X8.operator_at([0.0, 0.2]).is_err());
    /// ```
    #[expect(clippy::type_complexity, reason = "two matrices")]
    pub fn operator_at(
        &self,
        position: [f64; 2],
    ) -> std::result::Result<([[f64; 2]; 2], [[f64; 2]; 2]), OutOfReach> {
        let none = Handle { mass: [0.0; 2], damping: [0.0; 2], coulomb: [0.0; 2] };
        let (mass, damping) = ArmDynamics::new(none, *self).operator(&Pose::at(self, position)?);
        Ok((mass.rows(), damping.rows()))
    }

    /// The angles of shoulder and elbow, rad, that hold the handle at `position`, m.
    ///
    /// # Errors
    ///
    /// [`OutOfReach`] as in [`TwoLinkArm::operator_at`].
    pub fn joint_angles_at(&self, position: [f64; 2]) -> std::result::Result<[f64; 2], OutOfReach> {
        Ok(Pose::at(self, position)?.joint_angles())
    }
}
