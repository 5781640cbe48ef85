//! Measures the path to the partner: both sides send what a session would send, and tell each other what came.
//!
//! | stage | what is sent | how it goes on |
//! |---|---|---|
//! | waiting | a packet every 50 ms | an echo of an own stamp came: measuring |
//! | measuring | a packet per sample period | all are sent, or one of the two sides is stopped, and stragglers had their time: reporting |
//! | reporting | what came, block by block, until the partner has it | both have all, or nothing comes: done |
//!
//! A side that reports measures no more, so its partner ends its own measurement, too: both ways are over the same time.
//!
//! The packets are those of a session (`docs/wire.md`), from a handle at rest, so that they take the same way. A site that runs a session
//! refuses them as those of a stranger. No robot is touched.

mod exchange;
mod outcome;
mod report;
mod travels;

pub use outcome::{Outcome, Way};

use telespring::InvalidInput;
use telespring::session::clock::Clock as PartnerClock;
use telespring::session::wire::{Echo, Flags, Packet};
use telespring::session::{ClockSettings, LocalTime, Motion, PeerTime, Span};

use crate::clock::Clock;
use crate::transport::{PathEvent, Transport};
use exchange::{Heard, Told};
use travels::Travels;

/// From one packet to the next while the partner is not there.
const KNOCK: Span = Span(50_000_000);
/// How long the last packets may travel.
const STRAGGLE: Span = Span(1_000_000_000);
/// Without anything from the partner for this long, the probe ends.
const PATIENCE: Span = Span(10_000_000_000);
/// How long a side that has everything goes on telling so.
const LINGER: Span = Span(500_000_000);
/// How long a report may take: that of a million packets takes a minute.
const LONGEST_REPORT: Span = Span(300_000_000_000);
/// The most packets of a measurement, and room for those of the time before.
const MOST_PACKETS: usize = 1_000_000;
/// Room for the packets of the time of waiting, of either side.
const BEFORE: usize = 100_000;

/// What a probe is told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProbeSettings {
    /// The own session id, not 0.
    pub session: u64,
    /// From one packet to the next.
    pub period: Span,
    /// How long packets are sent.
    pub duration: Span,
}

/// Where a probe is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Nobody has answered yet.
    Waiting,
    /// Packets go both ways.
    Measuring,
    /// Both tell what came.
    Reporting,
    /// It is over.
    Done(End),
}

/// Why a probe is over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// Both ways are known.
    Complete,
    /// It was stopped before anybody had answered.
    Stopped,
    /// The partner fell silent before it had told all.
    Silent,
}

impl Stage {
    /// The stage in a word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Waiting => "waiting",
            Self::Measuring => "measuring",
            Self::Reporting => "reporting",
            Self::Done(_) => "done",
        }
    }
}

impl End {
    /// The end in a word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Complete => "complete",
            Self::Stopped => "stopped",
            Self::Silent => "partner-silent",
        }
    }
}

/// One side of a probe.
#[derive(Debug)]
pub struct Probe<T> {
    transport: T,
    settings: ProbeSettings,
    stage: Stage,
    clock: PartnerClock,
    partner: Option<u64>,
    /// The newest stamp of the partner, and when it came.
    newest: Option<(PeerTime, LocalTime)>,
    heard: Option<LocalTime>,
    due: LocalTime,
    sequence: u64,
    /// Packets of the measurement, if nobody stops it.
    packets: usize,
    /// Somebody has stopped it.
    is_stopped: bool,
    /// The first packet of the measurement, and when each of it was sent.
    first: u64,
    sent: Vec<LocalTime>,
    travels: Travels,
    /// The partner's first packet that came during the measurement: a partner that tells its own first one knows better.
    first_heard: Option<usize>,
    round_trips: Vec<Span>,
    /// What the partner has told of the own packets.
    reported: Option<Heard>,
    /// What the partner has been told of its packets.
    told: Told,
    /// Since when the last packet is sent, or everything is known.
    since: Option<LocalTime>,
    /// When the report began.
    reports_since: Option<LocalTime>,
    strange: u64,
    runs_session: bool,
    paths: Vec<(LocalTime, PathEvent)>,
}

