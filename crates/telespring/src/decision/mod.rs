//! The answer in one word: is a dyad stable over a network, with something in reserve?
//!
//! | part | job |
//! |---|---|
//! | [`Question`] | a dyad, what holds it, and the network that it is judged over |
//! | [`Decision`] | the verdicts at one stiffness, the reserve that is kept, and the answer |
//! | [`VaryingDelay`] | what is proven while the delay varies |
//! | [`Knowledge`] | what is known beside the verdicts and counts in the answer |
//!
//! Verdicts count masses and dampings as exactly known and the axes as independent. Who knows better, as by an
//! identification, says so in [`Knowledge`].

mod constant_delay;
mod question;
mod status;
mod varying;

pub use constant_delay::{
    are_roots_counted, constant_delay, is_axis_stable, is_instability_proven, is_stable, is_within,
    stiffness_limit, tier_stiffness_limit,
};
pub use question::Question;
pub use status::{Knowledge, Status};
pub use varying::VaryingDelay;

use crate::verdicts::{DelayLimit, Verdicts};

/// Share of the stiffness, and of the delay, that a stable dyad keeps in reserve; with less it is marginal.
pub const RESERVE: f64 = 0.05;
/// A dyad whose robots have errors is marginal if it is stable with a smaller probability.
pub const LEAST_PROBABILITY: f64 = 0.95;
/// A factor that keeps rounding on the safe side of a limit.
pub const WITHIN: f64 = 1.0 - 1e-9;

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
    /// What is known beside them.
    pub known: Knowledge,
    /// The answer.
    pub status: Status,
    /// The answer at a constant delay, which with jitter or gaps needs a playout buffer. Where no buffer can make the delay
    /// constant, it is `status`.
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

    /// Whether nothing that was not examined may decide: coupled axes, roots that were not counted.
    pub fn is_proven(&self) -> bool {
        status::is_proven(&self.verdicts, &self.known)
    }

    /// Whether it has the reserve of stiffness and delay, and is probable enough if robots have errors.
    pub fn keeps_reserve(&self) -> bool {
        self.keeps_stiffness_reserve && self.keeps_delay_reserve && self.known.is_probable()
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
