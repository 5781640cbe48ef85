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
//! loss = 0.01                   # probability that a packet is lost in the rehearsal, default 0
//! max_gap = 0.02                # s, the longest wait for a newer sample, default 0
//! playout_buffer = true         # a buffer makes the delay constant, default false
//!
//! [controller]
//! sample_period = 0.001         # s, the default; 0 is a continuous controller
//! computing_time = 0.0002       # s, default 0
//! ```
//!
//! All other keys describe the rehearsal and default to the paper's experiment: `[robot1]` and `[robot2]` may
//! add `coulomb`, `mass_sd`, `damping_sd` and `mass_damping_correlation`, and there are the sections
//! `[arm1]`, `[arm2]`, `[agent1]`, `[agent2]`, `[task]`, `[laboratory]`, `[protocol]`, `[session]` and `[comparison]`. `docs/study-file.md` lists
//! every key with its meaning, unit, range and default.

mod adversary;
mod ages;
mod changes;
mod comparison;
mod emulated_network;
mod entry;
mod guard;
mod keys;
mod laboratory;
mod live;
mod network;
mod operator;
mod other_files;
mod protocol;
mod python;
mod reader;
mod rehearsal;
mod replace;
mod robot;
mod robot_file;
mod section;
mod session;
mod source;
mod way_ages;
mod writer;

use crate::criteria::paper_critical_stiffness;
use crate::error::{InvalidInput, Result};
use crate::model::{Delay, Dyad, hman};
use crate::quantity;
use crate::session::Architecture;
use crate::verdicts::{Network, OperatorRange};
use changes::Changes;
use emulated_network::{MovedKeys, read_emulated_network};
use network::read_network;
use operator::{read_operator, with_spring};
use reader::Reader;
use robot::{RobotSection, read_robots};
use source::Source;

