//! What was found, judged and put into words.

use telespring::session::Span;

use super::{Item, Seen, Verdict};
use crate::summary::{LatenessSummary, RealTime, Summary};
use crate::transport::PathEvent;

/// Overruns are missed ticks; above this share of them the coupling has another sample period than it says.
const MOST_OVERRUNS: f64 = 0.05;
/// A device may send at least this share of its rows.
const FEWEST_ROWS: f64 = 0.9;
/// Each row begins a tick, so more of them make the loop faster than the study says.
const MOST_ROWS: f64 = 1.1;
const CAPABILITIES: &str = "Run `setcap cap_sys_nice,cap_ipc_lock+ep` on the program, or start it as root.";

/// What the operating system granted.
pub(super) fn privileges(real_time: &RealTime) -> Item {
    let RealTime { priority, locked_memory, awake } = real_time;
    let found =
        format!("real-time priority {priority}, locked memory {locked_memory}, processors awake {awake}");
    if [*priority, *locked_memory].contains(&"refused") {
        let found = format!("{found}: a busy machine keeps the loop from its tick");
        return Item::wrong("privileges", Verdict::Warning, found, CAPABILITIES);
    }
    Item::fine("privileges", found)
}

/// How late the loop was.
pub(super) fn timing(lateness: &LatenessSummary, period: f64, stall: Span) -> Item {
    let LatenessSummary { ticks, quantile_99, largest, overruns, .. } = lateness;
    let found = format!(
        "{ticks} ticks, 99 % within {:.3} ms, the latest {:.3} ms late, {overruns} missed",
        1e3 * quantile_99,
        1e3 * largest
    );
    let missed = *overruns as f64 / (ticks + overruns).max(1) as f64;
    let remedy =
        "End other programs, give this one a real-time priority, or lengthen the study's sample period.";
    if *largest >= stall.seconds() {
        let found = format!(
            "{found}: it stood still for longer than safety.stall, {:.0} ms, and the force would have ramped out",
            1e3 * stall.seconds()
        );
        return Item::wrong("loop", Verdict::Failed, found, remedy);
    }
    if missed > MOST_OVERRUNS {
        return Item::wrong("loop", Verdict::Failed, found, remedy);
    }
    if *overruns > 0 || *quantile_99 > period / 4.0 {
        return Item::wrong("loop", Verdict::Warning, found, remedy);
    }
    Item::fine("loop", found)
}

/// What the device said in `seconds`.
pub(super) fn device(seen: &Seen, period: f64, seconds: f64) -> Item {
    let Some(first) = seen.first else {
        return Item::wrong(
            "device",
            Verdict::Failed,
            "no row of data came",
            "Start the device program; it sends from device.device to device.local (docs/device-protocol.md).",
        );
    };
    let heard = (seen.latest - first).seconds();
    let rate = if heard > 0.0 { (seen.rows - 1) as f64 / heard } else { 0.0 };
    let gap = 1e3 * seen.longest_gap.seconds();
    let found =
        format!("{rate:.0} rows per second over {heard:.1} of {seconds:.1} s, at most {gap:.1} ms apart");
    let wrong = |verdict, what: &str, remedy: &str| {
        Item::wrong("device", verdict, format!("{found}; {what}"), remedy)
    };
    if let Some(fault) = seen.fault {
        let remedy =
            "See that the device program goes on to send; device.deadline says how long it may be silent.";
        return wrong(Verdict::Failed, &fault.to_string(), remedy);
    }
    if seen.is_impossible {
        let remedy = "Mend the device program: positions and velocities are finite numbers, in m and m/s.";
        return wrong(Verdict::Failed, "a value was not finite", remedy);
    }
    if seen.is_stopped {
        return wrong(Verdict::Warning, "the emergency stop is pressed", "Release it before the session.");
    }
    if !seen.is_ready {
        let remedy =
            "Enable its motors and home it: places 10 (enabled) and 11 (homed) of its rows are then 1.";
        let what = match seen.lacks {
            Some(lacks) => format!("the robot is not ready: {lacks}"),
            None => "the robot is not ready".to_owned(),
        };
        return wrong(Verdict::Warning, &what, remedy);
    }
    if !(FEWEST_ROWS..=MOST_ROWS).contains(&(rate * period)) {
        let what = format!("the study has {:.0} sample periods per second", 1.0 / period);
        return wrong(Verdict::Warning, &what, "Send one row per sample period of the study.");
    }
    let force = if seen.has_force { "measured" } else { "not measured" };
    Item::fine("device", format!("{found}; ready; the force on the handle is {force}"))
}

/// Whether the partner is there, and agrees.
pub(super) fn partner(summary: &Summary) -> Item {
    let latest = summary.events.iter().rev().find(|entry| matches!(entry.event, "agreed" | "disagreed"));
    match latest {
        Some(entry) if entry.event == "agreed" => {
            Item::fine("partner", "it is there and agrees on every term")
        }
        Some(entry) => {
            let what = entry.cause.as_deref().unwrap_or("something");
            let remedy =
                entry.remedy.unwrap_or("Give both sites the same study and program, and each its own side.");
            Item::wrong("partner", Verdict::Failed, format!("it is there, and disagrees on: {what}"), remedy)
        }
        None => nobody(summary),
    }
}

