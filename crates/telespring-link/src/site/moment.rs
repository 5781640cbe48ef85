//! One tick of a site as others see it, and sums over all of them.

use telespring::session::strategy::PartnerView;
use telespring::session::{LocalTime, Motion, SessionSnapshot, Span, WatchdogState};

use super::Phase;
use super::notes::{Forces, Latency, Newest, transit};
use crate::device::Stamp;

/// One tick of a site.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// The number of the tick, from 0.
    pub tick: u64,
    /// When.
    pub time: LocalTime,
    /// When the force was commanded.
    pub commanded: LocalTime,
    /// The state of the session.
    pub phase: Phase,
    /// The state of the endpoint's watchdog; it says nothing before the session runs.
    pub state: WatchdogState,
    /// The motion that the device reported; 0 along an axis that is locked, here or there.
    pub motion: Option<Motion>,
    /// The target that the person sees.
    pub target: Option<Motion>,
    /// The force commanded, N.
    pub force: [f64; 2],
    /// The energy in the account, J; `None` if the strategy keeps none.
    pub balance: Option<f64>,
    /// The age of the partner's motion in use, s; `None` while nothing is coupled.
    pub age: Option<f64>,
    /// When the partner's latest packet came.
    pub heard: Option<LocalTime>,
    /// From the own handle to the partner's, m, as the greetings have it; `None` if it is not known, or while coupled.
    pub offset: Option<[f64; 2]>,
    /// Whether the person here consents, and the one there.
    pub consents: [bool; 2],
    /// Whether this site wants a pause, and the partner.
    pub pauses: [bool; 2],
    /// The latest round trip; `None` if nothing has come lately.
    pub round_trip: Option<Span>,
    /// The share of the endpoint's force that is let through: below 1 while it is softened or let down, 0 without a force.
    pub share: f64,
    /// Whether the force was cut to its limit.
    pub is_cut: bool,
    /// The device's stamp of its newest measurement.
    pub stamp: Option<Stamp>,
    /// How much longer than the shortest lately the motion took from the device to the tick, s.
    pub device_delay: Option<f64>,
    /// Whether the endpoint was given the motion, and the target if there is one.
    pub is_measured: bool,
    /// Whether the endpoint was told the time alone, with no motion: its force falls to zero after a coupling.
    pub is_timed: bool,
    /// The forces beside the commanded one.
    pub forces: Forces,
    /// When the endpoint was asked for its force; `None` if it was not.
    pub asked: Option<LocalTime>,
    /// The partner's newest packet.
    pub newest: Option<Newest>,
    /// The endpoint after this tick.
    pub session: SessionSnapshot,
    /// The stiffness of the study, N/m.
    pub wanted_stiffness: f64,
    /// Datagrams that the endpoint was given so far, but that are not among the arrivals: a flood.
    pub unnoted_arrivals: u64,
}

impl Moment {
    /// The partner as the force of this tick used it; `None` if it used none.
    pub fn used_partner(&self) -> Option<PartnerView> {
        // while the endpoint is not asked, its view of the partner is that of an earlier time
        self.asked.and(self.session.partner)
    }

    /// Whether the strategy changed the force of the spring at this tick.
    pub fn is_limited(&self) -> bool {
        // while the endpoint is not asked, what it has to say is of an earlier time
        self.asked.is_some() && self.session.outgoing.limited
    }

    /// The stiffness that acts, N/m: that of the strategy, as far as watchdog and site let it through; 0 without a force.
    pub fn stiffness_in_use(&self) -> f64 {
        let acts = self.used_partner().is_some();
        if acts { self.session.outgoing.stiffness * self.session.enabled * self.share } else { 0.0 }
    }

    /// From the handle to the target while the session runs, m.
    pub fn distance(&self) -> Option<f64> {
        let (motion, target) = self.motion.zip(self.target).filter(|_| self.phase.is_coupled())?;
        let [x, y] = [0, 1].map(|axis| motion.position[axis] - target.position[axis]);
        Some(x.hypot(y))
    }

    /// Where the time went, of a tick that began `lateness` after it was due.
    pub fn latency(&self, lateness: Span) -> Latency {
        let newest = self.newest.as_ref().filter(|_| self.phase.is_coupled());
        let network = newest.and_then(|newest| transit(newest, self.session.clock.offset));
        let used = self.used_partner();
        Latency {
            device: self.device_delay,
            control: (lateness + (self.commanded - self.time)).seconds(),
            network,
            playout: used.zip(network).map(|(used, network)| used.age - network),
        }
    }
}

/// Counts and sums over the ticks of a site.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Tally {
    /// Ticks.
    pub ticks: u64,
    /// Ticks at which the session ran.
    pub coupled_ticks: u64,
    /// Ticks at which the device reported no new motion, while the session ran.
    pub unmeasured_ticks: u64,
    /// Ticks at which more datagrams had come than one tick looks at.
    pub full_ticks: u64,
    /// Greetings that were not for this session.
    pub strange_greetings: u64,
    /// Greetings of the partner that came after a later one.
    pub overtaken_greetings: u64,
    /// Packets of a session that was not agreed to.
    pub strange_packets: u64,
    /// Datagrams that came before the session ran.
    pub early_datagrams: u64,
    /// Ticks at which the force was cut to its limit.
    pub cut_ticks: u64,
    /// Ticks at which the force was softened because of the network.
    pub softened_ticks: u64,
    /// How often a coupling was interrupted.
    pub interruptions: u64,
    /// How often an emergency stop latched, here or there.
    pub emergency_stops: u64,
    /// The largest force commanded, N.
    pub largest_force: f64,
    /// The least energy in the account, J; `None` if the strategy keeps none.
    pub least_balance: Option<f64>,
    /// Sum of the distances to the target, m, and their number.
    pub distance: (f64, u64),
    /// From the first to the latest tick.
    pub first: Option<LocalTime>,
    /// See `first`.
    pub latest: LocalTime,
}

impl Tally {
    pub(super) fn count(&mut self, moment: &Moment) {
        self.ticks += 1;
        self.first.get_or_insert(moment.time);
        self.latest = moment.time;
        let [x, y] = moment.force;
        self.largest_force = self.largest_force.max(x.hypot(y));
        if let Some(balance) = moment.balance {
            self.least_balance = Some(self.least_balance.map_or(balance, |least| least.min(balance)));
        }
        if moment.phase.is_coupled() {
            self.coupled_ticks += 1;
            self.unmeasured_ticks += u64::from(moment.motion.is_none());
            if let Some(distance) = moment.distance() {
                self.distance = (self.distance.0 + distance, self.distance.1 + 1);
            }
        }
    }

    /// From the first to the latest tick.
    pub fn duration(&self) -> Span {
        self.first.map_or(Span(0), |first| self.latest - first)
    }

    /// The mean distance to the target while the session ran, m.
    pub fn tracking_error(&self) -> Option<f64> {
        let (sum, count) = self.distance;
        (count > 0).then(|| sum / count as f64)
    }
}
