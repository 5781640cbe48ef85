//! Reads and writes study files: the single validator for Rust, Python and the live program.
//!
//! ```toml
//! name = "Two H-MANs"
//!
//! [robot1]                      # and [robot2]
//! name = "H-MAN 1"              # optional
//! axes = ["x", "y"]             # optional: x, y, z, axis4, …
//! mass = [0.8334, 1.0649]       # kg: one number for all axes, or one per axis
//! damping = [7.7257, 10.1168]   # N·s/m
//!
//! [operator1]                   # and [operator2]: what holds the handle; without it the handle is free
//! mass = 1.5                    # kg, default 0
//! damping = [4, 6]              # N·s/m, default 0
//! stiffness = {min = 0, max = 300}   # N/m, default 0; any of the three may be a range
//!
//! [coupling]
//! stiffness = 71.2              # N/m, the virtual spring
//! damping = 0                   # N·s/m, a damper in parallel, default 0
//!
//! [network]
//! delay = 0.05                  # s, one way; or {forward = 0.04, backward = 0.06}
//! jitter = 0.01                 # s, the maximum additional delay of a packet, default 0
//! max_gap = 0.02                # s, the longest wait for a newer sample, default 0
//!
//! [controller]
//! sample_period = 0.001         # s, default 0: a continuous controller
//! computing_time = 0.0002       # s, default 0
//! ```
//!
//! All other keys describe the rehearsal and default to the paper's experiment: `[robot1]` and `[robot2]` may
//! add `coulomb`, `mass_sd`, `damping_sd` and `mass_damping_correlation`, and there are the sections
//! `[arm1]`, `[arm2]`, `[agent1]`, `[agent2]`, `[task]`, `[laboratory]` and `[protocol]`. `docs/study-file.md` lists
//! every key with its meaning, unit, range and default.

mod entry;
mod keys;
mod laboratory;
mod network;
mod operator;
mod protocol;
mod python;
mod reader;
mod rehearsal;
mod replace;
mod robot;
mod robot_file;
mod section;
mod source;
mod writer;

use crate::criteria::paper_critical_stiffness;
use crate::error::Result;
use crate::model::{Delay, Dyad, hman};
use crate::quantity;
use crate::verdicts::{Network, OperatorRange};
use network::read_network;
use operator::read_operator;
use reader::Reader;
use robot::{RobotSection, read_robots};
use source::Source;

pub use laboratory::{AgentChoice, Setup, Task};
pub use protocol::{Conditions, ProtocolChoice};
pub use python::{OptionValue, PythonObject};
pub use replace::Replacement;
pub use robot::Uncertainty;
pub use robot_file::{RobotFile, RobotRecord};
pub use toml::{Table, Value};

/// The virtual spring and the damper in parallel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coupling {
    /// Stiffness, N/m.
    pub stiffness: f64,
    /// Damping, N·s/m.
    pub damping: f64,
}

/// The content of a study file: two robots, their operators, the coupling and the network.
///
/// # Examples
///
/// ```
/// use telespring::study::Study;
/// let study = Study::from_toml(
///     "robot1 = {mass = 1, damping = 5}\n\
///      robot2 = {mass = 1, damping = 5}\n\
///      coupling.stiffness = 20\n\
///      network.delay = 0.05",
/// )?;
/// assert_eq!(study.coupling().stiffness, 20.0);
/// assert_eq!(Study::from_toml(&study.to_toml())?, study);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Study {
    name: String,
    robots: [RobotSection; 2],
    dyad: Dyad,
    operator_ranges: Option<[OperatorRange; 2]>,
    stiffness: f64,
    network: Network,
    setup: Setup,
    protocol: ProtocolChoice,
    holders: NamedHolders,
}

/// Whether a study file has a section of an arm or an agent. Studies that say the same are equal whether
/// they write it down or leave it to the defaults.
#[derive(Debug, Clone, Copy)]
struct NamedHolders(bool);

