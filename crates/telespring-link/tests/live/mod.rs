//! A site on a thread of this process, in a namespace, with every tick on record.

#![allow(dead_code, reason = "every test uses its part")]

mod known;
#[path = "../sites/mod.rs"]
mod sites;

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use rtrb::{Producer, RingBuffer};
use telespring::session::{Span, WatchdogState};
use telespring::study::Study;
use telespring_link::conduct::{Plan, conduct};
use telespring_link::demo::ROBOTS;
use telespring_link::device::Simulated;
use telespring_link::hello::draw_session;
use telespring_link::operator::Order;
use telespring_link::real_time::Limits;
use telespring_link::settings::{LoopChoice, PaceChoice};
use telespring_link::site::{Consent, Fallback, Moment, Phase, Rules, Safety, SiteSettings};
use telespring_link::summary::{Entry, Summary};
use telespring_link::transport::Transport;

use super::netns::Joined;
pub use known::{Known, PORT};

/// A real-time priority where it is granted. Where it is not, a busy machine keeps a loop from its tick for tens of
/// milliseconds, again and again.
const PRIORITY: LoopChoice =
    LoopChoice { priority: Some(10), lock_memory: false, stay_awake: false, pace: PaceChoice::Clock };
/// For the same reason a standstill of the loop does not let the force go here: the partner's silence is judged.
pub const SAFETY: Safety =
    Safety { silence: Span(150_000_000), stall: Span(100_000_000), ramp_out: Span(100_000_000) };
/// Stiffness of the spring, N/m: above what the paper's robots bear without a guard at 20 ms with losses.
pub const STIFFNESS: f64 = 142.0;
/// Two sites that are coupled wherever their handles are, and go on however bad the network is, unless the partner is silent for
/// this long: here the endpoint and its transport are judged.
fn rules(silence: Span) -> Rules {
    let patience = Span(600_000_000_000);
    let usual = Fallback::default();
    let fallback = Fallback { loss: 1.0, held: 1.0, age: 60.0, softened: 1.0, patience, silence, ..usual };
    Rules { consent: Consent::Automatic, alignment: 10.0, rest: 10.0, fallback, ..Rules::default() }
}

/// No test waits longer for anything.
const PATIENCE: Duration = Duration::from_secs(60);

/// The paper's robots behind the guard, as a study writes them.
pub fn study_text() -> String {
    format!(
        "{ROBOTS}coupling.stiffness = {STIFFNESS}\nnetwork.delay = 0.02\n\
         session = {{strategy = \"guard\", playout = \"adaptive\"}}\n"
    )
}

pub fn study() -> Study {
    Study::from_toml(&study_text()).unwrap()
}

/// What the thread of a site tells the test, and is told.
#[derive(Debug, Default)]
struct Progress {
    moments: Mutex<Vec<Moment>>,
    engaged: AtomicU64,
    /// Ticks in a row without a force.
    idle: AtomicU64,
    stop: AtomicBool,
    dies: AtomicBool,
}

impl Progress {
    fn note(&self, moment: &Moment) {
        self.moments.lock().unwrap().push(*moment);
        if moment.state == WatchdogState::Engaged && moment.phase == Phase::Running {
            self.engaged.fetch_add(1, Ordering::Relaxed);
        }
        if moment.force == [0.0; 2] {
            self.idle.fetch_add(1, Ordering::Relaxed);
        } else {
            self.idle.store(0, Ordering::Relaxed);
        }
        if self.dies.load(Ordering::Relaxed) {
            resume_unwind(Box::new("died"));
        }
    }
}

/// A site that runs.
#[derive(Debug)]
pub struct Live {
    side: usize,
    progress: Arc<Progress>,
    operator: Mutex<Producer<Order>>,
    thread: Option<JoinHandle<Option<Summary>>>,
}

/// What a site did, tick by tick, and its summary.
#[derive(Debug)]
pub struct Trace {
    pub moments: Vec<Moment>,
    pub summary: Summary,
}

impl Trace {
    /// Whether this event, with this cause if one is given, is in the summary.
    pub fn has(&self, event: &str, cause: Option<&str>) -> bool {
        let mut events = self.summary.events.iter();
        events.any(|entry| entry.event == event && (cause.is_none() || entry.cause.as_deref() == cause))
    }

    /// How often such an event is on record.
    pub fn count(&self, event: &str) -> usize {
        self.summary.events.iter().filter(|entry| entry.event == event).count()
    }

