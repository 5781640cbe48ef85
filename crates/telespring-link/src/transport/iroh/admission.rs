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
/// From this many on, an address has to answer before this site keeps anything about it.
const UNPROVEN: usize = 2;
/// Handshakes per second that are answered, and how many of them may come at once: for strangers, and likewise for what says that
/// it comes from an address of the partner, as long as it has not proven that.
const RATE: (f64, f64) = (10.0, 20.0);
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
    /// There is no way that this site allows: it looks for the partner anew.
    pub(in super::super) const WITHHELD: VarInt = VarInt::from_u32(4);
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
    fn new(now: Instant) -> Self {
        Self { left: RATE.1, since: now }
    }

    fn take(&mut self, now: Instant) -> bool {
        let (rate, most) = RATE;
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

/// What becomes of somebody who dials.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Answer {
    /// The handshake begins.
    Welcome,
    /// The address has to answer first. This site keeps nothing meanwhile; what it sends goes to the address that may be forged,
    /// and is smaller than what came.
    Prove,
    /// Nothing is said.
    Ignore,
}

/// Decides whose handshake begins.
#[derive(Debug)]
struct Door {
    strangers: Bucket,
    partners: Bucket,
}

impl Door {
    fn new(now: Instant) -> Self {
        Self { strangers: Bucket::new(now), partners: Bucket::new(now) }
    }

    /// `is_partner`: it comes from an address of the partner, or says so; `is_proven`: the address has answered; `running`:
    /// handshakes now.
    fn answer(&mut self, now: Instant, is_partner: bool, is_proven: bool, running: usize) -> Answer {
        if running >= HANDSHAKES[usize::from(is_partner)] {
            return Answer::Ignore;
        }
        let is_crowded = running >= UNPROVEN;
        match (is_partner, is_proven) {
            // whoever floods in the partner's name must not keep the partner out
            (true, true) => Answer::Welcome,
            (true, false) if is_crowded || !self.partners.take(now) => Answer::Prove,
            (false, _) if !self.strangers.take(now) => Answer::Ignore,
            (false, false) if is_crowded => Answer::Prove,
            _ => Answer::Welcome,
        }
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
    let mut door = Door::new(Instant::now());
    loop {
        tokio::select! {
            incoming = endpoint.accept() => {
                let Some(incoming) = incoming else { return };
                let is_partner = matches!(incoming.remote_addr(), IncomingAddr::Ip(address) if partners.contains(&address));
                let is_proven = incoming.remote_addr_validated();
                match door.answer(Instant::now(), is_partner, is_proven, handshakes.len()) {
                    Answer::Welcome => {
                        handshakes.spawn(shake(incoming, established.clone()));
                    }
                    Answer::Prove => {
                        let _ = incoming.retry();
                    }
                    Answer::Ignore => {
                        count(&shared.refused, 1);
                        incoming.ignore();
                    }
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
        let mut door = Door::new(start);
        let answers = (0..10_000_u32).map(|number| start + number * Duration::from_millis(1));
        let let_in = answers.filter(|now| door.answer(*now, false, false, 0) == Answer::Welcome).count();
        // 20 at once and 10 per second
        assert!((115..=121).contains(&let_in), "{let_in}");
        let later = start + Duration::from_secs(20);
        assert_eq!(door.answer(later, false, false, UNPROVEN), Answer::Prove);
        assert_eq!(door.answer(later, false, true, UNPROVEN), Answer::Welcome);
        assert_eq!(door.answer(later, false, true, HANDSHAKES[0]), Answer::Ignore);
    }

    #[test]
    fn law_who_floods_in_the_partners_name_must_prove_it_and_does_not_keep_the_partner_out() {
        let start = Instant::now();
        let mut door = Door::new(start);
        let forged: Vec<Answer> = (0..10_000_u32)
            .map(|number| door.answer(start + number * Duration::from_millis(1), true, false, 0))
            .collect();
        let welcome = forged.iter().filter(|answer| **answer == Answer::Welcome).count();
        assert!((115..=121).contains(&welcome), "{welcome}");
        assert!(!forged.contains(&Answer::Ignore));
        // an address that answers is the partner's
        let end = start + Duration::from_secs(10);
        assert_eq!(door.answer(end, true, true, HANDSHAKES[1] - 1), Answer::Welcome);
        // strangers do not use up what is the partner's, nor the other way round
        assert_eq!(door.answer(end, false, false, 0), Answer::Welcome);
        // many at a time are as many that must prove it
        assert_eq!(door.answer(end + Duration::from_secs(10), true, false, UNPROVEN), Answer::Prove);
        assert_eq!(door.answer(end, true, true, HANDSHAKES[1]), Answer::Ignore);
    }
}
