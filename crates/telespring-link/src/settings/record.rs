//! `[recording]` and `[live]`: who sees the session beside the people.

use std::net::SocketAddr;
use std::path::PathBuf;

use serde::Deserialize;
use telespring::InvalidInput;

use super::loopback;

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct Recording {
    pub(super) folder: Option<PathBuf>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct Live {
    address: Option<SocketAddr>,
}

/// Where viewers may look on.
pub(super) fn address(live: &Live) -> Result<Option<SocketAddr>, InvalidInput> {
    live.address.map(|address| loopback("live.address", address)).transpose()
}
