//! Recorded traces of a network: what happened to each packet that somebody sent.

mod anywhere;
mod fit;
mod ping;
mod playing;
mod reading;
pub(super) mod special;
mod statistics;

pub use fit::{BurstFit, JitterFit, TraceFit};
pub use playing::PlayedTrace;
pub(crate) use reading::names_round_trips;
pub use reading::{IrttDelay, TimeUnit, TraceFormat, TraceUnits};
pub use statistics::TraceStatistics;

use crate::error::{InvalidInput, Result};
use crate::quantity;
use crate::session::LocalTime;

/// The most packets that a trace is completed to.
const MOST_ROWS: f64 = 1e7;

/// One recorded packet of a network.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TraceRow {
    /// When it was sent, s.
    pub time: f64,
    /// How long it took, s; 0 if it was lost.
    pub delay: f64,
    /// Whether it never came.
    pub lost: bool,
}

/// A recorded trace of a network: at least two packets in the order of sending, the first at 0 s, of which at least one
/// came.
///
/// # Examples
///
/// ```
/// use telespring::rig::{Trace, trace::TraceUnits};
///
/// let text = "time_s,delay_ms,lost\n0.00,24.5,0\n0.02,,1\n0.04,26.0,0\n";
/// let trace = Trace::from_csv(text, TraceUnits::default())?;
/// assert_eq!(trace.rows()[2].delay, 0.026);
/// assert!((trace.statistics().loss - 1.0 / 3.0).abs() < 1e-15);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    rows: Vec<TraceRow>,
    /// From the first packet to the end, s: to the last packet and a median interval more.
    duration: f64,
    /// Whether a lost packet has a row.
    has_losses_recorded: bool,
}

impl Trace {
    /// Checks the packets of a recorded network.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] with the row, counted from 1, if a time is not finite or before its predecessor, a delay is
    /// negative or above 100 s, or the packets are fewer than two, were sent all at once, or never came.
    pub fn new(mut rows: Vec<TraceRow>) -> Result<Self> {
        for (index, row) in rows.iter_mut().enumerate() {
            let field = |name: &str| format!("trace row {}, {name}", index + 1);
            if !row.time.is_finite() {
                return Err(InvalidInput::new(
                    field("time"),
                    row.time,
                    "a time must be a finite number",
                    "Remove the row, or give the time at which the packet was sent.",
                ));
            }
            if row.lost {
                row.delay = 0.0;
                continue;
            }
            quantity::DELAY.check(&field("delay"), row.delay).map_err(|refusal| {
                let remedy = if row.delay < 0.0 {
                    "The two clocks differ: record round trips, and take half of each (--round-trip, or round_trip = true \
                     in a study)."
                } else {
                    "If the delays are in another unit, name the column by it, such as delay_ms."
                };
                InvalidInput { remedy: remedy.to_owned(), ..refusal }
            })?;
        }
        if let Some(index) = rows.windows(2).position(|pair| pair[1].time < pair[0].time) {
            return Err(InvalidInput::new(
                format!("trace row {}, time", index + 2),
                format!("{:?}", rows[index + 1].time),
                format!(
                    "rows are in the order of sending, and the row before was sent at {:?} s",
                    rows[index].time
                ),
                "Sort the rows by the time of sending.",
            ));
        }
        if rows.len() < 2 || rows.iter().all(|row| row.lost) {
            return Err(InvalidInput::new(
                "trace",
                format!("{} packet(s), {} lost", rows.len(), rows.iter().filter(|row| row.lost).count()),
                "a trace has at least two packets, of which at least one came",
                "Record for longer.",
            ));
        }
        let start = rows[0].time;
        rows.iter_mut().for_each(|row| row.time -= start);
        let last = rows[rows.len() - 1].time;
        let duration = last + statistics::median_interval(&rows);
        if !(last > 0.0) {
            return Err(InvalidInput::new(
                "trace",
                "all packets at one time",
                "the times are those of sending and increase",
                "Give the times at a finer resolution.",
            ));
        }
        let has_losses_recorded = rows.iter().any(|row| row.lost);
        Ok(Self { rows, duration, has_losses_recorded })
    }

