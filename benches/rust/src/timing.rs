//! Median and quartiles of a repeated call.

use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::Bench;

impl Bench {
    /// Times `call`, which does `items` pieces of work, for about `seconds` after a warm-up, and
    /// notes the seconds per piece under `name`.
    pub fn time(&mut self, name: &str, items: usize, seconds: f64, mut call: impl FnMut()) {
        let (budget, least) = if self.quick { (0.0, 1) } else { (seconds, 5) };
        let start = Instant::now();
        while start.elapsed() < Duration::from_secs_f64(0.1 * budget) {
            call();
        }
        let mut samples = Vec::new();
        let start = Instant::now();
        while samples.len() < least || start.elapsed() < Duration::from_secs_f64(budget) {
            let begin = Instant::now();
            call();
            samples.push(begin.elapsed().as_secs_f64() / items as f64);
        }
        samples.sort_by(f64::total_cmp);
        let at = |part: f64| samples[((samples.len() - 1) as f64 * part).round() as usize];
        self.results.insert(
            name.to_string(),
            json!({
                "median": at(0.5), "lower": at(0.25), "upper": at(0.75), "repetitions": samples.len(),
            }),
        );
    }

    /// Notes a number that belongs to a timing.
    pub fn note(&mut self, name: &str, value: impl Into<Value>) {
        self.results.insert(name.to_string(), value.into());
    }
}

/// Uniform numbers in 0..1, the same on every machine (splitmix64).
pub struct Uniform(u64);

impl Uniform {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        let unit = ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64;
        low + (high - low) * unit
    }

    /// Log-uniform.
    pub fn decades(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }
}
