//! The positive roots of any polynomial of degree up to 4, all that the criteria need: no panic, none invented, none missed.
//!
//! What is checked, coefficients constant first:
//! * every root is a positive finite number, in ascending order;
//! * there are no more of them than sign variations in the coefficients (Descartes);
//! * at each root the value is as small as rounding of the coefficients allows;
//! * wherever the value changes sign beyond doubt, at least one root lies between.

#![no_main]

use libfuzzer_sys::fuzz_target;
use telespring::fuzzing::positive_roots;

/// Coefficients outside these sizes never reach the solver: its callers bound theirs by the ranges of
/// masses, dampings and stiffnesses.
const SMALLEST: f64 = 1e-30;
const LARGEST: f64 = 1e30;
/// Relative backward error granted to a root.
const ROUNDING: f64 = 1e-10;

/// The value and the sum of its terms' magnitudes, both scaled so that nothing overflows.
fn value(coefficients: &[f64], x: f64) -> (f64, f64) {
    let largest = coefficients
        .iter()
        .enumerate()
        .filter(|(_, c)| **c != 0.0)
        .map(|(power, c)| c.abs().ln() + power as f64 * x.ln())
        .fold(f64::NEG_INFINITY, f64::max);
    let terms = coefficients
        .iter()
        .enumerate()
        .filter(|(_, c)| **c != 0.0)
        .map(|(power, c)| c.signum() * (c.abs().ln() + power as f64 * x.ln() - largest).exp());
    terms.fold((0.0, 0.0), |(sum, size), term| (sum + term, size + term.abs()))
}

fuzz_target!(|bytes: &[u8]| {
    let coefficients: Vec<f64> = bytes
        .chunks_exact(8)
        .take(5)
        .map(|chunk| f64::from_le_bytes(chunk.try_into().expect("chunks of eight bytes")))
        .map(|c| if c.is_finite() && (SMALLEST..=LARGEST).contains(&c.abs()) { c } else { 0.0 })
        .collect();
    let roots = positive_roots(&coefficients);

    let nonzero: Vec<f64> = coefficients.iter().copied().filter(|c| *c != 0.0).collect();
    let variations = nonzero.windows(2).filter(|pair| (pair[0] > 0.0) != (pair[1] > 0.0)).count();
    assert!(roots.len() <= variations, "{roots:?} but {variations} variations in {coefficients:?}");
    assert!(roots.iter().all(|root| root.is_finite() && *root > 0.0), "{roots:?} of {coefficients:?}");
    assert!(roots.is_sorted(), "{roots:?} of {coefficients:?}");
    for &root in &roots {
        let (residue, size) = value(&coefficients, root);
        // Logarithms of sizes up to 10¹⁵⁰ cost some digits.
        assert!(
            residue.abs() <= ROUNDING * size,
            "{root} is no root of {coefficients:?}: {residue} of {size}"
        );
    }

    // Twelve samples a decade over every scale at which two terms can balance.
    let mut last: Option<(f64, f64)> = None;
    for step in -800..=800 {
        let x = 10f64.powf(f64::from(step) / 12.0);
        let (sum, size) = value(&coefficients, x);
        if size == 0.0 || sum.abs() <= 1e-9 * size {
            continue;
        }
        if let Some((before, sign)) = last
            && sign != sum.signum()
        {
            let found = roots.iter().any(|root| (before..=x).contains(root));
            assert!(found, "a root between {before} and {x} of {coefficients:?} is missing from {roots:?}");
        }
        last = Some((x, sum.signum()));
    }
});
