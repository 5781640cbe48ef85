//! What guard and limits do, told while they do it, and not more often than people can read.

use telespring::session::{LocalTime, Span};

use super::{Happened, Log};

/// A limit that acts for so short counts as one time.
const QUIET: Span = Span(2_000_000_000);

/// What keeps the force from being that of the spring.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Limit {
    /// The strategy: the guard's account cannot pay the spring's force.
    Guard,
    /// The largest force.
    Force,
}

impl Limit {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Guard, Self::Force];

    /// The limit in a word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Guard => "guard",
            Self::Force => "force",
        }
    }
}

/// Whether each limit acts, with hysteresis: it begins with the first tick and is over after 2 s without one.
#[derive(Debug, Clone, Default)]
pub(super) struct Notices {
    latest: [Option<LocalTime>; Limit::ALL.len()],
}

impl Notices {
    /// Takes whether each limit acted at this tick.
    pub(super) fn take(&mut self, now: LocalTime, acts: [bool; Limit::ALL.len()], log: &mut Log) {
        for ((limit, latest), acts) in Limit::ALL.into_iter().zip(&mut self.latest).zip(acts) {
            if acts {
                if latest.is_none() {
                    log.push(now, Happened::Limiting(limit));
                }
                *latest = Some(now);
            } else if latest.is_some_and(|latest| now - latest >= QUIET) {
                *latest = None;
                log.push(now, Happened::Unlimited(limit));
            }
        }
    }
}
