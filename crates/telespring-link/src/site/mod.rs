//! One side of a live coupling: device, endpoint, transport and the state of the session.
//!
//! | state | force | how it goes on |
//! |---|---|---|
//! | greeting | 0 | both have agreed on the terms and both devices are ready: running |
//! | running | that of the endpoint, which ramps in, holds and ramps out by itself | a stop, a goodbye: leaving; a fault: ended |
//! | leaving | falls to 0 | ended |
//! | ended | 0 | – |
//!
//! A site reads no clock of its own and waits for nothing: [`Site::tick`] is called once per sample period with the clock
//! to use, a real one or that of a test.

mod arrivals;
mod force;
mod greeter;
mod log;
mod moment;
mod notes;
mod settings;

pub use log::{Happened, LOG_CAPACITY, Log};
pub use moment::{Cause, Moment, Phase, Tally};
pub use notes::{Arrival, Forces, Latency, Newest};
pub use settings::{Safety, SiteSettings};

use std::os::fd::BorrowedFd;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use telespring::InvalidInput;
use telespring::session::{Endpoint, LocalTime, SessionReport, Span};

use crate::clock::Clock;
use crate::device::{Command, Device, Reading};
use crate::hello::Purpose;
use crate::transport::{Transport, TransportReport};
use force::ForceGate;
use greeter::Greeter;
use notes::Notes;

/// From one greeting to the next.
const GREETING_INTERVAL: Span = Span(50_000_000);
/// From one goodbye to the next.
const GOODBYE_INTERVAL: Span = Span(10_000_000);
/// A partner that refuses, or is refused, for this long ends the greeting.
const PATIENCE: Span = Span(1_000_000_000);

/// One side of a live coupling. After its construction it allocates nothing, takes no lock and does not panic.
#[derive(Debug)]
pub struct Site<D, T> {
    device: D,
    transport: T,
    endpoint: Endpoint,
    greeter: Greeter,
    gate: ForceGate,
    safety: Safety,
    phase: Phase,
    /// Since when the session leaves, and why.
    left: Option<(LocalTime, Cause)>,
    /// When the next greeting or goodbye is due.
    greet_at: LocalTime,
    /// The partner's latest packet that the endpoint took.
    heard: Option<LocalTime>,
    log: Log,
    tally: Tally,
    notes: Notes,
    /// Somebody outside sets it when the recording has broken off.
    recording_alarm: Arc<AtomicBool>,
}

impl<D: Device, T: Transport> Site<D, T> {
    /// A site at the beginning of its greeting.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] for a setting out of range.
    pub fn new(settings: SiteSettings, device: D, transport: T) -> Result<Self, InvalidInput> {
        let SiteSettings { terms, endpoint, safety } = settings;
        safety.check()?;
        let session = endpoint.session;
        if session == 0 {
            return Err(InvalidInput::new(
                "session",
                0,
                "a session id is not 0",
                "Draw one with hello::draw_session().",
            ));
        }
        let gate = ForceGate::new(safety.force, endpoint.computing_tick);
        Ok(Self {
            device,
            transport,
            endpoint: Endpoint::new(endpoint)?,
            greeter: Greeter::new(session, terms),
            gate,
            safety,
            phase: Phase::Greeting,
            left: None,
            greet_at: LocalTime(0),
            heard: None,
            log: Log::new(),
            tally: Tally::default(),
            notes: Notes::new(),
            recording_alarm: Arc::default(),
        })
    }

    /// Measures, sends, receives and commands once; `stop` asks the session to end.
    pub fn tick(&mut self, clock: &impl Clock, stop: bool) -> Moment {
        let now = clock.now();
        self.notes.begin();
        let reading = match self.device.read(now) {
            Ok(reading) => Some(reading),
            Err(fault) => {
                self.end(now, Cause::Device(fault));
                None
            }
        };
        if let Some(reading) = &reading {
            self.judge(now, reading, stop);
        }
        if let (Some(reading), true) = (&reading, self.phase.is_coupled()) {
            self.measure(now, reading);
        }
        self.greet(now, reading.as_ref());
        self.receive(clock);
        let force = self.force(clock.now());
        let commanded = clock.now();
        self.device.command(commanded, Command { force, is_running: self.phase.is_coupled() });
        self.collect(now, commanded, reading.as_ref(), force)
    }

