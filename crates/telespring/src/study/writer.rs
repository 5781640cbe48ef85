//! A study as TOML text that reads back to the same study; sections that say what holds anyway are left
//! away.

use std::fmt::Write;

use super::Study;
use super::laboratory::{AgentChoice, MASSLESS, Setup, Task};
use super::protocol::{Conditions, ProtocolChoice};
use super::python::{OptionValue, PythonObject};
use crate::model::Operator;
use crate::rig::{Arm, Elbow};

/// The text of a study file, units as comments.
pub(super) fn to_toml(study: &Study) -> String {
    let mut text = Text(format!("name = {}\n", quoted(&study.name)));
    for (i, section) in study.robots.iter().enumerate() {
        let robot = &study.dyad.robots()[i];
        text.section(&format!("robot{}", i + 1));
        if let Some(name) = &section.name {
            text.line("name", quoted(name), "");
        }
        let axes: Vec<String> = robot.axes().iter().map(|name| quoted(name)).collect();
        text.line("axes", format!("[{}]", axes.join(", ")), "");
        text.line("mass", list(robot.mass()), "kg");
        text.line("damping", list(robot.damping()), "N·s/m");
        if section.coulomb.iter().any(|&force| force != 0.0) {
            text.line("coulomb", list(&section.coulomb), "N");
        }
        if let Some(uncertainty) = &section.uncertainty {
            text.line("mass_sd", list(&uncertainty.mass_sd), "kg");
            text.line("damping_sd", list(&uncertainty.damping_sd), "N·s/m");
            text.line("mass_damping_correlation", list(&uncertainty.correlation), "");
        }
    }
    for i in 0..2 {
        let (low, high) = match &study.operator_ranges {
            Some(ranges) => (ranges[i].low(), ranges[i].high()),
            None => (&study.dyad.operators()[i], &study.dyad.operators()[i]),
        };
        let free = Operator::free(low.mass().len());
        if *low == free && *high == free {
            continue;
        }
        text.section(&format!("operator{}", i + 1));
        text.line("mass", ranges(low.mass(), high.mass()), "kg");
        text.line("damping", ranges(low.damping(), high.damping()), "N·s/m");
        text.line("stiffness", ranges(low.stiffness(), high.stiffness()), "N/m");
    }
    text.section("coupling");
    text.line("stiffness", float(study.stiffness), "N/m");
    text.line("damping", float(study.dyad.coupling_damping()), "N·s/m");
    text.section("network");
    let delay = study.network.delay();
    let delay = if delay.forward() == delay.backward() {
        float(delay.forward())
    } else {
        format!("{{forward = {}, backward = {}}}", float(delay.forward()), float(delay.backward()))
    };
    text.line("delay", delay, "s, one way");
    text.line("jitter", float(study.network.jitter()), "s");
    text.line("max_gap", float(study.network.max_gap()), "s");
    text.section("controller");
    text.line("sample_period", float(study.network.sample_period()), "s");
    text.line("computing_time", float(study.network.computing_time()), "s");
    text.setup(&study.setup);
    text.protocol(&study.protocol);
    text.0
}

struct Text(String);

impl Text {
    fn section(&mut self, name: &str) {
        let _ = write!(self.0, "\n[{name}]\n");
    }

    fn line(&mut self, key: &str, value: impl AsRef<str>, unit: &str) {
        let comment = if unit.is_empty() { String::new() } else { format!("  # {unit}") };
        let _ = writeln!(self.0, "{key} = {}{comment}", value.as_ref());
    }

    fn setup(&mut self, setup: &Setup) {
        let paper = Setup::paper();
        for (i, arm) in setup.arms.iter().enumerate() {
            if *arm != MASSLESS {
                self.section(&format!("arm{}", i + 1));
                self.arm(arm);
            }
        }
        for (i, agent) in setup.agents.iter().enumerate() {
            if *agent != paper.agents[i] {
                self.section(&format!("agent{}", i + 1));
                self.agent(agent);
            }
        }
        if setup.task != paper.task {
            self.section("task");
            match &setup.task {
                Task::FigureEight { amplitude, angular_frequency } => {
                    self.line("kind", quoted("figure-eight"), "");
                    self.line("amplitude", list(amplitude), "m");
                    self.line("angular_frequency", float(*angular_frequency), "rad/s");
                }
                Task::Python(object) => self.python("function", object),
            }
        }
        let imperfect =
            Setup { arms: paper.arms, agents: paper.agents.clone(), task: paper.task.clone(), ..*setup };
        if imperfect != paper {
            self.section("laboratory");
            if let Some(period) = setup.sample_period {
                self.line("sample_period", float(period), "s");
            }
            self.line("computing_tick", setup.computing_tick.to_string(), "");
            self.line("actuator_lag", float(setup.actuator_lag), "s");
            self.line("encoder_resolution", float(setup.encoder_resolution), "m");
            self.line("jitter", float(setup.jitter), "s");
            self.line("loss", float(setup.loss), "");
        }
    }

