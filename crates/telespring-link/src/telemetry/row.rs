//! The row of a tick: what stands in which place.

use telespring::session::{Motion, Span, WatchdogState};

use crate::site::{Moment, Phase};

/// The version, the first value of every row.
pub const VERSION: f64 = 1.0;
/// Values in a row.
pub const VALUES: usize = 40;

/// What a place of a row holds, and its unit, in their order; the rest is not used and NaN.
pub const COLUMNS: [(&str, &str); 38] = [
    ("version", ""),
    ("sequence", ""),
    ("side", ""),
    ("time", "s"),
    ("phase", ""),
    ("watchdog", ""),
    ("measured", ""),
    ("position x", "m"),
    ("position y", "m"),
    ("velocity x", "m/s"),
    ("velocity y", "m/s"),
    ("partner position x", "m"),
    ("partner position y", "m"),
    ("partner velocity x", "m/s"),
    ("partner velocity y", "m/s"),
    ("target position x", "m"),
    ("target position y", "m"),
    ("target velocity x", "m/s"),
    ("target velocity y", "m/s"),
    ("force x", "N"),
    ("force y", "N"),
    ("measured force x", "N"),
    ("measured force y", "N"),
    ("stiffness wanted", "N/m"),
    ("stiffness in use", "N/m"),
    ("limited", ""),
    ("balance", "J"),
    ("age", "s"),
    ("silence", "s"),
    ("round trip", "s"),
    ("clock error", "s"),
    ("lateness", "s"),
    ("device delay", "s"),
    ("network delay", "s"),
    ("play-out delay", "s"),
    ("interval", "s"),
    ("missed", ""),
    ("marker", ""),
];

/// The number of a state of the session.
pub fn phase_code(phase: Phase) -> f64 {
    f64::from(phase.code())
}

/// The number of a state of the watchdog.
pub fn watchdog_code(state: WatchdogState) -> f64 {
    match state {
        WatchdogState::Disengaged { .. } => 0.0,
        WatchdogState::RampingIn => 1.0,
        WatchdogState::Engaged => 2.0,
        WatchdogState::Holding { .. } => 3.0,
        WatchdogState::RampingOut { .. } => 4.0,
    }
}

/// What a row says beside its moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Frame {
    pub(super) side: u8,
    /// The stiffness that the study wants, N/m.
    pub(super) stiffness: f64,
    /// From one row to the next, s.
    pub(super) interval: f64,
    /// Counts the rows.
    pub(super) sequence: u64,
    /// Items that this thread has missed.
    pub(super) missed: u64,
    /// The newest motion that the device reported.
    pub(super) motion: Option<Motion>,
}

impl Frame {
    /// The row of a moment.
    pub(super) fn row(&self, moment: &Moment, lateness: Span) -> [f64; VALUES] {
        let known = |value: Option<f64>| value.unwrap_or(f64::NAN);
        let motion = |motion: Option<Motion>| {
            motion.map_or([f64::NAN; 4], |Motion { position: [x, y], velocity: [u, v] }| [x, y, u, v])
        };
        let pair = |pair: Option<[f64; 2]>| pair.unwrap_or([f64::NAN; 2]);
        let is_coupled = moment.phase.is_coupled();
        let used = moment.used_partner();
        let clock = moment.session.clock;
        let latency = moment.latency(lateness);
        let mut row = [f64::NAN; VALUES];
        let mut places = row.iter_mut();
        let mut put =
            |values: &[f64]| values.iter().zip(&mut places).for_each(|(value, place)| *place = *value);
        put(&[VERSION, self.sequence as f64, f64::from(self.side), moment.time.seconds()]);
        put(&[
            phase_code(moment.phase),
            known(is_coupled.then(|| watchdog_code(moment.state))),
            f64::from(u8::from(moment.motion.is_some())),
        ]);
        put(&motion(self.motion));
        put(&motion(used.map(|used| used.wanted)));
        put(&motion(moment.target));
        put(&moment.force);
        put(&pair(moment.forces.measured));
        put(&[
            self.stiffness,
            moment.stiffness_in_use(),
            known(is_coupled.then(|| f64::from(u8::from(moment.is_limited())))),
            known(moment.balance),
            known(moment.age),
        ]);
        put(&[
            known(moment.heard.map(|heard| (moment.time - heard).seconds())),
            known(clock.round_trip.map(Span::seconds)),
            known(clock.offset_error.map(Span::seconds)),
        ]);
        put(&[lateness.seconds(), known(latency.device), known(latency.network), known(latency.playout)]);
        put(&[self.interval, self.missed as f64, f64::NAN]);
        row
    }
}

