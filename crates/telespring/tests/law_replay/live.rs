//! Two live sites in virtual time: their own clocks, an emulated network, a gate; what each endpoint was given is recorded.

use telespring::rig::replay::{RecordedArrival, RecordedSite, RecordedTick};
use telespring::rig::{Channel, JitterDistribution, NetworkModel, SimulatedRobot};
use telespring::session::{
    Endpoint, EndpointSettings, Event, LocalTime, Motion, Span, WatchdogSettings, WatchdogState,
};
use telespring::study::Study;

pub const PERIOD: Span = Span(1_000_000);
/// What the sites' clocks read at the start, ns.
const STARTS: [u64; 2] = [7_000_000_000, 91_234_567_890];
pub const SESSIONS: [u64; 2] = [0xa11ce, 0xb0b];
/// The largest force that the sites let through, N: small, so that it cuts.
pub const LARGEST: f64 = 1.5;

/// Two robots with these further lines of a study.
pub fn study(lines: &str) -> Study {
    let robots = "robot1 = {axes = [\"x\", \"y\"], mass = [0.8334, 1.0649], damping = [7.7257, 10.1168]}\n\
                  robot2 = {axes = [\"x\", \"y\"], mass = [0.7776, 1.3407], damping = [7.4208, 9.3496]}";
    Study::from_toml(&format!("{robots}\n{lines}")).unwrap()
}

/// The endpoints of both sides of a study.
pub fn endpoints(study: &Study) -> [EndpointSettings; 2] {
    let within = WatchdogSettings::within(Span(150_000_000), Span(20_000_000), PERIOD).unwrap();
    [0, 1].map(|side| study.live_side(side as u8 + 1, SESSIONS[side], within).unwrap())
}

