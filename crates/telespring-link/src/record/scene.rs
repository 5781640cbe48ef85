//! What the panels of a viewer read: poses, a frame, and events in words.

use foxglove::messages::log::Level;
use foxglove::messages::{FrameTransform, Log, Pose, PoseInFrame, Quaternion, Timestamp, Vector3};

use telespring::session::EventKind;

use super::messages::{Event, Pair};
use crate::site::Happened;
use crate::transport::PathEvent;

/// The frame of the study's axes.
const FRAME: &str = "study";
const UPRIGHT: Quaternion = Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 };

/// A date, from ns since 1970.
fn timestamp(date: u64) -> Timestamp {
    let seconds = u32::try_from(date / 1_000_000_000).unwrap_or(u32::MAX);
    Timestamp::new(seconds, u32::try_from(date % 1_000_000_000).unwrap_or(0))
}

/// A position in the plane of the study's axes.
pub(super) fn pose(position: Pair, date: u64) -> PoseInFrame {
    let Pair { x, y } = position;
    PoseInFrame {
        timestamp: Some(timestamp(date)),
        frame_id: FRAME.to_owned(),
        pose: Some(Pose { position: Some(Vector3 { x, y, z: 0.0 }), orientation: Some(UPRIGHT) }),
    }
}

/// The frame of a site, which is that of the study: a viewer shows a frame only if something names it.
pub(super) fn frame(site: &str, date: u64) -> FrameTransform {
    FrameTransform {
        timestamp: Some(timestamp(date)),
        parent_frame_id: FRAME.to_owned(),
        child_frame_id: site.to_owned(),
        translation: Some(Vector3 { x: 0.0, y: 0.0, z: 0.0 }),
        rotation: Some(UPRIGHT),
    }
}

/// An event in words.
pub(super) fn log(event: &Event, level: Level, site: &str, zero: u64) -> Log {
    let message = match &event.cause {
        Some(cause) => format!("{}: {cause}", event.event),
        None => event.event.clone(),
    };
    Log {
        timestamp: Some(timestamp(zero.saturating_add(event.time))),
        level: level.into(),
        message,
        name: site.to_owned(),
        file: String::new(),
        line: 0,
    }
}

/// How much something matters to whoever reads the log.
pub(super) fn level(happened: &Happened) -> Level {
    match happened {
        Happened::Disagreed(_)
        | Happened::EmergencyStop { .. }
        | Happened::NetworkPause(_)
        | Happened::ImpossibleValue { .. }
        | Happened::RecordingBroken => Level::Error,
        Happened::Interrupted(_)
        | Happened::ConsentLost
        | Happened::OrderRefused { .. }
        | Happened::Softened(_)
        | Happened::DeviceAwaited
        | Happened::PartnerAwaited
        | Happened::DelayTooShort { .. } => Level::Warning,
        Happened::Agreed { .. }
        | Happened::Entered(_)
        | Happened::Offset(_)
        | Happened::Consented
        | Happened::PartnerConsented
        | Happened::Cleared
        | Happened::Resumed
        | Happened::Mark(_)
        | Happened::Limiting(_)
        | Happened::Unlimited(_)
        | Happened::Restored
        | Happened::AxisLocked { .. }
        | Happened::Leaving(_)
        | Happened::Ended(_) => Level::Info,
        Happened::Path(event) => level_of_path(*event),
        Happened::Session(kind) => level_of_session(kind),
    }
}

fn level_of_path(event: PathEvent) -> Level {
    match event {
        PathEvent::Lost | PathEvent::Withheld | PathEvent::Refused => Level::Error,
        PathEvent::Changed | PathEvent::Relayed | PathEvent::Stranger | PathEvent::Rate { .. } => {
            Level::Warning
        }
        PathEvent::Direct => Level::Info,
    }
}

fn level_of_session(kind: &EventKind) -> Level {
    match kind {
        EventKind::ImpossibleValue { .. } | EventKind::ImpossibleForce => Level::Error,
        EventKind::PartnerFound { .. } | EventKind::RampingIn | EventKind::Engaged => Level::Info,
        // what takes the force, or puts a clock or a packet in doubt
        _ => Level::Warning,
    }
}

#[cfg(test)]
mod tests {
    use telespring::session::watchdog::Cause;

    use super::*;
    use crate::site::{Badness, Interruption};

    #[test]
    fn law_what_takes_the_force_stands_out_in_the_log() {
        for (happened, expected) in [
            (Happened::EmergencyStop { is_own: false }, Level::Error),
            (Happened::NetworkPause(Badness::Loss), Level::Error),
            (Happened::Interrupted(Interruption::PauseOrdered), Level::Warning),
            (Happened::Softened(Badness::Loss), Level::Warning),
            (Happened::Session(EventKind::Disengaged(Cause::Silence)), Level::Warning),
            (Happened::Session(EventKind::ImpossibleForce), Level::Error),
            (Happened::Path(PathEvent::Lost), Level::Error),
            (Happened::Path(PathEvent::Direct), Level::Info),
            (Happened::Consented, Level::Info),
        ] {
            assert_eq!(level(&happened), expected, "{happened:?}");
        }
    }
}
