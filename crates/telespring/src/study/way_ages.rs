//! The ages of the partner's motion over one way of a network, as a session plays it.
//!
//! A packet leaves at a tick, one every h, and is there at the first tick after `travel` to `travel` + `spread`. With up to
//! g lost in a row, the newest sample that is there is at most ⌈travel + spread⌉ + g h old, in whole periods. A play-out at
//! d plays what it has: exactly d where the sample of d and the next one are there; the last one before d where no later
//! one is; and between two, if those between them are missing: they are then at most (g + 1) h apart, on both sides of d.
//! Ages are those at the ticks; that a force is held for a period more is the verdicts' part.

use super::ages::{AgeSource, SourceSet};
use crate::rig::network::missing::LONGEST_GAP;
use crate::rig::{Adversary, NetworkModel, PacketOrder, Trace};
use crate::session::architecture::PlayoutDesign;
use crate::session::playout::Histogram;
use crate::session::{AdaptiveDelay, PlayoutSettings, Span};

/// Times that differ by less are the same, s.
const ROUNDING: f64 = 1e-9;

/// What a study says about one way of its network.
pub(super) struct WayFacts<'a> {
    /// The constant delay, s.
    pub delay: f64,
    /// The largest additional delay that is stated, s.
    pub jitter: f64,
    /// The longest wait for a newer sample that is stated, s.
    pub max_gap: f64,
    /// The time between two packets, s.
    pub period: f64,
    /// What the network does, without its trace.
    pub model: &'a NetworkModel,
    /// The recorded trace that is played, one way.
    pub trace: Option<&'a Trace>,
    /// Whether a fixed play-out without a delay of its own waits for jitter and gap.
    pub has_playout_buffer: bool,
    /// When a motion is played.
    pub playout: PlayoutDesign,
}

/// The ages that one way makes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum WayAges {
    /// As the study states them: delay, jitter and gap, or behind its buffer their sum.
    Stated,
    /// From `least` to `greatest`, s; the network may keep the delays in `lasting` for long.
    Within {
        /// Smallest age.
        least: f64,
        /// Largest age.
        greatest: f64,
        /// The shortest and the longest delay that may last, s.
        lasting: Option<[f64; 2]>,
    },
    /// Nothing bounds them.
    Unbounded,
}

/// When packets of a way arrive.
struct Arrivals {
    /// The shortest time on the way, s.
    travel: f64,
    /// The most that another packet takes longer, s.
    spread: f64,
    /// The longest time without a sample because of losses, s.
    lost: f64,
    /// Whether a packet may overtake an earlier one.
    may_overtake: bool,
    /// Whether the largest delay may last.
    may_last: bool,
}

/// A time in whole periods, rounded up.
fn up(time: f64, period: f64) -> f64 {
    ((time - ROUNDING) / period).ceil().max(0.0) * period
}

/// A time in whole periods, rounded down.
fn down(time: f64, period: f64) -> f64 {
    ((time + ROUNDING) / period).floor() * period
}

