//! Two sides, their robots and hands, and a network or an adversary, driven tick by tick without an endpoint.

mod case;
pub mod copy;
pub use crate::withstand_common::ledger::{Law, Violation};
pub use case::{Case, CaseSide, Network, PredictorKind};

use crate::withstand_common::ledger::{Facts, Ledger, Together};
use crate::withstand_common::plant::AxisPlant;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use telespring::session::predictor::{
    Hold, Kalman, Linear, MotionModel, Noise, Played, Predictor, SharedTarget, SharedTargetView,
};
use telespring::session::strategy::{PartnerView, Strategy, Tick};
use telespring::session::{Motion, PeerTime, Span};

/// The shared target: a figure of eight of 5 cm and 10 cm (Eq. 12 of Du et al. 2025).
pub fn target(time: f64) -> Motion {
    let w = 2.59 * time;
    Motion {
        position: [0.05 * (2.0 * w).sin(), 0.1 * w.sin()],
        velocity: [2.0 * 2.59 * 0.05 * (2.0 * w).cos(), 2.59 * 0.1 * w.cos()],
    }
}

/// What one packet carries.
#[derive(Clone, Copy)]
struct Packet {
    stamp: f64,
    arrival: f64,
    motion: Motion,
    energy_sent: f64,
}

/// One side as it runs.
struct Station {
    plants: [AxisPlant; 2],
    strategy: Box<dyn Strategy>,
    predictor: Box<dyn Predictor>,
    measured: Motion,
    partner: Option<PartnerView>,
    acted: [f64; 2],
    pending: [f64; 2],
    ledger: Ledger,
    /// All packets on the way to this side or arrived.
    packets: Vec<Packet>,
    /// The packet in use.
    playing: Option<Packet>,
}

/// What came of a run.
#[derive(Debug, Clone, Default)]
pub struct Outcome {
    /// The positions per tick, side and axis, m.
    pub positions: Vec<[[f64; 2]; 2]>,
    /// The largest distance of a handle from the origin along an axis, m.
    pub farthest: f64,
    /// The largest speed along an axis over the last second, m/s.
    pub last_speed: f64,
    /// The share of ticks at which each side was limited.
    pub limited: [f64; 2],
}

/// Runs a case with these strategies; the first law broken ends it.
pub fn run(
    case: &Case,
    strategies: [Box<dyn Strategy>; 2],
    random: &mut ChaCha8Rng,
) -> Result<Outcome, Violation> {
    let period = case.period;
    let mut stations = strategies.into_iter().enumerate().map(|(index, strategy)| {
        let side = &case.sides[index];
        let plants = [0, 1].map(|axis| {
            let mut plant = AxisPlant::new(side.mass[axis], side.damping[axis], side.ground[axis], period);
            plant.velocity = side.velocity[axis];
            plant
        });
        let facts = Facts {
            mass: side.mass,
            damping: side.damping,
            settings: side.settings,
            is_honest: case.is_honest(),
            clock_error: 0.0,
            unchecked: case.unchecked,
        };
        let ledger = Ledger::new(facts, &plants, strategy.report().balance.unwrap_or(0.0));
        let measured = measure(&plants, case.sides[index].settings.encoder_step);
        Station {
            plants,
            strategy,
            predictor: predictor(case.predictor),
            measured,
            partner: None,
            acted: [0.0; 2],
            pending: [0.0; 2],
            ledger,
            packets: Vec::new(),
            playing: None,
        }
    });
    let mut stations = [stations.next().unwrap(), stations.next().unwrap()];
    let (mut outcome, mut together) = (Outcome::default(), Together::default());
    for n in 0..=case.ticks {
        let now = n as f64 * period;
        outcome
            .positions
            .push([0, 1].map(|side| stations[side].plants.each_ref().map(|plant| plant.position)));
        let measured =
            [0, 1].map(|side| measure(&stations[side].plants, case.sides[side].settings.encoder_step));
        let ticks = [0, 1].map(|side| Tick {
            elapsed: if n == 0 { 0.0 } else { period },
            own: measured[side],
            previous: stations[side].measured,
            acted: stations[side].acted,
            partner: stations[side].partner,
            enabled: 1.0,
        });
        for side in 0..2 {
            stations[side].strategy.settle(&ticks[side]);
            stations[side].measured = measured[side];
        }
        // what each side has sent by now is known to nobody but the ledgers
        let sent = [0, 1].map(|side| stations[side].strategy.report().energy_sent);
        for side in 0..2 {
            let Station { plants, strategy, ledger, .. } = &mut stations[side];
            ledger.check(now, plants, &strategy.report(), sent[1 - side], ticks[side].displacement())?;
        }
        let ledgers = [0, 1].map(|side| (&stations[side].ledger, stations[side].strategy.report()));
        together.check(now, now >= case.let_go, ledgers)?;
        for side in 0..2 {
            let packet = Packet {
                stamp: now,
                arrival: now + case.travel_time(random),
                motion: measured[1 - side],
                energy_sent: sent[1 - side],
            };
            if !case.is_lost(random) {
                stations[side].packets.push(packet);
            }
        }
        let mut actings = [[0.0; 2]; 2];
        for side in 0..2 {
            let station = &mut stations[side];
            let enabled = case.enabled(now);
            station.partner =
                partner_view(case, station, &measured[side], now, random).filter(|_| enabled > 0.0);
            let tick = Tick { partner: station.partner, enabled, ..ticks[side] };
            let force = station.strategy.force(&tick);
            station.ledger.check_force(now, force, &station.strategy.report())?;
            let computed = if case.sides[side].settings.computing_tick {
                std::mem::replace(&mut station.pending, force)
            } else {
                force
            };
            let limit = case.force_limit;
            actings[side] = computed.map(|force| force.clamp(-limit, limit));
        }
        if n == case.ticks {
            break;
        }
        for side in 0..2 {
            let station = &mut stations[side];
            station.acted = actings[side];
            for axis in 0..2 {
                let hand = case.hand(side, axis, now, &target(now));
                let (acted, plant) = (station.acted[axis], &mut station.plants[axis]);
                let step = plant.advance_robot(acted, hand);
                station.ledger.add(axis, &step, hand, period);
                outcome.farthest = outcome.farthest.max(plant.position.abs());
                if n + 1000 > case.ticks {
                    outcome.last_speed = outcome.last_speed.max(plant.velocity.abs());
                }
            }
        }
    }
    outcome.limited = stations.each_ref().map(|station| {
        let report = station.strategy.report();
        report.limited_ticks as f64 / report.ticks.max(1) as f64
    });
    Ok(outcome)
}

