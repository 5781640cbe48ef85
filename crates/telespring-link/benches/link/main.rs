//! How the live program compares with raw UDP and with cyclictest, side by side in one run: `make bench-link`.
//!
//! Absolute times depend on the machine and on what else it does; the ratios matter. Needs root for the impaired path and the
//! real-time priority, and cyclictest (Debian: rt-tests); what is missing is said and left out.

mod lateness;
mod loss;
#[path = "../../tests/netns/mod.rs"]
mod netns;
mod round_trip;
#[path = "../../tests/sites/mod.rs"]
mod sites;

type Failure = Box<dyn std::error::Error>;

/// Rounds of each measurement; medians are printed.
const ROUNDS: usize = 5;

/// The middle of some values.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

fn main() -> Result<(), Failure> {
    println!("medians of {ROUNDS} rounds, in turns");
    round_trip::compare(ROUNDS, 5)?;
    loss::compare(ROUNDS, 5)?;
    lateness::compare(ROUNDS, 10)
}
