//! One robot in one arm under given forces, and what its handle feels of the arm.

use numpy::{IntoPyArray, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyDict;
use telespring::InvalidInput;
use telespring::quantity::SAMPLE_PERIOD;
use telespring::rig::plant::Plant;
use telespring::rig::{Arm, Elbow, Handle, TwoLinkArm};

use crate::arguments::Number;
use crate::errors::Outcome;

/// A dictionary of named values, each to be taken out once.
struct Table<'a, 'py> {
    name: &'static str,
    dict: &'a Bound<'py, PyDict>,
    known: Vec<&'static str>,
}

impl<'a, 'py> Table<'a, 'py> {
    fn new(name: &'static str, dict: &'a Bound<'py, PyDict>) -> Self {
        Self { name, dict, known: Vec::new() }
    }

    fn get(&mut self, key: &'static str) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.known.push(key);
        self.dict.get_item(key)
    }

    fn text(&mut self, key: &'static str, choices: &[&str]) -> Outcome<Option<String>> {
        let Some(value) = self.get(key)? else { return Ok(None) };
        let text = value.str()?.to_string();
        if choices.contains(&text.as_str()) {
            return Ok(Some(text));
        }
        let refusal =
            InvalidInput::new(key, text, format!("one of {choices:?} is needed"), "Write one of them.");
        Err(refusal.within(self.name).into())
    }

    /// Two numbers, or one for both.
    fn pair(&mut self, key: &'static str, otherwise: Option<[f64; 2]>) -> Outcome<[f64; 2]> {
        let Some(value) = self.get(key)? else {
            return otherwise.ok_or_else(|| {
                InvalidInput::new(key, "nothing", "a number or a pair is needed", "Add it to the dictionary.")
                    .within(self.name)
                    .into()
            });
        };
        if let Ok(number) = value.extract::<f64>() {
            return Ok([number; 2]);
        }
        value.extract::<[f64; 2]>().map_err(|_| {
            let text = value.repr().map_or_else(|_| "an object".to_owned(), |text| text.to_string());
            InvalidInput::new(key, text, "a number or a pair of numbers is needed", "Give one or two floats.")
                .within(self.name)
                .into()
        })
    }

    /// Refuses what nobody asked for: a misspelt key would pass for its default.
    fn end(self) -> Outcome<()> {
        for key in self.dict.keys() {
            let text = key.str()?.to_string();
            if !self.known.contains(&text.as_str()) {
                return Err(InvalidInput::new(
                    format!("{}.{text}", self.name),
                    "given",
                    format!("the keys are {:?}", self.known),
                    "Correct its name or leave it out.",
                )
                .into());
            }
        }
        Ok(())
    }
}

fn handle_of(dict: &Bound<'_, PyDict>) -> Outcome<Handle> {
    let mut table = Table::new("handle", dict);
    let handle = Handle {
        mass: table.pair("mass", None)?,
        damping: table.pair("damping", None)?,
        coulomb: table.pair("coulomb", Some([0.0; 2]))?,
    };
    table.end()?;
    handle.check().map_err(|refusal| refusal.within("handle"))?;
    Ok(handle)
}

fn arm_of(dict: &Bound<'_, PyDict>) -> Outcome<Arm> {
    let mut table = Table::new("arm", dict);
    let arm = match table.text("kind", &["massless", "lumped", "two-link"])?.as_deref() {
        Some("two-link") => {
            let elbow = table.text("elbow", &["left", "right"])?;
            Arm::TwoLink(TwoLinkArm {
                base: table.pair("base", None)?,
                elbow: if elbow.as_deref() == Some("left") { Elbow::Left } else { Elbow::Right },
                link_length: table.pair("link_length", None)?,
                link_mass: table.pair("link_mass", None)?,
                link_centre: table.pair("link_centre", None)?,
                link_inertia: table.pair("link_inertia", None)?,
                joint_damping: table.pair("joint_damping", Some([0.0; 2]))?,
                rotor_inertia: table.pair("rotor_inertia", Some([0.0; 2]))?,
                torque_limit: table.pair("torque_limit", Some([f64::INFINITY; 2]))?,
            })
        }
        Some("lumped") => Arm::Lumped {
            mass: table.pair("mass", Some([0.0; 2]))?,
            damping: table.pair("damping", Some([0.0; 2]))?,
        },
        _ => Arm::Lumped { mass: [0.0; 2], damping: [0.0; 2] },
    };
    table.end()?;
    arm.check().map_err(|refusal| refusal.within("arm"))?;
    Ok(arm)
}

/// Any array_like of rows (x, y), refused by its name.
fn rows(name: &str, value: &Bound<'_, PyAny>) -> Outcome<Vec<[f64; 2]>> {
    static AS_NUMBERS: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    let as_numbers = AS_NUMBERS.import(value.py(), "telespring._arrays", "as_numbers")?;
    let array = as_numbers.call1((name, value))?;
    if let Ok(array) = array.extract::<PyReadonlyArray2<'_, f64>>()
        && array.as_array().ncols() == 2
    {
        return Ok(array.as_array().outer_iter().map(|row| [row[0], row[1]]).collect());
    }
    let shape = array.getattr("shape")?;
    Err(InvalidInput::new(
        name,
        format!("an array of shape {shape}"),
        "rows of two numbers, x and y, are needed",
        "Give an array of shape (n, 2).",
    )
    .into())
}

fn columns(py: Python<'_>, values: Vec<[f64; 2]>) -> PyResult<Bound<'_, PyArray2<f64>>> {
    let shape = [values.len(), 2];
    values.into_flattened().into_pyarray(py).reshape(shape)
}

/// What was recorded of one run.
#[derive(Default)]
struct Record {
    position: Vec<[f64; 2]>,
    velocity: Vec<[f64; 2]>,
    handle_force: Vec<[f64; 2]>,
    torque: Vec<[f64; 2]>,
    out_of_reach: bool,
}

/// Position, velocity and the force at the handle of one robot in an arm, all forces held.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "tests name them")]
#[pyo3(signature = (handle, arm, hand_force, robot_force, sample_period, position0, velocity0=[0.0, 0.0]))]
pub fn simulate_handle<'py>(
    py: Python<'py>,
    handle: &Bound<'py, PyDict>,
    arm: &Bound<'py, PyDict>,
    hand_force: &Bound<'py, PyAny>,
    robot_force: &Bound<'py, PyAny>,
    sample_period: Number,
    position0: [f64; 2],
    velocity0: [f64; 2],
) -> Outcome<Bound<'py, PyDict>> {
    let (handle, arm) = (handle_of(handle)?, arm_of(arm)?);
    let (hand, robot) = (rows("hand_force", hand_force)?, rows("robot_force", robot_force)?);
    let period = SAMPLE_PERIOD.check("sample_period", sample_period.named("sample_period")?)?;
    if hand.len() != robot.len() || hand.is_empty() {
        return Err(InvalidInput::new(
            "robot_force",
            format!("{} rows beside {} of hand_force", robot.len(), hand.len()),
            "both forces have one row for every sample period, one at least",
            "Give them the same length.",
        )
        .into());
    }
    let plant = Plant::new(handle, &arm, position0).map_err(|refusal| refusal.within("arm"))?;
    let record = py.detach(|| run(plant.with_velocity(velocity0), &hand, &robot, period));
    let out = PyDict::new(py);
    let ended_at = if record.out_of_reach { period * (record.position.len() - 1) as f64 } else { f64::NAN };
    out.set_item("status", if record.out_of_reach { "out of reach" } else { "completed" })?;
    out.set_item("ended_at", ended_at)?;
    out.set_item("position", columns(py, record.position)?)?;
    out.set_item("velocity", columns(py, record.velocity)?)?;
    out.set_item("handle_force", columns(py, record.handle_force)?)?;
    if matches!(arm, Arm::TwoLink(_)) {
        out.set_item("torque", columns(py, record.torque)?)?;
    }
    Ok(out)
}

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
        if plant.advance(robot[tick], hand[tick], period).is_err() {
            record.out_of_reach = true;
            return record;
        }
    }
    // at the end no new forces are known: the last ones still act
    keep(&plant, hand.len() - 1, &mut record);
    record
}

