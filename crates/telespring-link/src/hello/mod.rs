//! The greeting: what both sides must agree on before any force, and where each of them stands.
//!
//! A greeting is as long as a packet, so that both take the same way. `docs/connect.md` has it byte by byte. Nothing in it is
//! secret, and nobody is believed because of it: who the partner is, the transport decides.

mod disagreement;
mod terms;

pub use disagreement::{Difference, Disagreement};
pub use terms::{Terms, fingerprint};

use telespring::session::wire::{LENGTH, MAX_STAMP};

/// The first bytes of every greeting.
pub const MAGIC: [u8; 4] = *b"TSPH";
/// The version of the greeting.
pub const VERSION: u8 = 3;
/// No handle is farther from its origin, m.
pub const MAX_POSITION: f32 = 1e6;

/// What a greeting is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// The sender wants to be coupled, or is.
    Hello,
    /// The sender leaves; its force falls to zero.
    Goodbye,
}

/// Where the sender stands.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Stance {
    /// The state that the sender shows, as a code; for people only.
    pub phase: u8,
    /// Its robot is homed and its motors may act.
    pub is_ready: bool,
    /// Its emergency stop has latched.
    pub is_stopped: bool,
    /// It wants a pause.
    pub is_paused: bool,
    /// It finds its handle at rest, and where the receiver's is.
    pub is_aligned: bool,
    /// The person there agrees to be coupled in this round.
    pub has_consented: bool,
    /// Counts how often the two have been coupled, or might have been; a consent is for one round.
    pub round: u32,
    /// The position of its handle, m, if known.
    pub position: Option<[f32; 2]>,
}

/// When a greeting was sent, and what it answers: for the round trip. Times in ns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Stamps {
    /// When it was sent, on the sender's clock. It rises, so that an overtaken greeting is known as such.
    pub sent: u64,
    /// The newest such stamp of the receiver, on the receiver's clock; 0 for none.
    pub echo: u64,
    /// From the arrival of that greeting to the sending of this one.
    pub held: u64,
}

/// A greeting.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Greeting {
    /// What it is for.
    pub purpose: Purpose,
    /// The sender's session id; never 0.
    pub session: u64,
    /// The session of the receiver that the sender has agreed to; 0 for none yet.
    pub accepted: u64,
    /// Why the sender does not agree to the receiver's terms.
    pub refusal: Option<Disagreement>,
    /// The sender's terms.
    pub terms: Terms,
    /// Where the sender stands.
    pub stance: Stance,
    /// For the round trip.
    pub stamps: Stamps,
}

impl Stance {
    /// The flags of a greeting, by bit.
    fn flags(&self, [x, y]: [bool; 2]) -> u8 {
        let Self { is_ready, is_stopped, is_paused, is_aligned, has_consented, position, .. } = *self;
        let flags = [is_ready, is_stopped, is_paused, is_aligned, has_consented, position.is_some(), x, y];
        flags.into_iter().zip(0..).map(|(flag, bit)| u8::from(flag) << bit).sum()
    }

    /// The stance in its bytes; `None` for a position that no handle has.
    fn decode(phase: u8, flags: u8, round: u32, position: u64) -> Option<Self> {
        let is = |bit: u8| flags >> bit & 1 == 1;
        let [low, high] = [position as u32, (position >> 32) as u32].map(f32::from_bits);
        let can_be = [low, high].iter().all(|value| value.abs() <= MAX_POSITION);
        if !can_be || (!is(5) && position != 0) {
            return None;
        }
        Some(Self {
            phase,
            is_ready: is(0),
            is_stopped: is(1),
            is_paused: is(2),
            is_aligned: is(3),
            has_consented: is(4),
            round,
            position: is(5).then_some([low, high]),
        })
    }
}

/// Why bytes are no greeting that this side understands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoGreeting {
    /// They are something else.
    Foreign,
    /// They are a greeting of this other version.
    OtherVersion(u8),
}

impl Greeting {
    /// A greeting that says nothing but who is there on which terms, and whom it accepts.
    pub fn new(purpose: Purpose, session: u64, accepted: u64, terms: Terms) -> Self {
        let (stance, stamps) = (Stance::default(), Stamps::default());
        Self { purpose, session, accepted, refusal: None, terms, stance, stamps }
    }

    /// The greeting as bytes.
    pub fn encode(&self) -> [u8; LENGTH] {
        let Terms { packets, axes, side, robots, strategy, study, coupling, sample_period, lock } =
            self.terms;
        let purpose = match self.purpose {
            Purpose::Hello => 0,
            Purpose::Goodbye => 1,
        };
        let refusal = Disagreement::code(self.refusal);
        let head = MAGIC.into_iter().chain([VERSION, purpose, packets, axes]);
        let ids = [self.session, self.accepted].into_iter().flat_map(u64::to_le_bytes);
        let Stance { phase, round, position, .. } = self.stance;
        let which = [side, refusal, phase, self.stance.flags(lock)].into_iter().chain(round.to_le_bytes());
        let prints = [robots, strategy, study].into_iter().flat_map(u64::to_le_bytes);
        let [stiffness, damping] = coupling;
        let numbers = [stiffness, damping, sample_period].into_iter().flat_map(f64::to_le_bytes);
        let position = position.unwrap_or_default().into_iter().flat_map(f32::to_le_bytes);
        let Stamps { sent, echo, held } = self.stamps;
        let stamps = [sent, echo, held].into_iter().flat_map(u64::to_le_bytes);
        let all = head.chain(ids).chain(which).chain(prints).chain(numbers).chain(position).chain(stamps);
        let mut datagram = [0; LENGTH];
        datagram.iter_mut().zip(all).for_each(|(place, byte)| *place = byte);
        datagram
    }

