//! Writes a study as TOML text that reads back to the same study; sections with default values are omitted.

use std::fmt::Write;

use super::Study;
use super::comparison::{ComparedNetwork, ComparisonChoice};
use super::emulated_network::{EmulatedNetwork, TraceFile};
use super::keys::toml_key;
use super::laboratory::{AgentChoice, MASSLESS, Setup, Task};
use super::protocol::{Conditions, ProtocolChoice};
use super::python::{OptionValue, PythonObject};
use crate::model::Operator;
use crate::rig::{Arm, Blackout, Elbow, GilbertElliott, JitterDistribution, PacketOrder, RateLimit};
use crate::session::Architecture;

/// The text of a study file, with units as comments.
pub(super) fn to_toml(study: &Study) -> String {
    let mut text = TomlText(format!("name = {}\n", quoted_text(&study.name)));
    if study.allows_unusual {
        text.write_line("allow_unusual", "true", "");
    }
    for (i, section) in study.robots.iter().enumerate() {
        let robot = &study.dyad.robots()[i];
        text.write_section(&format!("robot{}", i + 1));
        if let Some(name) = &section.name {
            text.write_line("name", quoted_text(name), "");
        }
        let axes: Vec<String> = robot.axes().iter().map(|name| quoted_text(name)).collect();
        text.write_line("axes", format!("[{}]", axes.join(", ")), "");
        text.write_line("mass", list_text(robot.mass()), "kg");
        text.write_line("damping", list_text(robot.damping()), "N·s/m");
        if section.coulomb.iter().any(|&force| force != 0.0) {
            text.write_line("coulomb", list_text(&section.coulomb), "N");
        }
        if section.ground_stiffness.iter().any(|&spring| spring != 0.0) {
            text.write_line("ground_stiffness", list_text(&section.ground_stiffness), "N/m");
        }
        if let Some(uncertainty) = &section.uncertainty {
            text.write_line("mass_sd", list_text(&uncertainty.mass_sd), "kg");
            text.write_line("damping_sd", list_text(&uncertainty.damping_sd), "N·s/m");
            text.write_line("mass_damping_correlation", list_text(&uncertainty.correlation), "");
        }
    }
    for i in 0..2 {
        let (low, high) = (study.hands[i].low(), study.hands[i].high());
        let free = Operator::free(low.mass().len());
        if *low == free && *high == free {
            continue;
        }
        text.write_section(&format!("operator{}", i + 1));
        text.write_line("mass", ranges_text(low.mass(), high.mass()), "kg");
        text.write_line("damping", ranges_text(low.damping(), high.damping()), "N·s/m");
        text.write_line("stiffness", ranges_text(low.stiffness(), high.stiffness()), "N/m");
    }
    text.write_section("coupling");
    if let Some(stiffness) = study.stiffness {
        text.write_line("stiffness", float_text(stiffness), "N/m");
    }
    text.write_line("damping", float_text(study.dyad.coupling_damping()), "N·s/m");
    text.write_section("network");
    let delay = study.network.delay();
    let delay = if delay.forward() == delay.backward() {
        float_text(delay.forward())
    } else {
        format!("{{forward = {}, backward = {}}}", float_text(delay.forward()), float_text(delay.backward()))
    };
    if study.has_delay {
        text.write_line("delay", delay, "s, one way");
    }
    text.write_each_way("jitter", study.emulated_network.model.jitters().map(float_text), "s");
    text.write_line("max_gap", float_text(study.network.max_gap()), "s");
    if study.has_playout_buffer() {
        text.write_line("playout_buffer", "true", "");
    }
    text.write_emulated_network(&study.emulated_network);
    text.write_section("controller");
    text.write_line("sample_period", float_text(study.network.sample_period()), "s");
    text.write_line("computing_time", float_text(study.network.computing_time()), "s");
    text.write_setup(&study.setup);
    text.write_protocol(&study.protocol);
    text.write_session(&study.session);
    text.write_comparison(&study.comparison);
    text.0
}

struct TomlText(String);

impl TomlText {
    /// Writes the header of a section to a study file.
    fn write_section(&mut self, name: &str) {
        let _ = write!(self.0, "\n[{name}]\n");
    }

    /// Writes a key with its value to a study file, and the unit as a comment.
    fn write_line(&mut self, key: &str, value: impl AsRef<str>, unit: &str) {
        let comment = if unit.is_empty() { String::new() } else { format!("  # {unit}") };
        let _ = writeln!(self.0, "{key} = {}{comment}", value.as_ref());
    }

