//! What the panels of a viewer read: poses, a frame, and events in words.

use foxglove::messages::log::Level;
use foxglove::messages::{FrameTransform, Log, Pose, PoseInFrame, Quaternion, Timestamp, Vector3};

use super::messages::{Event, Pair};

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
pub(super) fn log(event: &Event, site: &str, zero: u64) -> Log {
    let message = match &event.cause {
        Some(cause) => format!("{}: {cause}", event.event),
        None => event.event.clone(),
    };
    Log {
        timestamp: Some(timestamp(zero.saturating_add(event.time))),
        level: level(&event.event).into(),
        message,
        name: site.to_owned(),
        file: String::new(),
        line: 0,
    }
}

/// How much an event matters.
fn level(event: &str) -> Level {
    match event {
        "holding" | "ramping-out" | "disengaged" | "partner-restarted" | "clock-stepped"
        | "datagram-refused" | "path-changed" | "recording-missed" => Level::Warning,
        "disagreed" | "impossible-value" | "impossible-force" | "path-lost" | "recording-broken" => {
            Level::Error
        }
        _ => Level::Info,
    }
}
