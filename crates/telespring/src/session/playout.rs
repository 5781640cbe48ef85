//! The partner's motion, a fixed time after it was measured.
//!
//! Samples wait here, in the order in which the sender measured them, until they are due: at `now` the
//! buffer plays the motion of `now` − delay, interpolated linearly between the samples around it, so that
//! the delay need not be a whole number of samples. Where the later of the two has not come (it was lost
//! or is late), the earlier one is held. A sample that comes after its turn is dropped.

use std::collections::VecDeque;

use super::Nanoseconds;
use super::wire::Motion;

/// The most samples that wait at a time: at 1 kHz somewhat more than the longest delay of 100 s. Where
/// more come, the oldest go.
pub const CAPACITY: usize = 1 << 17;

#[derive(Debug, Clone, Copy)]
struct Sample {
    time: Nanoseconds,
    motion: Motion,
}

/// The buffer.
#[derive(Debug, Clone)]
pub struct Playout {
    delay: Nanoseconds,
    /// In order of their times, each time once.
    samples: VecDeque<Sample>,
}

impl Playout {
    /// An empty buffer that plays every motion `delay` after it was measured.
    pub fn new(delay: Nanoseconds) -> Self {
        Self { delay, samples: VecDeque::with_capacity(16) }
    }

    /// From a motion's measurement until it is played.
    pub fn delay(&self) -> Nanoseconds {
        self.delay
    }

    /// How many samples are kept.
    pub fn len(&self) -> usize {
        self.samples.len()
    }

    /// True before the first sample.
    pub fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }

    /// Takes in the motion that the partner measured at `time`; of several with the same time, the first
    /// counts. Samples that will not be played again, seen from `now`, are forgotten.
    ///
    /// `now` may not go back from call to call.
    pub fn insert(&mut self, now: Nanoseconds, time: Nanoseconds, motion: Motion) {
        let after = match self.samples.back() {
            Some(newest) if newest.time >= time => self.samples.partition_point(|sample| sample.time < time),
            _ => self.samples.len(),
        };
        if self.samples.get(after).is_none_or(|sample| sample.time != time) {
            self.samples.insert(after, Sample { time, motion });
        }
        if let Some(played) = now.before(self.delay) {
            while self.samples.get(1).is_some_and(|next| next.time <= played) {
                self.samples.pop_front();
            }
        }
        if self.samples.len() > CAPACITY {
            self.samples.pop_front();
        }
    }

    /// The partner's motion of `now` − delay, or `None` before the first sample is due.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::session::{Motion, Nanoseconds, Playout};
    ///
    /// let at = |x| Motion { position: [x, 0.0], velocity: [0.0; 2] };
    /// let mut playout = Playout::new(Nanoseconds(1_500));
    /// playout.insert(Nanoseconds(0), Nanoseconds(0), at(1.0));
    /// playout.insert(Nanoseconds(0), Nanoseconds(1_000), at(3.0));
    /// assert_eq!(playout.motion(Nanoseconds(1_499)), None);
    /// assert_eq!(playout.motion(Nanoseconds(2_000)), Some(at(2.0)));
    /// assert_eq!(playout.motion(Nanoseconds(9_000)), Some(at(3.0)));
    /// ```
    pub fn motion(&self, now: Nanoseconds) -> Option<Motion> {
        let played = now.before(self.delay)?;
        let after = self.samples.partition_point(|sample| sample.time <= played);
        let earlier = self.samples.get(after.checked_sub(1)?)?;
        let Some(later) = self.samples.get(after) else { return Some(earlier.motion) };
        let share = (played.0 - earlier.time.0) as f64 / (later.time.0 - earlier.time.0) as f64;
        let between =
            |from: [f64; 2], to: [f64; 2]| [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]));
        Some(Motion {
            position: between(earlier.motion.position, later.motion.position),
            velocity: between(earlier.motion.velocity, later.motion.velocity),
        })
    }
}
