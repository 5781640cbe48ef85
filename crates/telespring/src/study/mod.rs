//! The text of a study file to the model: the one validator for Rust, Python and the live program.
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
//! damping = 0                   # N·s/m, a damper beside it, default 0
//!
//! [network]
//! delay = 0.05                  # s, one way; or {forward = 0.04, backward = 0.06}
//! jitter = 0.01                 # s, the most that a packet may be later, default 0
//! max_gap = 0.02                # s, the longest wait for a newer sample, default 0
//!
//! [controller]
//! sample_period = 0.001         # s, default 0: a continuous controller
//! computing_time = 0.0002       # s, default 0
//! ```
//!
//! Everything else a study can say is of its rehearsal, and is the paper's experiment unless said:
//! [robot1] and [robot2] may add `coulomb`, `mass_sd`, `damping_sd` and `mass_damping_correlation`, and
//! there are the sections [arm1], [arm2], [agent1], [agent2], [task], [laboratory] and [protocol].
//! `docs/study-file.md` lists every key with its meaning, unit, range and default.

mod keys;
mod laboratory;
mod protocol;
mod python;
mod reader;
mod robot;
mod writer;

use crate::criteria::verdicts::{Network, OperatorRange};
use crate::error::{InvalidInput, Result};
use crate::model::{Delay, Dyad, Operator, hman};
use crate::quantity;
use crate::rig;
use reader::{Reader, Span};
use robot::{RobotSection, check_count, robot};

pub use laboratory::{AgentChoice, Setup, Task};
pub use protocol::{Conditions, ProtocolChoice};
pub use python::{OptionValue, PythonObject};
pub use robot::Uncertainty;

/// The virtual spring and the damper beside it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coupling {
    /// Stiffness, N/m.
    pub stiffness: f64,
    /// Damping, N·s/m.
    pub damping: f64,
}

/// What one study file says: two robots, who holds them, how they are coupled, over which network.
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
}

impl Study {
    /// The paper's two H-MANs at its condition 2K_xy (printed 71 N/m) and Δ_xy (167 ms), handles free,
    /// controllers continuous, as in its Fig. 5(h), and its whole experiment.
    pub fn paper() -> Self {
        Self {
            name: "Du, Kulkarni, Kager and Campolo: two H-MANs".to_owned(),
            robots: ["H-MAN 1", "H-MAN 2"].map(|name| RobotSection {
                name: Some(name.to_owned()),
                coulomb: vec![0.0; 2],
                uncertainty: None,
            }),
            dyad: hman(),
            operator_ranges: None,
            stiffness: PAPER_STIFFNESS,
            network: Network::constant(Delay::each_way(0.167).expect("the paper's delay is valid")),
            setup: Setup::paper(),
            protocol: ProtocolChoice::paper(),
        }
    }

    /// Reads a study from TOML text.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] where the text is not TOML, a key is unknown or missing, a value has the wrong
    /// type or range, or axes do not match. It names the dotted field, the value, what is allowed, the
    /// nearest remedy and the line. No text makes it panic.
    ///
    /// # Examples
    ///
    /// ```
    /// let refused = telespring::study::Study::from_toml("[network]\ndelay = 167").unwrap_err();
    /// assert_eq!(refused.field, "robot1.mass");
    /// ```
    pub fn from_toml(text: &str) -> Result<Self> {
        let reader = Reader::new(text)?;
        let [(robot1, section1), (robot2, section2)] = [robot(&reader, "robot1")?, robot(&reader, "robot2")?];
        let axes = robot1.axes().len();
        let ranges = [operator(&reader, "operator1", axes)?, operator(&reader, "operator2", axes)?];
        let single = ranges.iter().all(|range| range.low() == range.high());
        let operators = ranges.each_ref().map(OperatorRange::middle);
        let stiffness = reader.need("coupling", "stiffness", "stiffness = 20.0 (N/m)")?;
        let stiffness = stiffness.number(quantity::STIFFNESS, "a number")?;
        let damping = optional(&reader, "coupling", "damping", quantity::DAMPING)?;
        let dyad = Dyad::new(robot1, robot2, Some(operators), damping).map_err(|mut error| {
            // The only refusal left is that of unlike axes; its field is robot2.axes already.
            error.field = error.field.trim_start_matches("robot2.").to_owned();
            reader.place("robot2", error)
        })?;
        let study = Self {
            name: reader.name()?.unwrap_or_else(|| UNNAMED.to_owned()),
            robots: [section1, section2],
            dyad,
            operator_ranges: (!single).then_some(ranges),
            stiffness,
            network: network(&reader)?,
            setup: laboratory::setup(&reader)?,
            protocol: protocol::protocol(&reader)?,
        };
        study.check_rehearsal(&reader)?;
        Ok(study)
    }

    /// The study as TOML text that reads back to the same study.
    pub fn to_toml(&self) -> String {
        writer::to_toml(self)
    }

