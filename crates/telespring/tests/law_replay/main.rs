//! A replayed session reproduces itself, and under another strategy it is what that strategy makes of it.

mod live;

use live::{LARGEST, Mover, SESSIONS, Side, endpoints, live, study};
use telespring::rig::replay::{
    Acted, ForceLimits, RecordedArrival, RecordedSite, RecordedTick, ReplaySettings, ReplayedSite,
    replay_pair, replay_site,
};
use telespring::session::{EventKind, LocalTime, Motion, Packet};
use telespring::study::Study;

const TICKS: usize = 2900;

/// Every strategy, every predictor and both play-outs, a computing tick, and a coupling damper.
const SESSIONS_OF_STUDIES: [&str; 13] = [
    "session.strategy = \"spring\"\ncoupling.damping = 1",
    "session.strategy = \"guard\"",
    "session.strategy = \"guard\"\nlaboratory.computing_tick = true",
    "session = {strategy = \"guard\", predictor = \"linear\"}",
    "session = {strategy = \"guard\", predictor = \"kalman\"}",
    "session = {strategy = \"guard\", predictor = \"shared-target\"}",
    "session = {strategy = \"guard\", playout = \"adaptive\"}",
    "session = {strategy = \"spring\", playout = {kind = \"fixed\", delay = 0.07}}",
    "session.strategy = \"injected-damping\"",
    "session.strategy = \"wave-variables\"",
    "session.strategy = \"time-domain-passivity\"",
    "session.strategy = \"two-layer\"",
    "session.strategy = \"set-position-modulation\"",
];

fn study_of(lines: &str) -> Study {
    study(&format!("coupling.stiffness = 60\nnetwork.delay = 0.045\n{lines}"))
}

fn settings(study: &Study, acted: Acted) -> [ReplaySettings; 2] {
    let limits = ForceLimits { largest: LARGEST, ..ForceLimits::NONE };
    endpoints(study).map(|endpoint| ReplaySettings { endpoint, acted, limits })
}

/// Asserts that a replay is the live site, bit for bit.
fn assert_same(replayed: &ReplayedSite, site: &Side, lines: &str) {
    let bits = |force: [f64; 2]| force.map(f64::to_bits);
    for (tick, (replayed, ([wanted, force], age))) in
        replayed.ticks.iter().zip(site.forces.iter().zip(&site.ages)).enumerate()
    {
        assert_eq!(bits(replayed.wanted), bits(*wanted), "{lines}, tick {tick}");
        assert_eq!(bits(replayed.force), bits(*force), "{lines}, tick {tick}");
        assert_eq!(replayed.age, *age, "{lines}, tick {tick}");
    }
    assert_eq!(replayed.ticks.len(), site.forces.len());
    assert_eq!(replayed.report, site.endpoint.report(), "{lines}");
    // written out, because an event may have a NaN
    assert_eq!(format!("{:?}", replayed.events), format!("{:?}", site.events), "{lines}");
    assert_eq!(replayed.missed_events, 0);
}

/// The session was one: forces acted, the limit cut them, the cut way was noticed.
fn assert_eventful(sites: &[Side; 2]) {
    let largest = |side: &Side, which: usize| {
        side.forces.iter().map(|forces| forces[which][0].hypot(forces[which][1])).fold(0.0, f64::max)
    };
    assert!(largest(&sites[0], 0) > 0.05 && largest(&sites[0], 1) <= LARGEST + 1e-9);
    let rampings = |event: &&telespring::session::Event| matches!(event.kind, EventKind::RampingOut(_));
    assert!(sites[1].events.iter().any(|event| rampings(&event)), "the cut way");
    assert!(sites[0].events.iter().any(|event| matches!(event.kind, EventKind::ImpossibleValue { .. })));
    assert!(sites[0].events.iter().any(|event| matches!(event.kind, EventKind::Refused(_))));
}

