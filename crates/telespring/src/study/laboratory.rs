//! The sections `[arm1]`, `[arm2]`, `[agent1]`, `[agent2]`, `[task]` and `[laboratory]` of a study file.

use super::python::{PythonObject, read_python_object};
use super::reader::Reader;
use crate::error::Result;
use crate::quantity::{self, Quantity};
use crate::rig::{Arm, Elbow, Spots, TwoLinkArm};

/// The agent of an arm, as given in the study.
#[derive(Debug, Clone, PartialEq)]
pub enum AgentChoice {
    /// A spring and a damper to the target (Eq. 13, which has no damper).
    Skilled {
        /// N/m.
        stiffness: f64,
        /// N·s/m.
        damping: f64,
    },
    /// Springs to a cloud of spots (Eq. 14).
    Blurred {
        /// Total stiffness of all springs, N/m.
        stiffness: f64,
        /// The cloud.
        spots: Spots,
    },
    /// A Python class.
    Python(PythonObject),
}

/// The task of both agents, as given in the study.
#[derive(Debug, Clone, PartialEq)]
pub enum Task {
    /// p*(t) = (A sin 2ωt, B sin ωt), Eq. 12.
    FigureEight {
        /// A and B, m.
        amplitude: [f64; 2],
        /// ω, rad/s.
        angular_frequency: f64,
    },
    /// A Python function.
    Python(PythonObject),
}

/// The setup of a rehearsal: everything besides robots and protocol.
#[derive(Debug, Clone, PartialEq)]
pub struct Setup {
    /// Both arms.
    pub arms: [Arm; 2],
    /// Both agents.
    pub agents: [AgentChoice; 2],
    /// The task.
    pub task: Task,
    /// Sample period of the laboratory's controllers, s, if given in `[laboratory]`.
    pub sample_period: Option<f64>,
    /// True if a force acts one period after the sample from which it was computed.
    pub computing_tick: bool,
    /// Time constant of the robots' actuators, s.
    pub actuator_lag: f64,
    /// Resolution of measured positions, m; 0 for none. Velocities are not quantised.
    pub encoder_resolution: f64,
}

/// The ideal massless arm: the agent's force reaches the handle unchanged.
pub(super) const MASSLESS: Arm = Arm::Lumped { mass: [0.0; 2], damping: [0.0; 2] };
/// k_c of Eqs. 13 and 14, N/m.
const STIFFNESS: f64 = 120.0;
/// After 0.2 s a typical spot is 0.06 m away, the size of the figure: farther away it would hide the target
/// rather than blur it. The paper gives no lifetime.
const SPOTS: Spots = Spots { count: 10, velocity: 0.3, lifetime: 0.2 };

impl Setup {
    /// The paper's setup: massless arms, a skilled and a less-skilled agent, the figure of eight, no
    /// imperfections.
    pub fn paper() -> Self {
        Self {
            arms: [MASSLESS; 2],
            agents: [
                AgentChoice::Skilled { stiffness: STIFFNESS, damping: 0.0 },
                AgentChoice::Blurred { stiffness: STIFFNESS, spots: SPOTS },
            ],
            task: Task::FigureEight { amplitude: [0.05, 0.1], angular_frequency: PAPER_FREQUENCY },
            sample_period: None,
            computing_tick: false,
            actuator_lag: 0.0,
            encoder_resolution: 0.0,
        }
    }
}

/// ω of Eq. 12, rad/s.
pub(super) const PAPER_FREQUENCY: f64 = 2.59;

/// Reads the setup of a rehearsal.
pub(super) fn read_setup(reader: &Reader<'_>) -> Result<Setup> {
    let paper = Setup::paper();
    let [agent1, agent2] = paper.agents;
    let number = |key: &str, quantity: Quantity| number_or(reader, "laboratory", key, quantity, 0.0);
    Ok(Setup {
        arms: [read_arm(reader, "arm1")?, read_arm(reader, "arm2")?],
        agents: [read_agent(reader, "agent1", agent1)?, read_agent(reader, "agent2", agent2)?],
        task: read_task(reader, paper.task)?,
        sample_period: read_sample_period(reader)?,
        computing_tick: reader
            .get("laboratory", "computing_tick")
            .map_or(Ok(false), |entry| entry.boolean())?,
        actuator_lag: number("actuator_lag", quantity::SPAN)?,
        encoder_resolution: number("encoder_resolution", quantity::RESOLUTION)?,
    })
}

/// Reads the sample period of the laboratory's controllers, s, if given.
pub(super) fn read_sample_period(reader: &Reader<'_>) -> Result<Option<f64>> {
    let entry = reader.get("laboratory", "sample_period");
    entry.map(|entry| entry.number(quantity::SAMPLE_PERIOD, "a number")).transpose()
}

