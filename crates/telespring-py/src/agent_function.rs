//! An agent of the laboratory that is a function of the caller.

use numpy::PyArray1;
use pyo3::prelude::*;
use telespring::InvalidInput;
use telespring::rig::Observation;

use crate::arguments::Argument;
use crate::errors::Outcome;

/// A function of the caller: the force of an agent from time, position, velocity and target.
pub type AgentFunction = Py<PyAny>;

/// The refusal of a laboratory's agent that is no function.
pub fn refuse_uncallable(side: usize, text: String) -> InvalidInput {
    InvalidInput::new(
        format!("agents[{side}]"),
        text,
        "an agent is None or callable",
        "Pass a function of time, position, velocity and target that returns the force.",
    )
}

/// The refusal of a function for an agent of the laboratory that is not external.
pub fn refuse_superfluous(side: usize) -> InvalidInput {
    let number = side + 1;
    InvalidInput::new(
        format!("agents[{side}]"),
        "a function",
        format!("agent {number} of this laboratory is not an external one"),
        format!("Choose kind = \"python\" in [agent{number}], or pass None."),
    )
}

/// The force that the agent's function returns, or its exception.
pub fn call_agent(program: &AgentFunction, seen: &Observation) -> Outcome<[f64; 2]> {
    Python::attach(|py| {
        let vector = |values: [f64; 2]| PyArray1::from_slice(py, &values);
        let arguments = (seen.time, vector(seen.position), vector(seen.velocity), vector(seen.target));
        let answer = program.call1(py, arguments)?;
        match answer.extract::<Argument<[f64; 2]>>(py) {
            Ok(Argument::Given(force)) => Ok(force),
            Ok(Argument::Other(text)) => Err(InvalidInput::new(
                "agents",
                text,
                format!("at {} s the agent's force must be two numbers, in N along x and y", seen.time),
                "Return an array or a pair of two floats.",
            )
            .into()),
            Err(never) => match never {},
        }
    })
}
