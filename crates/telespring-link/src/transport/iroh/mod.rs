//! iroh: QUIC datagrams to and from a partner that is known by its key, encrypted, over any network.
//!
//! The loop pushes into one bounded queue, pops from another one, and wakes the thread of the network by one write; it takes no
//! lock and allocates nothing. That thread owns the endpoint and everything of tokio. `docs/network.md` says what goes where.

mod admission;
mod authority;
mod bell;
mod links;
mod network;
mod packet;
mod quic;
mod rate;
mod shared;
mod withheld;

use std::io::{Error, ErrorKind};
use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::mpsc::sync_channel;
use std::thread::JoinHandle;

use ::iroh::RelayUrl;
use rtrb::{Consumer, Producer, RingBuffer};
use telespring::session::LocalTime;

use super::{PathEvent, ROOM, Transport, TransportReport};
use crate::keys::{SiteId, SiteKey};
pub use authority::Authority;
use bell::Bell;
pub use network::ALPN;
use network::Ends;
use packet::{INBOX, Inbox, OUTBOX, Packet};
use shared::{Shared, Told, Way};

/// Who this site is, who the partner is, and where both are.
#[derive(Debug, Clone)]
pub struct IrohSettings {
    /// The key of this site.
    pub key: SiteKey,
    /// The allow-list: who may be the partner, one at a time.
    pub peer_ids: Vec<SiteId>,
    /// Addresses of the partner; none if only the partner dials, or it is found over the relay.
    pub peers: Vec<SocketAddr>,
    /// Where this site listens: at most one address of IPv4 and one of IPv6.
    pub local: Vec<SocketAddr>,
    /// A relay of one's own, to find a way through two firewalls.
    pub relay: Option<RelayUrl>,
    /// The authority of the relay's certificate; `None`: one on Mozilla's list.
    pub relay_authority: Option<Authority>,
    /// Whether datagrams may take the way over the relay for good.
    pub relayed: bool,
    /// The real-time priority of the thread of the network: less than the loop's. `None` for an ordinary thread.
    pub priority: Option<i32>,
}

/// Datagrams to and from a partner that is known by its key.
#[derive(Debug)]
pub struct Iroh {
    outbox: Producer<Packet>,
    inbox: Consumer<Packet>,
    bell: Bell,
    shared: Arc<Shared>,
    told: Told,
    /// Packets that could have been sent; one of `every` was.
    turn: u64,
    thinned: u64,
    unsent: u64,
    /// The thread of the network is gone.
    is_broken: bool,
    local: Vec<SocketAddr>,
    thread: Option<JoinHandle<()>>,
}

impl Iroh {
    /// Binds the addresses, and looks for the partner from now on.
    ///
    /// # Errors
    ///
    /// Those of the operating system, for instance if a port is in use.
    pub fn new(settings: &IrohSettings) -> Result<Self, Error> {
        let (outbox, to_network) = RingBuffer::new(OUTBOX);
        let (to_loop, inbox) = RingBuffer::new(INBOX);
        let (bell, shared) = (Bell::new()?, Arc::new(Shared::default()));
        let ends = Ends {
            outbox: to_network,
            inbox: Inbox::new(to_loop),
            bell: bell.clone(),
            shared: Arc::clone(&shared),
        };
        let (bound, answer) = sync_channel(1);
        let settings = settings.clone();
        let thread = std::thread::Builder::new()
            .name("network".to_owned())
            .spawn(move || network::run(&settings, ends, &bound))?;
        let broken = |_| Error::other("the thread of the network has broken off");
        let local =
            answer.recv().map_err(broken)?.map_err(|error| Error::new(ErrorKind::AddrNotAvailable, error))?;
        Ok(Self {
            outbox,
            inbox,
            bell,
            shared,
            told: Told::default(),
            turn: 0,
            thinned: 0,
            unsent: 0,
            is_broken: false,
            local,
            thread: Some(thread),
        })
    }

    /// The addresses where this site listens.
    pub fn local_addresses(&self) -> &[SocketAddr] {
        &self.local
    }
}

impl Transport for Iroh {
    fn is_due(&mut self) -> bool {
        self.turn = self.turn.wrapping_add(1);
        let is_due = self.turn.is_multiple_of(u64::from(self.shared.every()));
        self.thinned += u64::from(!is_due);
        is_due
    }

    fn send(&mut self, _: LocalTime, datagram: &[u8]) {
        if self.outbox.push(Packet::new(datagram)).is_ok() {
            self.bell.ring();
        } else {
            self.unsent += 1;
        }
    }

    fn receive(&mut self, _: LocalTime, room: &mut [u8; ROOM]) -> Option<usize> {
        let packet = self.inbox.pop().ok()?;
        let bytes = packet.bytes();
        for (place, byte) in room.iter_mut().zip(bytes) {
            *place = *byte;
        }
        Some(bytes.len())
    }

    fn poll_path(&mut self) -> Option<PathEvent> {
        if self.outbox.is_abandoned() && !self.is_broken {
            // the thread of the network has broken off: nothing comes or goes any more
            self.is_broken = true;
            self.shared.set_way(Way::None);
        }
        self.told.news(&self.shared)
    }

    fn report(&self) -> TransportReport {
        let report = self.shared.report(self.thinned);
        TransportReport { unsent: report.unsent + self.unsent, ..report }
    }
}

impl Drop for Iroh {
    fn drop(&mut self) {
        self.shared.stop.store(true, Relaxed);
        self.bell.ring();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn site() -> Iroh {
        Iroh::new(&IrohSettings {
            key: SiteKey::generate(),
            peer_ids: vec![SiteKey::generate().id()],
            peers: Vec::new(),
            local: vec![SocketAddr::from(([127, 0, 0, 1], 0))],
            relay: None,
            relay_authority: None,
            relayed: false,
            priority: None,
        })
        .unwrap()
    }

    #[test]
    fn law_a_network_that_breaks_off_is_told_once() {
        let mut site = site();
        site.shared.set_way(Way::Direct);
        assert_eq!(site.poll_path(), Some(PathEvent::Direct));
        // the thread ends, whatever for
        site.shared.stop.store(true, Relaxed);
        site.bell.ring();
        let start = std::time::Instant::now();
        let told = std::iter::repeat_with(|| site.poll_path()).find(|told| {
            std::thread::sleep(std::time::Duration::from_millis(1));
            told.is_some() || start.elapsed().as_secs() > 30
        });
        assert_eq!(told, Some(Some(PathEvent::Lost)));
        assert_eq!(site.poll_path(), None);
    }

    #[test]
    fn law_packets_are_left_out_evenly() {
        let mut site = site();
        for every in [1, 2, 4] {
            site.shared.set_every(every);
            let due: Vec<bool> = (0..100).map(|_| site.is_due()).collect();
            for some in due.chunks(usize::from(every)) {
                assert_eq!(some.iter().filter(|is_due| **is_due).count(), 1, "{every}");
            }
        }
    }
}
