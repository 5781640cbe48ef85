//! The target that this side has shown, for predictors that know it.

#![cfg_attr(not(test), deny(clippy::indexing_slicing))]

use std::collections::VecDeque;

use super::motion::Motion;
use super::predictor::SharedTargetView;
use super::time::LocalTime;

/// The targets shown so far, back to a fixed number of ticks.
#[derive(Debug, Clone)]
pub(super) struct Targets {
    /// In order of time; never more than `capacity`.
    shown: VecDeque<(LocalTime, Motion)>,
    capacity: usize,
}

impl Targets {
    pub(super) fn new(capacity: usize) -> Self {
        let capacity = capacity.max(2);
        Self { shown: VecDeque::with_capacity(capacity), capacity }
    }

    /// Notes the target shown from `now` on; `now` must not decrease from call to call.
    pub(super) fn show(&mut self, now: LocalTime, target: Motion) {
        if let Some(newest) = self.shown.back_mut().filter(|(time, _)| *time >= now) {
            newest.1 = target;
            return;
        }
        if self.shown.len() >= self.capacity {
            self.shown.pop_front();
        }
        self.shown.push_back((now, target));
    }

    /// The target at an earlier time, interpolated; the newest one at a later time, `None` if it is forgotten.
    fn at(&self, time: LocalTime) -> Option<Motion> {
        let after = self.shown.partition_point(|(shown, _)| *shown <= time);
        let (begin, earlier) = self.shown.get(after.checked_sub(1)?)?;
        let Some((end, later)) = self.shown.get(after) else { return Some(*earlier) };
        let share = (time - *begin).0 as f64 / (*end - *begin).0 as f64;
        Some(earlier.towards(later, share))
    }

    /// The newest target and the one at `then`.
    pub(super) fn view(&self, then: LocalTime) -> Option<SharedTargetView> {
        let (_, now) = *self.shown.back()?;
        Some(SharedTargetView { now, then: self.at(then)? })
    }
}
