//! One robot in one arm under given forces, and the mass and damping that its handle feels of the arm.

use numpy::{IntoPyArray, Ix2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyMapping;
use telespring::InvalidInput;
use telespring::quantity::{FORCE, PLACE, Quantity, SAMPLE_PERIOD, VELOCITY};
use telespring::rig::plant::{Halt, Plant};
use telespring::rig::{self, Handle};

use crate::arguments::{Argument, Number, rows, written};
use crate::errors::Outcome;
use crate::interrupt::apart;
use crate::participants::Arm;
use crate::recording::HandleMotion;
use crate::records::Array;
use crate::study_values::to_table;

/// The handle to simulate, from a mapping of the keys that a robot has in a study file.
fn handle_of(value: &Bound<'_, PyAny>) -> Outcome<Handle> {
    let Ok(keys) = value.cast::<PyMapping>() else {
        let allowed = "a mapping with mass and damping, and possibly coulomb, is required";
        return Err(InvalidInput::new("handle", written(value), allowed, "Pass a dict.").into());
    };
    Ok(Handle::from_table(&to_table("handle", keys)?)?)
}

/// The arm to simulate: an `Arm`, or a mapping of the keys that it has in a study file.
pub fn arm_of(value: &Bound<'_, PyAny>) -> Outcome<rig::Arm> {
    if let Ok(arm) = value.cast::<Arm>() {
        return Ok(arm.get().0);
    }
    let Ok(keys) = value.cast::<PyMapping>() else {
        let allowed = "an Arm, or a mapping of its keys, is required";
        return Err(InvalidInput::new("arm", written(value), allowed, "Pass an Arm.").into());
    };
    Ok(rig::Arm::from_table(&to_table("arm", keys)?)?)
}

/// Rows (x, y) of forces on the plant, N, each in its range.
fn forces(name: &str, value: &Bound<'_, PyAny>) -> Outcome<Vec<[f64; 2]>> {
    let forces = rows(name, value)?;
    for (tick, force) in forces.iter().enumerate() {
        for (axis, value) in force.iter().enumerate() {
            FORCE.check("", *value).map_err(|mut refusal| {
                refusal.field = format!("{name}[{tick}, {axis}]");
                refusal
            })?;
        }
    }
    Ok(forces)
}

/// Two numbers of the plant, each in its range.
fn pair(name: &str, given: Argument<[f64; 2]>, quantity: Quantity) -> Outcome<[f64; 2]> {
    let values = given.named(name)?;
    for (axis, value) in values.into_iter().enumerate() {
        quantity.check(&format!("{name}[{axis}]"), value)?;
    }
    Ok(values)
}

/// Two columns of the plant's recorded motion as an array.
fn columns(py: Python<'_>, values: Vec<[f64; 2]>) -> PyResult<Array<f64, Ix2>> {
    let shape = [values.len(), 2];
    Ok(values.into_flattened().into_pyarray(py).reshape(shape)?.into())
}

/// The signals of one simulated motion.
#[derive(Default)]
struct Record {
    position: Vec<[f64; 2]>,
    velocity: Vec<[f64; 2]>,
    handle_force: Vec<[f64; 2]>,
    torque: Vec<[f64; 2]>,
    halt: Option<Halt>,
}

/// Simulates one robot in an arm under forces held over each sample period.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "tests name them")]
#[pyo3(signature = (handle, arm, hand_force, robot_force, sample_period, position0, velocity0=Argument::Given([0.0, 0.0])))]
pub fn simulate_handle(
    py: Python<'_>,
    handle: &Bound<'_, PyAny>,
    arm: &Bound<'_, PyAny>,
    hand_force: &Bound<'_, PyAny>,
    robot_force: &Bound<'_, PyAny>,
    sample_period: Number,
    position0: Argument<[f64; 2]>,
    velocity0: Argument<[f64; 2]>,
) -> Outcome<HandleMotion> {
    let (handle, arm) = (handle_of(handle)?, arm_of(arm)?);
    let (hand, robot) = (forces("hand_force", hand_force)?, forces("robot_force", robot_force)?);
    let position0 = pair("position0", position0, PLACE)?;
    let velocity0 = pair("velocity0", velocity0, VELOCITY)?;
    let period = SAMPLE_PERIOD.check("sample_period", sample_period.named("sample_period")?)?;
    if hand.len() != robot.len() || hand.is_empty() {
        return Err(InvalidInput::new(
            "robot_force",
            format!("{} rows, and {} of hand_force", robot.len(), hand.len()),
            "both forces need one row per sample period, at least one",
            "Pass arrays of the same length.",
        )
        .into());
    }
    let plant = Plant::new(handle, &arm, position0).map_err(|refusal| refusal.within("arm"))?;
    let record = apart(py, move || run(plant.with_velocity(velocity0), &hand, &robot, period))?;
    let last = period * (record.position.len() - 1) as f64;
    let (status, ended_at) = match record.halt {
        None => ("completed", None),
        Some(Halt::OutOfReach(_)) => ("out of reach", Some(last)),
        Some(_) => ("too stiff", Some(last)),
    };
    let has_joints = matches!(arm, rig::Arm::TwoLink(_));
    Ok(HandleMotion {
        position: columns(py, record.position)?,
        velocity: columns(py, record.velocity)?,
        handle_force: columns(py, record.handle_force)?,
        torque: has_joints.then(|| columns(py, record.torque)).transpose()?,
        status: status.to_owned(),
        ended_at,
    })
}

/// Moves the plant under all forces and records its motion.
fn run(mut plant: Plant, hand: &[[f64; 2]], robot: &[[f64; 2]], period: f64) -> Record {
    let mut record = Record::default();
    let keep = |plant: &Plant, tick: usize, record: &mut Record| {
        record.position.push(plant.position());
        record.velocity.push(plant.velocity());
        record.handle_force.push(plant.handle_force(robot[tick], hand[tick]));
    };
    for tick in 0..hand.len() {
        keep(&plant, tick, &mut record);
        if let Plant::TwoLink(arm) = &plant {
            record.torque.push(arm.torque_for(hand[tick]));
        }
        if let Err(halt) = plant.advance(robot[tick], hand[tick], period) {
            record.halt = Some(halt);
            return record;
        }
    }
    // no forces are given for the end: the last ones still act
    keep(&plant, hand.len() - 1, &mut record);
    record
}

type Matrices<'py> = Bound<'py, PyArray3<f64>>;

/// Mass and damping matrices that the handle feels of an arm at each position.
#[pyfunction]
pub fn arm_operator<'py>(
    py: Python<'py>,
    arm: &Bound<'py, PyAny>,
    positions: &Bound<'py, PyAny>,
) -> Outcome<(Matrices<'py>, Matrices<'py>)> {
    let arm = arm_of(arm)?;
    let positions = rows("positions", positions)?;
    let (mut mass, mut damping) = (Vec::new(), Vec::new());
    for (index, position) in positions.iter().enumerate() {
        let (m, d) = match &arm {
            rig::Arm::Lumped { mass, damping } => (diagonal(*mass), diagonal(*damping)),
            rig::Arm::TwoLink(arm) => arm.operator_at(*position).map_err(|outside| {
                InvalidInput::new(
                    format!("positions[{index}]"),
                    format!("{position:?}"),
                    outside.to_string(),
                    "Choose positions within reach, or move the arm's base.",
                )
            })?,
        };
        mass.extend(m.into_iter().flatten());
        damping.extend(d.into_iter().flatten());
    }
    let shape = [positions.len(), 2, 2];
    Ok((mass.into_pyarray(py).reshape(shape)?, damping.into_pyarray(py).reshape(shape)?))
}

/// A diagonal matrix for a robot in an arm.
fn diagonal([x, y]: [f64; 2]) -> [[f64; 2]; 2] {
    [[x, 0.0], [0.0, y]]
}
