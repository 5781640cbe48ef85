//! Simulation with steps longer than the delay, for delays much shorter than the time constants of the
//! robots, or zero.
//!
//! A break is followed for the few delays in which its echoes matter. From then on the motion is smooth,
//! and the delayed series of a step is the partner's own series shifted by the delay: a fixed-point
//! iteration that contracts by about (fastest rate · delay).

use std::collections::VecDeque;

use super::force::Break;
use super::output::OutputWriter;
use super::series::{
    Coefficients, CoupledStep, Instant, Recurrence, STRIDE, Series, State, advance, advance_both, degree_for,
    is_resolved, reexpand,
};
use super::{Problem, RunOutcome};

/// The largest product of fastest rate and step length.
const REACH: f64 = 2.0;

/// The memory of the method, reused between simulations.
#[derive(Debug, Default)]
pub(super) struct LongSteps {
    past: [VecDeque<Series>; 2],
    events: Vec<f64>,
    recurrences: [Recurrence; 2],
    map: StepMap,
}

/// The maximum number of steps with the map: its rounding error is the same in every step and accumulates.
const MAP_STEPS: f64 = 1e4;

/// The full step as a linear map, built once: the contributions of position, velocity and constant force of
/// each robot to both series and both end states.
#[derive(Debug, Default)]
struct StepMap {
    columns: Vec<([Coefficients; 2], [State; 2])>,
    length: f64,
    degree: usize,
}

impl StepMap {
    /// Builds the columns of the long steps' map from unit states and forces.
    fn build(&mut self, pair: &CoupledStep) -> Option<()> {
        self.columns.clear();
        (self.length, self.degree) = (pair.length, pair.degree);
        for column in 0..6 {
            let (robot, kind) = (column / 3, column % 3);
            let mut from = [State::default(); 2];
            let mut force = [[0.0], [0.0]];
            match kind {
                0 => from[robot].x = 1.0,
                1 => from[robot].v = 1.0 / pair.length,
                _ => force[robot][0] = Self::unit_force(pair, robot),
            }
            let mut series = [[0.0; STRIDE]; 2];
            let unit = CoupledStep { from, force: [&force[0], &force[1]], must_resolve: false, ..*pair };
            let end = advance_both(&unit, &mut series)?;
            self.columns.push((series, end));
        }
        Some(())
    }

    /// A force whose contribution to the long steps' map is about one.
    fn unit_force(pair: &CoupledStep, robot: usize) -> f64 {
        1.0 / (pair.rates[robot].force * pair.length * pair.length)
    }

    /// Applies the map of a long step to its states and forces.
    fn apply(&self, pair: &CoupledStep, series: &mut [Coefficients; 2]) -> [State; 2] {
        let mut states = [State::default(); 2];
        for (column, (unit, end)) in self.columns.iter().enumerate() {
            let (robot, kind) = (column / 3, column % 3);
            let weight = match kind {
                0 => pair.from[robot].x,
                1 => pair.from[robot].v * pair.length,
                _ => pair.force[robot][0] / Self::unit_force(pair, robot),
            };
            for i in 0..2 {
                for (value, unit) in series[i].iter_mut().zip(&unit[i]) {
                    *value += weight * unit;
                }
                states[i].x += weight * end[i].x;
                states[i].v += weight * end[i].v;
            }
        }
        states
    }
}

struct LongStepRun<'a> {
    problem: &'a Problem<'a>,
    memory: &'a mut LongSteps,
    states: [State; 2],
    clock: f64,
    /// The rounding error of the clock.
    clock_rest: f64,
    /// From this time on no echo of a break matters.
    quiet_from: f64,
    cursors: [usize; 2],
    /// Additional terms if the last attempt was not resolved.
    more_terms: usize,
}

