//! Simulation with steps that divide the delay: a step of one robot coincides exactly with the partner's
//! step one delay earlier, whose coefficients are used unchanged.
//!
//! Times are (interval, θ) with 0 ≤ θ < delay, so an event at (j, θ) reaches the partner at (j + 1, θ)
//! without rounding. At a break inside a cell (a sample, a robot's later start) the cell is cut, and cut
//! again in the following intervals until the kink is negligible; its order grows by two with every
//! passage.

use super::output::OutputWriter;
use super::series::{
    Coefficients, Instant, MAX_DEGREE, Recurrence, STRIDE, Series, State, advance, degree_for, reexpand,
};
use super::{Problem, RunOutcome};

/// The effect of a kink, relative to the signal, below which it is dropped.
const NEGLIGIBLE: f64 = 1e-17;

/// A break within one delay interval.
#[derive(Debug, Clone, Copy)]
struct Kink {
    theta: f64,
    /// The lowest derivative of the position that jumps.
    order: usize,
    /// The effect of the jump on the position within one cell, relative to the signal.
    effect: f64,
}

/// The steps of one robot in one delay interval; the storage is reused.
#[derive(Debug, Default)]
struct StepTrack {
    steps: Vec<Series>,
    count: usize,
}

impl StepTrack {
    /// Appends a Taylor step on the delay grid to the track of a robot.
    fn push_step(&mut self, start: f64, length: f64) -> &mut Series {
        if self.count == self.steps.len() {
            self.steps.push(Series { start, length, degree: 0, coefficients: [0.0; STRIDE] });
        }
        let step = &mut self.steps[self.count];
        self.count += 1;
        (step.start, step.length) = (start, length);
        step
    }

    /// The coefficients of a robot's track on the delay grid over [start, start + length]; `cursor` moves along.
    fn window_series<'a>(
        &'a self,
        cursor: &mut usize,
        start: f64,
        length: f64,
        scratch: &'a mut Coefficients,
    ) -> &'a [f64] {
        let steps = &self.steps[..self.count];
        while *cursor + 1 < steps.len() && steps[*cursor + 1].start <= start {
            *cursor += 1;
        }
        let mut best = &steps[*cursor];
        if best.start == start && best.length == length {
            return best.used_coefficients();
        }
        // All steps under the window belong to one smooth interval, up to negligible kinks: the longest one
        // is expanded with the least rounding.
        for step in &steps[*cursor + 1..] {
            if step.start >= start + length {
                break;
            }
            if step.length > best.length {
                best = step;
            }
        }
        reexpand(best.used_coefficients(), (start - best.start) / best.length, length / best.length, scratch);
        &scratch[..=best.degree]
    }
}

/// The memory of the method, reused between simulations.
#[derive(Debug, Default)]
pub(super) struct Grid {
    previous: [StepTrack; 2],
    current: [StepTrack; 2],
    kinks_before: [Vec<Kink>; 2],
    kinks: [Vec<Kink>; 2],
}

/// The current state of a robot.
struct RobotState {
    state: State,
    break_cursor: usize,
    recurrence: Recurrence,
    force: Coefficients,
}

/// Simulates the linear dyad on a grid of steps that divide the delay, `cells` per delay.
pub(super) fn simulate_on_grid(
    problem: &Problem,
    cells: usize,
    grid: &mut Grid,
    writer: &mut OutputWriter,
) -> RunOutcome {
    let delay = problem.delay;
    let cell = delay / cells as f64;
    let degree = degree_for(problem.fastest * cell);
    let last_clock = problem.end + problem.offsets[0].max(problem.offsets[1]);
    let mut robots = [0, 1].map(|i| RobotState {
        state: problem.histories[i].start(),
        break_cursor: 0,
        recurrence: Recurrence::default(),
        force: [0.0; STRIDE],
    });
    let mut scratch = [0.0; STRIDE];
    for kinks in grid.kinks_before.iter_mut().chain(&mut grid.kinks) {
        kinks.clear();
    }
    let mut interval = -1.0;
    while !writer.is_complete() {
        let mut diverged = f64::INFINITY;
        let (last, tolerance) = (interval * delay, 16.0 * f64::EPSILON * (interval + 3.0) * delay);
        for (i, robot) in robots.iter_mut().enumerate() {
            let kinks = &mut grid.kinks[i];
            kinks.clear();
            propagate_kinks(problem, i, cell, &grid.kinks_before[1 - i], kinks);
            add_own_breaks(problem, i, interval, tolerance, cell, cells, &mut robot.break_cursor, kinks);
            let track = &mut grid.current[i];
            track.count = 0;
            let partner = &grid.previous[1 - i];
            let mut partner_cursor = 0;
            let (mut next_cell, mut next_kink, mut theta) = (1, 0, 0.0);
            while next_cell <= cells && last + theta <= last_clock {
                let mut end = if next_cell == cells { delay } else { cell * next_cell as f64 };
                match kinks.get(next_kink) {
                    Some(kink) if kink.theta < end => {
                        end = kink.theta;
                        next_kink += 1;
                    }
                    _ => next_cell += 1,
                }
                let length = end - theta;
                let local = Instant::new(interval, delay, theta - problem.offsets[i]);
                let step = track.push_step(theta, length);
                theta = end;
                if local.high + 0.5 * length < 0.0 {
                    let count = problem.histories[i].series(local.high, length, &mut step.coefficients);
                    step.degree = count - 1;
                    continue;
                }
                let delayed = partner.window_series(&mut partner_cursor, step.start, length, &mut scratch);
                if !robot.advance_robot(problem, i, local, degree, delayed, step) {
                    return RunOutcome::Unresolved;
                }
                if let Some(at) = writer.write_step(i, local, step, robot.state) {
                    diverged = diverged.min(at);
                    break;
                }
            }
        }
        if diverged.is_finite() {
            return RunOutcome::Diverged { at: diverged };
        }
        std::mem::swap(&mut grid.previous, &mut grid.current);
        std::mem::swap(&mut grid.kinks_before, &mut grid.kinks);
        interval += 1.0;
    }
    RunOutcome::Completed
}

