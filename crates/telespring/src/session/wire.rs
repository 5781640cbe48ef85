//! Packets as bytes, version 2.
//!
//! A packet has [`LENGTH`] bytes. Numbers are little-endian; u64 and f64 have 8 bytes, f64 as in IEEE 754. There is no
//! padding: every byte has a meaning and is checked.
//!
//! | bytes | content | allowed |
//! |---|---|---|
//! | 0..4 | [`MAGIC`], `TSPR` | just this |
//! | 4 | [`VERSION`], u8 | 2 |
//! | 5 | number of axes, u8 | 2 |
//! | 6..8 | [`Flags`], u16: bit 0 engaged, 1 holding, 2 ramping, 3 limited, 4 restarted | other bits 0 |
//! | 8..16 | session id, u64: drawn anew whenever the sender starts | any |
//! | 16..24 | sequence number, u64, from 0 | any |
//! | 24..32 | sent stamp, ns on the sender's clock, u64: when the motion was measured and sent | up to [`MAX_STAMP`] |
//! | 32..40 | echo stamp, ns on the receiver's clock, u64: the newest stamp that the sender knows of the receiver | up to [`MAX_STAMP`]; 0: none |
//! | 40..48 | echo held, ns on the sender's clock, u64: from the arrival of that stamp to the sent stamp | up to [`MAX_STAMP`]; 0 without echo |
//! | 48..64 | position per axis, m, 2 × f64 | [`MAX_VALUE`] |
//! | 64..80 | velocity per axis, m/s, 2 × f64 | [`MAX_VALUE`] |
//! | 80..88 | energy sent to the receiver in this session so far, J, f64: a running total, so that neither loss nor repetition changes it | 0 to [`MAX_ENERGY`] |
//! | 88..96 | stiffness in use, N/m, f64 | 0 to [`MAX_STIFFNESS`] |
//! | 96..112 | the strategy's own quantity per axis, 2 × f64 | [`MAX_SIGNAL`] |
//!
//! Position and velocity are sent together, because a coupling damper needs both from the same instant. Any bytes are
//! decoded or refused with a reason; what is decoded encodes to the same bytes.

#![cfg_attr(not(test), deny(clippy::indexing_slicing))]

use super::motion::{MAX_VALUE, Motion};
use super::time::{LocalTime, PeerTime, Span};

/// The first bytes of every packet.
pub const MAGIC: [u8; 4] = *b"TSPR";
/// The version of the packet layout.
pub const VERSION: u8 = 2;
/// The length of a packet in bytes.
pub const LENGTH: usize = 112;
/// The latest stamp, ns: 292 years, so that the difference of two stamps fits.
pub const MAX_STAMP: u64 = i64::MAX as u64;
/// The largest running total of energy, J: a kilowatt for eleven days.
pub const MAX_ENERGY: f64 = 1e9;
/// The largest stiffness, N/m.
pub const MAX_STIFFNESS: f64 = 1e9;
/// The largest magnitude of a strategy's own quantity.
pub const MAX_SIGNAL: f64 = 1e9;
const AXES: u8 = 2;

/// The state of the sender.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Flags {
    /// Its coupling acts with its full force.
    pub engaged: bool,
    /// It acts on an old motion, because something is wrong.
    pub holding: bool,
    /// Its force ramps out or in.
    pub ramping: bool,
    /// Its strategy changed the force of the spring.
    pub limited: bool,
    /// Its partner has restarted and is not engaged again yet.
    pub restarted: bool,
}

impl Flags {
    /// The flags as bits.
    pub fn bits(self) -> u16 {
        let Self { engaged, holding, ramping, limited, restarted } = self;
        [engaged, holding, ramping, limited, restarted]
            .into_iter()
            .rev()
            .fold(0, |bits, flag| bits << 1 | u16::from(flag))
    }

