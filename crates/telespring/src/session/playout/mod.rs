//! The play-out: the partner's motion, a chosen time after its measurement.
//!
//! Samples wait in the order of their measurement until they are due. At a tick the play-out plays the motion of
//! now − delay, interpolated linearly between the samples around it, so the delay need not be a multiple of the sample
//! period. If the later sample is missing (lost or late), the earlier one is held. A late sample is taken up while it is
//! still needed, and dropped once a later one is in use. The played instant never goes backwards.
//!
//! The delay is fixed, or follows the network ([`AdaptiveDelay`]). An adaptive play-out changes its delay by playing a
//! little slower or faster, and after a silence it goes on from the held motion: the played instant moves by no more
//! than (1 + slew) times the time that passed, so a change of the delay never makes the force jump. A fixed one returns
//! to its delay at once.
//!
//! All times are of the partner's clock; [`Clock`](super::Clock) turns the own time into it.

#![cfg_attr(not(test), deny(clippy::indexing_slicing))]

mod adaptation;
mod histogram;
mod report;
mod sequences;
mod settings;

pub use histogram::Histogram;
pub use report::{Ages, PlayoutCounts, PlayoutReport};
pub use settings::{AdaptiveDelay, MAX_CAPACITY, PlayoutSettings};

use std::collections::VecDeque;

use super::motion::{Motion, between};
use super::time::{PeerTime, Span};
use super::wire::Packet;
use adaptation::Adaptation;
use report::Counts;

/// What one packet brings to the play-out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// The sequence number.
    pub sequence: u64,
    /// When the partner measured it.
    pub time: PeerTime,
    /// The motion.
    pub motion: Motion,
    /// The strategy's own quantity per axis.
    pub signal: [f64; 2],
}

impl From<&Packet> for Sample {
    fn from(packet: &Packet) -> Self {
        let Packet { sequence, sent: time, motion, signal, .. } = *packet;
        Self { sequence, time, motion, signal }
    }
}

/// What the play-out plays at one tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Playing {
    /// The motion.
    pub motion: Motion,
    /// The strategy's own quantity per axis, of the same instant.
    pub signal: [f64; 2],
    /// The played instant.
    pub time: PeerTime,
    /// How long ago that is.
    pub age: Span,
    /// Whether an older motion is held because no later sample has come.
    pub held: bool,
    /// Whether the played instant is later than at the previous tick.
    pub fresh: bool,
    /// The ages of the newest and of the oldest sample in it: those of the samples around a gap, else `age` twice.
    pub ages: (Span, Span),
}

/// How the played instant follows the time.
#[derive(Debug, Clone)]
enum Pace {
    Fixed(Span),
    Adaptive(Box<Adaptation>),
}

/// The play-out of one side.
#[derive(Debug, Clone)]
pub struct Playout {
    pace: Pace,
    /// Samples in order of their times, without repetitions; never more than `capacity`.
    samples: VecDeque<Sample>,
    capacity: usize,
    played: Option<Played>,
    counts: Counts,
}

/// The last tick.
#[derive(Debug, Clone, Copy)]
struct Played {
    /// When it was.
    at: PeerTime,
    /// The instant that was due.
    instant: PeerTime,
    /// The instant that was played: earlier if the motion was held.
    shown: PeerTime,
    /// The age of the oldest sample in it, when it was played.
    oldest: Span,
}

impl Playout {
    /// An empty play-out for samples that are `sample_period` apart. It allocates all that it ever needs.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`](crate::InvalidInput) if a value is out of range, or more than [`MAX_CAPACITY`] samples would have
    /// to wait.
    pub fn new(settings: PlayoutSettings, sample_period: Span) -> crate::error::Result<Self> {
        let capacity = settings.capacity(sample_period)?;
        let pace = match settings {
            PlayoutSettings::Fixed { delay } => Pace::Fixed(delay),
            PlayoutSettings::Adaptive(adaptive) => {
                Pace::Adaptive(Box::new(Adaptation::new(adaptive, sample_period)))
            }
        };
        let samples = VecDeque::with_capacity(capacity);
        Ok(Self { pace, samples, capacity, played: None, counts: Counts::new() })
    }

    /// The time from the measurement of a motion to its use that the play-out strives for.
    pub fn delay(&self) -> Span {
        match &self.pace {
            Pace::Fixed(delay) => *delay,
            Pace::Adaptive(adaptation) => adaptation.delay(),
        }
    }

    /// The number of waiting samples, the one in use included.
    pub fn len(&self) -> usize {
        self.samples.len()
    }

