//! The last gate of the force: scaled, locked, limited, and let down when the coupling ends.

use telespring::session::gate::{self, ForceLimits, Passed};
use telespring::session::{LocalTime, Span};

use super::Limits;

/// A force behind a lag that is smaller acts no more, N.
const LEAST: f64 = 1e-3;

/// The last gate before the device: that of the core, and what the endpoint's account must know of it. The account takes the force
/// that acted.
#[derive(Debug, Clone)]
pub(super) struct ForceGate {
    gate: gate::ForceGate,
    /// The share of the force per axis: 0 along a locked one.
    scale: [f64; 2],
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
    /// Whether no force acts.
    fn is_idle(&self) -> bool {
        let [x, y] = self.force;
        x.hypot(y) < LEAST
    }

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
    /// Whether no force may have acted.
    fn is_nothing(&self) -> bool {
        self.range.is_none_or(|range| range == [[0.0; 2]; 2])
    }

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
        let Limits { force: largest, rise, scale, lock, .. } = *limits;
        Self {
            gate: gate::ForceGate::new(ForceLimits { largest, rise }, sample_period, computing_tick),
            scale: lock.map(|is_locked| if is_locked { 0.0 } else { scale }),
            place: None,
            since: Acting::default(),
            lag: Lag { constant: lag, ..Lag::default() },
        }
    }

    /// Along a locked axis nothing goes through.
    pub(super) fn lock(&mut self, scale: f64, lock: [bool; 2]) {
        self.scale = lock.map(|is_locked| if is_locked { 0.0 } else { scale });
    }

    /// The force that goes through from `now` on: a share of the wanted one, within the limits.
    pub(super) fn pass(&mut self, now: LocalTime, wanted: [f64; 2], share: f64) -> [f64; 2] {
        self.let_go_by(now);
        let force = self.gate.pass(now, wanted, self.scale.map(|scale| share * scale));
        self.note();
        force
    }

    /// Nothing goes through from `now` on. What went through before is still to be measured: [`ForceGate::is_settled`].
    pub(super) fn close(&mut self, now: LocalTime) {
        let is_settled = self.is_settled();
        self.let_go_by(now);
        self.gate.close(now);
        if is_settled {
            self.since = Acting::default();
        } else {
            self.note();
        }
    }

    /// Whether no force acts, or has acted since the latest measurement: the account knows of all.
    pub(super) fn is_settled(&self) -> bool {
        self.gate.is_idle() && self.lag.is_idle() && self.since.is_nothing()
    }

    /// What went through just now may act until the next measurement.
    fn note(&mut self) {
        self.since.forces += 1;
        self.since.add(if self.lag.constant > 0.0 { self.lag.force } else { self.gate.commanded().force });
    }

    /// Time has passed: a lagging force has followed, and the device may have let go if the latest command was long before.
    fn let_go_by(&mut self, now: LocalTime) {
        if self.lag.constant > 0.0 {
            self.lag.follow(now, self.gate.commanded().force);
        }
        if self.gate.release(now) {
            self.since.forces += 1;
            self.since.add([0.0; 2]);
        }
    }

    /// Whether the latest force was cut to the largest, or slowed.
    pub(super) fn was_cut(&self) -> bool {
        self.gate.was_cut()
    }

    /// The force that acted since the measurement before, of a handle that is measured at `place` now, if the endpoint does not
    /// know it. After one command per measurement that is the commanded one. After several, or behind a lag, nobody knows when the
    /// handle moved, and without a new one for long, nobody knows whether it still acted: the worst for the account counts.
    pub(super) fn settle(&mut self, now: LocalTime, place: [f64; 2]) -> Option<[f64; 2]> {
        self.let_go_by(now);
        let before = self.place.replace(place).unwrap_or(place);
        let mut since = std::mem::take(&mut self.since);
        let Passed { force, is_wanted } = self.gate.commanded();
        if self.lag.constant > 0.0 {
            since.add(self.lag.force);
        } else if since.forces <= 1 || since.range == Some([force; 2]) {
            return (!is_wanted).then_some(force);
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
        gate.1 = gate.1 + Span(5_000_000);
        assert_eq!(gate.acted([1.0, 1.0]), Some([2.0, 0.0]));
        assert_eq!(gate.acted([-1.0, -1.0]), Some([0.0, -1.0]));
        gate.pass([2.0, -1.0], 1.0);
        assert_eq!(gate.acted([1.0, 1.0]), None);
    }

    #[test]
    fn law_a_closed_gate_is_settled_once_all_that_went_through_is_measured() {
        let mut gate = Ticking::new(&LIMITS, true);
        assert!(gate.0.is_settled());
        gate.pass([3.0, -4.0], 1.0);
        // a device that is silent meanwhile, for however long
        for tick in 1..500 {
            gate.0.close(gate.1 + Span(tick * PERIOD.0));
            assert!(!gate.0.is_settled());
        }
        gate.1 = gate.1 + Span(500 * PERIOD.0);
        assert_eq!(gate.acted([0.1, 0.1]), Some([3.0, 0.0]));
        assert_eq!(gate.acted([-0.1, -0.1]), Some([0.0, -4.0]));
        let _ = gate.0.settle(gate.1, [0.1, 0.1]);
        gate.0.close(gate.1);
        assert!(gate.0.is_settled());
        // one that measures goes on until the last command has acted
        let mut gate = Ticking::new(&LIMITS, true);
        gate.pass([3.0, -4.0], 1.0);
        gate.pass([1.0, 0.0], 1.0);
        for expected in [[3.0, -4.0], [1.0, 0.0]] {
            gate.1 = gate.1 + PERIOD;
            // wanted or not: the endpoint does not know what acts once it is asked no more
            let told = gate.0.settle(gate.1, [0.0; 2]);
            assert!(told.is_none_or(|told| told == expected), "{told:?}");
            assert!(!gate.0.is_settled(), "{expected:?}");
            gate.0.close(gate.1);
        }
        gate.1 = gate.1 + PERIOD;
        let _ = gate.0.settle(gate.1, [0.0; 2]);
        gate.0.close(gate.1);
        assert!(gate.0.is_settled());
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