impl<T: Transport> Probe<T> {
    /// A probe that waits for the partner.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if it would send no packet, or more than a million.
    pub fn new(settings: ProbeSettings, transport: T) -> Result<Self, InvalidInput> {
        let packets = settings.duration.0 / settings.period.0.max(1);
        if !(1..=MOST_PACKETS as i64).contains(&packets) {
            let (value, allowed) = (format!("{} s", settings.duration.seconds()), "1 to 1000000 packets");
            return Err(InvalidInput::new("seconds", value, allowed, "Give 60."));
        }
        let packets = packets.unsigned_abs() as usize;
        Ok(Self {
            transport,
            settings,
            stage: Stage::Waiting,
            clock: PartnerClock::new(ClockSettings::estimated())?,
            partner: None,
            newest: None,
            heard: None,
            due: LocalTime(0),
            sequence: 0,
            packets,
            is_stopped: false,
            first: 0,
            sent: Vec::with_capacity(packets),
            travels: Travels::with_capacity(MOST_PACKETS + BEFORE),
            first_heard: None,
            round_trips: Vec::with_capacity(packets),
            reported: None,
            told: Told::default(),
            since: None,
            reports_since: None,
            strange: 0,
            runs_session: false,
            paths: Vec::new(),
        })
    }

    /// Packets of the measurement that are sent, and of all.
    pub fn progress(&self) -> (usize, usize) {
        (self.sent.len(), self.packets)
    }

    /// Sends and receives once. `stop` ends the measurement of both sides; what was sent until then is still reported.
    pub fn tick(&mut self, clock: &impl Clock, stop: bool) -> Stage {
        self.receive(clock);
        let now = clock.now();
        while let Some(event) = self.transport.poll_path() {
            if self.paths.len() < 256 {
                self.paths.push((now, event));
            }
        }
        self.is_stopped |= stop;
        match self.stage {
            Stage::Waiting if self.is_stopped => self.stage = Stage::Done(End::Stopped),
            Stage::Waiting if self.clock.report(now).minimum_round_trip.is_some() => {
                (self.stage, self.first, self.due) = (Stage::Measuring, self.sequence, now);
                self.send(now);
            }
            Stage::Waiting if now >= self.due => {
                self.send(now);
                self.due = now + KNOCK;
            }
            Stage::Measuring => self.measure(now),
            Stage::Reporting => {
                self.tell(now);
                if self.knows_all() && now - *self.since.get_or_insert(now) >= LINGER {
                    self.stage = Stage::Done(End::Complete);
                }
            }
            Stage::Waiting | Stage::Done(_) => {}
        }
        let is_silent = self.heard.is_some_and(|heard| now - heard >= PATIENCE)
            || self.reports_since.is_some_and(|since| now - since >= LONGEST_REPORT);
        if is_silent && matches!(self.stage, Stage::Measuring | Stage::Reporting) {
            let knows = self.reported.as_ref().is_some_and(Heard::is_complete);
            self.stage = Stage::Done(if knows { End::Complete } else { End::Silent });
        }
        self.stage
    }

    /// Sends a packet of the measurement, until it is over and the last ones had their time.
    fn measure(&mut self, now: LocalTime) {
        let is_ended = self.is_stopped || self.reported.is_some();
        // one packet at least: there is no report on none
        let is_over = (is_ended && !self.sent.is_empty()) || self.sent.len() >= self.packets;
        if !is_over {
            self.send(now);
            self.since = Some(now);
        } else if self.since.is_none_or(|since| now - since >= STRAGGLE) {
            (self.stage, self.since, self.reports_since) = (Stage::Reporting, None, Some(now));
            self.tell(now);
        }
    }

    /// Sends a packet of a handle at rest, unless the transport leaves it out.
    fn send(&mut self, now: LocalTime) {
        if !self.transport.is_due() {
            return;
        }
        let newest = self.newest.filter(|(_, came)| *came <= now);
        let packet = Packet {
            flags: Flags::default(),
            session: self.settings.session,
            sequence: self.sequence,
            sent: now.seen_by_peer(),
            echo: newest.map(|(sent, came)| Echo { stamp: sent.seen_by_peer(), held: now - came }),
            motion: Motion::default(),
            energy_sent: 0.0,
            stiffness: 0.0,
            signal: [0.0; 2],
        };
        self.sequence += 1;
        if self.stage == Stage::Measuring {
            self.sent.push(now);
        }
        self.transport.send(now, &packet.encode());
    }
}
