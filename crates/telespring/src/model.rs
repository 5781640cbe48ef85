//! Robots, operators, dyads and delays, with checked values.

use crate::error::{InvalidInput, Result};
use crate::quantity;

/// A robot with independent axes, each a mass with viscous damping.
#[derive(Debug, Clone, PartialEq)]
pub struct Robot {
    axes: Vec<String>,
    mass: Vec<f64>,
    damping: Vec<f64>,
}

/// Default axis names: x, y, z, then axis4, axis5, …
fn default_axes(count: usize) -> Vec<String> {
    ["x", "y", "z"]
        .iter()
        .map(ToString::to_string)
        .chain((4..).map(|i| format!("axis{i}")))
        .take(count)
        .collect()
}

/// Checks that every value in a list of the model is in the range of its quantity.
fn check_each(quantity: quantity::Quantity, field: &str, values: &[f64]) -> Result<()> {
    for (i, &value) in values.iter().enumerate() {
        quantity.check(&format!("{field}[{i}]"), value)?;
    }
    Ok(())
}

/// Checks that a list of the model has one value per axis.
fn check_length(field: &str, got: usize, expected: usize, of: &str) -> Result<()> {
    if got == expected {
        return Ok(());
    }
    Err(InvalidInput::new(
        field,
        format!("{got} value(s)"),
        format!("one value per axis of {of} is required: {expected}"),
        "Give every list one value per axis.",
    ))
}

impl Robot {
    /// Creates a robot from one mass (kg) and one viscous damping (N·s/m) per axis.
    ///
    /// By default the axes are named x, y, z, axis4, ….
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if a list is empty, lengths differ, an axis name is empty or repeated, a mass is
    /// outside 1e-4 to 1e4 kg or a damping outside 0 to 1e6 N·s/m.
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
                    "axis names must be distinct and not empty",
                    "Rename the axis.",
                ));
            }
        }
        Ok(Self { axes, mass, damping })
    }

    /// The names of the robot's axes.
    pub fn axes(&self) -> &[String] {
        &self.axes
    }

    /// The mass of the robot on each axis, kg.
    pub fn mass(&self) -> &[f64] {
        &self.mass
    }

    /// The viscous damping of the robot on each axis, N·s/m.
    pub fn damping(&self) -> &[f64] {
        &self.damping
    }
}

/// What holds a robot's handle (a hand, an arm, another robot): mass, damping and stiffness to ground of
/// each axis. A free handle has all of them zero.
#[derive(Debug, Clone, PartialEq)]
pub struct Operator {
    mass: Vec<f64>,
    damping: Vec<f64>,
    stiffness: Vec<f64>,
}

impl Operator {
    /// Creates an operator from mass (kg), damping (N·s/m) and stiffness (N/m) per axis.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if lengths differ or a value is negative, not finite or out of range.
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

    /// The operator of a free handle with `axes` axes: all values zero.
    pub fn free(axes: usize) -> Self {
        let zero = vec![0.0; axes];
        Self { mass: zero.clone(), damping: zero.clone(), stiffness: zero }
    }

    /// The mass of the operator on each axis, kg.
    pub fn mass(&self) -> &[f64] {
        &self.mass
    }

    /// The damping of the operator on each axis, N·s/m.
    pub fn damping(&self) -> &[f64] {
        &self.damping
    }

    /// The stiffness of the operator to ground on each axis, N/m.
    pub fn stiffness(&self) -> &[f64] {
        &self.stiffness
    }
}

/// Two robots, their operators and the coupling damper.
#[derive(Debug, Clone, PartialEq)]
pub struct Dyad {
    robots: [Robot; 2],
    operators: [Operator; 2],
    coupling_damping: f64,
}

