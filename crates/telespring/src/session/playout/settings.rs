//! When a sample is played.

#![cfg_attr(not(test), deny(clippy::indexing_slicing))]

use crate::error::{InvalidInput, Result};
use crate::session::Span;

/// The most samples that may have to wait: 17 minutes at 1 kHz.
pub const MAX_CAPACITY: i64 = 1 << 20;
/// Room for samples that come in bursts, or faster than agreed.
const SPARE: i64 = 64;

/// When a sample is played.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PlayoutSettings {
    /// A fixed time after its measurement.
    Fixed {
        /// This time.
        delay: Span,
    },
    /// As soon as the network allows.
    Adaptive(AdaptiveDelay),
}

/// A delay that follows the network: a quantile of the ages at which samples arrive, one sample period (the sample after
/// the played one must have come, too) and a margin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AdaptiveDelay {
    /// The share of the samples that should arrive in time, 0 to 1.
    pub quantile: f64,
    /// Added to the quantile.
    pub margin: Span,
    /// The delay is never below this …
    pub smallest: Span,
    /// … and never above this.
    pub largest: Span,
    /// The time over which ages are collected.
    pub window: Span,
    /// The share by which the motion may be played slower or faster while the delay changes, 0 to 0.9.
    pub slew: f64,
}

impl Default for AdaptiveDelay {
    /// 99 of 100 samples in time, 1 ms of margin, up to 0.5 s; 10 s are collected, and the speed changes by 10 %.
    fn default() -> Self {
        Self {
            quantile: 0.99,
            margin: Span(1_000_000),
            smallest: Span(0),
            largest: Span(500_000_000),
            window: Span(10_000_000_000),
            slew: 0.1,
        }
    }
}

/// The refusal of a span.
fn refuse(field: &str, span: Span, allowed: &str, remedy: &str) -> InvalidInput {
    InvalidInput::new(field, format!("{} s", span.seconds()), allowed, remedy)
}

impl PlayoutSettings {
    /// The number of samples that may wait, for samples this far apart.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if a value is out of range, or more than [`MAX_CAPACITY`] samples would have to wait.
    pub(crate) fn capacity(&self, sample_period: Span) -> Result<usize> {
        if sample_period < Span(1) {
            return Err(refuse(
                "sample_period",
                sample_period,
                "above 0",
                "Give the time between two samples.",
            ));
        }
        let (field, longest) = match *self {
            Self::Fixed { delay } => ("delay", delay),
            Self::Adaptive(adaptive) => {
                adaptive.check()?;
                // after a silence the play-out may lag this far behind
                ("largest", adaptive.largest + adaptive.largest)
            }
        };
        if longest < Span(0) {
            return Err(refuse(field, longest, "a delay is not negative", "Give 0 for no delay."));
        }
        let samples = (longest.0 / sample_period.0).saturating_add(SPARE);
        if samples > MAX_CAPACITY {
            return Err(refuse(
                field,
                longest,
                &format!("at most {MAX_CAPACITY} samples can wait, one every {} s", sample_period.seconds()),
                "Shorten the delay or lengthen the sample period.",
            ));
        }
        Ok(usize::try_from(samples).unwrap_or(0))
    }
}

impl AdaptiveDelay {
    /// Checks that every value is in range.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] for the first value that is not.
    pub fn check(&self) -> Result<()> {
        let Self { quantile, margin, smallest, largest, window, slew } = *self;
        if !(0.0..=1.0).contains(&quantile) {
            let remedy = "Give 0.99 for 99 of 100 samples.";
            return Err(InvalidInput::new("quantile", quantile, "a share from 0 to 1", remedy));
        }
        if !(slew > 0.0 && slew <= 0.9) {
            let remedy = "Give 0.1 to play at most 10 % slower or faster.";
            return Err(InvalidInput::new("slew", slew, "a share above 0, up to 0.9", remedy));
        }
        for (field, span) in [("margin", margin), ("smallest", smallest), ("window", window)] {
            if span < Span(0) {
                return Err(refuse(field, span, "not negative", "Give 0 or more."));
            }
        }
        if largest < smallest || largest < Span(1) {
            return Err(refuse(
                "largest",
                largest,
                "above 0 and at least the smallest delay",
                "Exchange them.",
            ));
        }
        Ok(())
    }
}
