//! Whether the two sides are coupled: when it begins, when it is interrupted, and when the session ends.

use telespring::session::playout::PlayoutReport;
use telespring::session::{LocalTime, Span, WatchdogState};

use super::accord::Stage;
use super::alignment::Alignment;
use super::fallback::{Seen, Verdict};
use super::locks::without;
use super::{Badness, Cause, Consent, Happened, Interruption, Phase, Site, Why};
use crate::device::Device;
use crate::transport::Transport;

/// A partner that refuses, or is refused, for this long ends the session. So does a network that is too slow.
const PATIENCE: Span = Span(1_000_000_000);

/// Whether a force may act.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Coupling {
    /// No: no motion is sent or taken.
    Off,
    /// As the endpoint decides.
    On {
        /// Since when.
        since: LocalTime,
    },
    /// It falls to zero.
    Falling {
        /// Since when.
        since: LocalTime,
    },
}

/// Why a partner let go, as the stage shows that both are in without it.
fn why(stage: Stage) -> Why {
    match stage {
        Stage::Stopped => Why::Stopped,
        Stage::Homing => Why::NotReady,
        Stage::Paused => Why::Paused,
        _ => Why::LetGo,
    }
}

impl<D: Device, T: Transport> Site<D, T> {
    /// Judges, before anything is sent, what the own motion means for this side.
    pub(super) fn judge(&mut self, now: LocalTime) {
        if self.phase == Phase::Ended {
            return;
        }
        if let Coupling::Falling { since } = self.coupling
            && now - since >= self.safety.ramp_out
        {
            self.coupling = Coupling::Off;
            if let Some((_, cause)) = self.left {
                self.end(now, cause);
            }
        }
        if let Coupling::On { .. } = self.coupling {
            let broken = self.handle.and_then(|motion| self.limits.broken(&motion, &self.travel));
            if let Some(interruption) = broken {
                self.interrupt(now, interruption);
            }
        }
        if self.coupling != Coupling::Off {
            return;
        }
        let there = self.accord.partner().and_then(|stance| stance.position);
        self.offset = Alignment::offset(self.motion.as_ref(), there).map(|offset| without(self.lock, offset));
        let knows_network = self.knows_network();
        let is_inside = self.handle.is_some_and(|motion| self.limits.holds(motion.position));
        let is_resting = self.is_resting();
        let speed = self.motion.and_then(|motion| self.travel.speed(motion.velocity, self.lock));
        let own = &mut self.accord.own;
        let was = std::mem::replace(&mut own.is_aligned, false);
        own.is_aligned =
            self.alignment.judge(speed, self.offset, was) && is_inside && is_resting && knows_network;
        let position = self.motion.map(|motion| motion.position.map(|value| value as f32));
        own.position =
            position.filter(|place| place.iter().all(|value| value.abs() <= crate::hello::MAX_POSITION));
        if was != own.is_aligned {
            self.greeter.hurry();
        }
    }

    /// Decides, after everything that has come was taken, how both sides stand.
    pub(super) fn decide(&mut self, now: LocalTime) {
        if self.left.is_some() {
            return;
        }
        if let Some(disagreement) = self.greeter.refused_for(now, PATIENCE)
            && self.coupling == Coupling::Off
        {
            return self.end(now, Cause::Refused(disagreement));
        }
        self.judge_device(now);
        let mut stage = self.stage(now);
        if matches!(self.coupling, Coupling::On { .. }) {
            if stage == Stage::Agreed {
                self.fall_back(now);
            } else {
                self.interrupt(now, Interruption::Partner(why(stage)));
            }
            stage = self.stage(now);
        }
        if self.is_too_slow(now, stage) {
            return self.end(now, Cause::DelayRefused);
        }
        self.see_to_consent(stage);
        stage = self.stage(now);
        if self.coupling == Coupling::Off && stage == Stage::Agreed {
            self.couple(now);
        }
        if stage == Stage::Aligning && self.coupling == Coupling::Off {
            self.alignment.tell(now, self.offset, &mut self.log);
        } else {
            self.alignment.forget();
        }
        self.enter(now, self.phase_of(stage));
    }

