//! What a liar may say within the protocol.

use telespring::session::motion::MAX_VALUE;
use telespring::session::wire::{Echo, Flags, MAX_ENERGY, MAX_SIGNAL, MAX_STAMP, MAX_STIFFNESS, Packet};
use telespring::session::{LocalTime, Motion, PeerTime, Span};
use telespring_link::hello::fingerprint;

use super::{Lie, Tongue};

/// All of them.
pub const ALL: [(&str, Tongue); 14] = [
    ("far", far),
    ("to and fro", to_and_fro),
    ("pump", pump),
    ("pump and pay", pump_and_pay),
    ("more and more energy", more_and_more_energy),
    ("absurd quantities", absurd_quantities),
    ("stamps of another age", stamps_of_another_age),
    ("numbers from nowhere", numbers_from_nowhere),
    ("echoes that nobody called", echoes_that_nobody_called),
    ("other sessions", other_sessions),
    ("many times over", many_times_over),
    ("now and then", now_and_then),
    ("still but fast", still_but_fast),
    ("anything", anything),
];

fn at(position: [f64; 2]) -> Motion {
    Motion { position, velocity: [0.0; 2] }
}

/// A number that nobody foresees, from 0 to below 1.
fn chance(tick: u64, stream: u64) -> f64 {
    let bits = fingerprint(&[tick.to_le_bytes(), stream.to_le_bytes()].concat());
    (bits >> 11) as f64 / (1_u64 << 53) as f64
}

fn far(lie: &Lie) -> Vec<Packet> {
    vec![Packet { motion: at([MAX_VALUE, -MAX_VALUE]), ..lie.truth }]
}

fn to_and_fro(lie: &Lie) -> Vec<Packet> {
    let far = if lie.tick.is_multiple_of(2) { MAX_VALUE } else { -MAX_VALUE };
    vec![Packet { motion: Motion { position: [far; 2], velocity: [-far; 2] }, ..lie.truth }]
}

/// Always ahead of the hand, whichever way it goes.
pub fn pump(lie: &Lie) -> Vec<Packet> {
    let Motion { position, velocity } = lie.victim;
    let ahead = [0, 1].map(|axis| position[axis] + 10.0 * velocity[axis].signum());
    vec![Packet { motion: at(ahead), ..lie.truth }]
}

fn pump_and_pay(lie: &Lie) -> Vec<Packet> {
    pump(lie).into_iter().map(|packet| Packet { energy_sent: MAX_ENERGY, ..packet }).collect()
}

fn more_and_more_energy(lie: &Lie) -> Vec<Packet> {
    let energy_sent = (lie.tick as f64).powi(3);
    to_and_fro(lie).into_iter().map(|packet| Packet { energy_sent, ..packet }).collect()
}

fn absurd_quantities(lie: &Lie) -> Vec<Packet> {
    let flags = Flags::from_bits((lie.tick % 32) as u16).unwrap();
    let stiffness = if lie.tick.is_multiple_of(2) { MAX_STIFFNESS } else { 0.0 };
    vec![Packet { flags, stiffness, signal: [MAX_SIGNAL, -MAX_SIGNAL], ..lie.truth }]
}

fn stamps_of_another_age(lie: &Lie) -> Vec<Packet> {
    let sent = [0, 1, MAX_STAMP / 2, MAX_STAMP][(lie.tick / 7 % 4) as usize];
    vec![Packet { sent: PeerTime(sent), ..lie.truth }]
}

fn numbers_from_nowhere(lie: &Lie) -> Vec<Packet> {
    let sequence = [u64::MAX, 0, lie.truth.sequence, u64::MAX / 2][(lie.tick / 11 % 4) as usize];
    vec![Packet { sequence, ..lie.truth }]
}

fn echoes_that_nobody_called(lie: &Lie) -> Vec<Packet> {
    let stamp = LocalTime([1, 100_000_000_000, MAX_STAMP][(lie.tick % 3) as usize]);
    let held = Span([0, 1_000_000_000_000, MAX_STAMP.cast_signed()][(lie.tick / 3 % 3) as usize]);
    vec![Packet { echo: Some(Echo { stamp, held }), ..lie.truth }]
}

fn other_sessions(lie: &Lie) -> Vec<Packet> {
    let sessions = [31, lie.tick, 0, lie.truth.session];
    sessions.map(|session| Packet { session, motion: at([MAX_VALUE; 2]), ..lie.truth }).into()
}

fn many_times_over(lie: &Lie) -> Vec<Packet> {
    vec![lie.truth; 200]
}

fn now_and_then(lie: &Lie) -> Vec<Packet> {
    if lie.tick.is_multiple_of(149) { to_and_fro(lie) } else { Vec::new() }
}

fn still_but_fast(lie: &Lie) -> Vec<Packet> {
    vec![Packet { motion: Motion { position: [0.3, 0.0], velocity: [1.0, 0.0] }, ..lie.truth }]
}

/// Every field may be anything, one packet in three stays away, and some are true.
fn anything(lie: &Lie) -> Vec<Packet> {
    let Lie { tick, victim, truth } = *lie;
    let mut packet = truth;
    let big =
        |stream, largest: f64| (chance(tick, stream) - 0.5) * 2.0 * largest.powf(chance(tick, stream + 1));
    match (chance(tick, 0) * 9.0) as u32 {
        0..3 => return Vec::new(),
        3 => packet.motion.position = [big(1, MAX_VALUE), big(3, MAX_VALUE)],
        4 => packet.motion.position = [0, 1].map(|axis| victim.position[axis] + big(5 + axis as u64, 1.0)),
        5 => packet.energy_sent = big(7, MAX_ENERGY).abs(),
        6 => packet.sent = PeerTime((chance(tick, 9) * MAX_STAMP as f64) as u64),
        7 => packet.sequence = (chance(tick, 10) * u64::MAX as f64) as u64,
        _ => {}
    }
    vec![packet]
}