#[test]
fn cross_a_replayed_session_reproduces_itself() {
    let mut is_cut = false;
    for lines in SESSIONS_OF_STUDIES {
        let study = study_of(lines);
        let sites = live(&study, TICKS, &Mover::Robots);
        assert_eventful(&sites);
        is_cut |= sites.iter().any(|site| site.given.ticks().iter().any(|tick| tick.acted.is_some()));
        for (side, settings) in settings(&study, Acted::Recorded).into_iter().enumerate() {
            let replayed = replay_site(settings, &sites[side].given).unwrap();
            assert_same(&replayed, &sites[side], lines);
            assert_eq!(replayed.renewed, 0);
        }
        // of both sides, with either force told: what the gate let through is known
        for acted in [Acted::Recorded, Acted::Replayed] {
            let recordings = [&sites[0].given, &sites[1].given];
            let replayed = replay_pair(settings(&study, acted), recordings).unwrap();
            for (replayed, site) in replayed.iter().zip(&sites) {
                assert_same(replayed, site, lines);
                let packets = site.given.arrivals().iter().filter(|arrival| arrival.datagram[0] != 7);
                assert_eq!(replayed.renewed, packets.count(), "{lines}");
            }
        }
    }
    assert!(is_cut, "no gate changed a force");
}

#[test]
fn cross_another_strategy_is_what_its_endpoints_make_of_the_motion() {
    let spring = live(&study_of(SESSIONS_OF_STUDIES[0]), TICKS, &Mover::Robots);
    let recordings = [&spring[0].given, &spring[1].given];
    for lines in &SESSIONS_OF_STUDIES[1..] {
        for stiffness in ["", "coupling.stiffness = 30\n"] {
            let base = if stiffness.is_empty() { "coupling.stiffness = 60\n" } else { stiffness };
            let other = study(&format!("{base}network.delay = 0.045\n{lines}"));
            // the session anew, with the recorded motions and the same network, by other endpoints
            let by_hand = live(&other, TICKS, &Mover::Script(recordings));
            let replayed = replay_pair(settings(&other, Acted::Replayed), recordings).unwrap();
            for (replayed, by_hand) in replayed.iter().zip(&by_hand) {
                assert_same(replayed, by_hand, lines);
            }
            let differs = replayed[0].ticks.iter().zip(&spring[0].forces);
            assert!(differs.into_iter().any(|(replayed, [wanted, _])| replayed.wanted != *wanted), "{lines}");
        }
    }
}

#[test]
fn law_the_force_of_a_replay_grows_no_steeper_than_its_site_lets_it() {
    let study = study_of(SESSIONS_OF_STUDIES[0]);
    let sites = live(&study, TICKS, &Mover::Robots);
    let rise = 15.0;
    let limits = ForceLimits { largest: LARGEST, rise };
    let settings = settings(&study, Acted::Replayed).map(|settings| ReplaySettings { limits, ..settings });
    let (mut slowed, mut fell) = (0, 0);
    for replayed in replay_pair(settings, [&sites[0].given, &sites[1].given]).unwrap() {
        for pair in replayed.ticks.windows(2) {
            let [before, now] = [pair[0].force, pair[1].force].map(|[x, y]| x.hypot(y));
            // two sample periods at most count as elapsed
            assert!(now <= before + rise * 0.002 + 1e-12, "{before} {now}");
            let wanted = pair[1].wanted[0].hypot(pair[1].wanted[1]);
            slowed += usize::from(now > 0.0 && now < 0.999 * wanted.min(LARGEST));
            fell += usize::from(before - now > rise * 0.002);
        }
    }
    assert!(slowed > 100 && fell > 0, "{slowed} {fell}");
}

#[test]
fn law_what_the_partner_has_not_recorded_stays_as_it_came() {
    let study = study_of(SESSIONS_OF_STUDIES[1]);
    let sites = live(&study, TICKS, &Mover::Robots);
    // the partner's recording ends early, as after a crash
    let end = 1200;
    let ticks = sites[1].given.ticks()[..end].to_vec();
    let arrivals = sites[1].given.arrivals().iter().filter(|arrival| arrival.tick < end).copied();
    let cut = RecordedSite::new(ticks, arrivals.collect()).unwrap();
    let replayed = replay_pair(settings(&study, Acted::Recorded), [&sites[0].given, &cut]).unwrap();
    assert_same(&replayed[0], &sites[0], "one side cut");
    assert!(replayed[0].renewed > 1000 && replayed[0].renewed < sites[0].given.arrivals().len());
    assert_eq!(replayed[1].ticks.len(), end);
}