/// What moves the handles.
pub enum Mover<'a> {
    /// Simulated robots and people, who feel the force.
    Robots,
    /// The recorded motions of another session.
    Script([&'a RecordedSite; 2]),
}

/// What became of one side.
pub struct Side {
    pub given: RecordedSite,
    /// The endpoint's force and that of the site, N, per tick; zero where it was not asked.
    pub forces: Vec<[[f64; 2]; 2]>,
    pub ages: Vec<Option<f64>>,
    pub events: Vec<Event>,
    pub endpoint: Endpoint,
}

/// The network of a session: jitter, losses, order not kept.
fn network() -> NetworkModel {
    let jitter = JitterDistribution::Gamma { mean: 0.004, sd: 0.003 };
    NetworkModel { jitter: 0.02, distribution: jitter, loss: 0.03, duplicate: 0.01, ..NetworkModel::ideal() }
}

/// A live session of both sides over some ticks; the way towards the second is cut for a while, and in the last 100 ticks the
/// sites let the force fall.
pub fn live(study: &Study, ticks: usize, mover: &Mover<'_>) -> [Side; 2] {
    let laboratory = study.laboratory().unwrap();
    let mut robots = [0, 1].map(|side| SimulatedRobot::new(&laboratory, side, 5).unwrap());
    let mut endpoints = endpoints(study).map(|settings| Endpoint::new(settings).unwrap());
    let mut towards: [Box<dyn Channel>; 2] = [0, 1].map(|side| network().channel(Span(30_000_000), 3, side));
    let mut given: [(Vec<RecordedTick>, Vec<RecordedArrival>); 2] = Default::default();
    let mut forces: [Vec<[[f64; 2]; 2]>; 2] = Default::default();
    let mut ages: [Vec<Option<f64>>; 2] = Default::default();
    let mut events: [Vec<Event>; 2] = Default::default();
    // what the gate let through, newest first
    let mut passed = [[([0.0; 2], true); 2]; 2];
    let computing_tick = laboratory.controller.computing_tick;
    for tick in 0..ticks {
        for side in 0..2 {
            // the second loop runs a third of a period behind, and neither is punctual
            let late = (tick as u64 * 7919 + side as u64 * 31) % 23 * 1_000 + side as u64 * 333_333;
            let now = tick as u64 * 1_000_000 + late;
            let local = |now: u64| LocalTime(now + STARTS[side]);
            let time = tick as f64 * 1e-3;
            let (motion, target) = match mover {
                Mover::Robots => (Some(robots[side].measure()), Some(robots[side].target(time))),
                Mover::Script(sites) => {
                    let tick = sites[side].ticks()[tick];
                    (tick.motion, tick.target)
                }
            };
            // now and then the device is silent, or speaks nonsense
            // the sites part for a while, as in a pause
            let is_coupled = !(1600..1800).contains(&tick);
            let motion = match (mover, tick % 977) {
                _ if !is_coupled => None,
                (Mover::Script(_), _) => motion,
                (_, 400) => None,
                (_, 800) => Some(Motion { position: [f64::NAN; 2], velocity: [0.0; 2] }),
                _ => motion,
            };
            let endpoint = &mut endpoints[side];
            let (force, is_wanted) = passed[side][usize::from(computing_tick)];
            let acted = (motion.is_some() && !is_wanted).then_some(force);
            if let Some(acted) = acted {
                endpoint.handle_acted(acted);
            }
            if let Some(motion) = motion {
                let _ = endpoint.handle_measurement(local(now), motion);
                if let Some(target) = target {
                    endpoint.handle_target(local(now), target);
                }
                let is_cut = side == 0 && (900..1150).contains(&tick);
                if let Some(packet) = endpoint.poll_transmit(local(now)).filter(|_| !is_cut) {
                    towards[1 - side].send(LocalTime(now), packet);
                }
            }
            if !is_coupled && !matches!(endpoint.state(), WatchdogState::Disengaged { .. }) {
                endpoint.handle_timeout(local(now));
            }
            let mut then = now;
            while let Some(datagram) = towards[side].deliver(LocalTime(now)) {
                then += 700;
                let _ = endpoint.handle_datagram(local(then), &datagram);
                given[side].1.push(RecordedArrival { tick, time: local(then), datagram });
            }
            if tick % 500 == 3 {
                // garbage
                then += 700;
                let _ = endpoint.handle_datagram(local(then), &[7; 112]);
                given[side].1.push(RecordedArrival { tick, time: local(then), datagram: [7; 112] });
            }
            let answered = is_coupled.then(|| local(then + 11_111));
            let wanted = answered.map_or([0.0; 2], |answered| endpoint.force(answered));
            let left = (ticks - tick).min(100) as f64 / 100.0;
            let scaled = wanted.map(|force| force * left);
            let size = scaled[0].hypot(scaled[1]);
            let force = if size > LARGEST { scaled.map(|force| force * (LARGEST / size)) } else { scaled };
            passed[side] = match is_coupled {
                true => [(force, force == wanted), passed[side][0]],
                false => [([0.0; 2], false); 2],
            };
            if let Mover::Robots = mover {
                robots[side].advance(time, force, 1e-3).unwrap();
            }
            let target = target.filter(|_| motion.is_some());
            given[side].0.push(RecordedTick {
                time: local(now),
                motion,
                acted,
                target,
                answered,
                share: [left; 2],
            });
            forces[side].push([wanted, force]);
            ages[side].push(endpoint.partner_age().filter(|_| is_coupled));
            events[side].extend(std::iter::from_fn(|| endpoint.poll_event()));
        }
    }
    let [(ticks1, arrivals1), (ticks2, arrivals2)] = given;
    let given =
        [RecordedSite::new(ticks1, arrivals1).unwrap(), RecordedSite::new(ticks2, arrivals2).unwrap()];
    let mut parts = given.into_iter().zip(forces).zip(ages).zip(events).zip(endpoints);
    [(); 2].map(|()| {
        let ((((given, forces), ages), events), endpoint) = parts.next().unwrap();
        Side { given, forces, ages, events, endpoint }
    })
}
