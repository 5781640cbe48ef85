//! Adversaries: what stands between the two sides and does the worst it can.
//!
//! An adversary is a channel behind the emulated one: it gets every packet that the network delivers, sees the motion
//! of the side that receives, and hands over what it likes, once per tick. Nothing here knows the strategy of the
//! receiver: an adversary looks for the largest energy by the next tick only (it is greedy).

use std::collections::VecDeque;

use super::{Channel, Datagram};
use crate::error::Result;
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
    /// It forges nothing and keeps the order: its quality flips with the stretch of the spring. It is good when a swing of
    /// the two sides against each other turns. It is bad as long as the last packet that has passed shows the spring
    /// stretched more in the direction of the swing than any later one. The receiver then swings past where the partner
    /// was, and finds the spring stretched further than before. It looks at the axis on which the swing has been fastest so
    /// far, because the turns of both axes come at different times. No packet waits longer than `longest` s.
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
    /// The words for all adversaries, as a study writes them.
    pub const KINDS: [&str; 4] = ["oldest-sample", "most-harmful-sample", "stretch-timed", "lying-peer"];

    /// The word for the adversary.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::rig::Adversary;
    ///
    /// assert_eq!(Adversary::OldestSample { memory: 1.0 }.kind(), "oldest-sample");
    /// ```
    pub const fn kind(&self) -> &'static str {
        let [oldest, most_harmful, stretch_timed, lying] = Self::KINDS;
        match self {
            Self::OldestSample { .. } => oldest,
            Self::MostHarmfulSample { .. } => most_harmful,
            Self::StretchTimed { .. } => stretch_timed,
            Self::LyingPeer { .. } => lying,
        }
    }

    /// Checks the values of the adversary.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`](crate::InvalidInput) with the field.
    pub fn check(&self) -> Result<()> {
        match *self {
            Self::OldestSample { memory } | Self::MostHarmfulSample { memory } => {
                quantity::SPAN.check("memory", memory)?;
            }
            Self::StretchTimed { longest } => {
                quantity::SPAN.check("longest", longest)?;
            }
            Self::LyingPeer { position, stamp, power } => {
                quantity::POSITION_SHIFT.check("position", position)?;
                quantity::STAMP_SHIFT.check("stamp", stamp)?;
                quantity::POWER.check("power", power)?;
            }
        }
        Ok(())
    }
}

/// A packet that the network has delivered to an adversary.
#[derive(Debug, Clone, Copy)]
struct Came {
    at: LocalTime,
    packet: Packet,
    /// The motion of the receiver when it was sent.
    receiver: Motion,
}

impl Came {
    /// How far the partner was from the receiver when the adversary's packet was sent, m.
    fn stretch(&self) -> [f64; 2] {
        combined(self.packet.motion.position, self.receiver.position, |partner, own| partner - own)
    }

    /// The mean velocity of both sides when the adversary's packet was sent, m/s.
    fn common_velocity(&self) -> [f64; 2] {
        combined(self.packet.motion.velocity, self.receiver.velocity, |partner, own| 0.5 * (partner + own))
    }
}

