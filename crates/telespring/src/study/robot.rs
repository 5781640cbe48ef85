//! The sections `[robot1]` and `[robot2]`.

use super::entry::{Entry, PerAxis};
use super::reader::Reader;
use crate::error::Result;
use crate::model::Robot;
use crate::quantity::{self, Quantity};

/// The uncertainty of a robot's identified parameters, per axis.
///
/// Mass and damping of one axis are jointly normal with these standard deviations and this correlation;
/// axes and robots are independent.
#[derive(Debug, Clone, PartialEq)]
pub struct Uncertainty {
    /// Standard deviation of the mass, kg.
    pub mass_sd: Vec<f64>,
    /// Standard deviation of the damping, N·s/m.
    pub damping_sd: Vec<f64>,
    /// Correlation of mass and damping, −1 to 1.
    pub correlation: Vec<f64>,
}

/// The content of a robot section besides mass and damping.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct RobotSection {
    pub name: Option<String>,
    pub coulomb: Vec<f64>,
    /// Stiffness of a spring between the robot and the ground, N/m per axis.
    pub ground_stiffness: Vec<f64>,
    pub uncertainty: Option<Uncertainty>,
}

/// Reads the sections of both robots, which have the same axes.
pub(super) fn read_robots(reader: &Reader<'_>) -> Result<[(Robot, RobotSection); 2]> {
    let named = [read_axis_names(reader, "robot1")?, read_axis_names(reader, "robot2")?];
    let listed = [axis_count_from_lists(reader, "robot1")?, axis_count_from_lists(reader, "robot2")?];
    let of = |own: usize, section: &str| {
        // A robot with single numbers has the axes of its partner; names given once hold for both.
        let other = 1 - own;
        let count = named[own].as_ref().map(Vec::len).or(listed[own]);
        let count = count.or(named[other].as_ref().map(Vec::len)).or(listed[other]).unwrap_or(1);
        let lent = named[other].as_ref().filter(|names| names.len() == count);
        read_robot(reader, section, count, named[own].as_ref().or(lent).cloned())
    };
    Ok([of(0, "robot1")?, of(1, "robot2")?])
}

/// Reads the names of a robot's axes, if given.
fn read_axis_names(reader: &Reader<'_>, section: &str) -> Result<Option<Vec<String>>> {
    reader.get(section, "axes").map(|entry| entry.text_list()).transpose()
}

/// The number of axes in a robot's lists, if it has any.
fn axis_count_from_lists(reader: &Reader<'_>, section: &str) -> Result<Option<usize>> {
    for (key, quantity) in [("mass", quantity::MASS), ("damping", quantity::DAMPING)] {
        let Some(entry) = reader.get(section, key) else { continue };
        if let Some(count) = entry.per_axis(quantity, false)?.count() {
            return Ok(Some(count));
        }
    }
    Ok(None)
}

/// Reads one robot with the given number of axes.
pub(super) fn read_robot(
    reader: &Reader<'_>,
    section: &str,
    count: usize,
    axes: Option<Vec<String>>,
) -> Result<(Robot, RobotSection)> {
    let mass = reader.require(section, "mass", "kg", "1.0")?;
    let damping = reader.require(section, "damping", "N·s/m", "5.0")?;
    let masses = mass.per_axis(quantity::MASS, false)?;
    let dampings = damping.per_axis(quantity::DAMPING, false)?;
    let name = reader.get(section, "name").map(|entry| entry.text()).transpose()?;
    for (entry, values) in [(&mass, &masses), (&damping, &dampings)] {
        check_axis_count(entry, values, count)?;
    }
    let robot = Robot::new(lower_ends(&masses, count), lower_ends(&dampings, count), axes)
        .map_err(|error| reader.place(section, error))?;
    let coulomb = read_per_axis_or_zero(reader, section, "coulomb", quantity::COULOMB, count)?;
    let spring = read_per_axis_or_zero(reader, section, "ground_stiffness", quantity::ROBOT_SPRING, count)?;
    let uncertainty = read_uncertainty(reader, section, count)?;
    Ok((robot, RobotSection { name, coulomb, ground_stiffness: spring, uncertainty }))
}

/// Reads the standard deviations and correlations of a robot.
fn read_uncertainty(reader: &Reader<'_>, section: &str, count: usize) -> Result<Option<Uncertainty>> {
    const CORRELATION: &str = "mass_damping_correlation";
    let mass_sd = read_per_axis_or_zero(reader, section, "mass_sd", quantity::MASS_SD, count)?;
    let damping_sd = read_per_axis_or_zero(reader, section, "damping_sd", quantity::DAMPING_SD, count)?;
    let correlation = read_per_axis_or_zero(reader, section, CORRELATION, quantity::CORRELATION, count)?;
    if let Some(entry) = reader.get(section, CORRELATION) {
        let certain = |axis: usize| mass_sd[axis] == 0.0 || damping_sd[axis] == 0.0;
        if (0..count).any(|axis| correlation[axis] != 0.0 && certain(axis)) {
            return Err(entry.reject(
                "a correlation needs mass_sd and damping_sd above 0 on the same axis",
                "Add both standard deviations, or remove the correlation.",
            ));
        }
    }
    let certain = mass_sd.iter().chain(&damping_sd).all(|&sd| sd == 0.0);
    Ok((!certain).then_some(Uncertainty { mass_sd, damping_sd, correlation }))
}

/// The lower ends of a robot's value ranges on all axes.
fn lower_ends(values: &PerAxis, count: usize) -> Vec<f64> {
    values.spread(count).iter().map(|span| span.low).collect()
}

/// Reads one value per axis of a robot; 0 if the key is missing.
fn read_per_axis_or_zero(
    reader: &Reader<'_>,
    section: &str,
    key: &str,
    quantity: Quantity,
    count: usize,
) -> Result<Vec<f64>> {
    let Some(entry) = reader.get(section, key) else { return Ok(vec![0.0; count]) };
    let values = entry.per_axis(quantity, false)?;
    check_axis_count(&entry, &values, count)?;
    // +0 removes the sign of −0, which has no meaning and would not be written.
    Ok(lower_ends(&values, count).into_iter().map(|value| value + 0.0).collect())
}

/// Checks that a robot's list has one value per axis.
pub(super) fn check_axis_count(entry: &Entry<'_, '_>, values: &PerAxis, count: usize) -> Result<()> {
    match values.count() {
        Some(got) if got != count => Err(entry.reject(
            format!("one value per axis is required: {count}, not {got}"),
            "Give one value per axis, or a single number for all of them.",
        )),
        _ => Ok(()),
    }
}