    /// How often a silence took the force, in the order that it has to be, and the force came back or the session was left.
    pub fn silences(&self) -> usize {
        let silence = Some("silence");
        let mut silences = 0;
        let mut events = self.summary.events.iter();
        while let Some(entry) = events.next() {
            if entry.event == "leaving" {
                // it lets go anyway, and what a silence does to that force is not told to its end
                break;
            }
            if (entry.event, entry.cause.as_deref()) != ("force-ramping-out", silence) {
                continue;
            }
            // what the session says beside its endpoint does not count
            let is_endpoints =
                |entry: &&Entry| matches!(entry.event, "disengaged" | "partner-restarted" | "engaged");
            let mut after = events.by_ref().filter(is_endpoints);
            let end = after.next().map(|entry| (entry.event, entry.cause.as_deref()));
            assert!(
                matches!(end, Some(("disengaged" | "partner-restarted" | "leaving", _))),
                "{end:?} after a force that ramps out: {:#?}",
                self.summary.events
            );
            silences += 1;
            if end.is_some_and(|(event, _)| event == "leaving") {
                break;
            }
        }
        silences
    }
}

impl Live {
    /// Starts the site of side 0 or 1 in its namespace, with the simulated robot of the study; `link` opens the way to the
    /// partner there.
    pub fn start<T: Transport>(
        joined: &Joined,
        side: usize,
        study: &str,
        silence: Span,
        link: impl FnOnce() -> T + Send + 'static,
    ) -> Self {
        let progress = Arc::new(Progress::default());
        let namespace = joined.namespaces[side].clone();
        let study = Study::from_toml(study).unwrap();
        let of_thread = Arc::clone(&progress);
        let (operator, orders) = RingBuffer::new(16);
        let site = move || {
            namespace.enter();
            let number = u8::try_from(side).unwrap() + 1;
            let device = Simulated::new(&study.laboratory().unwrap(), side, 3).unwrap();
            let settings = SiteSettings::new(&study, number, draw_session(), SAFETY).unwrap();
            let settings = SiteSettings { rules: rules(silence), ..settings };
            let limits = Limits { duration: Some(Span::from_seconds(120.0)) };
            let plan = Plan { real_time: PRIORITY, limits, orders: Some(orders), ..Plan::default() };
            let watch = |moment: &Moment| of_thread.note(moment);
            let run = || conduct(settings, device, link(), plan, &of_thread.stop, watch).unwrap();
            catch_unwind(AssertUnwindSafe(run)).ok()
        };
        let thread = std::thread::Builder::new().name(format!("site {}", side + 1)).spawn(site).unwrap();
        Self { side, progress, operator: Mutex::new(operator), thread: Some(thread) }
    }

    /// Waits for something, and gives up loudly.
    fn wait(&self, what: &str, is_so: impl Fn() -> bool) {
        let begin = Instant::now();
        while !is_so() {
            let latest = self.progress.moments.lock().unwrap().last().copied();
            assert!(begin.elapsed() < PATIENCE, "site {} waits for {what}: {latest:?}", self.side + 1);
            assert!(!self.has_ended(), "site {} has ended before {what}: {latest:?}", self.side + 1);
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    pub fn has_ended(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Waits until the site has been engaged for this many ticks from now.
    pub fn wait_engaged(&self, ticks: u64) {
        let engaged = || self.progress.engaged.load(Ordering::Relaxed);
        let before = engaged();
        self.wait("a force", || engaged() >= before + ticks);
    }

    /// Waits until the force has been zero for this many ticks.
    pub fn wait_idle(&self, ticks: u64) {
        self.wait("no force", || self.progress.idle.load(Ordering::Relaxed) >= ticks);
    }

    /// Gives an order, as the person at the site does.
    pub fn order(&self, order: Order) {
        self.operator.lock().unwrap().push(order).unwrap();
    }

    /// Lets the site leave, and waits for its end.
    pub fn leave(mut self) -> Trace {
        self.progress.stop.store(true, Ordering::Relaxed);
        self.finish()
    }

    /// Waits for the end that somebody else brings about.
    pub fn finish(&mut self) -> Trace {
        let begin = Instant::now();
        while !self.has_ended() && begin.elapsed() < PATIENCE {
            std::thread::sleep(Duration::from_millis(2));
        }
        assert!(self.has_ended(), "site {} does not end", self.side + 1);
        let summary = self.thread.take().unwrap().join().unwrap().expect("the site has broken off");
        Trace { moments: std::mem::take(&mut self.progress.moments.lock().unwrap()), summary }
    }

    /// The site ends in the middle of a tick, and its socket with it: nobody hears a goodbye. Returns its ticks.
    pub fn die(mut self) -> Vec<Moment> {
        self.progress.dies.store(true, Ordering::Relaxed);
        assert!(self.thread.take().unwrap().join().unwrap().is_none());
        std::mem::take(&mut self.progress.moments.lock().unwrap())
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        self.progress.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
