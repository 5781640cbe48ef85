//! What a recording says of its session beside the messages.

use std::collections::BTreeMap;
use std::time::{SystemTime, UNIX_EPOCH};

use telespring::session::{ClockSettings, WatchdogSettings};
use telespring::study::Study;

use crate::clock::{Clock, MonotonicClock};
use crate::site::{Safety, SiteSettings};

/// The version of the format.
const FORMAT: u32 = 1;

/// Names and values of one record.
pub(super) type Record = BTreeMap<String, String>;

/// What a recording says of its session.
#[derive(Debug, Clone)]
pub struct Facts {
    /// The robot of the study, 1 or 2.
    pub side: u8,
    /// The id of the session.
    pub session: u64,
    /// The date at which the monotonic clock reads 0, ns since 1970.
    pub zero: u64,
    /// The study, as TOML.
    pub study: String,
    /// The metadata: records by name.
    pub(super) records: BTreeMap<&'static str, Record>,
}

/// The date at which the monotonic clock reads 0, as the date is set now.
fn zero() -> u64 {
    let date = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |date| date.as_nanos());
    u64::try_from(date).unwrap_or(u64::MAX).saturating_sub(MonotonicClock.now().0)
}

fn record<const N: usize>(entries: [(&str, String); N]) -> Record {
    entries.map(|(key, value)| (key.to_owned(), value)).into()
}

impl Facts {
    /// The facts of a site of a study, whose monotonic clock is tied to the date now.
    pub fn new(study: &Study, settings: &SiteSettings) -> Self {
        let (side, session, zero) = (settings.terms.side, settings.endpoint.session, zero());
        let telespring = record([
            ("format_version", FORMAT.to_string()),
            ("program_version", env!("CARGO_PKG_VERSION").to_owned()),
            ("side", side.to_string()),
            ("session", format!("{session:#018x}")),
            ("wall_time_zero", zero.to_string()),
            ("study", study.name().to_owned()),
        ]);
        let Safety { silence, stall, ramp_out } = settings.safety;
        let limits = settings.limits;
        let mut safety = record([
            ("force", limits.force.to_string()),
            ("rise", limits.rise.to_string()),
            ("velocity", limits.velocity.to_string()),
            ("scale", limits.scale.to_string()),
            ("lock_x", limits.lock[0].to_string()),
            ("lock_y", limits.lock[1].to_string()),
            ("silence_ns", silence.0.to_string()),
            ("stall_ns", stall.0.to_string()),
            ("ramp_out_ns", ramp_out.0.to_string()),
        ]);
        for (axis, [least, most]) in ["x", "y"].into_iter().zip(limits.workspace) {
            safety.insert(format!("workspace_{axis}_least"), least.to_string());
            safety.insert(format!("workspace_{axis}_most"), most.to_string());
        }
        let records =
            [("telespring", telespring), ("endpoint", endpoint(settings)), ("safety", safety)].into();
        Self { side, session, zero, study: study.to_toml(), records }
    }

    /// Adds an entry to the record `telespring`.
    #[must_use]
    pub fn with(mut self, key: &str, value: &str) -> Self {
        self.records.entry("telespring").or_default().insert(key.to_owned(), value.to_owned());
        self
    }
}

/// What the endpoint was made with beside the study.
fn endpoint(settings: &SiteSettings) -> Record {
    let endpoint = &settings.endpoint;
    let mut entries = record([
        ("sample_period_ns", endpoint.sample_period.0.to_string()),
        ("computing_tick", endpoint.computing_tick.to_string()),
    ]);
    if let ClockSettings::Estimated { max_drift, window } = endpoint.clock {
        entries.extend(record([
            ("clock_max_drift", max_drift.to_string()),
            ("clock_window_ns", window.0.to_string()),
        ]));
    }
    if let Some(watchdog) = endpoint.watchdog {
        let WatchdogSettings {
            silence,
            frozen,
            frozen_distance,
            hold,
            own_silence,
            own_hold,
            ramp_out,
            ramp_in,
            recovery,
        } = watchdog;
        entries.insert("frozen_distance".to_owned(), frozen_distance.to_string());
        for (key, span) in [
            ("silence_ns", silence),
            ("frozen_ns", frozen),
            ("hold_ns", hold),
            ("own_silence_ns", own_silence),
            ("own_hold_ns", own_hold),
            ("ramp_out_ns", ramp_out),
            ("ramp_in_ns", ramp_in),
            ("recovery_ns", recovery),
        ] {
            entries.insert(key.to_owned(), span.0.to_string());
        }
    }
    entries
}
