//! Stability of a dyad held by two-link arms, one frozen pose at a time.
//!
//! A two-link arm adds to its handle a mass and a damping that couple x and y and change with the
//! pose. With both handles at rest in one place the dyad is a linear system of eight states; the effect of
//! moving from pose to pose is not included.

use nalgebra::{DMatrix, Matrix2};

use crate::delay_system::DelaySystem;
use crate::error::{InvalidInput, Result};
use crate::model::{Delay, Dyad, DyadAxis, Side};
use crate::quantity;
use crate::rig::Arm;
use crate::spectrum::spectral_abscissa;

/// Stability of one pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseStability {
    /// The largest real part of the characteristic roots other than s = 0, 1/s.
    pub spectral_abscissa: f64,
    /// The same with everything that couples x and y left out, 1/s.
    pub uncoupled_abscissa: f64,
    /// Whether the argument principle confirms for both that no root was missed.
    pub is_complete: bool,
}

/// One side with its handle in one place: robot, operator, arm and agent together, over x and y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrozenSide {
    /// Mass, kg.
    pub mass: Matrix2<f64>,
    /// Viscous damping, N·s/m.
    pub damping: Matrix2<f64>,
    /// Stiffness to the ground, N/m per axis.
    pub ground_stiffness: [f64; 2],
}

impl FrozenSide {
    /// |m_xy| over the geometric mean of m_xx and m_yy, in a frozen pose.
    pub fn cross_inertia(&self) -> f64 {
        self.mass[(0, 1)].abs() / (self.mass[(0, 0)] * self.mass[(1, 1)]).sqrt()
    }

    /// Whether x and y are independent on this side of a frozen pose.
    fn is_diagonal(&self) -> bool {
        [self.mass, self.damping].iter().all(|matrix| matrix[(0, 1)] == 0.0 && matrix[(1, 0)] == 0.0)
    }

    /// One axis of a frozen pose without what couples it to the other.
    fn on_axis(&self, axis: usize) -> Side {
        Side {
            mass: self.mass[(axis, axis)],
            damping: self.damping[(axis, axis)],
            ground_stiffness: self.ground_stiffness[axis],
        }
    }
}

/// A dyad of two axes whose handles are held by arms and agents.
///
/// # Examples
///
/// ```
/// use telespring::poses::DyadInArms;
/// use telespring::rig::{Arm, TwoLinkArm};
/// use telespring::{Delay, hman};
/// let arm = Arm::TwoLink(TwoLinkArm::HEBI_X8);
/// let held = DyadInArms::new(&hman(), [arm; 2], [120.0; 2])?;
/// let sides = held.sides_at([0.0, 0.05])?;
/// let pose = held.stability(&sides, 71.2, &Delay::each_way(0.1)?)?;
/// assert!(pose.is_complete);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct DyadInArms {
    sides: [FrozenSide; 2],
    arms: [Arm; 2],
    coupling_damping: f64,
}

impl DyadInArms {
    /// A dyad, the arm in each robot's handle, and the stiffness of each agent's spring, N/m.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if the robots have not two axes or a stiffness is out of its range.
    pub fn new(dyad: &Dyad, arms: [Arm; 2], agent_stiffness: [f64; 2]) -> Result<Self> {
        let names = dyad.axis_names();
        if names.len() != 2 {
            return Err(InvalidInput::new(
                "robot1",
                format!("axes {names:?}"),
                "an arm holds a robot of two axes, x and y",
                "Give both robots two masses and two dampings.",
            ));
        }
        for (index, stiffness) in agent_stiffness.into_iter().enumerate() {
            quantity::GROUND_STIFFNESS.check(&format!("agent_stiffness[{index}]"), stiffness)?;
        }
        let axes = [dyad.axis(0)?, dyad.axis(1)?];
        let sides = [0, 1].map(|side| {
            let [x, y] = [0, 1].map(|axis: usize| axes[axis].sides[side]);
            FrozenSide {
                mass: Matrix2::new(x.mass, 0.0, 0.0, y.mass),
                damping: Matrix2::new(x.damping, 0.0, 0.0, y.damping),
                ground_stiffness: [x, y].map(|axis| axis.ground_stiffness + agent_stiffness[side]),
            }
        });
        Ok(Self { sides, arms, coupling_damping: dyad.coupling_damping() })
    }