fn measure(plants: &[AxisPlant; 2], step: f64) -> Motion {
    let round = |x: f64| if step > 0.0 { (x / step).round() * step } else { x };
    Motion {
        position: plants.each_ref().map(|plant| round(plant.position)),
        velocity: plants.each_ref().map(|plant| plant.velocity),
    }
}

fn predictor(kind: PredictorKind) -> Box<dyn Predictor> {
    let kalman = |model, process| Kalman::new(model, Noise { process, position: 1e-5 }).unwrap();
    match kind {
        PredictorKind::Hold => Box::new(Hold),
        PredictorKind::Linear => Box::new(Linear),
        PredictorKind::ConstantVelocity => Box::new(kalman(MotionModel::ConstantVelocity, 1.0)),
        PredictorKind::ConstantAcceleration => Box::new(kalman(MotionModel::ConstantAcceleration, 100.0)),
        PredictorKind::SharedTarget => Box::new(SharedTarget),
    }
}

/// What the side knows of its partner now.
fn partner_view(
    case: &Case,
    station: &mut Station,
    own: &Motion,
    now: f64,
    random: &mut ChaCha8Rng,
) -> Option<PartnerView> {
    let (played, claimed) = match case.network {
        Network::Random { backwards, .. } => {
            let mut newest = station.playing;
            let mut latest: Option<Packet> = None;
            for packet in station.packets.iter().filter(|packet| packet.arrival <= now) {
                if newest.is_none_or(|newest| packet.stamp > newest.stamp) {
                    newest = Some(*packet);
                }
                if latest.is_none_or(|latest| packet.arrival > latest.arrival) {
                    latest = Some(*packet);
                }
            }
            // the total of the packet that came last, which may be an old one
            let claimed = latest.or(station.playing).map(|packet| packet.energy_sent);
            station.packets.retain(|packet| packet.arrival > now);
            let used = if backwards { latest.or(station.playing) } else { newest };
            station.playing = used;
            (used?, claimed?)
        }
        Network::Oldest { span } => {
            // one sample is held until it is as old as allowed, then the newest
            if station.playing.is_none_or(|playing| now - playing.stamp > span) {
                station.playing = station.packets.last().copied();
                station.packets.clear();
            }
            (station.playing?, station.playing?.energy_sent)
        }
        Network::Harmful { span } => {
            station.packets.retain(|packet| now - packet.stamp <= span);
            let harm = |packet: &Packet| {
                let [x, y] = packet.motion.position;
                let [u, v] = own.velocity;
                x * u + y * v
            };
            let worst = station.packets.iter().copied().max_by(|a, b| harm(a).total_cmp(&harm(b)))?;
            (worst, worst.energy_sent)
        }
        Network::Liar => {
            let size = 10.0_f64.powf(random.random_range(-3.0..5.9));
            let position =
                [0, 1].map(|axis| (own.position[axis] + size.copysign(own.velocity[axis])).clamp(-1e6, 1e6));
            let velocity = [0, 1].map(|_| random.random_range(-1e3..1e3));
            let claims =
                [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0, 0.0, 1e9 * random.random::<f64>(), 1e300];
            let stamp = now + 10.0_f64.powf(random.random_range(-3.0..6.0)) * random.random_range(-1.0..1.0);
            let motion = Motion { position, velocity };
            (
                Packet { stamp, arrival: now, motion, energy_sent: 0.0 },
                claims[random.random_range(0..claims.len())],
            )
        }
        Network::Nothing => return None,
    };
    let age = now - played.stamp;
    let request = Played {
        motion: played.motion,
        time: PeerTime::from_seconds(1e7 + played.stamp),
        age: Span::from_seconds(age),
        held: false,
    };
    let target = SharedTargetView { now: target(now), then: target(played.stamp) };
    let wanted = station.predictor.predict(&request, Some(&target));
    Some(PartnerView {
        wanted,
        played: played.motion,
        age,
        fresh: true,
        signal: [0.0; 2],
        energy_sent: claimed,
        stiffness: case.law.stiffness,
    })
}