/// Why nothing was heard of the partner, as far as the transport knows.
fn nobody(summary: &Summary) -> Item {
    let wrong = |verdict, found: &str, remedy: &str| Item::wrong("partner", verdict, found, remedy);
    let has = |event: PathEvent| summary.events.iter().any(|entry| entry.event == event.word());
    if has(PathEvent::Refused) {
        return wrong(
            Verdict::Failed,
            "it does not know the key of this site",
            "Let it write what telespring-link id prints here under network.peer_id of its site file.",
        );
    }
    if has(PathEvent::Withheld) && !has(PathEvent::Direct) {
        return wrong(
            Verdict::Failed,
            "it is reached over the relay only, and network.relayed is false here",
            "Open a port at one site, or allow packets over the relay at both (docs/network.md).",
        );
    }
    if summary.path.strangers > 0 {
        return wrong(
            Verdict::Warning,
            "no word from it yet, and somebody whose key is not in network.peer_id was refused",
            "Compare network.peer_id with what telespring-link id prints at the partner's site.",
        );
    }
    let found = match summary.loss.unreachable {
        0 => "no word from it yet",
        _ => "nobody listens at its address yet",
    };
    let remedy =
        "Start the partner's site, or its check; if it runs, check addresses and keys of both sites.";
    wrong(Verdict::Warning, found, remedy)
}

#[cfg(test)]
mod tests {
    use telespring::session::LocalTime;

    use super::*;
    use crate::device::Fault;

    fn lateness(quantile_99: f64, largest: f64, overruns: u64) -> LatenessSummary {
        LatenessSummary {
            ticks: 5000,
            median: 1e-5,
            quantile_99,
            quantile_999: largest,
            largest,
            overruns,
            followed: 0,
        }
    }

    #[test]
    fn law_a_loop_is_judged_by_its_period_and_by_the_time_that_the_force_may_stand() {
        let judged = |quantile_99, largest, overruns| {
            timing(&lateness(quantile_99, largest, overruns), 1e-3, Span(20_000_000)).verdict
        };
        assert_eq!(judged(1e-4, 5e-4, 0), Verdict::Ok);
        assert_eq!(judged(3e-4, 5e-4, 0), Verdict::Warning);
        assert_eq!(judged(1e-4, 1.5e-3, 1), Verdict::Warning);
        assert_eq!(judged(1e-4, 1.5e-3, 300), Verdict::Failed);
        assert_eq!(judged(1e-4, 0.02, 19), Verdict::Failed);
    }

    #[test]
    fn law_a_device_is_judged_by_what_it_lacks() {
        let good = Seen {
            rows: 5000,
            first: Some(LocalTime(0)),
            latest: LocalTime(4_999_000_000),
            is_ready: true,
            ..Seen::default()
        };
        let judged = |seen: Seen| {
            let item = device(&seen, 1e-3, 5.0);
            assert_eq!(item.remedy.is_none(), item.verdict == Verdict::Ok, "{item:?}");
            (item.verdict, item.found)
        };
        assert_eq!(judged(good).0, Verdict::Ok);
        for (seen, verdict, said) in [
            (Seen::default(), Verdict::Failed, "no row"),
            (Seen { fault: Some(Fault::Silent), ..good }, Verdict::Failed, "silent"),
            (Seen { is_impossible: true, ..good }, Verdict::Failed, "finite"),
            (Seen { is_stopped: true, ..good }, Verdict::Warning, "emergency stop"),
            (Seen { is_ready: false, ..good }, Verdict::Warning, "not ready"),
            (
                Seen { is_ready: false, lacks: Some("it naps"), ..good },
                Verdict::Warning,
                "not ready: it naps",
            ),
            (Seen { rows: 500, ..good }, Verdict::Warning, "100 rows per second"),
            (Seen { rows: 9000, ..good }, Verdict::Warning, "1800 rows per second"),
        ] {
            let (judged, found) = judged(seen);
            assert_eq!(judged, verdict, "{found}");
            assert!(found.contains(said), "{found}");
        }
    }

    #[test]
    fn law_a_privilege_that_was_refused_is_a_warning_and_one_that_nobody_wanted_is_none() {
        let judged = |priority, locked_memory| {
            privileges(&RealTime { priority, locked_memory, awake: "granted" }).verdict
        };
        assert_eq!(judged("granted", "granted"), Verdict::Ok);
        assert_eq!(judged("not-asked", "not-asked"), Verdict::Ok);
        assert_eq!(judged("refused", "granted"), Verdict::Warning);
        assert_eq!(judged("granted", "refused"), Verdict::Warning);
    }
}
