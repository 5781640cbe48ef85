//! One side of a coupling.

use super::wire::{LENGTH, Motion, Packet, PacketError};
use super::{Law, Nanoseconds, Playout};

/// One side: it measures and sends, receives, and gives the force on its own handle.
///
/// # Examples
///
/// Two sides, the network between them taking no time:
///
/// ```
/// use telespring::session::{Endpoint, Law, Motion, Nanoseconds};
///
/// let law = Law { stiffness: 100.0, damping: 0.0 };
/// let mut sides = [(); 2].map(|()| Endpoint::new(law, Nanoseconds(0)));
/// let now = Nanoseconds(0);
/// let at = |x| Motion { position: [x, 0.0], velocity: [0.0; 2] };
/// let first = sides[0].send(now, at(0.0))?;
/// let second = sides[1].send(now, at(0.02))?;
/// assert_eq!(sides[0].force(now), [0.0; 2]); // nothing has come yet
/// sides[0].receive(now, &second)?;
/// sides[1].receive(now, &first)?;
/// assert_eq!(sides[0].force(now), [2.0, 0.0]);
/// assert_eq!(sides[1].force(now), [-2.0, 0.0]);
/// # Ok::<(), telespring::session::PacketError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Endpoint {
    law: Law,
    playout: Playout,
    sequence: u64,
    own: Option<Motion>,
}

impl Endpoint {
    /// A side that plays its partner's motion `delay` after it was measured.
    pub fn new(law: Law, delay: Nanoseconds) -> Self {
        Self { law, playout: Playout::new(delay), sequence: 0, own: None }
    }

    /// Takes the own handle's motion as measured `now` and returns the packet for the partner.
    ///
    /// # Errors
    ///
    /// [`PacketError::Value`] where the device reports a value that no handle has; the motion before stays.
    pub fn send(&mut self, now: Nanoseconds, motion: Motion) -> Result<[u8; LENGTH], PacketError> {
        let motion = motion.check()?;
        self.own = Some(motion);
        let packet = Packet { sequence: self.sequence, time: now, motion };
        self.sequence += 1;
        Ok(packet.encode())
    }

    /// Takes in bytes that came `now`.
    ///
    /// # Errors
    ///
    /// [`PacketError`] where they are no packet; nothing has changed then.
    pub fn receive(&mut self, now: Nanoseconds, bytes: &[u8]) -> Result<(), PacketError> {
        let packet = Packet::decode(bytes)?;
        self.playout.insert(now, packet.time, packet.motion);
        Ok(())
    }

    /// The force on the own handle per axis, N: zero until there is a motion of both sides.
    pub fn force(&self, now: Nanoseconds) -> [f64; 2] {
        match (&self.own, self.playout.motion(now)) {
            (Some(own), Some(partner)) => self.law.force(own, &partner),
            _ => [0.0; 2],
        }
    }
}