    /// The study's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The robots' names, where they have one.
    pub fn robot_names(&self) -> [Option<&str>; 2] {
        self.robots.each_ref().map(|robot| robot.name.as_deref())
    }

    /// The dyad; where the operators are ranges it holds the middle of each.
    pub fn dyad(&self) -> &Dyad {
        &self.dyad
    }

    /// The ranges of both operators, where any of their values is a range.
    pub fn operator_ranges(&self) -> Option<&[OperatorRange; 2]> {
        self.operator_ranges.as_ref()
    }

    /// The spring and the damper beside it.
    pub fn coupling(&self) -> Coupling {
        Coupling { stiffness: self.stiffness, damping: self.dyad.coupling_damping() }
    }

    /// The network and the controllers' timing.
    pub fn network(&self) -> &Network {
        &self.network
    }

    /// How far each robot's parameters may be off; `None` where they are certain.
    pub fn uncertainty(&self) -> [Option<&Uncertainty>; 2] {
        self.robots.each_ref().map(|robot| robot.uncertainty.as_ref())
    }

    /// Each robot's Coulomb friction per axis, N.
    pub fn coulomb(&self) -> [&[f64]; 2] {
        self.robots.each_ref().map(|robot| robot.coulomb.as_slice())
    }

    /// What the file says of the rehearsal: arms, agents, task, controllers and network.
    pub fn setup(&self) -> &Setup {
        &self.setup
    }

    /// Whether the robots have exactly the two axes x and y, so that the study can be rehearsed.
    pub fn is_planar(&self) -> bool {
        self.dyad.axis_names() == PLANE
    }

    /// The sample period of the laboratory's controllers, s: [laboratory]'s, else [controller]'s, else 1 ms.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] where both sections name one and they differ, or [controller]'s is none that the
    /// laboratory can run at.
    pub fn sample_period(&self) -> Result<f64> {
        let of_controller = self.network.sample_period();
        match self.setup.sample_period {
            Some(period) if of_controller > 0.0 && period != of_controller => Err(InvalidInput::new(
                "laboratory.sample_period",
                format!("{period:?}"),
                format!("[controller] says {of_controller:?} s, and both mean the same controllers"),
                "Name it once, or alike.",
            )),
            Some(period) => Ok(period),
            None if of_controller > 0.0 => {
                quantity::SAMPLE_PERIOD.check("controller.sample_period", of_controller)
            }
            None => Ok(SAMPLE_PERIOD),
        }
    }

    /// The virtual laboratory of this study.
    ///
    /// An agent of Python stands in it as [`rig::Agent::External`], a target of Python as
    /// [`rig::Target::Sampled`] without samples: whoever runs it gives the forces and the positions.
    /// Operators are left out, since arms and agents hold the handles here.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] where the robots have other axes than x and y or the sample period is no good, by
    /// its dotted field.
    ///
    /// # Examples
    ///
    /// ```
    /// let laboratory = telespring::study::Study::paper().laboratory()?;
    /// assert_eq!(laboratory.controller.sample_period, 0.001);
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn laboratory(&self) -> Result<rig::Laboratory> {
        self.require_plane()?;
        let pair = |values: &[f64]| [values[0], values[1]];
        let side = |i: usize| rig::Side {
            handle: rig::Handle {
                mass: pair(self.dyad.robots()[i].mass()),
                damping: pair(self.dyad.robots()[i].damping()),
                coulomb: pair(&self.robots[i].coulomb),
            },
            arm: self.setup.arms[i],
            agent: match self.setup.agents[i] {
                AgentChoice::Skilled { stiffness, damping } => rig::Agent::Skilled { stiffness, damping },
                AgentChoice::Blurred { stiffness, spots } => rig::Agent::Blurred { stiffness, spots },
                AgentChoice::Python(_) => rig::Agent::External,
            },
        };
        Ok(rig::Laboratory {
            sides: [side(0), side(1)],
            target: match self.setup.task {
                Task::FigureEight { amplitude, angular_frequency } => {
                    rig::Target::FigureEight { amplitude, angular_frequency }
                }
                Task::Python(_) => rig::Target::Sampled(Vec::new()),
            },
            controller: rig::Controller {
                sample_period: self.sample_period()?,
                computing_tick: self.setup.computing_tick,
                actuator_lag: self.setup.actuator_lag,
                encoder_resolution: self.setup.encoder_resolution,
            },
            network: rig::Network { jitter: self.setup.jitter, loss: self.setup.loss },
        })
    }

    /// Which trials are run; what the file leaves away follows from robots, task and controllers.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] where the robots have other axes than x and y, give no reference stiffness where
    /// one is needed, or the parts do not fit together, by its dotted field.
    ///
    /// # Examples
    ///
    /// ```
    /// let protocol = telespring::study::Study::paper().protocol()?;
    /// assert_eq!((protocol.conditions.len(), protocol.trials), (17, 20));
    /// assert_eq!((protocol.duration, protocol.discard), (29.111, 4.852));
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn protocol(&self) -> Result<rig::Protocol> {
        self.require_plane()?;
        self.protocol.resolve(&self.dyad, &self.setup.task, self.sample_period()?)
    }

