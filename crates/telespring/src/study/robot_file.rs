//! A robot file, as `telespring identify` writes it.

use toml::{Table, Value};

use super::other_files::{remedy_for_table, section_of_study};

use crate::error::{InvalidInput, Result};

/// The key of a robot's spring to the ground.
const SPRING: &str = "ground_stiffness";

/// A robot file: the section `[robot]` with the keys of `[robot1]` in a study, and as a record `[identification]`.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotFile {
    name: String,
    robot: Table,
    identification: Table,
}

/// What identification recorded in addition to a robot's parameters.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RobotRecord {
    /// False if the axes are coupled by inertia; `None` if that is unknown.
    pub independent: Option<bool>,
    /// Reservations about the estimates, as sentences.
    pub warnings: Vec<String>,
    /// How many logs the estimates are from; `None` if that is unknown.
    pub logs: Option<usize>,
    /// Stiffness of a spring between the robot and the ground, N/m per axis; `None` if none was found.
    pub stiffness: Option<Vec<f64>>,
}

impl RobotFile {
    /// Reads a robot file; messages call it `name`.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if the text is not a robot file. The values of the robot are checked by the study that
    /// it is put into.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::study::{RobotFile, Study};
    /// let file = RobotFile::from_toml("[robot]\nmass = [0.84, 1.07]\ndamping = 7.7", "left.toml")?;
    /// let study = Study::paper().with_robot(0, &file)?;
    /// assert_eq!(study.dyad().robots()[0].mass(), [0.84, 1.07]);
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn from_toml(text: &str, name: &str) -> Result<Self> {
        let mut tables: Table = text.parse().map_err(|error: toml::de::Error| {
            let line = 1 + text[..error.span().map_or(0, |span| span.start)].matches('\n').count();
            let reason = error.message().trim().replace('\n', ", ");
            InvalidInput::new(
                name,
                "text",
                format!("a robot file is TOML text, and this is not: {reason} (line {line})"),
                remedy_for_table(text).unwrap_or("Correct that line, or check that this is the robot file."),
            )
        })?;
        let robot = tables.remove("robot");
        let identification = tables.remove("identification");
        let refuse = |value: String, remedy: &str| {
            let allowed = "a robot file has only the sections [robot] and [identification]";
            Err(InvalidInput::new(name, value, allowed, remedy))
        };
        if let Some(section) = section_of_study(tables.keys()) {
            return refuse(
                format!("[{section}]"),
                "This is a study: give it as the study, without --robot. Its robots are in it.",
            );
        }
        if let Some(other) = tables.keys().next() {
            return refuse(format!("[{other}]"), "Remove it, or check that this is the robot file.");
        }
        let Some(Value::Table(robot)) = robot else {
            return refuse(
                "no section [robot]".to_owned(),
                "Write [robot] on a line of its own, and mass and damping below it.",
            );
        };
        let identification = match identification {
            Some(Value::Table(record)) => record,
            _ => Table::new(),
        };
        Ok(Self { name: name.to_owned(), robot, identification })
    }

    /// The name of the robot file in messages.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The keys of the robot in the robot file as a study has them, with the spring that identification found.
    pub(super) fn robot(&self) -> Result<Table> {
        let mut robot = self.robot.clone();
        if let Some(springs) = self.record()?.stiffness {
            robot.entry(SPRING).or_insert_with(|| Value::from(springs));
        }
        Ok(robot)
    }

    /// Names the file in the refusal of a robot that a study has as `section`.
    pub(super) fn sign(&self, refusal: &mut InvalidInput, section: &str) {
        let (of_study, of_file) = (format!("[{section}]"), "[robot]");
        refusal.allowed = refusal.allowed.replace(&of_study, of_file);
        let is_recorded = refusal.field.contains(SPRING) && !self.robot.contains_key(SPRING);
        let place = if is_recorded { "stiffness in [identification]" } else { of_file };
        refusal.remedy =
            format!("{} See {place} in {}.", refusal.remedy.replace(&of_study, of_file), self.name);
    }

    /// What the section `[identification]` of a robot file records; nothing where it is missing.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if a value has the wrong type.
    pub fn record(&self) -> Result<RobotRecord> {
        let refuse = |key: &str, value: &Value, allowed: &str| {
            let remedy = format!(
                "Leave it as `telespring identify --out` wrote it. See [identification] in {}.",
                self.name
            );
            InvalidInput::new(format!("identification.{key}"), value, allowed, remedy)
        };
        let independent = match self.identification.get("axes_independent") {
            None => None,
            Some(Value::Boolean(independent)) => Some(*independent),
            Some(other) => return Err(refuse("axes_independent", other, "true or false is required")),
        };
        let warnings = match self.identification.get("warnings") {
            None => Vec::new(),
            Some(value) => value
                .as_array()
                .and_then(|items| items.iter().map(|item| item.as_str().map(str::to_owned)).collect())
                .ok_or_else(|| refuse("warnings", value, "a list of strings is required"))?,
        };
        let logs = match self.identification.get("logs") {
            None => None,
            Some(value) => Some(
                value
                    .as_integer()
                    .and_then(|count| usize::try_from(count).ok().filter(|count| *count > 0))
                    .ok_or_else(|| refuse("logs", value, "a number of logs, 1 or more, is required"))?,
            ),
        };
        let stiffness = match self.identification.get("stiffness") {
            None => None,
            Some(value) => Some(
                value
                    .as_array()
                    .and_then(|items| items.iter().map(|item| item.as_float()).collect::<Option<Vec<f64>>>())
                    .filter(|items| items.iter().all(|item| item.is_finite() && *item >= 0.0))
                    .ok_or_else(|| refuse("stiffness", value, "one stiffness in N/m per axis is required"))?,
            ),
        };
        Ok(RobotRecord { independent, warnings, logs, stiffness })
    }
}
