//! The site file: what one site is told, checked. One room per table of the file.

mod device;
mod limits;
mod network;
mod range;
mod real_time;
mod record;
mod safety;
mod session;
mod several;
mod spoken;
mod telemetry;

pub use device::DeviceChoice;
pub use network::{IrohChoice, NetworkChoice};
pub use real_time::{LoopChoice, PaceChoice};
pub use session::SessionChoice;
pub use telemetry::TelemetryChoice;

use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use telespring::InvalidInput;
use telespring::session::Span;
use telespring::session::architecture::{PredictorDesign, StrategyDesign};
use telespring::study::Study;

use crate::site::{Limits, Safety, SiteSettings};
use range::span;

/// What a site file says.
#[derive(Debug, Clone)]
pub struct SiteFile {
    /// The study.
    pub study: Study,
    /// The robot of the study that this site moves, 1 or 2.
    pub side: u8,
    /// How long the session takes at most.
    pub duration: Option<Span>,
    /// The way to the partner.
    pub network: NetworkChoice,
    /// The robot.
    pub device: DeviceChoice,
    /// What keeps the person safe whatever the network does.
    pub safety: Safety,
    /// The limits of robot and person, the tighter of both.
    pub limits: Limits,
    /// When the two sites may be coupled.
    pub session: SessionChoice,
    /// The loop.
    pub real_time: LoopChoice,
    /// The folder for a recording; `None` for none.
    pub recording: Option<PathBuf>,
    /// Where viewers may look on; `None` for nowhere.
    pub live: Option<SocketAddr>,
    /// Who on this machine is sent what every tick says.
    pub telemetry: Option<TelemetryChoice>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Text {
    study: PathBuf,
    side: u8,
    seconds: Option<f64>,
    network: network::Text,
    #[serde(default)]
    device: device::Text,
    #[serde(default)]
    safety: safety::Text,
    #[serde(default)]
    limits: limits::Text,
    #[serde(default)]
    session: session::SessionText,
    #[serde(default)]
    fallback: session::FallbackText,
    #[serde(default, rename = "loop")]
    real_time: real_time::Text,
    telemetry: Option<telemetry::Text>,
    #[serde(default)]
    recording: record::Recording,
    #[serde(default)]
    live: record::Live,
}

impl SiteFile {
    /// Reads a site file and the study that it names. Paths in it are relative to the file.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] with the key, or with the line and column of what is not TOML.
    pub fn read(path: &Path) -> Result<Self, InvalidInput> {
        let text = read(path, "site")?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let file = Self::from_toml(&text, |study| read(&folder.join(study), "study"))?;
        let recording = file.recording.map(|recording| folder.join(recording));
        Ok(Self { network: file.network.within(folder), recording, ..file })
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
        let Text {
            study: path,
            side,
            seconds,
            network,
            device,
            safety,
            limits,
            session,
            fallback,
            real_time,
            telemetry,
            recording,
            live,
        } = toml::from_str(text).map_err(|error| {
            let allowed = spoken::in_words(&error);
            InvalidInput::new("site", "the file", allowed, "docs/connect.md has every key of a site file.")
        })?;
        let study = Study::from_toml(&study(&path)?).map_err(spoken::of_study)?;
        let (network, device) = (NetworkChoice::new(network)?, DeviceChoice::new(device)?);
        let file = Self {
            study,
            side,
            duration: seconds.map(check_duration).transpose()?,
            network,
            device,
            safety: safety::read(&safety)?,
            limits: limits::read(&limits)?,
            session: SessionChoice::new(session, fallback, device.is_real())?,
            real_time: LoopChoice::new(&real_time)?,
            telemetry: telemetry.map(TelemetryChoice::new).transpose()?,
            recording: recording.folder,
            live: record::address(&live)?,
        };
        file.check()?;
        Ok(file)
    }

    /// What the site is made of, for a session with this id.
    ///
    /// # Errors
    ///
    /// Those of [`SiteSettings::new`].
    pub fn site(&self, session: u64) -> Result<SiteSettings, InvalidInput> {
        let settings =
            SiteSettings::new(&self.study, self.side, session, self.safety).map_err(spoken::of_study)?;
        let rules = self.session.rules(settings.rules, self.device.is_real());
        Ok(SiteSettings { limits: self.limits, rules, ..settings })
    }

    /// Checks what concerns several keys.
    fn check(&self) -> Result<(), InvalidInput> {
        if !matches!(self.side, 1 | 2) {
            let remedy = "Give the robot of the study that this site moves.";
            return Err(InvalidInput::new("side", self.side, "1 or 2", remedy));
        }
        if !self.study.is_planar() {
            // of other axes there is no laboratory, whose refusal says why
            self.study.laboratory_without_traces().map_err(spoken::of_study)?;
        }
        if !self.study.has_stiffness() {
            let remedy =
                "Write stiffness = 20.0 under [coupling] of the study, or what telespring decide says.";
            return Err(InvalidInput::missing("study.coupling.stiffness", "N/m", remedy));
        }
        if !self.device.is_real() {
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
        self.check_proof()
    }

    /// Checks that the guard is proven for the robots of the study, as `compare` asks before it recommends one: what it
    /// gives out without having it is then small.
    fn check_proof(&self) -> Result<(), InvalidInput> {
        let stiffness = self.study.coupling()?.stiffness;
        let overdraft = self.study.guard_overdraft(stiffness).map_err(spoken::of_study)?;
        if overdraft.is_proven() {
            return Ok(());
        }
        let largest = (10.0 * overdraft.proven_stiffness).floor() / 10.0;
        Err(InvalidInput::new(
            "study.coupling.stiffness",
            format!("{stiffness} N/m"),
            format!(
                "with these robots and controllers the guard is proven up to {largest} N/m only, and a person holds the robot"
            ),
            format!(
                "Use at most {largest} N/m, or shorten the sample period, the computing time or the lag of the force."
            ),
        ))
    }
}

/// How long a session takes at most, from seconds.
///
/// # Errors
///
/// [`InvalidInput`] if that is not 0.1 to 86400 s.
pub fn check_duration(seconds: f64) -> Result<Span, InvalidInput> {
    span("seconds", seconds, [0.1, 86_400.0], 20.0)
}

/// An address that only this machine reaches.
fn loopback(field: &str, address: SocketAddr) -> Result<SocketAddr, InvalidInput> {
    if address.ip().is_loopback() {
        return Ok(address);
    }
    Err(InvalidInput::new(
        field,
        address,
        "an address of this machine: nobody checks who sends a packet",
        "Write 127.0.0.1 with a port here, or transport = \"iroh\" for another machine.",
    ))
}

/// The text of a file.
fn read(path: &Path, what: &str) -> Result<String, InvalidInput> {
    std::fs::read_to_string(path).map_err(|error| {
        let value = path.display();
        InvalidInput::new(what, value, format!("the file cannot be read ({error})"), "Check the path.")
    })
}