    /// The flags of these bits, or `None` if an unknown bit is set.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::session::wire::Flags;
    ///
    /// let flags = Flags { engaged: true, limited: true, ..Flags::default() };
    /// assert_eq!(flags.bits(), 0b01001);
    /// assert_eq!(Flags::from_bits(0b01001), Some(flags));
    /// assert_eq!(Flags::from_bits(0b100000), None);
    /// ```
    pub fn from_bits(bits: u16) -> Option<Self> {
        let flag = |bit: u16| bits & 1 << bit != 0;
        (bits < 1 << 5).then(|| Self {
            engaged: flag(0),
            holding: flag(1),
            ramping: flag(2),
            limited: flag(3),
            restarted: flag(4),
        })
    }
}

/// The newest stamp that one side knows of the other, sent back to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Echo {
    /// The stamp, on the clock of the packet's receiver; 0 cannot be told from no echo.
    pub stamp: LocalTime,
    /// The time from its arrival to the packet's sent stamp, on the clock of the packet's sender; not negative.
    pub held: Span,
}

/// The content of a packet, as its receiver sees it: the sender is the peer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Packet {
    /// The state of the sender.
    pub flags: Flags,
    /// The sender's session id.
    pub session: u64,
    /// The sequence number, from 0.
    pub sequence: u64,
    /// When the motion was measured and sent.
    pub sent: PeerTime,
    /// The newest stamp of the receiver that the sender knows.
    pub echo: Option<Echo>,
    /// The motion.
    pub motion: Motion,
    /// The energy that the sender has sent to the receiver so far, J.
    pub energy_sent: f64,
    /// The stiffness in use, N/m.
    pub stiffness: f64,
    /// The strategy's own quantity per axis.
    pub signal: [f64; 2],
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
    /// Flags of another release, or damaged ones.
    #[error("the flags {found:#b} have unknown bits: run the same release on both sides")]
    Flags {
        /// The flags received.
        found: u16,
    },
    /// A stamp or a held time beyond [`MAX_STAMP`].
    #[error("the time stamp {found} ns is beyond 292 years: the packet is damaged")]
    Stamp {
        /// The stamp received.
        found: u64,
    },
    /// A held time without an echo.
    #[error("the packet echoes no stamp, but says that it held one for {held} ns: it is damaged")]
    Echo {
        /// The held time received.
        held: u64,
    },
    /// An impossible position or velocity.
    #[error("the motion contains {value}: values must be finite and at most {MAX_VALUE}")]
    Value {
        /// The first such value.
        value: f64,
    },
    /// An impossible total of energy.
    #[error("the energy sent is {value} J: a running total is finite, from 0 to {MAX_ENERGY} J")]
    Energy {
        /// The value received.
        value: f64,
    },
    /// An impossible stiffness.
    #[error("the stiffness is {value} N/m: it is finite, from 0 to {MAX_STIFFNESS} N/m")]
    Stiffness {
        /// The value received.
        value: f64,
    },
    /// An impossible quantity of the strategy.
    #[error("the strategy's quantity is {value}: it is finite and at most {MAX_SIGNAL}")]
    Signal {
        /// The first such value.
        value: f64,
    },
}

/// Takes fields from the front of the bytes; zeros beyond their end, which a packet of [`LENGTH`] bytes never reaches.
struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let Some((field, rest)) = self.0.split_first_chunk() else { return [0; N] };
        self.0 = rest;
        *field
    }

    fn byte(&mut self) -> u8 {
        u8::from_le_bytes(self.take())
    }

    fn whole(&mut self) -> u64 {
        u64::from_le_bytes(self.take())
    }

    fn stamp(&mut self) -> Result<u64, PacketError> {
        match self.whole() {
            stamp if stamp <= MAX_STAMP => Ok(stamp),
            found => Err(PacketError::Stamp { found }),
        }
    }

    fn number(&mut self) -> f64 {
        f64::from_le_bytes(self.take())
    }

    fn pair(&mut self) -> [f64; 2] {
        [self.number(), self.number()]
    }
}

/// Puts fields one behind the other.
struct Writer {
    bytes: [u8; LENGTH],
    at: usize,
}

impl Writer {
    fn put<const N: usize>(&mut self, field: [u8; N]) {
        let end = self.at.saturating_add(N);
        if let Some(place) = self.bytes.get_mut(self.at..end) {
            place.copy_from_slice(&field);
        }
        self.at = end;
    }

