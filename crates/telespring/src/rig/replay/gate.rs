//! What a live site lets through of a replayed force.

/// The gate between endpoint and device, as a live site has it: a share of the force, cut to a limit along its direction.
#[derive(Debug, Clone)]
pub(super) struct Gate {
    /// The largest force, N.
    largest: f64,
    computing_tick: bool,
    /// The last two forces that went through, newest first, and whether each is what was wanted.
    passed: [([f64; 2], bool); 2],
}

impl Gate {
    pub(super) fn new(largest: f64, computing_tick: bool) -> Self {
        Self { largest, computing_tick, passed: [([0.0; 2], true); 2] }
    }

    /// The force that goes through.
    pub(super) fn pass(&mut self, wanted: [f64; 2], share: [f64; 2]) -> [f64; 2] {
        let [x, y] = [0, 1].map(|axis| wanted[axis] * share[axis]);
        let size = x.hypot(y);
        let force =
            if size > self.largest { [x, y].map(|force| force * (self.largest / size)) } else { [x, y] };
        let force = if force.iter().all(|value| value.is_finite()) { force } else { [0.0; 2] };
        let [last, _] = self.passed;
        self.passed = [(force, force == wanted), last];
        force
    }

    /// Nothing goes through.
    pub(super) fn close(&mut self) {
        self.passed = [([0.0; 2], false); 2];
    }

    /// The force that acted until a measurement now, if it is not what the endpoint wanted, N.
    pub(super) fn acted(&self) -> Option<[f64; 2]> {
        let [last, before] = self.passed;
        let (force, is_wanted) = if self.computing_tick { before } else { last };
        (!is_wanted).then_some(force)
    }
}