    /// Writes a key with a value for each direction of the network to a study file: one value if both are equal.
    fn write_each_way(&mut self, key: &str, [forward, backward]: [String; 2], unit: &str) {
        if forward == backward {
            self.write_line(key, forward, unit);
        } else {
            self.write_line(key, format!("{{forward = {forward}, backward = {backward}}}"), unit);
        }
    }

    /// Writes to a study file what the network does to packets, where it does anything.
    fn write_emulated_network(&mut self, network: &EmulatedNetwork) {
        let ways = [&network.model.forward, &network.model.backward];
        let mut write = |key: &str, unit: &str, given: [Option<String>; 2]| match given {
            [None, None] => {}
            [Some(forward), Some(backward)] => self.write_each_way(key, [forward, backward], unit),
            [Some(forward), None] => self.write_line(key, format!("{{forward = {forward}}}"), unit),
            [None, Some(backward)] => self.write_line(key, format!("{{backward = {backward}}}"), unit),
        };
        let above_zero = |value: f64| (value > 0.0).then(|| float_text(value));
        write("distribution", "s", ways.map(|way| distribution_text(way.distribution)));
        write("loss", "", ways.map(|way| above_zero(way.loss)));
        write("burst", "", ways.map(|way| way.burst.map(burst_text)));
        write("duplicate", "", ways.map(|way| above_zero(way.duplicate)));
        write("order", "", ways.map(|way| (way.order == PacketOrder::Fifo).then(|| quoted_text("fifo"))));
        write("rate", "", ways.map(|way| way.rate.map(rate_text)));
        write("blackout", "s", ways.map(|way| way.blackout.map(blackout_text)));
        write(
            "adversary",
            "",
            ways.map(|way| way.adversary.map(|adversary| table_text(&adversary.to_table()))),
        );
        write("trace", "", network.traces.each_ref().map(|file| file.as_ref().map(trace_text)));
    }

    /// Writes to a study file the sections of the rehearsal setup that differ from the paper's.
    fn write_setup(&mut self, setup: &Setup) {
        let paper = Setup::paper();
        for (i, arm) in setup.arms.iter().enumerate() {
            if *arm != MASSLESS {
                self.write_section(&format!("arm{}", i + 1));
                self.write_arm(arm);
            }
        }
        for (i, agent) in setup.agents.iter().enumerate() {
            if *agent != paper.agents[i] {
                self.write_section(&format!("agent{}", i + 1));
                self.write_agent(agent);
            }
        }
        if setup.task != paper.task {
            self.write_section("task");
            match &setup.task {
                Task::FigureEight { amplitude, angular_frequency } => {
                    self.write_line("kind", quoted_text("figure-eight"), "");
                    self.write_line("amplitude", list_text(amplitude), "m");
                    self.write_line("angular_frequency", float_text(*angular_frequency), "rad/s");
                }
                Task::Python(object) => self.write_python("function", object),
            }
        }
        let imperfect =
            Setup { arms: paper.arms, agents: paper.agents.clone(), task: paper.task.clone(), ..*setup };
        if imperfect != paper {
            self.write_section("laboratory");
            if let Some(period) = setup.sample_period {
                self.write_line("sample_period", float_text(period), "s");
            }
            self.write_line("computing_tick", setup.computing_tick.to_string(), "");
            self.write_line("actuator_lag", float_text(setup.actuator_lag), "s");
            self.write_line("encoder_resolution", float_text(setup.encoder_resolution), "m");
        }
    }

    /// Writes the keys of an arm to a study file.
    fn write_arm(&mut self, arm: &Arm) {
        match arm {
            Arm::Lumped { mass, damping } => {
                self.write_line("kind", quoted_text("lumped"), "");
                self.write_line("mass", list_text(mass), "kg");
                self.write_line("damping", list_text(damping), "N·s/m");
            }
            Arm::TwoLink(arm) => {
                self.write_line("kind", quoted_text("two-link"), "");
                self.write_line("base", list_text(&arm.base), "m");
                self.write_line(
                    "elbow",
                    quoted_text(if arm.elbow == Elbow::Left { "left" } else { "right" }),
                    "",
                );
                self.write_line("link_length", list_text(&arm.link_length), "m");
                self.write_line("link_mass", list_text(&arm.link_mass), "kg");
                self.write_line("link_centre", list_text(&arm.link_centre), "m from the joint");
                self.write_line("link_inertia", list_text(&arm.link_inertia), "kg·m²");
                self.write_line("joint_damping", list_text(&arm.joint_damping), "N·m·s/rad");
                self.write_line("rotor_inertia", list_text(&arm.rotor_inertia), "kg·m²");
                if arm.torque_limit.iter().any(|limit| limit.is_finite()) {
                    self.write_line("torque_limit", list_text(&arm.torque_limit), "N·m");
                }
            }
        }
    }

