//! Robots, the operators who hold them, and the two of them as a dyad; validated once, here.

use crate::error::{InvalidInput, Result};
use crate::quantity;

/// A robot with independent axes, each a mass with viscous damping.
#[derive(Debug, Clone, PartialEq)]
pub struct Robot {
    axes: Vec<String>,
    mass: Vec<f64>,
    damping: Vec<f64>,
}

/// Names for axes that were given none: x, y, z, then axis4, axis5, …
fn default_axes(count: usize) -> Vec<String> {
    ["x", "y", "z"]
        .iter()
        .map(ToString::to_string)
        .chain((4..).map(|i| format!("axis{i}")))
        .take(count)
        .collect()
}

fn check_each(quantity: quantity::Quantity, field: &str, values: &[f64]) -> Result<()> {
    for (i, &value) in values.iter().enumerate() {
        quantity.check(&format!("{field}[{i}]"), value)?;
    }
    Ok(())
}

fn check_length(field: &str, got: usize, expected: usize, of: &str) -> Result<()> {
    if got == expected {
        return Ok(());
    }
    Err(InvalidInput::new(
        field,
        format!("{got} value(s)"),
        format!("one value per axis of {of} is needed, that is {expected}"),
        "Give every list one value per axis.",
    ))
}

impl Robot {
    /// A robot from one mass (kg) and one viscous damping (N·s/m) per axis.
    ///
    /// Without `axes` they are named x, y, z, axis4, ….
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] where a list is empty, lengths differ, an axis name repeats or is empty, a
    /// mass is not in 1e-4 to 1e4 kg or a damping not in 0 to 1e6 N·s/m.
    ///
    /// # Examples
    ///
    /// ```
    /// let robot = telespring::Robot::new(vec![0.8334, 1.0649], vec![7.7257, 10.1168], None)?;
    /// assert_eq!(robot.axes(), ["x", "y"]);
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn new(mass: Vec<f64>, damping: Vec<f64>, axes: Option<Vec<String>>) -> Result<Self> {
        if mass.is_empty() {
            return Err(InvalidInput::new(
                "mass",
                "[]",
                "a robot has at least one axis",
                "Give one mass per axis.",
            ));
        }
        check_each(quantity::MASS, "mass", &mass)?;
        check_length("damping", damping.len(), mass.len(), "the mass")?;
        check_each(quantity::DAMPING, "damping", &damping)?;
        let axes = axes.unwrap_or_else(|| default_axes(mass.len()));
        check_length("axes", axes.len(), mass.len(), "the mass")?;
        for (i, name) in axes.iter().enumerate() {
            if name.is_empty() || axes[..i].contains(name) {
                return Err(InvalidInput::new(
                    format!("axes[{i}]"),
                    format!("{name:?}"),
                    "every axis needs a name of its own",
                    "Rename the axis.",
                ));
            }
        }
        Ok(Self { axes, mass, damping })
    }

    /// The axes' names.
    pub fn axes(&self) -> &[String] {
        &self.axes
    }

    /// One mass per axis, kg.
    pub fn mass(&self) -> &[f64] {
        &self.mass
    }

    /// One viscous damping per axis, N·s/m.
    pub fn damping(&self) -> &[f64] {
        &self.damping
    }
}

/// What holds a robot's handle (a hand, an arm, another robot): mass, damping and a stiffness to
/// the ground, one of each per axis. All zero is a free handle.
#[derive(Debug, Clone, PartialEq)]
pub struct Operator {
    mass: Vec<f64>,
    damping: Vec<f64>,
    stiffness: Vec<f64>,
}

impl Operator {
    /// An operator from one mass (kg), damping (N·s/m) and stiffness (N/m) per axis.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] where lengths differ or a value is negative, not finite or out of range.
    ///
    /// # Examples
    ///
    /// ```
    /// let arm = telespring::Operator::new(vec![0.0; 2], vec![0.0; 2], vec![120.0; 2])?;
    /// assert_eq!(arm.stiffness(), [120.0, 120.0]);
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn new(mass: Vec<f64>, damping: Vec<f64>, stiffness: Vec<f64>) -> Result<Self> {
        check_each(quantity::ADDED_MASS, "mass", &mass)?;
        check_length("damping", damping.len(), mass.len(), "the operator's mass")?;
        check_each(quantity::DAMPING, "damping", &damping)?;
        check_length("stiffness", stiffness.len(), mass.len(), "the operator's mass")?;
        check_each(quantity::GROUND_STIFFNESS, "stiffness", &stiffness)?;
        Ok(Self { mass, damping, stiffness })
    }

