//! `[network]`: where this site listens, and who the partner is.

use std::net::{IpAddr, SocketAddr};
use std::path::{Path, PathBuf};

use iroh::RelayUrl;
use serde::Deserialize;
use telespring::InvalidInput;

use super::loopback;
use super::several::Several;
use crate::keys::{SiteId, SiteKey, parse_ids};
use crate::transport::{Authority, IrohSettings};

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
    /// iroh: any network, and a partner that is known by its key.
    Iroh(IrohChoice),
}

/// What a site file says of iroh.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct IrohChoice {
    /// The file of this site's key.
    pub key: PathBuf,
    /// The allow-list.
    pub peer_ids: Vec<SiteId>,
    /// Addresses of the partner.
    pub peers: Vec<SocketAddr>,
    /// Where this site listens.
    pub local: Vec<SocketAddr>,
    /// A relay of one's own.
    pub relay: Option<RelayUrl>,
    /// The file of the authority of the relay's certificate.
    pub relay_authority: Option<PathBuf>,
    /// Whether datagrams may go over the relay for good.
    pub relayed: bool,
}

#[derive(Deserialize, Clone, Copy, PartialEq, Eq, Default)]
#[serde(rename_all = "kebab-case")]
enum Word {
    #[default]
    Udp,
    Iroh,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Text {
    #[serde(default)]
    transport: Word,
    #[serde(default)]
    local: Several<SocketAddr>,
    #[serde(default)]
    peer: Several<SocketAddr>,
    key: Option<PathBuf>,
    #[serde(default)]
    peer_id: Several<String>,
    relay: Option<String>,
    relay_authority: Option<PathBuf>,
    relayed: Option<bool>,
}

impl NetworkChoice {
    /// The kind in a word.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Udp { .. } => "udp",
            Self::Iroh(_) => "iroh",
        }
    }

    pub(super) fn new(text: Text) -> Result<Self, InvalidInput> {
        match text.transport {
            Word::Udp => udp(text),
            Word::Iroh => IrohChoice::new(text).map(Self::Iroh),
        }
    }

    /// Takes relative paths from a folder.
    pub(super) fn within(mut self, folder: &Path) -> Self {
        if let Self::Iroh(choice) = &mut self {
            choice.key = folder.join(&choice.key);
            choice.relay_authority = choice.relay_authority.take().map(|path| folder.join(path));
        }
        self
    }
}

fn udp(text: Text) -> Result<NetworkChoice, InvalidInput> {
    let Text { transport: _, local, peer, key, peer_id, relay, relay_authority, relayed } = text;
    let given = [
        ("key", key.is_some()),
        ("peer_id", !peer_id.0.is_empty()),
        ("relay", relay.is_some()),
        ("relay_authority", relay_authority.is_some()),
        ("relayed", relayed.is_some()),
    ];
    if let Some((key, _)) = given.iter().find(|(_, is_given)| *is_given) {
        return Err(InvalidInput::new(
            format!("network.{key}"),
            "given",
            "UDP between two addresses of this machine knows neither keys nor relays",
            "Write transport = \"iroh\", or leave it out.",
        ));
    }
    let one = |field: &str, addresses: Vec<SocketAddr>| match addresses[..] {
        [address] => loopback(field, address),
        [] => Err(InvalidInput::missing(field, "an address of this machine", "Write 127.0.0.1 with a port.")),
        _ => Err(InvalidInput::new(field, addresses.len(), "one address", "Remove the others.")),
    };
    Ok(NetworkChoice::Udp { local: one("network.local", local.0)?, peer: one("network.peer", peer.0)? })
}

impl IrohChoice {
    fn new(text: Text) -> Result<Self, InvalidInput> {
        let Text { transport: _, local, peer, key, peer_id, relay, relay_authority, relayed } = text;
        let key = key.ok_or_else(|| {
            let remedy = "Make one with telespring-link keygen, and give its path.";
            InvalidInput::missing("network.key", "the file of this site's key", remedy)
        })?;
        let choice = Self {
            key,
            peer_ids: parse_ids("network.peer_id", &peer_id.0)?,
            peers: peer.0,
            local: local.0,
            relay: relay.as_deref().map(relay_url).transpose()?,
            relay_authority,
            relayed: relayed.unwrap_or(false),
        };
        choice.check()?;
        Ok(choice)
    }

