//! What a live site lets through of a replayed force.

use crate::session::{LocalTime, Span};

/// What a site lets through of a force at most.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceLimits {
    /// The largest force, N; infinite for no limit.
    pub largest: f64,
    /// Its steepest growth, N/s; infinite for no limit.
    pub rise: f64,
}

impl ForceLimits {
    /// No limit.
    pub const NONE: Self = Self { largest: f64::INFINITY, rise: f64::INFINITY };
}

/// A live site takes a device without a command for longer than this as one that may have let go.
const HELD: Span = Span(10_000_000);

/// The gate between endpoint and device, as a live site has it (`cross_what_a_site_tells_reproduces_its_session` holds the two
/// together): a share of the force, cut along its direction to a limit of its size and of its growth.
#[derive(Debug, Clone)]
pub(super) struct Gate {
    limits: ForceLimits,
    sample_period: Span,
    computing_tick: bool,
    /// When the latest force went through.
    at: Option<LocalTime>,
    /// The last two forces that went through, newest first, and whether each is what was wanted.
    passed: [([f64; 2], bool); 2],
}

impl Gate {
    /// A gate that is asked once per sample period; with a computing tick a force acts from the next tick on.
    pub(super) fn new(limits: ForceLimits, sample_period: Span, computing_tick: bool) -> Self {
        Self { limits, sample_period, computing_tick, at: None, passed: [([0.0; 2], true); 2] }
    }

    /// The force that goes through from `now` on, N: a share of the wanted one per axis, cut along its direction to the limit,
    /// and to what the force before may have grown to in this direction. It may fall at once.
    pub(super) fn pass(&mut self, now: LocalTime, wanted: [f64; 2], share: [f64; 2]) -> [f64; 2] {
        let [x, y] = [0, 1].map(|axis| wanted[axis] * share[axis]);
        let size = x.hypot(y);
        let [(before, _), _] = self.passed;
        let along = if size > 0.0 { (before[0] * x + before[1] * y) / size } else { 0.0 };
        // a standstill is no reason for a step
        let elapsed = self.at.map_or(self.sample_period, |at| now - at);
        let elapsed = elapsed.min(self.sample_period + self.sample_period);
        let largest = self.limits.largest.min(along.max(0.0) + self.limits.rise * elapsed.seconds());
        let force = if size > largest { [x, y].map(|force| force * (largest / size)) } else { [x, y] };
        // not finite: nothing goes through
        let force = if force.iter().all(|value| value.is_finite()) { force } else { [0.0; 2] };
        let [last, _] = self.passed;
        self.passed = [(force, force == wanted), last];
        self.at = Some(now);
        force
    }

    /// A motion is measured now: after a standstill the next force grows for one sample period only.
    pub(super) fn measure(&mut self, now: LocalTime) {
        let held = HELD.max(self.sample_period + self.sample_period);
        self.at = self.at.filter(|at| now - *at <= held);
    }

    /// Nothing goes through: the next force grows from zero.
    pub(super) fn close(&mut self) {
        self.at = None;
        self.passed = [([0.0; 2], false); 2];
    }

    /// The force that acted until a measurement now, N, if it is not what the endpoint wanted.
    pub(super) fn acted(&self) -> Option<[f64; 2]> {
        let [last, before] = self.passed;
        let (force, is_wanted) = if self.computing_tick { before } else { last };
        (!is_wanted).then_some(force)
    }
}