    /// Judges whether the session may go on.
    fn judge(&mut self, now: LocalTime, reading: &Reading, stop: bool) {
        if self.phase == Phase::Ended {
            return;
        }
        if reading.is_stopped {
            self.end(now, Cause::EmergencyStop);
        } else if !reading.is_ready && self.phase.is_coupled() {
            self.end(now, Cause::DeviceNotReady);
        } else if stop {
            match self.phase {
                Phase::Greeting => self.end(now, Cause::StopRequested),
                _ => self.leave(now, Cause::StopRequested),
            }
        } else if self.phase == Phase::Greeting
            && let Some(disagreement) = self.greeter.refused_for(now, PATIENCE)
        {
            self.end(now, Cause::Refused(disagreement));
        }
        if let (Phase::Leaving, Some((since, cause))) = (self.phase, self.left)
            && now - since >= self.safety.ramp_out
        {
            self.end(now, cause);
        }
    }

    /// Lets the force fall to zero, then ends.
    fn leave(&mut self, now: LocalTime, cause: Cause) {
        if self.phase == Phase::Running {
            self.phase = Phase::Leaving;
            self.left = Some((now, cause));
            self.greet_at = now;
            self.log.push(now, Happened::Leaving(cause));
        }
    }

    /// Ends at once: the force is zero from now on.
    fn end(&mut self, now: LocalTime, cause: Cause) {
        if self.phase != Phase::Ended {
            self.phase = Phase::Ended;
            self.left = Some((now, cause));
            self.greet_at = now;
            self.log.push(now, Happened::Ended(cause));
        }
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
    fn greet(&mut self, now: LocalTime, reading: Option<&Reading>) {
        self.greeter.is_ready = reading.is_some_and(|reading| reading.is_ready && !reading.is_stopped);
        let (purpose, interval) = match self.phase {
            Phase::Greeting => (Purpose::Hello, GREETING_INTERVAL),
            Phase::Running if self.greeter.owes_answer() => (Purpose::Hello, GREETING_INTERVAL),
            Phase::Leaving | Phase::Ended => (Purpose::Goodbye, GOODBYE_INTERVAL),
            Phase::Running => return,
        };
        if now >= self.greet_at || self.greeter.is_urgent() {
            self.greet_at = now + interval;
            let greeting = self.greeter.greeting(purpose);
            self.transport.send(now, &greeting.encode());
        }
    }

    /// The force from now on.
    fn force(&mut self, now: LocalTime) -> [f64; 2] {
        let share = match (self.phase, self.left) {
            (Phase::Running, _) => 1.0,
            (Phase::Leaving, Some((since, _))) => {
                1.0 - (now - since).0 as f64 / self.safety.ramp_out.0.max(1) as f64
            }
            _ => {
                self.gate.close();
                return [0.0; 2];
            }
        };
        let wanted = self.endpoint.force(now);
        (self.notes.asked, self.notes.forces.wanted) = (Some(now), Some(wanted));
        self.gate.pass(wanted, share.clamp(0.0, 1.0))
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
            self.log.push(event.time, Happened::Session(event.kind));
        }
        while let Some(event) = self.transport.poll_path() {
            self.log.push(now, Happened::Path(event));
        }
        if self.recording_alarm.load(Ordering::Relaxed) && self.recording_alarm.swap(false, Ordering::Relaxed)
        {
            self.log.push(now, Happened::RecordingBroken);
        }
        let session = self.endpoint.snapshot();
        let motion = reading.and_then(|reading| reading.motion);
        let target = reading.and_then(|reading| reading.target);
        let measured = reading.and_then(|reading| reading.acted);
        let device_delay = reading.and_then(|reading| self.notes.device_delay(now, reading));
        let moment = Moment {
            tick: self.notes.tick,
            time: now,
            commanded,
            phase: self.phase,
            state: self.endpoint.state(),
            motion,
            target,
            force,
            balance: session.strategy.balance,
            age: self.endpoint.partner_age(),
            heard: self.heard,
            stamp: reading.and_then(|reading| reading.stamp),
            device_delay,
            is_measured: self.notes.is_measured,
            forces: Forces { measured, ..self.notes.forces },
            asked: self.notes.asked,
            newest: self.notes.newest,
            session,
            wanted_stiffness: self.greeter.terms().coupling[0],
            unnoted_arrivals: self.notes.unnoted,
        };
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
