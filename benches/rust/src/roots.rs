//! The rightmost characteristic root with its certificate.

use std::error::Error;
use std::hint::black_box;

use serde_json::json;
use telespring::spectrum::{characteristic_roots, spectral_abscissa};
use telespring::{Delay, hman};

use crate::Bench;
use crate::simulation::{REFERENCE_DELAY, REFERENCE_STIFFNESS};

pub fn run(bench: &mut Bench) -> Result<(), Box<dyn Error>> {
    let axis = hman().axis(0)?;
    let stiffness = 2.0 * REFERENCE_STIFFNESS;
    let delay = Delay::each_way(REFERENCE_DELAY)?;
    bench.time("roots/abscissa", 100, 1.0, || {
        for _ in 0..100 {
            black_box(spectral_abscissa(black_box(&axis), stiffness, &delay).is_ok());
        }
    });
    bench.time("roots/eight", 100, 1.0, || {
        for _ in 0..100 {
            black_box(characteristic_roots(black_box(&axis), stiffness, &delay, 8).is_ok());
        }
    });
    let found = characteristic_roots(&axis, stiffness, &delay, 8)?;
    bench.note("roots/certificate", found.certificate.to_string());
    bench.note("roots/found", found.roots.iter().map(|s| json!([s.re, s.im])).collect::<Vec<_>>());
    Ok(())
}
