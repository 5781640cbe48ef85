//! The force with which an endpoint answers a measurement.

#![cfg_attr(not(test), deny(clippy::indexing_slicing))]

use super::Endpoint;
use crate::session::LocalTime;
use crate::session::event::EventKind;
use crate::session::playout::Playing;
use crate::session::predictor::{Played, Predictor};
use crate::session::strategy::{PartnerView, Strategy, Tick};
use crate::session::watchdog::WatchdogState;

impl Endpoint {
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
    pub(super) fn tick(&self, partner: Option<PartnerView>, enabled: f64) -> Option<Tick> {
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
}
