//! The answer in one word: is a dyad stable over a network, with something in reserve?
//!
//! | part | job |
//! |---|---|
//! | [`Question`] | a dyad, what holds it, and the network that it is judged over |
//! | [`Decision`] | the verdicts at one stiffness, the reserve that is kept, and the answer |
//! | [`VaryingDelay`] | what is proven while the delay varies |
//!
//! Masses and dampings count as exactly known: how probable an answer is where a robot's parameters have errors is not
//! asked here.

mod question;
mod varying;

pub use question::{Holding, Question};
pub use varying::VaryingDelay;

use crate::verdicts::{Assumption, DelayLimit, SampledCertificate, Tier, Verdicts};

/// Share of the stiffness, and of the delay, that a stable dyad keeps in reserve; with less it is marginal.
pub const RESERVE: f64 = 0.05;
/// The largest stiffness that is judged, N/m.
const STIFFEST: f64 = 1e7;

/// The answer in one word.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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

/// The answer to a question at one stiffness.
///
/// The margins are those at a constant delay: with jitter or gaps that behind a playout buffer. What holds without one is
/// in `varying`.
///
/// # Examples
///
/// ```
/// use telespring::decision::{Question, Status};
/// use telespring::{Delay, hman, verdicts::Network};
/// let network = Network::new(Delay::each_way(0.1)?, 0.0, 0.0, 0.001, 0.0)?;
/// let question = Question::of_network(hman(), network);
/// let answer = |stiffness| Ok(question.decide(stiffness)?.status);
/// assert_eq!([answer(71.2)?, answer(97.0)?, answer(110.0)?], [Status::Stable, Status::Marginal, Status::Unstable]);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Decision {
    /// The verdicts at the stiffness in question.
    pub verdicts: Verdicts,
    /// The answer.
    pub status: Status,
    /// The answer at a constant delay, which with jitter or gaps needs a playout buffer.
    pub constant_delay_status: Status,
    /// Whether it stays stable with 5 % more stiffness.
    pub keeps_stiffness_reserve: bool,
    /// Whether it stays stable with 5 % more delay.
    pub keeps_delay_reserve: bool,
    /// The first delay at which it is unstable, the mean of both ways.
    pub delay_limit: DelayLimit,
    /// The answer without a playout buffer; `None` if the delay does not vary.
    pub varying: Option<VaryingDelay>,
}

impl Decision {
    /// Whether the constant delay of the decision is stable for every operator, sampled controllers included.
    pub fn is_stable(&self) -> bool {
        is_stable(&self.verdicts)
    }

    /// Every smaller stiffness is stable at the delay of the decision, sampled controllers included, N/m; may be 0.
    pub fn stiffness_limit(&self) -> f64 {
        stiffness_limit(&self.verdicts)
    }

    /// The constant delay of the decision, s: the network's, or with jitter or gaps that behind a playout buffer.
    pub fn constant_delay(&self) -> [f64; 2] {
        constant_delay(&self.verdicts)
    }
}

/// Whether the constant delay is stable for every operator, sampled controllers included.
pub fn is_stable(judged: &Verdicts) -> bool {
    judged.tier(Tier::ConstantDelay).satisfied && judged.sampled_stable != Some(false)
}

/// Whether some operator in question is unstable; if not, a search over ranges was cut off.
pub fn is_instability_proven(judged: &Verdicts) -> bool {
    let constant = judged.tier(Tier::ConstantDelay);
    (!constant.satisfied && constant.proven)
        || judged.axes.iter().filter_map(|axis| axis.sampled.as_ref()).any(|sampled| !sampled.is_stable())
}

/// Whether no root that sampled controllers give was left out of the count.
pub fn are_roots_counted(judged: &Verdicts) -> bool {
    let sampled = judged.axes.iter().filter_map(|axis| axis.sampled.as_ref());
    sampled.into_iter().all(|found| found.certificate != SampledCertificate::Incomplete)
}

/// The stiffness (N/m) below which every one is stable at the delay, sampled controllers included.
pub fn stiffness_limit(judged: &Verdicts) -> f64 {
    let sampled = judged.axes.iter().filter_map(|axis| axis.sampled_stiffness_bound);
    let constant = judged.tier(Tier::ConstantDelay).stiffness_bound;
    constant.into_iter().chain(sampled).fold(f64::INFINITY, f64::min)
}

/// The delay that is judged, s: the network's, or that behind a playout buffer.
pub fn constant_delay(judged: &Verdicts) -> [f64; 2] {
    match judged.tier(Tier::ConstantDelay).assumption {
        Assumption::MetBehindPlayoutBuffer { delay } => delay,
        Assumption::Met => [judged.network.delay().forward(), judged.network.delay().backward()],
    }
}

/// The answer at a constant delay.
fn constant_delay_status(judged: &Verdicts, keeps_reserve: bool) -> Status {
    if !is_stable(judged) {
        return if is_instability_proven(judged) { Status::Unstable } else { Status::NotProven };
    }
    if !are_roots_counted(judged) {
        return Status::NotProven;
    }
    if keeps_reserve { Status::Stable } else { Status::Marginal }
}

/// Whether a mean delay (s) is below a limit, or at one that is itself stable.
fn is_within(delay: f64, limit: &DelayLimit) -> bool {
    // A delay that is a whole number of periods remains one in spite of rounding.
    if limit.attained { delay <= limit.delay * (1.0 + 1e-9) } else { delay < limit.delay }
}
