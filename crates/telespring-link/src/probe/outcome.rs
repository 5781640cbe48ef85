//! What a probe has found: numbers of both ways, and the trace that `telespring trace` reads.

use serde::Serialize;
use telespring::session::{LocalTime, Span};

use super::{End, Probe, Stage};
use crate::transport::Transport;

/// A silence that ends the force of a session with the usual `safety.silence`.
const SILENCE: f64 = 0.15;

/// What a probe has found. Times in s; `null` is not known.
#[derive(Debug, Clone, Serialize)]
pub struct Outcome {
    /// The version of this object, 1.
    pub schema: u32,
    /// How it ended: `complete`, `stopped` or `partner-silent`.
    pub end: &'static str,
    /// How long packets were sent.
    pub seconds: f64,
    /// Packets per second.
    pub rate: f64,
    /// The round trip.
    pub round_trip: Option<Quantiles>,
    /// The largest error of the ages of one way: how well the partner's clock is known.
    pub clock_error: Option<f64>,
    /// The way from the partner to this site; of a partner that fell silent, up to its last packet that came.
    pub towards_here: Option<Way>,
    /// The way from this site to the partner, as the partner saw it.
    pub towards_partner: Option<Way>,
    /// Datagrams that were none of this probe.
    pub strange: u64,
    /// Whether the partner runs a session in place of a probe.
    pub partner_runs_session: bool,
    /// Changes of the way.
    pub paths: Vec<Path>,
}

/// A change of the way.
#[derive(Debug, Clone, Serialize)]
pub struct Path {
    /// Since the first packet of the measurement.
    pub time: f64,
    /// What happened.
    pub event: &'static str,
}

/// How times are distributed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Quantiles {
    /// The smallest.
    pub smallest: f64,
    /// Half are no longer.
    pub median: f64,
    /// 9 of 10.
    pub quantile_90: f64,
    /// 99 of 100.
    pub quantile_99: f64,
    /// 999 of 1000.
    pub quantile_999: f64,
    /// The largest.
    pub largest: f64,
}

/// One way of a path.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Way {
    /// Packets sent.
    pub sent: u64,
    /// Packets that came.
    pub received: u64,
    /// The share that did not come.
    pub lost_share: f64,
    /// Losses in a row: how many rows, their mean and the longest.
    pub bursts: Bursts,
    /// Packets that came after a later one.
    pub overtaken: u64,
    /// How old packets were when they came.
    pub age: Option<Quantiles>,
    /// The mean change of the age from one packet to the next (as in RFC 3550, without its smoothing).
    pub jitter: Option<f64>,
    /// Times without any packet of 150 ms or more, after which the force of a session is zero.
    pub silences: u64,
    /// The longest time without any packet.
    pub longest_silence: f64,
}

/// See [`Way::bursts`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Bursts {
    /// Rows of lost packets.
    pub count: u64,
    /// Their mean length, packets; 0 without any.
    pub mean: f64,
    /// The longest, packets.
    pub longest: u64,
}

impl Quantiles {
    /// Of times in ns; `None` without any.
    fn of(mut times: Vec<i64>) -> Option<Self> {
        times.sort_unstable();
        let at = |share: f64| {
            let place = (share * times.len() as f64).ceil() as usize;
            times.get(place.clamp(1, times.len().max(1)) - 1).map(|time| Span(*time).seconds())
        };
        Some(Self {
            smallest: at(0.0)?,
            median: at(0.5)?,
            quantile_90: at(0.9)?,
            quantile_99: at(0.99)?,
            quantile_999: at(0.999)?,
            largest: at(1.0)?,
        })
    }
}

impl Way {
    /// From the ages of the packets, ns, `None` for one that did not come, and when each was sent.
    fn new(ages: &[Option<i64>], sent: impl Fn(usize) -> i64) -> Self {
        let came: Vec<i64> = ages.iter().copied().flatten().collect();
        let rows = ages.split(Option::is_some).map(<[_]>::len).filter(|length| *length > 0);
        let (count, lost, longest) =
            rows.fold((0, 0, 0), |(count, all, longest), row| (count + 1, all + row, longest.max(row)));
        let mut arrivals: Vec<i64> = ages
            .iter()
            .enumerate()
            .filter_map(|(number, age)| age.map(|age| sent(number).saturating_add(age)))
            .collect();
        let latest = arrivals.iter().scan(i64::MIN, |latest, arrival| {
            let is_overtaken = arrival < latest;
            *latest = (*latest).max(*arrival);
            Some(is_overtaken)
        });
        let overtaken = latest.filter(|is| *is).count() as u64;
        arrivals.sort_unstable();
        let gaps = || arrivals.windows(2).map(|pair| Span(pair[1] - pair[0]).seconds());
        let changes = ages.windows(2).filter_map(|pair| Some((pair[1]? - pair[0]?).abs()));
        let (changed, number) = changes.fold((0.0, 0_u64), |(sum, n), change| (sum + change as f64, n + 1));
        Self {
            sent: ages.len() as u64,
            received: came.len() as u64,
            lost_share: if ages.is_empty() { 0.0 } else { lost as f64 / ages.len() as f64 },
            bursts: Bursts {
                count,
                mean: if count == 0 { 0.0 } else { lost as f64 / count as f64 },
                longest: longest as u64,
            },
            overtaken,
            age: Quantiles::of(came),
            jitter: (number > 0).then(|| changed / number as f64 * 1e-9),
            silences: gaps().filter(|gap| *gap >= SILENCE).count() as u64,
            longest_silence: gaps().fold(0.0, f64::max),
        }
    }
}