    fn pair(&mut self, [x, y]: [f64; 2]) {
        self.put(x.to_le_bytes());
        self.put(y.to_le_bytes());
    }
}

impl Packet {
    /// The motion as a packet's content without session, echo or strategy, for instance of a test.
    pub fn of(sequence: u64, sent: PeerTime, motion: Motion) -> Self {
        Self {
            flags: Flags::default(),
            session: 0,
            sequence,
            sent,
            echo: None,
            motion,
            energy_sent: 0.0,
            stiffness: 0.0,
            signal: [0.0; 2],
        }
    }

    /// Encodes the packet as bytes.
    pub fn encode(&self) -> [u8; LENGTH] {
        let mut out = Writer { bytes: [0; LENGTH], at: 0 };
        out.put(MAGIC);
        out.put([VERSION, AXES]);
        out.put(self.flags.bits().to_le_bytes());
        let echo = self.echo.filter(|echo| echo.stamp.0 > 0);
        let (stamp, held) = echo.map_or((0, 0), |echo| (echo.stamp.0, echo.held.0.max(0).cast_unsigned()));
        for field in [self.session, self.sequence, self.sent.0, stamp, held] {
            out.put(field.to_le_bytes());
        }
        out.pair(self.motion.position);
        out.pair(self.motion.velocity);
        out.pair([self.energy_sent, self.stiffness]);
        out.pair(self.signal);
        out.bytes
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
    /// use telespring::session::{Motion, Packet, PacketError, PeerTime};
    ///
    /// let motion = Motion { position: [0.01, -0.02], velocity: [0.0, 0.3] };
    /// let packet = Packet { stiffness: 71.2, ..Packet::of(7, PeerTime(1_000_000), motion) };
    /// assert_eq!(Packet::decode(&packet.encode()), Ok(packet));
    /// assert_eq!(Packet::decode(b"hello"), Err(PacketError::Length { length: 5 }));
    /// ```
    pub fn decode(bytes: &[u8]) -> Result<Self, PacketError> {
        if bytes.len() != LENGTH {
            return Err(PacketError::Length { length: bytes.len() });
        }
        let mut fields = Reader(bytes);
        let magic = fields.take();
        if magic != MAGIC {
            return Err(PacketError::Foreign { found: magic });
        }
        let version = fields.byte();
        if version != VERSION {
            return Err(PacketError::Version { found: version });
        }
        let axes = fields.byte();
        if axes != AXES {
            return Err(PacketError::Axes { found: axes });
        }
        let bits = u16::from_le_bytes(fields.take());
        let flags = Flags::from_bits(bits).ok_or(PacketError::Flags { found: bits })?;
        let (session, sequence) = (fields.whole(), fields.whole());
        let (sent, stamp, held) = (fields.stamp()?, fields.stamp()?, fields.stamp()?);
        let echo = match (stamp, held) {
            (0, 0) => None,
            (0, held) => return Err(PacketError::Echo { held }),
            _ => Some(Echo { stamp: LocalTime(stamp), held: Span(held.cast_signed()) }),
        };
        let motion = Motion { position: fields.pair(), velocity: fields.pair() };
        if let Some(value) = motion.impossible_value() {
            return Err(PacketError::Value { value });
        }
        let [energy_sent, stiffness] = fields.pair();
        if !(0.0..=MAX_ENERGY).contains(&energy_sent) {
            return Err(PacketError::Energy { value: energy_sent });
        }
        if !(0.0..=MAX_STIFFNESS).contains(&stiffness) {
            return Err(PacketError::Stiffness { value: stiffness });
        }
        let signal = fields.pair();
        if let Some(value) = signal.into_iter().find(|value| !(value.abs() <= MAX_SIGNAL)) {
            return Err(PacketError::Signal { value });
        }
        Ok(Self {
            flags,
            session,
            sequence,
            sent: PeerTime(sent),
            echo,
            motion,
            energy_sent,
            stiffness,
            signal,
        })
    }
}
