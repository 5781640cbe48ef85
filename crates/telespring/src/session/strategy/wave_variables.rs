//! Wave variables: the two handles are joined by a virtual transmission line that is as long as the delay.

#![cfg_attr(not(test), deny(clippy::indexing_slicing))]

use super::tally::{Tally, step};
use super::{Outgoing, PartnerView, Strategy, StrategyReport, Tick};
use crate::error::Result;
use crate::quantity;
use crate::session::pair::{dot, finite_or, is_finite, size, zip};

/// What the line is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WaveSettings {
    /// The stiffness of the coupling without delay, N/m.
    pub stiffness: f64,
    /// The wave impedance b of the line, and the damper beside each spring that matches it, N·s/m.
    pub impedance: f64,
    /// The time constant of the filter on the arriving wave, s; 0 for none.
    pub filter: f64,
}

impl WaveSettings {
    /// A coupling stiffness (N/m), a wave impedance (N·s/m), and a filter of 5 ms.
    pub fn new(stiffness: f64, impedance: f64) -> Self {
        Self { stiffness, impedance, filter: 0.005 }
    }

    /// The damper beside the spring at each end, N·s/m, with this sample period (s): the impedance, or more if the held spring
    /// of 2k needs it. A held spring creates at most half its stiffness times the square of its change in a period, and this
    /// damper takes as much.
    pub fn damper(&self, period: f64) -> f64 {
        self.impedance.max(self.stiffness * period)
    }
}

/// The end of the line at this side, and what travels through it, per axis.
#[derive(Debug, Clone, Copy)]
struct Line {
    /// The position of the end, m, and its velocity until the next tick, m/s.
    position: [f64; 2],
    velocity: [f64; 2],
    /// The integral of the arriving wave as far as it has been used, √J·√s.
    heard: [f64; 2],
    /// The waves until the next tick, √W: arriving and leaving.
    arriving: [f64; 2],
    leaving: [f64; 2],
}

/// Wave variables (Niemeyer and Slotine, "Stable adaptive teleoperation", IEEE Journal of Oceanic Engineering 16, 1991), sent
/// as their integrals and checked against the energy sent (Niemeyer and Slotine, "Towards force-reflecting teleoperation over
/// the Internet", ICRA 1998).
///
/// Each handle is held by a spring of 2k and a damper of b at the end of a virtual line. With the velocity v of the end and
/// the force F on the spring, the wave (b v + F)/√(2b) arrives and (b v − F)/√(2b) leaves. Half the square of a wave is the
/// power that it carries, so a line of any constant length is passive. With delay T the line is a spring of b/T and has the
/// inertia b·T. The filter's time constant lengthens it.
///
/// The packet carries the integral of the leaving wave: a loss delays a part of it, and nothing drifts. What arrives never
/// carries more energy than the partner says it has sent; with that, varying delays, loss and repetition are passive, too. A
/// partner that states a false total is believed. The line couples how far the handles have moved since the coupling
/// began: a difference between their positions at that moment may stay. The robot must make the force that is commanded.
///
/// # Examples
///
/// ```
/// use telespring::session::strategy::{WaveSettings, WaveVariables};
///
/// let line = WaveVariables::new(WaveSettings { filter: 0.0, ..WaveSettings::new(100.0, 10.0) })?;
/// // in series: the spring, and the line of 0.1 s as a spring of 10 N·s/m / 0.1 s = 100 N/m
/// assert_eq!(line.static_stiffness(0.1), 50.0);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct WaveVariables {
    settings: WaveSettings,
    line: Option<Line>,
    /// The integral of the leaving wave, √J·√s.
    sent_wave: [f64; 2],
    sent: f64,
    received: f64,
    claimed: f64,
    tally: Tally,
}

impl WaveVariables {
    /// One end of a line.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`](crate::InvalidInput) for the first setting out of range.
    pub fn new(settings: WaveSettings) -> Result<Self> {
        quantity::STIFFNESS.check("stiffness", settings.stiffness)?;
        quantity::IMPEDANCE.check("impedance", settings.impedance)?;
        quantity::SPAN.check("filter", settings.filter)?;
        Ok(Self {
            settings,
            line: None,
            sent_wave: [0.0; 2],
            sent: 0.0,
            received: 0.0,
            claimed: 0.0,
            tally: Tally::default(),
        })
    }

    /// The stiffness between both handles at rest, N/m, for a constant delay each way (s): the spring and the line in series.
    pub fn static_stiffness(&self, delay: f64) -> f64 {
        let WaveSettings { stiffness, impedance, filter } = self.settings;
        1.0 / (1.0 / stiffness + (delay + filter) / impedance)
    }

