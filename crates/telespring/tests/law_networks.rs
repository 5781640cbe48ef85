//! Laws of networks: what each impairment does to packets, recorded traces, adversaries, and the energy they cause.

use std::sync::Arc;

use telespring::rig::trace::{IrttDelay, TimeUnit, TraceUnits};
use telespring::rig::{
    Agent, Arm, Blackout, ConnectedMode, Datagram, GilbertElliott, JitterDistribution, Laboratory, Network,
    NetworkModel, PacketOrder, RateLimit, Recording, Schedule, Status, Trace, TraceRow, Trial,
};
use telespring::session::wire::LENGTH;
use telespring::session::{LocalTime, Span};
use telespring::study::Study;
use telespring::{Delay, InvalidInput};

const PERIOD: Span = Span(1_000_000);
/// What every packet takes at least.
const TRAVEL: Span = Span(20_000_000);

/// A packet that carries its number.
fn numbered(number: u64) -> Datagram {
    let mut packet = [0; LENGTH];
    packet[..8].copy_from_slice(&number.to_le_bytes());
    packet
}

/// Number and delay (ns) of all packets in the order in which they come, one sent every ms.
///
/// Asked for at every moment at which one can come: the channel says nothing about when it will deliver.
fn passage(model: &NetworkModel, seed: u64, packets: u64, look: u64) -> Vec<(u64, u64)> {
    passage_towards(model, seed, 0, packets, look)
}

/// The same towards a side.
fn passage_towards(model: &NetworkModel, seed: u64, side: usize, packets: u64, look: u64) -> Vec<(u64, u64)> {
    model.check().unwrap();
    let mut channel = model.channel(TRAVEL, seed, side);
    let mut came = Vec::new();
    let period = PERIOD.0.cast_unsigned();
    let last = packets * period + 3_000_000_000;
    let mut now = 0;
    while now <= last {
        if now % period == 0 && now / period < packets {
            channel.send(LocalTime(now), numbered(now / period));
        }
        while let Some(packet) = channel.deliver(LocalTime(now)) {
            let number = u64::from_le_bytes(packet[..8].try_into().unwrap());
            came.push((number, now - number * period));
        }
        now += look;
    }
    came
}

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
fn law_one_impairment_leaves_the_numbers_of_the_others() {
    let burst = GilbertElliott { to_bad: 0.02, to_good: 0.3, loss_good: 0.0, loss_bad: 1.0 };
    let base = NetworkModel { jitter: 0.004, loss: 0.1, burst: Some(burst), ..NetworkModel::ideal() };
    let numbers = |model: &NetworkModel| {
        let mut numbers: Vec<u64> =
            passage(model, 2, 2000, 1_000_000).iter().map(|(number, _)| *number).collect();
        numbers.sort_unstable();
        numbers.dedup();
        numbers
    };
    let lost_as_before = numbers(&base);
    let gamma = JitterDistribution::Gamma { mean: 0.002, sd: 0.001 };
    for other in [
        NetworkModel { jitter: 0.02, ..base.clone() },
        NetworkModel { distribution: gamma, ..base.clone() },
        NetworkModel { duplicate: 0.5, ..base.clone() },
        NetworkModel { order: PacketOrder::Fifo, ..base.clone() },
    ] {
        assert_eq!(numbers(&other), lost_as_before, "{other:?}");
    }
    // and losses leave the delays of the packets that come
    let gamma = NetworkModel { loss: 0.0, distribution: gamma, ..base };
    let delays = |model: &NetworkModel| passage(model, 2, 500, 100_000);
    let (few, all) = (delays(&gamma), delays(&NetworkModel { burst: None, ..gamma.clone() }));
    assert!(few.len() < all.len() && few.iter().all(|packet| all.contains(packet)));
}

