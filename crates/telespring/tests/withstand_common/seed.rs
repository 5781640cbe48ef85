//! The seed of random cases.

/// The seed that `make verify` draws, or the usual one.
#[allow(clippy::disallowed_methods, reason = "make verify passes its seed this way")]
pub fn seed(usual: u64) -> u64 {
    let drawn = std::env::var("TELESPRING_VERIFY").ok();
    drawn.map_or(usual, |seed| seed.parse().expect("TELESPRING_VERIFY is a whole number"))
}
