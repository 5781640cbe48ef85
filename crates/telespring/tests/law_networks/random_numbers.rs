//! The random numbers of the impairments.

use telespring::InvalidInput;
use telespring::rig::{
    GilbertElliott, JitterDistribution, Laboratory, Network, NetworkModel, PacketOrder, Schedule, Trial,
};
use telespring::session::{LocalTime, Span};

use crate::passage::{numbered, passage};
use crate::trials::coupled;

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
