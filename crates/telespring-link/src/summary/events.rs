//! What happened, in words: the same in the summary, on the console and in a record.

use serde::Serialize;
use telespring::session::LocalTime;
use telespring::session::event::EventKind;
use telespring::session::watchdog::Cause as Fault;

use crate::site::Happened;
use crate::transport::PathEvent;

/// Something that happened.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Entry {
    /// When, s since the first tick.
    pub time: f64,
    /// What.
    pub event: &'static str,
    /// Why, or what exactly.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cause: Option<String>,
    /// The numbers of it; `docs/connect.md` says which.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub values: Option<[f64; 2]>,
}

impl Entry {
    /// What happened at `time`, counted from `first`.
    pub fn new(first: LocalTime, time: LocalTime, happened: &Happened) -> Self {
        let (event, cause) = words(happened);
        let values = match *happened {
            Happened::Offset(way) => Some(way),
            Happened::DelayTooShort { imposed, measured } => Some([imposed, measured]),
            _ => None,
        };
        Self { time: (time - first).seconds(), event, cause, values }
    }
}

/// What happened, in a word, and why.
fn words(happened: &Happened) -> (&'static str, Option<String>) {
    let because = |word: &str| Some(word.to_owned());
    match happened {
        Happened::Agreed { session } => ("agreed", Some(format!("{session:#018x}"))),
        Happened::Disagreed(disagreement) => ("disagreed", because(disagreement.word())),
        Happened::Entered(phase) => ("phase", because(phase.word())),
        Happened::Offset(way) => ("offset", Some(way_in_words(*way))),
        Happened::Consented => ("consented", None),
        Happened::ConsentLost => ("consent-lost", None),
        Happened::PartnerConsented => ("partner-consented", None),
        Happened::Interrupted(interruption) => ("interrupted", because(interruption.word())),
        Happened::EmergencyStop { is_own } => {
            ("emergency-stop", because(if *is_own { "here" } else { "partner" }))
        }
        Happened::Cleared => ("cleared", None),
        Happened::Resumed => ("resumed", None),
        Happened::OrderRefused { order, phase } => {
            ("order-refused", Some(format!("{} while {}", order.word(), phase.word())))
        }
        Happened::Mark(mark) => ("mark", Some(format!("{} {}", mark.kind.word(), mark.label.text()))),
        Happened::Limiting(limit) => ("limiting", because(limit.word())),
        Happened::Unlimited(limit) => ("limiting-over", because(limit.word())),
        Happened::Softened(badness) => ("softened", because(badness.word())),
        Happened::Restored => ("restored", None),
        Happened::NetworkPause(badness) => ("network-pause", because(badness.word())),
        Happened::DelayTooShort { imposed, measured } => {
            let text =
                format!("{:.1} ms are imposed, the network takes {:.1} ms", 1e3 * imposed, 1e3 * measured);
            ("delay-too-short", Some(text))
        }
        Happened::Leaving(cause) => ("leaving", because(cause.word())),
        Happened::Ended(cause) => ("ended", because(cause.word())),
        Happened::Path(event) => (event.word(), path_cause(*event)),
        Happened::Session(kind) => session_event(kind),
    }
}

/// The way that robot 2 has to go, in words.
fn way_in_words(way: [f64; 2]) -> String {
    let parts: Vec<String> = ["x", "y"]
        .into_iter()
        .zip(way.map(|value| (1e3 * value).round()))
        .filter(|(_, millimetres)| *millimetres != 0.0)
        .map(|(axis, millimetres)| format!("{millimetres:.0} mm in {axis}"))
        .collect();
    format!("move the handle of site 2 by {}", parts.join(" and "))
}

/// How much of the stream is sent from now on, if that is what a path event says.
fn path_cause(event: PathEvent) -> Option<String> {
    match event {
        PathEvent::Rate { every } => Some(format!("one packet of {every}")),
        _ => None,
    }
}

/// An event of the endpoint, in a word, and why.
fn session_event(kind: &EventKind) -> (&'static str, Option<String>) {
    let because = |cause: &Fault| Some(fault(*cause).to_owned());
    match kind {
        EventKind::PartnerFound { session } => ("partner-found", Some(format!("{session:#018x}"))),
        EventKind::PartnerRestarted { session } => ("partner-restarted", Some(format!("{session:#018x}"))),
        EventKind::Holding(cause) => ("holding", because(cause)),
        EventKind::RampingOut(cause) => ("ramping-out", because(cause)),
        EventKind::Disengaged(cause) => ("disengaged", because(cause)),
        EventKind::RampingIn => ("ramping-in", None),
        EventKind::Engaged => ("engaged", None),
        EventKind::Refused(refusal) => ("datagram-refused", Some(refusal.to_string())),
        EventKind::ImpossibleValue { value } => ("impossible-value", Some(value.to_string())),
        EventKind::ClockStepped => ("clock-stepped", None),
        EventKind::ImpossibleForce => ("impossible-force", None),
        _ => ("other", None),
    }
}

/// A cause of the watchdog in a word.
fn fault(cause: Fault) -> &'static str {
    match cause {
        Fault::Starting => "starting",
        Fault::Silence => "silence",
        Fault::FrozenStamps => "frozen-stamps",
        Fault::FrozenMotion => "frozen-motion",
        Fault::PartnerRestarted => "partner-restarted",
        Fault::ClockStepped => "clock-stepped",
        Fault::OwnMeasurement => "own-measurement",
        Fault::OwnSilence => "own-silence",
        _ => "other",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_an_offset_says_who_has_to_move_how_far_and_where() {
        let entry = Entry::new(LocalTime(0), LocalTime(1_500_000_000), &Happened::Offset([-0.0342, 0.005]));
        assert_eq!((entry.time, entry.event, entry.values), (1.5, "offset", Some([-0.0342, 0.005])));
        assert_eq!(entry.cause.as_deref(), Some("move the handle of site 2 by -34 mm in x and 5 mm in y"));
        let entry = Entry::new(LocalTime(0), LocalTime(0), &Happened::Offset([0.0, 0.021]));
        assert_eq!(entry.cause.as_deref(), Some("move the handle of site 2 by 21 mm in y"));
    }
}