    fn arm(&mut self, arm: &Arm) {
        match arm {
            Arm::Lumped { mass, damping } => {
                self.line("kind", quoted("lumped"), "");
                self.line("mass", list(mass), "kg");
                self.line("damping", list(damping), "N·s/m");
            }
            Arm::TwoLink(arm) => {
                self.line("kind", quoted("two-link"), "");
                self.line("base", list(&arm.base), "m");
                self.line("elbow", quoted(if arm.elbow == Elbow::Left { "left" } else { "right" }), "");
                self.line("link_length", list(&arm.link_length), "m");
                self.line("link_mass", list(&arm.link_mass), "kg");
                self.line("link_centre", list(&arm.link_centre), "m from the joint");
                self.line("link_inertia", list(&arm.link_inertia), "kg·m²");
                self.line("joint_damping", list(&arm.joint_damping), "N·m·s/rad");
                self.line("rotor_inertia", list(&arm.rotor_inertia), "kg·m²");
                if arm.torque_limit.iter().any(|limit| limit.is_finite()) {
                    self.line("torque_limit", list(&arm.torque_limit), "N·m");
                }
            }
        }
    }

    fn agent(&mut self, agent: &AgentChoice) {
        match agent {
            AgentChoice::Skilled { stiffness, damping } => {
                self.line("kind", quoted("skilled"), "");
                self.line("stiffness", float(*stiffness), "N/m");
                self.line("damping", float(*damping), "N·s/m");
            }
            AgentChoice::Blurred { stiffness, spots } => {
                self.line("kind", quoted("blurred"), "");
                self.line("stiffness", float(*stiffness), "N/m");
                self.line("spots", spots.count.to_string(), "");
                self.line("spot_velocity", float(spots.velocity), "m/s");
                self.line("spot_lifetime", float(spots.lifetime), "s");
            }
            AgentChoice::Python(object) => self.python("class", object),
        }
    }

    fn python(&mut self, key: &str, object: &PythonObject) {
        self.line("kind", quoted("python"), "");
        self.line(key, quoted(&object.path), "");
        if !object.options.is_empty() {
            let each = object.options.iter().map(|(name, value)| {
                // a name of letters beyond ASCII must be quoted
                let name = if name.is_ascii() { name.clone() } else { quoted(name) };
                format!("{name} = {}", option(value))
            });
            self.line("options", format!("{{{}}}", each.collect::<Vec<_>>().join(", ")), "");
        }
    }

    fn protocol(&mut self, protocol: &ProtocolChoice) {
        if *protocol == ProtocolChoice::paper() {
            return;
        }
        self.section("protocol");
        self.line("unconnected", protocol.unconnected.to_string(), "");
        match &protocol.conditions {
            Conditions::Combinations { stiffness, delay } => {
                for (key, values, unit) in [("stiffness", stiffness, "N/m"), ("delay", delay, "s, one way")] {
                    if let Some(values) = values {
                        self.line(key, list(values), unit);
                    }
                }
            }
            Conditions::Listed(listed) => {
                let each = listed
                    .iter()
                    .map(|&(k, delay)| format!("{{stiffness = {}, delay = {}}}", float(k), float(delay)));
                self.line("conditions", format!("[{}]", each.collect::<Vec<_>>().join(", ")), "N/m and s");
            }
        }
        self.line("trials", protocol.trials.to_string(), "");
        let given = [
            ("duration", protocol.duration, "s"),
            ("discard", protocol.discard, "s"),
            ("record_rate", protocol.record_rate, "Hz"),
        ];
        for (key, value, unit) in given {
            if let Some(value) = value {
                self.line(key, float(value), unit);
            }
        }
        self.line("seed", protocol.seed.to_string(), "");
        self.line("order", quoted(if protocol.shuffled { "shuffled" } else { "blocks" }), "");
    }
}

/// The shortest text that reads back to the same number.
fn float(value: f64) -> String {
    format!("{value:?}")
}

fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

fn option(value: &OptionValue) -> String {
    match value {
        OptionValue::Boolean(value) => value.to_string(),
        OptionValue::Whole(value) => value.to_string(),
        OptionValue::Number(value) => float(*value),
        OptionValue::Text(text) => quoted(text),
        OptionValue::List(items) => format!("[{}]", items.iter().map(option).collect::<Vec<_>>().join(", ")),
    }
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