/// The ages of both ways, ns; `None` for a packet that did not come.
#[derive(Debug, Clone, Default)]
struct Ages {
    towards_here: Option<Vec<Option<i64>>>,
    towards_partner: Option<Vec<Option<i64>>>,
}

impl<T: Transport> Probe<T> {
    /// What has been found so far.
    pub fn outcome(&self) -> Outcome {
        let period = self.settings.period;
        let clock = self.clock.report(self.latest());
        let Ages { towards_here, towards_partner } = self.ages();
        let first =
            self.sent.first().copied().or(self.paths.first().map(|(time, _)| *time)).unwrap_or_default();
        Outcome {
            schema: 1,
            end: match self.stage {
                Stage::Done(end) => end.word(),
                _ => End::Stopped.word(),
            },
            seconds: period.seconds() * self.sent.len() as f64,
            rate: 1.0 / period.seconds(),
            round_trip: Quantiles::of(self.round_trips.iter().map(|span| span.0).collect()),
            clock_error: clock.offset_error.map(Span::seconds),
            // when the partner sent its packets is not kept: in time, by its pace
            towards_here: towards_here.map(|ages| {
                let way = Way::new(&ages, |number| period.0.saturating_mul(number as i64));
                Way { overtaken: self.travels.overtaken, ..way }
            }),
            towards_partner: towards_partner.map(|ages| {
                Way::new(&ages, |number| self.sent.get(number).map_or(0, |sent| sent.0.cast_signed()))
            }),
            strange: self.strange,
            partner_runs_session: self.runs_session,
            paths: self
                .paths
                .iter()
                .map(|(time, event)| Path { time: (*time - first).seconds(), event: event.word() })
                .collect(),
        }
    }

    /// When something was sent or came last.
    fn latest(&self) -> LocalTime {
        self.heard.into_iter().chain(self.sent.last().copied()).max().unwrap_or_default()
    }

    /// The travels as ages, by what is known of the partner's clock at the end.
    fn ages(&self) -> Ages {
        let end = self.latest();
        let clock = self.clock.report(end);
        let Some(offset) = clock.offset else { return Ages::default() };
        let drift = clock.drift.map_or(0.0, |drift| drift.estimate);
        let start = self.sent.first().copied().unwrap_or(end);
        // the partner's clock minus this one when a packet was sent
        let at = |number: usize| {
            let since = Span(self.settings.period.0.saturating_mul(number as i64));
            let back = Span((start + since).0.cast_signed() - end.0.cast_signed());
            (offset + back.scaled(drift)).0
        };
        let shifted = |travels: Vec<Option<i64>>, sign: i64| {
            let age = |(number, travel): (usize, Option<i64>)| {
                // an age below 0 is the error of the clock
                travel.map(|travel: i64| travel.saturating_add(sign * at(number)).max(0))
            };
            travels.into_iter().enumerate().map(age).collect()
        };
        let reported = self.reported.as_ref();
        // a partner that fell silent has not told which packets were those of its measurement
        let heard = self.first_heard.map(|first| (first, self.travels.number_from(first)));
        let here = reported.map(|heard| (heard.first, heard.packets)).or(heard);
        Ages {
            towards_here: here.map(|(first, packets)| shifted(self.travels.from(first, packets), 1)),
            towards_partner: reported
                .and_then(|heard| heard.travels(self.sent.len()))
                .map(|travels| shifted(travels, -1)),
        }
    }

    /// Both ways in the form of IRTT (`irtt client -o`), which `telespring trace` reads: *send* is the way to the partner. `None`
    /// as long as one way is not known.
    pub fn trace(&self) -> Option<String> {
        let Ages { towards_here: Some(here), towards_partner: Some(there) } = self.ages() else {
            return None;
        };
        let trips = self.sent.iter().enumerate().map(|(number, sent)| {
            let [here, there] = [&here, &there].map(|ages| ages.get(number).copied().flatten());
            let lost = match (there, here) {
                (Some(_), Some(_)) => "false",
                (Some(_), None) => "true_down",
                (None, Some(_)) => "true_up",
                (None, None) => "true",
            };
            let mut delay = serde_json::Map::new();
            for (name, value) in [("send", there), ("receive", here)] {
                if let Some(value) = value {
                    delay.insert(name.to_owned(), value.into());
                }
            }
            if let (Some(there), Some(here)) = (there, here) {
                delay.insert("rtt".to_owned(), (there + here).into());
            }
            let stamp = serde_json::json!({ "client": { "send": { "monotonic": sent.0 } } });
            serde_json::json!({ "seqno": number, "lost": lost, "timestamps": stamp, "delay": delay })
        });
        let trips: Vec<_> = trips.collect();
        serde_json::to_string(
            &serde_json::json!({ "program": "telespring-link probe", "round_trips": trips }),
        )
        .ok()
    }
}
