//! What the loop tells others while it runs: every tick and every event, through a queue without locks.
//!
//! Each [`Observer`] has a queue and a thread of its own. One that falls behind misses items and is told how many; the loop
//! never waits for it.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

use rtrb::{Consumer, Producer, RingBuffer};
use telespring::session::{LocalTime, Span};

use crate::site::{Arrival, Happened, Moment};
use crate::summary::Summary;

/// Items that a queue holds: 8 s at 1 kHz, with an arrival per tick.
const CAPACITY: usize = 16_384;
/// How long an observer's thread rests once its queue is empty.
const REST: Duration = Duration::from_millis(5);
/// How long the end of a session waits for an observer that cannot go on, for instance for a disk.
const PATIENCE: Duration = Duration::from_secs(10);

/// Something that the loop tells.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "most items are ticks, and a box would allocate on the loop")]
pub enum Item {
    /// A tick.
    Tick {
        /// The tick.
        moment: Moment,
        /// How late it began.
        lateness: Span,
        /// How long it took.
        duration: Span,
        /// Ticks that were left out so far.
        overruns: u64,
    },
    /// A datagram that the endpoint was given; it comes before the tick at which it was.
    Arrival(Arrival),
    /// Something has happened; it comes before the tick at which it did.
    Event {
        /// When.
        time: LocalTime,
        /// What.
        happened: Happened,
    },
}

/// Whoever wants to see a session while it runs, on a thread of its own.
pub trait Observer: Send {
    /// What it does, in a word: the name of its thread.
    fn name(&self) -> &'static str;

    /// Takes the next item.
    fn take(&mut self, item: &Item);

    /// So many items found no room in the queue since the last call.
    fn miss(&mut self, _count: u64) {}

    /// The queue is empty; called some 200 times per second.
    fn rest(&mut self) {}

    /// The session is over, and no further item comes.
    fn finish(&mut self, _summary: &Summary) {}
}

/// The end of a queue on the loop's thread.
#[derive(Debug)]
struct Queue {
    items: Producer<Item>,
    /// Items that found no room.
    missed: Arc<AtomicU64>,
}

/// The loop's ends of all queues.
#[derive(Debug, Default)]
pub struct Feed {
    queues: Vec<Queue>,
}

impl Feed {
    /// Hands an item to every observer that has room. Neither waits nor allocates.
    pub fn publish(&mut self, item: Item) {
        for queue in &mut self.queues {
            if queue.items.push(item).is_err() {
                queue.missed.fetch_add(1, Ordering::Relaxed);
            }
        }
    }
}

/// The threads of the observers.
#[derive(Debug)]
pub struct Observers {
    threads: Vec<JoinHandle<()>>,
    /// Set once the session is over.
    summary: Arc<OnceLock<Summary>>,
}

impl std::fmt::Debug for dyn Observer {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(self.name())
    }
}

/// Starts a thread for each observer. Call it before the loop's thread asks for a real-time priority, which new threads
/// would inherit.
///
/// # Errors
///
/// That of the operating system if it gives no thread.
pub fn start(observers: Vec<Box<dyn Observer>>) -> std::io::Result<(Feed, Observers)> {
    let summary = Arc::new(OnceLock::new());
    let (mut queues, mut threads) = (Vec::new(), Vec::new());
    for observer in observers {
        let (items, consumer) = RingBuffer::new(CAPACITY);
        let missed = Arc::default();
        queues.push(Queue { items, missed: Arc::clone(&missed) });
        let summary = Arc::clone(&summary);
        let thread = Builder::new().name(observer.name().to_owned());
        threads.push(thread.spawn(move || watch(observer, consumer, &missed, &summary))?);
    }
    Ok((Feed { queues }, Observers { threads, summary }))
}

impl Observers {
    /// Lets every observer see what is still in its queue and finish, on its own thread: the caller's may have a real-time
    /// priority. One that cannot go on is left behind after 10 s; returns the names of those, and of those that have broken off.
    pub fn finish(self, summary: &Summary) -> Vec<String> {
        // nobody else sets it
        let _ = self.summary.set(summary.clone());
        let end = Instant::now() + PATIENCE;
        let mut unfinished = Vec::new();
        for thread in self.threads {
            let name = thread.thread().name().unwrap_or("observer").to_owned();
            while !thread.is_finished() && Instant::now() < end {
                std::thread::sleep(REST);
            }
            if !(thread.is_finished() && thread.join().is_ok()) {
                unfinished.push(name);
            }
        }
        unfinished
    }
}

/// The thread of an observer.
fn watch(
    mut observer: Box<dyn Observer>,
    mut items: Consumer<Item>,
    missed: &AtomicU64,
    summary: &OnceLock<Summary>,
) {
    loop {
        // read before the queue: what was published before the end is still seen
        let summary = summary.get();
        while let Ok(item) = items.pop() {
            observer.take(&item);
        }
        match missed.swap(0, Ordering::Relaxed) {
            0 => {}
            count => observer.miss(count),
        }
        if let Some(summary) = summary {
            return observer.finish(summary);
        }
        observer.rest();
        std::thread::sleep(REST);
    }
}