/// Simulates with steps longer than the delay.
pub(super) fn simulate_with_long_steps(
    problem: &Problem,
    memory: &mut LongSteps,
    writer: &mut OutputWriter,
) -> RunOutcome {
    memory.events.clear();
    for past in &mut memory.past {
        past.clear();
    }
    memory.recurrences = Default::default();
    memory.map.columns.clear();
    let states = [0, 1].map(|i| problem.histories[i].start());
    let mut march = LongStepRun {
        problem,
        memory,
        states,
        clock: 0.0,
        clock_rest: 0.0,
        quiet_from: 0.0,
        cursors: [0; 2],
        more_terms: 0,
    };
    march.remember_history();
    let limit = problem.end + problem.offsets[0].max(problem.offsets[1]);
    let longest = if problem.fastest > 0.0 { REACH / problem.fastest } else { f64::INFINITY };
    let may_map = limit / longest <= MAP_STEPS;
    let mut cut = 1.0;
    while !writer.is_complete() {
        march.take_reached_breaks();
        // The last step ends at the last output, or slightly later if that is at 0.
        let left = (limit - march.clock).max(problem.delay).max(f64::MIN_POSITIVE.max(1e-9 * limit));
        let room = march.time_to_next_event().min(left).min(longest);
        let room = cut * if room > 0.0 { room } else { 1e-9 };
        let explicit = march.clock < march.quiet_from;
        let next = march.clock + room;
        // Steps of the full length continue exactly; all others end exactly at their event.
        let full = !explicit && room == longest && may_map;
        let gone = (next - march.clock) - march.clock_rest;
        let (length, rest) = if full { (room, room - gone) } else { (gone, 0.0) };
        let done = if explicit { march.explicit_step(length) } else { march.implicit_step(length, full) };
        let Some(states) = done else {
            // A side that hardly moves needs more terms to resolve its small motion.
            if march.more_terms < STRIDE {
                march.more_terms += 8;
                continue;
            }
            (cut, march.more_terms) = (0.5 * cut, 0);
            if cut < 1e-3 {
                return RunOutcome::Unresolved;
            }
            continue;
        };
        (cut, march.more_terms) = (1.0, 0);
        let mut diverged = f64::INFINITY;
        for (i, advanced) in states.into_iter().enumerate() {
            if let Some((start, state)) = advanced {
                march.states[i] = state;
                if let Some(step) = march.memory.past[i].back()
                    && let Some(at) = writer.write_step(i, start, step, state)
                {
                    diverged = diverged.min(at);
                }
            }
        }
        if diverged.is_finite() {
            return RunOutcome::Diverged { at: diverged };
        }
        (march.clock, march.clock_rest) = (next, rest);
        march.drop_old_steps();
    }
    RunOutcome::Completed
}

type Advanced = [Option<(Instant, State)>; 2];

