//! Adversaries: what stands between the two sides and does the worst it can.
//!
//! An adversary is a channel behind the emulated one: it gets every packet that the network delivers, sees the motion
//! of the side that receives, and hands over what it likes, once per tick. Nothing here knows the strategy of the
//! receiver: an adversary looks for the largest energy by the next tick only (it is greedy).

use std::collections::VecDeque;

use super::{Channel, Datagram};
use crate::error::{InvalidInput, Result};
use crate::quantity;
use crate::session::wire::{MAX_ENERGY, MAX_STAMP};
use crate::session::{LocalTime, Motion, Packet, PeerTime, Span, motion};

/// What an adversary on the network does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Adversary {
    /// It hands over the oldest motion of the last `memory` s as if it were new: with the newest stamp.
    OldestSample {
        /// How far back it goes, s.
        memory: f64,
    },
    /// It hands over the most harmful motion of the last `memory` s as if it were new: the one that lets a spring
    /// give the most power to the receiver, the largest y·v of its position y and the receiver's velocity v.
    MostHarmfulSample {
        /// How far back it goes, s.
        memory: f64,
    },
    /// It forges nothing: it withholds packets while the spring relaxes and lets them pass while it is stretched, so
    /// that the receiver feels a spring that returns more than it took. No packet waits longer than `longest` s.
    StretchTimed {
        /// The longest wait, s.
        longest: f64,
    },
    /// A partner that lies: it alters every packet.
    LyingPeer {
        /// How far it moves its position along the receiver's velocity, m.
        position: f64,
        /// What it adds to its stamps, s; negative makes its motion older.
        stamp: f64,
        /// The energy that it claims to have sent beyond the truth, per second, W.
        power: f64,
    },
}

impl Adversary {
    /// Checks the values of the adversary.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] with the field.
    pub fn check(&self) -> Result<()> {
        match *self {
            Self::OldestSample { memory } | Self::MostHarmfulSample { memory } => {
                quantity::SPAN.check("memory", memory)?;
            }
            Self::StretchTimed { longest } => {
                quantity::SPAN.check("longest", longest)?;
            }
            Self::LyingPeer { position, stamp, power } => {
                quantity::AMPLITUDE.check("position", position)?;
                quantity::POWER.check("power", power)?;
                if !(stamp.abs() <= quantity::SPAN.maximum()) {
                    return Err(InvalidInput::new(
                        "stamp",
                        format!("{stamp:?}"),
                        format!(
                            "a shift of stamps is at most {} s, backwards or forwards",
                            quantity::SPAN.maximum()
                        ),
                        "Write the shift in s.",
                    ));
                }
            }
        }
        Ok(())
    }
}

/// An adversary behind a network.
#[derive(Debug)]
pub struct AdversaryChannel {
    adversary: Adversary,
    network: Box<dyn Channel>,
    receiver: Motion,
    /// What came, with its time, the oldest first.
    came: VecDeque<(LocalTime, Packet)>,
    /// The distance of the receiver from the newest position at the last tick, squared, m².
    stretch: f64,
    /// The sequence number of the next forged packet.
    sequence: u64,
    /// The tick at which it has done its work.
    served: Option<LocalTime>,
    /// What it hands over at this tick.
    out: VecDeque<Datagram>,
}

impl AdversaryChannel {
    /// The adversary behind this network, with nothing seen yet.
    pub fn new(adversary: Adversary, network: Box<dyn Channel>) -> Self {
        Self {
            adversary,
            network,
            receiver: Motion::default(),
            came: VecDeque::new(),
            stretch: 0.0,
            sequence: 0,
            served: None,
            out: VecDeque::new(),
        }
    }

