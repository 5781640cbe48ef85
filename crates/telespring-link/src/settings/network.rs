//! `[network]`: where this site listens, and who the partner is.

use std::net::SocketAddr;

use serde::Deserialize;
use telespring::InvalidInput;

use super::loopback;

/// The way to the partner.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum NetworkChoice {
    /// UDP between two addresses of this machine.
    Udp {
        /// Where this site listens.
        local: SocketAddr,
        /// The partner's address.
        peer: SocketAddr,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Text {
    local: SocketAddr,
    peer: SocketAddr,
}

impl NetworkChoice {
    pub(super) fn new(text: Text) -> Result<Self, InvalidInput> {
        let Text { local, peer } = text;
        Ok(Self::Udp { local: loopback("network.local", local)?, peer: loopback("network.peer", peer)? })
    }
}