impl RobotState {
    /// One Taylor step on the delay grid; the degree grows until the series is resolved. False if it never is.
    fn advance_robot(
        &mut self,
        problem: &Problem,
        robot: usize,
        local: Instant,
        mut degree: usize,
        delayed: &[f64],
        step: &mut Series,
    ) -> bool {
        let (rates, length) = (&problem.rates[robot], step.length);
        loop {
            let terms = problem.forces[robot].series(local, length, degree, &mut self.force);
            let (force, series) = (&self.force[..terms], &mut step.coefficients);
            step.degree = degree;
            if let Some(end) =
                advance(rates, &mut self.recurrence, self.state, length, degree, delayed, force, series)
            {
                self.state = end;
                return true;
            }
            if degree == MAX_DEGREE {
                return false;
            }
            degree = (degree + 6).min(MAX_DEGREE);
        }
    }
}

/// Propagates the partner's kinks of the last interval of the delay grid, one passage smoother.
fn propagate_kinks(problem: &Problem, robot: usize, cell: f64, from: &[Kink], into: &mut Vec<Kink>) {
    let rates = &problem.rates[robot];
    for kink in from {
        let order = kink.order as f64;
        let spring = rates.coupling * cell * cell / ((order + 1.0) * (order + 2.0));
        let damper = rates.damper * cell / (order + 1.0);
        let effect = kink.effect * spring.max(damper);
        let order = kink.order + if rates.damper > 0.0 { 1 } else { 2 };
        if effect > NEGLIGIBLE {
            into.push(Kink { theta: kink.theta, order, effect });
        }
    }
}

/// Adds the breaks of the robot's own force, start and history; those on the grid need no cut.
#[expect(clippy::too_many_arguments, reason = "private; a struct would only rename them")]
fn add_own_breaks(
    problem: &Problem,
    robot: usize,
    interval: f64,
    tolerance: f64,
    cell: f64,
    cells: usize,
    cursor: &mut usize,
    kinks: &mut Vec<Kink>,
) {
    let passed_on = kinks.len();
    while let Some(break_point) = problem.next_own_break(robot, cursor) {
        let theta = (-interval).mul_add(problem.delay, break_point.time + problem.offsets[robot]);
        if theta >= problem.delay - tolerance {
            break;
        }
        *cursor += 1;
        if theta < -tolerance {
            continue;
        }
        let nearest = (theta / cell).round().min(cells as f64);
        let on_grid = (theta - nearest * cell).abs() <= tolerance;
        let here = kinks[..passed_on].partition_point(|kink| kink.theta < theta);
        let near = |kink: Option<&Kink>| kink.is_some_and(|kink| (kink.theta - theta).abs() <= tolerance);
        if on_grid {
            continue;
        }
        // A kink that coincides with an existing one keeps the exact place of that one.
        let twin = [Some(here), here.checked_sub(1)]
            .into_iter()
            .flatten()
            .find(|&n| n < passed_on && near(kinks.get(n)));
        if let Some(n) = twin {
            kinks[n].order = kinks[n].order.min(break_point.order);
            kinks[n].effect = kinks[n].effect.max(break_point.effect);
        } else if !(kinks.len() > passed_on && near(kinks.last())) {
            kinks.push(Kink { theta, order: break_point.order, effect: break_point.effect });
        }
    }
    if kinks.len() > passed_on && passed_on > 0 {
        kinks.sort_by(|a, b| a.theta.total_cmp(&b.theta));
    }
}