impl LongStepRun<'_> {
    /// The distance within which two times of a long-step run coincide, s.
    fn tolerance(&self) -> f64 {
        16.0 * f64::EPSILON * self.clock.abs().max(self.problem.delay)
    }

    /// In a run of long steps, the number of delays for which a break is followed, until a kink of its order
    /// over one delay is rounding.
    fn echo_count(&self, order: usize) -> usize {
        let small = self.problem.fastest * self.problem.delay;
        let growth = if self.problem.rates[0].damper > 0.0 { 1 } else { 2 };
        let (mut order, mut echoes) = (order + 1, 0);
        let mut effect: f64 = (1..=order).map(|n| small / n as f64).product();
        while effect > 1e-17 {
            for _ in 0..growth {
                order += 1;
                effect *= small / order as f64;
            }
            echoes += 1;
        }
        echoes
    }

    /// Adds a break at `clock` and its echoes to the upcoming events of the long-step run.
    fn add_event(&mut self, clock: f64, order: usize) {
        let delay = self.problem.delay;
        let echoes = if delay > 0.0 { self.echo_count(order) } else { 0 };
        for echo in 0..=echoes {
            let at = clock + echo as f64 * delay;
            if at > self.clock + self.tolerance() {
                let place = self.memory.events.partition_point(|&event| event > at);
                self.memory.events.insert(place, at);
            }
        }
        let quiet = clock + echoes as f64 * delay - self.tolerance();
        self.quiet_from = self.quiet_from.max(quiet);
    }

    /// Stores the history of both robots as steps before the long-step run.
    fn remember_history(&mut self) {
        for i in 0..2 {
            let (history, offset) = (&self.problem.histories[i], self.problem.offsets[i]);
            let mut edges = vec![-self.problem.delay];
            let mut orders = vec![(offset, 1)];
            for break_point in (0..history.break_count()).filter_map(|n| history.break_at(n)) {
                let clock = break_point.time + offset;
                orders.push((clock, break_point.order));
                if clock > -self.problem.delay && clock < offset {
                    edges.push(clock);
                }
            }
            edges.push(offset);
            for pair in edges.windows(2).filter(|pair| pair[1] > pair[0]) {
                let mut coefficients = [0.0; STRIDE];
                let length = pair[1] - pair[0];
                let count = history.series(pair[0] - offset, length, &mut coefficients);
                self.memory.past[i].push_back(Series {
                    start: pair[0],
                    length,
                    degree: count - 1,
                    coefficients,
                });
            }
            for (clock, order) in orders {
                self.add_event(clock, order);
            }
            // History and start are done; the breaks of the forces follow.
            self.cursors[i] = history.break_count() + 1;
        }
    }

    /// The next break of either force in a long-step run, on the common clock.
    fn next_break(&mut self) -> Option<(usize, f64, Break)> {
        let mut earliest: Option<(usize, f64, Break)> = None;
        for i in 0..2 {
            if let Some(break_point) = self.problem.next_own_break(i, &mut self.cursors[i]) {
                let clock = break_point.time + self.problem.offsets[i];
                if earliest.is_none_or(|(_, time, _)| clock < time) {
                    earliest = Some((i, clock, break_point));
                }
            }
        }
        earliest
    }

    /// Adds the breaks that the clock of the long-step run has reached and drops the events behind it.
    fn take_reached_breaks(&mut self) {
        let reached = self.clock + self.tolerance();
        while let Some((robot, clock, break_point)) = self.next_break() {
            if clock > reached {
                break;
            }
            self.cursors[robot] += 1;
            self.add_event(clock, break_point.order);
        }
        while self.memory.events.last().is_some_and(|&event| event <= reached) {
            self.memory.events.pop();
        }
    }

    /// The time of a long-step run until the next break or echo of a break.
    fn time_to_next_event(&mut self) -> f64 {
        let next = self.next_break().map_or(f64::INFINITY, |(_, clock, _)| clock);
        self.memory.events.last().copied().unwrap_or(f64::INFINITY).min(next) - self.clock
    }

    /// The current time of a long-step run on the clock of a robot.
    fn robot_time(&self, robot: usize) -> Instant {
        let mut local = Instant::new(1.0, self.clock, -self.problem.offsets[robot]);
        local.low += self.clock_rest;
        local
    }

    /// Whether the clock of a robot has started in a long-step run.
    fn has_started(&self, robot: usize) -> bool {
        self.clock + self.tolerance() >= self.problem.offsets[robot]
    }

    /// The degree of a Taylor series for the length of a long step.
    fn series_degree(&self, length: f64) -> usize {
        (degree_for(self.problem.fastest * length) + 2 + self.more_terms).min(STRIDE - 1)
    }

    /// In a long-step run, a step no longer than the delay: the delayed partner series is known.
    fn explicit_step(&mut self, length: f64) -> Option<Advanced> {
        let mut advanced = [None; 2];
        let mut steps = [None; 2];
        let degree = self.series_degree(length);
        for i in 0..2 {
            if !self.has_started(i) {
                continue;
            }
            let local = self.robot_time(i);
            let mut force = [0.0; STRIDE];
            let terms = self.problem.forces[i].series(local, length, degree, &mut force);
            let mut delayed = [0.0; STRIDE];
            let known = self.window_series(1 - i, self.clock - self.problem.delay, length, &mut delayed);
            let mut step = Series { start: self.clock, length, degree, coefficients: [0.0; STRIDE] };
            let end = advance(
                &self.problem.rates[i],
                &mut self.memory.recurrences[i],
                self.states[i],
                length,
                degree,
                &delayed[..known],
                &force[..terms],
                &mut step.coefficients,
            )?;
            advanced[i] = Some((local, end));
            steps[i] = Some(step);
        }
        for (past, step) in self.memory.past.iter_mut().zip(steps) {
            past.extend(step);
        }
        Some(advanced)
    }

    /// In a long-step run, writes the series of a robot over a window in the past; returns the number of
    /// coefficients.
    fn window_series(&self, robot: usize, start: f64, length: f64, into: &mut Coefficients) -> usize {
        let mut best: Option<(f64, &Series)> = None;
        for step in self.memory.past[robot].iter().rev() {
            let overlap = (step.start + step.length).min(start + length) - step.start.max(start);
            if best.is_none_or(|(most, _)| overlap > most) {
                best = Some((overlap, step));
            }
            if step.start <= start {
                break;
            }
        }
        let Some((_, step)) = best else { return 0 };
        reexpand(step.used_coefficients(), (start - step.start) / step.length, length / step.length, into);
        step.degree + 1
    }

    /// A long step of any length in a smooth interval, both partners at once.
    fn implicit_step(&mut self, length: f64, full: bool) -> Option<Advanced> {
        let degree = self.series_degree(length);
        let locals = [self.robot_time(0), self.robot_time(1)];
        let mut force = [[0.0; STRIDE]; 2];
        let terms = [0, 1].map(|i| self.problem.forces[i].series(locals[i], length, degree, &mut force[i]));
        let force = [&force[0][..terms[0]], &force[1][..terms[1]]];
        let pair = CoupledStep {
            rates: &self.problem.rates,
            delay: self.problem.delay,
            small: self.problem.fastest * self.problem.delay,
            from: self.states,
            length,
            degree,
            force,
            must_resolve: true,
        };
        let mut series = [[0.0; STRIDE]; 2];
        let map = &mut self.memory.map;
        let states = if full && terms == [1, 1] && self.more_terms == 0 {
            if map.columns.len() < 6 || (map.length, map.degree) != (length, degree) {
                map.build(&pair)?;
            }
            let states = map.apply(&pair, &mut series);
            if !series.iter().all(|series| is_resolved(&series[..=degree])) {
                return None;
            }
            states
        } else {
            advance_both(&pair, &mut series)?
        };
        for (past, coefficients) in self.memory.past.iter_mut().zip(series) {
            past.push_back(Series { start: self.clock, length, degree, coefficients });
        }
        Some([0, 1].map(|i| Some((locals[i], states[i]))))
    }

    /// Drops steps of a long-step run that no delayed window can reach any more.
    fn drop_old_steps(&mut self) {
        let needed = self.clock - 1.01 * self.problem.delay;
        for past in &mut self.memory.past {
            while past.len() > 1 && past.front().is_some_and(|step| step.start + step.length < needed) {
                past.pop_front();
            }
        }
    }
}
