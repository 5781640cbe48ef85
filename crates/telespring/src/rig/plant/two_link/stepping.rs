//! Time integration under held forces: Dormand–Prince 5(4) steps (1980), cut where an axis stops or breaks
//! loose.

use super::dynamics::{ArmDynamics, ForceBalance};
use super::friction::{Contact, consistent_contacts, motion_under, sticking_excess};
use super::{Halt, OutOfReach};

/// Positions, m, and velocities, m/s.
pub(super) type State = [f64; 4];

/// Error of one step, relative to the speed (at least `SLOW`) and in m. The whole motion is then accurate
/// to about 1e-9, since errors of a damped motion do not accumulate for long.
const RELATIVE_TOLERANCE: f64 = 1e-11;
const POSITION_TOLERANCE: f64 = 1e-13;
const SLOW: f64 = 1e-2;
/// A step is not cut below this fraction of the span.
const SMALLEST_STEP: f64 = 1e-7;
/// Halvings that locate an event: from 1 ms to below 1e-16 s.
const HALVINGS: usize = 44;
/// The step limit per span, and per second of it. Arms and robots of realistic mass need a few steps per 1
/// ms; a trial of 30 s at 1 kHz that needs all of them takes about 10 s.
const MAX_STEPS: f64 = 300.0;
const MAX_STEPS_PER_SECOND: f64 = 1e5;
/// The event limit per span; the rest is then integrated without events. More events can come only from
/// rounding, where an axis starts with almost no excess force.
const MAX_EVENTS: usize = 64;

/// The coefficients of E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I,
/// 1993, table II.5.2; the last row is the step itself.
const STAGES: [&[f64]; 6] = [
    &[1.0 / 5.0],
    &[3.0 / 40.0, 9.0 / 40.0],
    &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
    &[19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0],
    &[9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0],
    &[35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];
/// The step minus that of the embedded method of order 4.
const ERROR: [f64; 7] =
    [71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0];

/// The forces held over a span.
#[derive(Debug, Clone, Copy)]
pub(super) struct HeldForces {
    pub torque: [f64; 2],
    pub robot_force: [f64; 2],
}

struct StepResult {
    state: State,
    derivative: State,
    balance: ForceBalance,
    /// The estimated error divided by the tolerance.
    error: f64,
}

struct HeldSpan<'a> {
    rig: &'a ArmDynamics,
    held: HeldForces,
    contact: [Contact; 2],
}

/// Position and velocity in a state that is stepped.
#[inline]
fn split_state([px, py, vx, vy]: State) -> ([f64; 2], [f64; 2]) {
    ([px, py], [vx, vy])
}

impl HeldSpan<'_> {
    /// The force balance of robot and arm in a state of the stepping, under the held forces.
    #[inline]
    fn force_balance(&self, state: State) -> Result<ForceBalance, OutOfReach> {
        let (position, velocity) = split_state(state);
        self.rig.force_balance(position, velocity, self.held.torque, self.held.robot_force)
    }

    /// The time derivative of a stepped state under the present contacts.
    #[inline]
    fn derivative(&self, state: State, balance: &ForceBalance) -> State {
        let [ax, ay] = motion_under(balance, self.contact, self.rig.handle.coulomb).acceleration;
        [state[2], state[3], ax, ay]
    }

    /// One Dormand–Prince step of robot and arm with its error estimate.
    #[inline]
    fn runge_kutta_step(&self, start: State, slope: State, length: f64) -> Result<StepResult, OutOfReach> {
        let mut slopes = [slope; 7];
        let mut state = start;
        let mut last = None;
        for (stage, weights) in STAGES.iter().enumerate() {
            for i in 0..4 {
                let sum: f64 = weights.iter().zip(&slopes).map(|(weight, slope)| weight * slope[i]).sum();
                state[i] = start[i] + length * sum;
            }
            let balance = self.force_balance(state)?;
            slopes[stage + 1] = self.derivative(state, &balance);
            last = Some(balance);
        }
        let missed = |i: usize| {
            let sum: f64 = ERROR.iter().zip(&slopes).map(|(weight, slope)| weight * slope[i]).sum();
            (length * sum).abs()
        };
        let speed = state[2].abs().max(state[3].abs()).max(SLOW);
        let error = (missed(0).max(missed(1)) / POSITION_TOLERANCE)
            .max(missed(2).max(missed(3)) / (RELATIVE_TOLERANCE * speed));
        let balance = last.expect("there are stages");
        Ok(StepResult { state, derivative: slopes[6], balance, error })
    }

    /// Whether a sticking or slipping contact is violated in a stepped state.
    fn is_broken(&self, state: State, balance: &ForceBalance) -> bool {
        let level = self.rig.handle.coulomb;
        (0..2).any(|axis| match self.contact[axis] {
            Contact::Frictionless => false,
            Contact::Stuck => {
                sticking_excess(motion_under(balance, self.contact, level).friction[axis], level[axis]) > 0.0
            }
            slipping => slipping.direction() * state[2 + axis] < 0.0,
        })
    }

    /// Locates the first contact violation within a step: the time, and the step that just passes it.
    ///
    /// A contact violated and restored within one step is missed. Steps are short enough that this moved
    /// the handle by less than 1e-10 m in each of 60 000 random spans of 0.1 s.
    fn first_event(
        &self,
        start: State,
        slope: State,
        whole: StepResult,
        length: f64,
    ) -> Result<Option<(f64, StepResult)>, OutOfReach> {
        if !self.is_broken(whole.state, &whole.balance) {
            return Ok(None);
        }
        let (mut before, mut after) = (0.0, (length, whole));
        for _ in 0..HALVINGS {
            let middle = 0.5 * (before + after.0);
            let trial = self.runge_kutta_step(start, slope, middle)?;
            if self.is_broken(trial.state, &trial.balance) {
                after = (middle, trial);
            } else {
                before = middle;
            }
        }
        Ok(Some(after))
    }
}

