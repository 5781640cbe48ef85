//! What an endpoint makes of the bytes that arrive.

#![cfg_attr(not(test), deny(clippy::indexing_slicing))]

use super::Endpoint;
use super::partner::Arrival;
use crate::session::event::EventKind;
use crate::session::predictor::Predictor;
use crate::session::watchdog::{Cause, WatchdogState};
use crate::session::wire::{Packet, PacketError};
use crate::session::{LocalTime, Span};

/// Why a datagram was refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DatagramError {
    /// It is no packet.
    #[error(transparent)]
    Packet(#[from] PacketError),
    /// It has the session id of this side.
    #[error("the packet has the session id of this side: it came back, or both sides were given the same id")]
    OwnSession,
    /// It belongs to a session of the partner that is over.
    #[error("the packet belongs to session {session:#x}, which is over: the partner has restarted since")]
    FormerSession {
        /// The session id.
        session: u64,
    },
    /// Its stamp lies in the future, although both sides read one clock.
    #[error("the packet is stamped {} s in the future: the clocks of the two sides differ", ahead.seconds())]
    FromTheFuture {
        /// How far.
        ahead: Span,
    },
}

impl Endpoint {
    /// Takes the bytes of a datagram that arrived at `now`.
    ///
    /// # Errors
    ///
    /// [`DatagramError`] if they are not a packet of the partner; nothing changes then but the counts.
    pub fn handle_datagram(
        &mut self,
        now: LocalTime,
        bytes: &[u8],
    ) -> std::result::Result<(), DatagramError> {
        let now = self.begin(now);
        let taken = self.take_datagram(now, bytes);
        match taken {
            Ok(()) => self.received = self.received.saturating_add(1),
            Err(refusal) => {
                self.refused = self.refused.saturating_add(1);
                self.events.push(now, EventKind::Refused(refusal));
            }
        }
        taken
    }

    fn take_datagram(&mut self, now: LocalTime, bytes: &[u8]) -> std::result::Result<(), DatagramError> {
        let packet = Packet::decode(bytes)?;
        if packet.session == self.session {
            return Err(DatagramError::OwnSession);
        }
        if let Some(ahead) = self.clock.ahead(now, packet.sent) {
            return Err(DatagramError::FromTheFuture { ahead });
        }
        let idle =
            matches!(self.state(), WatchdogState::Disengaged { cause: Cause::Silence | Cause::FrozenStamps });
        match self.partner.accept(now, &packet, idle)? {
            Arrival::First => self.events.push(now, EventKind::PartnerFound { session: packet.session }),
            Arrival::Restarted => {
                self.events.push(now, EventKind::PartnerRestarted { session: packet.session });
                self.restarted = true;
                self.clock.forget();
                self.begin_anew(now, Cause::PartnerRestarted);
            }
            Arrival::Later | Arrival::Other => {}
        }
        let steps = self.clock.steps();
        self.clock.handle_packet(now, &packet);
        if self.clock.steps() > steps {
            self.events.push(now, EventKind::ClockStepped);
            self.begin_anew(now, Cause::ClockStepped);
        }
        if let Some(peer) = self.clock.to_peer(now) {
            self.playout.insert(peer, (&packet).into());
        }
        Ok(())
    }

    /// Forgets the partner's motion: what comes now does not continue it.
    fn begin_anew(&mut self, now: LocalTime, cause: Cause) {
        self.playout.forget();
        self.predictor.reset();
        self.ready = false;
        if let Some(state) = self.watchdog.as_mut().and_then(|watchdog| watchdog.let_go(now, cause)) {
            self.enter(now, state);
        }
    }
}
