//! Critical stiffness, maximum delay and all crossings of many dyads, one after the other.

use std::error::Error;
use std::hint::black_box;

use telespring::verdicts::{Network, OperatorRange, verdicts};
use telespring::criteria::{critical_stiffness, crossings, maximum_delay, paper_critical_stiffness};
use telespring::{Delay, DyadAxis, Operator, hman};

use crate::Bench;
use crate::timing::Uniform;

type Cases = Vec<(DyadAxis, f64)>;

/// Masses and dampings log-uniform over two decades, stiffness 0.2 to 6 times the paper's k_m.
fn two_decades(count: usize) -> Result<Cases, telespring::InvalidInput> {
    let mut number = Uniform::new(1);
    (0..count)
        .map(|_| {
            let [m1, m2] = [(); 2].map(|()| number.decades(0.1, 10.0));
            let [b1, b2] = [(); 2].map(|()| number.decades(0.5, 50.0));
            let axis = DyadAxis::new(m1, b1, m2, b2)?;
            Ok((axis, paper_critical_stiffness(&axis)? * number.decades(0.2, 6.0)))
        })
        .collect()
}

/// Robots like the paper's.
fn like_hman(count: usize) -> Result<Cases, telespring::InvalidInput> {
    let mut number = Uniform::new(2);
    (0..count)
        .map(|_| {
            let [m1, m2] = [(); 2].map(|()| number.between(0.5, 2.0));
            let [b1, b2] = [(); 2].map(|()| number.between(4.0, 15.0));
            Ok((DyadAxis::new(m1, b1, m2, b2)?, number.between(10.0, 300.0)))
        })
        .collect()
}

pub fn run(bench: &mut Bench) -> Result<(), Box<dyn Error>> {
    let count = if bench.quick { 50 } else { 10_000 };
    for (set, cases) in [("two-decades", two_decades(count)?), ("hman-like", like_hman(count)?)] {
        let found: usize = cases.iter().map(|(axis, k)| crossings(axis, *k).map_or(0, |c| c.len())).sum();
        bench.note(&format!("criteria/{set}/crossings-each"), found as f64 / count as f64);
        bench.time(&format!("criteria/{set}/crossings"), count, 1.0, || {
            for (axis, k) in &cases {
                let _ = black_box(crossings(black_box(axis), *k));
            }
        });
        bench.time(&format!("criteria/{set}/maximum-delay"), count, 1.0, || {
            for (axis, k) in &cases {
                let _ = black_box(maximum_delay(black_box(axis), *k));
            }
        });
        bench.time(&format!("criteria/{set}/critical-stiffness"), count, 1.0, || {
            for (axis, _) in &cases {
                black_box(critical_stiffness(black_box(axis)));
            }
        });
        // the first of them, for the comparison with high precision
        let sample: Vec<_> = cases
            .iter()
            .take(60)
            .map(|(axis, k)| {
                let [one, two] = axis.sides;
                let delay = maximum_delay(axis, *k).map_or(f64::NAN, |d| d.min(f64::MAX));
                vec![one.mass, one.damping, two.mass, two.damping, *k, critical_stiffness(axis), delay]
            })
            .collect();
        bench.note(&format!("criteria/{set}/sample"), sample);
    }
    let (dyad, network) = (hman(), Network::constant(Delay::each_way(0.1)?));
    let axis = dyad.axis(0)?;
    bench.time("criteria/hman/critical-stiffness", 1, 1.0, || {
        black_box(critical_stiffness(black_box(&axis)));
    });
    // Every operator from a free handle to a firm grip, under sampled controllers, where remedies are needed too.
    let grip = OperatorRange::new(
        Operator::free(2),
        Operator::new(vec![1.5; 2], vec![10.0; 2], vec![300.0; 2])?,
    )?;
    let grips = [grip.clone(), grip];
    let sampled = Network::new(Delay::each_way(0.1)?, 0.0, 0.0, 0.001, 0.0)?;
    bench.time("criteria/hman/verdicts-over-grips", 1, 1.0, || {
        let _ = black_box(verdicts(black_box(&dyad), Some(&grips), 142.4, &sampled));
    });
    bench.time("criteria/hman/verdicts", 1, 1.0, || {
        let _ = black_box(verdicts(black_box(&dyad), None, 71.2, &network));
    });
    Ok(())
}
