//! What one side lets through of the force of its endpoint: the same on the robot and in a replay.

#![cfg_attr(not(test), deny(clippy::indexing_slicing))]

use super::{LocalTime, Span};

/// Without a new command for longer than this, and two sample periods, a device may have let go by itself
/// (`docs/device-protocol.md`).
const HELD: Span = Span(5_000_000);

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

/// A force that went through the gate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passed {
    /// The force, N.
    pub force: [f64; 2],
    /// Whether it is what the endpoint wanted.
    pub is_wanted: bool,
}

impl Passed {
    const NOTHING: Self = Self { force: [0.0; 2], is_wanted: false };
}

/// The gate between endpoint and device: a share of the force, cut along its direction to a limit of its size and of its
/// growth, and a memory of what went through. What goes through is a share of what was wanted along each axis, so the guard's
/// proof holds behind it.
///
/// # Examples
///
/// ```
/// use telespring::session::gate::{ForceGate, ForceLimits};
/// use telespring::session::{LocalTime, Span};
///
/// let mut gate = ForceGate::new(ForceLimits { largest: 5.0, ..ForceLimits::NONE }, Span(1_000_000), false);
/// assert_eq!(gate.pass(LocalTime(0), [30.0, -40.0], [1.0; 2]), [3.0, -4.0]);
/// assert!(gate.was_cut() && !gate.commanded().is_wanted);
/// ```
#[derive(Debug, Clone)]
pub struct ForceGate {
    limits: ForceLimits,
    sample_period: Span,
    computing_tick: bool,
    /// When the latest force went through; `None` if it may act no more.
    at: Option<LocalTime>,
    /// The last two forces that went through, newest first.
    passed: [Passed; 2],
    was_cut: bool,
}

impl ForceGate {
    /// A gate that is asked once per sample period; with a computing tick a force acts from the next tick on.
    pub fn new(limits: ForceLimits, sample_period: Span, computing_tick: bool) -> Self {
        let nothing = Passed { is_wanted: true, ..Passed::NOTHING };
        Self { limits, sample_period, computing_tick, at: None, passed: [nothing; 2], was_cut: false }
    }

    /// The force that goes through from `now` on, N: a share of the wanted one per axis, cut along its direction to the limit,
    /// and to what the force before may have grown to in this direction. It may fall at once.
    pub fn pass(&mut self, now: LocalTime, wanted: [f64; 2], share: [f64; 2]) -> [f64; 2] {
        // a standstill is no reason for a step
        self.release(now);
        let elapsed = self.at.map_or(self.sample_period, |at| now - at);
        let elapsed = elapsed.min(self.sample_period + self.sample_period);
        let ([u, v], [a, b]) = (wanted, share);
        let [x, y] = [u * a, v * b];
        let size = x.hypot(y);
        let [Passed { force: [p, q], .. }, _] = self.passed;
        let along = if size > 0.0 { (p * x + q * y) / size } else { 0.0 };
        let largest = self.limits.largest.min(along.max(0.0) + self.limits.rise * elapsed.seconds());
        self.was_cut = size > largest;
        let force = if self.was_cut { [x, y].map(|force| force * (largest / size)) } else { [x, y] };
        // not finite: nothing goes through
        let force = if force.iter().all(|value| value.is_finite()) { force } else { [0.0; 2] };
        self.note(now, Passed { force, is_wanted: force == wanted });
        force
    }

    /// Nothing goes through from `now` on. What went through before may act until the device has heard of it
    /// ([`ForceGate::is_idle`]). The next force grows from zero.
    pub fn close(&mut self, now: LocalTime) {
        let was_idle = self.is_idle();
        self.was_cut = false;
        self.note(now, Passed::NOTHING);
        self.at = self.at.filter(|_| !was_idle);
    }

    fn note(&mut self, now: LocalTime, passed: Passed) {
        let [last, _] = self.passed;
        self.passed = [passed, last];
        self.at = Some(now);
    }