pub use ages::{AgeSource, JudgedNetwork, Unjudged};
pub use comparison::{ComparedNetwork, ComparisonChoice};
pub use emulated_network::{EmulatedNetwork, TraceFile};
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
/// assert_eq!(study.coupling()?.stiffness, 20.0);
/// assert_eq!(Study::from_toml(&study.to_toml())?, study);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Study {
    name: String,
    robots: [RobotSection; 2],
    dyad: Dyad,
    /// What the sections of the operators say.
    hands: [OperatorRange; 2],
    /// The hands together with the robots' own springs, if any value is a range.
    operator_ranges: Option<[OperatorRange; 2]>,
    stiffness: Option<f64>,
    /// False if the delay of the network is 0 only because none is given.
    has_delay: bool,
    network: Network,
    /// Whether both sides play the samples out at a constant age.
    has_playout_buffer: bool,
    emulated_network: EmulatedNetwork,
    setup: Setup,
    protocol: ProtocolChoice,
    session: Architecture,
    comparison: ComparisonChoice,
    allows_unusual: bool,
    holders: NamedHolders,
    moved_keys: MovedKeys,
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
                ground_stiffness: vec![0.0; 2],
                uncertainty: None,
            }),
            stiffness: Some(paper_stiffness(&dyad)),
            has_delay: true,
            hands: dyad
                .operators()
                .each_ref()
                .map(|free| OperatorRange::new(free.clone(), free.clone()).expect("one operator is a range")),
            dyad,
            operator_ranges: None,
            network: Network::constant(Delay::each_way(0.167).expect("the paper's delay is valid")),
            has_playout_buffer: false,
            emulated_network: EmulatedNetwork::ideal(),
            setup: Setup::paper(),
            protocol: ProtocolChoice::paper(),
            session: Architecture::default(),
            comparison: ComparisonChoice::default(),
            allows_unusual: false,
            holders: NamedHolders(false),
            moved_keys: MovedKeys::default(),
        }
    }

    /// Reads a study from TOML text.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if the text is not TOML, a key is unknown or missing, a value
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
        Self::read(Source::file(text), None)
    }

    /// The study from a file's source.
    fn read(source: Source<'_>, changes: Option<&Changes>) -> Result<Self> {
        let reader = Reader::new(source, changes)?;
        let [(robot1, section1), (robot2, section2)] = read_robots(&reader)?;
        let axes = robot1.axes().len();
        let hands = [read_operator(&reader, "operator1", axes)?, read_operator(&reader, "operator2", axes)?];
        let together = |i: usize, section: &RobotSection| {
            with_spring(&hands[i], &section.ground_stiffness)
                .map_err(|error| reader.place(&format!("operator{}", i + 1), error))
        };
        let ranges = [together(0, &section1)?, together(1, &section2)?];
        let single = ranges.iter().all(|range| range.low() == range.high());
        let operators = ranges.each_ref().map(OperatorRange::middle);
        let stiffness = reader.get("coupling", "stiffness");
        let stiffness = stiffness.map(|entry| entry.number(quantity::STIFFNESS, "a number")).transpose()?;
        let damping = reader.number_or_zero("coupling", "damping", quantity::DAMPING)?;
        let dyad = Dyad::new(robot1, robot2, Some(operators), damping).map_err(|mut error| {
            // Only different axes are left to reject; the field is robot2.axes already.
            error.field = error.field.trim_start_matches("robot2.").to_owned();
            reader.place("robot2", error)
        })?;
        let emulated_network = read_emulated_network(&reader)?;
        let study = Self {
            name: reader.name()?.unwrap_or_else(|| UNNAMED.to_owned()),
            robots: [section1, section2],
            dyad,
            hands,
            operator_ranges: (!single).then_some(ranges),
            stiffness,
            has_delay: reader.get("network", "delay").is_some(),
            network: read_network(&reader, emulated_network.model.jitters())?,
            has_playout_buffer: reader
                .get("network", "playout_buffer")
                .map_or(Ok(false), |entry| entry.boolean())?,
            emulated_network,
            setup: laboratory::read_setup(&reader)?,
            protocol: protocol::read_protocol(&reader)?,
            session: session::read_session(&reader)?,
            comparison: comparison::read_comparison(&reader)?,
            allows_unusual: reader.allows_unusual(),
            holders: NamedHolders(HOLDERS.iter().any(|section| reader.has(section))),
            moved_keys: MovedKeys::of(&reader),
        };
        study.check_buffer().map_err(|error| reader.with_line_of_field(error))?;
        study.check_rehearsal(&reader)?;
        study.check_dampers(&reader)?;
        study.check_comparison(&reader)?;
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

    /// The stiffness of a spring between each robot and the ground, N/m per axis; 0 without one.
    ///
    /// Dyad and operator ranges include it: the equations have one place for it and the operator's stiffness.
    pub fn ground_stiffness(&self) -> [&[f64]; 2] {
        self.robots.each_ref().map(|robot| robot.ground_stiffness.as_slice())
    }

    /// The study's dyad; for operator ranges with the middle of each range.
    pub fn dyad(&self) -> &Dyad {
        &self.dyad
    }

    /// The study's ranges of both operators, if any value is a range.
    pub fn operator_ranges(&self) -> Option<&[OperatorRange; 2]> {
        self.operator_ranges.as_ref()
    }

    /// What the study's sections of the operators say: the ranges of both hands, without the robots' own springs.
    pub fn hands(&self) -> &[OperatorRange; 2] {
        &self.hands
    }

    /// Whether the study gives the stiffness of the spring; one that asks for limits does not.
    pub fn has_stiffness(&self) -> bool {
        self.stiffness.is_some()
    }

    /// Whether the study gives the delay of the network.
    pub fn has_delay(&self) -> bool {
        self.has_delay
    }

    /// Whether the study promises a playout buffer: both sides hold every sample until it has the age of the
    /// latest one, so that the delay is constant.
    pub fn has_playout_buffer(&self) -> bool {
        self.has_playout_buffer
    }

    /// Whether the study accepts values that no laboratory has.
    pub fn allows_unusual(&self) -> bool {
        self.allows_unusual
    }

    /// The study's coupling: spring and damper.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if the study gives no stiffness.
    pub fn coupling(&self) -> Result<Coupling> {
        let missing = || {
            let remedy = "Add a section [coupling] with stiffness = 20.0.";
            InvalidInput::missing("coupling.stiffness", "N/m", remedy)
        };
        let stiffness = self.stiffness.ok_or_else(missing)?;
        Ok(Coupling { stiffness, damping: self.dyad.coupling_damping() })
    }

    /// The study's network and the timing of its controllers.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if the study gives no delay.
    pub fn network(&self) -> Result<&Network> {
        if self.has_delay {
            return Ok(&self.network);
        }
        let remedy = "Add a section [network] with delay = 0.05.";
        Err(InvalidInput::missing("network.delay", "s, one way", remedy))
    }

    /// The study's uncertainty of each robot's parameters; `None` if they are certain.
    pub fn uncertainty(&self) -> [Option<&Uncertainty>; 2] {
        self.robots.each_ref().map(|robot| robot.uncertainty.as_ref())
    }
}

/// All keys of a study file as `section.key`, in order, those outside the sections first.
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
    keys::TOP.into_iter().map(str::to_owned).chain(dotted).collect()
}

/// The paper's 2K_xy: twice Eq. 5 on the x axis, N/m.
fn paper_stiffness(hman: &Dyad) -> f64 {
    let critical = hman.axis(0).and_then(|x| paper_critical_stiffness(&x));
    2.0 * critical.expect("the paper's criterion applies to the paper's robots")
}

/// The sections that say what holds the handles in a rehearsal.
const HOLDERS: [&str; 4] = ["arm1", "arm2", "agent1", "agent2"];
const UNNAMED: &str = "unnamed study";