    /// A free handle on `axes` axes.
    pub fn free(axes: usize) -> Self {
        let zero = vec![0.0; axes];
        Self { mass: zero.clone(), damping: zero.clone(), stiffness: zero }
    }

    /// One mass per axis, kg.
    pub fn mass(&self) -> &[f64] {
        &self.mass
    }

    /// One damping per axis, N·s/m.
    pub fn damping(&self) -> &[f64] {
        &self.damping
    }

    /// One stiffness to the ground per axis, N/m.
    pub fn stiffness(&self) -> &[f64] {
        &self.stiffness
    }
}

/// Two robots, what holds them, and the damper beside the virtual spring.
#[derive(Debug, Clone, PartialEq)]
pub struct Dyad {
    robots: [Robot; 2],
    operators: [Operator; 2],
    coupling_damping: f64,
}

impl Dyad {
    /// Two robots with the same axes; without `operators` both handles are free.
    ///
    /// `coupling_damping` (N·s/m) acts beside the spring, through the same delay.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] where axes do not match or the coupling damping is negative or not finite.
    pub fn new(
        robot1: Robot,
        robot2: Robot,
        operators: Option<[Operator; 2]>,
        coupling_damping: f64,
    ) -> Result<Self> {
        if robot1.axes.len() != robot2.axes.len() {
            return Err(InvalidInput::new(
                "robot2.axes",
                format!("{} axes", robot2.axes.len()),
                format!("both robots need as many axes, and robot1 has {}", robot1.axes.len()),
                "Give both robots one mass and one damping per axis.",
            ));
        }
        if robot1.axes != robot2.axes {
            return Err(InvalidInput::new(
                "robot2.axes",
                format!("{:?}", robot2.axes),
                format!("both robots need the same axes in the same order, here {:?}", robot1.axes),
                "Name the axes alike, or leave the names away.",
            ));
        }
        let axes = robot1.axes.len();
        let operators = operators.unwrap_or_else(|| [Operator::free(axes), Operator::free(axes)]);
        for (operator, name) in operators.iter().zip(["operator1", "operator2"]) {
            check_length(name, operator.mass.len(), axes, "the robots")?;
        }
        quantity::DAMPING.check("coupling_damping", coupling_damping)?;
        Ok(Self { robots: [robot1, robot2], operators, coupling_damping })
    }

    /// The two robots.
    pub fn robots(&self) -> &[Robot; 2] {
        &self.robots
    }

    /// The two operators.
    pub fn operators(&self) -> &[Operator; 2] {
        &self.operators
    }

    /// The damper beside the spring, N·s/m.
    pub fn coupling_damping(&self) -> f64 {
        self.coupling_damping
    }

    /// The axes' names.
    pub fn axis_names(&self) -> &[String] {
        &self.robots[0].axes
    }

    /// Every axis, operators added to the robots.
    pub fn axes(&self) -> impl Iterator<Item = DyadAxis> + '_ {
        (0..self.axis_names().len()).map(|axis| DyadAxis {
            sides: [0, 1].map(|i| Side {
                mass: self.robots[i].mass[axis] + self.operators[i].mass[axis],
                damping: self.robots[i].damping[axis] + self.operators[i].damping[axis],
                ground_stiffness: self.operators[i].stiffness[axis],
            }),
            coupling_damping: self.coupling_damping,
        })
    }

    /// One axis, operators added to the robots.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] where the dyad has no axis of that index.
    pub fn axis(&self, axis: usize) -> Result<DyadAxis> {
        self.axes().nth(axis).ok_or_else(|| {
            InvalidInput::new(
                "axis",
                axis,
                format!("this dyad has the axes {:?}, counted from 0", self.axis_names()),
                "Choose one of them.",
            )
        })
    }
}

/// One side of one axis: robot and operator together, without the coupling.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Side {
    /// Mass of robot and operator, kg.
    pub mass: f64,
    /// Viscous damping of robot and operator, N·s/m.
    pub damping: f64,
    /// Stiffness of the operator to the ground, N/m; 0 for a free handle.
    pub ground_stiffness: f64,
}

/// One axis of a dyad: what every criterion, spectrum and simulation works on.
///
/// With k the stiffness of the spring, c the coupling damping and T the sum of both one-way delays,
/// its characteristic function is P₁(s) P₂(s) − (k + c s)² e^(−T s) with
/// Pᵢ(s) = mᵢ s² + (bᵢ + c) s + k + k_h,i.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DyadAxis {
    /// Both sides.
    pub sides: [Side; 2],
    /// The damper beside the spring, N·s/m.
    pub coupling_damping: f64,
}

