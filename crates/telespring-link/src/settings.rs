//! The site file: what one site is told, checked.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use telespring::InvalidInput;
use telespring::session::Span;
use telespring::session::architecture::{PredictorDesign, StrategyDesign};
use telespring::study::Study;

use crate::site::Safety;

/// The robot of a site.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DeviceChoice {
    /// The robot of the study with its simulated person; the seed draws what the person sees.
    Simulated {
        /// The seed.
        seed: u64,
    },
    /// A program that speaks the device protocol.
    Udp {
        /// Where this program listens.
        local: SocketAddr,
        /// Where the device program listens, and sends from.
        device: SocketAddr,
        /// How long the device may be silent.
        deadline: Span,
    },
}

/// What the loop asks the operating system for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LoopChoice {
    /// The priority of the first-in-first-out schedule, 1 to 99; `None` to ask for none.
    pub priority: Option<i32>,
    /// Whether the memory stays in place.
    pub lock_memory: bool,
}

impl Default for LoopChoice {
    /// Priority 80, memory locked.
    fn default() -> Self {
        Self { priority: Some(80), lock_memory: true }
    }
}

/// What a site file says.
#[derive(Debug, Clone)]
pub struct SiteFile {
    /// The study.
    pub study: Study,
    /// The robot of the study that this site moves, 1 or 2.
    pub side: u8,
    /// How long the session takes at most.
    pub duration: Option<Span>,
    /// Where this site listens, and the partner's address.
    pub addresses: [SocketAddr; 2],
    /// The robot.
    pub device: DeviceChoice,
    /// The limits.
    pub safety: Safety,
    /// The loop.
    pub real_time: LoopChoice,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Text {
    study: PathBuf,
    side: u8,
    seconds: Option<f64>,
    network: NetworkText,
    #[serde(default)]
    device: DeviceText,
    #[serde(default)]
    safety: SafetyText,
    #[serde(default, rename = "loop")]
    real_time: LoopText,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct NetworkText {
    local: SocketAddr,
    peer: SocketAddr,
}

#[derive(Deserialize)]
#[serde(tag = "kind", deny_unknown_fields, rename_all = "kebab-case")]
enum DeviceText {
    Simulated {
        #[serde(default = "usual_seed")]
        seed: u64,
    },
    Udp {
        local: SocketAddr,
        device: SocketAddr,
        #[serde(default = "usual_deadline")]
        deadline: f64,
    },
}

fn usual_seed() -> u64 {
    1
}

fn usual_deadline() -> f64 {
    0.1
}

impl Default for DeviceText {
    fn default() -> Self {
        Self::Simulated { seed: usual_seed() }
    }
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct SafetyText {
    force: Option<f64>,
    silence: Option<f64>,
    stall: Option<f64>,
    ramp_out: Option<f64>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct LoopText {
    priority: Option<i32>,
    lock_memory: Option<bool>,
}

impl SiteFile {
    /// Reads a site file and the study that it names, whose path is relative to the file.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] with the key, or with the line and column of what is not TOML.
    pub fn read(path: &Path) -> Result<Self, InvalidInput> {
        let text = read(path, "site")?;
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::from_toml(&text, |study| read(&folder.join(study), "study"))
    }

    /// As [`SiteFile::read`], from the text; `study` returns that of the study.
    ///
    /// # Errors
    ///
    /// As [`SiteFile::read`], and every error of `study`.
    pub fn from_toml(
        text: &str,
        study: impl FnOnce(&Path) -> Result<String, InvalidInput>,
    ) -> Result<Self, InvalidInput> {
        let Text { study: path, side, seconds, network, device, safety, real_time } = toml::from_str(text)
            .map_err(|error| {
                let allowed = error.to_string().trim_end().to_owned();
                InvalidInput::new(
                    "site",
                    "the file",
                    allowed,
                    "docs/connect.md has every key of a site file.",
                )
            })?;
        let study = Study::from_toml(&study(&path)?).map_err(|refusal| refusal.within("study"))?;
        let duration = seconds.map(|seconds| span("seconds", seconds, [0.1, 86_400.0], 20.0)).transpose()?;
        let device = match device {
            DeviceText::Simulated { seed } => DeviceChoice::Simulated { seed },
            DeviceText::Udp { local, device, deadline } => DeviceChoice::Udp {
                local,
                device,
                deadline: span("device.deadline", deadline, [0.005, 1.0], usual_deadline())?,
            },
        };
        let usual = Safety::default();
        let time = |field: &str, given: Option<f64>, usual: Span| {
            given.map_or(Ok(usual), |given| span(field, given, [0.005, 10.0], usual.seconds()))
        };
        let safety = Safety {
            force: safety.force.unwrap_or(usual.force),
            silence: time("safety.silence", safety.silence, usual.silence)?,
            stall: time("safety.stall", safety.stall, usual.stall)?,
            ramp_out: time("safety.ramp_out", safety.ramp_out, usual.ramp_out)?,
        };
        safety.check()?;
        let usual = LoopChoice::default();
        let priority = real_time.priority.or(usual.priority);
        if let Some(priority) = priority.filter(|priority| !(0..=99).contains(priority)) {
            let remedy = "Give 80, or 0 for an ordinary thread.";
            return Err(InvalidInput::new("loop.priority", priority, "a whole number from 0 to 99", remedy));
        }
        let real_time = LoopChoice {
            priority: priority.filter(|priority| *priority > 0),
            lock_memory: real_time.lock_memory.unwrap_or(usual.lock_memory),
        };
        let file = Self {
            study,
            side,
            duration,
            addresses: [network.local, network.peer],
            device,
            safety,
            real_time,
        };
        file.check()?;
        Ok(file)
    }

    /// Checks what concerns several keys.
    fn check(&self) -> Result<(), InvalidInput> {
        if !matches!(self.side, 1 | 2) {
            let remedy = "Give the robot of the study that this site moves.";
            return Err(InvalidInput::new("side", self.side, "1 or 2", remedy));
        }
        let device = match self.device {
            DeviceChoice::Simulated { .. } => None,
            DeviceChoice::Udp { local, device, .. } => Some([local, device]),
        };
        let [local, peer] = self.addresses;
        let named = [("network.local", Some(local)), ("network.peer", Some(peer))].into_iter().chain([
            ("device.local", device.map(|[local, _]| local)),
            ("device.device", device.map(|[_, device]| device)),
        ]);
        for (field, address) in named {
            if let Some(address) = address.filter(|address| !address.ip().is_loopback()) {
                return Err(InvalidInput::new(
                    field,
                    address,
                    "an address of this machine: nobody checks who sends a packet",
                    "Write 127.0.0.1 with a port; lead other machines' packets there through an authenticated tunnel.",
                ));
            }
        }
        if device.is_none() {
            return Ok(());
        }
        let session = self.study.session();
        if !matches!(session.strategy, StrategyDesign::Guard(_)) {
            return Err(InvalidInput::new(
                "study.session.strategy",
                format!("{:?}", session.strategy.kind()),
                "a robot that a person holds is coupled by the guard",
                "Write strategy = \"guard\" under [session] of the study.",
            ));
        }
        if session.predictor == PredictorDesign::SharedTarget {
            return Err(InvalidInput::new(
                "study.session.predictor",
                format!("{:?}", session.predictor.kind()),
                "the device protocol tells no target, which this predictor needs",
                "Write predictor = \"hold\" under [session] of the study.",
            ));
        }
        Ok(())
    }
}

/// A span of time in seconds within a range.
fn span(field: &str, seconds: f64, [least, most]: [f64; 2], usual: f64) -> Result<Span, InvalidInput> {
    if seconds >= least && seconds <= most {
        return Ok(Span::from_seconds(seconds));
    }
    let allowed = format!("{least} to {most} s");
    Err(InvalidInput::new(field, format!("{seconds} s"), allowed, format!("Give {usual}.")))
}

/// The text of a file.
fn read(path: &Path, what: &str) -> Result<String, InvalidInput> {
    std::fs::read_to_string(path).map_err(|error| {
        let value = path.display();
        InvalidInput::new(what, value, format!("the file cannot be read ({error})"), "Check the path.")
    })
}
