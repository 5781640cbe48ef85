//! What each adversary hands over, packet by packet.

use std::collections::VecDeque;

use telespring::rig::network::adversary::AdversaryChannel;
use telespring::rig::{Adversary, Channel, Datagram};
use telespring::session::{LocalTime, Motion, Packet, PeerTime};

/// A channel that hands packets over at once.
#[derive(Debug, Default)]
struct Wire(VecDeque<Datagram>);

impl Channel for Wire {
    fn send(&mut self, _: LocalTime, packet: Datagram) {
        self.0.push_back(packet);
    }

    fn deliver(&mut self, _: LocalTime) -> Option<Datagram> {
        self.0.pop_front()
    }
}

/// What an adversary hands over at tick n if the partner is at n mm at tick n and the receiver moves with `velocity`.
fn handed_over(adversary: Adversary, velocity: f64, ticks: u64) -> Vec<Vec<Packet>> {
    let mut channel = AdversaryChannel::new(adversary, Box::new(Wire::default()));
    let serve = |n: u64| {
        let now = LocalTime(n * 1_000_000);
        let motion = Motion { position: [n as f64 * 1e-3, 0.0], velocity: [0.0; 2] };
        channel.send(now, Packet { energy_sent: 2.0, ..Packet::of(n, PeerTime(now.0), motion) }.encode());
        channel.observe(Motion { position: [0.0; 2], velocity: [velocity, 0.0] });
        std::iter::from_fn(|| channel.deliver(now)).map(|bytes| Packet::decode(&bytes).unwrap()).collect()
    };
    (0..ticks).map(serve).collect()
}

#[test]
fn law_an_adversary_hands_over_what_it_says() {
    for (tick, packets) in handed_over(Adversary::OldestSample { memory: 0.01 }, 1.0, 40).iter().enumerate() {
        let [packet] = packets[..] else { panic!("{packets:?}") };
        assert_eq!(packet.sent, PeerTime(tick as u64 * 1_000_000));
        assert_eq!(packet.motion.position[0], tick.saturating_sub(10) as f64 * 1e-3);
        assert_eq!(packet.sequence, tick as u64);
    }
    // moving towards the partner the newest is the farthest, away from it the oldest
    let harmful = Adversary::MostHarmfulSample { memory: 0.01 };
    assert_eq!(handed_over(harmful, 1.0, 40)[39][0].motion.position[0], 0.039);
    assert_eq!(handed_over(harmful, -1.0, 40)[39][0].motion.position[0], 0.029);
    let liar = Adversary::LyingPeer { position: 0.1, stamp: -0.002, power: 5.0 };
    let [lie] = handed_over(liar, -2.0, 11)[10][..] else { panic!() };
    assert!((lie.motion.position[0] - (0.010 - 0.1)).abs() < 1e-15);
    assert_eq!(lie.sent, PeerTime(8_000_000));
    assert!((lie.energy_sent - (2.0 + 5.0 * 0.01)).abs() < 1e-12);
    // moving after the partner, or not at all, nothing is withheld; away from it each packet waits its 10 ms
    for (velocity, waits) in [(1.0, 0), (0.0, 0), (-1.0, 10)] {
        let flips = handed_over(Adversary::StretchTimed { longest: 0.01 }, velocity, 40);
        for (tick, packets) in flips.iter().enumerate().skip(1) {
            let came: Vec<u64> = packets.iter().map(|packet| packet.sequence).collect();
            let expected: Vec<u64> =
                (tick as u64).checked_sub(waits).filter(|n| *n > 0).into_iter().collect();
            assert_eq!(came, expected, "{velocity}, tick {tick}");
        }
    }
}
