//! A recorded trace of a network as a fixed play-out plays it.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::Trace;
use crate::error::{InvalidInput, Result};
use crate::session::playout::{Playout, PlayoutSettings, Sample};
use crate::session::{LocalTime, Motion, Span};

/// The most ticks that are played.
const MOST_TICKS: f64 = 1e8;

/// The ages of the motion that a fixed play-out uses over a network's trace.
#[derive(Debug, Clone, PartialEq)]
pub struct PlayedTrace {
    /// The delay of the play-out, s.
    pub delay: f64,
    /// The time between two packets, and between two ticks, s.
    pub sample_period: f64,
    /// The ticks at which a motion was used.
    pub ticks: usize,
    /// Of these, the ticks at which an old motion was held because no later sample had come.
    pub held_ticks: usize,
    /// The ages of the newest and the oldest sample in use, s, at the ticks at which the motion was not exactly as old
    /// as the play-out's delay. They differ where samples between the two that are interpolated are missing.
    pub late: Vec<[f64; 2]>,
}

impl PlayedTrace {
    /// The share of the ticks at which the motion played over the network was exactly as old as the delay.
    pub fn in_time(&self) -> f64 {
        1.0 - self.late.len() as f64 / self.ticks as f64
    }

    /// The smallest and the largest age of any sample in use over the network's trace, s.
    pub fn ages(&self) -> [f64; 2] {
        let own = if self.late.len() < self.ticks {
            [self.delay, self.delay]
        } else {
            [f64::INFINITY, f64::NEG_INFINITY]
        };
        self.late.iter().fold(own, |[low, high], [newest, oldest]| [low.min(*newest), high.max(*oldest)])
    }

    /// The share of the ticks at which all ages over the network's trace were in a range, s.
    pub fn share_within(&self, low: f64, high: f64) -> f64 {
        let is_within = |newest: f64, oldest: f64| low <= newest && oldest <= high;
        let late = self.late.iter().filter(|ages| is_within(ages[0], ages[1])).count();
        let punctual = if is_within(self.delay, self.delay) { self.ticks - self.late.len() } else { 0 };
        (late + punctual) as f64 / self.ticks as f64
    }
}

impl Trace {
    /// Plays a session over the network's trace: a packet and a tick every `sample_period`, from the first recorded
    /// packet to the end, behind the play-out that an [`Endpoint`](crate::session::Endpoint) has.
    ///
    /// A packet has the delay and the fate of the recorded packet that was sent last before it, as [`Trace::at`] says.
    /// Nothing is counted before the first sample is due and there.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if the delay is not from 0 to 100 s, the period is not above 0, the trace has more than 10⁸ ticks or
    /// ends before anything is played, or more samples would have to wait than a play-out takes.
    ///
    /// # Examples
    ///
    /// Every packet takes 20 ms. Played after 25 ms all are in time, after 10 ms all are 10 ms late:
    ///
    /// ```
    /// use telespring::rig::{Trace, TraceRow};
    ///
    /// let row = |n| TraceRow { time: 0.01 * f64::from(n), delay: 0.02, lost: false };
    /// let trace = Trace::new((0..100).map(row).collect())?;
    /// let played = trace.play(0.025, 0.001)?;
    /// assert_eq!((played.in_time(), played.ages()), (1.0, [0.025, 0.025]));
    /// assert_eq!(trace.play(0.01, 0.001)?.ages(), [0.02, 0.02]);
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn play(&self, delay: f64, sample_period: f64) -> Result<PlayedTrace> {
        crate::quantity::DELAY.check("delay", delay)?;
        let period = Span::from_seconds(sample_period);
        if !(sample_period.is_finite() && period > Span(0)) {
            return Err(InvalidInput::new(
                "sample_period",
                format!("{sample_period:?}"),
                "it is a time above 0, in s",
                "Give the time between two packets.",
            ));
        }
        let ticks = self.duration / period.seconds();
        if ticks > MOST_TICKS {
            return Err(InvalidInput::new(
                "sample_period",
                format!("{sample_period:?}"),
                format!("a trace of {} s has more than {MOST_TICKS:e} of them", self.duration),
                "Give a longer one, or a part of the trace.",
            ));
        }
        let wanted = Span::from_seconds(delay);
        let mut playout = Playout::new(PlayoutSettings::Fixed { delay: wanted }, period)?;
        let mut played = PlayedTrace { delay, sample_period, ticks: 0, held_ticks: 0, late: Vec::new() };
        let mut travelling = BinaryHeap::new();
        for tick in 0..(ticks - 1e-6).ceil() as u64 {
            let now = LocalTime(tick * period.0.cast_unsigned());
            let row = self.at(now);
            if !row.lost {
                travelling.push(Reverse((now + Span::from_seconds(row.delay), tick)));
            }
            while let Some(Reverse((arrival, sequence))) = travelling.peek().copied()
                && arrival <= now
            {
                travelling.pop();
                let time = LocalTime(sequence * period.0.cast_unsigned()).seen_by_peer();
                let motion = Motion::default();
                playout.insert(now.seen_by_peer(), Sample { sequence, time, motion, signal: [0.0; 2] });
            }
            let Some(playing) = playout.play(now.seen_by_peer()) else { continue };
            played.ticks += 1;
            played.held_ticks += usize::from(playing.held);
            if playing.ages != (wanted, wanted) {
                // divided, so that 90 ms read 0.09
                let seconds = |span: Span| span.0 as f64 / 1e9;
                played.late.push([seconds(playing.ages.0), seconds(playing.ages.1)]);
            }
        }
        if played.ticks == 0 {
            return Err(InvalidInput::new(
                "trace",
                format!("{} s long", self.duration),
                format!("nothing of it is played with a delay of {delay} s: it ends before"),
                "Record for longer.",
            ));
        }
        Ok(played)
    }
}