    fn stage(&self, now: LocalTime) -> Stage {
        self.accord.stage(now, self.greeter.is_settled())
    }

    /// A consent ends where its grounds do; a simulated person gives one as soon as it can.
    fn see_to_consent(&mut self, stage: Stage) {
        let had = self.accord.own.has_consented;
        let has = match stage {
            Stage::Agreed => had,
            Stage::Consenting => had || self.rules.consent == Consent::Automatic,
            _ => false,
        };
        if had != has {
            self.accord.own.has_consented = has;
            self.greeter.hurry();
        }
    }

    /// The state that people are shown.
    fn phase_of(&self, stage: Stage) -> Phase {
        match (self.coupling, stage) {
            (Coupling::Falling { .. }, _) => Phase::RampingOut,
            (Coupling::On { .. }, _) => match self.endpoint.state() {
                WatchdogState::Disengaged { .. } | WatchdogState::RampingIn => Phase::RampingIn,
                _ => Phase::Running,
            },
            (_, Stage::Connecting) => Phase::Connecting,
            (_, Stage::Stopped) => Phase::Stopped,
            (_, Stage::Homing) => Phase::Homing,
            (_, Stage::Paused) => Phase::Paused,
            (_, Stage::Aligning) => Phase::Aligning,
            (_, Stage::Consenting | Stage::Agreed) => Phase::Consenting,
        }
    }

    fn enter(&mut self, now: LocalTime, phase: Phase) {
        if self.phase != phase {
            self.phase = phase;
            self.log.push(now, Happened::Entered(phase));
        }
    }

    /// The coupling begins; the endpoint's watchdog lets the force begin from zero.
    fn couple(&mut self, now: LocalTime) {
        self.coupling = Coupling::On { since: now };
        self.accord.couple();
        self.watch.begin(now);
        self.heard = None;
    }

    /// The coupling ends for now, suddenly or along a ramp, and this side takes back its consent.
    pub(super) fn interrupt(&mut self, now: LocalTime, interruption: Interruption) {
        if self.phase == Phase::Ended {
            return;
        }
        if interruption.is_sudden() && self.coupling != Coupling::Off {
            self.coupling = Coupling::Off;
            if let Some((_, cause)) = self.left {
                return self.end(now, cause);
            }
        }
        let was_coupled = self.accord.is_coupled();
        self.accord.part();
        self.greeter.hurry();
        if !was_coupled {
            return;
        }
        self.accord.own.is_paused |= interruption.pauses();
        self.tally.interruptions += 1;
        self.log.push(now, Happened::Interrupted(interruption));
        if matches!(self.coupling, Coupling::On { .. }) {
            self.coupling = Coupling::Falling { since: now };
        }
    }

    /// Judges the network while the coupling acts.
    fn fall_back(&mut self, now: LocalTime) {
        let Coupling::On { since } = self.coupling else { return };
        let heard = self.heard.unwrap_or(since);
        let is_silent = self.heard.is_some() && now - heard >= self.safety.silence;
        let age = self.endpoint.partner_age().filter(|_| self.endpoint.state() == WatchdogState::Engaged);
        let seen = Seen { heard, age, is_silent };
        let (watch, endpoint, passed_over) = (&mut self.watch, &self.endpoint, &self.passed_over);
        let counts = || {
            let playout = endpoint.report().playout;
            PlayoutReport { lost: passed_over.lost(playout.lost), ..playout }
        };
        match watch.judge(now, &seen, counts) {
            Verdict::Same => {}
            Verdict::Soften(badness) => self.soften(now, badness),
            Verdict::Harden => self.log.push(now, Happened::Restored),
            Verdict::Pause(badness) => {
                self.log.push(now, Happened::NetworkPause(badness));
                self.interrupt(now, Interruption::Network);
            }
        }
    }

