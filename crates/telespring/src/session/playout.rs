//! The playout buffer: the partner's motion, a fixed time after its measurement.
//!
//! Samples wait in the order of their measurement until they are due. At `now` the buffer plays the motion
//! of `now` − delay, interpolated linearly between the samples around it, so the delay need not be a
//! multiple of the sample period. If the later sample is missing (lost or late), the earlier one is held. A
//! sample that arrives too late is dropped.

use std::collections::VecDeque;

use super::Nanoseconds;
use super::motion::Motion;

/// The maximum number of waiting samples: at 1 kHz slightly more than the longest delay of 100 s. Beyond it
/// the oldest are dropped.
pub const CAPACITY: usize = 1 << 17;

#[derive(Debug, Clone, Copy)]
struct Sample {
    time: Nanoseconds,
    motion: Motion,
}

/// The playout buffer of one side.
#[derive(Debug, Clone)]
pub struct Playout {
    delay: Nanoseconds,
    /// Samples in order of their times, without duplicates.
    samples: VecDeque<Sample>,
}

impl Playout {
    /// An empty buffer that plays every motion `delay` after its measurement.
    pub fn new(delay: Nanoseconds) -> Self {
        Self { delay, samples: VecDeque::with_capacity(16) }
    }

    /// The time from the measurement of a motion to its use.
    pub fn delay(&self) -> Nanoseconds {
        self.delay
    }

    /// The number of samples in the playout buffer.
    pub fn len(&self) -> usize {
        self.samples.len()
    }

    /// True before the first sample has arrived.
    pub fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }

    /// Inserts the motion that the partner measured at `time`; of several with the same time, the first is
    /// kept. Samples no longer needed at `now` are dropped.
    ///
    /// `now` must not decrease from call to call.
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