    /// Takes what the network delivers and decides what the receiver gets at this tick.
    fn serve(&mut self, now: LocalTime) {
        let already = self.came.len();
        while let Some(bytes) = self.network.deliver(now) {
            if let Ok(packet) = Packet::decode(&bytes) {
                self.came.push_back((now, packet));
            }
        }
        let receiver = self.receiver;
        match self.adversary {
            Adversary::OldestSample { memory } => {
                self.forget_before(now - Span::from_seconds(memory));
                let oldest = self.came.front().map(|(_, packet)| packet.motion);
                self.forge(now, oldest);
            }
            Adversary::MostHarmfulSample { memory } => {
                self.forget_before(now - Span::from_seconds(memory));
                let harm = |motion: &Motion| {
                    motion.position[0] * receiver.velocity[0] + motion.position[1] * receiver.velocity[1]
                };
                let worst = self
                    .came
                    .iter()
                    .map(|(_, packet)| packet.motion)
                    .max_by(|a, b| harm(a).total_cmp(&harm(b)));
                self.forge(now, worst);
            }
            Adversary::StretchTimed { longest } => self.withhold(now, Span::from_seconds(longest)),
            Adversary::LyingPeer { position, stamp, power } => {
                for (_, packet) in self.came.drain(already..) {
                    let lie =
                        lie(packet, receiver, position, Span::from_seconds(stamp), power * now.seconds());
                    self.out.push_back(lie.encode());
                }
            }
        }
    }

    /// The adversary forgets what came before `time`, but never the newest packet.
    fn forget_before(&mut self, time: LocalTime) {
        while self.came.len() > 1 && self.came.front().is_some_and(|(came, _)| *came < time) {
            self.came.pop_front();
        }
    }

    /// The adversary hands over a motion in a packet that looks newer than all before it.
    fn forge(&mut self, now: LocalTime, motion: Option<Motion>) {
        let (Some(motion), Some((came, newest))) = (motion, self.came.back()) else { return };
        let sent = PeerTime((newest.sent + (now - *came)).0.min(MAX_STAMP));
        let forged = Packet { motion, sent, sequence: self.sequence, ..*newest };
        self.sequence += 1;
        self.out.push_back(forged.encode());
    }

    /// The adversary withholds packets while the spring relaxes.
    fn withhold(&mut self, now: LocalTime, longest: Span) {
        let Some((_, newest)) = self.came.back() else { return };
        let [x, y] = [0, 1].map(|axis| newest.motion.position[axis] - self.receiver.position[axis]);
        let stretch = x * x + y * y;
        let is_relaxing = stretch < self.stretch;
        self.stretch = stretch;
        let passed = match is_relaxing {
            true => self.came.partition_point(|(came, _)| now - *came >= longest),
            false => self.came.len(),
        };
        self.out.extend(self.came.drain(..passed).map(|(_, packet)| packet.encode()));
    }
}

/// The packet of a partner that lies to the receiver with this motion.
fn lie(packet: Packet, receiver: Motion, position: f64, stamp: Span, energy: f64) -> Packet {
    let Motion { position: told, velocity } = packet.motion;
    let speed = receiver.velocity[0].hypot(receiver.velocity[1]);
    let along = if speed > 0.0 { receiver.velocity.map(|value| value / speed) } else { [1.0, 0.0] };
    let limit = motion::MAX_VALUE;
    Packet {
        motion: Motion {
            position: [0, 1].map(|axis| (told[axis] + position * along[axis]).clamp(-limit, limit)),
            velocity,
        },
        sent: PeerTime((packet.sent + stamp).0.min(MAX_STAMP)),
        energy_sent: (packet.energy_sent + energy).min(MAX_ENERGY),
        ..packet
    }
}

impl Channel for AdversaryChannel {
    fn send(&mut self, now: LocalTime, packet: Datagram) {
        self.network.send(now, packet);
    }

    fn deliver(&mut self, now: LocalTime) -> Option<Datagram> {
        if self.served != Some(now) {
            self.served = Some(now);
            self.serve(now);
        }
        self.out.pop_front()
    }

    fn observe(&mut self, receiver: Motion) {
        self.receiver = receiver;
        self.network.observe(receiver);
    }
}
