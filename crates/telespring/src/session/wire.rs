//! Packets as bytes.
//!
//! | bytes | content |
//! |---|---|
//! | 0..4 | [`MAGIC`] |
//! | 4 | [`VERSION`] |
//! | 5 | number of axes, 2 |
//! | 6..14 | sequence number, u64 |
//! | 14..22 | time of measurement at the sender, ns, u64 |
//! | 22..38 | position per axis, m, f64 |
//! | 38..54 | velocity per axis, m/s, f64 |
//!
//! Numbers are little-endian. Position and velocity are sent together, because a coupling damper needs both
//! from the same instant.

use super::Nanoseconds;
use super::motion::{MAX_VALUE, Motion};

/// The first bytes of every packet.
pub const MAGIC: [u8; 4] = *b"TSPR";
/// The version of the packet layout.
pub const VERSION: u8 = 1;
/// The length of a packet in bytes.
pub const LENGTH: usize = 54;
const AXES: u8 = 2;

/// The content of a packet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Packet {
    /// The sequence number, from 0.
    pub sequence: u64,
    /// The time of measurement at the sender.
    pub time: Nanoseconds,
    /// The motion.
    pub motion: Motion,
}

/// Why bytes are not a valid packet.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PacketError {
    /// Too short or too long.
    #[error("a packet has {LENGTH} bytes, not {length}: it is truncated or comes from another program")]
    Length {
        /// The number of bytes received.
        length: usize,
    },
    /// Not a packet of this program.
    #[error("a packet begins with {MAGIC:?}, not {found:?}: it comes from another program")]
    Foreign {
        /// The first bytes received.
        found: [u8; 4],
    },
    /// An unknown packet layout.
    #[error(
        "the packet has version {found}, this side reads version {VERSION}: run the same release on both"
    )]
    Version {
        /// The version received.
        found: u8,
    },
    /// Another number of axes.
    #[error("the packet has {found} axes, this side has {AXES}: both robots need the same axes")]
    Axes {
        /// The number of axes received.
        found: u8,
    },
    /// An impossible position or velocity.
    #[error("the motion contains {value}: values must be finite and at most {MAX_VALUE}")]
    Value {
        /// The first such value.
        value: f64,
    },
}

/// Returns the motion if it is fit for a packet.
pub(super) fn check_motion(motion: Motion) -> Result<Motion, PacketError> {
    motion.impossible_value().map_or(Ok(motion), |value| Err(PacketError::Value { value }))
}

/// The `N` bytes of a packet from index `at`.
fn bytes_at<const N: usize>(bytes: &[u8; LENGTH], at: usize) -> [u8; N] {
    let mut out = [0; N];
    out.copy_from_slice(&bytes[at..at + N]);
    out
}

impl Packet {
    /// Encodes the packet as bytes.
    pub fn encode(&self) -> [u8; LENGTH] {
        let mut bytes = [0; LENGTH];
        bytes[..4].copy_from_slice(&MAGIC);
        (bytes[4], bytes[5]) = (VERSION, AXES);
        bytes[6..14].copy_from_slice(&self.sequence.to_le_bytes());
        bytes[14..22].copy_from_slice(&self.time.0.to_le_bytes());
        let Motion { position: [x, y], velocity: [u, v] } = self.motion;
        for (place, value) in bytes[22..].chunks_exact_mut(8).zip([x, y, u, v]) {
            place.copy_from_slice(&value.to_le_bytes());
        }
        bytes
    }

    /// Decodes a packet from bytes.
    ///
    /// # Errors
    ///
    /// [`PacketError`] if they are not a packet of this layout, or hold an impossible value.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::session::{Motion, Nanoseconds, Packet, PacketError};
    ///
    /// let motion = Motion { position: [0.01, -0.02], velocity: [0.0, 0.3] };
    /// let packet = Packet { sequence: 7, time: Nanoseconds(1_000_000), motion };
    /// assert_eq!(Packet::decode(&packet.encode()), Ok(packet));
    /// assert_eq!(Packet::decode(b"hello"), Err(PacketError::Length { length: 5 }));
    /// ```
    pub fn decode(bytes: &[u8]) -> Result<Self, PacketError> {
        let bytes: &[u8; LENGTH] =
            bytes.try_into().map_err(|_| PacketError::Length { length: bytes.len() })?;
        let found = bytes_at(bytes, 0);
        if found != MAGIC {
            return Err(PacketError::Foreign { found });
        }
        if bytes[4] != VERSION {
            return Err(PacketError::Version { found: bytes[4] });
        }
        if bytes[5] != AXES {
            return Err(PacketError::Axes { found: bytes[5] });
        }
        let number = |at| f64::from_le_bytes(bytes_at(bytes, at));
        let motion =
            check_motion(Motion { position: [number(22), number(30)], velocity: [number(38), number(46)] })?;
        Ok(Self {
            sequence: u64::from_le_bytes(bytes_at(bytes, 6)),
            time: Nanoseconds(u64::from_le_bytes(bytes_at(bytes, 14))),
            motion,
        })
    }
}