#[test]
fn law_the_two_ways_draw_numbers_of_their_own() {
    let model = NetworkModel {
        burst: Some(GilbertElliott { to_bad: 0.2, to_good: 0.3, loss_good: 0.0, loss_bad: 1.0 }),
        ..NetworkModel::ideal()
    };
    let lost = |side| {
        let mut channel = model.channel(Span(0), 4, side);
        let send = |n: u64| {
            channel.send(LocalTime(n), numbered(n));
            channel.deliver(LocalTime(n)).is_none()
        };
        (0..500).map(send).collect::<Vec<_>>()
    };
    assert_ne!(lost(0), lost(1));
    assert_eq!(lost(0), lost(0));
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

#[test]
fn law_a_recorded_trace_is_played_in_a_circle_from_a_place_of_the_seed() {
    let row = |time, delay, lost| TraceRow { time, delay, lost };
    let rows = vec![row(0.0, 0.005, false), row(0.01, 0.0, true), row(0.02, 0.03, false)];
    let trace = Arc::new(Trace::new(rows).unwrap());
    assert_eq!(trace.duration(), 0.03);
    let model = NetworkModel { trace: Some(trace), ..NetworkModel::ideal() };
    // packets every ms: the place shows to the ms
    let place = |seed: u64, side: usize| {
        let mut came = passage_towards(&model, seed, side, 60, 1_000_000);
        came.sort_unstable();
        let expected = |place: u64| {
            (0..60).filter_map(move |n| match (n + place) % 30 {
                0..10 => Some((n, 5_000_000)),
                10..20 => None,
                _ => Some((n, 30_000_000)),
            })
        };
        (0..30).find(|place| came.iter().copied().eq(expected(*place))).expect("the trace from some place on")
    };
    let places: Vec<_> = (0..40).map(|seed| place(seed, 0)).collect();
    // both ways were recorded at the same time
    assert!((0..40).all(|seed| place(seed, 1) == places[seed as usize]));
    // of 30 places, 40 seeds draw 22 on average
    let distinct = places.iter().collect::<std::collections::BTreeSet<_>>();
    assert!(distinct.len() > 15, "{places:?}");
}

/// A trace of this text, or its refusal.
fn read(text: &str) -> Result<Trace, InvalidInput> {
    Trace::from_csv(text, TraceUnits::default())
}

#[test]
fn ref_a_table_is_read_with_its_units_and_separators() {
    let expected = read("time_s,delay_s,lost\n0,0.025,0\n0.02,,1\n0.05,0.03,0\n").unwrap();
    for text in [
        "time(ms) delay(ms) lost other\n1723189086537 25 0 x\n1723189086557 nan true x\n1723189086587 30 no x\n",
        "\u{feff}# recorded\nlost;delay [ms];sent [us]\n0;25,0;0\n1;;20000\n0;30,0;50000\n",
        "pub_time_ns\trtt_us\n0\t25000\n20000000\t\n50000000\t30000\n",
    ] {
        let trace = read(text).unwrap();
        for (row, wanted) in trace.rows().iter().zip(expected.rows()) {
            assert!(
                (row.time - wanted.time).abs() < 1e-12 && (row.delay - wanted.delay).abs() < 1e-12,
                "{text}"
            );
            assert_eq!(row.lost, wanted.lost, "{text}");
        }
        assert_eq!(trace.rows().len(), 3);
    }
    let units = TraceUnits { time: Some(TimeUnit::Seconds), delay: Some(TimeUnit::Milliseconds) };
    assert_eq!(Trace::from_csv("time,delay\n0,1\n1,2\n", units).unwrap().rows()[1].delay, 0.002);
    assert_eq!(expected.halved().rows()[2].delay, 0.015);
}

#[test]
fn law_a_trace_that_says_nothing_is_refused_with_its_place() {
    for (text, field) in [
        ("", "trace, column time"),
        ("when,delay_s\n0,1\n", "trace, column time"),
        ("time_s,lost\n0,1\n", "trace, column delay"),
        ("time,delay_ms\n0,1\n1,1\n", "trace, unit of time"),
        ("time_s,delay\n0,1\n1,1\n", "trace, unit of delay"),
        ("time_s,delay_s\n0,1\n1,x\n", "trace, line 3, delay"),
        ("time_s,delay_s,lost\n0,1,2\n", "trace, line 2, lost"),
        ("time_s,delay_s\n0,1\n2,1\n1,1\n", "trace row 3, time"),
        ("time_s,delay_s\n0,1\n1,-0.001\n", "trace row 2, delay"),
        ("time_s,delay_s\n0,1\n1,101\n", "trace row 2, delay"),
        ("time_s,delay_s\n0,1\nnan,1\n", "trace row 2, time"),
        ("time_s,delay_s\n0,1\n", "trace"),
        ("time_s,delay_s,lost\n0,1,1\n1,1,1\n", "trace"),
        ("time_s,delay_s\n0,1\n0,1\n", "trace"),
    ] {
        let refused = read(text).unwrap_err();
        assert_eq!(refused.field, field, "{text:?}: {refused}");
    }
    assert_eq!(Trace::from_irtt("{}", IrttDelay::RoundTrip).unwrap_err().field, "trace");
}

#[test]
fn ref_statistics_of_a_small_trace_by_hand() {
    // the second is still under way when the fifth comes
    let text = "time_ms,delay_ms,lost\n0,20,0\n10,55,0\n20,,1\n30,,1\n40,20,0\n50,,1\n60,40,0\n";
    let statistics = read(text).unwrap().statistics();
    assert_eq!((statistics.sent, statistics.interval), (7, 0.01));
    assert!((statistics.loss - 3.0 / 7.0).abs() < 1e-15);
    assert_eq!(statistics.burst_length, 1.5);
    // packet 2 arrives at 65 ms, packet 5 at 60 ms: one of four was overtaken
    assert_eq!(statistics.reordered, 0.25);
    assert!((statistics.mean - 0.03375).abs() < 1e-15);
    assert!((statistics.median - 0.03).abs() < 1e-15);
    assert_eq!((statistics.minimum, statistics.maximum), (0.02, 0.055));
    let trace = read(text).unwrap();
    // sorted 20, 20, 40, 55: three quarters lie at place 2.25
    assert!((trace.quantile(0.75) - 0.04375).abs() < 1e-15);
}

/// A trace that the emulator makes: packets every ms.
fn recorded(model: &NetworkModel, packets: u64) -> Trace {
    let mut rows: Vec<TraceRow> =
        (0..packets).map(|n| TraceRow { time: n as f64 * 1e-3, delay: 0.0, lost: true }).collect();
    for (number, delay) in passage(model, 21, packets, 10_000) {
        rows[number as usize] = TraceRow { delay: delay as f64 * 1e-9, lost: false, ..rows[number as usize] };
    }
    Trace::new(rows).unwrap()
}

#[test]
fn law_the_fit_finds_the_model_that_made_the_trace() {
    let burst = GilbertElliott { to_bad: 0.02, to_good: 0.4, loss_good: 0.0, loss_bad: 1.0 };
    for distribution in [
        JitterDistribution::Uniform,
        JitterDistribution::Normal { mean: 0.01, sd: 0.002 },
        JitterDistribution::Gamma { mean: 0.006, sd: 0.003 },
        JitterDistribution::LogNormal { mean: 0.006, sd: 0.004 },
    ] {
        let model = NetworkModel { jitter: 0.04, distribution, burst: Some(burst), ..NetworkModel::ideal() };
        let trace = recorded(&model, 6000);
        let fit = trace.fit();
        let best = fit.jitter[0];
        // not told apart with certainty: gamma and log-normal resemble a normal distribution far from 0
        assert!(best.distance < 0.02, "{distribution:?}: {best:?}");
        let mut quantiles = 0.0_f64;
        for share in 1..100 {
            let at = trace.quantile(f64::from(share) / 100.0);
            let fitted = best.distribution.cumulative(at - best.delay, best.jitter);
            quantiles = quantiles.max((fitted - f64::from(share) / 100.0).abs());
        }
        assert!(quantiles < 0.025, "{distribution:?}: {quantiles}");
        let same = fit
            .jitter
            .iter()
            .find(|one| std::mem::discriminant(&one.distribution) == std::mem::discriminant(&distribution))
            .unwrap();
        assert!(same.distance < 0.02, "{distribution:?}: {same:?}");
        // the wrong end of the list fits visibly worse
        assert!(fit.jitter.last().unwrap().distance > 2.0 * best.distance, "{:?}", fit.jitter);
        let found = fit.burst.unwrap();
        // 4 standard errors of a share
        assert!((found.model.to_bad - 0.02).abs() < 4.0 * (0.02_f64 / 5700.0).sqrt(), "{found:?}");
        assert!((found.model.to_good - 0.4).abs() < 4.0 * (0.24_f64 / 290.0).sqrt(), "{found:?}");
        assert!(found.distance < 0.1, "{found:?}");
        let (delay, fitted) = fit.model();
        fitted.check().unwrap();
        assert!(delay > 0.0 && delay < 0.0205 + 0.01, "{delay}");
    }
}

fn coupled(stiffness: f64, delay: f64) -> Option<ConnectedMode> {
    Some(ConnectedMode { stiffness, damping: 0.0, delay: Delay::each_way(delay).unwrap() })
}

fn run(laboratory: &Laboratory, coupling: Option<ConnectedMode>, duration: f64) -> Recording {
    laboratory.check().unwrap();
    let schedule = Schedule::new(duration, 1000.0, laboratory.controller.sample_period).unwrap();
    Trial { laboratory, coupling, seed: 1, schedule }.record::<InvalidInput>([None, None]).unwrap()
}

/// What the two robots gave out, by the balance of energies of each handle, which shares nothing with forces times
/// displacements: the kinetic energy and the viscous loss less the work of the hand. And that loss, J.
fn balance(recording: &Recording, laboratory: &Laboratory) -> (f64, f64) {
    let rows = recording.velocity.len();
    let period = laboratory.controller.sample_period;
    let (mut given, mut lost) = (0.0, 0.0);
    for side in 0..2 {
        for axis in 0..2 {
            let (m, b) =
                (laboratory.stations[side].handle.mass[axis], laboratory.stations[side].handle.damping[axis]);
            let velocity = |row: usize| recording.velocity[row][side][axis];
            given += 0.5 * m * (velocity(rows - 1).powi(2) - velocity(0).powi(2));
            for row in 0..rows - 1 {
                let (from, to) = (velocity(row), velocity(row + 1));
                // a velocity that changes evenly within a period
                lost += b * period * (from * from + from * to + to * to) / 3.0;
                given -= recording.agent_force[row][side][axis] * period * 0.5 * (from + to);
            }
        }
    }
    (given + lost, lost)
}

#[test]
fn law_the_observer_counts_what_the_handles_balance_says() {
    let mut laboratory = Laboratory::paper();
    for (stiffness, delay) in [(71.2, 0.0), (71.2, 0.084), (142.0, 0.084)] {
        let recording = run(&laboratory, coupled(stiffness, delay), 4.0);
        let observed = recording.outcome.coupling_energy;
        let (given, lost) = balance(&recording, &laboratory);
        let expected = -given;
        // the velocity between two ticks is not quite even
        let scale = 1e-4 * lost;
        assert!(
            (observed.total - expected).abs() < scale,
            "{stiffness}, {delay}: {observed:?}, not {expected}"
        );
        assert!(observed.minimum <= observed.total && observed.minimum <= 0.0);
    }
    // undelayed, a spring cannot give more than it took, but for the little that holding a force generates
    laboratory.stations[1].agent = Agent::Skilled { stiffness: 60.0, damping: 1.0 };
    let spring = run(&laboratory, coupled(71.2, 0.0), 4.0).outcome.coupling_energy;
    // over a delay it gives out what the handles then lose
    let mut free = Laboratory::paper();
    for station in &mut free.stations {
        station.arm = Arm::Lumped { mass: [0.0; 2], damping: [0.0; 2] };
    }
    free.stations[0].agent = Agent::Skilled { stiffness: 30.0, damping: 0.0 };
    free.stations[1].agent = Agent::Skilled { stiffness: 0.0, damping: 0.0 };
    let delayed = run(&free, coupled(142.0, 0.2), 4.0).outcome.coupling_energy;
    assert!(spring.minimum > -0.01, "{spring:?}");
    assert!(delayed.minimum < -0.1, "{delayed:?}");
    let alone = run(&laboratory, None, 1.0).outcome.coupling_energy;
    assert_eq!((alone.total, alone.minimum), (0.0, 0.0));
}

#[test]
fn law_a_trial_runs_on_every_network_and_is_repeatable() {
    let burst = GilbertElliott { to_bad: 0.01, to_good: 0.2, loss_good: 0.0, loss_bad: 1.0 };
    let rough = NetworkModel {
        jitter: 0.02,
        distribution: JitterDistribution::Gamma { mean: 0.004, sd: 0.003 },
        loss: 0.01,
        burst: Some(burst),
        duplicate: 0.02,
        order: PacketOrder::Fifo,
        rate: Some(RateLimit { bits_per_second: 2e6, queue: 50 }),
        blackout: Some(Blackout { start: 0.5, duration: 0.1, period: None }),
        ..NetworkModel::ideal()
    };
    let mut laboratory = Laboratory::paper();
    let clean = run(&laboratory, coupled(71.2, 0.05), 1.0);
    laboratory.network.forward = rough;
    let one_way = run(&laboratory, coupled(71.2, 0.05), 1.0);
    assert_eq!(one_way.outcome.status, Status::Completed);
    assert_eq!(one_way, run(&laboratory, coupled(71.2, 0.05), 1.0));
    assert_ne!(one_way.coupling_force, clean.coupling_force);
}

const ROBOTS: &str = "robot1 = {mass = [1, 1], damping = 5}\nrobot2 = {mass = [1, 1], damping = 5}\n";

fn study(text: &str) -> Result<Study, InvalidInput> {
    Study::from_toml(&format!("{ROBOTS}{text}"))
}

#[test]
fn law_the_section_network_says_everything_and_is_written_as_read() {
    let text = "[network]\ndelay = 0.05\njitter = {forward = 0.02, backward = 0.03}\nloss = 0.01\n\
                distribution = {forward = {kind = \"gamma\", mean = 0.004, sd = 0.002}}\n\
                burst = {backward = {to_bad = 0.01, to_good = 0.25}}\nduplicate = 0.1\norder = \"fifo\"\n\
                rate = {forward = 1e6, backward = {bits_per_second = 2e6, queue = 5}}\n\
                blackout = {start = 1, duration = 0.5, period = 4.0}\n";
    let given = study(text).unwrap();
    let network = given.laboratory().unwrap().network;
    assert_eq!((network.forward.jitter, network.backward.jitter), (0.02, 0.03));
    assert_eq!(network.forward.distribution, JitterDistribution::Gamma { mean: 0.004, sd: 0.002 });
    assert_eq!(network.backward.distribution, JitterDistribution::Uniform);
    assert_eq!(network.forward.burst, None);
    let burst = GilbertElliott { to_bad: 0.01, to_good: 0.25, loss_good: 0.0, loss_bad: 1.0 };
    assert_eq!(network.backward.burst, Some(burst));
    assert_eq!(network.forward.rate, Some(RateLimit { bits_per_second: 1e6, queue: RateLimit::QUEUE }));
    assert_eq!(network.backward.rate, Some(RateLimit { bits_per_second: 2e6, queue: 5 }));
    assert_eq!(network.forward.blackout, Some(Blackout { start: 1.0, duration: 0.5, period: Some(4.0) }));
    assert_eq!((network.forward.loss, network.backward.duplicate), (0.01, 0.1));
    assert_eq!(network.backward.order, PacketOrder::Fifo);
    // the verdicts assume the larger jitter
    assert_eq!(given.network().unwrap().jitter(), 0.03);
    assert_eq!(Study::from_toml(&given.to_toml()).unwrap(), given);
    assert!(given.moved_keys().is_empty());
}

#[test]
fn law_the_old_place_is_read_and_a_contradiction_refused() {
    let old = study("[laboratory]\njitter = 0.01\nloss = 0.1\n").unwrap();
    assert_eq!(old, study("[network]\njitter = 0.01\nloss = 0.1\n").unwrap());
    let moved = [("laboratory.jitter", "network.jitter"), ("laboratory.loss", "network.loss")];
    assert_eq!(old.moved_keys(), moved.map(|(old, new)| (old.to_owned(), new.to_owned())));
    let both = "network.delay = 0.05\nnetwork.jitter = 0.02\nlaboratory.jitter = ";
    assert_eq!(study(&format!("{both}0.02")).unwrap().emulated_network().jitter(), 0.02);
    assert_eq!(study(&format!("{both}0.01")).unwrap_err().field, "laboratory.jitter");
    // what replaces the one replaces the other
    use telespring::study::{Replacement, Value};
    let replaced = |section: &str| {
        let keys = [("jitter".to_owned(), Some(Value::from(0.005)))];
        old.replace(&[(section.to_owned(), Replacement::Keys(keys.into()))].into()).unwrap()
    };
    assert_eq!(replaced("network"), replaced("laboratory"));
    assert_eq!(replaced("network").emulated_network().jitter(), 0.005);
}

#[test]
fn law_a_network_that_cannot_be_is_refused_by_its_key() {
    for (text, field) in [
        ("distribution = \"gamma\"", "network.distribution"),
        ("distribution = {kind = \"gamma\", mean = 0.004, sd = 0.002}", "network.distribution.kind"),
        (
            "jitter = 0.01\ndistribution = {kind = \"normal\", mean = 0.02, sd = 0.002}",
            "network.distribution.mean",
        ),
        (
            "jitter = 0.01\ndistribution = {kind = \"normal\", mean = 0.002, sd = 0.02}",
            "network.distribution.sd",
        ),
        ("distribution = {kind = \"uniform\", mean = 0.1}", "network.distribution"),
        ("loss = 2", "network.loss"),
        ("loss = {forward = 0.1, backward = 1.5}", "network.loss.backward"),
        ("burst = 0.1", "network.burst"),
        ("burst = {to_bad = 0.1}", "network.burst.to_good"),
        ("burst = {to_bad = 0.1, to_good = 1.5}", "network.burst.to_good"),
        ("burst = {p = 0.1}", "network.burst.p"),
        ("order = \"lifo\"", "network.order"),
        ("rate = 0", "network.rate"),
        ("rate = {bits_per_second = 1e6, queue = -1}", "network.rate.queue"),
        ("blackout = {start = 1}", "network.blackout.duration"),
        ("blackout = {duration = 1, period = 0.5}", "network.blackout.period"),
        (
            "trace = \"a.csv\"\njitter = 0.1\ndistribution = {kind = \"normal\", mean = 0.002, sd = 0.02}",
            "network.distribution",
        ),
    ] {
        let refused = study(&format!("[network]\n{text}\n")).unwrap_err();
        assert_eq!(refused.field, field, "{text}: {refused}");
    }
}

#[test]
fn law_a_study_with_a_trace_needs_its_content() {
    let text = "[network]\ntrace = {file = \"a.csv\", round_trip = true}\ndelay = 0.05\njitter = 0.02\n[protocol]\ntrials = 2\n";
    let given = study(text).unwrap();
    assert_eq!(Study::from_toml(&given.to_toml()).unwrap(), given);
    assert_eq!(given.laboratory().unwrap_err().field, "network.trace");
    let trace = Arc::new(read("time_s,delay_ms\n0,20\n1,40\n").unwrap());
    let laboratory = given.laboratory_on([Some(trace.clone()), Some(trace.clone())]).unwrap();
    laboratory.check().unwrap();
    let way = laboratory.network.backward.clone();
    assert_eq!((way.jitter, way.trace.unwrap().rows()[1].delay), (0.0, 0.02));
    // the same from the text of the files, with their names where they are refused
    let text = Some("time_s,delay_ms\n0,20\n1,40\n");
    assert_eq!(given.laboratory_on_texts([text, text]).unwrap(), laboratory);
    let refused = given.laboratory_on_texts([text, Some("time_s\n0\n")]).unwrap_err();
    assert_eq!(refused.field, "a.csv, trace, column delay");
    // of IRTT the round trip is halved, and one way is that of the direction
    let stamps = r#""timestamps": {"client": {"send": {"monotonic": 0}}}"#;
    let trip = |ms: u32| {
        let delay = r#""delay": {"rtt": 30000000, "send": 20000000, "receive": 10000000}"#;
        format!(
            r#"{{"lost": "false", {}, {delay}}}"#,
            stamps.replace(": 0", &format!(": {}", ms * 1_000_000))
        )
    };
    let irtt = format!(r#"{{"round_trips": [{}, {}]}}"#, trip(0), trip(10));
    let delays = |study: &Study| {
        let network = study.laboratory_on_texts([Some(&irtt), Some(&irtt)]).unwrap().network;
        [network.forward, network.backward].map(|way| way.trace.unwrap().rows()[1].delay)
    };
    assert_eq!(delays(&given), [0.015, 0.015]);
    let one_way = study("network.trace = \"a.json\"").unwrap();
    assert_eq!(delays(&one_way), [0.02, 0.01]);
    assert_eq!(study("").unwrap().laboratory_on([Some(trace), None]).unwrap_err().field, "traces");
}

#[test]
fn pin_uniform_jitter_and_independent_loss_draw_as_before() {
    // positions after 1 s as the first emulator gave them, which had nothing else
    let mut laboratory = Laboratory::paper();
    laboratory.network =
        Network::each_way(NetworkModel { jitter: 0.004, loss: 0.05, ..NetworkModel::ideal() });
    let schedule = Schedule::new(1.0, 100.0, 0.001).unwrap();
    for (stiffness, delay, expected) in [
        (
            71.2,
            0.0836,
            [[-0.046900358256811756, 0.07622370094106803], [-0.027995692200430553, 0.06380505327408491]],
        ),
        (
            142.0,
            0.05,
            [[-0.04709646645690854, 0.07266178675315473], [-0.027366791368631148, 0.0709874721145861]],
        ),
    ] {
        let trial = Trial { laboratory: &laboratory, coupling: coupled(stiffness, delay), seed: 7, schedule };
        let recording = trial.record::<InvalidInput>([None, None]).unwrap();
        assert_eq!(*recording.position.last().unwrap(), expected, "{stiffness} N/m");
    }
}
