//! What happened in a live session.

use telespring::session::{EventKind, LocalTime};

use super::{Badness, Cause, Interruption, Limit, Phase};
use crate::hello::Disagreement;
use crate::operator::{Mark, Order};
use crate::transport::PathEvent;

/// The most entries of a log; the rest is counted.
pub const LOG_CAPACITY: usize = 4096;

/// What happened.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Happened {
    /// This side agrees to the partner's terms.
    Agreed {
        /// The partner's session id.
        session: u64,
    },
    /// The two sides do not agree.
    Disagreed(Disagreement),
    /// The state of the session is another one.
    Entered(Phase),
    /// The handles are apart: the way that robot 2 would have to go to where robot 1 is, m.
    Offset([f64; 2]),
    /// The person here agrees to be coupled.
    Consented,
    /// A consent given here holds no more.
    ConsentLost,
    /// The person there agrees to be coupled.
    PartnerConsented,
    /// The coupling ends for now: the force falls to zero.
    Interrupted(Interruption),
    /// The emergency stop has latched, here or there.
    EmergencyStop {
        /// Whether it is the own one.
        is_own: bool,
    },
    /// The own emergency stop is left.
    Cleared,
    /// The pause ordered here is over.
    Resumed,
    /// An order that is not possible now.
    OrderRefused {
        /// The order.
        order: Order,
        /// The state in which it came.
        phase: Phase,
    },
    /// A marker.
    Mark(Mark),
    /// A limit keeps the force from being that of the spring …
    Limiting(Limit),
    /// … and does so no more.
    Unlimited(Limit),
    /// The network is bad: the force is softened …
    Softened(Badness),
    /// … and returns to its whole.
    Restored,
    /// The network has been bad for too long: the session pauses.
    NetworkPause(Badness),
    /// The delay that is imposed, s, is shorter than the network's own.
    DelayTooShort {
        /// The delay imposed on the partner's motion, s.
        imposed: f64,
        /// Half of the round trip as measured, or the age in use while the session runs, s.
        measured: f64,
    },
    /// The force falls to zero, and the session ends.
    Leaving(Cause),
    /// The session is over.
    Ended(Cause),
    /// An event of the endpoint.
    Session(EventKind),
    /// The way of the datagrams has changed.
    Path(PathEvent),
    /// The recording has broken off; the session goes on.
    RecordingBroken,
}

/// The most that happens between two ticks; the rest is in the log only.
const NEWS_CAPACITY: usize = 256;

/// What happened, and when.
#[derive(Debug, Clone)]
pub struct Log {
    entries: Vec<(LocalTime, Happened)>,
    missed: u64,
    news: Vec<(LocalTime, Happened)>,
}

impl Log {
    pub(super) fn new() -> Self {
        let news = Vec::with_capacity(NEWS_CAPACITY);
        Self { entries: Vec::with_capacity(LOG_CAPACITY), missed: 0, news }
    }

    /// A tick begins.
    pub(super) fn begin_tick(&mut self) {
        self.news.clear();
    }

    /// Adds an entry, if there is room. The last place is for the end.
    pub(super) fn push(&mut self, time: LocalTime, happened: Happened) {
        if self.news.len() < NEWS_CAPACITY {
            self.news.push((time, happened));
        }
        let room = LOG_CAPACITY - usize::from(!matches!(happened, Happened::Ended(_)));
        if self.entries.len() < room {
            self.entries.push((time, happened));
        } else {
            self.missed += 1;
        }
    }

    /// The entries, oldest first.
    pub fn entries(&self) -> &[(LocalTime, Happened)] {
        &self.entries
    }

    /// What happened at the latest tick, also when the log is full.
    pub fn news(&self) -> &[(LocalTime, Happened)] {
        &self.news
    }

    /// Entries for which there was no room.
    pub fn missed(&self) -> u64 {
        self.missed
    }
}
