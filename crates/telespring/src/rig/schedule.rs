//! Which ticks of a trial are run and kept.

use crate::error::{InvalidInput, Result};
use crate::quantity;

/// The most ticks of one trial.
pub const MAX_TICKS: usize = 100_000_000;

/// Which ticks are run and which are kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Schedule {
    ticks: usize,
    stride: usize,
}

impl Schedule {
    /// For a trial of `duration` s from which `record_rate` rows a second are kept.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] where a value is out of range, the record rate does not divide the controllers'
    /// rate, or there would be more than [`MAX_TICKS`].
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
                format!("Write {}, or another such part of it.", 1.0 / (sample_period * stride.max(1.0))),
            ));
        }
        // 0.29 s at 1 kHz has 290 ticks, though the quotient rounds to 289.999…
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

    /// How many periods are run.
    pub fn ticks(&self) -> usize {
        self.ticks
    }

    /// Every how many ticks a row is kept, from tick 0 on.
    pub fn stride(&self) -> usize {
        self.stride
    }

    /// When row `row` is kept at this sample period (s), s.
    pub fn time(&self, row: usize, sample_period: f64) -> f64 {
        // a division by the rate gives 0.35 s at 1 kHz as it is written
        (row * self.stride) as f64 / (1.0 / sample_period)
    }

    /// How many rows are kept of a complete trial.
    pub fn rows(&self) -> usize {
        self.ticks / self.stride + 1
    }
}
