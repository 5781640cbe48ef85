//! Steps longer than the delay, for delays much shorter than the robots' own times (and none at all).
//!
//! A break is followed for the few delays within which its echoes matter; from then on the motion is
//! smooth and a step's delayed series is the partner's own series on the same step, shifted by the delay:
//! a fixed point that contracts by about (fastest rate · delay) with each iteration.

use std::collections::VecDeque;

use super::force::Break;
use super::output::Writer;
use super::series::{
    Coefficients, Instant, Pair, Recurrence, STRIDE, Series, State, advance, advance_both, degree_for,
    reexpand, resolved,
};
use super::{Problem, RunOutcome};

/// Largest (fastest rate · step length).
const REACH: f64 = 2.0;

/// Memory of the method, kept from one simulation to the next.
#[derive(Debug, Default)]
pub(super) struct Smooth {
    past: [VecDeque<Series>; 2],
    events: Vec<f64>,
    recurrences: [Recurrence; 2],
    map: Map,
}

/// Most steps for which the map is used: its rounding is the same in every step and adds up.
const MAP_STEPS: f64 = 1e4;

/// The full step as a linear map, built once: what position, velocity and constant force of each robot
/// contribute to both series and both end states.
#[derive(Debug, Default)]
struct Map {
    columns: Vec<([Coefficients; 2], [State; 2])>,
    length: f64,
    degree: usize,
}

impl Map {
    fn build(&mut self, pair: &Pair) -> Option<()> {
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
            let unit = Pair { from, force: [&force[0], &force[1]], must_resolve: false, ..*pair };
            let end = advance_both(&unit, &mut series)?;
            self.columns.push((series, end));
        }
        Some(())
    }

    /// The force whose contribution is of the order of one.
    fn unit_force(pair: &Pair, robot: usize) -> f64 {
        1.0 / (pair.rates[robot].force * pair.length * pair.length)
    }

    fn apply(&self, pair: &Pair, series: &mut [Coefficients; 2]) -> [State; 2] {
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

struct March<'a> {
    problem: &'a Problem<'a>,
    memory: &'a mut Smooth,
    states: [State; 2],
    clock: f64,
    /// What rounding has left out of the clock.
    clock_rest: f64,
    /// From here on no echo of a break matters any more.
    quiet_from: f64,
    cursors: [usize; 2],
    /// Terms beyond the usual degree, where the last attempt was not resolved.
    more_terms: usize,
}

pub(super) fn run(problem: &Problem, memory: &mut Smooth, writer: &mut Writer) -> RunOutcome {
    memory.events.clear();
    for past in &mut memory.past {
        past.clear();
    }
    memory.recurrences = Default::default();
    memory.map.columns.clear();
    let states = [0, 1].map(|i| problem.histories[i].start());
    let mut march = March {
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
        march.meet_breaks();
        // the last step ends at the last output, or a little later where that is at 0
        let left = (limit - march.clock).max(problem.delay).max(f64::MIN_POSITIVE.max(1e-9 * limit));
        let room = march.room().min(left).min(longest);
        let room = cut * if room > 0.0 { room } else { 1e-9 };
        let explicit = march.clock < march.quiet_from;
        let next = march.clock + room;
        // steps of one length go on exactly; all others end exactly at their event
        let full = !explicit && room == longest && may_map;
        let gone = (next - march.clock) - march.clock_rest;
        let (length, rest) = if full { (room, room - gone) } else { (gone, 0.0) };
        let done = if explicit { march.explicit(length) } else { march.implicit(length, full) };
        let Some(states) = done else {
            // a side that hardly moves yet needs more terms to resolve its own small motion
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
                    && let Some(at) = writer.write(i, start, step, state)
                {
                    diverged = diverged.min(at);
                }
            }
        }
        if diverged.is_finite() {
            return RunOutcome::Diverged { at: diverged };
        }
        (march.clock, march.clock_rest) = (next, rest);
        march.forget();
    }
    RunOutcome::Completed
}

type Advanced = [Option<(Instant, State)>; 2];

