//! What happened, in words: the same in the summary, on the console and in a record.

use serde::Serialize;
use telespring::session::{EventKind, LocalTime, WatchdogState};

use super::remedies::remedy;
use crate::operator::Order;
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
    /// What to do about it, if somebody can.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub remedy: Option<&'static str>,
    /// The numbers of it; `docs/connect.md` says which.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub values: Option<[f64; 2]>,
}

impl Entry {
    /// What happened at `time`, counted from `first`.
    pub fn new(first: LocalTime, time: LocalTime, happened: &Happened) -> Self {
        let (event, cause) = event_words(happened);
        let values = match *happened {
            Happened::Offset(way) => Some(way),
            Happened::DelayTooShort { imposed, measured } => Some([imposed, measured]),
            _ => None,
        };
        let remedy = remedy(happened);
        Self { time: (time - first).seconds(), event, cause, remedy, values }
    }
}

/// What happened in a word, and why or with which value.
pub fn event_words(happened: &Happened) -> (&'static str, Option<String>) {
    let because = |word: &str| Some(word.to_owned());
    match happened {
        Happened::Agreed { session } => ("agreed", Some(format!("{session:#018x}"))),
        Happened::Disagreed(difference) => ("disagreed", Some(difference.to_string())),
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
        Happened::OrderRefused { order: Order::Unknown(text), .. } => {
            ("order-refused", Some(format!("no such order: {:?}", text.text())))
        }
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
        Happened::RecordingBroken => ("recording-broken", None),
        Happened::ImpossibleValue { what, value } => {
            ("impossible-value", Some(format!("{value} as the {what}")))
        }
        Happened::AxisLocked { axis, by } => ("axis-locked", Some(locked_in_words(*axis, *by))),
        Happened::DeviceAwaited => ("device-awaited", None),
        Happened::PartnerAwaited => ("partner-awaited", None),
        // a state of the session has the same word as what its watchdog does
        Happened::Session(kind @ EventKind::RampingIn) => ("force-ramping-in", kind.reason()),
        Happened::Session(kind @ EventKind::RampingOut(_)) => ("force-ramping-out", kind.reason()),
        Happened::Session(kind) => (kind.word(), kind.reason()),
    }
}

/// Which axis is left out of the coupling, and who wants it.
fn locked_in_words(axis: u8, by: [bool; 2]) -> String {
    let axis = if axis == 0 { "x" } else { "y" };
    let who = match by {
        [true, true] => "both sites",
        [true, false] => "this site",
        _ => "the partner",
    };
    format!("{axis}, by {who}")
}

/// The way that robot 2 has to go, or robot 1 the other way, in words: the same at both sites.
fn way_in_words(way: [f64; 2]) -> String {
    // a small way as exactly as it takes to say that there is one
    let farthest = 1e3 * way[0].abs().max(way[1].abs());
    let digits = [1.0, 0.1, 0.01].iter().filter(|least| farthest < **least).count();
    let zero = format!("{:.digits$}", 0.0);
    let go = |way: [f64; 2]| {
        let parts: Vec<String> = ["x", "y"]
            .into_iter()
            .zip(way.map(|value| format!("{:.digits$}", 1e3 * value)))
            .filter(|(_, millimetres)| millimetres.trim_start_matches('-') != zero)
            .map(|(axis, millimetres)| format!("{millimetres} mm in {axis}"))
            .collect();
        if parts.is_empty() { "a few micrometres".to_owned() } else { parts.join(" and ") }
    };
    let back = way.map(|value| -value);
    format!("move the handle of site 1 by {}, or that of site 2 by {}", go(back), go(way))
}

/// How much of the stream is sent from now on, if that is what a path event says.
fn path_cause(event: PathEvent) -> Option<String> {
    match event {
        PathEvent::Rate { every } => Some(format!("one packet of {every}")),
        _ => None,
    }
}

/// The state of the watchdog in a word, and why.
pub fn watchdog_words(state: WatchdogState) -> (&'static str, Option<&'static str>) {
    match state {
        WatchdogState::Disengaged { cause } => ("disengaged", Some(cause.word())),
        WatchdogState::RampingIn => ("ramping-in", None),
        WatchdogState::Engaged => ("engaged", None),
        WatchdogState::Holding { cause } => ("holding", Some(cause.word())),
        WatchdogState::RampingOut { cause } => ("ramping-out", Some(cause.word())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_every_event_of_the_path_is_documented() {
        let page = include_str!("../../../../docs/connect.md");
        let (rate, changed) = (PathEvent::Rate { every: 2 }, PathEvent::Changed);
        for event in [
            changed,
            PathEvent::Direct,
            PathEvent::Relayed,
            PathEvent::Withheld,
            rate,
            PathEvent::Refused,
            PathEvent::Stranger,
            PathEvent::Lost,
        ] {
            assert!(page.contains(&format!("`{}`", event.word())), "{event:?}");
        }
    }

    #[test]
    fn law_an_offset_says_who_has_to_move_how_far_and_where() {
        let entry = Entry::new(LocalTime(0), LocalTime(1_500_000_000), &Happened::Offset([-0.0342, 0.005]));
        assert_eq!((entry.time, entry.event, entry.values), (1.5, "offset", Some([-0.0342, 0.005])));
        assert_eq!(
            entry.cause.as_deref(),
            Some(
                "move the handle of site 1 by 34 mm in x and -5 mm in y, or that of site 2 by -34 mm in x and 5 mm in y"
            )
        );
        let entry = Entry::new(LocalTime(0), LocalTime(0), &Happened::Offset([0.0, 0.021]));
        assert_eq!(
            entry.cause.as_deref(),
            Some("move the handle of site 1 by -21 mm in y, or that of site 2 by 21 mm in y")
        );
        // an alignment may be as tight as one likes
        for (way, said) in [
            ([-4e-4, 0.0], "-0.4 mm in x"),
            ([2e-5, 3e-5], "0.02 mm in x and 0.03 mm in y"),
            ([0.0, 1e-7], "a few"),
        ] {
            let entry = Entry::new(LocalTime(0), LocalTime(0), &Happened::Offset(way));
            assert!(
                entry.cause.as_deref().is_some_and(|cause| cause.contains(&format!("by {said}"))),
                "{entry:?}"
            );
        }
    }
}