/// Integrates robot and two-link arm over `span`, s.
///
/// `guess` is the last successful step, with which the next span starts.
pub(super) fn advance_two_link(
    rig: &ArmDynamics,
    held: HeldForces,
    span: f64,
    state: &mut State,
    guess: &mut f64,
) -> Result<(), Halt> {
    let level = rig.handle.coulomb;
    let has_friction = level != [0.0; 2];
    let mut work = HeldSpan { rig, held, contact: [Contact::Frictionless; 2] };
    let mut left = span;
    let mut events = 0;
    let mut balance = work.force_balance(*state)?;
    work.contact = consistent_contacts(&balance, split_state(*state).1, level);
    let mut slope = work.derivative(*state, &balance);
    let mut steps_left = MAX_STEPS + MAX_STEPS_PER_SECOND * span;
    while left > 0.0 {
        if work.contact == [Contact::Stuck; 2] {
            // Nothing moves, so nothing changes until other forces act.
            return Ok(());
        }
        steps_left -= 1.0;
        if steps_left < 0.0 {
            return Err(Halt::TooStiff { position: split_state(*state).0 });
        }
        let length = guess.min(left);
        let trial = match work.runge_kutta_step(*state, slope, length) {
            Ok(trial) if trial.error.is_finite() => trial,
            _ if length > SMALLEST_STEP * span => {
                *guess = 0.5 * length;
                continue;
            }
            _ => return Err(OutOfReach { position: split_state(*state).0 }.into()),
        };
        // Order 5: the error falls with the fifth power of the step.
        let change = (0.9 * trial.error.powf(-0.2)).clamp(0.2, 5.0);
        if trial.error > 1.0 && length > SMALLEST_STEP * span {
            *guess = length * change;
            continue;
        }
        if length < left || change < 1.0 {
            *guess = length * change;
        } else {
            *guess = guess.max(length * change);
        }
        if !has_friction {
            *state = trial.state;
            slope = trial.derivative;
            left = if length < left { left - length } else { 0.0 };
            continue;
        }
        let (end, next) = (trial.state, trial.derivative);
        let event = if events < MAX_EVENTS { work.first_event(*state, slope, trial, length)? } else { None };
        match event {
            None => {
                *state = end;
                slope = next;
                left = if length < left { left - length } else { 0.0 };
            }
            Some((at, trial)) => {
                events += 1;
                *state = trial.state;
                left = if at < left { left - at } else { 0.0 };
                for axis in 0..2 {
                    if work.contact[axis].direction() * state[2 + axis] < 0.0 {
                        state[2 + axis] = 0.0;
                    }
                }
                balance = work.force_balance(*state)?;
                work.contact = consistent_contacts(&balance, split_state(*state).1, level);
                slope = work.derivative(*state, &balance);
            }
        }
    }
    Ok(())
}
