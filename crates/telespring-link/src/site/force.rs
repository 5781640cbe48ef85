//! The last gate of the force: scaled, locked, limited, and let down when the coupling ends.

use telespring::session::{LocalTime, Span};

use super::Limits;

/// Without a new command for longer than this, and two sample periods, a device may have let go by itself
/// (`docs/device-protocol.md`).
const HELD: Span = Span(5_000_000);

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
    /// Where the handle was at the latest measurement, m.
    place: Option<[f64; 2]>,
    since: Acting,
    lag: Lag,
}

/// The force of a motor that follows its commands with a time constant, as the study states it.
#[derive(Debug, Clone, Copy, Default)]
struct Lag {
    /// The time constant, s; 0 for none.
    constant: f64,
    force: [f64; 2],
    at: Option<LocalTime>,
}

impl Lag {
    /// Follows the command that has acted until `now`.
    fn follow(&mut self, now: LocalTime, command: [f64; 2]) {
        let elapsed = self.at.replace(now).map_or(0.0, |at| (now - at).seconds().max(0.0));
        let rest = (-elapsed / self.constant).exp();
        self.force = [0, 1].map(|axis| command[axis] + (self.force[axis] - command[axis]) * rest);
    }
}

/// What may have acted since the latest measurement.
#[derive(Debug, Clone, Copy, Default)]
struct Acting {
    /// Forces that went through.
    forces: u32,
    /// The least and the largest that acted, per axis, N.
    range: Option<[[f64; 2]; 2]>,
}

impl Acting {
    /// This force may have acted.
    fn add(&mut self, force: [f64; 2]) {
        let [least, most] = self.range.unwrap_or([force; 2]);
        self.range = Some([
            [0, 1].map(|axis| least[axis].min(force[axis])),
            [0, 1].map(|axis| most[axis].max(force[axis])),
        ]);
    }

    /// What the account takes along this way, m: per axis the force that gave out most, or took in least.
    fn worst(&self, way: [f64; 2]) -> [f64; 2] {
        let [least, most] = self.range.unwrap_or_default();
        [0, 1].map(|axis| if way[axis] > 0.0 { most[axis] } else { least[axis] })
    }
}

