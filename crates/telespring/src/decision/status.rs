//! The answer in one word, and what counts in it beside the verdicts.

use super::{LEAST_PROBABILITY, Question, VaryingDelay, are_roots_counted, is_instability_proven, is_stable};
use crate::verdicts::Verdicts;

/// The answer in one word, the best one first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Status {
    /// Stable with the reserve.
    Stable,
    /// Stable without the reserve.
    Marginal,
    /// Something that was not examined may decide.
    NotProven,
    /// Unstable.
    Unstable,
}

impl Status {
    /// All of them, the best one first.
    pub const ALL: [Self; 4] = [Self::Stable, Self::Marginal, Self::NotProven, Self::Unstable];

    /// The word for it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Stable => "stable",
            Self::Marginal => "marginal",
            Self::NotProven => "not proven",
            Self::Unstable => "unstable",
        }
    }
}

/// What is known beside the verdicts, and counts in the answer. The default is what verdicts take for granted.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Knowledge {
    /// Whether the axes of a robot are coupled. Verdicts treat each axis alone: what they call stable is then not proven.
    pub has_coupled_axes: bool,
    /// How probable it is that the constant delay is stable, where masses and dampings have errors.
    pub stable_probability: Option<f64>,
    /// The stiffness (N/m) that is proven while the delay varies for all robots but a few, where these have errors.
    pub varying_stiffness_limit: Option<f64>,
    /// Whether the verdicts were asked to search an attack.
    pub is_attack_searched: bool,
}

impl Knowledge {
    /// Whether it is stable in spite of the errors, probably enough.
    pub(super) fn is_probable(&self) -> bool {
        self.stable_probability.is_none_or(|probability| probability >= LEAST_PROBABILITY)
    }
}

/// Whether nothing that was not examined may decide.
pub(super) fn is_proven(judged: &Verdicts, known: &Knowledge) -> bool {
    are_roots_counted(judged) && !known.has_coupled_axes
}

/// The answer at a constant delay.
pub(super) fn at_constant_delay(judged: &Verdicts, known: &Knowledge, keeps_reserve: bool) -> Status {
    if !is_stable(judged) {
        return if is_instability_proven(judged) { Status::Unstable } else { Status::NotProven };
    }
    if !is_proven(judged, known) {
        return Status::NotProven;
    }
    if keeps_reserve { Status::Stable } else { Status::Marginal }
}

/// The answer, from that at a constant delay and that while the delay varies. A playout buffer that nobody promised does
/// not count.
pub(super) fn overall(
    question: &Question,
    known: &Knowledge,
    constant: Status,
    varying: Option<&VaryingDelay>,
) -> Status {
    match varying {
        _ if question.has_unjudged() => Status::NotProven,
        Some(varying) if !question.has_playout_buffer => {
            // Coupled axes take away what was proven, but an unstable axis remains one.
            if known.has_coupled_axes { varying.status.max(Status::NotProven) } else { varying.status }
        }
        _ => constant,
    }
}