#[cfg(test)]
pub(super) mod tests {
    use telespring::session::clock::ClockReport;
    use telespring::session::strategy::{Outgoing, PartnerView};
    use telespring::session::watchdog::Cause;
    use telespring::session::{LocalTime, Packet, PeerTime, SessionSnapshot};

    use super::*;
    use crate::site::{Forces, Newest};

    const PAGE: &str = include_str!("../../../../docs/telemetry.md");

    pub(in crate::telemetry) fn moment() -> Moment {
        let partner = PartnerView {
            wanted: Motion { position: [13.0, 14.0], velocity: [15.0, 16.0] },
            played: Motion { position: [0.0; 2], velocity: [0.0; 2] },
            age: 12.0,
            fresh: true,
            signal: [0.0; 2],
            energy_sent: 0.0,
            stiffness: 0.0,
        };
        let packet = Packet::of(4, PeerTime(1_000_000_000), partner.played);
        let session = SessionSnapshot {
            partner: Some(partner),
            enabled: 1.0,
            outgoing: Outgoing { stiffness: 17.0, limited: true, ..Outgoing::default() },
            clock: ClockReport {
                round_trip: Some(Span(18_000_000_000)),
                offset: Some(Span(-500_000_000)),
                offset_error: Some(Span(19_000_000_000)),
                ..ClockReport::default()
            },
            ..SessionSnapshot::default()
        };
        Moment {
            tick: 2500,
            time: LocalTime(2_500_000_000),
            commanded: LocalTime(2_500_100_000),
            stamp: None,
            device_delay: Some(20.0),
            is_measured: true,
            is_timed: false,
            forces: Forces { measured: Some([21.0, 22.0]), ..Forces::default() },
            asked: Some(LocalTime(2_500_050_000)),
            newest: Some(Newest { arrival: LocalTime(2_000_000_000), packet }),
            session,
            wanted_stiffness: 100.0,
            unnoted_arrivals: 0,
            phase: Phase::Running,
            state: WatchdogState::Engaged,
            motion: Some(Motion { position: [1.0, 2.0], velocity: [3.0, 4.0] }),
            target: Some(Motion { position: [5.0, 6.0], velocity: [7.0, 8.0] }),
            force: [9.0, 10.0],
            balance: Some(11.0),
            age: Some(12.0),
            heard: Some(LocalTime(2_000_000_000)),
            offset: None,
            consents: [true; 2],
            pauses: [false; 2],
            round_trip: None,
            share: 1.0,
            is_cut: false,
        }
    }

    fn frame() -> Frame {
        Frame { side: 2, stiffness: 100.0, interval: 0.002, sequence: 7, missed: 3, motion: moment().motion }
    }

