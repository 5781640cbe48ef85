//! Writes the outputs of a simulation into the caller's arrays.

use super::MAGNITUDE_LIMIT;
use super::series::{Coefficients, Instant, STRIDE, Series, State, evaluate};

/// True for outputs beyond [`MAGNITUDE_LIMIT`] and for NaN.
fn is_beyond(value: f64) -> bool {
    value.is_nan() || value.abs() > MAGNITUDE_LIMIT
}

/// Writes positions and velocities at t = i/rate as the steps arrive.
pub(super) struct OutputWriter<'a> {
    rate: f64,
    count: usize,
    next: [usize; 2],
    position: [&'a mut [f64]; 2],
    velocity: Option<[&'a mut [f64]; 2]>,
}

impl<'a> OutputWriter<'a> {
    /// A writer for `count` outputs at `rate` (Hz) into the caller's arrays.
    pub(super) fn new(
        rate: f64,
        count: usize,
        position: [&'a mut [f64]; 2],
        velocity: Option<[&'a mut [f64]; 2]>,
    ) -> Self {
        Self { rate, count, next: [0; 2], position, velocity }
    }

    /// Restarts writing from the first output of the simulation.
    pub(super) fn restart(&mut self) {
        self.next = [0; 2];
    }

    /// True if every output of both robots' simulation is written.
    pub(super) fn is_complete(&self) -> bool {
        self.next.iter().all(|&next| next >= self.count)
    }

    /// Writes the outputs of `robot` within a step that starts at `start` on the robot's clock and ends in
    /// `state`; returns the time from which positions exceed [`MAGNITUDE_LIMIT`], if they do.
    pub(super) fn write_step(
        &mut self,
        robot: usize,
        start: Instant,
        series: &Series,
        state: State,
    ) -> Option<f64> {
        let end = start.high + series.length;
        let first = self.next[robot];
        // A point on the edge of two steps is taken from the first: both agree there.
        let stop = ((end * self.rate * (1.0 + 2.0 * f64::EPSILON)).floor() + 1.0).max(0.0);
        let stop = if stop < self.count as f64 { stop as usize } else { self.count };
        let diverged = is_beyond(state.x);
        if stop > first {
            let nominal = first as f64 / self.rate;
            let rest = (-nominal).mul_add(self.rate, first as f64) / self.rate;
            let u = ((nominal - start.high) - start.low + rest) / series.length;
            let spacing = 1.0 / (self.rate * series.length);
            evaluate(series.used_coefficients(), u, spacing, &mut self.position[robot][first..stop]);
            if let Some(velocity) = &mut self.velocity {
                let mut slopes: Coefficients = [0.0; STRIDE];
                let inverse = 1.0 / series.length;
                for (n, (slope, value)) in slopes.iter_mut().zip(&series.used_coefficients()[1..]).enumerate()
                {
                    *slope = (n + 1) as f64 * inverse * value;
                }
                evaluate(&slopes[..series.degree], u, spacing, &mut velocity[robot][first..stop]);
            }
            self.next[robot] = stop;
            if diverged {
                let beyond = self.position[robot][first..stop].iter().position(|x| is_beyond(*x));
                if let Some(i) = beyond {
                    return Some((first + i) as f64 / self.rate);
                }
            }
        }
        diverged.then_some(end)
    }

    /// The number of outputs before `time`.
    pub(super) fn count_before(&self, time: f64) -> usize {
        let estimate = (time * self.rate).floor().max(0.0) as usize;
        let mut count = estimate.saturating_sub(1);
        while count < self.count && (count as f64 / self.rate) < time {
            count += 1;
        }
        count.min(self.count)
    }
}