impl WayFacts<'_> {
    /// The age at which a fixed play-out plays, s, if the study chooses none other.
    fn usual_playout(&self) -> f64 {
        self.delay + if self.has_playout_buffer { self.jitter + self.max_gap } else { 0.0 }
    }

    /// The ages of the motion in use, and where they come from.
    pub fn ages(&self, sources: &mut SourceSet) -> WayAges {
        let Some(arrivals) = self.arrivals(sources) else { return WayAges::Unbounded };
        let gap = self.max_gap.max(arrivals.lost);
        if self.max_gap > 0.0 && arrivals.lost > self.max_gap + ROUNDING {
            sources.add(AgeSource::GapTooShort);
        }
        let found = match self.playout {
            PlayoutDesign::Fixed { delay } => {
                let played = delay.unwrap_or_else(|| self.usual_playout());
                if (played - self.usual_playout()).abs() > ROUNDING {
                    sources.add(AgeSource::Playout);
                } else if self.is_as_stated(&arrivals) {
                    return WayAges::Stated;
                }
                self.played_at(played, &arrivals, gap)
            }
            PlayoutDesign::Adaptive(adaptive) => {
                sources.add(AgeSource::AdaptivePlayout);
                self.followed(&adaptive, &arrivals, gap)
            }
        };
        match found {
            WayAges::Within { greatest, .. } if greatest > LONGEST_GAP => WayAges::Unbounded,
            found => self.with_what_is_stated(found),
        }
    }

    /// When the packets arrive; `None` if nothing bounds that.
    fn arrivals(&self, sources: &mut SourceSet) -> Option<Arrivals> {
        let Self { model, period, .. } = *self;
        for (is_there, source) in [
            (model.loss > 0.0, AgeSource::Loss),
            (model.burst.is_some_and(|burst| burst.loss() > 0.0), AgeSource::Burst),
            (model.blackout.is_some_and(|blackout| blackout.duration > 0.0), AgeSource::Blackout),
            (model.rate.is_some(), AgeSource::Rate),
            (model.adversary.is_some(), AgeSource::Adversary),
            (self.trace.is_some(), AgeSource::Trace),
        ] {
            if is_there {
                sources.add(source);
            }
        }
        // it takes packets, and hands them over, at ticks
        let withheld = up(withheld_time(model)?, period);
        let lost = model.longest_loss(period)? as f64 * period;
        let [service, queue] = link_times(model, period);
        if service > period * (1.0 + ROUNDING) {
            sources.add(AgeSource::RateBelowNeed);
        }
        if let Some(trace) = self.trace {
            return self.recorded_arrivals(trace, lost, service, queue, withheld);
        }
        Some(Arrivals {
            travel: (self.delay - period).max(0.0) + service,
            spread: self.jitter + queue + withheld,
            lost,
            may_overtake: model.order == PacketOrder::Any && self.jitter > period,
            may_last: queue == 0.0 && withheld == 0.0,
        })
    }

    /// The same over a recorded trace; `None` beside other losses, with which those of the trace may join to longer rows.
    fn recorded_arrivals(
        &self,
        trace: &Trace,
        lost: f64,
        service: f64,
        queue: f64,
        withheld: f64,
    ) -> Option<Arrivals> {
        if lost > 0.0 || queue > 0.0 {
            return None;
        }
        let came = || trace.rows().iter().filter(|row| !row.lost);
        let [least, most] = came().fold([f64::INFINITY, 0.0], |[least, most]: [f64; 2], row| {
            [least.min(row.delay), most.max(row.delay)]
        });
        // from one packet that came to the next, once round
        let mut longest: f64 = 0.0;
        let mut last: Option<f64> = None;
        let again = came().map(|row| row.time + trace.duration());
        for time in came().map(|row| row.time).chain(again) {
            longest = longest.max(time - last.unwrap_or(time));
            last = Some(time);
        }
        let has_lost = trace.rows().iter().any(|row| row.lost);
        Some(Arrivals {
            travel: least + service,
            spread: most - least + withheld,
            lost: if has_lost { up(longest, self.period) } else { 0.0 },
            may_overtake: self.model.order == PacketOrder::Any && most - least > self.period,
            may_last: false,
        })
    }

    /// The age of the newest sample that is there if none is lost, at most, s.
    fn latest(&self, arrivals: &Arrivals) -> f64 {
        let latest = up(arrivals.travel + arrivals.spread, self.period);
        // the delay that is stated counts, also where no sample has exactly this age
        if self.trace.is_some() { latest } else { latest.max(self.delay + arrivals.spread) }
    }

    /// Whether delay, jitter and gap are all that there is: nothing of the network's losses, rate or recording.
    fn is_as_stated(&self, arrivals: &Arrivals) -> bool {
        self.is_plain(arrivals) && self.latest(arrivals) <= self.delay + self.jitter + ROUNDING
    }

    /// Whether the network does nothing but delay packets, by the delay and up to the jitter.
    fn is_plain(&self, arrivals: &Arrivals) -> bool {
        self.trace.is_none()
            && self.model.rate.is_none()
            && self.model.adversary.is_none()
            && arrivals.lost == 0.0
    }

    /// The ages behind a fixed play-out at `played` s.
    fn played_at(&self, played: f64, arrivals: &Arrivals, gap: f64) -> WayAges {
        let Arrivals { travel, spread, lost, may_overtake, may_last } = *arrivals;
        let is_in_time = travel + spread + self.max_gap <= down(played, self.period) + ROUNDING;
        let latest = self.latest(arrivals);
        if is_in_time && lost == 0.0 {
            let lasting = Some([played; 2]);
            return WayAges::Within { least: played, greatest: played, lasting };
        }
        if let Some(ages) = self.recorded_ages(played) {
            return ages;
        }
        let least = if may_overtake && !is_in_time && self.is_plain(arrivals) && played >= self.delay {
            // as stated: a neighbour of what is played may be a period younger
            self.delay
        } else if may_overtake && !is_in_time {
            travel
        } else if lost > 0.0 {
            travel.max(played - lost - self.period)
        } else {
            travel.max(played)
        };
        let across = if lost > 0.0 { played + gap + self.period } else { played };
        let lasting = may_last.then(|| [played.max(travel), played.max(travel + spread)]);
        WayAges::Within {
            least,
            greatest: across.max(latest + gap),
            lasting: if self.trace.is_some() { None } else { lasting },
        }
    }

    /// The ages of a recording as a fixed play-out plays it; `None` where something else comes on top.
    fn recorded_ages(&self, played: f64) -> Option<WayAges> {
        let trace = self.trace?;
        let is_alone = self.model.rate.is_none()
            && self.model.adversary.is_none()
            && self.model.order == PacketOrder::Any;
        if !is_alone {
            return None;
        }
        let [least, greatest] = trace.play(played, self.period).ok()?.ages();
        Some(WayAges::Within { least, greatest, lasting: None })
    }

    /// The ages behind a play-out that follows the network.
    fn followed(&self, adaptive: &AdaptiveDelay, arrivals: &Arrivals, gap: f64) -> WayAges {
        let Arrivals { travel, spread, mut lost, may_overtake, may_last } = *arrivals;
        let wanted = |age: f64| {
            let wanted = age + self.period + adaptive.margin.seconds();
            wanted.min(adaptive.largest.seconds()).max(adaptive.smallest.seconds())
        };
        let latest = self.latest(arrivals);
        // its quantile of the ages is that of a histogram, a little larger
        let longest = wanted(Histogram::largest_quantile(Span::from_seconds(latest)).seconds());
        let shortest = wanted(travel);
        // Packets that come all at once after a wait may be more than the play-out holds; the newest are then lost.
        let mut gap = gap;
        let waiting = longest.max(latest + gap);
        let settings = PlayoutSettings::Adaptive(*adaptive);
        let holds = settings.capacity(Span::from_seconds(self.period)).unwrap_or(0) as f64;
        if waiting / self.period + 2.0 > holds {
            (lost, gap) = (lost + waiting, gap + waiting);
        }
        let least = if may_overtake || lost > 0.0 { travel } else { travel.max(shortest) };
        let across = if lost > 0.0 { gap + self.period } else { 0.0 };
        let lasting = may_last.then(|| [shortest.max(travel), wanted(travel + spread).max(travel + spread)]);
        WayAges::Within {
            least,
            greatest: longest.max(latest + gap) + across,
            lasting: if self.trace.is_some() { None } else { lasting },
        }
    }

    /// These ages together with those that jitter and gap state beside a recorded trace, for the verdicts.
    fn with_what_is_stated(&self, found: WayAges) -> WayAges {
        let WayAges::Within { least, greatest, lasting } = found else { return found };
        if self.trace.is_none() || (self.jitter == 0.0 && self.max_gap == 0.0) || self.has_playout_buffer {
            return found;
        }
        let latest = self.delay + self.jitter + self.max_gap;
        WayAges::Within { least: least.min(self.delay), greatest: greatest.max(latest), lasting }
    }
}

/// How much older than delay, jitter and gap a motion may become on a way with these losses, link and adversary, one packet
/// every `period`, s; `None` if nothing bounds it.
pub(super) fn missing_time(model: &NetworkModel, period: f64) -> Option<f64> {
    let lost = model.longest_loss(period)? as f64 * period;
    let withheld = withheld_time(model)?;
    let [service, queue] = link_times(model, period);
    Some(service + queue + withheld + if lost > 0.0 { lost + period } else { 0.0 })
}

/// How long an adversary withholds packets, s; `None` if it forges them.
fn withheld_time(model: &NetworkModel) -> Option<f64> {
    match model.adversary {
        None => Some(0.0),
        Some(Adversary::StretchTimed { longest }) => Some(longest),
        Some(_) => None,
    }
}

/// The time of a packet on the link of limited rate, and the longest in its queue, s.
fn link_times(model: &NetworkModel, period: f64) -> [f64; 2] {
    let Some(rate) = model.rate else { return [0.0; 2] };
    let service = rate.service_time();
    let fills = service > period * (1.0 + ROUNDING);
    [service, if fills { rate.queue as f64 * service } else { 0.0 }]
}