    /// The cells of the row of the page that begins with `place`.
    fn cells(place: &str) -> Vec<&'static str> {
        let line = PAGE.lines().find(|line| line.starts_with(&format!("| {place} |"))).unwrap();
        line.split('|').map(str::trim).collect()
    }

    /// "0 greeting, 1 running" as numbers and words.
    fn codes(text: &str) -> Vec<(f64, &str)> {
        let pairs = text.split(", ").map(|pair| pair.split_once(' ').unwrap());
        pairs.map(|(code, word)| (code.parse().unwrap(), word)).collect()
    }

    #[test]
    fn law_the_page_has_every_place() {
        for (place, (name, unit)) in COLUMNS.iter().enumerate() {
            assert_eq!(cells(&place.to_string())[2..4], [*name, *unit], "{place}");
        }
        assert_eq!(cells("38, 39")[2], "not used");
        assert_eq!(VALUES, 40);
        assert!(PAGE.contains(&format!(
            "{VALUES} little-endian doubles (IEEE 754), 8 bytes each, {} bytes",
            8 * VALUES
        )));
        let phases: Vec<_> = Phase::ALL.map(|phase| (phase_code(phase), phase.word())).into();
        assert_eq!(codes(cells("4")[4]), phases);
        let cause = Cause::Silence;
        let states = [
            (WatchdogState::Disengaged { cause }, "disengaged"),
            (WatchdogState::RampingIn, "ramping-in"),
            (WatchdogState::Engaged, "engaged"),
            (WatchdogState::Holding { cause }, "holding"),
            (WatchdogState::RampingOut { cause }, "ramping-out"),
        ];
        let states: Vec<_> = states.map(|(state, word)| (watchdog_code(state), word)).into();
        assert_eq!(codes(cells("5")[4]), states);
    }

    #[test]
    fn law_each_value_stands_in_its_place() {
        let row = frame().row(&moment(), Span(250_000));
        let value = |name: &str| row[COLUMNS.iter().position(|(column, _)| *column == name).unwrap()];
        for (name, expected) in [
            ("version", 1.0),
            ("sequence", 7.0),
            ("side", 2.0),
            ("time", 2.5),
            ("phase", 5.0),
            ("watchdog", 2.0),
            ("measured", 1.0),
            ("position x", 1.0),
            ("position y", 2.0),
            ("velocity x", 3.0),
            ("velocity y", 4.0),
            ("target position x", 5.0),
            ("target position y", 6.0),
            ("target velocity x", 7.0),
            ("target velocity y", 8.0),
            ("force x", 9.0),
            ("force y", 10.0),
            ("stiffness wanted", 100.0),
            ("partner position x", 13.0),
            ("partner position y", 14.0),
            ("partner velocity x", 15.0),
            ("partner velocity y", 16.0),
            ("measured force x", 21.0),
            ("measured force y", 22.0),
            ("stiffness in use", 17.0),
            ("limited", 1.0),
            ("round trip", 18.0),
            ("clock error", 19.0),
            ("device delay", 20.0),
            // sent at 1.5 s of this clock
            ("network delay", 0.5),
            ("play-out delay", 11.5),
            ("balance", 11.0),
            ("age", 12.0),
            ("silence", 0.5),
            ("lateness", 0.000_25),
            ("interval", 0.002),
            ("missed", 3.0),
        ] {
            assert_eq!(value(name), expected, "{name}");
        }
        assert!(row[COLUMNS.len()..].iter().all(|value| value.is_nan()));
    }

    /// Place, name and bytes of a row: `tests/telemetry_row.txt`, from which the tests of the drivers in Python read the same.
    #[test]
    fn law_a_row_has_the_bytes_that_the_drivers_read() {
        let row = frame().row(&moment(), Span(250_000));
        let lines = row.iter().enumerate().map(|(place, value)| {
            let name = COLUMNS.get(place).map_or("not used", |(name, _)| name);
            let bytes: String = value.to_le_bytes().iter().map(|byte| format!("{byte:02x}")).collect();
            format!("{place} {name}: {bytes}\n")
        });
        assert_eq!(lines.collect::<String>(), include_str!("../../../../tests/telemetry_row.txt"));
    }

    #[test]
    fn law_what_is_not_known_is_no_number() {
        let moment = Moment {
            phase: Phase::Connecting,
            motion: None,
            target: None,
            balance: None,
            age: None,
            heard: None,
            device_delay: None,
            asked: None,
            forces: Forces::default(),
            newest: None,
            session: SessionSnapshot::default(),
            ..moment()
        };
        let row = Frame { motion: None, ..frame() }.row(&moment, Span(0));
        for (name, value) in COLUMNS.iter().map(|(name, _)| *name).zip(row) {
            let known = [
                "version",
                "sequence",
                "side",
                "time",
                "phase",
                "measured",
                "force x",
                "force y",
                "stiffness wanted",
                "stiffness in use",
                "lateness",
                "interval",
                "missed",
            ];
            assert_eq!(!value.is_nan(), known.contains(&name), "{name} {value}");
        }
        // the newest motion stays
        let row = frame().row(&moment, Span(0));
        assert_eq!(row[6..11], [0.0, 1.0, 2.0, 3.0, 4.0]);
    }
}
