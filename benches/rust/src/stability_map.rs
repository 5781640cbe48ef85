//! A million points: is each stable?

use std::error::Error;
use std::hint::black_box;

use telespring::criteria::{maximum_delay, stability_map, unstable_root_count};
use telespring::{DyadAxis, hman};

use crate::Bench;
use crate::timing::Uniform;

pub fn run(bench: &mut Bench) -> Result<(), Box<dyn Error>> {
    let side = if bench.quick { 20 } else { 1000 };
    let axis = hman().axis(0)?;
    let stiffness: Vec<f64> = (0..side).map(|i| 1.0 + 299.0 * i as f64 / (side - 1) as f64).collect();
    let delay: Vec<f64> = (0..side).map(|i| 0.5 * i as f64 / (side - 1) as f64).collect();
    let stable = stability_map(&axis, &stiffness, &delay)?;
    bench.note("map/grid/stable", stable.iter().filter(|&&stable| stable).count());
    bench.time("map/grid", 1, 1.0, || {
        let _ = black_box(stability_map(black_box(&axis), &stiffness, &delay));
    });

    // every point another dyad, another stiffness and another delay
    let mut number = Uniform::new(3);
    let points = (0..side * side)
        .map(|_| {
            let [m1, m2] = [(); 2].map(|()| number.between(0.5, 2.0));
            let [b1, b2] = [(); 2].map(|()| number.between(4.0, 15.0));
            let axis = DyadAxis::new(m1, b1, m2, b2)?;
            Ok((axis, number.between(10.0, 300.0), number.between(0.0, 0.5)))
        })
        .collect::<Result<Vec<_>, telespring::InvalidInput>>()?;
    let mut stable = vec![false; points.len()];
    bench.time("map/random/maximum-delay", 1, 2.0, || {
        for ((axis, k, delay), stable) in points.iter().zip(&mut stable) {
            *stable = maximum_delay(axis, *k).is_ok_and(|most| *delay < most);
        }
        black_box(&stable);
    });
    bench.note("map/random/below-maximum-delay", stable.iter().filter(|&&stable| stable).count());
    bench.time("map/random/all-intervals", 1, 2.0, || {
        for ((axis, k, delay), stable) in points.iter().zip(&mut stable) {
            *stable = unstable_root_count(axis, *k, *delay).is_ok_and(|count| count == 0);
        }
        black_box(&stable);
    });
    bench.note("map/random/stable", stable.iter().filter(|&&stable| stable).count());
    Ok(())
}
