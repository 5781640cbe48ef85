//! What a session was, as JSON.

mod events;
mod remedies;

pub use events::{Entry, event_words, watchdog_words};

use serde::Serialize;
use telespring::session::playout::PlayoutReport;
use telespring::session::{SessionReport, Span};

use crate::device::Device;
use crate::real_time::{Lateness, Privileges};
use crate::record::RecordingSummary;
use crate::site::{Cause, Site, Tally};
use crate::transport::{Transport, TransportReport};

/// The version of the summary.
pub const SCHEMA: u32 = 1;

/// What a session of one site was. All times are in s, energies in J, forces in N, distances in m; `null` is not known.
#[derive(Debug, Clone, Serialize)]
pub struct Summary {
    /// [`SCHEMA`].
    pub schema: u32,
    /// The robot of the study, 1 or 2.
    pub side: u8,
    /// The state in which the session was left.
    pub state: &'static str,
    /// Why it ended.
    pub cause: Option<&'static str>,
    /// On what the two sides did not agree, if that ended it.
    pub disagreement: Option<&'static str>,
    /// From the first to the latest tick.
    pub seconds: f64,
    /// The share of the ticks at which the session ran.
    pub coupled_share: f64,
    /// The round trip.
    pub round_trip: RoundTrip,
    /// The age of the partner's motion in use.
    pub age: Option<Age>,
    /// What the network did.
    pub loss: Loss,
    /// What the transport knows of its path.
    pub path: Path,
    /// How late the loop was.
    pub lateness: LatenessSummary,
    /// The share of the ticks at which the strategy changed the force of the spring; `null` without a tick with a partner.
    pub limited_share: Option<f64>,
    /// The energy of the account.
    pub energy: Energy,
    /// The share of the ticks at which the force was cut to its limit, and at which it was softened because of the network.
    pub cut_share: f64,
    /// See `cut_share`.
    pub softened_share: f64,
    /// How often the coupling was interrupted: by a pause, a stop, a device, the network or the partner.
    pub interruptions: u64,
    /// How often an emergency stop latched, here or there.
    pub emergency_stops: u64,
    /// The largest force commanded.
    pub largest_force: f64,
    /// The mean distance to the target while the session ran (TE), if there is a target.
    pub te: Option<f64>,
    /// Datagrams that changed nothing, by why.
    pub refused: Refused,
    /// What the operating system granted.
    pub real_time: RealTime,
    /// What happened, oldest first; times since the first tick.
    pub events: Vec<Entry>,
    /// Events for which there was no room.
    pub missed_events: u64,
    /// What became of the recording; `null` if there is none.
    pub recording: Option<RecordingSummary>,
}

/// See [`Summary::round_trip`].
#[derive(Debug, Clone, Serialize)]
pub struct RoundTrip {
    /// The latest.
    pub latest: Option<f64>,
    /// The smallest.
    pub smallest: Option<f64>,
    /// Half of it: the largest error of the partner's clock, and so of the age.
    pub clock_error: Option<f64>,
}

/// See [`Summary::age`].
#[derive(Debug, Clone, Serialize)]
pub struct Age {
    /// The smallest.
    pub smallest: f64,
    /// The mean.
    pub mean: f64,
    /// Half of the motions in use were no older.
    pub median: f64,
    /// 99 of 100.
    pub quantile_99: f64,
    /// The largest.
    pub largest: f64,
    /// The share of the ticks at which an old motion was held.
    pub held_share: f64,
}

/// See [`Summary::loss`].
#[derive(Debug, Clone, Serialize)]
pub struct Loss {
    /// Packets sent.
    pub sent: u64,
    /// Packets of the partner that came.
    pub received: u64,
    /// Packets of the partner that did not come, although later ones did.
    pub lost: u64,
    /// The share of those.
    pub share: f64,
    /// Packets that came after their time.
    pub late: u64,
    /// Times that the network said that the partner is not there.
    pub unreachable: u64,
}

/// See [`Summary::path`]. All is 0 or `null` for a transport that knows nothing of its path.
#[derive(Debug, Clone, Serialize)]
pub struct Path {
    /// The latest round trip of the transport's own packets.
    pub round_trip: Option<f64>,
    /// Packets that got lost on the way to the partner.
    pub lost: u64,
    /// Of how many packets one was sent at last, because of the loss that lasted; `null` if the transport leaves out none.
    pub every: Option<u8>,
    /// Packets that were left out.
    pub thinned: u64,
    /// Packets for which there was no way.
    pub unsent: u64,
    /// Datagrams that made room for newer ones before the loop looked.
    pub overflowed: u64,
    /// Connections with the partner, one after the other.
    pub connections: u64,
    /// Connections that were refused: unknown keys, and more than this site answers.
    pub strangers: u64,
}

/// See [`Summary::lateness`].
#[derive(Debug, Clone, Serialize)]
pub struct LatenessSummary {
    /// Ticks.
    pub ticks: u64,
    /// See [`Lateness`].
    pub median: f64,
    /// See [`Lateness`].
    pub quantile_99: f64,
    /// See [`Lateness`].
    pub quantile_999: f64,
    /// See [`Lateness`].
    pub largest: f64,
    /// See [`Lateness`].
    pub overruns: u64,
    /// See [`Lateness`].
    pub followed: u64,
}

/// See [`Summary::energy`].
#[derive(Debug, Clone, Serialize)]
pub struct Energy {
    /// In the account at the end.
    pub balance: Option<f64>,
    /// The least that was in the account.
    pub least_balance: Option<f64>,
    /// Given out to the handle.
    pub given_out: f64,
    /// Sent to the partner.
    pub sent: f64,
    /// Taken in from the partner.
    pub received: f64,
}

