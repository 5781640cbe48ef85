//! The site file of a partner that is known by its key.

use std::net::SocketAddr;

/// The file of this side, 1 or 2, with the key `N.key` of its own; further tables go behind it.
pub fn over_iroh(study: &str, side: usize, peer_id: &str, local: SocketAddr, peer: SocketAddr) -> String {
    format!(
        "study = \"{study}\"\nside = {side}\n\n[network]\ntransport = \"iroh\"\nkey = \"{side}.key\"\npeer_id = \"{peer_id}\"\n\
         local = \"{local}\"\npeer = [\"{peer}\"]\n"
    )
}