    /// Both sides of the frozen pose with their handles at `position`, m.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] with the field `position` where an arm cannot reach it.
    pub fn sides_at(&self, position: [f64; 2]) -> Result<[FrozenSide; 2]> {
        let mut sides = self.sides;
        for (side, arm) in sides.iter_mut().zip(&self.arms) {
            let (mass, damping) = match arm {
                Arm::Lumped { mass, damping } => (diagonal(*mass), diagonal(*damping)),
                Arm::TwoLink(arm) => arm.operator_at(position).map_err(|outside| {
                    InvalidInput::new(
                        "position",
                        format!("{position:?}"),
                        outside.to_string(),
                        "Choose positions within reach, or move the arm's base.",
                    )
                })?,
            };
            side.mass += Matrix2::from_fn(|i, j| mass[i][j]);
            side.damping += Matrix2::from_fn(|i, j| damping[i][j]);
        }
        Ok(sides)
    }

    /// One frozen pose as a linear system with delays.
    ///
    /// The states are x, y, x′, y′ of robot 1, counted from the pose, then those of robot 2.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if the stiffness, N/m, is out of its range.
    pub fn system(&self, sides: &[FrozenSide; 2], stiffness: f64, delay: &Delay) -> Result<DelaySystem> {
        quantity::STIFFNESS.check("stiffness", stiffness)?;
        let mut a0 = DMatrix::zeros(8, 8);
        let mut terms = Vec::with_capacity(2);
        for (own, partner, lag) in [(0, 4, delay.backward()), (4, 0, delay.forward())] {
            let side = &sides[own / 4];
            let inverse = side.mass.try_inverse().expect("a mass matrix is positive definite");
            let [kx, ky] = side.ground_stiffness.map(|ground| ground + stiffness);
            let pull = -inverse * Matrix2::new(kx, 0.0, 0.0, ky);
            let drag = -inverse * (side.damping + Matrix2::identity() * self.coupling_damping);
            let mut late = DMatrix::zeros(8, 8);
            for i in 0..2 {
                a0[(own + i, own + 2 + i)] = 1.0;
                for j in 0..2 {
                    a0[(own + 2 + i, own + j)] = pull[(i, j)];
                    a0[(own + 2 + i, own + 2 + j)] = drag[(i, j)];
                    late[(own + 2 + i, partner + j)] = inverse[(i, j)] * stiffness;
                    late[(own + 2 + i, partner + 2 + j)] = inverse[(i, j)] * self.coupling_damping;
                }
            }
            terms.push((lag, late));
        }
        DelaySystem::new(a0, terms)
    }

    /// How stable one frozen pose is, and how stable it would be with x and y independent.
    ///
    /// # Errors
    ///
    /// As [`DyadInArms::system`].
    pub fn stability(&self, sides: &[FrozenSide; 2], stiffness: f64, delay: &Delay) -> Result<PoseStability> {
        let mut apart = PoseStability {
            spectral_abscissa: f64::NEG_INFINITY,
            uncoupled_abscissa: f64::NEG_INFINITY,
            is_complete: true,
        };
        for axis in 0..2 {
            let both = sides.map(|side| side.on_axis(axis));
            let axis = DyadAxis { sides: both, coupling_damping: self.coupling_damping };
            let abscissa = spectral_abscissa(&axis, stiffness, delay)?;
            apart.uncoupled_abscissa = apart.uncoupled_abscissa.max(abscissa.value);
            apart.is_complete &= abscissa.certificate.is_complete();
        }
        if sides.iter().all(FrozenSide::is_diagonal) {
            return Ok(PoseStability { spectral_abscissa: apart.uncoupled_abscissa, ..apart });
        }
        let coupled = self.system(sides, stiffness, delay)?.spectral_abscissa_without_zero();
        Ok(PoseStability {
            spectral_abscissa: coupled.value,
            is_complete: apart.is_complete && coupled.certificate.is_complete(),
            ..apart
        })
    }
}

/// A diagonal matrix of x and y for a frozen pose.
fn diagonal([x, y]: [f64; 2]) -> [[f64; 2]; 2] {
    [[x, 0.0], [0.0, y]]
}
