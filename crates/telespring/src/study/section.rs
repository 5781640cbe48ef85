//! One section of a study, read on its own.

use toml::{Table, Value};

use super::adversary::read_adversary;
use super::laboratory::{self, AgentChoice, Setup, Task};
use super::reader::Reader;
use super::replace::unwritable;
use super::robot::read_robot;
use super::session::read_session;
use super::source::Source;
use crate::error::{InvalidInput, Result};
use crate::rig::{Adversary, Arm, Handle};
use crate::session::Architecture;

impl AgentChoice {
    /// Reads an agent from a table with the keys of the section `[agent1]`; without a kind it is a skilled one.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`](crate::InvalidInput) if a value is refused, with a field such as `agent.stiffness`.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::study::AgentChoice;
    /// let table = "kind = \"skilled\"\nstiffness = 90.0".parse().unwrap();
    /// let agent = AgentChoice::from_table(&table)?;
    /// assert_eq!(agent, AgentChoice::Skilled { stiffness: 90.0, damping: 0.0 });
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn from_table(table: &Table) -> Result<Self> {
        let [default, _] = Setup::paper().agents;
        read_section("agent1", "agent", table, |reader| laboratory::read_agent(reader, "agent1", default))
    }
}

impl Arm {
    /// Reads an arm from a table with the keys of the section `[arm1]`; without a kind it is massless.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`](crate::InvalidInput) if a value is refused, with a field such as `arm.link_mass[1]`.
    pub fn from_table(table: &Table) -> Result<Self> {
        let arm = read_section("arm1", "arm", table, |reader| laboratory::read_arm(reader, "arm1"))?;
        arm.check().map_err(|refusal| refusal.within("arm"))?;
        Ok(arm)
    }
}

impl Task {
    /// Reads a task from a table with the keys of the section `[task]`; without a kind it is the figure eight.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`](crate::InvalidInput) if a value is refused, with a field such as `task.amplitude`.
    pub fn from_table(table: &Table) -> Result<Self> {
        read_section("task", "task", table, |reader| laboratory::read_task(reader, Setup::paper().task))
    }
}

impl Architecture {
    /// Reads an architecture from a table with the keys of the section `[session]`; without keys it is the bare spring.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if a value is refused, with a field such as `session.strategy.share`.
    pub fn from_table(table: &Table) -> Result<Self> {
        read_section("session", "session", table, read_session)
    }
}

impl Handle {
    /// Reads the handle of a planar robot from a table with the keys of the section `[robot1]`.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`](crate::InvalidInput) if a value is refused, with a field such as `handle.coulomb`.
    pub fn from_table(table: &Table) -> Result<Self> {
        let (robot, section) =
            read_section("robot1", "handle", table, |reader| read_robot(reader, "robot1", 2, None))?;
        let pair = |values: &[f64]| [values[0], values[1]];
        Ok(Self { mass: pair(robot.mass()), damping: pair(robot.damping()), coulomb: pair(&section.coulomb) })
    }
}

impl Adversary {
    /// Reads an adversary from a table with the keys of `network.adversary`.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if a value is refused, with a field such as `adversary.memory`.
    pub fn from_table(table: &Table) -> Result<Self> {
        let network = [("adversary".to_owned(), Value::Table(table.clone()))].into_iter().collect();
        let read = read_section("network", "network", &network, |reader| {
            let entry = reader.get("network", "adversary").expect("the section has this key only");
            let adversary = read_adversary(&entry)?;
            adversary.check().map_err(|refusal| refusal.within("network.adversary"))?;
            Ok(adversary)
        });
        read.map_err(|refusal| InvalidInput {
            field: refusal.field.trim_start_matches("network.").to_owned(),
            ..refusal
        })
    }
}

/// Reads the table as the section `section`; refusals call it `name`.
fn read_section<T>(
    section: &str,
    name: &str,
    table: &Table,
    read: impl FnOnce(&Reader<'_>) -> Result<T>,
) -> Result<T> {
    let tables: Table = [(section.to_owned(), Value::Table(table.clone()))].into_iter().collect();
    let text = toml::to_string(&tables).map_err(|error| unwritable(&error))?;
    // What a study may contain is checked when the section becomes part of one.
    let mut source = Source::generated(&text);
    source.allows_unusual = true;
    Reader::new(source, None).and_then(|reader| read(&reader)).map_err(|mut refusal| {
        let (of_study, alone) = (format!("[{section}]"), format!("[{name}]"));
        if let Some(rest) = refusal.field.strip_prefix(section) {
            refusal.field = format!("{name}{rest}");
        }
        refusal.allowed = refusal.allowed.replace(&of_study, &alone);
        refusal.remedy = refusal.remedy.replace(&of_study, &alone);
        refusal
    })
}
