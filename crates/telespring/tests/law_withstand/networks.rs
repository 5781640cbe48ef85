//! Random networks: every impairment, recorded traces, and every adversary.

use std::sync::Arc;

use crate::case::{pick, spread};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use telespring::rig::{
    Adversary, Blackout, GilbertElliott, JitterDistribution, Network, NetworkModel, PacketOrder, RateLimit,
    Trace, TraceRow,
};

/// A random network; on every second one the two ways differ.
pub fn random_network(random: &mut ChaCha8Rng, period: f64) -> Network {
    let way = random_way(random, period);
    if random.random() {
        return Network::each_way(way);
    }
    Network { forward: way, backward: random_way(random, period) }
}

fn random_way(random: &mut ChaCha8Rng, period: f64) -> NetworkModel {
    let model = NetworkModel {
        burst: random.random_bool(0.2).then(|| random_burst(random)),
        loss: pick(random, &[0.0, 0.0, 0.02, 0.3]),
        duplicate: pick(random, &[0.0, 0.0, 0.0, 0.3]),
        order: pick(random, &[PacketOrder::Any, PacketOrder::Fifo]),
        rate: random.random_bool(0.15).then(|| random_rate(random, period)),
        blackout: random.random_bool(0.2).then(|| random_blackout(random)),
        adversary: random.random_bool(0.6).then(|| random_adversary(random)),
        ..NetworkModel::ideal()
    };
    let model = match random.random_range(0..6) {
        0 => model,
        1 => NetworkModel { trace: Some(Arc::new(random_trace(random))), ..model },
        _ => {
            let jitter = spread(random, 1e-3, 0.3);
            NetworkModel { jitter, distribution: random_distribution(random, jitter), ..model }
        }
    };
    model.check().unwrap();
    model
}

fn random_burst(random: &mut ChaCha8Rng) -> GilbertElliott {
    GilbertElliott {
        to_bad: spread(random, 1e-4, 0.1),
        to_good: spread(random, 3e-3, 0.5),
        loss_good: pick(random, &[0.0, 0.05]),
        loss_bad: pick(random, &[0.5, 1.0]),
    }
}

/// A link that is faster or slower than the packets come.
fn random_rate(random: &mut ChaCha8Rng, period: f64) -> RateLimit {
    let share = random.random_range(0.5..1.5);
    let bits = 8.0 * RateLimit::PACKET_BYTES as f64;
    RateLimit { bits_per_second: bits / (share * period), queue: random.random_range(0..200) }
}

fn random_blackout(random: &mut ChaCha8Rng) -> Blackout {
    let duration = spread(random, 0.01, 1.0);
    Blackout {
        start: random.random_range(0.0..1.0),
        duration,
        period: random.random_bool(0.7).then(|| duration + random.random_range(0.05..1.0)),
    }
}

fn random_distribution(random: &mut ChaCha8Rng, bound: f64) -> JitterDistribution {
    let mean = bound * random.random_range(0.1..0.9);
    let sd = bound * random.random_range(0.05..0.5);
    pick(
        random,
        &[
            JitterDistribution::Uniform,
            JitterDistribution::Normal { mean, sd },
            JitterDistribution::Gamma { mean, sd },
            JitterDistribution::LogNormal { mean, sd },
        ],
    )
}

/// A line as mobile networks have them: a base, waits that grow and empty at once, losses in runs.
fn random_trace(random: &mut ChaCha8Rng) -> Trace {
    let (base, interval) = (spread(random, 5e-3, 0.2), spread(random, 2e-3, 0.03));
    let (mut wait, mut is_lost) = (0.0_f64, false);
    let rows = (0..200).map(|n| {
        wait = if random.random_bool(0.05) { spread(random, 0.01, 0.5) } else { (wait - interval).max(0.0) };
        is_lost = random.random_bool(if is_lost { 0.7 } else { 0.02 });
        // the first packet always comes: a trace without any is none
        let lost = is_lost && n > 0;
        let delay = base + wait + spread(random, 1e-4, 5e-3);
        TraceRow { time: f64::from(n) * interval, delay: if lost { 0.0 } else { delay }, lost }
    });
    Trace::new(rows.collect()).unwrap()
}

fn random_adversary(random: &mut ChaCha8Rng) -> Adversary {
    let span = spread(random, 0.03, 1.0);
    match random.random_range(0..4) {
        0 => Adversary::OldestSample { memory: span },
        1 => Adversary::MostHarmfulSample { memory: span.min(0.4) },
        2 => Adversary::StretchTimed { longest: span },
        _ => Adversary::LyingPeer {
            position: pick(random, &[0.0, 0.01, 0.3, 10.0]),
            stamp: pick(random, &[0.0, -0.1, -5.0, 0.05]),
            power: pick(random, &[0.0, 0.2, 5.0, 1000.0]),
        },
    }
}