    fn soften(&mut self, now: LocalTime, badness: Badness) {
        self.log.push(now, Happened::Softened(badness));
        if let (Some(imposed), Badness::Held | Badness::Age, Some(measured)) =
            (self.rules.imposed_delay, badness, self.endpoint.partner_age())
        {
            self.log.push(now, Happened::DelayTooShort { imposed, measured });
        }
    }

    /// Whether a delay is imposed that the network cannot keep, for longer than by chance. Before that is known, nobody is
    /// coupled: [`Site::knows_network`].
    fn is_too_slow(&mut self, now: LocalTime, stage: Stage) -> bool {
        let (Some(imposed), Some(round_trip)) = (self.rules.imposed_delay, self.round_trips.median()) else {
            return false;
        };
        let measured = round_trip.seconds() / 2.0;
        if measured <= imposed || self.coupling != Coupling::Off || stage == Stage::Connecting {
            self.too_short_since = None;
            return false;
        }
        if self.too_short_since.is_none() {
            self.too_short_since = Some(now);
            self.log.push(now, Happened::DelayTooShort { imposed, measured });
        }
        self.too_short_since.is_some_and(|since| now - since >= PATIENCE)
    }

    /// Whether enough is known of the network for the delay that is imposed.
    fn knows_network(&self) -> bool {
        self.rules.imposed_delay.is_none()
            || (self.round_trips.median().is_some() && self.too_short_since.is_none())
    }

    /// The partner has left.
    pub(super) fn part_for_good(&mut self, now: LocalTime) {
        if self.tally.coupled_ticks > 0 {
            self.leave(now, Cause::PartnerLeft);
        } else if self.too_short_since.is_some() {
            // it has found the same, a moment earlier
            self.end(now, Cause::DelayRefused);
        } else {
            // nothing has begun yet: it may start anew
            self.greeter.forget();
        }
    }

    /// Lets the force fall to zero, then ends.
    pub(super) fn leave(&mut self, now: LocalTime, cause: Cause) {
        if self.left.is_some() || self.phase == Phase::Ended {
            return;
        }
        if self.coupling == Coupling::Off {
            return self.end(now, cause);
        }
        self.left = Some((now, cause));
        self.greet_at = now;
        self.log.push(now, Happened::Leaving(cause));
        if matches!(self.coupling, Coupling::On { .. }) {
            self.coupling = Coupling::Falling { since: now };
        }
        self.accord.part();
        self.enter(now, Phase::RampingOut);
    }

    /// Ends at once: the force is zero from now on.
    pub(super) fn end(&mut self, now: LocalTime, cause: Cause) {
        if self.phase != Phase::Ended {
            self.coupling = Coupling::Off;
            self.accord.part();
            self.phase = Phase::Ended;
            self.left = Some((now, cause));
            self.greet_at = now;
            self.log.push(now, Happened::Ended(cause));
        }
    }

    /// The share of the force that acts.
    fn share(&self, now: LocalTime) -> f64 {
        let falling = match self.coupling {
            Coupling::Off => 0.0,
            Coupling::On { .. } => 1.0,
            Coupling::Falling { since } => {
                (1.0 - (now - since).0 as f64 / self.safety.ramp_out.0.max(1) as f64).clamp(0.0, 1.0)
            }
        };
        falling * self.watch.share()
    }

    /// The force from now on.
    pub(super) fn force(&mut self, now: LocalTime) -> [f64; 2] {
        if self.coupling == Coupling::Off {
            self.gate.close(now);
            return [0.0; 2];
        }
        let wanted = self.endpoint.force(now);
        let share = self.share(now);
        (self.notes.asked, self.notes.forces.wanted, self.notes.share) = (Some(now), Some(wanted), share);
        self.gate.pass(now, wanted, share)
    }
}
