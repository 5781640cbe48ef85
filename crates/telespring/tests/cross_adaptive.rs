//! The adaptive solver against a method that shares no code with it: classical Runge-Kutta of order 4 at a fixed
//! fine step with cubic Hermite lookups, blind to break points.

use std::convert::Infallible;

use telespring::dde::adaptive::{DelayKind, Options, Status, solve};

const END: f64 = 8.0;

fn delay(t: f64) -> f64 {
    0.15 + 0.05 * (2.0 * t).sin()
}

/// Two robots with a spring whose force saturates at 3 N and smooth friction, pushed by a constant force of 1 N.
fn slope(y: &[f64], z: &[f64]) -> [f64; 4] {
    let spring = |gap: f64| 3.0 * (71.2 * gap / 3.0).tanh();
    let friction = |v: f64| 0.2 * (v / 0.05).tanh() + 2.0 * v;
    [
        y[2],
        y[3],
        (1.0 + spring(z[1] - y[0]) - friction(y[2])) / 0.8334,
        (spring(z[0] - y[1]) - friction(y[3])) / 1.0649,
    ]
}

/// The state at `steps` + 1 equidistant times.
fn fixed_step(steps: usize) -> Vec<[f64; 4]> {
    let width = END / steps as f64;
    let mut states = vec![[0.0; 4]];
    let mut slopes: Vec<[f64; 4]> = Vec::new();
    let look_up = |states: &[[f64; 4]], slopes: &[[f64; 4]], s: f64| {
        if s <= 0.0 {
            return [0.0; 4];
        }
        let index = ((s / width) as usize).min(slopes.len() - 2);
        let u = s / width - index as f64;
        std::array::from_fn(|i| {
            let (a, b) = (states[index][i], states[index + 1][i]);
            let (p, q) = (width * slopes[index][i], width * slopes[index + 1][i]);
            a + u * (p + u * (3.0 * (b - a) - 2.0 * p - q + u * (2.0 * (a - b) + p + q)))
        })
    };
    for n in 0..=steps {
        let (t, y) = (n as f64 * width, states[n]);
        let at = |c: f64, y: &[f64; 4], slopes: &[[f64; 4]]| {
            let time = t + c * width;
            slope(y, &look_up(&states, slopes, time - delay(time)))
        };
        let k1 = at(0.0, &y, &slopes);
        slopes.push(k1);
        let shifted = |k: &[f64; 4], c: f64| std::array::from_fn(|i| y[i] + c * width * k[i]);
        let k2 = at(0.5, &shifted(&k1, 0.5), &slopes);
        let k3 = at(0.5, &shifted(&k2, 0.5), &slopes);
        let k4 = at(1.0, &shifted(&k3, 1.0), &slopes);
        let next = std::array::from_fn(|i| y[i] + width / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
        states.push(next);
    }
    states
}

#[test]
fn cross_saturated_dyad_under_a_swinging_delay() {
    let solution = solve(
        |_, y, delayed, out| {
            out.copy_from_slice(&slope(y, &delayed[0]));
            Ok::<(), Infallible>(())
        },
        vec![DelayKind::time(delay)],
        |_, out| {
            out.fill(0.0);
            Ok(())
        },
        4,
        None,
        (0.0, END),
        &Options { rtol: 1e-12.into(), atol: 1e-14.into(), ..Options::default() },
    )
    .expect("the problem is well posed");
    assert_eq!(solution.status, Status::Completed);
    let steps = 80_000;
    let states = fixed_step(steps);
    let mut y = [0.0; 4];
    let mut largest: f64 = 0.0;
    for n in (0..=steps).step_by(1000) {
        solution.evaluate(END * n as f64 / steps as f64, &mut y).expect("inside");
        for i in 0..4 {
            largest = largest.max((y[i] - states[n][i]).abs());
        }
    }
    // Seen 1e-11; a break that the fixed step crosses unseen costs up to its square, 1e-8, times the jump there.
    assert!(largest < 1e-10, "{largest:e}, {} steps, {} rejected", solution.steps, solution.rejected);
}
