//! Exact simulation of the linear dyad: Taylor series on steps that divide the delay.
//!
//! One axis of a dyad with constant delays, each robot on its own clock from t = 0:
//!
//! ```text
//! m₁ x₁'' + b₁ x₁' + k_h1 x₁ = k (x₂(t − backward) − x₁) + c (x₂'(t − backward) − x₁') + f₁(t)
//! m₂ x₂'' + b₂ x₂' + k_h2 x₂ = k (x₁(t − forward)  − x₂) + c (x₁'(t − forward)  − x₂') + f₂(t)
//! ```
//!
//! (Du, Kulkarni, Kager and Campolo, Eq. 1, with operators, a coupling damper and unequal delays added.) On
//! each step both positions are one Taylor series. Its coefficients follow from those of the partner one
//! delay earlier by a two-term recurrence. No delay is rounded and nothing is interpolated. Unequal delays
//! are replaced by their mean, with one robot's clock starting later by half of the difference; this is
//! exact.
//!
//! | part | job |
//! |---|---|
//! | `grid` | steps that divide the delay |
//! | `smooth` | steps longer than the delay, for short or zero delays |
//! | `series` | recurrences, re-expansion, evaluation |
//! | `force`, `history`, `piecewise` | forces, and positions before the start |
//! | `fit` | polynomials through a function of time |

mod fit;
mod force;
mod grid;
mod history;
mod output;
mod piecewise;
mod series;
mod smooth;

pub use force::{Force, Hold, SampledForce, Sine};
pub use history::History;
pub use piecewise::PiecewisePolynomial;

use crate::error::{InvalidInput, Result};
use crate::model::{Delay, DyadAxis};
use crate::quantity;
use force::Break;
use output::OutputWriter;
use series::Rates;

/// A simulation diverges if a position exceeds this magnitude, m: far beyond any robot, but far from
/// overflow. It also bounds forces and histories.
pub const MAGNITUDE_LIMIT: f64 = 1e12;

/// The maximum number of outputs of one simulation.
pub const MAX_OUTPUTS: usize = 1_000_000_000;

/// The maximum number of steps of a simulation: about two minutes of work.
pub const MAX_STEPS: f64 = 1e9;

/// The maximum number of steps within one delay: all are stored, about 0.7 GB.
pub const MAX_STEPS_PER_DELAY: f64 = 5e5;

/// The largest product of fastest rate and step length: a degree of about 25 resolves it.
const REACH: f64 = 2.0;

/// Below this product of fastest rate and delay, steps longer than the delay are cheaper.
const SHORT_DELAY: f64 = 0.35;

/// How a simulation ended.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Status {
    /// Every output was reached.
    Completed,
    /// A position exceeded [`MAGNITUDE_LIMIT`]; outputs from that time on are omitted.
    Diverged {
        /// The first omitted time on the robot's clock, s.
        at: f64,
    },
}

/// A simulation: axis, coupling, forces, histories and duration.
#[derive(Debug, Clone, Copy)]
pub struct Simulation<'a> {
    /// The axis.
    pub axis: &'a DyadAxis,
    /// Stiffness of the virtual spring, N/m; 0 leaves only the coupling damper, if any.
    pub stiffness: f64,
    /// The delays.
    pub delay: &'a Delay,
    /// The force on each robot, N, on that robot's clock.
    pub forces: &'a [Force; 2],
    /// The positions of each robot before t = 0.
    pub histories: &'a [History; 2],
    /// Duration, s.
    pub duration: f64,
    /// Outputs per second, Hz.
    pub rate: f64,
}

/// Positions and velocities of both robots at t = i/rate.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    /// Outputs per second, Hz.
    pub rate: f64,
    /// Per robot, one position (m) per output.
    pub position: [Vec<f64>; 2],
    /// Per robot, one velocity (m/s) per output.
    pub velocity: [Vec<f64>; 2],
    /// How it ended.
    pub status: Status,
    /// The approximation error of each robot's force (N); 0 unless it came from a function.
    pub force_error: [f64; 2],
    /// The approximation error of each robot's history (m); 0 unless it came from a function.
    pub history_error: [f64; 2],
}

