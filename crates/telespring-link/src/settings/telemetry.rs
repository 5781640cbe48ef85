//! `[telemetry]`: who on this machine is sent what every tick says.

use std::net::SocketAddr;

use serde::Deserialize;
use telespring::InvalidInput;

use super::loopback;

/// The most addresses.
const MOST: usize = 4;

/// Who is sent the rows of [`crate::telemetry`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TelemetryChoice {
    /// Where they listen, on this machine.
    pub addresses: Vec<SocketAddr>,
    /// A row every so many ticks.
    pub every: u32,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Text {
    address: Addresses,
    #[serde(default = "usual_every")]
    every: u32,
}

#[derive(Deserialize)]
#[serde(untagged, expecting = "an address such as \"127.0.0.1:4700\", or up to 4 of them in brackets")]
enum Addresses {
    One(SocketAddr),
    Several(Vec<SocketAddr>),
}

fn usual_every() -> u32 {
    1
}

impl TelemetryChoice {
    pub(super) fn new(text: Text) -> Result<Self, InvalidInput> {
        let Text { address, every } = text;
        let addresses = match address {
            Addresses::One(address) => vec![address],
            Addresses::Several(addresses) => addresses,
        };
        if !(1..=MOST).contains(&addresses.len()) {
            let (value, remedy) = (format!("{} addresses", addresses.len()), "Name those that listen.");
            return Err(InvalidInput::new("telemetry.address", value, format!("1 to {MOST}"), remedy));
        }
        if !(1..=1000).contains(&every) {
            return Err(InvalidInput::new("telemetry.every", every, "1 to 1000 ticks", "Give 1."));
        }
        let addresses = addresses
            .into_iter()
            .map(|address| loopback("telemetry.address", address))
            .collect::<Result<_, _>>()?;
        Ok(Self { addresses, every })
    }
}