impl ForceGate {
    /// `lag`: the time constant of the motors, s.
    pub(super) fn new(limits: &Limits, sample_period: Span, computing_tick: bool, lag: f64) -> Self {
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
            place: None,
            since: Acting::default(),
            lag: Lag { constant: lag, ..Lag::default() },
        }
    }

    /// Along a locked axis nothing goes through.
    pub(super) fn lock(&mut self, scale: f64, lock: [bool; 2]) {
        self.scale = lock.map(|is_locked| if is_locked { 0.0 } else { scale });
    }

    /// The command that acts now.
    fn commanded(&self) -> ([f64; 2], bool) {
        let [last, before] = self.passed;
        if self.computing_tick { before } else { last }
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
        self.let_go_by(now);
        let [last, _] = self.passed;
        self.passed = [(force, force == wanted), last];
        self.since.forces += 1;
        self.since.add(if self.lag.constant > 0.0 { self.lag.force } else { self.commanded().0 });
        self.at = Some(now);
        force
    }

    /// Time has passed: a lagging force has followed, and the device may have let go if the latest command was long before.
    fn let_go_by(&mut self, now: LocalTime) {
        if self.lag.constant > 0.0 {
            self.lag.follow(now, self.commanded().0);
        }
        let held = HELD.max(self.sample_period + self.sample_period);
        if self.at.take_if(|at| now - *at > held).is_some() {
            self.since.forces += 1;
            self.since.add([0.0; 2]);
        }
    }

    /// Nothing goes through.
    pub(super) fn close(&mut self) {
        (self.was_cut, self.at) = (false, None);
        self.passed = [([0.0; 2], false); 2];
        self.since = Acting::default();
    }

    /// Whether the latest force was cut to the largest, or slowed.
    pub(super) fn was_cut(&self) -> bool {
        self.was_cut
    }

    /// The force that acted since the measurement before, of a handle that is measured at `place` now, if the endpoint does not
    /// know it. After one command per measurement that is the commanded one. After several, or behind a lag, nobody knows when the
    /// handle moved, and without a new one for long, nobody knows whether it still acted: the worst for the account counts.
    pub(super) fn settle(&mut self, now: LocalTime, place: [f64; 2]) -> Option<[f64; 2]> {
        self.let_go_by(now);
        let before = self.place.replace(place).unwrap_or(place);
        let mut since = std::mem::take(&mut self.since);
        let (force, is_known) = self.commanded();
        if self.lag.constant > 0.0 {
            since.add(self.lag.force);
        } else if since.forces <= 1 || since.range == Some([force; 2]) {
            return (!is_known).then_some(force);
        }
        Some(since.worst([0, 1].map(|axis| place[axis] - before[axis])))
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
            let mut ticking = Self(ForceGate::new(limits, PERIOD, computing_tick, 0.0), LocalTime(0));
            ticking.pass([0.0; 2], 1.0);
            ticking
        }

        fn pass(&mut self, wanted: [f64; 2], share: f64) -> [f64; 2] {
            self.1 = self.1 + PERIOD;
            let _ = self.0.settle(self.1, [0.0; 2]);
            self.0.pass(self.1, wanted, share)
        }

        /// What acted since the measurement before, of a handle that is at `place` a period later.
        fn acted(&mut self, place: [f64; 2]) -> Option<[f64; 2]> {
            self.0.clone().settle(self.1 + PERIOD, place)
        }
    }

    #[test]
    fn law_the_gate_limits_the_force_and_says_what_acted() {
        let mut gate = Ticking::new(&LIMITS, false);
        assert_eq!(gate.pass([3.0, 4.0], 1.0), [3.0, 4.0]);
        assert_eq!(gate.acted([0.0; 2]), None);
        assert_eq!(gate.pass([30.0, -40.0], 1.0), [6.0, -8.0]);
        assert_eq!(gate.acted([0.0; 2]), Some([6.0, -8.0]));
        assert_eq!(gate.pass([3.0, 4.0], 0.5), [1.5, 2.0]);
        assert_eq!(gate.acted([0.0; 2]), Some([1.5, 2.0]));
        assert_eq!(gate.pass([f64::NAN, 1.0], 1.0), [0.0; 2]);
        assert_eq!(gate.pass([f64::INFINITY, 1.0], 1.0), [0.0; 2]);
    }

    #[test]
    fn law_a_scale_takes_its_share_and_a_locked_axis_has_no_force() {
        let mut gate = Ticking::new(&Limits { scale: 0.5, lock: [false, true], ..LIMITS }, false);
        assert_eq!(gate.pass([4.0, 100.0], 1.0), [2.0, 0.0]);
        assert_eq!((gate.acted([0.0; 2]), gate.0.was_cut()), (Some([2.0, 0.0]), false));
        assert_eq!(gate.pass([40.0, 0.0], 1.0), [10.0, 0.0]);
        assert!(gate.0.was_cut());
    }

    #[test]
    fn law_with_a_computing_tick_the_force_before_acted() {
        let mut gate = Ticking::new(&LIMITS, true);
        gate.pass([20.0, 0.0], 1.0);
        gate.pass([1.0, 0.0], 1.0);
        assert_eq!(gate.acted([0.0; 2]), Some([10.0, 0.0]));
        gate.pass([2.0, 0.0], 1.0);
        assert_eq!(gate.acted([0.0; 2]), None);
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
        assert!((y - 1.5).abs() < 1e-12, "{y}");
        gate.0.close();
        let [_, y] = gate.pass([0.0, 30.0], 1.0);
        assert!((y - 1.0).abs() < 1e-12, "{y}");
    }

    #[test]
    fn law_after_several_commands_the_worst_of_them_counts() {
        let mut gate = Ticking::new(&LIMITS, false);
        gate.pass([3.0, -4.0], 1.0);
        // no measurement
        gate.0.pass(gate.1, [2.0, -1.0], 1.0);
        assert_eq!(gate.acted([1.0, 1.0]), Some([3.0, -1.0]));
        assert_eq!(gate.acted([-1.0, -1.0]), Some([2.0, -4.0]));
        // one force all the time is known
        gate.pass([2.0, -1.0], 1.0);
        gate.0.pass(gate.1, [2.0, -1.0], 1.0);
        assert_eq!(gate.acted([1.0, 1.0]), None);
        // the device has let go, or not; after one measurement that is over
        gate.pass([2.0, -1.0], 1.0);
        gate.1 = gate.1 + HELD;
        assert_eq!(gate.acted([1.0, 1.0]), Some([2.0, 0.0]));
        assert_eq!(gate.acted([-1.0, -1.0]), Some([0.0, -1.0]));
        gate.pass([2.0, -1.0], 1.0);
        assert_eq!(gate.acted([1.0, 1.0]), None);
    }

    #[test]
    fn law_behind_a_lag_the_account_takes_what_acted_and_not_the_command() {
        let mut gate = ForceGate::new(&LIMITS, PERIOD, false, 0.01);
        let (mut now, mut acting) = (LocalTime(0), 0.0);
        gate.pass(now, [0.0; 2], 1.0);
        for tick in 0..200 {
            now = now + PERIOD;
            let command = if tick < 100 { 5.0 } else { -5.0 };
            for (way, is_least) in [(1.0, false), (-1.0, true)] {
                let [told, _] = gate.clone().settle(now, [way, 0.0]).unwrap();
                // between the force at the measurement before and that at this one
                let range: [f64; 2] = acting_range(acting, if tick <= 100 { 5.0 } else { -5.0 }, tick);
                let expected = if is_least { range[0] } else { range[1] };
                assert!((told - expected).abs() < 1e-9, "{tick}: {told} {range:?}");
            }
            if tick > 0 {
                acting = after(acting, if tick <= 100 { 5.0 } else { -5.0 });
            }
            let _ = gate.settle(now, [0.0; 2]);
            gate.pass(now, [command, 0.0], 1.0);
        }
        assert!((acting + 5.0).abs() < 1e-3);
    }

    /// A force behind a lag of 10 ms, a period later.
    fn after(acting: f64, command: f64) -> f64 {
        command + (acting - command) * (-0.1_f64).exp()
    }

    fn acting_range(acting: f64, command: f64, tick: i32) -> [f64; 2] {
        let later = if tick == 0 { acting } else { after(acting, command) };
        [acting.min(later), acting.max(later)]
    }
}
