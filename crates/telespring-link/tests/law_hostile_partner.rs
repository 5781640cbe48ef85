//! A partner that lies within the protocol, clocks that step and devices that fail, in virtual time: what the force did, and what was
//! recorded.

mod common;
mod dyad;
mod judge;

use common::{Pair, Script, hman_study};
use dyad::{Dyad, Lie, Tongue, lies};
use judge::{Rules, judge, largest_speed};
use telespring::session::watchdog::Cause;
use telespring::session::wire::Packet;
use telespring::session::{AccountSettings, EventKind, PeerTime, WatchdogState};
use telespring::study::Study;
use telespring_link::site::{Happened, LOG_CAPACITY, Moment, Safety};

const STIFFNESS: f64 = 142.0;
/// The damping of robot 1, N·s/m.
const DAMPING: [f64; 2] = [7.7257, 10.1168];
/// There, and as long back, s.
const DELAY: f64 = 0.02;

fn study(strategy: &str) -> Study {
    hman_study(&format!(
        "coupling.stiffness = {STIFFNESS}\nnetwork.delay = {DELAY}\n\
         session = {{strategy = \"{strategy}\", playout = \"adaptive\"}}"
    ))
}

/// The energy that a site gave out to its handle, J, and the most that the guard's account may have paid for: what it held, what
/// damping took, what the partner may send.
fn energy(record: &[Moment]) -> [f64; 2] {
    let AccountSettings { share, capacity, intake, .. } = AccountSettings::new(STIFFNESS, DAMPING);
    let (mut given, mut paid, mut most) = (0.0, capacity, 0.0_f64);
    for pair in record.windows(2) {
        let seconds = (pair[1].time - pair[0].time).seconds();
        let [from, to] = [pair[0].motion.unwrap().position, pair[1].motion.unwrap().position];
        for axis in 0..2 {
            let moved = to[axis] - from[axis];
            given += pair[0].force[axis] * moved;
            paid += share * DAMPING[axis] * moved * moved / seconds;
            // a held force, in one tick
            most = most.max(0.5 * STIFFNESS * moved * moved);
        }
        paid += intake * seconds;
        assert!(record[0].balance.is_none() || given <= paid + 2.0 * most, "{given} J of {paid} J: {pair:?}");
    }
    [given, paid]
}

/// What a record is judged by if the partner's handle had at most this speed, m/s; `None` if it says what it likes.
fn rules(speed: Option<f64>) -> Rules {
    Rules { safety: Safety::default(), stiffness: STIFFNESS, speed }
}

/// How often the endpoint of side 1 has recorded such an event.
fn count(dyad: &Dyad, is_wanted: impl Fn(&EventKind) -> bool) -> usize {
    let entries = dyad.sites[0].log().entries().iter();
    let kinds = entries.filter_map(|(_, happened)| match happened {
        Happened::Session(kind) => Some(kind),
        _ => None,
    });
    kinds.filter(|kind| is_wanted(kind)).count()
}

#[test]
fn law_whatever_a_partner_says_the_force_and_the_energy_stay_within_the_account() {
    for (name, tongue) in lies::ALL {
        let mut dyad = Dyad::engaged(&study("guard"));
        dyad.lie(tongue);
        dyad.run(8000);
        dyad.be_honest();
        dyad.run(6000);
        let record = &dyad.records[0];
        let findings = judge(record, &rules(None));
        let [given, paid] = energy(record);
        println!("{name}: {findings:?}, {given} J of {paid} J");
        // a lie is forgotten
        assert_eq!(record.last().unwrap().state, WatchdogState::Engaged, "{name}");
        assert!(dyad.sites[0].log().entries().len() <= LOG_CAPACITY, "{name}");
    }
}

#[test]
fn law_without_the_guard_a_lie_pumps_energy() {
    // what the law above would see if the guard did nothing
    let mut dyad = Dyad::engaged(&study("spring"));
    dyad.lie(lies::pump);
    dyad.run(3000);
    let [given, paid] = energy(&dyad.records[0]);
    assert!(given > paid, "{given} J of {paid} J");
}