    /// Writes the keys of an agent to a study file.
    fn write_agent(&mut self, agent: &AgentChoice) {
        match agent {
            AgentChoice::Skilled { stiffness, damping } => {
                self.write_line("kind", quoted_text("skilled"), "");
                self.write_line("stiffness", float_text(*stiffness), "N/m");
                self.write_line("damping", float_text(*damping), "N·s/m");
            }
            AgentChoice::Blurred { stiffness, spots } => {
                self.write_line("kind", quoted_text("blurred"), "");
                self.write_line("stiffness", float_text(*stiffness), "N/m");
                self.write_line("spots", spots.count.to_string(), "");
                self.write_line("spot_velocity", float_text(spots.velocity), "m/s");
                self.write_line("spot_lifetime", float_text(spots.lifetime), "s");
            }
            AgentChoice::Python(object) => self.write_python("class", object),
        }
    }

    /// Writes the reference to a Python object and its options to a study file.
    fn write_python(&mut self, key: &str, object: &PythonObject) {
        self.write_line("kind", quoted_text("python"), "");
        self.write_line(key, quoted_text(&object.path), "");
        if !object.options.is_empty() {
            let options = object.options.iter().map(|(name, value)| {
                // A non-ASCII name must be quoted.
                let name = if name.is_ascii() { name.clone() } else { quoted_text(name) };
                format!("{name} = {}", option_text(value))
            });
            self.write_line("options", format!("{{{}}}", options.collect::<Vec<_>>().join(", ")), "");
        }
    }

    /// Writes the section `[protocol]` to a study file if it differs from the paper's.
    fn write_protocol(&mut self, protocol: &ProtocolChoice) {
        if *protocol == ProtocolChoice::paper() {
            return;
        }
        self.write_section("protocol");
        self.write_line("unconnected", protocol.unconnected.to_string(), "");
        match &protocol.conditions {
            Conditions::Combinations { stiffness, delay } => {
                for (key, values, unit) in [("stiffness", stiffness, "N/m"), ("delay", delay, "s, one way")] {
                    if let Some(values) = values {
                        self.write_line(key, list_text(values), unit);
                    }
                }
            }
            Conditions::Listed(listed) => {
                let conditions = listed.iter().map(|&(k, delay)| {
                    format!("{{stiffness = {}, delay = {}}}", float_text(k), float_text(delay))
                });
                self.write_line(
                    "conditions",
                    format!("[{}]", conditions.collect::<Vec<_>>().join(", ")),
                    "N/m and s",
                );
            }
        }
        self.write_line("trials", protocol.trials.to_string(), "");
        let given = [
            ("duration", protocol.duration, "s"),
            ("discard", protocol.discard, "s"),
            ("record_rate", protocol.record_rate, "Hz"),
        ];
        for (key, value, unit) in given {
            if let Some(value) = value {
                self.write_line(key, float_text(value), unit);
            }
        }
        self.write_line("seed", protocol.seed.to_string(), "");
        self.write_line("order", quoted_text(if protocol.shuffled { "shuffled" } else { "blocks" }), "");
    }

    /// Writes the section `[session]` to a study file if it differs from the bare spring.
    fn write_session(&mut self, architecture: &Architecture) {
        if *architecture != Architecture::default() {
            self.write_section("session");
            let table = architecture.to_table();
            for key in ["strategy", "predictor", "playout"] {
                self.write_line(key, value_text(&table[key]), "");
            }
        }
    }

    /// Writes the section `[comparison]` to a study file if the study has it.
    fn write_comparison(&mut self, comparison: &ComparisonChoice) {
        let ComparisonChoice { architectures, networks } = comparison;
        if architectures.is_some() || networks.is_some() {
            self.write_section("comparison");
        }
        if let Some(architectures) = architectures {
            let items = architectures.iter().map(|architecture| table_text(&architecture.to_table()));
            self.write_line("architectures", format!("[{}]", items.collect::<Vec<_>>().join(", ")), "");
        }
        if let Some(networks) = networks {
            let items = networks.iter().map(|ComparedNetwork { name, keys, delays }| {
                let mut table = keys.clone();
                table.insert("name".to_owned(), toml::Value::String(name.clone()));
                if let Some(delays) = delays {
                    let delays = delays.iter().copied().map(toml::Value::Float).collect();
                    table.insert("delay".to_owned(), toml::Value::Array(delays));
                }
                table_text(&table)
            });
            self.write_line("networks", format!("[{}]", items.collect::<Vec<_>>().join(", ")), "s");
        }
    }
}

