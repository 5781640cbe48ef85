//! The crate `differential-equations` on the same simulation.

use std::error::Error;
use std::hint::black_box;

use differential_equations::prelude::*;
use telespring::dde::linear::output_count;
use telespring::{DyadAxis, hman};

use crate::Bench;
use crate::simulation::{DURATION, RATE, REFERENCE_DELAY, REFERENCE_STIFFNESS};

struct Coupled {
    axis: DyadAxis,
    stiffness: f64,
}

impl DDE<1, f64, [f64; 4]> for Coupled {
    fn diff(&self, _t: f64, y: &[f64; 4], delayed: &[[f64; 4]; 1], rate: &mut [f64; 4]) {
        let [one, two] = &self.axis.sides;
        let k = self.stiffness;
        rate[0] = y[1];
        rate[1] = (k * (delayed[0][2] - y[0]) - one.damping * y[1] + 1.0) / one.mass;
        rate[2] = y[3];
        rate[3] = (k * (delayed[0][0] - y[2]) - two.damping * y[3] - 1.0) / two.mass;
    }

    fn lags(&self, _t: f64, _y: &[f64; 4], lags: &mut [f64; 1]) {
        lags[0] = REFERENCE_DELAY;
    }
}

pub fn run(bench: &mut Bench) -> Result<(), Box<dyn Error>> {
    let system = Coupled { axis: hman().axis(0)?, stiffness: 2.0 * REFERENCE_STIFFNESS };
    let count = output_count(DURATION, RATE)?;
    // its documented method and tolerances, and the best that was found for it
    macro_rules! measure {
        ($name:literal, $method:expr) => {
            let solve = || {
                IVP::dde(&system, 0.0, DURATION, [0.0; 4], |_| [0.0; 4])
                    .even(1.0 / RATE)
                    .method($method)
                    .solve()
            };
            match solve() {
                Ok(solution) => {
                    bench.time(concat!("differential-equations/", $name), 1, 1.0, || {
                        black_box(solve().is_ok());
                    });
                    // its last output but one may repeat the end, off by rounding
                    let skip = solution.y.len() - 2;
                    let surplus = skip + 2 > count;
                    let kept = solution.y.iter().enumerate().filter(|&(n, _)| !surplus || n != skip);
                    let robot = |i: usize| kept.clone().map(|(_, y)| y[i]).collect::<Vec<_>>();
                    bench.save(concat!("differential-equations-", $name), [&robot(0), &robot(2)])?;
                }
                Err(error) => {
                    bench.note(concat!("differential-equations/", $name), format!("{error:?}"));
                }
            }
        };
    }
    measure!("rkv878e", ExplicitRungeKutta::rkv878e().max_delay(REFERENCE_DELAY));
    measure!("dopri5", ExplicitRungeKutta::dopri5().rtol(1e-6).atol(1e-9).max_delay(REFERENCE_DELAY));
    measure!("dop853", ExplicitRungeKutta::dop853().rtol(1e-9).atol(1e-12).max_delay(REFERENCE_DELAY));
    measure!(
        "dop853-fine",
        ExplicitRungeKutta::dop853().rtol(1e-12).atol(1e-15).h_max(0.02).max_delay(REFERENCE_DELAY)
    );
    Ok(())
}
