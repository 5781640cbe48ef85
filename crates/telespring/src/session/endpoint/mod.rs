//! One side of a coupling: sends, receives and computes the force.
//!
//! The caller owns the clock, the device and the network. At every tick it calls, in this order,
//!
//! 1. [`Endpoint::handle_measurement`] with the own motion (before it [`Endpoint::handle_acted`], if the force that
//!    acted is known better than by the settings),
//! 2. [`Endpoint::handle_target`], if there is a target that both sides show,
//! 3. [`Endpoint::poll_transmit`] and sends what comes out,
//! 4. [`Endpoint::handle_datagram`] for all that has arrived,
//! 5. [`Endpoint::force`] and applies it until the next one.
//!
//! [`Endpoint::poll_event`] says what happened. If no tick comes, [`Endpoint::next_timeout`] says when
//! [`Endpoint::handle_timeout`] has something to do.

#![cfg_attr(not(test), deny(clippy::indexing_slicing))]

mod partner;
mod settings;

pub use settings::EndpointSettings;

use super::clock::{Clock, ClockReport};
use super::event::{Event, EventKind, Events};
use super::motion::Motion;
use super::playout::{Playing, Playout, PlayoutReport};
use super::predictor::{Played, Predictor, PredictorChoice};
use super::strategy::{PartnerView, Strategy, StrategyChoice, StrategyReport, Tick};
use super::target::Targets;
use super::time::{LocalTime, PeerTime, Span};
use super::watchdog::{Cause, Fault, Faults, Watchdog, WatchdogState};
use super::wire::{Flags, LENGTH, MAX_ENERGY, MAX_SIGNAL, MAX_STAMP, MAX_STIFFNESS, Packet, PacketError};
use crate::error::Result;
use partner::{Arrival, Partner};

/// Why a datagram was refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DatagramError {
    /// It is no packet.
    #[error(transparent)]
    Packet(#[from] PacketError),
    /// It has the session id of this side.
    #[error("the packet has the session id of this side: it came back, or both sides were given the same id")]
    OwnSession,
    /// It belongs to a session of the partner that is over.
    #[error("the packet belongs to session {session:#x}, which is over: the partner has restarted since")]
    FormerSession {
        /// The session id.
        session: u64,
    },
    /// Its stamp lies in the future, although both sides read one clock.
    #[error("the packet is stamped {} s in the future: the clocks of the two sides differ", ahead.seconds())]
    FromTheFuture {
        /// How far.
        ahead: Span,
    },
}

/// A measured value that no device has; it was not used.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("the own device reports {value}: values must be finite and at most {}", super::motion::MAX_VALUE)]
pub struct ImpossibleMeasurement {
    /// The value.
    pub value: f64,
}

/// What a session has done so far.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SessionReport {
    /// The state of the watchdog; engaged without one.
    pub state: WatchdogState,
    /// The partner's session id; `None` before its first packet.
    pub partner: Option<u64>,
    /// The partner's state as of its newest packet.
    pub partner_flags: Flags,
    /// How often the partner has restarted.
    pub restarts: u64,
    /// Packets sent.
    pub sent: u64,
    /// Packets taken.
    pub received: u64,
    /// Datagrams refused.
    pub refused: u64,
    /// Values of the own device, the target or the measured force that were impossible.
    pub impossible_values: u64,
    /// Events given up because nobody fetched them.
    pub missed_events: u64,
    /// The partner's clock.
    pub clock: ClockReport,
    /// The play-out.
    pub playout: PlayoutReport,
    /// The strategy's account.
    pub strategy: StrategyReport,
}

/// A value as a packet may carry it; 0 for NaN.
fn bounded(value: f64, smallest: f64, largest: f64) -> f64 {
    if value.is_nan() { 0.0 } else { value.clamp(smallest, largest) }
}

/// The own motion and when it was measured.
#[derive(Debug, Clone, Copy)]
struct Measured {
    at: LocalTime,
    motion: Motion,
}

