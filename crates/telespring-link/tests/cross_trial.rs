//! Two sites over an ideal delayed wire in virtual time move as the laboratory's trial of the same study.

mod common;

use std::cell::Cell;
use std::rc::Rc;

use common::{PERIOD, VirtualClock, hman_study, wire};
use telespring::InvalidInput;
use telespring::rig::{ConnectedMode, Recording, Schedule, Status, Trial};
use telespring::session::{ClockSettings, Span};
use telespring::study::Study;
use telespring_link::device::Simulated;
use telespring_link::site::{Limits, Moment, Safety, Site, SiteSettings};

const SEED: u64 = 7;
const TICKS: usize = 3000;

/// The trial of a study.
fn trial(study: &Study) -> Recording {
    let laboratory = study.laboratory().unwrap();
    let coupling = study.coupling().unwrap();
    let mode = ConnectedMode {
        stiffness: coupling.stiffness,
        damping: coupling.damping,
        delay: study.network().unwrap().delay(),
    };
    let schedule = Schedule::new(TICKS as f64 * 1e-3, 1000.0, 1e-3).unwrap();
    let trial = Trial { laboratory: &laboratory, coupling: Some(mode), seed: SEED, schedule };
    let recording = trial.record::<InvalidInput>([None, None]).unwrap();
    assert_eq!(recording.outcome.status, Status::Completed);
    recording
}

/// Every tick of both sites from the first at which they are coupled.
fn live(study: &Study) -> Vec<[Moment; 2]> {
    let laboratory = study.laboratory().unwrap();
    let delay = study.network().unwrap().delay();
    let ends = wire((Span::from_seconds(delay.forward()) - PERIOD).max(Span(0)));
    let clock = VirtualClock(Rc::new(Cell::new(9_000_000_000)), Rc::default());
    let mut sites = [0, 1].map(|side| {
        let number = u8::try_from(side).unwrap() + 1;
        let settings = SiteSettings::new(study, number, 21 + side as u64, Safety::default()).unwrap();
        let mut settings = SiteSettings { limits: Limits::NONE, ..settings.simulated() };
        // as the laboratory has it: one clock, and a coupling that acts on however old a motion
        settings.endpoint.watchdog = None;
        settings.endpoint.clock = ClockSettings::default();
        let device = Simulated::new(&laboratory, side, SEED).unwrap();
        Site::new(settings, device, ends[side].clone()).unwrap()
    });
    let mut moments = Vec::new();
    let mut has_begun = false;
    while moments.len() <= TICKS {
        clock.0.set(clock.0.get() + 1_000_000);
        let both = sites.each_mut().map(|site| site.tick(&clock, false));
        if has_begun {
            moments.push(both);
        }
        let running = both.map(|moment| moment.phase.is_coupled());
        // both have agreed at the same tick, because the wire is alike both ways
        assert_eq!(running[0], running[1]);
        has_begun = running[0];
        assert!(clock.0.get() < 20_000_000_000, "the sites do not agree");
    }
    moments
}

/// The largest differences of position (m) and force (N), and how far the handles moved.
fn compare(study: &Study) -> [f64; 3] {
    let (recording, live) = (trial(study), live(study));
    let (mut position, mut force, mut travel) = (0.0_f64, 0.0_f64, 0.0_f64);
    for tick in 0..=TICKS {
        for side in 0..2 {
            let motion = live[tick][side].motion.unwrap();
            for axis in 0..2 {
                let there = recording.position[tick][side][axis];
                position = position.max((motion.position[axis] - there).abs());
                let felt = recording.coupling_force[tick][side][axis];
                force = force.max((live[tick][side].force[axis] - felt).abs());
                travel = travel.max(there.abs());
            }
        }
    }
    [position, force, travel]
}

#[test]
fn cross_two_live_sites_move_as_the_rehearsal() {
    // A trial counts its time in s, a site in ns: the last digit of a time differs, which a stable coupling forgets. Seen:
    // 1e-16 m and 4e-14 N.
    for lines in [
        "coupling.stiffness = 71.2\nnetwork.delay = 0.084",
        "coupling.stiffness = 142\nnetwork.delay = 0.0835955\nsession.strategy = \"guard\"",
        "coupling.stiffness = 142\nnetwork.delay = 0.05\n\
         session = {strategy = \"guard\", predictor = \"shared-target\", playout = \"adaptive\"}",
        "coupling.stiffness = 60\nnetwork.delay = 0.03\nsession.strategy = \"wave-variables\"",
        "coupling.stiffness = 60\nnetwork.delay = 0.001\ncoupling.damping = 1",
    ] {
        let [position, force, travel] = compare(&hman_study(lines));
        assert!(travel > 0.05, "{lines}: {travel}");
        assert!(position <= 1e-12 && force <= 1e-10, "{lines}: {position} m, {force} N");
    }
}

#[test]
fn cross_a_computing_tick_and_a_lag_are_those_of_the_rehearsal() {
    for lines in ["laboratory.computing_tick = true", "laboratory.actuator_lag = 0.005"] {
        let base = "coupling.stiffness = 142\nnetwork.delay = 0.05\nsession.strategy = \"guard\"";
        let [position, _, travel] = compare(&hman_study(&format!("{base}\n{lines}")));
        assert!(travel > 0.05 && position <= 1e-12, "{lines}: {position} m of {travel} m");
    }
}
