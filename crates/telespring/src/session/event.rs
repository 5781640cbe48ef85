//! What happened in a session, and why.

#![cfg_attr(not(test), deny(clippy::indexing_slicing))]

use std::collections::VecDeque;

use super::endpoint::DatagramError;
use super::time::{LocalTime, Span};
use super::watchdog::Cause;

/// The most events that wait to be fetched.
pub const CAPACITY: usize = 256;
/// Refusals within this time of the previous one that was reported are only counted.
const QUIET: Span = Span(1_000_000_000);

/// What happened in a session.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum EventKind {
    /// The first packet of the partner came.
    PartnerFound {
        /// The partner's session id.
        session: u64,
    },
    /// The partner has restarted: another session id, or stamps and sequence numbers that contradict the order.
    PartnerRestarted {
        /// The partner's session id now.
        session: u64,
    },
    /// Something is wrong: the force goes on for a moment.
    Holding(Cause),
    /// It stayed wrong: the force ramps out.
    RampingOut(Cause),
    /// The force is zero.
    Disengaged(Cause),
    /// All is well again: the force ramps in from zero.
    RampingIn,
    /// The force acts fully.
    Engaged,
    /// A datagram was refused; further ones within a second are counted only.
    Refused(DatagramError),
    /// The own device, the target or the measured force had an impossible value, which was not used.
    ImpossibleValue {
        /// The value.
        value: f64,
    },
    /// The stamps contradict the estimate of the partner's clock: a clock was set, and the estimate began anew.
    ClockStepped,
    /// The strategy returned a force that is not finite; zero acts instead.
    ImpossibleForce,
}

impl EventKind {
    /// What happened in the session, in a word.
    pub fn word(&self) -> &'static str {
        match self {
            Self::PartnerFound { .. } => "partner-found",
            Self::PartnerRestarted { .. } => "partner-restarted",
            Self::Holding(_) => "holding",
            Self::RampingOut(_) => "ramping-out",
            Self::Disengaged(_) => "disengaged",
            Self::RampingIn => "ramping-in",
            Self::Engaged => "engaged",
            Self::Refused(_) => "datagram-refused",
            Self::ImpossibleValue { .. } => "impossible-value",
            Self::ClockStepped => "clock-stepped",
            Self::ImpossibleForce => "impossible-force",
        }
    }

    /// Why, or of whom; `None` if the word of the session's event says it all. It allocates: not for the control loop.
    pub fn reason(&self) -> Option<String> {
        match self {
            Self::PartnerFound { session } | Self::PartnerRestarted { session } => {
                Some(format!("{session:#018x}"))
            }
            Self::Holding(cause) | Self::RampingOut(cause) | Self::Disengaged(cause) => {
                Some(cause.word().to_owned())
            }
            Self::Refused(refusal) => Some(refusal.to_string()),
            Self::ImpossibleValue { value } => Some(value.to_string()),
            Self::RampingIn | Self::Engaged | Self::ClockStepped | Self::ImpossibleForce => None,
        }
    }
}

/// What happened in a session, and when.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Event {
    /// When.
    pub time: LocalTime,
    /// What, and why.
    pub kind: EventKind,
}

/// The events that wait to be fetched; the oldest are given up if there are too many.
#[derive(Debug, Clone)]
pub(super) struct Events {
    waiting: VecDeque<Event>,
    missed: u64,
    refused_at: Option<LocalTime>,
    impossible_at: Option<LocalTime>,
}

impl Events {
    pub(super) fn new() -> Self {
        Self { waiting: VecDeque::with_capacity(CAPACITY), missed: 0, refused_at: None, impossible_at: None }
    }

    pub(super) fn push(&mut self, time: LocalTime, kind: EventKind) {
        let quiet = match kind {
            EventKind::Refused(_) => Some(&mut self.refused_at),
            EventKind::ImpossibleValue { .. } | EventKind::ImpossibleForce => Some(&mut self.impossible_at),
            _ => None,
        };
        if let Some(reported) = quiet {
            if reported.is_some_and(|reported| time - reported < QUIET) {
                return;
            }
            *reported = Some(time);
        }
        if self.waiting.len() >= CAPACITY {
            self.waiting.pop_front();
            self.missed = self.missed.saturating_add(1);
        }
        self.waiting.push_back(Event { time, kind });
    }

    pub(super) fn poll(&mut self) -> Option<Event> {
        self.waiting.pop_front()
    }

    pub(super) fn missed(&self) -> u64 {
        self.missed
    }
}
