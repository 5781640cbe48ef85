//! `[device]`: the robot of a site.

use std::net::SocketAddr;

use serde::Deserialize;
use telespring::InvalidInput;
use telespring::session::Span;

use super::loopback;
use super::range::span;

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

#[derive(Deserialize)]
#[serde(tag = "kind", deny_unknown_fields, rename_all = "kebab-case")]
pub(super) enum Text {
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

impl Default for Text {
    fn default() -> Self {
        Self::Simulated { seed: usual_seed() }
    }
}

impl DeviceChoice {
    pub(super) fn new(text: Text) -> Result<Self, InvalidInput> {
        Ok(match text {
            Text::Simulated { seed } => Self::Simulated { seed },
            Text::Udp { local, device, deadline } => Self::Udp {
                local: loopback("device.local", local)?,
                device: loopback("device.device", device)?,
                deadline: span("device.deadline", deadline, [0.005, 1.0], usual_deadline())?,
            },
        })
    }

    /// The kind in a word.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Simulated { .. } => "simulated",
            Self::Udp { .. } => "udp",
        }
    }

    /// Whether a person may hold this robot.
    pub fn is_real(&self) -> bool {
        !matches!(self, Self::Simulated { .. })
    }
}