impl DyadAxis {
    /// One axis from two masses (kg) and dampings (N·s/m), free handles and no coupling damping.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] where a value is out of its range.
    pub fn new(m1: f64, b1: f64, m2: f64, b2: f64) -> Result<Self> {
        Self::with_operators(m1, b1, m2, b2, 0.0, 0.0, 0.0)
    }

    /// As [`DyadAxis::new`], with both operators' stiffness (N/m) and a coupling damping (N·s/m).
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] where a value is out of its range.
    #[inline]
    pub fn with_operators(m1: f64, b1: f64, m2: f64, b2: f64, kh1: f64, kh2: f64, c: f64) -> Result<Self> {
        Ok(Self {
            sides: [
                Side {
                    mass: quantity::MASS.check("m1", m1)?,
                    damping: quantity::DAMPING.check("b1", b1)?,
                    ground_stiffness: quantity::GROUND_STIFFNESS.check("kh1", kh1)?,
                },
                Side {
                    mass: quantity::MASS.check("m2", m2)?,
                    damping: quantity::DAMPING.check("b2", b2)?,
                    ground_stiffness: quantity::GROUND_STIFFNESS.check("kh2", kh2)?,
                },
            ],
            coupling_damping: quantity::DAMPING.check("c", c)?,
        })
    }

    /// Refuses values that only fields filled in by hand can hold.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] where a value is out of its range; robot and operator together may have twice the mass
    /// and damping of one.
    pub fn check(&self) -> Result<()> {
        for (side, [mass, damping, ground]) in
            self.sides.iter().zip([["m1", "b1", "kh1"], ["m2", "b2", "kh2"]])
        {
            quantity::SIDE_MASS.check(mass, side.mass)?;
            quantity::SIDE_DAMPING.check(damping, side.damping)?;
            quantity::GROUND_STIFFNESS.check(ground, side.ground_stiffness)?;
        }
        quantity::DAMPING.check("c", self.coupling_damping)?;
        Ok(())
    }

    /// True where neither operator holds its handle to the ground: s = 0 is then a root for every
    /// stiffness and delay (both robots carried off together).
    pub fn is_free(&self) -> bool {
        self.sides.iter().all(|side| side.ground_stiffness == 0.0)
    }
}

/// The one-way delays of both directions, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Delay {
    forward: f64,
    backward: f64,
}

impl Delay {
    /// Unequal delays: `forward` from robot 1 to robot 2, `backward` from robot 2 to robot 1.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] where a delay is negative, not finite or longer than 100 s.
    pub fn new(forward: f64, backward: f64) -> Result<Self> {
        Ok(Self {
            forward: quantity::DELAY.check("delay.forward", forward)?,
            backward: quantity::DELAY.check("delay.backward", backward)?,
        })
    }

    /// The same delay each way.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] where the delay is negative, not finite or longer than 100 s.
    pub fn each_way(delay: f64) -> Result<Self> {
        quantity::DELAY.check("delay", delay)?;
        Ok(Self { forward: delay, backward: delay })
    }

    /// From robot 1 to robot 2, s.
    pub fn forward(&self) -> f64 {
        self.forward
    }

    /// From robot 2 to robot 1, s.
    pub fn backward(&self) -> f64 {
        self.backward
    }

    /// Half of the round trip, s: all that stability depends on.
    pub fn mean(&self) -> f64 {
        0.5 * (self.forward + self.backward)
    }

    /// The round trip, s.
    pub fn round_trip(&self) -> f64 {
        self.forward + self.backward
    }
}

/// The two H-MANs of Du, Kulkarni, Kager and Campolo, Table III, as H-MAN₁ and H-MAN₂.
///
/// # Examples
///
/// ```
/// let dyad = telespring::hman();
/// assert_eq!(dyad.axis_names(), ["x", "y"]);
/// ```
pub fn hman() -> Dyad {
    let robot = |mass, damping| Robot::new(mass, damping, None).expect("published values are valid");
    Dyad::new(
        robot(vec![0.8334, 1.0649], vec![7.7257, 10.1168]),
        robot(vec![0.7776, 1.3407], vec![7.4208, 9.3496]),
        None,
        0.0,
    )
    .expect("published robots share their axes")
}