/// One side of a coupling: it measures and sends, receives, and computes the force on its own handle.
///
/// # Examples
///
/// Two sides with a network without delay, without a watchdog:
///
/// ```
/// use telespring::session::{Endpoint, EndpointSettings, Law, LocalTime, Motion, Span};
///
/// let law = Law { stiffness: 100.0, damping: 0.0 };
/// let settings = |id| EndpointSettings { watchdog: None, ..EndpointSettings::new(id, law, Span(0)) };
/// let (mut one, mut two) = (Endpoint::new(settings(1))?, Endpoint::new(settings(2))?);
/// let now = LocalTime(0);
/// let at = |x| Motion { position: [x, 0.0], velocity: [0.0; 2] };
/// one.handle_measurement(now, at(0.0))?;
/// two.handle_measurement(now, at(0.02))?;
/// one.handle_datagram(now, &two.poll_transmit(now).unwrap())?;
/// two.handle_datagram(now, &one.poll_transmit(now).unwrap())?;
/// assert_eq!(one.force(now), [2.0, 0.0]);
/// assert_eq!(two.force(now), [-2.0, 0.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Endpoint {
    session: u64,
    sample_period: Span,
    computing_tick: bool,
    strategy: StrategyChoice,
    predictor: PredictorChoice,
    playout: Playout,
    clock: Clock,
    watchdog: Option<Watchdog>,
    partner: Partner,
    targets: Targets,
    events: Events,
    now: LocalTime,
    /// The newest own motion and the one before it.
    own: Option<Measured>,
    previous: Option<Measured>,
    /// Since when the own device has reported impossible values.
    impossible_since: Option<LocalTime>,
    /// The newest measurement has not been sent, or not been answered with a force.
    to_send: bool,
    to_answer: bool,
    /// The partner as of the latest force.
    view: Option<PartnerView>,
    /// There is a motion of the partner to follow.
    ready: bool,
    /// The partner has restarted and the coupling has not been engaged since.
    restarted: bool,
    /// The forces computed last and before, N, and the factor in the last one.
    computed: [[f64; 2]; 2],
    enabled: f64,
    /// The force that acted until the newest measurement, N, and what the caller says about the time since.
    acted: [f64; 2],
    told: Option<[f64; 2]>,
    energy_sent: f64,
    sent: u64,
    received: u64,
    refused: u64,
    impossible_values: u64,
}

impl Endpoint {
    /// Creates a side. It allocates all that it ever needs.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`](crate::InvalidInput) if a setting is out of range.
    pub fn new(settings: EndpointSettings) -> Result<Self> {
        settings.check()?;
        let playout = Playout::new(settings.playout, settings.sample_period)?;
        let targets = Targets::new(playout.capacity());
        Ok(Self {
            session: settings.session,
            sample_period: settings.sample_period,
            computing_tick: settings.computing_tick,
            strategy: settings.strategy,
            predictor: settings.predictor,
            playout,
            clock: Clock::new(settings.clock)?,
            watchdog: settings.watchdog.map(Watchdog::new),
            partner: Partner::new(settings.watchdog),
            targets,
            events: Events::new(),
            now: LocalTime(0),
            own: None,
            previous: None,
            impossible_since: None,
            to_send: false,
            to_answer: false,
            view: None,
            ready: false,
            restarted: false,
            computed: [[0.0; 2]; 2],
            enabled: 0.0,
            acted: [0.0; 2],
            told: None,
            energy_sent: 0.0,
            sent: 0,
            received: 0,
            refused: 0,
            impossible_values: 0,
        })
    }

    /// Takes the own motion, measured at `now`.
    ///
    /// # Errors
    ///
    /// [`ImpossibleMeasurement`] if the device reports an impossible value. It is not used or sent; the watchdog holds
    /// the force and ramps it out if no possible value comes. Without a watchdog the force is zero until one comes.
    pub fn handle_measurement(
        &mut self,
        now: LocalTime,
        motion: Motion,
    ) -> std::result::Result<(), ImpossibleMeasurement> {
        let now = self.begin(now);
        if let Some(value) = motion.impossible_value() {
            self.note_impossible(now, value);
            self.impossible_since.get_or_insert(now);
            self.to_answer = false;
            self.watch(now);
            return Err(ImpossibleMeasurement { value });
        }
        self.impossible_since = None;
        let [last, before] = self.computed;
        let acting = if self.computing_tick && !self.to_answer { before } else { last };
        self.acted = self.told.take().unwrap_or(acting);
        let measured = Measured { at: now, motion };
        self.previous = Some(self.own.unwrap_or(measured));
        self.own = Some(measured);
        (self.to_send, self.to_answer) = (true, true);
        if let Some(tick) = self.tick(self.view, self.enabled) {
            self.strategy.settle(&tick);
        }
        Ok(())
    }