    /// Whether the device may have let go by itself just now, because the latest command was long before. The next force grows
    /// for one sample period only then.
    pub fn release(&mut self, now: LocalTime) -> bool {
        let held = HELD.max(self.sample_period + self.sample_period);
        self.at.take_if(|at| now - *at > held).is_some()
    }

    /// The command that acts now.
    pub fn commanded(&self) -> Passed {
        let [last, before] = self.passed;
        if self.computing_tick { before } else { last }
    }

    /// Whether no command that acts now or later is a force.
    pub fn is_idle(&self) -> bool {
        let [last, before] = self.passed.map(|passed| passed.force == [0.0; 2]);
        last && (before || !self.computing_tick)
    }

    /// Whether the latest force was cut to the largest, or slowed.
    pub fn was_cut(&self) -> bool {
        self.was_cut
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: Span = Span(1_000_000);

    /// A gate, and the ticks at which it is asked.
    struct Ticking(ForceGate, LocalTime);

    impl Ticking {
        fn new(limits: ForceLimits) -> Self {
            let mut ticking = Self(ForceGate::new(limits, PERIOD, false), LocalTime(0));
            ticking.pass([0.0; 2]);
            ticking
        }

        fn pass(&mut self, wanted: [f64; 2]) -> [f64; 2] {
            self.1 = self.1 + PERIOD;
            self.0.pass(self.1, wanted, [1.0; 2])
        }
    }

    #[test]
    fn law_the_force_grows_no_steeper_than_allowed_and_falls_at_once() {
        let mut gate = Ticking::new(ForceLimits { largest: 10.0, rise: 1000.0 });
        for expected in [1.0, 2.0, 3.0] {
            let [x, y] = gate.pass([30.0, 0.0]);
            assert!((x - expected).abs() < 1e-12 && y == 0.0 && gate.0.was_cut(), "{x}");
        }
        // to the other side: it falls at once, and grows from zero
        let [x, _] = gate.pass([-30.0, 0.0]);
        assert!((x + 1.0).abs() < 1e-12, "{x}");
        // across: what it was along the new direction is 0
        let [x, y] = gate.pass([0.0, 30.0]);
        assert!(x == 0.0 && (y - 1.0).abs() < 1e-12, "{y}");
        assert_eq!(gate.pass([0.0, 0.5]), [0.0, 0.5]);
        assert!(!gate.0.was_cut());
        // a late tick lets it grow for two, a standstill for one: that is no reason for a step
        gate.1 = gate.1 + Span(3_000_000);
        let [_, y] = gate.pass([0.0, 30.0]);
        assert!((y - 2.5).abs() < 1e-12, "{y}");
        gate.1 = gate.1 + Span(1_000_000_000);
        let [_, y] = gate.pass([0.0, 30.0]);
        assert!((y - 3.5).abs() < 1e-12, "{y}");
        // and neither is a closed gate
        gate.0.close(gate.1);
        let [_, y] = gate.pass([0.0, 30.0]);
        assert!((y - 1.0).abs() < 1e-12, "{y}");
    }

    #[test]
    fn law_what_is_not_finite_does_not_go_through() {
        let mut gate = Ticking::new(ForceLimits { largest: 10.0, ..ForceLimits::NONE });
        assert_eq!(gate.pass([f64::NAN, 1.0]), [0.0; 2]);
        assert_eq!(gate.pass([f64::INFINITY, 1.0]), [0.0; 2]);
        assert_eq!(gate.pass([30.0, -40.0]), [6.0, -8.0]);
    }

    #[test]
    fn law_a_closed_gate_is_idle_once_no_command_acts() {
        for (computing_tick, ticks) in [(false, 1), (true, 2)] {
            let mut gate = ForceGate::new(ForceLimits::NONE, PERIOD, computing_tick);
            assert!(gate.is_idle());
            gate.pass(LocalTime(1_000_000), [1.0, 0.0], [1.0; 2]);
            for tick in 0..ticks {
                assert!(!gate.is_idle(), "{tick}");
                gate.close(LocalTime(2_000_000 + tick * 1_000_000));
            }
            assert!(gate.is_idle());
        }
    }
}
