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
mod coupling;
mod fallback;
mod force;
mod greeter;
mod limits;
mod log;
mod moment;
mod notes;
mod notices;
mod orders;
mod phase;
mod round_trip;
mod settings;

pub use fallback::{Badness, Fallback};
pub use limits::Limits;
pub use log::{Happened, LOG_CAPACITY, Log};
pub use moment::{Moment, Tally};
pub use notes::{Arrival, Forces, Latency, Newest};
pub use notices::Limit;
pub use phase::{Cause, Interruption, Phase};
pub use settings::{Consent, Rules, Safety, SiteSettings};

use std::os::fd::BorrowedFd;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rtrb::Consumer;
use telespring::InvalidInput;
use telespring::session::{Endpoint, LocalTime, Motion, SessionReport, Span, WatchdogState};

use crate::clock::Clock;
use crate::device::{Command, Device, Reading};
use crate::hello::Purpose;
use crate::operator::Order;
use crate::transport::{Transport, TransportReport};
use accord::Accord;
use alignment::Alignment;
use coupling::Coupling;
use fallback::Watch;
use force::ForceGate;
use greeter::Greeter;
use notes::Notes;
use notices::Notices;
use round_trip::RoundTrips;

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
    /// The latest own motion.
    motion: Option<Motion>,
    /// From the own handle to the partner's, m.
    offset: Option<[f64; 2]>,
    /// The partner's latest packet that the endpoint took.
    heard: Option<LocalTime>,
    /// Ticks that the strategy had limited before this one.
    limited_ticks: u64,
    /// Whether the emergency stop is pressed now.
    is_pressed: bool,
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
            gate: ForceGate::new(&limits, endpoint.sample_period, endpoint.computing_tick),
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
            motion: None,
            offset: None,
            heard: None,
            limited_ticks: 0,
            is_pressed: false,
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
        let reading = self.read(now);
        self.take_orders(now);
        if stop {
            self.leave(now, Cause::StopRequested);
        }
        self.judge(now);
        match &reading {
            Some(reading) if self.coupling != Coupling::Off => self.measure(now, reading),
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
        self.collect(now, commanded, reading.as_ref(), force)
    }

    /// Whether the endpoint's force is zero. It must be before a coupling begins, so that the force begins from zero.
    fn is_resting(&self) -> bool {
        !self.is_watched || matches!(self.endpoint.state(), WatchdogState::Disengaged { .. })
    }

    /// Reads the device, and what it means for this side.
    fn read(&mut self, now: LocalTime) -> Option<Reading> {
        match self.device.read(now) {
            Ok(reading) => {
                self.is_pressed = reading.is_stopped;
                if reading.is_stopped && !self.accord.own.is_stopped {
                    self.accord.own.is_stopped = true;
                    self.interrupt(now, Interruption::EmergencyStop);
                    self.tell_stop(now, true);
                }
                let is_ready = reading.is_ready && !reading.is_stopped;
                if self.accord.own.is_ready && !is_ready {
                    self.interrupt(now, Interruption::DeviceNotReady);
                }
                self.accord.own.is_ready = is_ready;
                self.motion = reading.motion.or(self.motion);
                Some(reading)
            }
            Err(fault) => {
                if fault.is_final() {
                    self.end(now, Cause::Device(fault));
                } else if self.accord.own.is_ready {
                    self.interrupt(now, Interruption::Device(fault));
                }
                self.accord.own.is_ready = false;
                self.motion = None;
                None
            }
        }
    }

    fn tell_stop(&mut self, now: LocalTime, is_own: bool) {
        self.tally.emergency_stops += 1;
        self.log.push(now, Happened::EmergencyStop { is_own });
    }

    /// Gives the endpoint the own motion, and sends its packet.
    fn measure(&mut self, now: LocalTime, reading: &Reading) {
        let Some(motion) = reading.motion else { return };
        let told = reading.acted.or_else(|| self.gate.acted());
        if let Some(acted) = told {
            self.endpoint.handle_acted(acted);
        }
        (self.notes.is_measured, self.notes.forces.told) = (true, told);
        // A motion that cannot be is an event of the endpoint, and its watchdog sees to the force.
        let _ = self.endpoint.handle_measurement(now, motion);
        if let Some(target) = reading.target {
            self.endpoint.handle_target(now, target);
        }
        if let Some(packet) = self.endpoint.poll_transmit(now) {
            self.transport.send(now, &packet);
        }
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
        }
    }

    /// What there is to say of this tick.
    fn collect(
        &mut self,
        now: LocalTime,
        commanded: LocalTime,
        reading: Option<&Reading>,
        force: [f64; 2],
    ) -> Moment {
        while let Some(event) = self.endpoint.poll_event() {
            // while nothing is coupled the silence of both is no event
            if self.coupling != Coupling::Off {
                self.log.push(event.time, Happened::Session(event.kind));
            }
        }
        while let Some(event) = self.transport.poll_path() {
            self.log.push(now, Happened::Path(event));
        }
        if self.recording_alarm.load(Ordering::Relaxed) && self.recording_alarm.swap(false, Ordering::Relaxed)
        {
            self.log.push(now, Happened::RecordingBroken);
        }
        let session = self.endpoint.snapshot();
        let report = session.strategy;
        let is_coupled = self.phase.is_coupled();
        let is_limited = is_coupled && report.limited_ticks > self.limited_ticks;
        self.limited_ticks = report.limited_ticks;
        self.notices.take(now, [is_limited, self.gate.was_cut()], &mut self.log);
        let measured = reading.and_then(|reading| reading.acted);
        let device_delay = reading.and_then(|reading| self.notes.device_delay(now, reading));
        let moment = Moment {
            tick: self.notes.tick,
            time: now,
            commanded,
            phase: self.phase,
            state: self.endpoint.state(),
            motion: reading.and_then(|reading| reading.motion),
            target: reading.and_then(|reading| reading.target),
            force,
            balance: session.strategy.balance,
            age: self.endpoint.partner_age(),
            heard: self.heard,
            stamp: reading.and_then(|reading| reading.stamp),
            device_delay,
            is_measured: self.notes.is_measured,
            is_timed: self.notes.is_timed,
            forces: Forces { measured, ..self.notes.forces },
            asked: self.notes.asked,
            newest: self.notes.newest,
            session,
            wanted_stiffness: self.greeter.terms().coupling[0],
            unnoted_arrivals: self.notes.unnoted,
            offset: self.offset.filter(|_| !is_coupled),
            consents: [self.accord.own.has_consented, self.accord.partner_consents()],
            share: self.notes.share,
            is_cut: self.gate.was_cut(),
        };
        self.tally.cut_ticks += u64::from(self.gate.was_cut());
        self.tally.softened_ticks += u64::from(is_coupled && self.watch.share() < 1.0);
        self.notes.tick += 1;
        self.tally.count(&moment);
        moment
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
        self.endpoint.report()
    }

    /// The transport's report.
    pub fn transport_report(&self) -> TransportReport {
        self.transport.report()
    }

    /// The device.
    pub fn device(&self) -> &D {
        &self.device
    }

    /// What becomes readable once the device has measured anew, if it has a pace of its own.
    pub fn device_pace(&self) -> Option<BorrowedFd<'_>> {
        self.device.pace()
    }
}
