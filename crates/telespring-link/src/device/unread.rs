//! Several rows of a device between two ticks.

use super::protocol::State;

/// What the rows since the latest reading say together.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Unread {
    /// How many.
    pub(super) rows: u32,
    /// Sum of the measured forces, N, and their number.
    force: ([f64; 2], u32),
    /// A stop, or motors that may not act, in any row: another one behind it undoes nothing.
    pub(super) was_unready: bool,
    pub(super) was_stopped: bool,
}

impl Unread {
    /// Takes a row.
    pub(super) fn add(&mut self, state: &State) {
        self.rows += 1;
        self.was_unready |= !(state.is_enabled && state.is_homed);
        self.was_stopped |= state.is_stopped;
        if let Some(force) = state.measured_force {
            let (sum, count) = self.force;
            self.force = ([0, 1].map(|axis| sum[axis] + force[axis]), count + 1);
        }
    }

    /// The mean of the measured forces, N.
    pub(super) fn force(&self) -> Option<[f64; 2]> {
        let (sum, count) = self.force;
        (count > 0).then(|| sum.map(|sum| sum / f64::from(count)))
    }
}