    /// The greeting in a datagram.
    ///
    /// # Errors
    ///
    /// [`NoGreeting`] if it holds none of this version. Every byte is checked.
    pub fn decode(datagram: &[u8]) -> Result<Self, NoGreeting> {
        let datagram: &[u8; LENGTH] = datagram.try_into().map_err(|_| NoGreeting::Foreign)?;
        let word = |at: usize| {
            let mut bytes = [0; 8];
            bytes.iter_mut().zip(datagram.iter().skip(at)).for_each(|(place, byte)| *place = *byte);
            u64::from_le_bytes(bytes)
        };
        let [m, a, g, i, version, purpose, packets, axes] = word(0).to_le_bytes();
        if [m, a, g, i] != MAGIC {
            return Err(NoGreeting::Foreign);
        }
        if version != VERSION {
            return Err(NoGreeting::OtherVersion(version));
        }
        let [side, refusal, phase, flags, round @ ..] = word(24).to_le_bytes();
        let refusal = Disagreement::decode(refusal).ok_or(NoGreeting::Foreign)?;
        let purpose = match purpose {
            0 => Purpose::Hello,
            1 => Purpose::Goodbye,
            _ => return Err(NoGreeting::Foreign),
        };
        let stance = Stance::decode(phase, flags, u32::from_le_bytes(round), word(80));
        let stamps = Stamps { sent: word(88), echo: word(96), held: word(104) };
        let number = |at| f64::from_bits(word(at));
        let greeting = Self {
            purpose,
            session: word(8),
            accepted: word(16),
            refusal,
            terms: Terms {
                packets,
                axes,
                side,
                robots: word(32),
                strategy: word(40),
                study: word(48),
                coupling: [number(56), number(64)],
                sample_period: number(72),
                lock: [6, 7].map(|bit| flags >> bit & 1 == 1),
            },
            stance: stance.ok_or(NoGreeting::Foreign)?,
            stamps,
        };
        if greeting.session == 0
            || [stamps.sent, stamps.echo, stamps.held].iter().any(|time| *time > MAX_STAMP)
        {
            return Err(NoGreeting::Foreign);
        }
        Ok(greeting)
    }
}

/// A session id drawn by the kernel; never 0.
pub fn draw_session() -> u64 {
    let mut bytes = [0; 8];
    loop {
        let drawn = rustix::rand::getrandom(&mut bytes, rustix::rand::GetRandomFlags::empty());
        let session = u64::from_le_bytes(bytes);
        if drawn == Ok(8) && session != 0 {
            return session;
        }
    }
}

#[cfg(test)]
mod tests {
    use telespring::session::wire::Packet;
    use telespring::study::Study;

    use super::*;

    fn greeting() -> Greeting {
        let terms = Terms::new(&Study::paper(), 1).unwrap();
        Greeting {
            purpose: Purpose::Hello,
            session: 5,
            accepted: 6,
            refusal: Some(Disagreement::Robots),
            terms,
            stance: stance(0x3f),
            stamps: Stamps { sent: 1, echo: 1 << 62, held: 3 },
        }
    }

    /// The stance with these flags.
    fn stance(flags: u8) -> Stance {
        let is = |bit: u8| flags >> bit & 1 == 1;
        Stance {
            phase: 3,
            is_ready: is(0),
            is_stopped: is(1),
            is_paused: is(2),
            is_aligned: is(3),
            has_consented: is(4),
            round: 0x0102_0304,
            position: is(5).then_some([0.25, -0.5]),
        }
    }

    #[test]
    fn law_a_greeting_survives_encoding_and_every_byte_counts() {
        for purpose in [Purpose::Hello, Purpose::Goodbye] {
            for refusal in (0..=8).map(|code| Disagreement::decode(code).unwrap()) {
                let greeting = Greeting { purpose, refusal, ..greeting() };
                assert_eq!(Greeting::decode(&greeting.encode()), Ok(greeting));
            }
        }
        for flags in 0..=0xff {
            let mut greeting = Greeting { stance: stance(flags), ..greeting() };
            greeting.terms.lock = [flags & 0x40 != 0, flags & 0x80 != 0];
            assert_eq!(greeting.encode()[27], flags);
            assert_eq!(Greeting::decode(&greeting.encode()), Ok(greeting));
        }
        // a position that is none, or without its flag, and times beyond all clocks
        for (at, byte) in [(83, 0x7f), (27, 0x1f), (95, 0x80), (103, 0x80), (111, 0x80)] {
            let mut bytes = greeting().encode();
            bytes[at] = byte;
            assert_eq!(Greeting::decode(&bytes), Err(NoGreeting::Foreign), "{at}");
        }
        let good = greeting().encode();
        for at in 0..LENGTH {
            let mut bytes = good;
            bytes[at] ^= 0x40;
            match Greeting::decode(&bytes) {
                Ok(other) => assert_eq!(other.encode(), bytes),
                Err(NoGreeting::OtherVersion(version)) => assert_eq!((at, version), (4, bytes[4])),
                Err(NoGreeting::Foreign) => {
                    assert!([0, 1, 2, 3, 5, 25].contains(&at) || at >= 80, "{at}")
                }
            }
        }
        assert_eq!(Greeting::decode(&good[..LENGTH - 1]), Err(NoGreeting::Foreign));
        assert_eq!(Greeting::decode(&[0; LENGTH]), Err(NoGreeting::Foreign));
        // a packet is no greeting, and a greeting no packet
        assert!(Packet::decode(&good).is_err());
    }
}