    /// Takes the force that acted on the own handle on average since the last measurement, N, where it is known better
    /// than by the settings: the actuator saturates, lags, or its force is measured. Call it before
    /// [`Endpoint::handle_measurement`].
    pub fn handle_acted(&mut self, force: [f64; 2]) {
        match force.into_iter().find(|value| !value.is_finite()) {
            Some(value) => self.note_impossible(self.now, value),
            None => self.told = Some(force),
        }
    }

    /// Takes the target that both sides show, as shown at `now`; an impossible one is not used.
    pub fn handle_target(&mut self, now: LocalTime, target: Motion) {
        let now = self.begin(now);
        match target.impossible_value() {
            Some(value) => self.note_impossible(now, value),
            None if self.predictor.uses_target() => self.targets.show(now, target),
            None => {}
        }
    }

    /// The packet for the partner, if a motion has been measured since the last one.
    pub fn poll_transmit(&mut self, now: LocalTime) -> Option<[u8; LENGTH]> {
        let now = self.begin(now);
        let own = self.own.filter(|_| std::mem::take(&mut self.to_send))?;
        let outgoing = self.strategy.outgoing();
        if outgoing.energy_sent > self.energy_sent {
            self.energy_sent = outgoing.energy_sent.min(MAX_ENERGY);
        }
        let packet = Packet {
            flags: self.flags(outgoing.limited),
            session: self.session,
            sequence: self.sent,
            sent: PeerTime(own.at.0.min(MAX_STAMP)),
            echo: self.partner.echo(own.at),
            motion: own.motion,
            energy_sent: self.energy_sent,
            stiffness: bounded(outgoing.stiffness, 0.0, MAX_STIFFNESS),
            signal: outgoing.signal.map(|value| bounded(value, -MAX_SIGNAL, MAX_SIGNAL)),
        };
        self.sent = self.sent.saturating_add(1);
        self.watch(now);
        Some(packet.encode())
    }

    /// The state of this side, for the partner.
    fn flags(&self, limited: bool) -> Flags {
        let state = self.state();
        Flags {
            engaged: matches!(state, WatchdogState::Engaged | WatchdogState::Holding { .. }),
            holding: matches!(state, WatchdogState::Holding { .. }),
            ramping: matches!(state, WatchdogState::RampingIn | WatchdogState::RampingOut { .. }),
            limited,
            restarted: self.restarted,
        }
    }

    /// Takes the bytes of a datagram that arrived at `now`.
    ///
    /// # Errors
    ///
    /// [`DatagramError`] if they are not a packet of the partner; nothing changes then but the counts.
    pub fn handle_datagram(
        &mut self,
        now: LocalTime,
        bytes: &[u8],
    ) -> std::result::Result<(), DatagramError> {
        let now = self.begin(now);
        let taken = self.take_datagram(now, bytes);
        match taken {
            Ok(()) => self.received = self.received.saturating_add(1),
            Err(refusal) => {
                self.refused = self.refused.saturating_add(1);
                self.events.push(now, EventKind::Refused(refusal));
            }
        }
        taken
    }

    fn take_datagram(&mut self, now: LocalTime, bytes: &[u8]) -> std::result::Result<(), DatagramError> {
        let packet = Packet::decode(bytes)?;
        if packet.session == self.session {
            return Err(DatagramError::OwnSession);
        }
        if let Some(ahead) = self.clock.ahead(now, packet.sent) {
            return Err(DatagramError::FromTheFuture { ahead });
        }
        let idle =
            matches!(self.state(), WatchdogState::Disengaged { cause: Cause::Silence | Cause::FrozenStamps });
        match self.partner.accept(now, &packet, idle)? {
            Arrival::First => self.events.push(now, EventKind::PartnerFound { session: packet.session }),
            Arrival::Restarted => {
                self.events.push(now, EventKind::PartnerRestarted { session: packet.session });
                self.restarted = true;
                self.clock.forget();
                self.begin_anew(now, Cause::PartnerRestarted);
            }
            Arrival::Later | Arrival::Other => {}
        }
        let steps = self.clock.steps();
        self.clock.handle_packet(now, &packet);
        if self.clock.steps() > steps {
            self.events.push(now, EventKind::ClockStepped);
            self.begin_anew(now, Cause::ClockStepped);
        }
        if let Some(peer) = self.clock.to_peer(now) {
            self.playout.insert(peer, (&packet).into());
        }
        Ok(())
    }

