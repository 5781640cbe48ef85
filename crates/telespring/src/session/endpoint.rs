//! One side of a coupling: sends, receives and computes the force.

use super::wire::{LENGTH, Packet, PacketError, check_motion};
use super::{Law, Motion, Nanoseconds, Playout};

/// One side of a coupling: it measures and sends, receives, and computes the force on its own handle.
///
/// # Examples
///
/// Two sides with a network without delay:
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
    /// Creates a side that uses its partner's motion `delay` after its measurement.
    pub fn new(law: Law, delay: Nanoseconds) -> Self {
        Self { law, playout: Playout::new(delay), sequence: 0, own: None }
    }

    /// Stores the endpoint's own motion measured at `now` and returns the packet for the partner.
    ///
    /// # Errors
    ///
    /// [`PacketError::Value`] if the device reports an impossible value; the previous motion is kept.
    pub fn send(&mut self, now: Nanoseconds, motion: Motion) -> Result<[u8; LENGTH], PacketError> {
        let motion = check_motion(motion)?;
        self.own = Some(motion);
        let packet = Packet { sequence: self.sequence, time: now, motion };
        self.sequence += 1;
        Ok(packet.encode())
    }

    /// Receives at the endpoint the bytes of a packet that arrived at `now`.
    ///
    /// # Errors
    ///
    /// [`PacketError`] if they are not a valid packet; nothing changes then.
    pub fn receive(&mut self, now: Nanoseconds, bytes: &[u8]) -> Result<(), PacketError> {
        let packet = Packet::decode(bytes)?;
        self.playout.insert(now, packet.time, packet.motion);
        Ok(())
    }

    /// The endpoint's force on its own handle per axis, N; zero until both motions are known.
    pub fn force(&self, now: Nanoseconds) -> [f64; 2] {
        match (&self.own, self.playout.motion(now)) {
            (Some(own), Some(partner)) => self.law.force(own, &partner),
            _ => [0.0; 2],
        }
    }
}