    /// The arriving wave until the next tick, √W, and whether the energy that the partner has sent had to limit it.
    fn arriving(&self, heard: [f64; 2], signal: [f64; 2], time: f64) -> ([f64; 2], bool) {
        if !(time > 0.0) {
            return ([0.0; 2], false);
        }
        let spread = self.settings.filter.max(time);
        let wave = zip(signal, heard, |signal, heard| (signal - heard) / spread);
        let most = (2.0 * (self.claimed - self.received).max(0.0) / time).sqrt();
        match size(wave) {
            length if !length.is_finite() => ([0.0; 2], true),
            length if length <= most => (wave, false),
            length => (wave.map(|wave| wave / length * most), true),
        }
    }

    /// The end of the line when the coupling begins: half way between both handles, as if the spring were one.
    fn begin(tick: &Tick, partner: &PartnerView) -> Line {
        let position = zip(tick.own.position, partner.wanted.position, |own, other| 0.5 * (own + other));
        Line { position, velocity: [0.0; 2], heard: partner.signal, arriving: [0.0; 2], leaving: [0.0; 2] }
    }
}

impl Strategy for WaveVariables {
    fn settle(&mut self, tick: &Tick) {
        self.tally.settle(tick);
        let time = step(tick);
        let Some(line) = &mut self.line else { return };
        let along = |from: [f64; 2], rate: [f64; 2]| zip(from, rate, |from, rate| from + rate * time);
        line.position = along(line.position, line.velocity);
        line.heard = along(line.heard, line.arriving);
        let sent_wave = along(self.sent_wave, line.leaving);
        let energy = |wave: [f64; 2]| 0.5 * dot(wave, wave) * time;
        let (sent, received) = (self.sent + energy(line.leaving), self.received + energy(line.arriving));
        let states = [line.position, line.heard, sent_wave, [sent, received]];
        if states.into_iter().all(is_finite) {
            (self.sent_wave, self.sent, self.received) = (sent_wave, sent, received);
        } else {
            self.line = None;
        }
    }

    fn force(&mut self, tick: &Tick) -> [f64; 2] {
        let Some(partner) = &tick.partner else {
            // nothing more leaves; the springs are relaxed when the coupling begins again
            self.line = None;
            self.tally.pause();
            return [0.0; 2];
        };
        self.claimed = self.claimed.max(finite_or(partner.energy_sent, 0.0));
        let time = step(tick);
        let mut line = self.line.unwrap_or_else(|| Self::begin(tick, partner));
        let WaveSettings { stiffness, impedance, .. } = self.settings;
        let spring = 2.0 * stiffness;
        let damper = self.settings.damper(time);
        let force_on = |wave: [f64; 2]| {
            let pull = zip(line.position, tick.own.position, |end, own| spring * (end - own));
            let pull = zip(pull, tick.own.velocity, |pull, velocity| pull - damper * velocity);
            let root = (2.0 * impedance).sqrt();
            let velocity = zip(wave, pull, |wave, pull| (root * wave - pull) / (impedance + damper));
            (zip(wave, velocity, |wave, velocity| root * wave - impedance * velocity), velocity, root)
        };
        let (wave, limited) = self.arriving(line.heard, partner.signal, time);
        let (force, velocity, root) = force_on(wave);
        let wanted = if limited {
            let spread = self.settings.filter.max(time);
            force_on(zip(partner.signal, line.heard, |signal, heard| (signal - heard) / spread)).0
        } else {
            force
        };
        let leaving = zip(velocity, wave, |velocity, wave| root * velocity - wave);
        let [wanted, force] = [wanted, force].map(|force| force.map(|force| force * tick.enabled));
        if ![velocity, leaving, force].into_iter().all(is_finite) {
            self.line = None;
            self.tally.count(wanted, [0.0; 2]);
            return [0.0; 2];
        }
        (line.velocity, line.arriving, line.leaving) = (velocity, wave, leaving);
        self.line = Some(line);
        self.tally.count(wanted, force);
        force
    }

    fn outgoing(&self) -> Outgoing {
        Outgoing {
            energy_sent: self.sent,
            signal: self.sent_wave,
            stiffness: self.settings.stiffness,
            limited: self.tally.is_limited(),
        }
    }

    fn report(&self) -> StrategyReport {
        StrategyReport { energy_sent: self.sent, energy_received: self.received, ..self.tally.report() }
    }
}