/// An adversary behind a network.
#[derive(Debug)]
pub struct AdversaryChannel {
    adversary: Adversary,
    network: Box<dyn Channel>,
    receiver: Motion,
    /// The motions of the receiver, from the one on when the newest packet was sent.
    seen: VecDeque<(LocalTime, Motion)>,
    /// What came and waits or is remembered, the oldest first.
    came: VecDeque<Came>,
    /// The stretch of the spring when the last packet that has passed was sent, m.
    passed: Option<[f64; 2]>,
    /// The largest speed of the swing of both sides against each other so far per axis, m/s.
    fastest: [f64; 2],
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
            seen: VecDeque::new(),
            came: VecDeque::new(),
            passed: None,
            fastest: [0.0; 2],
            sequence: 0,
            served: None,
            out: VecDeque::new(),
        }
    }

    /// Takes what the network delivers and decides what the receiver gets at this tick.
    fn serve(&mut self, now: LocalTime) {
        let already = self.came.len();
        let receiver = self.receiver;
        self.seen.push_back((now, receiver));
        while let Some(bytes) = self.network.deliver(now) {
            if let Ok(packet) = Packet::decode(&bytes) {
                let receiver = self.receiver_at(LocalTime(packet.sent.0));
                self.came.push_back(Came { at: now, packet, receiver });
            }
        }
        match self.adversary {
            Adversary::OldestSample { memory } => {
                self.forget_before(now - Span::from_seconds(memory));
                let oldest = self.came.front().map(|came| came.packet.motion);
                self.forge(now, oldest);
            }
            Adversary::MostHarmfulSample { memory } => {
                self.forget_before(now - Span::from_seconds(memory));
                let harm = |motion: &Motion| dot(motion.position, receiver.velocity);
                let motions = self.came.iter().map(|came| came.packet.motion);
                let worst = motions.max_by(|a, b| harm(a).total_cmp(&harm(b)));
                self.forge(now, worst);
            }
            Adversary::StretchTimed { longest } => self.withhold(now, Span::from_seconds(longest)),
            Adversary::LyingPeer { position, stamp, power } => {
                for Came { packet, .. } in self.came.drain(already..) {
                    let lie =
                        lie(packet, receiver, position, Span::from_seconds(stamp), power * now.seconds());
                    self.out.push_back(lie.encode());
                }
            }
        }
    }

    /// The receiver at the time at which a packet was sent to the adversary, which knows both clocks; it forgets what was before.
    fn receiver_at(&mut self, time: LocalTime) -> Motion {
        while self.seen.get(1).is_some_and(|(next, _)| *next <= time) {
            self.seen.pop_front();
        }
        self.seen.front().map_or(self.receiver, |(_, motion)| *motion)
    }

    /// The adversary forgets what came before `time`, but never the newest packet.
    fn forget_before(&mut self, time: LocalTime) {
        while self.came.len() > 1 && self.came.front().is_some_and(|came| came.at < time) {
            self.came.pop_front();
        }
    }

    /// The adversary hands over a motion in a packet that looks newer than all before it.
    fn forge(&mut self, now: LocalTime, motion: Option<Motion>) {
        let (Some(motion), Some(newest)) = (motion, self.came.back()) else { return };
        let sent = PeerTime((newest.packet.sent + (now - newest.at)).0.min(MAX_STAMP));
        let forged = Packet { motion, sent, sequence: self.sequence, ..newest.packet };
        self.sequence += 1;
        self.out.push_back(forged.encode());
    }

    /// The adversary lets those packets pass that have waited longest, and all up to the one at which the spring was
    /// stretched most in the direction of the swing, if that is more than at the last one that has passed.
    fn withhold(&mut self, now: LocalTime, longest: Span) {
        let Some(newest) = self.came.back() else { return };
        let [u, v] = combined(self.receiver.velocity, newest.common_velocity(), |own, common| own - common);
        self.fastest = [self.fastest[0].max(u.abs()), self.fastest[1].max(v.abs())];
        let swing = if self.fastest[0] >= self.fastest[1] { [u, 0.0] } else { [0.0, v] };
        let mut passing = self.came.partition_point(|came| now - came.at >= longest);
        let last = self.came.iter().take(passing).next_back().map(Came::stretch).or(self.passed);
        let mut most = last.map_or(f64::NEG_INFINITY, |stretch| dot(stretch, swing));
        for (n, came) in self.came.iter().enumerate().skip(passing) {
            // of two that are equal the newer one: at rest nothing is withheld
            let along = dot(came.stretch(), swing);
            if along >= most {
                (most, passing) = (along, n + 1);
            }
        }
        for came in self.came.drain(..passing) {
            self.passed = Some(came.stretch());
            self.out.push_back(came.packet.encode());
        }
    }
}

/// The scalar product of what an adversary compares.
fn dot([a, b]: [f64; 2], [c, d]: [f64; 2]) -> f64 {
    a * c + b * d
}

/// Two pairs of values of an adversary, combined per axis.
fn combined([a, b]: [f64; 2], [c, d]: [f64; 2], combine: impl Fn(f64, f64) -> f64) -> [f64; 2] {
    [combine(a, c), combine(b, d)]
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