    /// Forgets the partner's motion: what comes now does not continue it.
    fn begin_anew(&mut self, now: LocalTime, cause: Cause) {
        self.playout.forget();
        self.predictor.reset();
        self.ready = false;
        if let Some(state) = self.watchdog.as_mut().and_then(|watchdog| watchdog.let_go(now, cause)) {
            self.enter(now, state);
        }
    }

    /// The force on the own handle per axis from `now` until the next call, N.
    ///
    /// It is computed once per measurement. Called again without a new measurement, it is the force of before, or less
    /// while the watchdog ramps it out.
    pub fn force(&mut self, now: LocalTime) -> [f64; 2] {
        let now = self.begin(now);
        if !std::mem::take(&mut self.to_answer) {
            return self.force_without_measurement(now);
        }
        let looked = self.look(now);
        self.ready = looked.is_some();
        self.watch(now);
        let partner = match self.state() {
            WatchdogState::Disengaged { .. } => None,
            // whatever the partner does now, the force falls along its last motion
            WatchdogState::RampingOut { .. } => self.view.map(|view| PartnerView { fresh: false, ..view }),
            _ => looked.map(|(view, playing)| {
                self.playout.count(&playing);
                view
            }),
        };
        (self.view, self.enabled) = (partner, self.factor(now));
        let force = self.tick(partner, self.enabled).map_or([0.0; 2], |tick| self.strategy.force(&tick));
        let force = if force.iter().all(|value| value.is_finite()) {
            force
        } else {
            self.events.push(now, EventKind::ImpossibleForce);
            [0.0; 2]
        };
        let [last, _] = self.computed;
        self.computed = [force, last];
        force
    }

    /// The force while the own device has not reported anew.
    fn force_without_measurement(&self, now: LocalTime) -> [f64; 2] {
        let [last, _] = self.computed;
        if self.watchdog.is_none() {
            return if self.impossible_since.is_some() { [0.0; 2] } else { last };
        }
        let factor = self.factor(now);
        if factor >= self.enabled { last } else { last.map(|force| force * (factor / self.enabled)) }
    }

    /// The partner as known at `now`.
    fn look(&mut self, now: LocalTime) -> Option<(PartnerView, Playing)> {
        let playing = self.playout.play(self.clock.to_peer(now)?)?;
        let played =
            Played { motion: playing.motion, time: playing.time, age: playing.age, held: playing.held };
        let target = self.clock.to_local(playing.time).and_then(|then| self.targets.view(then));
        let predicted = self.predictor.predict(&played, target.as_ref());
        let view = PartnerView {
            wanted: if predicted.impossible_value().is_none() { predicted } else { playing.motion },
            played: playing.motion,
            age: playing.age.seconds(),
            fresh: playing.fresh,
            signal: playing.signal,
            energy_sent: self.partner.energy_sent(),
            stiffness: self.partner.stiffness(),
        };
        Some((view, playing))
    }

    /// The tick of the newest measurement.
    fn tick(&self, partner: Option<PartnerView>, enabled: f64) -> Option<Tick> {
        let (own, previous) = (self.own?, self.previous?);
        Some(Tick {
            elapsed: (own.at - previous.at).seconds(),
            own: own.motion,
            previous: previous.motion,
            acted: self.acted,
            partner,
            enabled,
        })
    }

    /// Begins a call at `now`: time does not go back, and the watchdog judges what was before.
    fn begin(&mut self, now: LocalTime) -> LocalTime {
        if now > self.now {
            self.now = now;
            self.clock.advance(now);
            self.watch(now);
        }
        self.now
    }