type Matrices<'py> = Bound<'py, PyArray3<f64>>;

/// Mass and damping matrices that the handle feels of an arm at each position.
#[pyfunction]
pub fn arm_operator<'py>(
    py: Python<'py>,
    arm: &Bound<'py, PyDict>,
    positions: &Bound<'py, PyAny>,
) -> Outcome<(Matrices<'py>, Matrices<'py>)> {
    let arm = arm_of(arm)?;
    let positions = rows("positions", positions)?;
    let (mut mass, mut damping) = (Vec::new(), Vec::new());
    for (index, position) in positions.iter().enumerate() {
        let (m, d) = match &arm {
            Arm::Lumped { mass, damping } => (diagonal(*mass), diagonal(*damping)),
            Arm::TwoLink(arm) => arm.operator_at(*position).map_err(|outside| {
                InvalidInput::new(
                    format!("positions[{index}]"),
                    format!("{position:?}"),
                    outside.to_string(),
                    "Keep to positions within the reach, or move the arm's base.",
                )
            })?,
        };
        mass.extend(m.into_iter().flatten());
        damping.extend(d.into_iter().flatten());
    }
    let shape = [positions.len(), 2, 2];
    Ok((mass.into_pyarray(py).reshape(shape)?, damping.into_pyarray(py).reshape(shape)?))
}

fn diagonal([x, y]: [f64; 2]) -> [[f64; 2]; 2] {
    [[x, 0.0], [0.0, y]]
}