impl Trajectory {
    /// The time of output `index` of the simulation, s.
    pub fn time(&self, index: usize) -> f64 {
        index as f64 / self.rate
    }

    /// The number of outputs of the simulation.
    pub fn len(&self) -> usize {
        self.position[0].len()
    }

    /// True if the simulation diverged before its first output.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// How a simulation into the caller's arrays ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SimulationOutcome {
    /// How it ended.
    pub status: Status,
    /// The number of outputs written, from the first; the rest of the arrays is undefined.
    pub outputs: usize,
}

/// Memory for simulations. Reusing it avoids every allocation of [`Simulation::run_into`] that grows with
/// the simulation.
#[derive(Debug, Default)]
pub struct Workspace {
    grid: grid::Grid,
    smooth: smooth::LongSteps,
}

/// The number of outputs of a simulation: i = 0, 1, … up to and including `duration`·`rate`.
///
/// # Errors
///
/// [`InvalidInput`] if duration or rate is out of range, or there would be more than [`MAX_OUTPUTS`].
///
/// # Examples
///
/// ```
/// assert_eq!(telespring::dde::linear::output_count(10.0, 1000.0)?, 10_001);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
pub fn output_count(duration: f64, rate: f64) -> Result<usize> {
    quantity::DURATION.check("duration", duration)?;
    quantity::RATE.check("rate", rate)?;
    // At 100 Hz, 0.29 s has its own output although the product rounds to 28.999….
    let last = (duration * rate * (1.0 + 4.0 * f64::EPSILON)).floor();
    if last < MAX_OUTPUTS as f64 {
        return Ok(last as usize + 1);
    }
    Err(InvalidInput::new(
        "rate",
        rate,
        format!("duration times rate may give at most {MAX_OUTPUTS} outputs, here {last:e}"),
        "Shorten the simulation or lower the rate.",
    ))
}

/// Simulates one axis of a dyad; see the [module](self) for the equations.
///
/// The error relative to the largest value of the signal is below 1e-11 for steps, sines, polynomials and
/// sampled signals; for a function of time its reported approximation error is added.
///
/// # Errors
///
/// [`InvalidInput`] if a value is out of range, or the axis is so stiff (large damping/mass) that more than
/// [`MAX_STEPS`] steps, or [`MAX_STEPS_PER_DELAY`] within one delay, are needed.
///
/// # Examples
///
/// ```
/// use telespring::dde::linear::{Force, History, Status, simulate};
/// use telespring::{Delay, hman};
///
/// let axis = hman().axis(0)?;
/// let forces = [Force::Step(1.0), Force::Step(-1.0)];
/// let stiffness = 2.0 * 35.615988;
/// let result = simulate(&axis, stiffness, &Delay::each_way(0.05)?, &forces, 10.0, 1000.0, &Default::default())?;
/// assert_eq!(result.status, Status::Completed);
/// // stable: the robots come to rest where the spring balances both forces
/// let stretch = result.position[0][10_000] - result.position[1][10_000];
/// assert!((stretch - 1.0 / stiffness).abs() < 1e-6);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
pub fn simulate(
    axis: &DyadAxis,
    stiffness: f64,
    delay: &Delay,
    forces: &[Force; 2],
    duration: f64,
    rate: f64,
    histories: &[History; 2],
) -> Result<Trajectory> {
    Simulation { axis, stiffness, delay, forces, histories, duration, rate }.run(&mut Workspace::default())
}

