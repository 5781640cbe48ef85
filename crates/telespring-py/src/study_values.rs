//! Python values as a study file contains them: numbers, strings, booleans, lists and tables.

use std::collections::BTreeMap;

use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyMapping, PyString, PyTuple};
use telespring::InvalidInput;
use telespring::study::{OptionValue, Replacement, Table, Value};

use crate::arguments::written;
use crate::coupling::Coupling;
use crate::errors::Outcome;
use crate::experiment::LaboratorySettings;
use crate::model::{Operator, Robot};
use crate::network::Network;

/// The value as a study file holds it; `field` names it in a refusal.
pub fn to_value(field: &str, value: &Bound<'_, PyAny>) -> Outcome<Value> {
    // numpy's arrays and scalars, and the classes of a study
    for method in ["tolist", "to_dict"] {
        if let Ok(convert) = value.getattr(method) {
            return to_value(field, &convert.call0()?);
        }
    }
    if let Ok(boolean) = value.cast::<PyBool>() {
        return Ok(Value::Boolean(boolean.is_true()));
    }
    if value.is_instance_of::<PyInt>() {
        return value.extract().map(Value::Integer).map_err(|_| {
            let allowed = "a whole number has at most 64 bits in a study";
            InvalidInput::new(field, written(value), allowed, "Choose a smaller number.").into()
        });
    }
    if let Ok(number) = value.cast::<PyFloat>() {
        return Ok(Value::Float(number.value()));
    }
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(Value::String(text.to_cow()?.into_owned()));
    }
    if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        let items = value.try_iter()?.enumerate();
        return items
            .map(|(i, item)| to_value(&format!("{field}[{i}]"), &item?))
            .collect::<Outcome<_>>()
            .map(Value::Array);
    }
    if let Ok(mapping) = value.cast::<PyMapping>() {
        return to_table(field, mapping).map(Value::Table);
    }
    Err(InvalidInput::new(
        field,
        written(value),
        "a study contains numbers, strings, booleans, and lists and tables of these",
        "Convert it to one of them.",
    )
    .into())
}

/// The mapping as a table of a study file.
pub fn to_table(field: &str, mapping: &Bound<'_, PyMapping>) -> Outcome<Table> {
    let mut table = Table::new();
    for item in mapping.items()?.iter() {
        let (key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>) = item.extract()?;
        let key = key.str()?.to_string();
        let value = to_value(&format!("{field}.{key}"), &value)?;
        table.insert(key, value);
    }
    Ok(table)
}