    fn require_plane(&self) -> Result<()> {
        if self.is_planar() {
            return Ok(());
        }
        Err(InvalidInput::new(
            "robot1.axes",
            format!("{:?}", self.dyad.axis_names()),
            "a rehearsal needs robots with exactly the two axes \"x\" and \"y\"",
            "Give both robots these axes to rehearse the study.",
        ))
    }

    /// Where the file says anything of a rehearsal, the rehearsal must be possible.
    fn check_rehearsal(&self, reader: &Reader<'_>) -> Result<()> {
        let Some(section) = reader.rehearsal_section() else { return Ok(()) };
        if !self.is_planar() {
            return Err(reader.refuse_section(
                section,
                format!(
                    "a rehearsal needs robots with exactly the two axes \"x\" and \"y\", and these have {:?}",
                    self.dyad.axis_names()
                ),
                "Remove the section, or give both robots these axes.",
            ));
        }
        let mut laboratory = self.laboratory().map_err(|error| reader.locate(error))?;
        if matches!(laboratory.target, rig::Target::Sampled(_)) {
            // a target of Python has no samples yet; all else is checked
            laboratory.target = rig::Target::FigureEight { amplitude: [0.0; 2], angular_frequency: 0.0 };
        }
        laboratory.check().map_err(|error| reader.locate(error))?;
        self.protocol().map_err(|error| reader.locate(error))?;
        Ok(())
    }
}

/// Every key of a study file as `section.key`, in order, `name` first.
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

/// The axes of a rehearsal.
const PLANE: [&str; 2] = ["x", "y"];
/// Period of the laboratory's controllers where the study names none, s.
const SAMPLE_PERIOD: f64 = 0.001;

/// Twice Eq. 5 on the x axis, N/m.
const PAPER_STIFFNESS: f64 = (7.7257 * 7.7257 + 7.4208 * 7.4208) / (0.8334 + 0.7776);
const UNNAMED: &str = "unnamed study";

/// A value that is 0 where it is not given.
fn optional(reader: &Reader<'_>, section: &str, key: &str, quantity: quantity::Quantity) -> Result<f64> {
    reader.get(section, key).map_or(Ok(0.0), |entry| entry.number(quantity, "a number"))
}

fn operator(reader: &Reader<'_>, section: &str, axes: usize) -> Result<OperatorRange> {
    let keys = [
        ("mass", quantity::ADDED_MASS),
        ("damping", quantity::DAMPING),
        ("stiffness", quantity::GROUND_STIFFNESS),
    ];
    let mut spans = Vec::with_capacity(3);
    for (key, quantity) in keys {
        spans.push(match reader.get(section, key) {
            None => vec![Span { low: 0.0, high: 0.0 }; axes],
            Some(entry) => {
                let values = entry.per_axis(quantity, true)?;
                check_count(&entry, &values, axes)?;
                values.spread(axes)
            }
        });
    }
    let end = |end: fn(&Span) -> f64| {
        let mut values = spans.iter().map(|spans| spans.iter().map(end).collect::<Vec<f64>>());
        let mut next = || values.next().unwrap_or_default();
        Operator::new(next(), next(), next())
    };
    let place = |error: InvalidInput| reader.place(section, error);
    let (low, high) = (end(|span| span.low).map_err(place)?, end(|span| span.high).map_err(place)?);
    OperatorRange::new(low, high).map_err(place)
}

fn network(reader: &Reader<'_>) -> Result<Network> {
    let entry = reader.need("network", "delay", "delay = 0.05 (s, one way)")?;
    let delay = match entry.pair(["forward", "backward"], "or give one number")? {
        Some([forward, backward]) => Delay::new(
            forward.number(quantity::DELAY, "a number")?,
            backward.number(quantity::DELAY, "a number")?,
        ),
        None => Delay::each_way(entry.number(quantity::DELAY, "a number or {forward = …, backward = …}")?),
    };
    Network::new(
        delay.map_err(|error| reader.place("network", error))?,
        optional(reader, "network", "jitter", quantity::SPAN)?,
        optional(reader, "network", "max_gap", quantity::SPAN)?,
        optional(reader, "controller", "sample_period", quantity::SPAN)?,
        optional(reader, "controller", "computing_time", quantity::SPAN)?,
    )
    .map_err(|error| {
        let section =
            if matches!(error.field.as_str(), "jitter" | "max_gap") { "network" } else { "controller" };
        match reader.get(section, &error.field) {
            Some(entry) => entry.place(error.within(section)),
            None => error.within(section),
        }
    })
}
