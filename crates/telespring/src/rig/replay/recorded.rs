//! What the endpoint of one live site was given, as its recording has it.

use crate::error::{InvalidInput, Result};
use crate::rig::network::Datagram;
use crate::session::{LocalTime, Motion};

/// One tick of a recorded site.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecordedTick {
    /// When it began, on the site's clock: the stamp of its measurement and of its packet.
    pub time: LocalTime,
    /// The motion that the endpoint was given; `None` if it was given none.
    pub motion: Option<Motion>,
    /// The force that the endpoint was told to have acted since the last measurement, N; `None` if it was told none.
    pub acted: Option<[f64; 2]>,
    /// The target that the endpoint was given.
    pub target: Option<Motion>,
    /// When the endpoint was asked for the force; `None` if it was not.
    pub answered: Option<LocalTime>,
    /// The share of the endpoint's force that the site let act, per axis, before its limit: 1 while running.
    pub share: [f64; 2],
}

impl RecordedTick {
    /// A tick at which the endpoint was given and asked nothing.
    pub fn at(time: LocalTime) -> Self {
        Self { time, motion: None, acted: None, target: None, answered: None, share: [1.0; 2] }
    }
}

/// One datagram that the endpoint of a recorded site was given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecordedArrival {
    /// The index of the tick in which the endpoint was given it: after the measurement, before the force.
    pub tick: usize,
    /// When, on the site's clock.
    pub time: LocalTime,
    /// Its bytes; one that was no packet counts as refused.
    pub datagram: Datagram,
}

/// What the endpoint of one live site was given, in its order.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedSite {
    ticks: Vec<RecordedTick>,
    arrivals: Vec<RecordedArrival>,
}

impl RecordedSite {
    /// The ticks and arrivals of a site, oldest first.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if the times of the ticks do not rise, or an arrival is out of order or of a tick that is not there.
    pub fn new(ticks: Vec<RecordedTick>, arrivals: Vec<RecordedArrival>) -> Result<Self> {
        for (index, pair) in ticks.windows(2).enumerate() {
            if pair[1].time <= pair[0].time {
                return Err(InvalidInput::new(
                    format!("ticks[{}].time", index + 1),
                    format!("{} ns", pair[1].time.0),
                    format!("later than the tick before, {} ns", pair[0].time.0),
                    "Give the ticks of one site in the order of its clock.",
                ));
            }
        }
        for (index, arrival) in arrivals.iter().enumerate() {
            let before = if index == 0 { 0 } else { arrivals[index - 1].tick };
            if arrival.tick < before || arrival.tick >= ticks.len() {
                return Err(InvalidInput::new(
                    format!("arrivals[{index}].tick"),
                    arrival.tick,
                    format!("an index of a tick from {before} to {}", ticks.len().saturating_sub(1)),
                    "Give the arrivals in the order in which the site took them.",
                ));
            }
        }
        Ok(Self { ticks, arrivals })
    }

    /// The ticks, oldest first.
    pub fn ticks(&self) -> &[RecordedTick] {
        &self.ticks
    }

    /// The arrivals, oldest first.
    pub fn arrivals(&self) -> &[RecordedArrival] {
        &self.arrivals
    }
}