impl March<'_> {
    fn tolerance(&self) -> f64 {
        16.0 * f64::EPSILON * self.clock.abs().max(self.problem.delay)
    }

    /// How many delays a break is followed: until a kink of its order over one delay is rounding.
    fn echoes(&self, order: usize) -> usize {
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

    /// Adds a break at `clock` and its echoes to the events still to come.
    fn add_event(&mut self, clock: f64, order: usize) {
        let delay = self.problem.delay;
        let echoes = if delay > 0.0 { self.echoes(order) } else { 0 };
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

    /// The steps before the start, from both histories.
    fn remember_history(&mut self) {
        for i in 0..2 {
            let (history, offset) = (&self.problem.histories[i], self.problem.offsets[i]);
            let mut edges = vec![-self.problem.delay];
            let mut orders = vec![(offset, 1)];
            for found in (0..history.break_count()).filter_map(|n| history.break_at(n)) {
                let clock = found.time + offset;
                orders.push((clock, found.order));
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
            // history and start are dealt with; the forces' breaks follow
            self.cursors[i] = history.break_count() + 1;
        }
    }

    /// The next break of either force, on the common clock.
    fn next_break(&mut self) -> Option<(usize, f64, Break)> {
        let mut earliest: Option<(usize, f64, Break)> = None;
        for i in 0..2 {
            if let Some(found) = self.problem.own_break(i, &mut self.cursors[i]) {
                let clock = found.time + self.problem.offsets[i];
                if earliest.is_none_or(|(_, time, _)| clock < time) {
                    earliest = Some((i, clock, found));
                }
            }
        }
        earliest
    }

    /// Takes in the breaks that the clock has reached and forgets the events behind it.
    fn meet_breaks(&mut self) {
        let reached = self.clock + self.tolerance();
        while let Some((robot, clock, found)) = self.next_break() {
            if clock > reached {
                break;
            }
            self.cursors[robot] += 1;
            self.add_event(clock, found.order);
        }
        while self.memory.events.last().is_some_and(|&event| event <= reached) {
            self.memory.events.pop();
        }
    }

    /// Time until the next event.
    fn room(&mut self) -> f64 {
        let next = self.next_break().map_or(f64::INFINITY, |(_, clock, _)| clock);
        self.memory.events.last().copied().unwrap_or(f64::INFINITY).min(next) - self.clock
    }

    fn local(&self, robot: usize) -> Instant {
        let mut local = Instant::new(1.0, self.clock, -self.problem.offsets[robot]);
        local.low += self.clock_rest;
        local
    }

    fn started(&self, robot: usize) -> bool {
        self.clock + self.tolerance() >= self.problem.offsets[robot]
    }

    fn degree(&self, length: f64) -> usize {
        (degree_for(self.problem.fastest * length) + 2 + self.more_terms).min(STRIDE - 1)
    }

    /// A step not longer than the delay: what the partner did is known.
    fn explicit(&mut self, length: f64) -> Option<Advanced> {
        let mut advanced = [None; 2];
        let mut steps = [None; 2];
        let degree = self.degree(length);
        for i in 0..2 {
            if !self.started(i) {
                continue;
            }
            let local = self.local(i);
            let mut force = [0.0; STRIDE];
            let terms = self.problem.forces[i].series(local, length, degree, &mut force);
            let mut delayed = [0.0; STRIDE];
            let known = self.window(1 - i, self.clock - self.problem.delay, length, &mut delayed);
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

    /// Writes the series of a robot over a window of the past and returns how many coefficients it has.
    fn window(&self, robot: usize, start: f64, length: f64, into: &mut Coefficients) -> usize {
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
        reexpand(step.used(), (start - step.start) / step.length, length / step.length, into);
        step.degree + 1
    }

    /// A step of any length in a smooth stretch: both partners at once.
    fn implicit(&mut self, length: f64, full: bool) -> Option<Advanced> {
        let degree = self.degree(length);
        let locals = [self.local(0), self.local(1)];
        let mut force = [[0.0; STRIDE]; 2];
        let terms = [0, 1].map(|i| self.problem.forces[i].series(locals[i], length, degree, &mut force[i]));
        let force = [&force[0][..terms[0]], &force[1][..terms[1]]];
        let pair = Pair {
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
            if !series.iter().all(|series| resolved(&series[..=degree])) {
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

    /// Drops steps that no delayed window can reach any more.
    fn forget(&mut self) {
        let needed = self.clock - 1.01 * self.problem.delay;
        for past in &mut self.memory.past {
            while past.len() > 1 && past.front().is_some_and(|step| step.start + step.length < needed) {
                past.pop_front();
            }
        }
    }
}