    /// True before the first sample has come.
    pub fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }

    /// The most samples that can wait.
    pub fn capacity(&self) -> usize {
        self.capacity
    }

    /// The instant that is played, or held, at `now`: before the first tick the wanted one.
    fn due(&self, now: PeerTime) -> Option<PeerTime> {
        let wanted = now.checked_sub(self.delay());
        let Some(before) = self.played else { return wanted };
        let wanted = wanted.unwrap_or_default();
        let due = match &self.pace {
            Pace::Fixed(_) => wanted,
            Pace::Adaptive(adaptation) => {
                let elapsed = (now - before.at).max(Span(0));
                let change = elapsed.scaled(adaptation.settings().slew);
                let largest = adaptation.settings().largest;
                wanted
                    .clamp(before.instant + (elapsed - change), before.instant + (elapsed + change))
                    .max(now - (largest + largest))
            }
        };
        Some(due.max(before.instant))
    }

    /// Takes a sample that arrived at `now`; of several with the same time or number, the first is kept.
    ///
    /// `now` must not decrease from call to call.
    pub fn insert(&mut self, now: PeerTime, sample: Sample) {
        if !self.counts.sequences.note(sample.sequence) {
            self.counts.repeated = self.counts.repeated.saturating_add(1);
            return;
        }
        self.counts.received = self.counts.received.saturating_add(1);
        if let Pace::Adaptive(adaptation) = &mut self.pace {
            adaptation.add(now - sample.time);
        }
        if self.played.is_some() && self.due(now).is_some_and(|due| sample.time < due) {
            self.counts.late = self.counts.late.saturating_add(1);
        }
        // what certainly has been played: an adaptive delay may still change before the next tick
        let played = match self.pace {
            Pace::Fixed(_) => self.due(now),
            Pace::Adaptive(_) => self.played.map(|before| before.instant),
        };
        if let Some(played) = played {
            self.drop_before(played);
            let in_use = self.samples.front().filter(|first| first.time <= played);
            if in_use.is_some_and(|in_use| sample.time < in_use.time) {
                self.counts.overtaken = self.counts.overtaken.saturating_add(1);
                return;
            }
        }
        let after = match self.samples.back() {
            Some(newest) if newest.time >= sample.time => {
                self.samples.partition_point(|waiting| waiting.time < sample.time)
            }
            _ => self.samples.len(),
        };
        if self.samples.get(after).is_some_and(|waiting| waiting.time == sample.time) {
            return;
        }
        if self.samples.len() >= self.capacity {
            self.counts.crowded_out = self.counts.crowded_out.saturating_add(1);
            if after == self.samples.len() {
                return;
            }
            self.samples.pop_back();
        }
        self.samples.insert(after.min(self.samples.len()), sample);
    }

    /// Drops the samples before the one in use at `due`.
    fn drop_before(&mut self, due: PeerTime) {
        while self.samples.get(1).is_some_and(|next| next.time <= due) {
            self.samples.pop_front();
        }
    }

    /// The partner's motion at `now`, or `None` before the first sample is due.
    ///
    /// `now` must not decrease from call to call. What is played does not count as used before [`Playout::count`].
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::session::playout::{Playout, PlayoutSettings, Sample};
    /// use telespring::session::{Motion, PeerTime, Span};
    ///
    /// let settings = PlayoutSettings::Fixed { delay: Span(1_500) };
    /// let mut playout = Playout::new(settings, Span(1_000))?;
    /// for (sequence, x) in [(0, 1.0), (1, 3.0)] {
    ///     let motion = Motion { position: [x, 0.0], velocity: [0.0; 2] };
    ///     let time = PeerTime(sequence * 1_000);
    ///     playout.insert(PeerTime(0), Sample { sequence, time, motion, signal: [0.0; 2] });
    /// }
    /// let mut x = |now| playout.play(PeerTime(now)).map(|playing| playing.motion.position[0]);
    /// assert_eq!(x(1_499), None);
    /// assert_eq!(x(2_000), Some(2.0));
    /// assert_eq!(x(9_000), Some(3.0));
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn play(&mut self, now: PeerTime) -> Option<Playing> {
        let due = self.due(now)?;
        self.drop_before(due);
        let earlier = *self.samples.front().filter(|sample| sample.time <= due)?;
        let later = self.samples.get(1);
        let mut playing = Playing {
            motion: earlier.motion,
            signal: earlier.signal,
            time: earlier.time,
            age: now - earlier.time,
            held: later.is_none() && due > earlier.time,
            fresh: false,
            ages: (now - earlier.time, now - earlier.time),
        };
        if let Some(later) = later {
            let share = (due - earlier.time).0 as f64 / (later.time - earlier.time).0 as f64;
            playing.motion = earlier.motion.towards(&later.motion, share);
            playing.signal = between(earlier.signal, later.signal, share);
            (playing.time, playing.age) = (due, now - due);
            let adjacent = later.sequence.checked_sub(earlier.sequence) == Some(1) || share == 0.0;
            playing.ages =
                if adjacent { (playing.age, playing.age) } else { (now - later.time, now - earlier.time) };
        }
        playing.fresh = self.played.is_none_or(|before| playing.time > before.shown);
        // a fixed delay is returned to at once, an adaptive one from where the motion stood still
        let instant = if let Pace::Fixed(_) = self.pace { due } else { playing.time };
        self.played = Some(Played { at: now, instant, shown: playing.time, oldest: playing.ages.1 });
        Some(playing)
    }

    /// The age, when it was played, of the oldest sample in the motion that was played last; `None` before the first.
    pub fn oldest_played(&self) -> Option<Span> {
        self.played.map(|before| before.oldest)
    }

    /// Counts what was played as used.
    pub fn count(&mut self, playing: &Playing) {
        self.counts.tick(playing.age, playing.ages, playing.held);
    }

    /// Goes on to the wanted delay at once, at `now`: while no force acts, a jump does no harm. The played instant does
    /// not go back even then.
    pub fn settle(&mut self, now: PeerTime) {
        let wanted = now.checked_sub(self.delay()).unwrap_or_default();
        if let Some(before) = &mut self.played {
            before.instant = before.instant.max(wanted);
            before.at = before.at.max(now);
        }
    }

    /// Forgets all samples and what was learnt of the network, after the partner has restarted; the counts stay.
    pub fn forget(&mut self) {
        self.samples.clear();
        self.played = None;
        self.counts.restart();
        if let Pace::Adaptive(adaptation) = &mut self.pace {
            adaptation.forget();
        }
    }

    /// The counts of the report, which cost little.
    pub fn counts(&self) -> PlayoutCounts {
        self.counts.so_far()
    }

    /// What the play-out has done so far.
    pub fn report(&self) -> PlayoutReport {
        self.counts.report(self.delay())
    }
}
