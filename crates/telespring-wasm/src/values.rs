//! A study as values for controls, and with some of them changed.

use std::collections::BTreeMap;

use serde_json::{Value, json};
use telespring::quantity::{self, Quantity};
use telespring::study::{Replacement, Study, Table, Value as Toml};
use telespring::verdicts::OperatorRange;
use telespring::{InvalidInput, Result};

/// The study in a text; an empty one is the paper's, with the controllers that `telespring decide` takes.
///
/// # Errors
///
/// [`InvalidInput`] as [`Study::from_toml`].
pub fn read(text: &str) -> Result<Study> {
    if text.is_empty() {
        // As without a file on the command line: the sample period is the reader's default.
        let period = Study::from_toml(ANY)?.network()?.sample_period();
        return changed(&Study::paper(), &format!("controller.sample_period = {period:?}"));
    }
    Study::from_toml(text)
}

/// A study that leaves all to the defaults.
const ANY: &str = "robot1 = {mass = 1, damping = 1}\nrobot2 = {mass = 1, damping = 1}\nnetwork.delay = 0\n";

/// The study with the values of a TOML table in place of its own, by section and key.
///
/// # Errors
///
/// [`InvalidInput`] if the table is not TOML, or a value is refused.
pub fn changed(study: &Study, changes: &str) -> Result<Study> {
    if changes.trim().is_empty() {
        return Ok(study.clone());
    }
    let table: Table = changes.parse().map_err(|error: toml::de::Error| {
        InvalidInput::new("changes", error.message(), "a TOML table is required", "Correct the text.")
    })?;
    let replacements: BTreeMap<String, Replacement> = table
        .into_iter()
        .map(|(section, value)| {
            let replacement = match value {
                Toml::Table(keys) if keys.is_empty() => Replacement::Default,
                Toml::Table(keys) => {
                    Replacement::Keys(keys.into_iter().map(|(key, value)| (key, Some(value))).collect())
                }
                value => Replacement::Value(value),
            };
            (section, replacement)
        })
        .collect();
    study.replace(&replacements)
}

/// The values of a study that a page shows and changes, its text, and what is usual of each quantity.
///
/// # Errors
///
/// None today; as the others it returns a result.
pub fn values(study: &Study) -> Result<Value> {
    let delay = study.network().ok().map(|network| network.delay());
    let timing = study.judged_network(Some(telespring::Delay::each_way(0.0)?), [None, None])?.network;
    let names = study.robot_names();
    let robots: Vec<Value> = study
        .dyad()
        .robots()
        .iter()
        .enumerate()
        .map(|(i, robot)| {
            json!({
                "name": names[i],
                "mass": robot.mass(),
                "damping": robot.damping(),
                "ground_stiffness": study.ground_stiffness()[i],
            })
        })
        .collect();
    let network = study.network().ok().copied();
    let judged =
        study.judged_network(delay.is_none().then_some(telespring::Delay::each_way(0.0)?), [None, None])?;
    Ok(json!({
        "name": study.name(),
        "axes": study.dyad().axis_names(),
        "robots": robots,
        "operators": study.hands().each_ref().map(hand),
        "stiffness": study.coupling().ok().map(|coupling| coupling.stiffness),
        "coupling_damping": study.dyad().coupling_damping(),
        "delay": delay.map(|delay| [delay.forward(), delay.backward()]),
        "jitter": network.map(|network| network.jitters()),
        "max_gap": network.map(|network| network.max_gap()),
        "playout_buffer": study.has_playout_buffer(),
        "sample_period": timing.sample_period(),
        "computing_time": timing.computing_time(),
        "session": study.session().label(),
        "allow_unusual": study.allows_unusual(),
        "is_judged_as_stated": judged.is_as_stated,
        "ages_from": judged.sources.iter().map(|source| source.word()).collect::<Vec<_>>(),
        "not_judged": judged.unjudged.iter().map(|each| each.word()).collect::<Vec<_>>(),
        "has_uncertainty": study.uncertainty().iter().any(Option::is_some),
        "names_arms_or_agents": study.names_arms_or_agents(),
        "usual": {
            "mass": usual(quantity::MASS),
            "damping": usual(quantity::DAMPING),
            "stiffness": usual(quantity::STIFFNESS),
            "delay": usual(quantity::DELAY),
            "sample_period": usual(quantity::CONTROLLER_PERIOD),
            "operator_stiffness": usual(quantity::GROUND_STIFFNESS),
            "operator_damping": usual(quantity::OPERATOR_DAMPING),
            "operator_mass": usual(quantity::ADDED_MASS),
        },
        "toml": study.to_toml(),
    }))
}

/// The lowest and the highest value of what holds a handle, per axis.
fn hand(range: &OperatorRange) -> Value {
    let (low, high) = (range.low(), range.high());
    let pairs = |low: &[f64], high: &[f64]| -> Vec<[f64; 2]> {
        low.iter().zip(high).map(|(low, high)| [*low, *high]).collect()
    };
    json!({
        "mass": pairs(low.mass(), high.mass()),
        "damping": pairs(low.damping(), high.damping()),
        "stiffness": pairs(low.stiffness(), high.stiffness()),
    })
}

/// The smallest and the largest usual magnitude.
fn usual(quantity: Quantity) -> Option<[f64; 2]> {
    quantity.usual_range().map(|(least, most)| [least, most])
}

/// A refusal as JSON.
pub fn refusal(refused: &InvalidInput) -> Value {
    json!({
        "refused": refused.to_string(),
        "field": refused.field,
        "value": refused.value,
        "allowed": refused.allowed,
        "remedy": refused.remedy,
    })
}
