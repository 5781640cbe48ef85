//! The last gate of the force: scaled, locked, limited, and let down when the coupling ends.

use telespring::session::{LocalTime, Span};

use super::Limits;

/// The last gate before the device: it limits the force and its growth, and remembers what it changed, so that the endpoint's
/// account takes the force that acted. What goes through is a share of what was wanted along each axis, so the guard's proof holds
/// behind it.
#[derive(Debug, Clone)]
pub(super) struct ForceGate {
    /// The share of the force per axis: 0 along a locked one.
    scale: [f64; 2],
    /// The largest force, N, and its steepest growth, N/s.
    largest: f64,
    rise: f64,
    sample_period: Span,
    computing_tick: bool,
    /// Whether the latest force was cut to the largest, or slowed.
    was_cut: bool,
    /// When the latest force went through.
    at: Option<LocalTime>,
    /// The last two forces that went through, newest first, and whether they are what was wanted.
    passed: [([f64; 2], bool); 2],
}

impl ForceGate {
    pub(super) fn new(limits: &Limits, sample_period: Span, computing_tick: bool) -> Self {
        let Limits { force, rise, scale, lock, .. } = *limits;
        Self {
            scale: lock.map(|is_locked| if is_locked { 0.0 } else { scale }),
            largest: force,
            rise,
            sample_period,
            computing_tick,
            was_cut: false,
            at: None,
            passed: [([0.0; 2], true); 2],
        }
    }

    /// The force that goes through from `now` on: a share of the wanted one, cut along its direction to the limit, and to what the
    /// force before may have grown to in this direction.
    pub(super) fn pass(&mut self, now: LocalTime, wanted: [f64; 2], share: f64) -> [f64; 2] {
        let [x, y] = [0, 1].map(|axis| wanted[axis] * (share * self.scale[axis]));
        let size = x.hypot(y);
        let [(before, _), _] = self.passed;
        let along = if size > 0.0 { (before[0] * x + before[1] * y) / size } else { 0.0 };
        // a standstill is no reason for a step
        let elapsed = self.at.map_or(self.sample_period, |at| now - at);
        let elapsed = elapsed.min(self.sample_period + self.sample_period);
        let largest = self.largest.min(along.max(0.0) + self.rise * elapsed.seconds());
        self.was_cut = size > largest;
        let force = if self.was_cut { [x, y].map(|force| force * (largest / size)) } else { [x, y] };
        // not finite: nothing goes through
        let force = if force.iter().all(|value| value.is_finite()) { force } else { [0.0; 2] };
        let [last, _] = self.passed;
        self.passed = [(force, force == wanted), last];
        self.at = Some(now);
        force
    }

    /// Nothing goes through.
    pub(super) fn close(&mut self) {
        (self.was_cut, self.at) = (false, None);
        self.passed = [([0.0; 2], false); 2];
    }

    /// Whether the latest force was cut to the largest, or slowed.
    pub(super) fn was_cut(&self) -> bool {
        self.was_cut
    }

    /// The force that acted since the last measurement, if the endpoint does not know it.
    pub(super) fn acted(&self) -> Option<[f64; 2]> {
        let [last, before] = self.passed;
        let (force, is_known) = if self.computing_tick { before } else { last };
        (!is_known).then_some(force)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits = Limits { force: 10.0, ..Limits::NONE };
    const PERIOD: Span = Span(1_000_000);

    /// A gate, and the ticks at which it is asked.
    struct Ticking(ForceGate, LocalTime);

    impl Ticking {
        fn new(limits: &Limits, computing_tick: bool) -> Self {
            let mut ticking = Self(ForceGate::new(limits, PERIOD, computing_tick), LocalTime(0));
            ticking.pass([0.0; 2], 1.0);
            ticking
        }

        fn pass(&mut self, wanted: [f64; 2], share: f64) -> [f64; 2] {
            self.1 = self.1 + PERIOD;
            self.0.pass(self.1, wanted, share)
        }
    }

    #[test]
    fn law_the_gate_limits_the_force_and_says_what_acted() {
        let mut gate = Ticking::new(&LIMITS, false);
        assert_eq!(gate.pass([3.0, 4.0], 1.0), [3.0, 4.0]);
        assert_eq!(gate.0.acted(), None);
        assert_eq!(gate.pass([30.0, -40.0], 1.0), [6.0, -8.0]);
        assert_eq!(gate.0.acted(), Some([6.0, -8.0]));
        assert_eq!(gate.pass([3.0, 4.0], 0.5), [1.5, 2.0]);
        assert_eq!(gate.0.acted(), Some([1.5, 2.0]));
        assert_eq!(gate.pass([f64::NAN, 1.0], 1.0), [0.0; 2]);
        assert_eq!(gate.pass([f64::INFINITY, 1.0], 1.0), [0.0; 2]);
    }

    #[test]
    fn law_a_scale_takes_its_share_and_a_locked_axis_has_no_force() {
        let mut gate = Ticking::new(&Limits { scale: 0.5, lock: [false, true], ..LIMITS }, false);
        assert_eq!(gate.pass([4.0, 100.0], 1.0), [2.0, 0.0]);
        assert_eq!((gate.0.acted(), gate.0.was_cut()), (Some([2.0, 0.0]), false));
        assert_eq!(gate.pass([40.0, 0.0], 1.0), [10.0, 0.0]);
        assert!(gate.0.was_cut());
    }

    #[test]
    fn law_with_a_computing_tick_the_force_before_acted() {
        let mut gate = Ticking::new(&LIMITS, true);
        gate.pass([20.0, 0.0], 1.0);
        gate.pass([1.0, 0.0], 1.0);
        assert_eq!(gate.0.acted(), Some([10.0, 0.0]));
        gate.pass([2.0, 0.0], 1.0);
        assert_eq!(gate.0.acted(), None);
    }

    #[test]
    fn law_the_force_grows_no_steeper_than_allowed_and_falls_at_once() {
        let mut gate = Ticking::new(&Limits { rise: 1000.0, ..LIMITS }, false);
        for expected in [1.0, 2.0, 3.0] {
            let [x, y] = gate.pass([30.0, 0.0], 1.0);
            assert!((x - expected).abs() < 1e-12 && y == 0.0 && gate.0.was_cut(), "{x}");
        }
        // to the other side: it falls at once, and grows from zero
        let [x, _] = gate.pass([-30.0, 0.0], 1.0);
        assert!((x + 1.0).abs() < 1e-12, "{x}");
        // across: what it was along the new direction is 0
        let [x, y] = gate.pass([0.0, 30.0], 1.0);
        assert!(x == 0.0 && (y - 1.0).abs() < 1e-12, "{y}");
        assert_eq!(gate.pass([0.0, 0.5], 1.0), [0.0, 0.5]);
        assert!(!gate.0.was_cut());
        // a standstill of the loop is no reason for a step, and neither is a closed gate
        gate.1 = gate.1 + Span(1_000_000_000);
        let [_, y] = gate.pass([0.0, 30.0], 1.0);
        assert!((y - 2.5).abs() < 1e-12, "{y}");
        gate.0.close();
        let [_, y] = gate.pass([0.0, 30.0], 1.0);
        assert!((y - 1.0).abs() < 1e-12, "{y}");
    }
}
