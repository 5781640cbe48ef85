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

mod reader;

use std::fmt::Write;

use crate::criteria::verdicts::{Network, OperatorRange};
use crate::error::{InvalidInput, Result};
use crate::model::{Delay, Dyad, Operator, Robot, hman};
use crate::quantity;
use reader::{PerAxis, Reader, Span};

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
    robot_names: [Option<String>; 2],
    dyad: Dyad,
    operator_ranges: Option<[OperatorRange; 2]>,
    stiffness: f64,
    network: Network,
}

impl Study {
    /// The paper's two H-MANs at its condition 2K_xy (printed 71 N/m) and Δ_xy (167 ms), handles free,
    /// controllers continuous, as in its Fig. 5(h).
    pub fn paper() -> Self {
        Self {
            name: "Du, Kulkarni, Kager and Campolo: two H-MANs".to_owned(),
            robot_names: [Some("H-MAN 1".to_owned()), Some("H-MAN 2".to_owned())],
            dyad: hman(),
            operator_ranges: None,
            stiffness: PAPER_STIFFNESS,
            network: Network::constant(Delay::each_way(0.167).expect("the paper's delay is valid")),
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
        let [(robot1, name1), (robot2, name2)] = [robot(&reader, "robot1")?, robot(&reader, "robot2")?];
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
        Ok(Self {
            name: reader.name()?.unwrap_or_else(|| UNNAMED.to_owned()),
            robot_names: [name1, name2],
            dyad,
            operator_ranges: (!single).then_some(ranges),
            stiffness,
            network: network(&reader)?,
        })
    }

    /// The study as TOML text that reads back to the same study.
    pub fn to_toml(&self) -> String {
        let mut text = format!("name = {}\n", quoted(&self.name));
        for (i, robot) in self.dyad.robots().iter().enumerate() {
            section(&mut text, &format!("robot{}", i + 1));
            if let Some(name) = &self.robot_names[i] {
                line(&mut text, "name", &quoted(name), "");
            }
            let axes: Vec<String> = robot.axes().iter().map(|name| quoted(name)).collect();
            line(&mut text, "axes", &format!("[{}]", axes.join(", ")), "");
            line(&mut text, "mass", &list(robot.mass()), "kg");
            line(&mut text, "damping", &list(robot.damping()), "N·s/m");
        }
        for i in 0..2 {
            let (low, high) = match &self.operator_ranges {
                Some(ranges) => (ranges[i].low(), ranges[i].high()),
                None => (&self.dyad.operators()[i], &self.dyad.operators()[i]),
            };
            let free = Operator::free(low.mass().len());
            if *low == free && *high == free {
                continue;
            }
            section(&mut text, &format!("operator{}", i + 1));
            line(&mut text, "mass", &ranges(low.mass(), high.mass()), "kg");
            line(&mut text, "damping", &ranges(low.damping(), high.damping()), "N·s/m");
            line(&mut text, "stiffness", &ranges(low.stiffness(), high.stiffness()), "N/m");
        }
        section(&mut text, "coupling");
        line(&mut text, "stiffness", &float(self.stiffness), "N/m");
        line(&mut text, "damping", &float(self.dyad.coupling_damping()), "N·s/m");
        section(&mut text, "network");
        let delay = self.network.delay();
        let delay = if delay.forward() == delay.backward() {
            float(delay.forward())
        } else {
            format!("{{forward = {}, backward = {}}}", float(delay.forward()), float(delay.backward()))
        };
        line(&mut text, "delay", &delay, "s, one way");
        line(&mut text, "jitter", &float(self.network.jitter()), "s");
        line(&mut text, "max_gap", &float(self.network.max_gap()), "s");
        section(&mut text, "controller");
        line(&mut text, "sample_period", &float(self.network.sample_period()), "s");
        line(&mut text, "computing_time", &float(self.network.computing_time()), "s");
        text
    }

    /// The study's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The robots' names, where they have one.
    pub fn robot_names(&self) -> [Option<&str>; 2] {
        self.robot_names.each_ref().map(Option::as_deref)
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
}

/// Twice Eq. 5 on the x axis, N/m.
const PAPER_STIFFNESS: f64 = (7.7257 * 7.7257 + 7.4208 * 7.4208) / (0.8334 + 0.7776);
const UNNAMED: &str = "unnamed study";

/// A value that is 0 where it is not given.
fn optional(reader: &Reader<'_>, section: &str, key: &str, quantity: quantity::Quantity) -> Result<f64> {
    reader.get(section, key).map_or(Ok(0.0), |entry| entry.number(quantity, "a number"))
}

fn robot(reader: &Reader<'_>, section: &str) -> Result<(Robot, Option<String>)> {
    let mass = reader.need(section, "mass", "mass = 1.0 (kg)")?;
    let damping = reader.need(section, "damping", "damping = 5.0 (N·s/m)")?;
    let masses = mass.per_axis(quantity::MASS, false)?;
    let dampings = damping.per_axis(quantity::DAMPING, false)?;
    let name = reader.get(section, "name").map(|entry| entry.text()).transpose()?;
    let axes = reader.get(section, "axes").map(|entry| entry.texts()).transpose()?;
    // A list says how many axes there are; single numbers go to all of them.
    let count = axes.as_ref().map(Vec::len).or(masses.count()).or(dampings.count()).unwrap_or(1);
    for (entry, values) in [(&mass, &masses), (&damping, &dampings)] {
        check_count(entry, values, count)?;
    }
    let lows = |values: &PerAxis| values.spread(count).iter().map(|span| span.low).collect();
    let robot =
        Robot::new(lows(&masses), lows(&dampings), axes).map_err(|error| reader.place(section, error))?;
    Ok((robot, name))
}

fn check_count(entry: &reader::Entry<'_, '_>, values: &PerAxis, count: usize) -> Result<()> {
    match values.count() {
        Some(got) if got != count => Err(entry.refuse(
            format!("one value per axis is needed, that is {count}, and here are {got}"),
            "Give one value per axis, or a single number for all of them.",
        )),
        _ => Ok(()),
    }
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
    let delay = match entry.pair(["forward", "backward"])? {
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

fn section(text: &mut String, name: &str) {
    let _ = write!(text, "\n[{name}]\n");
}

fn line(text: &mut String, key: &str, value: &str, unit: &str) {
    let comment = if unit.is_empty() { String::new() } else { format!("  # {unit}") };
    let _ = writeln!(text, "{key} = {value}{comment}");
}

/// The shortest text that reads back to the same number.
fn float(value: f64) -> String {
    format!("{value:?}")
}

fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

fn list(values: &[f64]) -> String {
    format!("[{}]", values.iter().map(|&value| float(value)).collect::<Vec<_>>().join(", "))
}

fn ranges(low: &[f64], high: &[f64]) -> String {
    let each = low.iter().zip(high).map(|(&low, &high)| {
        if low == high { float(low) } else { format!("{{min = {}, max = {}}}", float(low), float(high)) }
    });
    format!("[{}]", each.collect::<Vec<_>>().join(", "))
}