impl Simulation<'_> {
    /// Runs the simulation and returns positions and velocities.
    ///
    /// # Errors
    ///
    /// As [`simulate`].
    pub fn run(&self, workspace: &mut Workspace) -> Result<Trajectory> {
        let count = output_count(self.duration, self.rate)?;
        let mut position = [vec![0.0; count], vec![0.0; count]];
        let mut velocity = [vec![0.0; count], vec![0.0; count]];
        let outcome = {
            let ([x1, x2], [v1, v2]) = (&mut position, &mut velocity);
            self.run_into([x1, x2], Some([v1, v2]), workspace)?
        };
        for values in position.iter_mut().chain(&mut velocity) {
            values.truncate(outcome.outputs);
        }
        Ok(Trajectory {
            rate: self.rate,
            position,
            velocity,
            status: outcome.status,
            force_error: [self.forces[0].error(), self.forces[1].error()],
            history_error: [self.histories[0].error(), self.histories[1].error()],
        })
    }

    /// Runs the simulation into the caller's arrays of at least [`output_count`] values: positions (m) and
    /// optionally velocities (m/s). After the first call with the same workspace only a few short lists are
    /// allocated at the start, and nothing while it runs.
    ///
    /// # Errors
    ///
    /// As [`simulate`], and if an array is too short.
    pub fn run_into(
        &self,
        position: [&mut [f64]; 2],
        velocity: Option<[&mut [f64]; 2]>,
        workspace: &mut Workspace,
    ) -> Result<SimulationOutcome> {
        let count = output_count(self.duration, self.rate)?;
        let shortest = position.iter().chain(velocity.iter().flatten()).map(|values| values.len()).min();
        if shortest.is_none_or(|length| length < count) {
            return Err(InvalidInput::new(
                "position",
                format!("{} value(s)", shortest.unwrap_or(0)),
                format!("every output array needs {count} values"),
                "output_count gives the length.",
            ));
        }
        let problem = self.problem(count)?;
        let mut writer = OutputWriter::new(self.rate, count, position, velocity);
        let outcome = problem.solve(workspace, &mut writer)?;
        let (status, outputs) = match outcome {
            RunOutcome::Completed => (Status::Completed, count),
            RunOutcome::Diverged { at } => (Status::Diverged { at }, writer.count_before(at)),
            RunOutcome::Unresolved => {
                return Err(too_stiff_error("a series does not converge", self.stiffness));
            }
        };
        Ok(SimulationOutcome { status, outputs })
    }

    /// The checked problem: both robots on one clock with the mean delay.
    fn problem(&self, count: usize) -> Result<Problem<'_>> {
        check_axis(self.axis)?;
        if self.stiffness != 0.0 {
            quantity::STIFFNESS.check("stiffness", self.stiffness)?;
        }
        for (i, force) in self.forces.iter().enumerate() {
            force.check(&format!("forces[{i}]"))?;
        }
        let c = self.axis.coupling_damping;
        let rates = self.axis.sides.map(|side| Rates {
            damping: (side.damping + c) / side.mass,
            stiffness: (self.stiffness + side.ground_stiffness) / side.mass,
            coupling: self.stiffness / side.mass,
            damper: c / side.mass,
            force: 1.0 / side.mass,
        });
        let fastest = [
            rates[0].fastest_rate(),
            rates[1].fastest_rate(),
            self.forces[0].fastest_rate(),
            self.forces[1].fastest_rate(),
        ];
        // The robot whose messages travel longer starts later on the common clock.
        let half = 0.5 * (self.delay.forward() - self.delay.backward());
        Ok(Problem {
            rates,
            forces: self.forces,
            histories: self.histories,
            offsets: [half.max(0.0), (-half).max(0.0)],
            delay: self.delay.mean(),
            fastest: fastest.into_iter().fold(0.0, f64::max),
            end: (count - 1) as f64 / self.rate,
        })
    }
}

/// How one run of a method ended.
pub(in crate::dde::linear) enum RunOutcome {
    Completed,
    Diverged {
        at: f64,
    },
    /// A series did not converge: shorter steps are needed.
    Unresolved,
}