#[cfg(test)]
mod tests {
    use std::net::UdpSocket;
    use std::sync::Mutex;
    use std::sync::mpsc::{Receiver, channel};
    use std::thread::ThreadId;

    use telespring::study::Study;

    use super::*;
    use crate::device::Simulated;
    use crate::real_time::{Pace, Privileges};
    use crate::site::{Safety, Site, SiteSettings};
    use crate::transport::Udp;

    /// What an observer saw: the times of the events, how many it missed, and the threads that called it.
    #[derive(Debug, Default)]
    struct Seen {
        times: Vec<u64>,
        missed: u64,
        threads: Vec<ThreadId>,
        is_finished: bool,
    }

    /// Keeps what it sees; while `gate` is held it stands still.
    struct Slow {
        gate: Arc<Mutex<()>>,
        seen: Arc<Mutex<Seen>>,
    }

    impl Observer for Slow {
        fn name(&self) -> &'static str {
            "slow"
        }

        fn take(&mut self, item: &Item) {
            let _open = self.gate.lock().unwrap();
            let mut seen = self.seen.lock().unwrap();
            seen.threads.push(std::thread::current().id());
            if let Item::Event { time, .. } = item {
                seen.times.push(time.0);
            }
        }

        fn miss(&mut self, count: u64) {
            self.seen.lock().unwrap().missed += count;
        }

        fn finish(&mut self, _: &Summary) {
            let mut seen = self.seen.lock().unwrap();
            seen.threads.push(std::thread::current().id());
            seen.is_finished = true;
        }
    }

    /// Stands still until its other end is gone.
    struct Stuck(Receiver<()>);

    impl Observer for Stuck {
        fn name(&self) -> &'static str {
            "stuck"
        }

        fn take(&mut self, _: &Item) {
            let _ = self.0.recv();
        }
    }

    fn event(time: u64) -> Item {
        Item::Event { time: LocalTime(time), happened: Happened::Restored }
    }

    /// That of a session without a tick.
    fn summary() -> Summary {
        let study = Study::paper();
        let settings = SiteSettings::new(&study, 1, 1, Safety::default()).unwrap();
        let device = Simulated::new(&study.laboratory().unwrap(), 0, 1).unwrap();
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        let there = socket.local_addr().unwrap();
        let site = Site::new(settings.simulated(), device, Udp::on(socket, there).unwrap()).unwrap();
        let nothing = Privileges { priority: None, locked_memory: None, awake: None };
        Summary::new(1, &site, &Pace::new(Span(1_000_000)).lateness(), &nothing)
    }

    #[test]
    fn law_what_finds_no_room_is_counted_and_nobody_waits() {
        let (gate, seen) = (Arc::new(Mutex::new(())), Arc::new(Mutex::new(Seen::default())));
        let slow = Slow { gate: Arc::clone(&gate), seen: Arc::clone(&seen) };
        let (mut feed, observers) = start(vec![Box::new(slow)]).unwrap();
        let count = 3 * CAPACITY as u64;
        {
            let _closed = gate.lock().unwrap();
            (0..count).for_each(|time| feed.publish(event(time)));
        }
        assert!(observers.finish(&summary()).is_empty());
        let Seen { times, missed, threads, is_finished } = std::mem::take(&mut *seen.lock().unwrap());
        assert_eq!(times.len() as u64 + missed, count);
        // the oldest come first, in their order, and at most one more than the queue holds
        assert!((CAPACITY..=CAPACITY + 1).contains(&times.len()), "{}", times.len());
        assert!(times.iter().copied().eq(0..times.len() as u64));
        // all of it on a thread of its own, the end included: that of the loop has a real-time priority
        assert!(is_finished && threads.iter().all(|thread| *thread == threads[0]));
        assert_ne!(threads[0], std::thread::current().id());
    }

    #[test]
    fn law_a_stuck_observer_keeps_nothing_from_the_others() {
        let (release, stuck) = channel();
        let seen = Arc::new(Mutex::new(Seen::default()));
        let slow = Slow { gate: Arc::default(), seen: Arc::clone(&seen) };
        let (mut feed, observers) = start(vec![Box::new(Stuck(stuck)), Box::new(slow)]).unwrap();
        (0..100).for_each(|time| feed.publish(event(time)));
        while seen.lock().unwrap().times.len() < 100 {
            std::thread::sleep(REST);
        }
        assert!(!observers.threads[0].is_finished());
        drop(release);
        assert!(observers.finish(&summary()).is_empty());
        assert!(seen.lock().unwrap().is_finished);
    }
}