impl PartialEq for NamedHolders {
    /// Always true: whether a study names its holders does not make it another.
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Study {
    /// The paper's two H-MAN robots at its condition 2K_xy (printed 71 N/m) and Δ_xy (167 ms) with free
    /// handles and continuous controllers, as in its Fig. 5(h), and its whole experiment.
    pub fn paper() -> Self {
        let dyad = hman();
        Self {
            name: "Du, Kulkarni, Kager and Campolo: two H-MANs".to_owned(),
            robots: ["H-MAN 1", "H-MAN 2"].map(|name| RobotSection {
                name: Some(name.to_owned()),
                coulomb: vec![0.0; 2],
                uncertainty: None,
            }),
            stiffness: paper_stiffness(&dyad),
            dyad,
            operator_ranges: None,
            network: Network::constant(Delay::each_way(0.167).expect("the paper's delay is valid")),
            setup: Setup::paper(),
            protocol: ProtocolChoice::paper(),
            holders: NamedHolders(false),
        }
    }

    /// Reads a study from TOML text.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`](crate::InvalidInput) if the text is not TOML, a key is unknown or missing, a value
    /// has the wrong type or is out of range, or axes do not match. It gives the dotted field, the value, the
    /// allowed values, the nearest remedy and the line. No text causes a panic.
    ///
    /// # Examples
    ///
    /// ```
    /// let refused = telespring::study::Study::from_toml("[network]\ndelay = 167").unwrap_err();
    /// assert_eq!(refused.field, "robot1.mass");
    /// ```
    pub fn from_toml(text: &str) -> Result<Self> {
        Self::read(Source::file(text))
    }

    /// The study from a file's source.
    fn read(source: Source<'_>) -> Result<Self> {
        let reader = Reader::new(source)?;
        let [(robot1, section1), (robot2, section2)] = read_robots(&reader)?;
        let axes = robot1.axes().len();
        let ranges = [read_operator(&reader, "operator1", axes)?, read_operator(&reader, "operator2", axes)?];
        let single = ranges.iter().all(|range| range.low() == range.high());
        let operators = ranges.each_ref().map(OperatorRange::middle);
        let stiffness = reader.require("coupling", "stiffness", "N/m", "20.0")?;
        let stiffness = stiffness.number(quantity::STIFFNESS, "a number")?;
        let damping = reader.number_or_zero("coupling", "damping", quantity::DAMPING)?;
        let dyad = Dyad::new(robot1, robot2, Some(operators), damping).map_err(|mut error| {
            // Only different axes are left to reject; the field is robot2.axes already.
            error.field = error.field.trim_start_matches("robot2.").to_owned();
            reader.place("robot2", error)
        })?;
        let study = Self {
            name: reader.name()?.unwrap_or_else(|| UNNAMED.to_owned()),
            robots: [section1, section2],
            dyad,
            operator_ranges: (!single).then_some(ranges),
            stiffness,
            network: read_network(&reader)?,
            setup: laboratory::read_setup(&reader)?,
            protocol: protocol::read_protocol(&reader)?,
            holders: NamedHolders(HOLDERS.iter().any(|section| reader.has(section))),
        };
        study.check_rehearsal(&reader)?;
        Ok(study)
    }

    /// Writes the study as TOML text that reads back to the same study.
    pub fn to_toml(&self) -> String {
        writer::to_toml(self)
    }

    /// The name of the study.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The names of the study's robots, if given.
    pub fn robot_names(&self) -> [Option<&str>; 2] {
        self.robots.each_ref().map(|robot| robot.name.as_deref())
    }

    /// The study's dyad; for operator ranges with the middle of each range.
    pub fn dyad(&self) -> &Dyad {
        &self.dyad
    }

    /// The study's ranges of both operators, if any value is a range.
    pub fn operator_ranges(&self) -> Option<&[OperatorRange; 2]> {
        self.operator_ranges.as_ref()
    }

    /// The study's coupling: spring and damper.
    pub fn coupling(&self) -> Coupling {
        Coupling { stiffness: self.stiffness, damping: self.dyad.coupling_damping() }
    }

    /// The study's network and the timing of its controllers.
    pub fn network(&self) -> &Network {
        &self.network
    }

    /// The study's uncertainty of each robot's parameters; `None` if they are certain.
    pub fn uncertainty(&self) -> [Option<&Uncertainty>; 2] {
        self.robots.each_ref().map(|robot| robot.uncertainty.as_ref())
    }
}

/// All keys of a study file as `section.key`, in order, `name` first.
///
/// # Examples
///
/// ```
/// assert!(telespring::study::keys().contains(&"network.delay".to_owned()));
/// ```
pub fn keys() -> Vec<String> {
    let dotted = keys::SECTIONS
        .iter()
        .flat_map(|(section, keys)| keys.all().into_iter().map(move |key| format!("{section}.{key}")));
    std::iter::once("name".to_owned()).chain(dotted).collect()
}

/// The paper's 2K_xy: twice Eq. 5 on the x axis, N/m.
fn paper_stiffness(hman: &Dyad) -> f64 {
    let critical = hman.axis(0).and_then(|x| paper_critical_stiffness(&x));
    2.0 * critical.expect("the paper's criterion applies to the paper's robots")
}

/// The sections that say what holds the handles in a rehearsal.
const HOLDERS: [&str; 4] = ["arm1", "arm2", "agent1", "agent2"];
const UNNAMED: &str = "unnamed study";