#[test]
fn law_a_partner_whose_clock_is_set_gets_no_force_until_its_clock_is_known_again() {
    const HOUR: i64 = 3_600_000_000_000;
    fn shifted<const STEP: i64>(lie: &Lie) -> Vec<Packet> {
        vec![Packet { sent: PeerTime(lie.truth.sent.0.saturating_add_signed(STEP)), ..lie.truth }]
    }
    let steps: [(f64, Tongue); 4] = [
        (3600.0, shifted::<HOUR>),
        (0.3, shifted::<300_000_000>),
        (-0.3, shifted::<-300_000_000>),
        (-60.0, shifted::<-60_000_000_000>),
    ];
    for (step, tongue) in steps {
        let mut dyad = Dyad::engaged(&study("guard"));
        let before = dyad.records[0].len();
        dyad.lie(tongue);
        dyad.run(6000);
        let record = &dyad.records[0];
        let findings = judge(record, &rules(Some(largest_speed(&dyad.records[1]))));
        println!("{step} s: {findings:?}");
        let is_step =
            |kind: &EventKind| matches!(kind, EventKind::ClockStepped | EventKind::PartnerRestarted { .. });
        assert_eq!(count(&dyad, is_step), 1, "{step} s: {:?}", dyad.sites[0].log());
        assert!(idle_after(&record[before..]) <= 120, "{step} s");
        assert_eq!(record.last().unwrap().state, WatchdogState::Engaged, "{step} s");
        let age = record.last().unwrap().age.unwrap();
        assert!((age - DELAY).abs() <= DELAY, "{step} s: {age} s");
    }
}

/// Ticks until the force is zero, one per ms.
fn idle_after(record: &[Moment]) -> usize {
    record.iter().position(|moment| moment.force == [0.0; 2]).unwrap()
}

#[test]
fn law_a_site_that_stood_still_begins_from_zero() {
    // the machine was paused: its loop, its clock's reader and its person go on later
    for pause in [30_000_000, 300_000_000, 5_000_000_000] {
        let mut dyad = Dyad::engaged(&study("guard"));
        let before = dyad.records[1].len();
        dyad.offset = pause;
        dyad.run(6000);
        for side in 0..2 {
            let record = &dyad.records[side];
            let findings = judge(record, &rules(Some(largest_speed(&dyad.records[1 - side]))));
            println!("{pause} ns, site {}: {findings:?}", side + 1);
            assert_eq!(record.last().unwrap().state, WatchdogState::Engaged, "{pause} ns");
        }
        assert!(idle_after(&dyad.records[1][before..]) <= 100, "{pause} ns");
        let log = dyad.sites[1].log().entries();
        let lets_go = Happened::Session(EventKind::Disengaged(Cause::OwnSilence));
        assert!(log.iter().any(|(_, happened)| *happened == lets_go), "{pause} ns: {log:?}");
    }
}

#[test]
fn law_a_device_that_reports_nonsense_or_nothing_takes_the_force_along_a_ramp() {
    let nonsense = |script: &mut Script| script.position = [f64::NAN, 0.0];
    let nothing = |script: &mut Script| script.is_measured = false;
    type Change = fn(&mut Script);
    let faults: [(Change, Cause, usize); 2] =
        [(nonsense, Cause::OwnMeasurement, 85), (nothing, Cause::OwnSilence, 100)];
    for (fault, cause, longest) in faults {
        // 2 cm apart, and so 2 N
        let study =
            hman_study("coupling.stiffness = 100\nnetwork.delay = 0.02\nsession.strategy = \"guard\"");
        let mut pair = Pair::new([&study, &study], 0.02);
        pair.run(1500, |_, _| {});
        let good = pair.devices[0].0.get();
        pair.devices[0].change(fault);
        let mut record = Vec::new();
        pair.run(300, |pair, _| record.push(pair.moment(0)));
        let after = idle_after(&record);
        println!("{cause:?}: no force after {after} ms");
        assert!(after <= longest, "{cause:?}: {after} ms");
        pair.devices[0].change(|script| *script = Script { command: script.command, ..good });
        pair.run(1500, |pair, _| record.push(pair.moment(0)));
        judge(&record, &Rules { safety: Safety::default(), stiffness: 100.0, speed: Some(0.0) });
        assert_eq!(record.last().unwrap().state, WatchdogState::Engaged, "{cause:?}");
        let lets_go = Happened::Session(EventKind::Disengaged(cause));
        let log = pair.site_of(0).log().entries();
        assert!(log.iter().any(|(_, happened)| *happened == lets_go), "{cause:?}: {log:?}");
    }
}