/// The distribution of a network's jitter as written to a study file; `None` if it is uniform.
fn distribution_text(distribution: JitterDistribution) -> Option<String> {
    let [mean, sd] = distribution.moments()?.map(float_text);
    let kind = match distribution {
        JitterDistribution::Uniform => "uniform",
        JitterDistribution::Normal { .. } => "normal",
        JitterDistribution::Gamma { .. } => "gamma",
        JitterDistribution::LogNormal { .. } => "lognormal",
    };
    Some(format!("{{kind = {}, mean = {mean}, sd = {sd}}}", quoted_text(kind)))
}

/// Losses of a network in bursts as written to a study file.
fn burst_text(burst: GilbertElliott) -> String {
    let GilbertElliott { to_bad, to_good, loss_good, loss_bad } = burst;
    let [to_bad, to_good, loss_good, loss_bad] = [to_bad, to_good, loss_good, loss_bad].map(float_text);
    format!("{{to_bad = {to_bad}, to_good = {to_good}, loss_good = {loss_good}, loss_bad = {loss_bad}}}")
}

/// The rate of a network's link as written to a study file.
fn rate_text(rate: RateLimit) -> String {
    format!("{{bits_per_second = {}, queue = {}}}", float_text(rate.bits_per_second), rate.queue)
}

/// The blackouts of a network as written to a study file.
fn blackout_text(blackout: Blackout) -> String {
    let Blackout { start, duration, period } = blackout;
    let period = period.map_or_else(String::new, |period| format!(", period = {}", float_text(period)));
    format!("{{start = {}, duration = {}{period}}}", float_text(start), float_text(duration))
}

/// The file of a network's trace as written to a study file.
fn trace_text(file: &TraceFile) -> String {
    format!("{{file = {}, round_trip = {}}}", quoted_text(&file.path), file.is_round_trip)
}

/// A number as written to a study file: the shortest text that reads back to the same value.
fn float_text(value: f64) -> String {
    format!("{value:?}")
}

/// A string as written to a study file, in TOML syntax.
fn quoted_text(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

/// A value as written to a study file on one line, in TOML syntax.
fn value_text(value: &toml::Value) -> String {
    match value {
        toml::Value::Table(table) => table_text(table),
        toml::Value::Array(items) => {
            format!("[{}]", items.iter().map(value_text).collect::<Vec<_>>().join(", "))
        }
        toml::Value::Float(value) => float_text(*value),
        _ => value.to_string(),
    }
}

/// A table as written to a study file on one line, its name or kind first.
fn table_text(table: &toml::Table) -> String {
    let is_first = |key: &str| ["name", "kind", "strategy"].contains(&key);
    let (first, others): (Vec<_>, Vec<_>) = table.iter().partition(|(key, _)| is_first(key));
    let pair = |(key, value): (&String, &toml::Value)| format!("{} = {}", toml_key(key), value_text(value));
    format!("{{{}}}", first.into_iter().chain(others).map(pair).collect::<Vec<_>>().join(", "))
}

/// The value of an option as written to a study file, in TOML syntax.
fn option_text(value: &OptionValue) -> String {
    match value {
        OptionValue::Boolean(value) => value.to_string(),
        OptionValue::Whole(value) => value.to_string(),
        OptionValue::Number(value) => float_text(*value),
        OptionValue::Text(text) => quoted_text(text),
        OptionValue::List(items) => {
            format!("[{}]", items.iter().map(option_text).collect::<Vec<_>>().join(", "))
        }
    }
}

/// A list of numbers as written to a study file, in TOML syntax.
fn list_text(values: &[f64]) -> String {
    format!("[{}]", values.iter().map(|&value| float_text(value)).collect::<Vec<_>>().join(", "))
}

/// A list of numbers or ranges as written to a study file, in TOML syntax.
fn ranges_text(low: &[f64], high: &[f64]) -> String {
    let axes = low.iter().zip(high).map(|(&low, &high)| {
        if low == high {
            float_text(low)
        } else {
            format!("{{min = {}, max = {}}}", float_text(low), float_text(high))
        }
    });
    format!("[{}]", axes.collect::<Vec<_>>().join(", "))
}
