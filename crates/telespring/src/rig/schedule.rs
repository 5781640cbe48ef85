//! The ticks of a trial that are run and recorded.

use crate::error::{InvalidInput, Result};
use crate::quantity;

/// The maximum number of ticks of one trial.
pub const MAX_TICKS: usize = 100_000_000;

/// The number of ticks of a trial, and the stride of the recorded ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Schedule {
    ticks: usize,
    stride: usize,
}

impl Schedule {
    /// Creates the schedule of a trial of `duration` s with `record_rate` rows per second.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if a value is out of range, the record rate does not divide the controllers' rate,
    /// or there are more than [`MAX_TICKS`].
    ///
    /// # Examples
    ///
    /// ```
    /// let schedule = telespring::rig::Schedule::new(29.111, 100.0, 0.001)?;
    /// assert_eq!((schedule.ticks(), schedule.stride(), schedule.rows()), (29_111, 10, 2_912));
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn new(duration: f64, record_rate: f64, sample_period: f64) -> Result<Self> {
        quantity::DURATION.check("duration", duration)?;
        quantity::RATE.check("record_rate", record_rate)?;
        let exact = 1.0 / (record_rate * sample_period);
        let stride = exact.round();
        if !(stride >= 1.0 && (exact - stride).abs() <= 1e-9 * stride) {
            return Err(InvalidInput::new(
                "record_rate",
                record_rate,
                format!("the record rate must divide the controllers' rate, {} Hz", 1.0 / sample_period),
                format!(
                    "Write {}, or another integer fraction of it.",
                    1.0 / (sample_period * stride.max(1.0))
                ),
            ));
        }
        // At 1 kHz 0.29 s has 290 ticks, although the quotient rounds to 289.999….
        let ticks = (duration / sample_period * (1.0 + 4.0 * f64::EPSILON)).floor();
        if ticks > MAX_TICKS as f64 {
            return Err(InvalidInput::new(
                "duration",
                duration,
                format!("a trial has at most {MAX_TICKS} ticks of the controllers, here {ticks:e}"),
                "Shorten the trial or lengthen the sample period.",
            ));
        }
        Ok(Self { ticks: ticks as usize, stride: stride as usize })
    }

    /// The number of sample periods in the schedule of a trial.
    pub fn ticks(&self) -> usize {
        self.ticks
    }

    /// The number of ticks between recorded rows of the schedule.
    pub fn stride(&self) -> usize {
        self.stride
    }

    /// The time of a recorded row of the schedule at this sample period (s), s.
    pub fn time(&self, row: usize, sample_period: f64) -> f64 {
        // Dividing by the rate gives 0.35 s at 1 kHz exactly as written.
        (row * self.stride) as f64 / (1.0 / sample_period)
    }

    /// The number of recorded rows in the schedule of a complete trial.
    pub fn rows(&self) -> usize {
        self.ticks / self.stride + 1
    }
}