impl Dyad {
    /// Creates a dyad from two robots with the same axes; both handles are free by default.
    ///
    /// `coupling_damping` (N·s/m) acts in parallel with the spring, through the same delay.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if the axes differ or the coupling damping is negative or not finite.
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
                format!("both robots need the same number of axes, and robot1 has {}", robot1.axes.len()),
                "Give both robots one mass and one damping per axis.",
            ));
        }
        if robot1.axes != robot2.axes {
            return Err(InvalidInput::new(
                "robot2.axes",
                format!("{:?}", robot2.axes),
                format!("both robots need the same axes in the same order, here {:?}", robot1.axes),
                "Give both robots the same axis names, or omit them.",
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

    /// The two robots of the dyad.
    pub fn robots(&self) -> &[Robot; 2] {
        &self.robots
    }

    /// The two operators of the dyad.
    pub fn operators(&self) -> &[Operator; 2] {
        &self.operators
    }

    /// The coupling damping of the dyad, in parallel with the spring, N·s/m.
    pub fn coupling_damping(&self) -> f64 {
        self.coupling_damping
    }

    /// The names of the dyad's axes.
    pub fn axis_names(&self) -> &[String] {
        &self.robots[0].axes
    }

    /// All axes, each with the operators' values added to the robots'.
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

    /// One axis, with the operators' values added to the robots'.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if the dyad has no axis with that index.
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

/// One side of an axis: robot and operator together, without the coupling.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Side {
    /// Combined mass of robot and operator, kg.
    pub mass: f64,
    /// Combined viscous damping of robot and operator, N·s/m.
    pub damping: f64,
    /// Stiffness of the operator to ground, N/m; 0 for a free handle.
    pub ground_stiffness: f64,
}

/// One axis of a dyad: the input of every criterion, spectrum and simulation.
///
/// With spring stiffness k, coupling damping c and round-trip delay T, its characteristic function is P₁(s)
/// P₂(s) − (k + c s)² e^(−T s) with Pᵢ(s) = mᵢ s² + (bᵢ + c) s + k + k_h,i.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DyadAxis {
    /// Both sides.
    pub sides: [Side; 2],
    /// Coupling damping, in parallel with the spring, N·s/m.
    pub coupling_damping: f64,
}

impl DyadAxis {
    /// Creates an axis with free handles and no coupling damping from masses (kg) and dampings (N·s/m).
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if a value is out of range.
    pub fn new(m1: f64, b1: f64, m2: f64, b2: f64) -> Result<Self> {
        Self::with_operators(m1, b1, m2, b2, 0.0, 0.0, 0.0)
    }

    /// As [`DyadAxis::new`], with the operators' stiffness (N/m) and a coupling damping (N·s/m).
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if a value is out of range.
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

    /// Checks the public fields, which may have been set without a constructor.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if a value is out of its range. Robot and operator together may have twice the mass and
    /// damping of one.
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

    /// True if neither operator has a stiffness to ground: s = 0 is then a root for every stiffness and
    /// delay, the rigid-body motion of both robots.
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
    /// Creates unequal delays: `forward` from robot 1 to robot 2, `backward` from robot 2 to robot 1.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if a delay is negative, not finite or longer than 100 s.
    pub fn new(forward: f64, backward: f64) -> Result<Self> {
        Ok(Self {
            forward: quantity::DELAY.check("delay.forward", forward)?,
            backward: quantity::DELAY.check("delay.backward", backward)?,
        })
    }

    /// Creates equal delays in both directions.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if the delay is negative, not finite or longer than 100 s.
    pub fn each_way(delay: f64) -> Result<Self> {
        quantity::DELAY.check("delay", delay)?;
        Ok(Self { forward: delay, backward: delay })
    }

    /// The delay from robot 1 to robot 2, s.
    pub fn forward(&self) -> f64 {
        self.forward
    }

    /// The delay from robot 2 to robot 1, s.
    pub fn backward(&self) -> f64 {
        self.backward
    }

    /// The mean one-way delay, s: half the round trip. Under continuous controllers no other delay affects stability.
    pub fn mean(&self) -> f64 {
        0.5 * (self.forward + self.backward)
    }

    /// The round-trip delay, s.
    pub fn round_trip(&self) -> f64 {
        self.forward + self.backward
    }
}

/// The two H-MAN robots of Du, Kulkarni, Kager and Campolo, Table III.
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
