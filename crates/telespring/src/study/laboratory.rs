//! The sections of arms, agents, task and laboratory: who does what in a rehearsal, on which controllers
//! and network.

use super::python::{PythonObject, python};
use super::reader::Reader;
use crate::error::Result;
use crate::quantity::{self, Quantity};
use crate::rig::{Arm, Elbow, Spots, TwoLinkArm};

/// Who moves an arm, as the study says it.
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
        /// All springs together, N/m.
        stiffness: f64,
        /// The cloud.
        spots: Spots,
    },
    /// A class of Python.
    Python(PythonObject),
}

/// What both agents follow, as the study says it.
#[derive(Debug, Clone, PartialEq)]
pub enum Task {
    /// p*(t) = (A sin 2ωt, B sin ωt), Eq. 12.
    FigureEight {
        /// A and B, m.
        amplitude: [f64; 2],
        /// ω, rad/s.
        angular_frequency: f64,
    },
    /// A function of Python.
    Python(PythonObject),
}

/// What a study says of its rehearsal beside robots and protocol.
#[derive(Debug, Clone, PartialEq)]
pub struct Setup {
    /// Both arms.
    pub arms: [Arm; 2],
    /// Both agents.
    pub agents: [AgentChoice; 2],
    /// What they follow.
    pub task: Task,
    /// Period of the laboratory's controllers, s, where [laboratory] names one.
    pub sample_period: Option<f64>,
    /// True where a force acts one period after the sample it was computed from.
    pub computing_tick: bool,
    /// Time constant of the robots' actuators, s.
    pub actuator_lag: f64,
    /// Step to which measured positions are rounded, m; 0 is none. Velocities have no step.
    pub encoder_resolution: f64,
    /// The most that a packet may be later than the delay, s.
    pub jitter: f64,
    /// Probability that a packet is lost.
    pub loss: f64,
}

/// Both zero: the agent's force reaches the handle unchanged.
pub(super) const MASSLESS: Arm = Arm::Lumped { mass: [0.0; 2], damping: [0.0; 2] };
/// k_c of Eqs. 13 and 14, N/m.
const STIFFNESS: f64 = 120.0;
/// By 0.2 s the typical spot is 0.06 m off, the size of the figure: further off it would hide the target
/// rather than blur it. The paper gives no lifetime.
const SPOTS: Spots = Spots { count: 10, velocity: 0.3, lifetime: 0.2 };

impl Setup {
    /// The paper's: massless arms, a skilled and a less-skilled agent, its figure eight, nothing imperfect.
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
            jitter: 0.0,
            loss: 0.0,
        }
    }
}

/// ω of Eq. 12, rad/s.
pub(super) const PAPER_FREQUENCY: f64 = 2.59;

pub(super) fn setup(reader: &Reader<'_>) -> Result<Setup> {
    let paper = Setup::paper();
    let [agent1, agent2] = paper.agents;
    let number = |key: &str, quantity: Quantity| or(reader, "laboratory", key, quantity, 0.0);
    Ok(Setup {
        arms: [arm(reader, "arm1")?, arm(reader, "arm2")?],
        agents: [agent(reader, "agent1", agent1)?, agent(reader, "agent2", agent2)?],
        task: task(reader, paper.task)?,
        sample_period: reader
            .get("laboratory", "sample_period")
            .map(|entry| entry.number(quantity::SAMPLE_PERIOD, "a number"))
            .transpose()?,
        computing_tick: reader
            .get("laboratory", "computing_tick")
            .map_or(Ok(false), |entry| entry.boolean())?,
        actuator_lag: number("actuator_lag", quantity::SPAN)?,
        encoder_resolution: number("encoder_resolution", quantity::RESOLUTION)?,
        jitter: number("jitter", quantity::SPAN)?,
        loss: number("loss", quantity::PROBABILITY)?,
    })
}

