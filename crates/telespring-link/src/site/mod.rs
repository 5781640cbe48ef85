//! One side of a live coupling: device, endpoint, transport and the state of the session.
//!
//! Both sides derive the state ([`Phase`]) from where each of them stands; see [`accord`] and `docs/connect.md`. A force acts
//! in `ramping-in`, `running` and `ramping-out` only.
//!
//! A site reads no clock of its own and waits for nothing: [`Site::tick`] is called once per sample period with the clock
//! to use, a real one or that of a test.

mod accord;
mod alignment;
mod arrivals;
mod awaited;
mod coupling;
mod fallback;
mod force;
mod greeter;
mod limits;
mod locks;
mod log;
mod measuring;
mod moment;
mod notes;
mod notices;
mod orders;
mod passed_over;
mod phase;
mod reporting;
mod round_trip;
mod settings;
mod travel;

pub use fallback::{Badness, Fallback};
pub use limits::Limits;
pub use log::{Happened, LOG_CAPACITY, Log};
pub use moment::{Moment, Tally};
pub use notes::{Arrival, Forces, Latency, Newest};
pub use notices::Limit;
pub use phase::{Cause, Interruption, Phase, Why};
pub use settings::{Consent, Rules, Safety, SiteSettings};

use std::os::fd::BorrowedFd;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use rtrb::Consumer;
use telespring::InvalidInput;
use telespring::session::strategy::StrategyChoice;
use telespring::session::{Endpoint, LocalTime, Motion, SessionReport, Span, WatchdogState};

use crate::clock::Clock;
use crate::device::{Command, Device};
use crate::hello::{Purpose, Terms};
use crate::operator::Order;
use crate::transport::{PathEvent, Transport, TransportReport};
use accord::Accord;
use alignment::Alignment;
use awaited::Awaited;
use coupling::Coupling;
use fallback::Watch;
use force::ForceGate;
use greeter::Greeter;
use notes::Notes;
use notices::Notices;
use passed_over::PassedOver;
use round_trip::RoundTrips;
use travel::Travel;

/// From one greeting to the next.
const GREETING_INTERVAL: Span = Span(50_000_000);
/// From one goodbye to the next.
const GOODBYE_INTERVAL: Span = Span(10_000_000);

/// One side of a live coupling. After its construction it allocates nothing, takes no lock and does not panic.
#[derive(Debug)]
pub struct Site<D, T> {
    device: D,
    transport: T,
    endpoint: Endpoint,
    /// Whether the endpoint has a watchdog.
    is_watched: bool,
    greeter: Greeter,
    accord: Accord,
    alignment: Alignment,
    round_trips: RoundTrips,
    gate: ForceGate,
    watch: Watch,
    notices: Notices,
    safety: Safety,
    limits: Limits,
    rules: Rules,
    phase: Phase,
    coupling: Coupling,
    /// Since when the session leaves, and why.
    left: Option<(LocalTime, Cause)>,
    /// Since when the delay that is imposed is shorter than the network's own.
    too_short_since: Option<LocalTime>,
    /// When the next greeting or goodbye is due.
    greet_at: LocalTime,
    /// The latest own motion as the device reported it, and how fast its positions change.
    handle: Option<Motion>,
    travel: Travel,
    /// The same without the axes that are locked, here or there.
    motion: Option<Motion>,
    lock: [bool; 2],
    /// From the own handle to the partner's, m.
    offset: Option<[f64; 2]>,
    /// The partner's latest packet that the endpoint took.
    heard: Option<LocalTime>,
    /// Packets that came while nothing was coupled.
    passed_over: PassedOver,
    /// Whether the own consent that was told last holds.
    told_consent: bool,
    /// Who has not come yet.
    awaited: Awaited,
    /// Whether a stranger was told.
    told_stranger: bool,
    /// When an impossible force of the device was told last.
    impossible_force: Option<LocalTime>,
    /// Ticks that the strategy had limited before this one.
    limited_ticks: u64,
    /// How long the machine had been suspended at the latest tick.
    suspended: Option<Span>,
    /// Whether the emergency stop is pressed now.
    is_pressed: bool,
    /// Whether the time for this session is over.
    is_expired: bool,
    orders: Option<Consumer<Order>>,
    log: Log,
    tally: Tally,
    notes: Notes,
    /// Somebody outside sets it when the recording has broken off.
    recording_alarm: Arc<AtomicBool>,
}

impl<D: Device, T: Transport> Site<D, T> {
    /// A site at the beginning of its session.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] for a setting out of range.
    pub fn new(settings: SiteSettings, device: D, transport: T) -> Result<Self, InvalidInput> {
        let SiteSettings { terms, endpoint, safety, limits, rules } = settings;
        let terms = Terms { lock: limits.lock, ..terms };
        safety.check()?;
        limits.check()?;
        rules.check()?;
        let session = endpoint.session;
        if session == 0 {
            return Err(InvalidInput::new(
                "session",
                0,
                "a session id is not 0",
                "Draw one with hello::draw_session().",
            ));
        }
        Ok(Self {
            device,
            transport,
            gate: ForceGate::new(
                &limits,
                endpoint.sample_period,
                endpoint.computing_tick,
                lag(&endpoint.strategy),
            ),
            is_watched: endpoint.watchdog.is_some(),
            endpoint: Endpoint::new(endpoint)?,
            alignment: Alignment::new(rules.alignment, rules.rest, terms.side),
            greeter: Greeter::new(session, terms),
            accord: Accord::default(),
            round_trips: RoundTrips::default(),
            watch: Watch::new(rules.fallback),
            notices: Notices::default(),
            safety,
            limits,
            rules,
            phase: Phase::Connecting,
            coupling: Coupling::Off,
            left: None,
            too_short_since: None,
            greet_at: LocalTime(0),
            handle: None,
            travel: Travel::default(),
            motion: None,
            lock: limits.lock,
            offset: None,
            heard: None,
            passed_over: PassedOver::default(),
            told_consent: false,
            awaited: Awaited::new(),
            told_stranger: false,
            impossible_force: None,
            limited_ticks: 0,
            suspended: None,
            is_pressed: false,
            is_expired: false,
            orders: None,
            log: Log::new(),
            tally: Tally::default(),
            notes: Notes::new(),
            recording_alarm: Arc::default(),
        })
    }

