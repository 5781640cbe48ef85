//! A packet as bytes.
//!
//! | bytes | content |
//! |---|---|
//! | 0..4 | [`MAGIC`] |
//! | 4 | [`VERSION`] |
//! | 5 | number of axes, 2 |
//! | 6..14 | sequence number, u64 |
//! | 14..22 | when the sender measured, ns, u64 |
//! | 22..38 | position per axis, m, f64 |
//! | 38..54 | velocity per axis, m/s, f64 |
//!
//! Numbers are little-endian. Position and velocity travel together, because a coupling damper is only
//! as good as the position measured with it.

use super::Nanoseconds;

/// How every packet begins.
pub const MAGIC: [u8; 4] = *b"TSPR";
/// The layout that this module reads and writes.
pub const VERSION: u8 = 1;
/// Bytes of a packet.
pub const LENGTH: usize = 54;
/// The largest position (m) or velocity (m/s) that a packet may carry: beyond it no handle moves, and
/// every force computed from it would still be finite.
pub const MAX_VALUE: f64 = 1e6;

const AXES: u8 = 2;

/// How a handle moves at one instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Motion {
    /// Position per axis, m.
    pub position: [f64; 2],
    /// Velocity per axis, m/s.
    pub velocity: [f64; 2],
}

impl Motion {
    /// The motion itself where every value is finite and at most [`MAX_VALUE`].
    ///
    /// # Errors
    ///
    /// [`PacketError::Value`] otherwise.
    pub fn check(self) -> Result<Self, PacketError> {
        let values = [self.position, self.velocity];
        match values.iter().flatten().find(|value| !(value.abs() <= MAX_VALUE)) {
            None => Ok(self),
            Some(&value) => Err(PacketError::Value { value }),
        }
    }
}

/// What one side tells the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Packet {
    /// Counts up from 0.
    pub sequence: u64,
    /// When the sender measured the motion.
    pub time: Nanoseconds,
    /// The motion.
    pub motion: Motion,
}

/// Why bytes were not taken as a packet.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PacketError {
    /// Too short or too long.
    #[error("a packet has {LENGTH} bytes; these are {length}: it was cut, or comes from something else")]
    Length {
        /// How many came.
        length: usize,
    },
    /// Not a packet of this program.
    #[error("a packet begins with {MAGIC:?}, not {found:?}: it comes from another program")]
    Foreign {
        /// How it began.
        found: [u8; 4],
    },
    /// A layout that is not known here.
    #[error(
        "the packet has version {found}, this side reads version {VERSION}: run the same release on both"
    )]
    Version {
        /// Its version.
        found: u8,
    },
    /// Another number of axes.
    #[error("the packet has {found} axes, this side has {AXES}: both robots need the same axes")]
    Axes {
        /// How many it has.
        found: u8,
    },
    /// A position or velocity that no handle has.
    #[error("the motion holds {value}, which no handle has: values are finite and at most {MAX_VALUE}")]
    Value {
        /// The first such value.
        value: f64,
    },
}

/// `N` bytes from `at` on.
fn take<const N: usize>(bytes: &[u8; LENGTH], at: usize) -> [u8; N] {
    let mut out = [0; N];
    out.copy_from_slice(&bytes[at..at + N]);
    out
}

impl Packet {
    /// As bytes.
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

    /// From bytes.
    ///
    /// # Errors
    ///
    /// [`PacketError`] where they are no packet of this layout, or hold a value that no handle has.
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
        let found = take(bytes, 0);
        if found != MAGIC {
            return Err(PacketError::Foreign { found });
        }
        if bytes[4] != VERSION {
            return Err(PacketError::Version { found: bytes[4] });
        }
        if bytes[5] != AXES {
            return Err(PacketError::Axes { found: bytes[5] });
        }
        let number = |at| f64::from_le_bytes(take(bytes, at));
        let motion =
            Motion { position: [number(22), number(30)], velocity: [number(38), number(46)] }.check()?;
        Ok(Self {
            sequence: u64::from_le_bytes(take(bytes, 6)),
            time: Nanoseconds(u64::from_le_bytes(take(bytes, 14))),
            motion,
        })
    }
}
