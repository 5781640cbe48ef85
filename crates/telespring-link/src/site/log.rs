//! What happened in a live session.

use telespring::session::{EventKind, LocalTime};

use super::{Badness, Cause, Interruption, Limit, Phase};
use crate::hello::Difference;
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
    Disagreed(Difference),
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
    /// The own device reported a value that cannot be, and that was not used.
    ImpossibleValue {
        /// What it is said to be, with its place in the row.
        what: &'static str,
        /// The value.
        value: f64,
    },
    /// An axis is left out of the coupling, as this site or the partner wants it.
    AxisLocked {
        /// 0 for x, 1 for y.
        axis: u8,
        /// Whether this site wants it, and the partner.
        by: [bool; 2],
    },
    /// The device program has not reported anything yet.
    DeviceAwaited,
    /// The partner has not said anything yet.
    PartnerAwaited,
    /// The way of the datagrams has changed.
    Path(PathEvent),
    /// The recording has broken off; the session goes on.
    RecordingBroken,
}

/// Who can make something happen again and again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Author {
    /// The partner or the network.
    There,
    /// The people here, or the device, with orders.
    Orders,
    /// Nobody: it happens once, or at most a few times per second.
    Nobody,
}

impl Happened {
    fn author(&self) -> Author {
        match self {
            Self::Agreed { .. }
            | Self::Disagreed(_)
            | Self::Entered(_)
            | Self::Offset(_)
            | Self::Consented
            | Self::ConsentLost
            | Self::PartnerConsented
            | Self::EmergencyStop { is_own: false }
            | Self::DelayTooShort { .. }
            | Self::AxisLocked { .. }
            | Self::Session(_)
            | Self::Path(_) => Author::There,
            Self::OrderRefused { .. } | Self::Mark(_) => Author::Orders,
            _ => Author::Nobody,
        }
    }
}

/// How much of one author is logged: so much in a row, and one entry more with every fourth tick. The rest is counted.
#[derive(Debug, Clone, Copy)]
struct Allowance(u32);

impl Allowance {
    const ENTRY: u32 = 4;
    const MOST: u32 = 512 * Self::ENTRY;

    fn begin_tick(&mut self) {
        self.0 = (self.0 + 1).min(Self::MOST);
    }

    /// Whether an entry is allowed.
    fn take(&mut self) -> bool {
        let left = self.0.checked_sub(Self::ENTRY);
        self.0 = left.unwrap_or(self.0);
        left.is_some()
    }
}

/// Entries of the log that are kept for what neither the partner nor orders can bring about again and again.
const RESERVED: usize = LOG_CAPACITY / 4;
/// The most that happens between two ticks; the rest is in the log only.
const NEWS_CAPACITY: usize = 256;

/// What happened, and when. Nobody can fill it, or keep what happens here out of it.
#[derive(Debug, Clone)]
pub struct Log {
    entries: Vec<(LocalTime, Happened)>,
    missed: u64,
    news: Vec<(LocalTime, Happened)>,
    there: Allowance,
    orders: Allowance,
    latest: LocalTime,
}

impl Log {
    pub(super) fn new() -> Self {
        let (news, whole) = (Vec::with_capacity(NEWS_CAPACITY), Allowance(Allowance::MOST));
        Self {
            entries: Vec::with_capacity(LOG_CAPACITY),
            missed: 0,
            news,
            there: whole,
            orders: whole,
            latest: LocalTime(0),
        }
    }

    /// A tick begins.
    pub(super) fn begin_tick(&mut self) {
        self.news.clear();
        self.there.begin_tick();
        self.orders.begin_tick();
    }

    /// Adds an entry, if there is room. The last place is for the end. What a tick finds out counts as of now, also if something
    /// came while it ran: the times rise.
    pub(super) fn push(&mut self, time: LocalTime, happened: Happened) {
        let time = time.max(self.latest);
        self.latest = time;
        let (is_allowed, room) = match happened.author() {
            Author::There => (self.there.take(), LOG_CAPACITY - RESERVED),
            Author::Orders => (self.orders.take(), LOG_CAPACITY - RESERVED),
            Author::Nobody => (true, LOG_CAPACITY - usize::from(!matches!(happened, Happened::Ended(_)))),
        };
        if is_allowed && self.news.len() < NEWS_CAPACITY {
            self.news.push((time, happened));
        }
        if is_allowed && self.entries.len() < room {
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

    /// Entries for which there was no room, or of which there were too many.
    pub fn missed(&self) -> u64 {
        self.missed
    }
}