    /// The network's trace of somebody who recorded what was lost, even if nothing was: a step between two rows is then the
    /// sender's.
    #[must_use]
    pub fn with_losses_recorded(self) -> Self {
        Self { has_losses_recorded: true, ..self }
    }

    /// Whether a packet that the network lost has a row: one has, or the recording has a place for it. If not, lost
    /// packets may be [missing rows](Trace::with_missing_rows).
    pub fn has_losses_recorded(&self) -> bool {
        self.has_losses_recorded
    }

    /// The packets of the network's trace.
    pub fn rows(&self) -> &[TraceRow] {
        &self.rows
    }

    /// How long the network's trace is before it begins again, s: to the last packet, and a median interval more.
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// What happens to a packet sent at this time, where the trial starts at 0, if the network's trace is played in a
    /// circle: what happened to the recorded packet that was sent last before it.
    pub fn at(&self, time: LocalTime) -> TraceRow {
        // in whole ns, so that a packet sent with a recorded one meets the same
        let within = time.0 % LocalTime::from_seconds(self.duration).0.max(1);
        let after = self.rows.partition_point(|row| LocalTime::from_seconds(row.time).0 <= within);
        self.rows[after.saturating_sub(1)]
    }

    /// The network's trace with half of each delay: one way of a recorded round trip, if both ways take equally long.
    #[must_use]
    pub fn halved(mut self) -> Self {
        self.rows.iter_mut().for_each(|row| row.delay *= 0.5);
        self
    }

    /// The trace of a network to which a packet was sent every `period` s, where the rows of lost packets are missing.
    ///
    /// A step between two rows of more than 1.5 periods, up to `longest` s, gets a row for each packet that is missing;
    /// a longer one is a pause of the sender and is closed to one period. Without sequence numbers nothing
    /// tells the two apart: the choice of `longest` is yours.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if a value is not above 0, or there would be more than ten million rows.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::rig::{Trace, TraceRow};
    ///
    /// let row = |time| TraceRow { time, delay: 0.02, lost: false };
    /// let trace = Trace::new([0.0, 0.01, 0.04, 9.04].map(row).to_vec())?.with_missing_rows(0.01, 1.0)?;
    /// let sent: Vec<_> = trace.rows().iter().map(|row| ((row.time * 1e3).round(), row.lost)).collect();
    /// assert_eq!(sent, [(0.0, false), (10.0, false), (20.0, true), (30.0, true), (40.0, false), (50.0, false)]);
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn with_missing_rows(&self, period: f64, longest: f64) -> Result<Self> {
        for (field, value) in [("period", period), ("longest", longest)] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(InvalidInput::new(
                    field,
                    format!("{value:?}"),
                    "it is a time above 0, in s",
                    "Give the time between two packets as sent, and the longest pause that is a loss.",
                ));
            }
        }
        if self.duration / period > MOST_ROWS {
            return Err(InvalidInput::new(
                "period",
                format!("{period:?}"),
                format!("a trace of {} s with it has more than {MOST_ROWS:e} rows", self.duration),
                "Give a longer period, or a part of the trace.",
            ));
        }
        let mut rows = vec![self.rows[0]];
        let mut removed = 0.0;
        for pair in self.rows.windows(2) {
            let step = pair[1].time - pair[0].time;
            let from = pair[0].time - removed;
            if step > longest.max(1.5 * period) {
                removed += step - period;
            } else if step > 1.5 * period {
                let missing = (step / period).round() as usize - 1;
                let apart = step / (missing + 1) as f64;
                let lost = |n: usize| TraceRow { time: from + n as f64 * apart, delay: 0.0, lost: true };
                rows.extend((1..=missing).map(lost));
            }
            rows.push(TraceRow { time: pair[1].time - removed, ..pair[1] });
        }
        Ok(Self::new(rows)?.with_losses_recorded())
    }
}