/// Reads a number of the laboratory, or returns `default` if the key is missing.
fn number_or(reader: &Reader<'_>, section: &str, key: &str, quantity: Quantity, default: f64) -> Result<f64> {
    // +0 removes the sign of −0, which has no meaning and would not be written.
    reader.get(section, key).map_or(Ok(default), |entry| Ok(entry.number(quantity, "a number")? + 0.0))
}

/// Reads an arm of the laboratory from the section `[arm1]` or `[arm2]`.
pub(super) fn read_arm(reader: &Reader<'_>, section: &str) -> Result<Arm> {
    let pair = |key: &str, quantity: Quantity| {
        reader
            .get(section, key)
            .map_or(Ok([0.0; 2]), |entry| Ok(entry.two_numbers(quantity, true)?.map(|v| v + 0.0)))
    };
    match reader.kind(section)? {
        "two-link" => {
            let need = |key: &str, example: &str, quantity: Quantity| {
                reader.require(section, key, quantity.unit(), example)?.two_numbers(quantity, key != "base")
            };
            let elbow = reader.require(section, "elbow", "", "\"left\"")?.choice(&["left", "right"])?;
            let arm = TwoLinkArm {
                base: need("base", "[0.0, -0.5]", quantity::PLACE)?,
                elbow: if elbow == "left" { Elbow::Left } else { Elbow::Right },
                link_length: need("link_length", "[0.3, 0.3]", quantity::LENGTH)?,
                link_mass: need("link_mass", "[1.0, 0.8]", quantity::LINK_MASS)?,
                link_centre: need("link_centre", "[0.15, 0.15]", quantity::OFFSET)?,
                link_inertia: need("link_inertia", "[0.008, 0.006]", quantity::INERTIA)?,
                joint_damping: pair("joint_damping", quantity::JOINT_DAMPING)?,
                rotor_inertia: pair("rotor_inertia", quantity::INERTIA)?,
                torque_limit: reader
                    .get(section, "torque_limit")
                    .map_or(Ok([f64::INFINITY; 2]), |entry| entry.two_numbers(quantity::TORQUE, true))?,
            };
            Ok(Arm::TwoLink(arm))
        }
        "lumped" => Ok(Arm::Lumped {
            mass: pair("mass", quantity::ADDED_MASS)?,
            damping: pair("damping", quantity::DAMPING)?,
        }),
        _ => Ok(MASSLESS),
    }
}

/// Reads an agent of the laboratory from the section `[agent1]` or `[agent2]`.
pub(super) fn read_agent(reader: &Reader<'_>, section: &str, default: AgentChoice) -> Result<AgentChoice> {
    if !reader.has(section) {
        return Ok(default);
    }
    let stiffness = || number_or(reader, section, "stiffness", quantity::GROUND_STIFFNESS, STIFFNESS);
    Ok(match reader.kind(section)? {
        "skilled" => AgentChoice::Skilled {
            stiffness: stiffness()?,
            damping: number_or(reader, section, "damping", quantity::DAMPING, 0.0)?,
        },
        "blurred" => AgentChoice::Blurred {
            stiffness: stiffness()?,
            spots: Spots {
                count: reader.get(section, "spots").map_or(Ok(SPOTS.count as i64), |entry| {
                    entry.whole_number("the number of spots", 1, Spots::MAX_COUNT as i64)
                })? as usize,
                velocity: number_or(reader, section, "spot_velocity", quantity::SPEED, SPOTS.velocity)?,
                lifetime: number_or(reader, section, "spot_lifetime", quantity::LIFETIME, SPOTS.lifetime)?,
            },
        },
        _ => AgentChoice::Python(read_python_object(reader, section, "class", "agents:Patient")?),
    })
}

/// Reads the task in the laboratory from the section `[task]`.
pub(super) fn read_task(reader: &Reader<'_>, default: Task) -> Result<Task> {
    let Task::FigureEight { amplitude, angular_frequency } = default else { return Ok(default) };
    if reader.has("task") && reader.kind("task")? == "python" {
        return Ok(Task::Python(read_python_object(reader, "task", "function", "targets:circle")?));
    }
    Ok(Task::FigureEight {
        amplitude: reader.get("task", "amplitude").map_or(Ok(amplitude), |entry| {
            Ok(entry.two_numbers(quantity::AMPLITUDE, false)?.map(|v| v + 0.0))
        })?,
        angular_frequency: number_or(
            reader,
            "task",
            "angular_frequency",
            quantity::ANGULAR_FREQUENCY,
            angular_frequency,
        )?,
    })
}
