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

mod answer;
mod partner;
mod receiving;
mod report;
mod settings;
mod watching;

pub use receiving::DatagramError;
pub use report::{SessionReport, SessionSnapshot};
pub use settings::EndpointSettings;

use super::clock::Clock;
use super::event::Events;
use super::motion::Motion;
use super::playout::Playout;
use super::predictor::PredictorChoice;
use super::strategy::{PartnerView, Strategy, StrategyChoice};
use super::target::Targets;
use super::time::{LocalTime, PeerTime, Span};
use super::watchdog::{Watchdog, WatchdogState};
use super::wire::{Flags, LENGTH, MAX_ENERGY, MAX_SIGNAL, MAX_STAMP, MAX_STIFFNESS, Packet};
use crate::error::Result;
use partner::Partner;

/// A measured value that no device has; it was not used.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("the own device reports {value}: values must be finite and at most {}", super::motion::MAX_VALUE)]
pub struct ImpossibleMeasurement {
    /// The value.
    pub value: f64,
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
    /// Without an own measurement for this time the own device is silent, but not before two sample periods.
    own_silence: Span,
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
            own_silence: settings.watchdog.map_or(Span(0), |watchdog| watchdog.own_silence),
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
}