    fn check(&self) -> Result<(), InvalidInput> {
        let families = [IpAddr::is_ipv4, IpAddr::is_ipv6];
        if self.local.is_empty() {
            let remedy = "Write \"0.0.0.0:4500\", or an address of this machine with a port.";
            return Err(InvalidInput::missing("network.local", "where this site listens", remedy));
        }
        for is_family in families {
            let number = self.local.iter().filter(|address| is_family(&address.ip())).count();
            if number > 1 {
                let allowed = "at most one address of IPv4 and one of IPv6";
                return Err(InvalidInput::new("network.local", number, allowed, "Remove one."));
            }
        }
        for peer in &self.peers {
            let ip = peer.ip();
            let is_broadcast = ip == IpAddr::V4(std::net::Ipv4Addr::BROADCAST);
            if ip.is_unspecified() || ip.is_multicast() || is_broadcast || peer.port() == 0 {
                let remedy = "Give the address and port at which the partner can be reached.";
                return Err(InvalidInput::new(
                    "network.peer",
                    peer,
                    "an address of one machine, and a port",
                    remedy,
                ));
            }
            if !self.local.iter().any(|local| local.is_ipv4() == peer.is_ipv4()) {
                let remedy = "Add \"0.0.0.0:4500\" or \"[::]:4500\" to network.local.";
                let allowed = "an address of the same kind (IPv4, IPv6) as one of network.local";
                return Err(InvalidInput::new("network.peer", peer, allowed, remedy));
            }
        }
        let needs_relay = [("relayed", self.relayed), ("relay_authority", self.relay_authority.is_some())];
        if let Some((key, _)) = needs_relay.iter().find(|(_, is_given)| *is_given && self.relay.is_none()) {
            return Err(InvalidInput::new(
                format!("network.{key}"),
                "given",
                "a relay that it is about",
                format!("Give the address of your own relay as network.relay, or leave {key} out."),
            ));
        }
        Ok(())
    }

    /// What the transport is made of: reads the files. `priority`: that of the loop, if it has one.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if a file cannot be read, or the key is the partner's.
    pub fn settings(&self, priority: Option<i32>) -> Result<IrohSettings, InvalidInput> {
        let key = SiteKey::read("network.key", &self.key)?;
        if self.peer_ids.contains(&key.id()) {
            let remedy = "Ask the partner for the line of telespring-link id.";
            return Err(InvalidInput::new(
                "network.peer_id",
                key.id(),
                "the partner's id, not this site's",
                remedy,
            ));
        }
        let relay_authority = self
            .relay_authority
            .as_deref()
            .map(|path| Authority::read("network.relay_authority", path))
            .transpose()?;
        let Self { key: _, peer_ids, peers, local, relay, relay_authority: _, relayed } = self.clone();
        let priority = priority.map(|priority| priority - 1).filter(|priority| *priority > 0);
        Ok(IrohSettings { key, peer_ids, peers, local, relay, relay_authority, relayed, priority })
    }
}

/// The address of a relay: encrypted, or on this machine.
fn relay_url(text: &str) -> Result<RelayUrl, InvalidInput> {
    let refuse = || {
        let remedy = "Give that of your own relay; telespring-link relay-config says how to run one.";
        InvalidInput::new(
            "network.relay",
            format!("{text:?}"),
            "https:// and the name of a relay of your own",
            remedy,
        )
    };
    let url: RelayUrl = text.parse().map_err(|_| refuse())?;
    let host = url.host_str().unwrap_or_default();
    let bare = host.trim_start_matches('[').trim_end_matches(']');
    let is_here = bare.parse().is_ok_and(|ip: IpAddr| ip.is_loopback());
    let is_plain = url.username().is_empty() && url.password().is_none() && url.query().is_none();
    let is_fine =
        is_plain && !host.is_empty() && (url.scheme() == "https" || (url.scheme() == "http" && is_here));
    if is_fine { Ok(url) } else { Err(refuse()) }
}
