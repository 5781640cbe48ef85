//! The connections with the partner: usually one.
//!
//! Both sides dial, because perhaps only one of them can be reached, and one that has started anew dials while the other one
//! still holds the former connection. So there may be two for a moment. Datagrams are taken from all of them. The side with the
//! smaller id closes all but its newest one; the other side sends on the one on which it heard last. If the smaller one has the
//! newest one, the other one hears on it at once, so both use the same.
//!
//! Who dials is connected before the partner has looked at its key, so a connection counts only once something has come over it.
//! Both send an empty datagram ten times per second, as a sign of life, for that.

use std::cell::{Cell, RefCell};
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
    /// Counts the connections of this site. iroh's own number is a place in memory, which a later connection may have again.
    number: u64,
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
    /// Connections so far.
    number: Cell<u64>,
    /// Whether what comes is taken.
    is_open: Cell<bool>,
    /// A connection has come or gone.
    pub(super) changed: Notify,
}

impl Links {
    /// No connection yet; `is_open`: see [`Links::set_open`].
    pub(super) fn new(own: EndpointId, inbox: Inbox, shared: Arc<Shared>, is_open: bool) -> Rc<Self> {
        Rc::new(Self {
            own,
            links: RefCell::new(Vec::with_capacity(MOST + 1)),
            inbox: RefCell::new(inbox),
            shared,
            number: Cell::new(0),
            is_open: Cell::new(is_open),
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
        // a former partner that may speak again is heard no more
        for link in links.extract_if(.., |link| link.connection.remote_id() != partner) {
            link.connection.close(reason::BUSY, b"another partner");
        }
        let number = self.number.get() + 1;
        self.number.set(number);
        links.push(Link { number, connection: connection.clone(), heard: Instant::now(), is_proven: false });
        let is_arbiter = self.own < partner;
        let keep = if is_arbiter { 1 } else { MOST };
        let many = links.len().saturating_sub(keep);
        for link in links.drain(..many) {
            link.connection.close(reason::REPLACED, b"replaced");
        }
        drop(links);
        self.changed.notify_waiters();
        tokio::task::spawn_local(Rc::clone(self).read(number, connection));
    }

    /// Reads datagrams until the connection ends.
    async fn read(self: Rc<Self>, number: u64, connection: Connection) {
        let end = loop {
            let datagram = match connection.read_datagram().await {
                Ok(datagram) => datagram,
                Err(end) => break end,
            };
            // one that this site has closed still gives what had come before
            if self.note(number) && self.is_open.get() && !datagram.is_empty() {
                count(&self.shared.received, 1);
                let has_overflowed = self.inbox.borrow_mut().push(&datagram);
                count(&self.shared.overflowed, u64::from(has_overflowed));
            }
        };
        if matches!(&end, ConnectionError::ApplicationClosed(close) if close.error_code == reason::UNKNOWN) {
            self.shared.is_unknown.store(true, Relaxed);
        }
        self.links.borrow_mut().retain(|link| link.number != number);
        self.changed.notify_waiters();
    }

    /// The partner was heard on a connection: the next datagrams go there. False if this site has closed it.
    fn note(&self, number: u64) -> bool {
        let mut links = self.links.borrow_mut();
        let Some(at) = links.iter().position(|link| link.number == number) else { return false };
        let last = links.len().saturating_sub(1);
        if let Some(link) = links.get_mut(at) {
            link.heard = Instant::now();
            if !link.is_proven {
                link.is_proven = true;
                count(&self.shared.connections, 1);
            }
        }
        links.swap(at, last);
        true
    }

    /// The connection to send on. A silent one counts, too: the partner may be heard again.
    pub(super) fn current(&self) -> Option<Connection> {
        self.links.borrow().last().map(|link| link.connection.clone())
    }

    /// The number of the connection to send on.
    pub(super) fn current_number(&self) -> u64 {
        self.links.borrow().last().map_or(0, |link| link.number)
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

    /// Closes every connection, so that the partner is looked for anew: under all its addresses.
    pub(super) fn renew(&self) {
        for link in self.links.borrow_mut().drain(..) {
            link.connection.close(reason::WITHHELD, b"no way that is allowed");
        }
        self.changed.notify_waiters();
    }

    /// Whether what comes is taken: not while it may come over a relay that this site does not allow.
    pub(super) fn set_open(&self, is_open: bool) {
        self.is_open.set(is_open);
    }

    /// Hands the loop what has waited for room.
    pub(super) fn flush(&self) {
        self.inbox.borrow_mut().flush();
    }
}