/// The problem that the methods solve: both robots on one clock, with the mean delay each way.
struct Problem<'a> {
    rates: [Rates; 2],
    forces: &'a [Force; 2],
    histories: &'a [History; 2],
    /// The start of each robot on the common clock, s; one of them 0.
    offsets: [f64; 2],
    delay: f64,
    /// The fastest rate of the sides and forces, 1/s.
    fastest: f64,
    /// The last output on the robots' own clocks, s.
    end: f64,
}

impl Problem<'_> {
    /// In a simulation, the first break of a robot (history, start, force) at or after index `cursor`; moves
    /// `cursor` to it.
    fn next_own_break(&self, robot: usize, cursor: &mut usize) -> Option<Break> {
        let history = self.histories[robot].break_count();
        if *cursor < history {
            return self.histories[robot].break_at(*cursor);
        }
        if *cursor == history {
            return Some(Break { time: 0.0, order: 1, effect: 1.0 });
        }
        let mut force_cursor = *cursor - history - 1;
        let break_point = self.forces[robot].next_break(&mut force_cursor);
        *cursor = force_cursor + history + 1;
        break_point
    }

    /// Solves the simulation problem: chooses steps that divide the delay or longer ones, and their number.
    fn solve(&self, workspace: &mut Workspace, writer: &mut OutputWriter) -> Result<RunOutcome> {
        let breaks = (0..2).map(|i| self.forces[i].breaks_before(self.end)).fold(0.0, f64::max);
        let spacing = if breaks > 0.0 { self.end / breaks } else { f64::INFINITY };
        let cells = (self.delay * self.fastest / REACH).ceil().max(1.0);
        let follows_breaks = spacing < 8.0 * self.delay;
        let divides = self.fastest * self.delay > SHORT_DELAY || follows_breaks;
        let intervals = if divides { self.end / self.delay } else { 0.0 };
        if self.fastest * self.end / REACH + intervals + breaks > MAX_STEPS {
            return Err(too_stiff_error("too many steps would be needed", self.fastest));
        }
        if !divides {
            let outcome = smooth::simulate_with_long_steps(self, &mut workspace.smooth, writer);
            if self.delay == 0.0 || !matches!(outcome, RunOutcome::Unresolved) {
                return Ok(outcome);
            }
            writer.restart();
        }
        // Cells as short as the spacing of the breaks keep the degree low where there are many cuts.
        let mut cells = cells.max((self.delay / spacing).floor());
        loop {
            if cells > MAX_STEPS_PER_DELAY {
                return Err(too_stiff_error("too many steps would be needed within one delay", self.fastest));
            }
            match grid::simulate_on_grid(self, cells as usize, &mut workspace.grid, writer) {
                RunOutcome::Unresolved => {
                    cells *= 2.0;
                    writer.restart();
                }
                outcome => return Ok(outcome),
            }
        }
    }
}

/// The error for a simulation that needs too many steps.
fn too_stiff_error(what: &str, rate: f64) -> InvalidInput {
    InvalidInput::new(
        "axis",
        format!("fastest rate {rate} 1/s"),
        format!("{what}: their number follows from the fastest rate, the duration and the delay"),
        "Lower damping, stiffness or frequency, raise the mass, or shorten the simulation.",
    )
}

/// Checks the values of the axis of a simulation.
fn check_axis(axis: &DyadAxis) -> Result<()> {
    let check = |field: String, value: f64, positive: bool| {
        if value.is_finite() && (value > 0.0 || (!positive && value == 0.0)) {
            return Ok(());
        }
        let allowed = if positive {
            "a finite number above 0 is required"
        } else {
            "a finite number of 0 or more is required"
        };
        Err(InvalidInput::new(field, value, allowed, "Build the axis with DyadAxis::new, which checks it."))
    };
    for (i, side) in axis.sides.iter().enumerate() {
        check(format!("axis.sides[{i}].mass"), side.mass, true)?;
        check(format!("axis.sides[{i}].damping"), side.damping, false)?;
        check(format!("axis.sides[{i}].ground_stiffness"), side.ground_stiffness, false)?;
    }
    check("axis.coupling_damping".to_owned(), axis.coupling_damping, false)
}
