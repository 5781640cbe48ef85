//! What a site says of a tick: what happened elsewhere, and the tick as others see it.

use std::sync::atomic::Ordering;

use telespring::session::{LocalTime, Span};

use super::accord::FRESH;
use super::{Forces, Happened, Moment, Phase, Site, measuring};
use crate::device::{Device, Reading};
use crate::transport::Transport;

impl<D: Device, T: Transport> Site<D, T> {
    /// Logs what happened elsewhere in this tick. While nothing is coupled, the silence of both is no event of the endpoint.
    pub(super) fn tell(&mut self, now: LocalTime, is_coupled: bool) {
        while let Some(event) = self.endpoint.poll_event() {
            if is_coupled {
                self.log.push(event.time, measuring::event(event.kind, self.motion));
            }
        }
        while let Some(event) = self.transport.poll_path() {
            self.log.push(now, Happened::Path(event));
        }
        if self.phase != Phase::Ended {
            self.awaited.tell(now, &mut self.log);
        }
        let consents = self.accord.own.has_consented;
        // whoever leaves needs none any more
        if std::mem::replace(&mut self.told_consent, consents) != consents && self.left.is_none() {
            self.log.push(now, if consents { Happened::Consented } else { Happened::ConsentLost });
        }
        if self.recording_alarm.load(Ordering::Relaxed) && self.recording_alarm.swap(false, Ordering::Relaxed)
        {
            self.log.push(now, Happened::RecordingBroken);
        }
    }

    /// What there is to say of this tick.
    pub(super) fn collect(
        &mut self,
        now: LocalTime,
        commanded: LocalTime,
        reading: Option<&Reading>,
        force: [f64; 2],
    ) -> Moment {
        let mut session = self.endpoint.snapshot();
        session.playout.lost = self.passed_over.lost(session.playout.lost);
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
            // while the endpoint is not asked, its age is that of an earlier time
            age: self.notes.asked.and(self.endpoint.partner_age()),
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
            pauses: [self.accord.own.is_paused, self.accord.partner_pauses()],
            round_trip: self.round_trip_now(now),
            share: self.notes.share,
            is_cut: self.gate.was_cut(),
        };
        self.tally.cut_ticks += u64::from(self.gate.was_cut());
        self.tally.softened_ticks += u64::from(is_coupled && self.watch.share() < 1.0);
        self.notes.tick += 1;
        self.tally.count(&moment);
        moment
    }

    /// The latest round trip: of the packets while coupled, else of the greetings; `None` if nothing has come lately.
    fn round_trip_now(&self, now: LocalTime) -> Option<Span> {
        let is_fresh = |heard: Option<LocalTime>| heard.is_some_and(|heard| now - heard <= FRESH);
        if self.phase.is_coupled() && self.heard.is_some() {
            return self.endpoint.snapshot().clock.round_trip.filter(|_| is_fresh(self.heard));
        }
        self.round_trips.latest().filter(|_| is_fresh(self.round_trips.heard()))
    }
}