    /// Takes orders from this queue at every tick, beside those of the device.
    pub fn obey(&mut self, orders: Consumer<Order>) {
        self.orders = Some(orders);
    }

    /// Measures, sends, receives and commands once; `stop` asks the session to end.
    pub fn tick(&mut self, clock: &impl Clock, stop: bool) -> Moment {
        let now = clock.now();
        self.log.begin_tick();
        self.notes.begin();
        let was_coupled = self.coupling != Coupling::Off;
        self.judge_machine(now, clock.suspended());
        let reading = self.read(now);
        self.take_orders(now);
        if stop {
            self.leave(now, Cause::StopRequested);
        } else if self.is_expired {
            self.leave(now, Cause::TimeOver);
        }
        self.judge(now);
        match &reading {
            Some(reading) if self.coupling != Coupling::Off || self.owes(reading) => {
                self.measure(now, reading)
            }
            _ if self.coupling == Coupling::Off && !self.is_resting() => {
                self.notes.is_timed = true;
                self.endpoint.handle_timeout(now);
            }
            _ => {}
        }
        self.greet(now);
        self.receive(clock);
        self.decide(now);
        let force = self.force(clock.now());
        let commanded = clock.now();
        let is_over = self.phase == Phase::Ended;
        self.device.command(commanded, Command { force, is_running: self.phase.is_coupled(), is_over });
        self.tell(now, was_coupled || self.coupling != Coupling::Off);
        self.collect(now, commanded, reading.as_ref(), force)
    }

    /// Whether the endpoint's force is zero. It must be before a coupling begins, so that the force begins from zero.
    fn is_resting(&self) -> bool {
        !self.is_watched || matches!(self.endpoint.state(), WatchdogState::Disengaged { .. })
    }

    /// Sends the greetings that are due.
    fn greet(&mut self, now: LocalTime) {
        let (purpose, interval) = match self.left {
            Some(_) => (Purpose::Goodbye, GOODBYE_INTERVAL),
            None => (Purpose::Hello, GREETING_INTERVAL),
        };
        if now >= self.greet_at || self.greeter.is_urgent() {
            self.greet_at = now + interval;
            self.accord.own.phase = self.phase.code();
            let greeting = self.greeter.greeting(purpose, self.accord.own, self.round_trips.stamps(now));
            self.transport.send(now, &greeting.encode());
            if !self.told_stranger && self.transport.report().strangers > 0 {
                self.told_stranger = true;
                self.log.push(now, Happened::Path(PathEvent::Stranger));
            }
        }
    }

    /// Says in the log when this switch is set, and resets it: the recording has broken off.
    pub fn watch_recording(&mut self, alarm: Arc<AtomicBool>) {
        self.recording_alarm = alarm;
    }

    /// The datagrams that the endpoint was given at the latest tick, in their order.
    pub fn arrivals(&self) -> &[Arrival] {
        self.notes.arrivals()
    }

    /// The state of the session.
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// Why the session leaves or has ended.
    pub fn cause(&self) -> Option<Cause> {
        self.left.map(|(_, cause)| cause)
    }

    /// What has happened, oldest first.
    pub fn log(&self) -> &Log {
        &self.log
    }

    /// Counts and sums over the ticks.
    pub fn tally(&self) -> &Tally {
        &self.tally
    }

    /// The endpoint's report.
    pub fn session_report(&self) -> SessionReport {
        let mut report = self.endpoint.report();
        report.playout.lost = self.passed_over.lost(report.playout.lost);
        report
    }

    /// The transport's report.
    pub fn transport_report(&self) -> TransportReport {
        self.transport.report()
    }

    /// The device.
    pub fn device(&self) -> &D {
        &self.device
    }

    /// Whether the device has measured anew since the latest tick, if it has a pace of its own.
    pub fn listen(&mut self, now: LocalTime) -> bool {
        self.device.listen(now)
    }

    /// The time for this session is over: the next tick leaves it.
    pub fn expire(&mut self) {
        self.is_expired = true;
    }

    /// What becomes readable when the device has sent something, if it has a pace of its own.
    pub fn device_pace(&self) -> Option<BorrowedFd<'_>> {
        self.device.pace()
    }
}

/// The time constant of the motors that a strategy accounts for, s.
fn lag(strategy: &StrategyChoice) -> f64 {
    match strategy {
        StrategyChoice::Guard(guard) => guard.account().settings().actuator_lag,
        _ => 0.0,
    }
}
