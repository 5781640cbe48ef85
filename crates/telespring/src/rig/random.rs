//! Random numbers of a trial: ChaCha with 8 rounds, identical on every machine.
//!
//! Every random element of a trial has its own stream, so changing one (more jitter, one spot fewer) leaves
//! the numbers of all others unchanged.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// The random elements of a trial.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum RandomStream {
    /// The agent of a side.
    Agent(usize),
    /// Uniform jitter and independent loss of the network towards a side.
    Network(usize),
    /// Another impairment of the network towards a side.
    Impairment(Impairment, usize),
    /// Where the recorded traces of both ways begin.
    TraceStart,
}

/// The impairments of a network with random numbers of their own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Impairment {
    /// Jitter that is not uniform.
    Jitter,
    /// Loss in bursts.
    Burst,
    /// Copies of packets.
    Duplicate,
}

/// The random generator of one element of a trial.
pub(crate) fn random_generator(seed: u64, stream: RandomStream) -> ChaCha8Rng {
    let mut random_generator = ChaCha8Rng::seed_from_u64(seed);
    random_generator.set_stream(match stream {
        RandomStream::Agent(side) => side as u64,
        RandomStream::Network(side) => 2 + side as u64,
        RandomStream::Impairment(impairment, side) => 4 + 2 * impairment as u64 + side as u64,
        RandomStream::TraceStart => u64::MAX,
    });
    random_generator
}

/// The seed of one trial in a rehearsal with the seed `base`.
///
/// It depends only on the three numbers: trials may run in any order, and more can be added later without
/// changing the existing ones.
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
    // Words of 32 bits, two per seed.
    random_generator.set_word_pos(2 * u128::from(trial));
    random_generator.next_u64()
}
