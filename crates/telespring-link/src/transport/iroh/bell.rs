//! How the loop wakes the thread of the network: by one write that does not wait.

#![allow(
    unsafe_code,
    reason = "tokio waits for a file descriptor of one's own only at one's own promise that it stays"
)]

use std::io::Error;
use std::os::fd::OwnedFd;
use std::sync::Arc;

use rustix::event::{EventfdFlags, eventfd};
use tokio::io::Interest;
use tokio::io::unix::AsyncFd;

/// The loop's end.
#[derive(Debug, Clone)]
pub(super) struct Bell(Arc<OwnedFd>);

/// The end of the thread of the network.
#[derive(Debug)]
pub(super) struct Ear(AsyncFd<Arc<OwnedFd>>);

impl Bell {
    pub(super) fn new() -> Result<Self, Error> {
        Ok(Self(Arc::new(eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK)?)))
    }

    /// Wakes the other thread. It cannot fail but for a count of 2⁶⁴ − 2, which the other thread has then to catch up with.
    pub(super) fn ring(&self) {
        let _ = rustix::io::write(&*self.0, &1_u64.to_ne_bytes());
    }

    /// The other end, within a tokio runtime.
    pub(super) fn ear(&self) -> Result<Ear, Error> {
        // SAFETY: the descriptor is shared, never exchanged, and closes with its last owner, after this one.
        Ok(Ear(unsafe { AsyncFd::register_with_interest(Arc::clone(&self.0), Interest::READABLE) }?))
    }
}

impl Ear {
    /// Waits until the bell has rung since the last call.
    pub(super) async fn listen(&self) {
        while let Ok(mut ready) = self.0.readable().await {
            let mut count = [0; 8];
            let read = rustix::io::read(&**ready.get_inner(), &mut count);
            ready.clear_ready();
            if read.is_ok() {
                return;
            }
        }
        // the runtime ends
        std::future::pending().await
    }
}