#[test]
fn law_a_gap_in_the_partner_s_recording_costs_the_packets_of_the_gap_only() {
    let study = study_of(SESSIONS_OF_STUDIES[0]);
    let sites = live(&study, TICKS, &Mover::Robots);
    let (gap, partner) = (1300..1310, &sites[1].given);
    let lost: Vec<u64> = partner.ticks()[gap.clone()].iter().map(|tick| tick.time.0).collect();
    let ticks: Vec<RecordedTick> = [&partner.ticks()[..gap.start], &partner.ticks()[gap.end..]].concat();
    let arrivals = partner.arrivals().iter().filter(|arrival| !gap.contains(&arrival.tick));
    let arrivals = arrivals.map(|arrival| {
        let tick = if arrival.tick < gap.start { arrival.tick } else { arrival.tick - gap.len() };
        RecordedArrival { tick, ..*arrival }
    });
    let with_gap = RecordedSite::new(ticks, arrivals.collect()).unwrap();
    let replayed = replay_pair(settings(&study, Acted::Recorded), [&sites[0].given, &with_gap]).unwrap();
    // the packets of a spring say nothing of the partner's past
    assert_same(&replayed[0], &sites[0], "gap");
    let packets =
        sites[0].given.arrivals().iter().filter_map(|arrival| Packet::decode(&arrival.datagram).ok());
    let (unknown, known): (Vec<_>, Vec<_>) = packets.partition(|packet| lost.contains(&packet.sent.0));
    assert!(!unknown.is_empty());
    assert_eq!(replayed[0].renewed, known.len());
}

#[test]
fn law_impossible_recordings_are_refused() {
    let at = |time| RecordedTick::at(LocalTime(time));
    let arrival = |tick| RecordedArrival { tick, time: LocalTime(1), datagram: [0; 112] };
    let field = |ticks, arrivals| RecordedSite::new(ticks, arrivals).unwrap_err().field;
    assert_eq!(field(vec![at(5), at(5)], vec![]), "ticks[1].time");
    assert_eq!(field(vec![at(5)], vec![arrival(1)]), "arrivals[0].tick");
    assert_eq!(field(vec![at(5), at(6)], vec![arrival(1), arrival(0)]), "arrivals[1].tick");
    let study = study_of(SESSIONS_OF_STUDIES[0]);
    let empty = RecordedSite::new(vec![], vec![]).unwrap();
    let [one, two] = settings(&study, Acted::Recorded);
    let twice = replay_pair([one.clone(), one.clone()], [&empty, &empty]).unwrap_err();
    assert_eq!(twice.field, "session");
    // each side has heard what the other sends only later
    let early = |session, motion: Motion, sent: u64| {
        let packet = Packet { session, ..Packet::of(0, LocalTime(sent).seen_by_peer(), motion) };
        let arrival = RecordedArrival { tick: 0, time: LocalTime(11), datagram: packet.encode() };
        let ticks = [10, 20].map(|time| RecordedTick { motion: Some(motion), ..at(time) });
        RecordedSite::new(ticks.to_vec(), vec![arrival]).unwrap()
    };
    let still = Motion { position: [0.0; 2], velocity: [0.0; 2] };
    let pair = [&early(SESSIONS[1], still, 20), &early(SESSIONS[0], still, 20)];
    assert_eq!(replay_pair([one.clone(), two], pair).unwrap_err().field, "arrivals");
    let field = |limits| replay_site(ReplaySettings { limits, ..one.clone() }, &empty).unwrap_err().field;
    assert_eq!(field(ForceLimits { largest: f64::NAN, ..ForceLimits::NONE }), "largest_force");
    assert_eq!(field(ForceLimits { rise: 0.0, ..ForceLimits::NONE }), "steepest_rise");
}
