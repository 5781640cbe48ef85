//! What two sites over iroh do in several tests: find each other, and exchange.

use std::net::{SocketAddr, UdpSocket};
use std::time::{Duration, Instant};

use telespring::session::LocalTime;
use telespring_link::transport::{Iroh, PathEvent, ROOM, Transport};

/// How long anything may take on a busy machine.
const PATIENCE: Duration = Duration::from_secs(30);
/// The iroh transport does not ask for the time.
pub const NOW: LocalTime = LocalTime(0);

/// An address of this machine that nobody has.
pub fn free_address() -> SocketAddr {
    UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap()
}

/// Waits until `done` says so.
pub fn wait(what: &str, mut done: impl FnMut() -> bool) {
    let start = Instant::now();
    while !done() {
        assert!(start.elapsed() < PATIENCE, "{what}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Waits for a path event.
pub fn wait_for(site: &mut Iroh, expected: PathEvent) {
    wait(&format!("{expected:?}"), || site.poll_path() == Some(expected));
}

/// Sends from one to the other until something arrives, and returns it.
pub fn exchange(from: &mut Iroh, to: &mut Iroh, content: &[u8]) -> Vec<u8> {
    let mut room = [0; ROOM];
    let mut got = None;
    wait("a datagram", || {
        from.send(NOW, content);
        while let Some(length) = to.receive(NOW, &mut room) {
            if room.starts_with(content) {
                got = Some(room[..length].to_vec());
            }
        }
        got.is_some()
    });
    got.unwrap()
}
