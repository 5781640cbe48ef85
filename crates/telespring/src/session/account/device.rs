//! What the device will still do of the forces commanded so far.

use super::AccountSettings;

/// The forces that still act after the balance has changed, as sizes: an upper bound, whatever their directions.
///
/// With a computing tick a command reaches the device one period later; behind a lag the force that acts follows it. The
/// impulse of all that is still to come, in sample periods, is what the account must be able to pay.
#[derive(Debug, Clone, Copy)]
pub(super) struct Device {
    computing_tick: bool,
    /// The time constant, s.
    lag: f64,
    /// The same in sample periods.
    lag_periods: f64,
    /// The command that reaches the device at the next measurement, N; 0 without a computing tick.
    waiting: f64,
    /// The command that the device follows, N.
    commanded: f64,
    /// The force behind the lag, N.
    acting: f64,
}

impl Device {
    /// A device at rest.
    pub(super) fn new(settings: &AccountSettings) -> Self {
        let AccountSettings { computing_tick, actuator_lag: lag, sample_period, .. } = *settings;
        let lag_periods = lag / sample_period;
        Self { computing_tick, lag, lag_periods, waiting: 0.0, commanded: 0.0, acting: 0.0 }
    }

    /// Time passes, s.
    pub(super) fn advance(&mut self, elapsed: f64) {
        if self.lag > 0.0 && elapsed > 0.0 {
            let rest = (-elapsed / self.lag).exp();
            self.acting = self.commanded + (self.acting - self.commanded) * rest;
        }
    }

    /// The impulse that earlier commands will still give, N for one sample period each.
    pub(super) fn outstanding(&self) -> f64 {
        self.waiting + self.lag_periods * self.acting
    }

    /// A force of this size is commanded until the next measurement, N.
    pub(super) fn command(&mut self, size: f64) {
        (self.waiting, self.commanded) = if self.computing_tick { (size, self.waiting) } else { (0.0, size) };
    }
}