/// See [`Summary::refused`].
#[derive(Debug, Clone, Serialize)]
pub struct Refused {
    /// No packet, or one that the endpoint refused.
    pub datagrams: u64,
    /// Packets of a session that was not agreed to.
    pub strange_packets: u64,
    /// Greetings that were not for this session.
    pub strange_greetings: u64,
    /// Greetings of the partner that came after a later one.
    pub overtaken_greetings: u64,
    /// Datagrams that came before the session ran.
    pub early: u64,
    /// Ticks at which more came than one tick looks at.
    pub full_ticks: u64,
}

/// See [`Summary::real_time`].
#[derive(Debug, Clone, Serialize)]
pub struct RealTime {
    /// `granted`, `refused` or `not-asked`.
    pub priority: &'static str,
    /// As above.
    pub locked_memory: &'static str,
    /// Whether the processors stayed awake, as above.
    pub awake: &'static str,
}

impl Summary {
    /// What the session of a site was.
    pub fn new<D: Device, T: Transport>(
        side: u8,
        site: &Site<D, T>,
        lateness: &Lateness,
        privileges: &Privileges,
    ) -> Self {
        let (report, tally) = (site.session_report(), site.tally());
        let first = tally.first.unwrap_or_default();
        let cause = site.cause();
        let strategy = report.strategy;
        let share = |part: u64, whole: u64| if whole == 0 { 0.0 } else { part as f64 / whole as f64 };
        Self {
            schema: SCHEMA,
            side,
            state: site.phase().word(),
            cause: cause.map(Cause::word),
            disagreement: match cause {
                Some(Cause::Refused(disagreement)) => Some(disagreement.word()),
                _ => None,
            },
            seconds: tally.duration().seconds(),
            coupled_share: share(tally.coupled_ticks, tally.ticks),
            round_trip: round_trip(&report),
            age: age(&report.playout),
            loss: loss(&report, &site.transport_report()),
            path: path(&site.transport_report()),
            lateness: LatenessSummary {
                ticks: lateness.ticks,
                median: lateness.median.seconds(),
                quantile_99: lateness.quantile_99.seconds(),
                quantile_999: lateness.quantile_999.seconds(),
                largest: lateness.largest.seconds(),
                overruns: lateness.overruns,
                followed: lateness.followed,
            },
            limited_share: (strategy.ticks > 0).then(|| share(strategy.limited_ticks, strategy.ticks)),
            energy: Energy {
                balance: strategy.balance,
                least_balance: tally.least_balance,
                given_out: strategy.given_out,
                sent: strategy.energy_sent,
                received: strategy.energy_received,
            },
            cut_share: share(tally.cut_ticks, tally.ticks),
            softened_share: share(tally.softened_ticks, tally.ticks),
            interruptions: tally.interruptions,
            emergency_stops: tally.emergency_stops,
            largest_force: tally.largest_force,
            te: tally.tracking_error(),
            refused: refused(&report, tally),
            real_time: RealTime {
                priority: granted(privileges.priority.map(|outcome| outcome.is_ok())),
                locked_memory: granted(privileges.locked_memory.map(|outcome| outcome.is_ok())),
                awake: granted(privileges.awake.as_ref().map(Result::is_ok)),
            },
            events: site
                .log()
                .entries()
                .iter()
                .map(|(time, happened)| Entry::new(first, *time, happened))
                .collect(),
            missed_events: site.log().missed() + report.missed_events,
            recording: None,
        }
    }
}

fn round_trip(report: &SessionReport) -> RoundTrip {
    let clock = report.clock;
    RoundTrip {
        latest: clock.round_trip.map(Span::seconds),
        smallest: clock.minimum_round_trip.map(Span::seconds),
        clock_error: clock.offset_error.map(Span::seconds),
    }
}

fn age(playout: &PlayoutReport) -> Option<Age> {
    playout.ages.map(|ages| Age {
        smallest: ages.smallest.seconds(),
        mean: ages.mean.seconds(),
        median: ages.median.seconds(),
        quantile_99: ages.quantile_99.seconds(),
        largest: ages.largest.seconds(),
        held_share: playout.held_share(),
    })
}

fn loss(report: &SessionReport, transport: &TransportReport) -> Loss {
    let PlayoutReport { received, lost, late, .. } = report.playout;
    let all = received + lost;
    Loss {
        sent: report.sent,
        received,
        lost,
        share: if all == 0 { 0.0 } else { lost as f64 / all as f64 },
        late,
        unreachable: transport.unreachable,
    }
}

fn path(report: &TransportReport) -> Path {
    let TransportReport {
        round_trip, lost, every, thinned, unsent, overflowed, connections, strangers, ..
    } = *report;
    Path {
        round_trip: round_trip.map(Span::seconds),
        lost,
        every: (every > 0).then_some(every),
        thinned,
        unsent,
        overflowed,
        connections,
        strangers,
    }
}

fn refused(report: &SessionReport, tally: &Tally) -> Refused {
    Refused {
        datagrams: report.refused,
        strange_packets: tally.strange_packets,
        strange_greetings: tally.strange_greetings,
        overtaken_greetings: tally.overtaken_greetings,
        early: tally.early_datagrams,
        full_ticks: tally.full_ticks,
    }
}

/// What became of a request, in a word.
fn granted(outcome: Option<bool>) -> &'static str {
    match outcome {
        Some(true) => "granted",
        Some(false) => "refused",
        None => "not-asked",
    }
}
