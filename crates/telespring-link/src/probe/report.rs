//! What a side tells the other of the packets that came, byte by byte.
//!
//! | bytes | content | type |
//! |---|---|---|
//! | 0–3 | `TSPB` | 4 bytes |
//! | 4 | version, 1 | u8 |
//! | 5–7 | unused, 0 | |
//! | 8–15 | session id of the sender, never 0 | u64 |
//! | 16–23 | session id of the receiver | u64 |
//! | 24–31 | the sender's first packet of the measurement | u64 |
//! | 32–39 | its packets of the measurement | u64 |
//! | 40–47 | blocks of its report | u64 |
//! | 48–55 | blocks of the receiver's report that it has, without a gap | u64 |
//! | 56–63 | this block | u64 |
//! | 64–71 | what every travel below is counted from, ns: arrival less stamp, on two clocks | i64 |
//! | 72–111 | travels of [`PER_BLOCK`] packets of the receiver, 100 ns; 2³² − 1: it did not come | 10 × u32 |

use telespring::session::wire::LENGTH;

/// The first bytes of every report.
const MAGIC: [u8; 4] = *b"TSPB";
/// The version of the report.
const VERSION: u8 = 1;
/// Packets that a block tells of.
pub(super) const PER_BLOCK: usize = 10;
/// The travel of a packet that did not come.
pub(super) const ABSENT: u32 = u32::MAX;

/// One block of a report.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Report {
    pub(super) session: u64,
    pub(super) partner: u64,
    pub(super) first: u64,
    pub(super) packets: u64,
    pub(super) blocks: u64,
    pub(super) acknowledged: u64,
    pub(super) block: u64,
    pub(super) base: i64,
    pub(super) travels: [u32; PER_BLOCK],
}

impl Report {
    pub(super) fn encode(&self) -> [u8; LENGTH] {
        let Self { session, partner, first, packets, blocks, acknowledged, block, base, travels } = *self;
        let head = MAGIC.into_iter().chain([VERSION, 0, 0, 0]);
        let words = [session, partner, first, packets, blocks, acknowledged, block, base.cast_unsigned()];
        let body = words.into_iter().flat_map(u64::to_le_bytes);
        let rest = travels.into_iter().flat_map(u32::to_le_bytes);
        let mut datagram = [0; LENGTH];
        datagram.iter_mut().zip(head.chain(body).chain(rest)).for_each(|(place, byte)| *place = byte);
        datagram
    }

    pub(super) fn decode(datagram: &[u8]) -> Option<Self> {
        let datagram: &[u8; LENGTH] = datagram.try_into().ok()?;
        let (words, travels) = datagram.split_at(72);
        let mut words = words.chunks_exact(8).map(|bytes| bytes.try_into().map_or(0, u64::from_le_bytes));
        let [head, session, partner, first, packets, blocks, acknowledged, block, base] =
            std::array::from_fn(|_| words.next().unwrap_or(0));
        let [m, a, g, i, version, unused @ ..] = head.to_le_bytes();
        if [m, a, g, i] != MAGIC || version != VERSION || unused != [0; 3] || session == 0 {
            return None;
        }
        let mut travels =
            travels.chunks_exact(4).map(|bytes| bytes.try_into().map_or(ABSENT, u32::from_le_bytes));
        let travels = std::array::from_fn(|_| travels.next().unwrap_or(ABSENT));
        let base = base.cast_signed();
        Some(Self { session, partner, first, packets, blocks, acknowledged, block, base, travels })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_a_report_survives_encoding() {
        let report = Report {
            session: 1,
            partner: 2,
            first: 3,
            packets: 4,
            blocks: 5,
            acknowledged: 6,
            block: 7,
            base: -8,
            travels: std::array::from_fn(|place| 9 + place as u32),
        };
        assert_eq!(Report::decode(&report.encode()), Some(report));
        for at in 0..8 {
            let mut bytes = report.encode();
            bytes[at] ^= 1;
            assert_eq!(Report::decode(&bytes), None);
        }
        assert_eq!(Report::decode(&report.encode()[1..]), None);
        assert_eq!(Report::decode(&Report { session: 0, ..report }.encode()), None);
        // a session takes it neither for a greeting nor for a packet
        assert!(crate::hello::Greeting::decode(&report.encode()).is_err());
        assert!(telespring::session::wire::Packet::decode(&report.encode()).is_err());
    }
}