    /// What is wrong at `now`.
    fn faults(&self, now: LocalTime) -> Faults {
        let impossible = self.impossible_since.map(|since| Fault { cause: Cause::OwnMeasurement, since });
        let silent = self.own_silence().filter(|silent| now > *silent);
        let silent = silent.map(|since| Fault { cause: Cause::OwnSilence, since });
        [impossible.or(silent), self.partner.fault(now)]
    }

    /// After this time the own device is silent.
    fn own_silence(&self) -> Option<LocalTime> {
        self.own.map(|own| own.at + self.sample_period + self.sample_period)
    }

    /// Lets the watchdog judge at `now`.
    fn watch(&mut self, now: LocalTime) {
        // at most every state once
        for _ in 0..5 {
            let (faults, ready) = (self.faults(now), self.ready);
            let Some(state) = self.watchdog.as_mut().and_then(|watchdog| watchdog.step(now, faults, ready))
            else {
                return;
            };
            self.enter(now, state);
        }
    }

    /// Notes a new state of the watchdog.
    fn enter(&mut self, now: LocalTime, state: WatchdogState) {
        let kind = match state {
            WatchdogState::Holding { cause } => EventKind::Holding(cause),
            WatchdogState::RampingOut { cause } => EventKind::RampingOut(cause),
            WatchdogState::Disengaged { cause } => EventKind::Disengaged(cause),
            WatchdogState::RampingIn => {
                self.clock.settle(now);
                if let Some(peer) = self.clock.to_peer(now) {
                    self.playout.settle(peer);
                }
                EventKind::RampingIn
            }
            WatchdogState::Engaged => {
                self.restarted = false;
                EventKind::Engaged
            }
        };
        self.events.push(now, kind);
    }

    fn note_impossible(&mut self, now: LocalTime, value: f64) {
        self.impossible_values = self.impossible_values.saturating_add(1);
        self.events.push(now, EventKind::ImpossibleValue { value });
    }

    /// The watchdog's factor on the force.
    fn factor(&self, now: LocalTime) -> f64 {
        self.watchdog.as_ref().map_or(1.0, |watchdog| watchdog.factor(now))
    }

    /// The state of the watchdog; engaged without one.
    pub fn state(&self) -> WatchdogState {
        self.watchdog.as_ref().map_or(WatchdogState::Engaged, Watchdog::state)
    }

    /// The oldest event not fetched yet.
    pub fn poll_event(&mut self) -> Option<Event> {
        self.events.poll()
    }

    /// The next time at which the state changes if nothing else comes; `None` without a watchdog or partner.
    pub fn next_timeout(&self) -> Option<LocalTime> {
        let watchdog = self.watchdog.as_ref()?;
        let state = watchdog.state();
        let acting = !matches!(state, WatchdogState::Disengaged { .. } | WatchdogState::RampingOut { .. });
        let own = [self.own_silence().map(|silence| silence + Span(1))];
        let faults = own.into_iter().chain(self.partner.timeouts()).flatten();
        let coming = faults.filter(|time| acting && *time > self.now);
        coming.chain(watchdog.next_timeout(self.faults(self.now))).min()
    }

    /// Does what is due at `now`.
    pub fn handle_timeout(&mut self, now: LocalTime) {
        self.begin(now);
    }

    /// The age of the oldest sample in the partner's motion that the latest force used, s, before any prediction; `None` if
    /// it used none. Where samples are missing between the two that are interpolated, it is older than the played instant.
    pub fn partner_age(&self) -> Option<f64> {
        self.view.and(self.playout.oldest_played()).map(Span::seconds)
    }

    /// All energy that the partner says it has sent to this side, J: the largest total of each of its sessions.
    pub fn partner_energy(&self) -> f64 {
        self.partner.energy_sent()
    }

    /// The strategy's account so far: a part of the report that costs little.
    pub fn strategy_report(&self) -> StrategyReport {
        self.strategy.report()
    }

    /// What the session has done so far.
    pub fn report(&self) -> SessionReport {
        SessionReport {
            state: self.state(),
            partner: self.partner.session(),
            partner_flags: self.partner.flags(),
            restarts: self.partner.restarts,
            sent: self.sent,
            received: self.received,
            refused: self.refused,
            impossible_values: self.impossible_values,
            missed_events: self.events.missed(),
            clock: self.clock.report(self.now),
            playout: self.playout.report(),
            strategy: self.strategy.report(),
        }
    }
}
