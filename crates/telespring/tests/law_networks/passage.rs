//! What comes through a network's channel, and when.

use telespring::rig::{Datagram, NetworkModel};
use telespring::session::wire::LENGTH;
use telespring::session::{LocalTime, Span};

const PERIOD: Span = Span(1_000_000);

/// What every packet takes at least.
pub const TRAVEL: Span = Span(20_000_000);

/// A packet that carries its number.
pub fn numbered(number: u64) -> Datagram {
    let mut packet = [0; LENGTH];
    packet[..8].copy_from_slice(&number.to_le_bytes());
    packet
}

/// Number and delay (ns) of all packets in the order in which they come, one sent every ms.
///
/// Asked for at every moment at which one can come: the channel says nothing about when it will deliver.
pub fn passage(model: &NetworkModel, seed: u64, packets: u64, look: u64) -> Vec<(u64, u64)> {
    passage_towards(model, seed, 0, packets, look)
}

/// The same towards a side.
pub fn passage_towards(
    model: &NetworkModel,
    seed: u64,
    side: usize,
    packets: u64,
    look: u64,
) -> Vec<(u64, u64)> {
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
