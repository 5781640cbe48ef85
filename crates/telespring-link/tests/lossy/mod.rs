//! A path between two sites on this machine that loses datagrams, or all of them, for several tests.

#![allow(dead_code, reason = "no test needs all of it")]

use std::net::{SocketAddr, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::thread::JoinHandle;
use std::time::Duration;

/// What became of the datagrams of one way.
#[derive(Debug, Default)]
pub struct Way {
    pub came: AtomicU64,
    pub lost: AtomicU64,
}

/// A path from a site with an address of IPv6 only to one with IPv4 only, so that there is no other one between them.
pub struct Lossy {
    /// Where each site finds the other one.
    pub doors: [SocketAddr; 2],
    /// From the first to the second, and back.
    pub ways: [Arc<Way>; 2],
    /// Nothing gets through.
    pub is_cut: Arc<AtomicBool>,
    ends: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
}

impl Lossy {
    /// Between two sites at these addresses; each datagram is lost with this probability.
    pub fn new(sites: [SocketAddr; 2], probability: f64) -> std::io::Result<Self> {
        assert!(sites[0].is_ipv6() && sites[1].is_ipv4());
        let sockets = [UdpSocket::bind("[::1]:0")?, UdpSocket::bind("127.0.0.1:0")?];
        let doors = [sockets[0].local_addr()?, sockets[1].local_addr()?];
        let ways: [Arc<Way>; 2] = [Arc::default(), Arc::default()];
        let (is_cut, ends) = (Arc::<AtomicBool>::default(), Arc::<AtomicBool>::default());
        let threads = (0..2)
            .map(|from| {
                let [near, far] =
                    [&sockets[from], &sockets[1 - from]].map(|socket| socket.try_clone().unwrap());
                near.set_read_timeout(Some(Duration::from_millis(50))).unwrap();
                let (way, is_cut, ends) = (Arc::clone(&ways[from]), Arc::clone(&is_cut), Arc::clone(&ends));
                let to = sites[1 - from];
                // a generator of our own: the same losses each time (xorshift, Marsaglia)
                let mut state = 0x9e37_79b9_7f4a_7c15_u64 + from as u64;
                std::thread::spawn(move || {
                    let mut room = [0; 2000];
                    while !ends.load(Relaxed) {
                        let Ok((length, _)) = near.recv_from(&mut room) else { continue };
                        way.came.fetch_add(1, Relaxed);
                        state ^= state << 13;
                        state ^= state >> 7;
                        state ^= state << 17;
                        let is_lost = ((state >> 11) as f64 / (1_u64 << 53) as f64) < probability;
                        if is_lost || is_cut.load(Relaxed) {
                            way.lost.fetch_add(1, Relaxed);
                        } else {
                            let _ = far.send_to(&room[..length], to);
                        }
                    }
                })
            })
            .collect();
        Ok(Self { doors, ways, is_cut, ends, threads })
    }

    /// The share of datagrams lost from side `from` on.
    pub fn share(&self, from: usize) -> f64 {
        let way = &self.ways[from];
        way.lost.load(Relaxed) as f64 / way.came.load(Relaxed).max(1) as f64
    }
}

impl Drop for Lossy {
    fn drop(&mut self) {
        self.ends.store(true, Relaxed);
        for thread in self.threads.drain(..) {
            let _ = thread.join();
        }
    }
}
