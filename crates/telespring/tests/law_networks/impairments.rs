//! What each impairment does to packets.

use telespring::rig::{Blackout, GilbertElliott, JitterDistribution, NetworkModel, PacketOrder, RateLimit};

use crate::passage::{TRAVEL, passage};

/// Delays of the packets that come, beyond the constant one, s; seen 0.1 ms late at most.
fn excess(model: &NetworkModel, packets: u64) -> Vec<f64> {
    passage(model, 5, packets, 100_000)
        .iter()
        .map(|(_, delay)| *delay as f64 * 1e-9 - TRAVEL.seconds())
        .collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// ∫ f from 0 to the bound, by Simpson's rule.
fn integral(f: impl Fn(f64) -> f64, bound: f64) -> f64 {
    let steps = 4000;
    let h = bound / f64::from(steps);
    let weight = |n: i32| if n == 0 || n == steps { 1.0 } else { f64::from(2 + 2 * (n % 2)) };
    (0..=steps).map(|n| weight(n) * f(f64::from(n) * h)).sum::<f64>() * h / 3.0
}

#[test]
fn law_without_impairments_every_packet_takes_the_constant_delay() {
    let came = passage(&NetworkModel::ideal(), 1, 300, 1_000_000);
    assert_eq!(came, (0..300).map(|number| (number, 20_000_000)).collect::<Vec<_>>());
}

#[test]
fn ref_jitter_has_the_mean_of_its_cut_density() {
    let bound = 0.02;
    let (m, sd) = (0.006, 0.004);
    let shape: f64 = (m / sd) * (m / sd);
    let scale = sd * sd / m;
    let spread = (1.0_f64 + (sd / m).powi(2)).ln();
    // densities as in any textbook, up to a factor that cancels
    let normal = |x: f64| (-0.5 * ((x - m) / sd).powi(2)).exp();
    let gamma = |x: f64| if x > 0.0 { x.powf(shape - 1.0) * (-x / scale).exp() } else { 0.0 };
    let log_normal = |x: f64| {
        if x > 0.0 { (-0.5 * (x.ln() - m.ln() + 0.5 * spread).powi(2) / spread).exp() / x } else { 0.0 }
    };
    let cases: [(JitterDistribution, &dyn Fn(f64) -> f64); 4] = [
        (JitterDistribution::Uniform, &|_| 1.0),
        (JitterDistribution::Normal { mean: m, sd }, &normal),
        (JitterDistribution::Gamma { mean: m, sd }, &gamma),
        (JitterDistribution::LogNormal { mean: m, sd }, &log_normal),
    ];
    for (distribution, density) in cases {
        let model = NetworkModel { jitter: bound, distribution, ..NetworkModel::ideal() };
        let delays = excess(&model, 4000);
        assert_eq!(delays.len(), 4000);
        assert!(delays.iter().all(|delay| (-1e-12..=bound + 1e-4).contains(delay)), "{distribution:?}");
        let mass = integral(density, bound);
        let expected = integral(|x| x * density(x), bound) / mass;
        let variance = integral(|x| (x - expected).powi(2) * density(x), bound) / mass;
        // 4 standard errors of a mean, and 0.05 ms of looking every 0.1 ms
        let error = 4.0 * (variance / 4000.0).sqrt() + 1e-5;
        assert!(
            (mean(&delays) - 5e-5 - expected).abs() < error,
            "{distribution:?}: {} {expected}",
            mean(&delays)
        );
        // the distribution function against the integral of the density
        for x in [0.001, 0.006, 0.015] {
            let cumulative = integral(density, x) / mass;
            assert!((distribution.cumulative(x, bound) - cumulative).abs() < 2e-4, "{distribution:?} at {x}");
        }
    }
}

#[test]
fn ref_bursts_have_the_closed_forms_of_loss_and_length() {
    for (to_bad, to_good, loss_good, loss_bad) in
        [(0.01, 0.25, 0.0, 1.0), (0.05, 0.2, 0.02, 0.7), (1.0, 1.0, 0.0, 1.0)]
    {
        let burst = GilbertElliott { to_bad, to_good, loss_good, loss_bad };
        let packets = 40_000;
        let model = NetworkModel { burst: Some(burst), ..NetworkModel::ideal() };
        let mut lost = vec![true; packets as usize];
        passage(&model, 11, packets, 1_000_000).iter().for_each(|(number, _)| lost[*number as usize] = false);
        let share = lost.iter().filter(|lost| **lost).count() as f64 / packets as f64;
        let bursts: Vec<f64> =
            lost.chunk_by(|a, b| a == b).filter(|run| run[0]).map(|run| run.len() as f64).collect();
        // the variance of the share is about 2/(p + r) times that of independent losses; 4 standard errors
        let independent = burst.loss() * (1.0 - burst.loss()) / packets as f64;
        let error = 4.0 * (independent * 2.0 / (to_bad + to_good).min(1.0)).sqrt();
        assert!((share - burst.loss()).abs() < error, "{burst:?}: {share}, not {}", burst.loss());
        let expected = burst.mean_burst_length();
        let variance =
            bursts.iter().map(|length| (length - expected).powi(2)).sum::<f64>() / bursts.len() as f64;
        let error = 4.0 * (variance / bursts.len() as f64).sqrt() + 1e-3;
        assert!((mean(&bursts) - expected).abs() < error, "{burst:?}: {}, not {expected}", mean(&bursts));
    }
    // the simple model's own closed forms: p/(p + r) and 1/r
    let simple = GilbertElliott { to_bad: 0.01, to_good: 0.25, loss_good: 0.0, loss_bad: 1.0 };
    assert!((simple.loss() - 0.01 / 0.26).abs() < 1e-15);
    assert!((simple.mean_burst_length() - 4.0).abs() < 1e-12);
    let none = GilbertElliott { loss_bad: 0.0, ..simple };
    assert_eq!((none.loss(), none.mean_burst_length()), (0.0, 0.0));
    let all = GilbertElliott { loss_good: 1.0, ..simple };
    assert_eq!(all.mean_burst_length(), f64::INFINITY);
}

#[test]
fn ref_a_link_of_limited_rate_has_the_delays_of_its_queue() {
    let link = |service: f64, queue| {
        let bits_per_second = 8.0 * RateLimit::PACKET_BYTES as f64 / service;
        NetworkModel { rate: Some(RateLimit { bits_per_second, queue }), ..NetworkModel::ideal() }
    };
    // a link that keeps up delays every packet by its service time
    let came = passage(&link(0.0004, 10), 1, 200, 100_000);
    assert!(came.iter().all(|(_, delay)| *delay == 20_400_000), "{came:?}");
    // one that does not delays packet n by s + n (s − h)
    let came = passage(&link(0.0015, 1000), 1, 200, 100_000);
    for (number, delay) in &came {
        assert_eq!(*delay, 20_000_000 + 1_500_000 + number * 500_000);
    }
    // with a full queue it loses what exceeds its rate, 1 − h/s, and nobody waits longer than the queue
    let came = passage(&link(0.0015, 8), 1, 3000, 100_000);
    let lost = 1.0 - came.len() as f64 / 3000.0;
    assert!((lost - 1.0 / 3.0).abs() < 0.01, "{lost}");
    assert!(came.iter().all(|(_, delay)| *delay <= 20_000_000 + 10 * 1_500_000));
}

#[test]
fn law_fifo_never_overtakes_and_any_does() {
    let any = NetworkModel { jitter: 0.01, ..NetworkModel::ideal() };
    let fifo = NetworkModel { order: PacketOrder::Fifo, ..any.clone() };
    let (any, fifo) = (passage(&any, 3, 500, 100_000), passage(&fifo, 3, 500, 100_000));
    assert!(any.windows(2).any(|pair| pair[1].0 < pair[0].0));
    assert_eq!(fifo.iter().map(|(number, _)| *number).collect::<Vec<_>>(), (0..500).collect::<Vec<_>>());
    // a packet waits for the slowest before it, no longer
    let mut latest = 0;
    let mut sorted = any;
    sorted.sort_unstable();
    for ((number, alone), (_, delay)) in sorted.iter().zip(&fifo) {
        latest = latest.max(number * 1_000_000 + alone);
        assert_eq!(number * 1_000_000 + delay, latest);
    }
}

#[test]
fn law_copies_are_as_frequent_as_asked_and_change_nothing_else() {
    let plain = NetworkModel { jitter: 0.004, loss: 0.1, ..NetworkModel::ideal() };
    let twice = NetworkModel { duplicate: 0.3, ..plain.clone() };
    let first = |model: &NetworkModel| {
        let mut came = passage(model, 9, 3000, 100_000);
        came.sort_unstable();
        came
    };
    let (once, twice) = (first(&plain), first(&twice));
    let copies = twice.len() - once.len();
    let share = copies as f64 / once.len() as f64;
    assert!((share - 0.3).abs() < 4.0 * (0.21 / once.len() as f64).sqrt(), "{share}");
    // every packet of the network without copies is there, at its own time
    assert!(once.iter().all(|packet| twice.binary_search(packet).is_ok()));
}

#[test]
fn law_a_blackout_loses_what_is_sent_in_it() {
    let blackout = Some(Blackout { start: 0.1, duration: 0.05, period: Some(0.2) });
    let came = passage(&NetworkModel { blackout, ..NetworkModel::ideal() }, 1, 600, 1_000_000);
    let expected = (0..600_u64).filter(|n| !(100..150).contains(&(n % 200))).collect::<Vec<_>>();
    assert_eq!(came.iter().map(|(number, _)| *number).collect::<Vec<_>>(), expected);
    let once = Some(Blackout { start: 0.1, duration: 0.05, period: None });
    assert_eq!(
        passage(&NetworkModel { blackout: once, ..NetworkModel::ideal() }, 1, 600, 1_000_000).len(),
        550
    );
}
