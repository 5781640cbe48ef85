//! The delay that a play-out should have: a quantile of the ages at which samples arrive, plus a margin.

#![cfg_attr(not(test), deny(clippy::indexing_slicing))]

use std::collections::VecDeque;

use super::histogram::Histogram;
use super::settings::AdaptiveDelay;
use crate::session::Span;

/// The delay is computed anew after this many samples.
const INTERVAL: u64 = 32;

/// The ages at which the last samples arrived, and the delay that follows from them.
#[derive(Debug, Clone)]
pub(super) struct Adaptation {
    settings: AdaptiveDelay,
    sample_period: Span,
    /// The last ages, oldest first; never more than `capacity`.
    recent: VecDeque<Span>,
    capacity: usize,
    ages: Histogram,
    since_computed: u64,
    delay: Span,
}

impl Adaptation {
    pub(super) fn new(settings: AdaptiveDelay, sample_period: Span) -> Self {
        let samples = settings.window.0 / sample_period.0.max(1);
        let capacity = usize::try_from(samples.clamp(16, 1 << 16)).unwrap_or(16);
        Self {
            settings,
            sample_period,
            recent: VecDeque::with_capacity(capacity),
            capacity,
            ages: Histogram::new(),
            since_computed: 0,
            delay: settings.largest,
        }
    }

    pub(super) fn settings(&self) -> &AdaptiveDelay {
        &self.settings
    }

    /// Takes the age at which a sample arrived.
    pub(super) fn add(&mut self, age: Span) {
        if self.recent.len() >= self.capacity
            && let Some(oldest) = self.recent.pop_front()
        {
            self.ages.remove(oldest);
        }
        self.recent.push_back(age);
        self.ages.add(age);
        self.since_computed = self.since_computed.saturating_add(1);
        if self.since_computed >= INTERVAL || self.ages.len() <= INTERVAL {
            self.since_computed = 0;
            if let Some(age) = self.ages.quantile(self.settings.quantile) {
                // the sample after the played one must have come, too
                let wanted = age + self.sample_period + self.settings.margin;
                self.delay = wanted.clamp(self.settings.smallest, self.settings.largest);
            }
        }
    }

    /// The delay to strive for; the largest before the first sample.
    pub(super) fn delay(&self) -> Span {
        self.delay
    }

    pub(super) fn forget(&mut self) {
        self.recent.clear();
        self.ages.clear();
        (self.since_computed, self.delay) = (0, self.settings.largest);
    }
}
