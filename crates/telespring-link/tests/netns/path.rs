//! The impaired path between two TUN devices: one thread that carries packets both ways.

use std::io::ErrorKind;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, poll};
use rustix::time::Timespec;
use telespring_link::real_time;
use tun_rs::SyncDevice;

use super::line::{Counts, Line, Way};

/// What a test and the thread of a path share.
#[derive(Debug)]
struct Shared {
    /// What each way does, from side 0 and from side 1.
    ways: Mutex<[Way; 2]>,
    counts: Mutex<[Counts; 2]>,
    is_over: AtomicBool,
}

/// A path between two TUN devices. It ends when it is dropped.
#[derive(Debug)]
pub struct Path {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl Path {
    /// A path that does this each way; the two ways draw apart.
    pub fn new(devices: [SyncDevice; 2], way: Way, seed: u64) -> Self {
        let shared = Arc::new(Shared {
            ways: Mutex::new([way; 2]),
            counts: Mutex::default(),
            is_over: AtomicBool::new(false),
        });
        let of_thread = Arc::clone(&shared);
        let lines = [0, 1].map(|side| Line::new(way, 2 * seed + side));
        let thread = std::thread::Builder::new()
            .name("path".to_owned())
            .spawn(move || carry(&devices, lines, &of_thread))
            .unwrap();
        Self { shared, thread: Some(thread) }
    }

    /// Changes both ways from now on.
    pub fn change(&self, change: impl Fn(&mut Way)) {
        self.shared.ways.lock().unwrap().iter_mut().for_each(change);
    }

    /// Changes the way from a side.
    pub fn change_from(&self, side: usize, change: impl FnOnce(&mut Way)) {
        change(&mut self.shared.ways.lock().unwrap()[side]);
    }

    /// What became of the packets so far, of side 0 and of side 1.
    pub fn counts(&self) -> [Counts; 2] {
        *self.shared.counts.lock().unwrap()
    }

    /// As [`Path::counts`], once nothing travels any more.
    pub fn counts_at_rest(&self) -> [Counts; 2] {
        let patience = Instant::now() + Duration::from_secs(30);
        let mut before = self.counts();
        loop {
            std::thread::sleep(Duration::from_millis(50));
            let counts = self.counts();
            if counts == before && counts.iter().all(|way| way.travelling() == 0) {
                return counts;
            }
            assert!(Instant::now() < patience, "the path does not come to rest: {counts:?}");
            before = counts;
        }
    }
}

impl Drop for Path {
    fn drop(&mut self) {
        self.shared.is_over.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Carries packets until the path is over. What the kernel says of itself in IPv6 does not count and is not carried.
fn carry(devices: &[SyncDevice; 2], mut lines: [Line; 2], shared: &Shared) {
    // above the loops of the tests: a busy machine does not make the path slower than asked, where this is granted
    let _ = real_time::claim(Some(20), false, false);
    let start = Instant::now();
    let mut room = [0; 2048];
    while !shared.is_over.load(Ordering::Relaxed) {
        let ways = *shared.ways.lock().unwrap();
        for side in 0..2 {
            lines[side].way = ways[side];
            while let Ok(length) = devices[side].recv(&mut room) {
                if room[0] >> 4 == 4 {
                    lines[side].take(start.elapsed().as_secs_f64(), &room[..length]);
                }
            }
            while let Some(packet) = lines[side].give(start.elapsed().as_secs_f64()) {
                match devices[1 - side].send(&packet) {
                    Ok(_) => {}
                    Err(error) if error.kind() == ErrorKind::WouldBlock => {}
                    Err(error) => panic!("the path cannot deliver: {error}"),
                }
            }
        }
        *shared.counts.lock().unwrap() = lines.each_ref().map(Line::counts);
        let now = start.elapsed().as_secs_f64();
        let next = lines.iter().filter_map(Line::next_due).fold(now + 5e-3, f64::min);
        let wait = Timespec { tv_sec: 0, tv_nsec: ((next - now).max(0.0) * 1e9) as i64 };
        let mut readable = devices.each_ref().map(|device| PollFd::new(device, PollFlags::IN));
        let _ = poll(&mut readable, Some(&wait));
    }
}