/// A number, or `default` where the key is not given.
fn or(reader: &Reader<'_>, section: &str, key: &str, quantity: Quantity, default: f64) -> Result<f64> {
    // +0: a minus sign before a zero means nothing and would not be written
    reader.get(section, key).map_or(Ok(default), |entry| Ok(entry.number(quantity, "a number")? + 0.0))
}

pub(super) fn arm(reader: &Reader<'_>, section: &str) -> Result<Arm> {
    let pair = |key: &str, quantity: Quantity| {
        reader.get(section, key).map_or(Ok([0.0; 2]), |entry| Ok(entry.two(quantity, true)?.map(|v| v + 0.0)))
    };
    match reader.kind(section)? {
        "two-link" => {
            let need = |key: &str, like: &str, quantity: Quantity| {
                reader.need(section, key, &format!("{key} = {like}"))?.two(quantity, key != "base")
            };
            let elbow = reader.need(section, "elbow", "elbow = \"left\"")?.choice(&["left", "right"])?;
            let arm = TwoLinkArm {
                base: need("base", "[0.0, -0.5] (m)", quantity::PLACE)?,
                elbow: if elbow == "left" { Elbow::Left } else { Elbow::Right },
                link_length: need("link_length", "[0.3, 0.3] (m)", quantity::LENGTH)?,
                link_mass: need("link_mass", "[1.0, 0.8] (kg)", quantity::LINK_MASS)?,
                link_centre: need("link_centre", "[0.15, 0.15] (m)", quantity::OFFSET)?,
                link_inertia: need("link_inertia", "[0.008, 0.006] (kg·m²)", quantity::INERTIA)?,
                joint_damping: pair("joint_damping", quantity::JOINT_DAMPING)?,
                rotor_inertia: pair("rotor_inertia", quantity::INERTIA)?,
                torque_limit: reader
                    .get(section, "torque_limit")
                    .map_or(Ok([f64::INFINITY; 2]), |entry| entry.two(quantity::TORQUE, true))?,
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

pub(super) fn agent(reader: &Reader<'_>, section: &str, default: AgentChoice) -> Result<AgentChoice> {
    if !reader.has(section) {
        return Ok(default);
    }
    let stiffness = || or(reader, section, "stiffness", quantity::GROUND_STIFFNESS, STIFFNESS);
    Ok(match reader.kind(section)? {
        "skilled" => AgentChoice::Skilled {
            stiffness: stiffness()?,
            damping: or(reader, section, "damping", quantity::DAMPING, 0.0)?,
        },
        "blurred" => AgentChoice::Blurred {
            stiffness: stiffness()?,
            spots: Spots {
                count: reader.get(section, "spots").map_or(Ok(SPOTS.count as i64), |entry| {
                    entry.whole("the number of spots", 1, Spots::MAX_COUNT as i64)
                })? as usize,
                velocity: or(reader, section, "spot_velocity", quantity::SPEED, SPOTS.velocity)?,
                lifetime: or(reader, section, "spot_lifetime", quantity::LIFETIME, SPOTS.lifetime)?,
            },
        },
        _ => AgentChoice::Python(python(reader, section, "class", "agents:Patient")?),
    })
}

pub(super) fn task(reader: &Reader<'_>, default: Task) -> Result<Task> {
    let Task::FigureEight { amplitude, angular_frequency } = default else { return Ok(default) };
    if reader.has("task") && reader.kind("task")? == "python" {
        return Ok(Task::Python(python(reader, "task", "function", "targets:circle")?));
    }
    Ok(Task::FigureEight {
        amplitude: reader
            .get("task", "amplitude")
            .map_or(Ok(amplitude), |entry| Ok(entry.two(quantity::AMPLITUDE, false)?.map(|v| v + 0.0)))?,
        angular_frequency: or(
            reader,
            "task",
            "angular_frequency",
            quantity::ANGULAR_FREQUENCY,
            angular_frequency,
        )?,
    })
}
