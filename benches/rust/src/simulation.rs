//! One simulation of 10 s at 1 kHz, and the 32 of the paper's Fig. 5.

use std::error::Error;
use std::hint::black_box;

use telespring::dde::linear::{Force, History, Simulation, Workspace, output_count};
use telespring::{Delay, DyadAxis, hman};

use crate::Bench;

/// K_xy of the paper's two robots, N/m: the worse axis of the critical stiffness.
pub const REFERENCE_STIFFNESS: f64 = 35.615988;
/// Δ_xy, s.
pub const REFERENCE_DELAY: f64 = 0.167;
pub const DURATION: f64 = 10.0;
pub const RATE: f64 = 1000.0;

pub fn run(bench: &mut Bench) -> Result<(), Box<dyn Error>> {
    let count = output_count(DURATION, RATE)?;
    let axis = hman().axis(0)?;
    let stiffness = 2.0 * REFERENCE_STIFFNESS;
    let forces = [Force::Step(1.0), Force::Step(-1.0)];
    let histories: [History; 2] = Default::default();
    let mut workspace = Workspace::default();
    let (mut x1, mut x2) = (vec![0.0; count], vec![0.0; count]);
    let (mut v1, mut v2) = (vec![0.0; count], vec![0.0; count]);

    for (name, each_way, seconds) in [
        ("simulation", REFERENCE_DELAY, 2.0),
        ("simulation/10ms", 1e-2, 0.5),
        ("simulation/1ms", 1e-3, 0.5),
        ("simulation/100us", 1e-4, 0.5),
        ("simulation/1ns", 1e-9, 0.5),
    ] {
        let delay = Delay::each_way(each_way)?;
        let simulation = Simulation {
            axis: &axis,
            stiffness,
            delay: &delay,
            forces: &forces,
            histories: &histories,
            duration: DURATION,
            rate: RATE,
        };
        simulation.run_into([&mut x1, &mut x2], None, &mut workspace)?;
        bench.time(name, 1, seconds, || {
            let ending = simulation.run_into([&mut x1, &mut x2], None, &mut workspace);
            black_box(ending.is_ok());
        });
        bench.save(&name.replace('/', "-"), [&x1, &x2])?;
        if each_way == REFERENCE_DELAY {
            bench.time("simulation/velocities", 1, seconds, || {
                let ending =
                    simulation.run_into([&mut x1, &mut x2], Some([&mut v1, &mut v2]), &mut workspace);
                black_box(ending.is_ok());
            });
            bench.save("simulation-velocities", [&v1, &v2])?;
        }
    }
    grid(bench)
}

/// Four stiffnesses, four delays, two axes.
fn grid(bench: &mut Bench) -> Result<(), Box<dyn Error>> {
    let count = output_count(DURATION, RATE)?;
    let dyad = hman();
    let axes: [DyadAxis; 2] = [dyad.axis(0)?, dyad.axis(1)?];
    let delays = [0.0, 0.5, 1.0, 2.0].map(|factor| Delay::each_way(factor * REFERENCE_DELAY));
    let [d0, d1, d2, d3] = delays;
    let delays = [d0?, d1?, d2?, d3?];
    let forces = [Force::Step(1.0), Force::Step(-1.0)];
    let histories: [History; 2] = Default::default();
    let mut workspace = Workspace::default();
    let mut positions = vec![0.0; 32 * 2 * count];
    let mut all = |positions: &mut [f64]| {
        let mut rows = positions.chunks_exact_mut(count);
        for axis in &axes {
            for factor in [0.5, 1.0, 2.0, 4.0] {
                for delay in &delays {
                    let simulation = Simulation {
                        axis,
                        stiffness: factor * REFERENCE_STIFFNESS,
                        delay,
                        forces: &forces,
                        histories: &histories,
                        duration: DURATION,
                        rate: RATE,
                    };
                    if let (Some(x1), Some(x2)) = (rows.next(), rows.next()) {
                        simulation.run_into([x1, x2], None, &mut workspace)?;
                    }
                }
            }
        }
        Ok::<(), telespring::InvalidInput>(())
    };
    all(&mut positions)?;
    bench.time("grid", 1, 2.0, || {
        black_box(all(&mut positions).is_ok());
    });
    bench.save("grid", [&positions, &[]])?;
    Ok(())
}
