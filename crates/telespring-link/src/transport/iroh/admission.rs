//! Who is let in: keys on the allow-list, and no more handshakes at a time than this site can bear.

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::{Duration, Instant};

use iroh::endpoint::{AfterHandshakeOutcome, Connection, EndpointHooks, Incoming, IncomingAddr, VarInt};
use iroh::{Endpoint, EndpointId};
use tokio::sync::mpsc::Sender;
use tokio::task::JoinSet;

use super::shared::{Shared, count};

/// Handshakes at a time from addresses that are not the partner's, and from those that are.
const HANDSHAKES: [usize; 2] = [8, 16];
/// From this many on, a stranger's address has to answer before this site keeps anything about it.
const UNPROVEN: usize = 2;
/// Handshakes per second from addresses that are not the partner's, and how many of them may come at once.
const STRANGERS: (f64, f64) = (10.0, 20.0);
/// How long a handshake may take.
const HANDSHAKE: Duration = Duration::from_secs(5);

/// Why this site closes a connection; the code goes to the other side.
pub(super) mod reason {
    use super::VarInt;

    /// The key is not on the allow-list.
    pub(in super::super) const UNKNOWN: VarInt = VarInt::from_u32(1);
    /// This site has another partner now.
    pub(in super::super) const BUSY: VarInt = VarInt::from_u32(2);
    /// There is a newer connection with the same partner.
    pub(in super::super) const REPLACED: VarInt = VarInt::from_u32(3);
}

/// The allow-list. Both the one who dials and the one who is dialled have proven their keys when it is asked.
#[derive(Debug)]
pub(super) struct AllowList {
    pub(super) ids: Vec<EndpointId>,
    pub(super) shared: Arc<Shared>,
}

impl EndpointHooks for AllowList {
    async fn after_handshake<'a>(&'a self, connection: &'a Connection) -> AfterHandshakeOutcome {
        if self.ids.contains(&connection.remote_id()) {
            return AfterHandshakeOutcome::Accept;
        }
        count(&self.shared.refused, 1);
        AfterHandshakeOutcome::Reject { error_code: reason::UNKNOWN, reason: b"unknown key".to_vec() }
    }
}

/// So many per second, and so many at once.
#[derive(Debug)]
struct Bucket {
    left: f64,
    since: Instant,
}

impl Bucket {
    fn take(&mut self, now: Instant) -> bool {
        let (rate, most) = STRANGERS;
        let passed = now.duration_since(self.since).as_secs_f64();
        self.since = now;
        self.left = (self.left + passed * rate).min(most);
        let has = self.left >= 1.0;
        if has {
            self.left -= 1.0;
        }
        has
    }
}

/// Answers who dials, as long as the site lives. Connections that are let in go to `established`.
pub(super) async fn accept(
    endpoint: Endpoint,
    partners: Vec<SocketAddr>,
    shared: Arc<Shared>,
    established: Sender<Connection>,
) {
    let mut handshakes = JoinSet::new();
    let mut bucket = Bucket { left: STRANGERS.1, since: Instant::now() };
    loop {
        tokio::select! {
            incoming = endpoint.accept() => {
                let Some(incoming) = incoming else { return };
                let is_partner = matches!(incoming.remote_addr(), IncomingAddr::Ip(address) if partners.contains(&address));
                let running = handshakes.len();
                let is_welcome = running < HANDSHAKES[usize::from(is_partner)]
                    && (is_partner || bucket.take(Instant::now()));
                if !is_welcome {
                    count(&shared.refused, 1);
                    incoming.ignore();
                } else if !is_partner && running >= UNPROVEN && !incoming.remote_addr_validated() {
                    // costs this site nothing to remember; it goes to the address that may be forged, and is smaller
                    // than what came
                    let _ = incoming.retry();
                } else {
                    handshakes.spawn(shake(incoming, established.clone()));
                }
            }
            Some(_) = handshakes.join_next() => {}
        }
    }
}

async fn shake(incoming: Incoming, established: Sender<Connection>) {
    let Ok(accepting) = incoming.accept() else { return };
    // a connection that has not proven its key yet carries no data: 0-RTT is never asked for
    if let Ok(Ok(connection)) = tokio::time::timeout(HANDSHAKE, accepting).await {
        let _ = established.send(connection).await;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_strangers_come_at_a_bounded_rate() {
        let start = Instant::now();
        let mut bucket = Bucket { left: STRANGERS.1, since: start };
        let let_in =
            (0..10_000_u32).filter(|number| bucket.take(start + *number * Duration::from_millis(1))).count();
        // 20 at once and 10 per second
        assert!((115..=121).contains(&let_in), "{let_in}");
    }
}
