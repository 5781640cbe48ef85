//! The last gate of the force: scaled, locked, limited, and let down when the coupling ends.

use super::Limits;

/// The last gate before the device: it limits the force, and remembers what it changed, so that the endpoint's account takes
/// the force that acted. What goes through is never longer than what was wanted, so the guard's proof holds behind it.
#[derive(Debug, Clone)]
pub(super) struct ForceGate {
    /// The share of the force per axis: 0 along a locked one.
    scale: [f64; 2],
    /// The largest force, N.
    largest: f64,
    computing_tick: bool,
    /// Whether the latest force was cut to the largest.
    was_cut: bool,
    /// The last two forces that went through, newest first, and whether they are what was wanted.
    passed: [([f64; 2], bool); 2],
}

impl ForceGate {
    pub(super) fn new(limits: &Limits, computing_tick: bool) -> Self {
        let scale = limits.lock.map(|is_locked| if is_locked { 0.0 } else { limits.scale });
        let passed = [([0.0; 2], true); 2];
        Self { scale, largest: limits.force, computing_tick, was_cut: false, passed }
    }

    /// The force that goes through: a share of the wanted one, cut to the limit along its direction.
    pub(super) fn pass(&mut self, wanted: [f64; 2], share: f64) -> [f64; 2] {
        let [x, y] = [0, 1].map(|axis| wanted[axis] * (share * self.scale[axis]));
        let size = x.hypot(y);
        self.was_cut = size > self.largest;
        let force = if self.was_cut { [x, y].map(|force| force * (self.largest / size)) } else { [x, y] };
        // not finite: nothing goes through
        let force = if force.iter().all(|value| value.is_finite()) { force } else { [0.0; 2] };
        let [last, _] = self.passed;
        self.passed = [(force, force == wanted), last];
        force
    }

    /// Nothing goes through.
    pub(super) fn close(&mut self) {
        self.was_cut = false;
        self.passed = [([0.0; 2], false); 2];
    }

    /// Whether the latest force was cut to the largest.
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

    #[test]
    fn law_the_gate_limits_the_force_and_says_what_acted() {
        let mut gate = ForceGate::new(&LIMITS, false);
        assert_eq!(gate.pass([3.0, 4.0], 1.0), [3.0, 4.0]);
        assert_eq!(gate.acted(), None);
        assert_eq!(gate.pass([30.0, -40.0], 1.0), [6.0, -8.0]);
        assert_eq!(gate.acted(), Some([6.0, -8.0]));
        assert_eq!(gate.pass([3.0, 4.0], 0.5), [1.5, 2.0]);
        assert_eq!(gate.acted(), Some([1.5, 2.0]));
        assert_eq!(gate.pass([f64::NAN, 1.0], 1.0), [0.0; 2]);
        assert_eq!(gate.pass([f64::INFINITY, 1.0], 1.0), [0.0; 2]);
    }

    #[test]
    fn law_a_scale_takes_its_share_and_a_locked_axis_has_no_force() {
        let mut gate = ForceGate::new(&Limits { scale: 0.5, lock: [false, true], ..LIMITS }, false);
        assert_eq!(gate.pass([4.0, 100.0], 1.0), [2.0, 0.0]);
        assert_eq!((gate.acted(), gate.was_cut()), (Some([2.0, 0.0]), false));
        assert_eq!(gate.pass([40.0, 0.0], 1.0), [10.0, 0.0]);
        assert!(gate.was_cut());
    }

    #[test]
    fn law_with_a_computing_tick_the_force_before_acted() {
        let mut gate = ForceGate::new(&LIMITS, true);
        gate.pass([20.0, 0.0], 1.0);
        gate.pass([1.0, 0.0], 1.0);
        assert_eq!(gate.acted(), Some([10.0, 0.0]));
        gate.pass([2.0, 0.0], 1.0);
        assert_eq!(gate.acted(), None);
    }
}
