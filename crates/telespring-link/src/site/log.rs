//! What happened in a live session.

use telespring::session::{EventKind, LocalTime};

use super::moment::Cause;
use crate::hello::Disagreement;
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
    /// Both sides have agreed: the endpoint decides on the force from now on.
    Running,
    /// The force falls to zero.
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

/// What happened, and when.
#[derive(Debug, Clone)]
pub struct Log {
    entries: Vec<(LocalTime, Happened)>,
    missed: u64,
}

impl Log {
    pub(super) fn new() -> Self {
        Self { entries: Vec::with_capacity(LOG_CAPACITY), missed: 0 }
    }

    /// Adds an entry, if there is room. The last place is for the end.
    pub(super) fn push(&mut self, time: LocalTime, happened: Happened) {
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

    /// Entries for which there was no room.
    pub fn missed(&self) -> u64 {
        self.missed
    }
}