/// The keywords of `Study.replace`, by section.
pub fn replacements(sections: &Bound<'_, PyDict>) -> Outcome<BTreeMap<String, Replacement>> {
    let replacement = |name: &str, section: &Bound<'_, PyAny>| -> Outcome<Replacement> {
        if section.is_none() {
            return Ok(Replacement::Default);
        }
        if let Ok(robot) = section.cast::<Robot>() {
            return Ok(Replacement::Keys(robot_keys(&robot.get().0)));
        }
        if let Ok(operator) = section.cast::<Operator>() {
            let keys = ["mass", "damping", "stiffness"].map(|key| {
                let values = operator.getattr(key)?;
                Ok((key.to_owned(), Some(to_value(&format!("{name}.{key}"), &values)?)))
            });
            return Ok(Replacement::Keys(keys.into_iter().collect::<Outcome<_>>()?));
        }
        if let Ok(coupling) = section.cast::<Coupling>() {
            let coupling = coupling.get().0;
            let keys = [("stiffness", coupling.stiffness), ("damping", coupling.damping)];
            return Ok(Replacement::Keys(numbers(&keys)));
        }
        let section = match section.getattr("to_dict") {
            Ok(convert) => convert.call0()?,
            Err(_) => section.clone(),
        };
        let Ok(keys) = section.cast::<PyMapping>() else {
            return Ok(Replacement::Value(to_value(name, &section)?));
        };
        let keys = keys.items()?.iter().map(|item| {
            let (key, value): (Bound<'_, PyAny>, Option<Bound<'_, PyAny>>) = item.extract()?;
            let key = key.str()?.to_string();
            let value = value.map(|value| to_value(&format!("{name}.{key}"), &value)).transpose()?;
            Ok((key, value))
        });
        Ok(Replacement::Keys(keys.collect::<Outcome<_>>()?))
    };
    let mut out = BTreeMap::new();
    // What the settings of a laboratory say about its network, where the network itself is not told otherwise.
    let mut of_the_network = BTreeMap::new();
    for (name, section) in sections.iter() {
        let name = name.str()?.to_string();
        match section.cast::<Network>() {
            Ok(network) if name == "network" => {
                let network = network.get().0;
                let (delay, computing) = (network.delay(), network.computing_time());
                let mut keys = numbers(&[("max_gap", network.max_gap())]);
                let each_way = |[forward, backward]: [f64; 2]| {
                    let ways = [("forward", forward), ("backward", backward)];
                    Value::Table(
                        ways.map(|(way, value)| (way.to_owned(), Value::Float(value))).into_iter().collect(),
                    )
                };
                keys.insert("delay".to_owned(), Some(each_way([delay.forward(), delay.backward()])));
                let [forward, backward] = network.jitters();
                let jitter =
                    if forward == backward { Value::Float(forward) } else { each_way([forward, backward]) };
                keys.insert("jitter".to_owned(), Some(jitter));
                out.insert(name, Replacement::Keys(keys));
                let controller =
                    numbers(&[("sample_period", network.sample_period()), ("computing_time", computing)]);
                out.entry("controller".to_owned()).or_insert(Replacement::Keys(controller));
            }
            _ => {
                let mut replacement = replacement(&name, &section)?;
                if let Replacement::Keys(keys) = &mut replacement
                    && section.is_instance_of::<LaboratorySettings>()
                {
                    let moved = ["jitter", "loss"].into_iter().filter_map(|key| keys.remove_entry(key));
                    of_the_network.extend(moved);
                }
                out.insert(name, replacement);
            }
        }
    }
    if !of_the_network.is_empty() {
        let network = out.entry("network".to_owned()).or_insert_with(|| Replacement::Keys(BTreeMap::new()));
        if let Replacement::Keys(keys) = network {
            for (key, value) in of_the_network {
                keys.entry(key).or_insert(value);
            }
        }
    }
    Ok(out)
}

/// The keys of a section of numbers in a study.
fn numbers(values: &[(&str, f64)]) -> BTreeMap<String, Option<Value>> {
    values.iter().map(|(key, value)| ((*key).to_owned(), Some(Value::Float(*value)))).collect()
}

/// The keys of a robot's section in a study: what was measured on the robot that it replaces is dropped.
fn robot_keys(robot: &telespring::Robot) -> BTreeMap<String, Option<Value>> {
    let row = |values: &[f64]| Some(Value::Array(values.iter().copied().map(Value::Float).collect()));
    let axes = robot.axes().iter().cloned().map(Value::String).collect();
    let kept =
        [("mass", row(robot.mass())), ("damping", row(robot.damping())), ("axes", Some(Value::Array(axes)))];
    let dropped =
        ["name", "coulomb", "ground_stiffness", "mass_sd", "damping_sd", "mass_damping_correlation"];
    let dropped = dropped.into_iter().map(|key| (key, None));
    kept.into_iter().chain(dropped).map(|(key, value)| (key.to_owned(), value)).collect()
}

/// The value of an option in a study, for an agent or a target written in Python, as Python holds it.
pub fn option<'py>(py: Python<'py>, value: &OptionValue) -> PyResult<Bound<'py, PyAny>> {
    Ok(match value {
        OptionValue::Boolean(value) => value.into_pyobject(py)?.to_owned().into_any(),
        OptionValue::Whole(value) => value.into_pyobject(py)?.into_any(),
        OptionValue::Number(value) => value.into_pyobject(py)?.into_any(),
        OptionValue::Text(text) => text.into_pyobject(py)?.into_any(),
        OptionValue::List(items) => {
            let items = items.iter().map(|item| option(py, item)).collect::<PyResult<Vec<_>>>()?;
            PyList::new(py, items)?.into_any()
        }
    })
}
