//! A partner of which nothing is true: position, velocity, stamps, echoes, session and totals.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use telespring::rig::{Channel, Datagram};
use telespring::session::wire::{Echo, MAX_ENERGY, MAX_STAMP, MAX_STIFFNESS};
use telespring::session::{LocalTime, Motion, Packet, PeerTime, Span};

/// Alters every packet of a channel, in ways that the receiver must take.
#[derive(Debug)]
pub struct Liar {
    pub channel: Box<dyn Channel>,
    pub random: ChaCha8Rng,
    pub receiver: Motion,
    /// What it adds to its session id: every now and then it starts anew.
    pub restarts: u64,
}

impl Liar {
    fn alter(&mut self, now: LocalTime, packet: Packet) -> Packet {
        let random = &mut self.random;
        let size = 10.0_f64.powf(random.random_range(-3.0..5.9));
        let Motion { position, velocity } = self.receiver;
        let position = [0, 1].map(|axis| (position[axis] + size.copysign(velocity[axis])).clamp(-1e6, 1e6));
        let mut shift = || Span::from_seconds(10.0_f64.powf(random.random_range(-3.0..6.0)));
        let (back, forth, held) = (shift(), shift(), shift());
        let sent = match random.random_range(0..8) {
            0 => packet.sent - back,
            1 => packet.sent + forth,
            _ => packet.sent,
        };
        let echo = Echo { stamp: now - held, held };
        if random.random_bool(1e-3) {
            self.restarts += 1;
        }
        let totals = [0.0, 1e-3, 10.0 * random.random::<f64>(), MAX_ENERGY];
        Packet {
            session: packet.session + 16 * self.restarts,
            sent: PeerTime(sent.0.min(MAX_STAMP)),
            echo: if random.random_bool(0.1) { Some(echo) } else { packet.echo },
            motion: Motion { position, velocity: [0, 1].map(|_| random.random_range(-1e3..1e3)) },
            energy_sent: totals[random.random_range(0..totals.len())],
            stiffness: MAX_STIFFNESS * random.random::<f64>(),
            ..packet
        }
    }
}

impl Channel for Liar {
    fn send(&mut self, now: LocalTime, packet: Datagram) {
        self.channel.send(now, packet);
    }

    fn deliver(&mut self, now: LocalTime) -> Option<Datagram> {
        let packet = Packet::decode(&self.channel.deliver(now)?).unwrap();
        Some(self.alter(now, packet).encode())
    }

    fn observe(&mut self, receiver: Motion) {
        self.receiver = receiver;
        self.channel.observe(receiver);
    }
}
