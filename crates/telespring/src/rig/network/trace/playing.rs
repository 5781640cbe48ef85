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
    /// The smallest and the largest age of any sample in use, s, wherever the ticks fall between the recorded packets.
    pub extremes: [f64; 2],
    /// The ages of the newest and the oldest sample in use, s, at the ticks at which the motion was not exactly as old
    /// as the play-out's delay. They differ where samples between the two that are interpolated are missing.
    pub late: Vec<[f64; 2]>,
}

impl PlayedTrace {
    /// The share of the ticks at which the motion played over the network was exactly as old as the delay.
    pub fn in_time(&self) -> f64 {
        1.0 - self.late.len() as f64 / self.ticks as f64
    }

    /// The smallest and the largest age of any sample in use over the network's trace, s, wherever the ticks fall between
    /// the recorded packets.
    pub fn ages(&self) -> [f64; 2] {
        self.extremes
    }

    /// The smallest and the largest age at the ticks that were played over the network's trace, s.
    fn ages_played(&self) -> [f64; 2] {
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
    /// Plays a session over the network's trace, which is repeated in a circle: a packet and a tick every `sample_period`,
    /// once round, behind the play-out that an [`Endpoint`](crate::session::Endpoint) has.
    ///
    /// A packet has the delay and the fate of the recorded packet that was sent last before it, as [`Trace::at`] says. The
    /// session has run before the first tick that counts for so long that every motion in use was sent on the
    /// circle: what was lost at the start and what came after the end of the recording count. Where packets were not
    /// recorded whole periods apart, the extremes of the ages hold wherever the ticks fall between them.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if the delay is not from 0 to 100 s, the period is not above 0, there would be more than 10⁸ ticks,
    /// more samples would have to wait than a play-out takes, or packets were recorded closer than a period and those
    /// that a session would send are lost.
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
        let is_on_grid = self.is_on_grid(period);
        // Where the ticks may fall elsewhere, the sure arrivals are rarer than the packets that came.
        let silence = if is_on_grid { self.longest_silence() } else { 2.0 * self.duration };
        let before = (silence + self.longest_delay() + delay) / period.seconds();
        let round = self.duration / period.seconds();
        if before + round > MOST_TICKS {
            return Err(InvalidInput::new(
                "sample_period",
                format!("{sample_period:?}"),
                format!("a trace of {} s has more than {MOST_TICKS:e} of them", self.duration),
                "Give a longer one, or a part of the trace.",
            ));
        }
        let ticks = Ticks { before: before.ceil() as u64 + 2, round: (round - 1e-6).ceil() as u64, period };
        let extremes = [f64::NAN; 2];
        let mut played =
            PlayedTrace { delay, sample_period, ticks: 0, held_ticks: 0, extremes, late: Vec::new() };
        self.play_once(ticks, &mut played)?;
        played.extremes = if is_on_grid { played.ages_played() } else { self.ages_anywhere(ticks, delay)? };
        Ok(played)
    }

    /// Plays once round the network's trace, a tick at the first recorded packet.
    fn play_once(&self, ticks: Ticks, played: &mut PlayedTrace) -> Result<()> {
        let Ticks { before, round, period } = ticks;
        let wanted = Span::from_seconds(played.delay);
        let mut playout = Playout::new(PlayoutSettings::Fixed { delay: wanted }, period)?;
        let mut travelling = BinaryHeap::new();
        let tick_time = |tick: u64| LocalTime(tick * period.0.cast_unsigned());
        let start = self.start(ticks);
        for tick in 0..before + round {
            let now = tick_time(tick);
            let row = self.at(now + start);
            if !row.lost {
                travelling.push(Reverse((now + Span::from_seconds(row.delay), tick)));
            }
            while let Some(Reverse((arrival, sequence))) = travelling.peek().copied()
                && arrival <= now
            {
                travelling.pop();
                let time = tick_time(sequence).seen_by_peer();
                let motion = Motion::default();
                playout.insert(now.seen_by_peer(), Sample { sequence, time, motion, signal: [0.0; 2] });
            }
            let playing = playout.play(now.seen_by_peer());
            if tick < before {
                continue;
            }
            let playing = playing.ok_or_else(|| too_close(period))?;
            played.ticks += 1;
            played.held_ticks += usize::from(playing.held);
            if playing.ages != (wanted, wanted) {
                // divided, so that 90 ms read 0.09
                let seconds = |span: Span| span.0 as f64 / 1e9;
                played.late.push([seconds(playing.ages.0), seconds(playing.ages.1)]);
            }
        }
        Ok(())
    }

    /// The longest delay of a packet that came over the network, s.
    fn longest_delay(&self) -> f64 {
        self.rows.iter().filter(|row| !row.lost).map(|row| row.delay).fold(0.0, f64::max)
    }

    /// The longest time on the circle of the network's trace from one packet that came to the sending of the next one, s.
    fn longest_silence(&self) -> f64 {
        let mut came = self.rows.iter().filter(|row| !row.lost).map(|row| row.time);
        let first = came.next().unwrap_or(0.0);
        let (last, longest) =
            came.fold((first, 0.0_f64), |(before, longest), time| (time, longest.max(time - before)));
        longest.max(first + self.duration - last)
    }

    /// Whether all packets of the network's trace were sent whole periods apart: then it does not matter where between
    /// them the ticks of a session fall.
    fn is_on_grid(&self, period: Span) -> bool {
        let is_whole = |time: f64| Span::from_seconds(time).0 % period.0 == 0;
        self.rows.iter().all(|row| is_whole(row.time)) && is_whole(self.duration)
    }

    /// Where on the circle of the network's trace a session starts whose first tick that counts is at the first packet.
    pub(super) fn start(&self, Ticks { before, period, .. }: Ticks) -> Span {
        let circle = LocalTime::from_seconds(self.duration).0.max(1);
        Span((circle - before * period.0.cast_unsigned() % circle).cast_signed())
    }
}

/// The refusal of a trace of a network whose packets are too close together for a session's period.
pub(super) fn too_close(period: Span) -> InvalidInput {
    InvalidInput::new(
        "sample_period",
        format!("{:?}", period.seconds()),
        "packets were recorded closer together than it, and those that a session would send may all be lost",
        "Give a period as short as the time between two recorded packets.",
    )
}

/// The ticks of a session over a network's trace: those before the first that counts, those of one round, and the time
/// between two.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ticks {
    pub(super) before: u64,
    pub(super) round: u64,
    pub(super) period: Span,
}
