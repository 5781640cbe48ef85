//! The connections with the partner: usually one.
//!
//! Both sides dial, because perhaps only one of them can be reached, and one that has started anew dials while the other one
//! still holds the former connection. So there may be two for a moment. Datagrams are taken from all of them. The side with the
//! smaller id closes all but its newest one; the other side sends on the one on which it heard last. If the smaller one has the
//! newest one, the other one hears on it at once, so both use the same.
//!
//! Who dials is connected before the partner has looked at its key, so a connection counts only once something has come over it.
//! Both send an empty datagram ten times per second, as a sign of life, for that.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use std::time::{Duration, Instant};

use bytes::Bytes;
use iroh::EndpointId;
use iroh::endpoint::{Connection, ConnectionError};
use tokio::sync::Notify;

use super::admission::reason;
use super::packet::Inbox;
use super::shared::{Shared, count};

/// Connections at a time.
const MOST: usize = 3;
/// A partner that is silent for this long is looked for anew.
const SILENCE: Duration = Duration::from_millis(1500);

#[derive(Debug)]
struct Link {
    connection: Connection,
    heard: Instant,
    /// A datagram has come: the partner has let this site in.
    is_proven: bool,
}

/// The connections with the partner, newest last.
#[derive(Debug)]
pub(super) struct Links {
    own: EndpointId,
    links: RefCell<Vec<Link>>,
    inbox: RefCell<Inbox>,
    shared: Arc<Shared>,
    /// Whether what comes is taken.
    is_open: std::cell::Cell<bool>,
    /// A connection has come or gone.
    pub(super) changed: Notify,
}

impl Links {
    pub(super) fn new(own: EndpointId, inbox: Inbox, shared: Arc<Shared>) -> Rc<Self> {
        Rc::new(Self {
            own,
            links: RefCell::new(Vec::with_capacity(MOST + 1)),
            inbox: RefCell::new(inbox),
            shared,
            is_open: std::cell::Cell::new(true),
            changed: Notify::new(),
        })
    }

    /// Takes a connection with a partner on the allow-list, and reads from it until it ends.
    pub(super) fn add(self: &Rc<Self>, connection: Connection) {
        let partner = connection.remote_id();
        let mut links = self.links.borrow_mut();
        if links.iter().any(|link| link.connection.remote_id() != partner && link.heard.elapsed() < SILENCE) {
            count(&self.shared.refused, 1);
            connection.close(reason::BUSY, b"another partner");
            return;
        }
        let is_arbiter = self.own < partner;
        links.push(Link { connection: connection.clone(), heard: Instant::now(), is_proven: false });
        let keep = if is_arbiter { 1 } else { MOST };
        let many = links.len().saturating_sub(keep);
        for link in links.drain(..many) {
            link.connection.close(reason::REPLACED, b"replaced");
        }
        links.retain(|link| link.connection.remote_id() == partner);
        drop(links);
        self.changed.notify_waiters();
        tokio::task::spawn_local(Rc::clone(self).read(connection));
    }

    /// Reads datagrams until the connection ends.
    async fn read(self: Rc<Self>, connection: Connection) {
        let id = connection.stable_id();
        let end = loop {
            let datagram = match connection.read_datagram().await {
                Ok(datagram) => datagram,
                Err(end) => break end,
            };
            self.note(id);
            if self.is_open.get() && !datagram.is_empty() {
                count(&self.shared.received, 1);
                let has_overflowed = self.inbox.borrow_mut().push(&datagram);
                count(&self.shared.overflowed, u64::from(has_overflowed));
            }
        };
        if matches!(&end, ConnectionError::ApplicationClosed(close) if close.error_code == reason::UNKNOWN) {
            self.shared.is_unknown.store(true, Relaxed);
        }
        self.links.borrow_mut().retain(|link| link.connection.stable_id() != id);
        self.changed.notify_waiters();
    }

    /// The partner was heard on a connection: the next datagrams go there.
    fn note(&self, id: usize) {
        let mut links = self.links.borrow_mut();
        let last = links.len().saturating_sub(1);
        if let Some(at) = links.iter().position(|link| link.connection.stable_id() == id) {
            if let Some(link) = links.get_mut(at) {
                link.heard = Instant::now();
                if !link.is_proven {
                    link.is_proven = true;
                    count(&self.shared.connections, 1);
                }
            }
            links.swap(at, last);
        }
    }

    /// The connection to send on. A silent one counts, too: the partner may be heard again.
    pub(super) fn current(&self) -> Option<Connection> {
        self.links.borrow().last().map(|link| link.connection.clone())
    }

    /// Whether there is a connection with a sign of life lately, perhaps one over which nothing has come yet.
    pub(super) fn is_alive(&self) -> bool {
        self.links.borrow().iter().any(|link| link.heard.elapsed() < SILENCE)
    }

    /// Whether the partner has let this site in, and has given a sign of life lately.
    pub(super) fn is_connected(&self) -> bool {
        self.links.borrow().iter().any(|link| link.is_proven && link.heard.elapsed() < SILENCE)
    }

    /// Gives a sign of life on each connection.
    pub(super) fn greet(&self) {
        for link in self.links.borrow().iter() {
            let _ = link.connection.send_datagram(Bytes::new());
        }
    }

    /// Whether what comes is taken: not while it comes over a relay that this site does not allow.
    pub(super) fn set_open(&self, is_open: bool) {
        self.is_open.set(is_open);
    }

    /// Hands the loop what has waited for room.
    pub(super) fn flush(&self) {
        self.inbox.borrow_mut().flush();
    }
}
