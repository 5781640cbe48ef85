//! The sections [robot1] and [robot2].

use super::entry::{Entry, PerAxis};
use super::reader::Reader;
use crate::error::Result;
use crate::model::Robot;
use crate::quantity::{self, Quantity};

/// How far a robot's identified parameters may be off, per axis.
///
/// Mass and damping of one axis are normal with these standard deviations and this correlation; axes and
/// robots are independent.
#[derive(Debug, Clone, PartialEq)]
pub struct Uncertainty {
    /// Standard deviation of the mass, kg.
    pub mass_sd: Vec<f64>,
    /// Standard deviation of the damping, N·s/m.
    pub damping_sd: Vec<f64>,
    /// Correlation of the two, −1 to 1.
    pub correlation: Vec<f64>,
}

/// What the file says of a robot beside its mass and damping.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct RobotSection {
    pub name: Option<String>,
    pub coulomb: Vec<f64>,
    pub uncertainty: Option<Uncertainty>,
}

/// The sections of both robots, which share their axes.
pub(super) fn robots(reader: &Reader<'_>) -> Result<[(Robot, RobotSection); 2]> {
    let named = [named(reader, "robot1")?, named(reader, "robot2")?];
    let listed = [listed(reader, "robot1")?, listed(reader, "robot2")?];
    let of = |own: usize, section: &str| {
        // A robot of single numbers has the axes of its partner, and names given once hold for both.
        let other = 1 - own;
        let count = named[own].as_ref().map(Vec::len).or(listed[own]);
        let count = count.or(named[other].as_ref().map(Vec::len)).or(listed[other]).unwrap_or(1);
        let lent = named[other].as_ref().filter(|names| names.len() == count);
        robot(reader, section, count, named[own].as_ref().or(lent).cloned())
    };
    Ok([of(0, "robot1")?, of(1, "robot2")?])
}

/// The names of a robot's axes, where it gives them.
fn named(reader: &Reader<'_>, section: &str) -> Result<Option<Vec<String>>> {
    reader.get(section, "axes").map(|entry| entry.texts()).transpose()
}

/// The number of axes that a robot's lists tell, where it has any.
fn listed(reader: &Reader<'_>, section: &str) -> Result<Option<usize>> {
    for (key, quantity) in [("mass", quantity::MASS), ("damping", quantity::DAMPING)] {
        let Some(entry) = reader.get(section, key) else { continue };
        if let Some(count) = entry.per_axis(quantity, false)?.count() {
            return Ok(Some(count));
        }
    }
    Ok(None)
}

pub(super) fn robot(
    reader: &Reader<'_>,
    section: &str,
    count: usize,
    axes: Option<Vec<String>>,
) -> Result<(Robot, RobotSection)> {
    let mass = reader.need(section, "mass", "mass = 1.0 (kg)")?;
    let damping = reader.need(section, "damping", "damping = 5.0 (N·s/m)")?;
    let masses = mass.per_axis(quantity::MASS, false)?;
    let dampings = damping.per_axis(quantity::DAMPING, false)?;
    let name = reader.get(section, "name").map(|entry| entry.text()).transpose()?;
    for (entry, values) in [(&mass, &masses), (&damping, &dampings)] {
        check_count(entry, values, count)?;
    }
    let robot = Robot::new(lows(&masses, count), lows(&dampings, count), axes)
        .map_err(|error| reader.place(section, error))?;
    let coulomb = zero_or_each(reader, section, "coulomb", quantity::COULOMB, count)?;
    Ok((robot, RobotSection { name, coulomb, uncertainty: uncertainty(reader, section, count)? }))
}

fn uncertainty(reader: &Reader<'_>, section: &str, count: usize) -> Result<Option<Uncertainty>> {
    const CORRELATION: &str = "mass_damping_correlation";
    let mass_sd = zero_or_each(reader, section, "mass_sd", quantity::MASS_SD, count)?;
    let damping_sd = zero_or_each(reader, section, "damping_sd", quantity::DAMPING_SD, count)?;
    let correlation = zero_or_each(reader, section, CORRELATION, quantity::CORRELATION, count)?;
    if let Some(entry) = reader.get(section, CORRELATION) {
        let certain = |axis: usize| mass_sd[axis] == 0.0 || damping_sd[axis] == 0.0;
        if (0..count).any(|axis| correlation[axis] != 0.0 && certain(axis)) {
            return Err(entry.refuse(
                "a correlation needs mass_sd and damping_sd above 0 on the same axis",
                "Add both standard deviations, or remove the correlation.",
            ));
        }
    }
    let certain = mass_sd.iter().chain(&damping_sd).all(|&sd| sd == 0.0);
    Ok((!certain).then_some(Uncertainty { mass_sd, damping_sd, correlation }))
}

fn lows(values: &PerAxis, count: usize) -> Vec<f64> {
    values.spread(count).iter().map(|span| span.low).collect()
}

/// One value per axis, 0 where the key is not given.
fn zero_or_each(
    reader: &Reader<'_>,
    section: &str,
    key: &str,
    quantity: Quantity,
    count: usize,
) -> Result<Vec<f64>> {
    let Some(entry) = reader.get(section, key) else { return Ok(vec![0.0; count]) };
    let values = entry.per_axis(quantity, false)?;
    check_count(&entry, &values, count)?;
    // +0: a minus sign before a zero means nothing and would not be written
    Ok(lows(&values, count).into_iter().map(|value| value + 0.0).collect())
}

pub(super) fn check_count(entry: &Entry<'_, '_>, values: &PerAxis, count: usize) -> Result<()> {
    match values.count() {
        Some(got) if got != count => Err(entry.refuse(
            format!("one value per axis is needed, that is {count}, and here are {got}"),
            "Give one value per axis, or a single number for all of them.",
        )),
        _ => Ok(()),
    }
}
