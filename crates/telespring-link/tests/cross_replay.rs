//! What a site tells of its ticks and arrivals is enough: its session reproduces itself in the core, bit for bit.

mod common;

use common::{Pair, anywhere, hman_study};
use telespring::rig::replay::{
    Acted, ForceLimits, RecordedArrival, RecordedSite, RecordedTick, ReplaySettings, ReplayedSite,
    replay_pair, replay_site,
};
use telespring::session::EndpointSettings;
use telespring::study::Study;
use telespring_link::site::{Limits, Moment, Phase, Safety, SiteSettings};

/// The largest force, N, and its steepest growth, N/s: small, so that the site cuts.
const LIMITS: ForceLimits = ForceLimits { largest: 1.0, rise: 12.0 };
/// The share of the force that acts along each axis.
const SCALE: [f64; 2] = [0.7, 0.0];

/// The ticks and arrivals of both sides, as a site tells them.
struct Told {
    moments: [Vec<Moment>; 2],
    arrivals: [Vec<RecordedArrival>; 2],
}

/// A session of two moving handles with limits, a scale and a locked axis: a way cut for a while, a silent device, and a stop at
/// the end. A device that is silent now and then leaves the site in doubt what acted.
fn live(study: &Study, is_silent: bool) -> Told {
    let mut pair = Pair::with([study, study], 0.03, |settings| {
        let settings = anywhere(settings);
        let ForceLimits { largest: force, rise } = LIMITS;
        let limits = Limits { force, rise, scale: SCALE[0], lock: [false, true], ..settings.limits };
        SiteSettings { limits, ..settings }
    });
    let mut told = Told { moments: Default::default(), arrivals: Default::default() };
    for tick in 0..3000 {
        let angle = f64::from(tick) * 0.005;
        for (side, device) in pair.devices.iter().enumerate() {
            let turn = angle * (1.0 + 0.2 * side as f64);
            device.change(|script| {
                script.position = [0.03 * turn.sin() + 0.02 * side as f64, 0.03 * turn.cos()];
                script.velocity = [0.15 * turn.cos(), -0.15 * turn.sin()];
                script.is_measured = !is_silent || tick % 411 != 400;
            });
        }
        pair.ends[0].wire.borrow_mut().is_cut[1] = (1500..1700).contains(&tick);
        pair.stop[0] = tick >= 2800;
        pair.tick();
        for side in 0..2 {
            told.moments[side].push(pair.moment(side));
            told.arrivals[side].extend(pair.site_of(side).arrivals().iter().map(|arrival| RecordedArrival {
                tick: usize::try_from(arrival.tick).unwrap(),
                time: arrival.time,
                datagram: arrival.datagram,
            }));
        }
    }
    told
}

/// What the endpoint of a side was given.
fn recorded(told: &Told, side: usize) -> RecordedSite {
    let ticks = told.moments[side].iter().map(|moment| RecordedTick {
        motion: moment.motion.filter(|_| moment.is_measured),
        acted: moment.forces.told,
        target: moment.target.filter(|_| moment.is_measured),
        answered: moment.asked,
        share: SCALE.map(|scale| moment.share * scale),
        ..RecordedTick::at(moment.time)
    });
    RecordedSite::new(ticks.collect(), told.arrivals[side].clone()).unwrap()
}

fn endpoint(study: &Study, side: usize) -> EndpointSettings {
    let number = u8::try_from(side).unwrap() + 1;
    SiteSettings::new(study, number, 11 + side as u64, Safety::default()).unwrap().endpoint
}

/// Asserts that a replay is what the site did.
fn assert_same(replayed: &ReplayedSite, moments: &[Moment], lines: &str) {
    let bits = |force: [f64; 2]| force.map(f64::to_bits);
    for (tick, (replayed, moment)) in replayed.ticks.iter().zip(moments).enumerate() {
        let wanted = moment.forces.wanted.unwrap_or_default();
        assert_eq!(bits(replayed.wanted), bits(wanted), "{lines}, tick {tick}");
        assert_eq!(bits(replayed.force), bits(moment.force), "{lines}, tick {tick}");
        if moment.asked.is_some() {
            assert_eq!(replayed.age, moment.age, "{lines}, tick {tick}");
            assert_eq!(replayed.balance, moment.balance, "{lines}, tick {tick}");
            assert_eq!(replayed.state, moment.state, "{lines}, tick {tick}");
        }
    }
    assert_eq!(replayed.ticks.len(), moments.len());
}

#[test]
fn cross_what_a_site_tells_reproduces_its_session() {
    for lines in [
        "session.strategy = \"guard\"",
        "session = {strategy = \"guard\", predictor = \"kalman\", playout = \"adaptive\"}",
        "session.strategy = \"wave-variables\"",
        "session.strategy = \"two-layer\"\nlaboratory.computing_tick = true",
    ] {
        let study = hman_study(&format!("coupling.stiffness = 100\nnetwork.delay = 0.04\n{lines}"));
        let told = live(&study, true);
        let settings = |acted| {
            [0, 1].map(|side| ReplaySettings { endpoint: endpoint(&study, side), acted, limits: LIMITS })
        };
        let sites = [0, 1].map(|side| recorded(&told, side));
        for side in 0..2 {
            let moments = &told.moments[side];
            assert!(moments.iter().any(|moment| moment.phase == Phase::RampingOut), "{lines}");
            assert!(moments.iter().any(|moment| moment.forces.told.is_some()), "{lines}: nothing was cut");
            let size = |moment: &Moment| moment.force[0].hypot(moment.force[1]);
            let slowed =
                moments.iter().filter(|moment| moment.is_cut && size(moment) < 0.99 * LIMITS.largest);
            assert!(slowed.count() > 50, "{lines}: nothing was slowed");
            let [ref one, ref two] = settings(Acted::Recorded);
            let alone = replay_site([one, two][side].clone(), &sites[side]).unwrap();
            assert_same(&alone, moments, lines);
        }
        // of devices that do as they are told, the force that the gate lets through is the one that acted
        for acted in [Acted::Recorded, Acted::Replayed] {
            let told = if acted == Acted::Recorded { &told } else { &live(&study, false) };
            let sites = [0, 1].map(|side| recorded(told, side));
            let both = replay_pair(settings(acted), [&sites[0], &sites[1]]).unwrap();
            for (replayed, moments) in both.iter().zip(&told.moments) {
                assert_same(replayed, moments, lines);
                assert!(replayed.renewed > 2000, "{lines}");
            }
        }
    }
}
