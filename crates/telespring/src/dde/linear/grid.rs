//! Steps that divide the delay: a step of one robot in one delay interval meets exactly the partner's
//! step in the interval before, whose coefficients are used as they are.
//!
//! Times are (interval, θ) with 0 ≤ θ < delay, so that what happens at (j, θ) is felt by the partner at
//! (j + 1, θ) without any rounding. Where something breaks inside a cell of the grid (a sample, a
//! robot's later start), the cell is cut there, and cut again in the next intervals until the kink, whose
//! order grows by two with every passage, is too small to matter.

use super::output::Writer;
use super::series::{
    Coefficients, Instant, MAX_DEGREE, Recurrence, STRIDE, Series, State, advance, degree_for, reexpand,
};
use super::{Problem, RunOutcome};

/// What a kink must amount to, relative to the signal, to be followed further.
const NEGLIGIBLE: f64 = 1e-17;

/// A break inside one delay interval.
#[derive(Debug, Clone, Copy)]
struct Kink {
    theta: f64,
    /// Lowest derivative of the position that jumps.
    order: usize,
    /// The jump's effect on the position within one cell, relative to the signal.
    effect: f64,
}

/// The steps of one robot in one delay interval; storage is kept between intervals.
#[derive(Debug, Default)]
struct Track {
    steps: Vec<Series>,
    count: usize,
}

impl Track {
    fn next(&mut self, start: f64, length: f64) -> &mut Series {
        if self.count == self.steps.len() {
            self.steps.push(Series { start, length, degree: 0, coefficients: [0.0; STRIDE] });
        }
        let step = &mut self.steps[self.count];
        self.count += 1;
        (step.start, step.length) = (start, length);
        step
    }

    /// The coefficients over [start, start + length]; `cursor` follows along.
    fn window<'a>(
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
            return best.used();
        }
        // all steps under the window belong to one smooth stretch, up to negligible kinks: the longest
        // of them is expanded with the least rounding
        for step in &steps[*cursor + 1..] {
            if step.start >= start + length {
                break;
            }
            if step.length > best.length {
                best = step;
            }
        }
        reexpand(best.used(), (start - best.start) / best.length, length / best.length, scratch);
        &scratch[..=best.degree]
    }
}

/// Memory of the method, kept from one simulation to the next.
#[derive(Debug, Default)]
pub(super) struct Grid {
    previous: [Track; 2],
    current: [Track; 2],
    kinks_before: [Vec<Kink>; 2],
    kinks: [Vec<Kink>; 2],
}

/// Where a robot stands.
struct Robot {
    state: State,
    break_cursor: usize,
    recurrence: Recurrence,
    force: Coefficients,
}

pub(super) fn run(problem: &Problem, cells: usize, grid: &mut Grid, writer: &mut Writer) -> RunOutcome {
    let delay = problem.delay;
    let cell = delay / cells as f64;
    let degree = degree_for(problem.fastest * cell);
    let last_clock = problem.end + problem.offsets[0].max(problem.offsets[1]);
    let mut robots = [0, 1].map(|i| Robot {
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
            pass_on(problem, i, cell, &grid.kinks_before[1 - i], kinks);
            add_own(problem, i, interval, tolerance, cell, cells, &mut robot.break_cursor, kinks);
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
                let step = track.next(theta, length);
                theta = end;
                if local.high + 0.5 * length < 0.0 {
                    let count = problem.histories[i].series(local.high, length, &mut step.coefficients);
                    step.degree = count - 1;
                    continue;
                }
                let delayed = partner.window(&mut partner_cursor, step.start, length, &mut scratch);
                if !robot.advance(problem, i, local, degree, delayed, step) {
                    return RunOutcome::Unresolved;
                }
                if let Some(at) = writer.write(i, local, step, robot.state) {
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

impl Robot {
    /// One step; the degree grows where the series is not resolved at once. False where it never is.
    fn advance(
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

/// The partner's kinks of the interval before, one passage smoother.
fn pass_on(problem: &Problem, robot: usize, cell: f64, from: &[Kink], into: &mut Vec<Kink>) {
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
fn add_own(
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
    while let Some(found) = problem.own_break(robot, cursor) {
        let theta = (-interval).mul_add(problem.delay, found.time + problem.offsets[robot]);
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
        // a kink that falls on one that is there already keeps that one's exact place
        let twin = [Some(here), here.checked_sub(1)]
            .into_iter()
            .flatten()
            .find(|&n| n < passed_on && near(kinks.get(n)));
        if let Some(n) = twin {
            kinks[n].order = kinks[n].order.min(found.order);
            kinks[n].effect = kinks[n].effect.max(found.effect);
        } else if !(kinks.len() > passed_on && near(kinks.last())) {
            kinks.push(Kink { theta, order: found.order, effect: found.effect });
        }
    }
    if kinks.len() > passed_on && passed_on > 0 {
        kinks.sort_by(|a, b| a.theta.total_cmp(&b.theta));
    }
}
