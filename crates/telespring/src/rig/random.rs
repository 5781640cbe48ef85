//! Random numbers: ChaCha with 8 rounds, the same on every machine.
//!
//! Everything random in a trial has a stream of its own, so that a change of one thing (more jitter, a
//! spot less) leaves the numbers of all others as they were.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// What draws random numbers in a trial.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum RandomStream {
    /// The agent of a side.
    Agent(usize),
    /// The network towards a side.
    Network(usize),
}

/// The random_generator of one thing in a trial.
pub(crate) fn random_generator(seed: u64, stream: RandomStream) -> ChaCha8Rng {
    let mut random_generator = ChaCha8Rng::seed_from_u64(seed);
    random_generator.set_stream(match stream {
        RandomStream::Agent(side) => side as u64,
        RandomStream::Network(side) => 2 + side as u64,
    });
    random_generator
}

/// The seed of one trial of a rehearsal whose own seed is `base`.
///
/// It depends on nothing but the three numbers: trials may be run in any order, and more of them added
/// later, without a change of those that exist.
///
/// # Examples
///
/// ```
/// use telespring::rig::trial_seed;
///
/// assert_eq!(trial_seed(1, 0, 0), trial_seed(1, 0, 0));
/// assert_ne!(trial_seed(1, 0, 0), trial_seed(1, 0, 1));
/// ```
pub fn trial_seed(base: u64, condition: u64, trial: u64) -> u64 {
    let mut random_generator = ChaCha8Rng::seed_from_u64(base);
    random_generator.set_stream(condition);
    // words of 32 bits, two to a seed
    random_generator.set_word_pos(2 * u128::from(trial));
    random_generator.next_u64()
}
