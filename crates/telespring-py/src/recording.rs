//! What is recorded of trials: one trial, or many of the same duration.

use numpy::{Ix1, Ix2, Ix3, Ix4};
use pyo3::prelude::*;

use crate::records::{Array, record};

record! {
    /// The signals of one trial at its recorded instants, and how it ended.
    ///
    /// Row j is at tick j/record_rate; all arrays end where the trial ended. Signals of both robots have the
    /// shape (n, 2 robots, 2 axes). `Laboratory.run` returns it.
    Recording {
        /// Time since the start of the trial, s, (n,).
        time: Array<f64, Ix1>,
        /// Position of the target, m, (n, 2).
        target: Array<f64, Ix2>,
        /// Positions of the handles, m.
        position: Array<f64, Ix3>,
        /// Velocities of the handles, m/s.
        velocity: Array<f64, Ix3>,
        /// Force of each robot on its handle, from this instant on, N.
        coupling_force: Array<f64, Ix3>,
        /// Force that each agent commands its arm, from this instant on, N.
        agent_force: Array<f64, Ix3>,
        /// Force of each arm on its handle, from this instant on, N.
        handle_force: Array<f64, Ix3>,
        /// Where each agent takes the target to be, m.
        aim: Array<f64, Ix3>,
        /// Energy in the account of each side's strategy, J, (n, 2 robots); NaN if it keeps none, or unconnected.
        account: Array<f64, Ix2>,
        /// Age of the partner's motion that each side uses, as played, s, (n, 2 robots); NaN while there is none.
        age: Array<f64, Ix2>,
        /// Share of the instants with a partner at which the strategy changed the force of the spring, (2 robots,); this and
        /// the following are NaN where nothing can be said, as in the unconnected mode.
        limited_share: Array<f64, Ix1>,
        /// Mean share of the spring's force that was withheld at those instants; above 1 where the strategy pushed the
        /// other way, below 0 where a damper made the force larger.
        withheld_share: Array<f64, Ix1>,
        /// Energy that each side gave out to its own handle, as it measured it, J.
        given_out: Array<f64, Ix1>,
        /// Energy that each side's strategy sent to its partner, J.
        energy_sent: Array<f64, Ix1>,
        /// Mean age of the partner's motion in use, s.
        age_mean: Array<f64, Ix1>,
        /// Smallest age of a partner's sample in use, s.
        age_low: Array<f64, Ix1>,
        /// Largest age of a partner's sample in use, s.
        age_high: Array<f64, Ix1>,
        /// Share of the instants at which an old motion was held because no later one had come.
        held_share: Array<f64, Ix1>,
        /// Packets that had not come although later ones had.
        lost: Array<f64, Ix1>,
        /// Energy that the coupling took at both handles, less what it gave out there, J; negative if it gave more.
        coupling_energy: f64,
        /// The smallest value of this energy during the trial, J.
        coupling_energy_minimum: f64,
        /// Energy that each hand got, J, (2 robots,), also in the unconnected mode; negative if it gave more than it got.
        hand_energy: Array<f64, Ix1>,
        /// "completed", "diverged" (a handle went beyond 10 m), "out of reach" (of a two-link arm) or "too
        /// stiff" (time constants of a robot in a two-link arm too short to integrate).
        status: String,
        /// Time of the first tick that is left out, s; None if the trial was completed.
        ended_at: Option<f64>,
    }
}

record! {
    /// The signals of many trials of the same duration.
    ///
    /// As `Recording`, with the trial as the first dimension of all signals; NaN after an early end.
    /// `Laboratory.run_many` returns it.
    Recordings {
        /// Time since the start of a trial, s, (n,).
        time: Array<f64, Ix1>,
        /// Position of the target, m, (trials, n, 2).
        target: Array<f64, Ix3>,
        /// Positions of the handles, m, (trials, n, 2, 2).
        position: Array<f64, Ix4>,
        /// Velocities of the handles, m/s.
        velocity: Array<f64, Ix4>,
        /// Force of each robot on its handle, from this instant on, N.
        coupling_force: Array<f64, Ix4>,
        /// Force that each agent commands its arm, from this instant on, N.
        agent_force: Array<f64, Ix4>,
        /// Force of each arm on its handle, from this instant on, N.
        handle_force: Array<f64, Ix4>,
        /// Where each agent takes the target to be, m.
        aim: Array<f64, Ix4>,
        /// Energy in the account of each side's strategy, J, (trials, n, 2 robots); NaN if it keeps none, or unconnected.
        account: Array<f64, Ix3>,
        /// Age of the partner's motion that each side uses, as played, s, (trials, n, 2 robots); NaN while there is none.
        age: Array<f64, Ix3>,
        /// Share of the instants with a partner at which the strategy changed the force of the spring, (trials, 2 robots); this and
        /// the following are NaN where nothing can be said, as in the unconnected mode.
        limited_share: Array<f64, Ix2>,
        /// Mean share of the spring's force that was withheld at those instants; above 1 where the strategy pushed the
        /// other way, below 0 where a damper made the force larger.
        withheld_share: Array<f64, Ix2>,
        /// Energy that each side gave out to its own handle, as it measured it, J.
        given_out: Array<f64, Ix2>,
        /// Energy that each side's strategy sent to its partner, J.
        energy_sent: Array<f64, Ix2>,
        /// Mean age of the partner's motion in use, s.
        age_mean: Array<f64, Ix2>,
        /// Smallest age of a partner's sample in use, s.
        age_low: Array<f64, Ix2>,
        /// Largest age of a partner's sample in use, s.
        age_high: Array<f64, Ix2>,
        /// Share of the instants at which an old motion was held because no later one had come.
        held_share: Array<f64, Ix2>,
        /// Packets that had not come although later ones had.
        lost: Array<f64, Ix2>,
        /// Energy that the coupling took at both handles, less what it gave out there, J, (trials,); negative if it gave more.
        coupling_energy: Array<f64, Ix1>,
        /// The smallest value of this energy during the trial, J.
        coupling_energy_minimum: Array<f64, Ix1>,
        /// Energy that each hand got, J, (trials, 2 robots), also in the unconnected mode; negative if it gave more than it got.
        hand_energy: Array<f64, Ix2>,
        /// How each trial ended, as in `Recording`.
        status: Vec<String>,
        /// Time of the first tick that is left out, s, (trials,); NaN if a trial was completed.
        ended_at: Array<f64, Ix1>,
    }
}

record! {
    /// The motion of one handle in an arm under given forces. `simulate_handle` returns it.
    ///
    /// Row j is at j sample periods; the arrays end where the motion ended.
    HandleMotion {
        /// Position, m, (n, 2).
        position: Array<f64, Ix2>,
        /// Velocity, m/s, (n, 2).
        velocity: Array<f64, Ix2>,
        /// Force of the arm on the handle, N, (n, 2).
        handle_force: Array<f64, Ix2>,
        /// Torques of the joints, N·m; None for an arm without joints.
        torque: Option<Array<f64, Ix2>>,
        /// "completed", "out of reach" or "too stiff", as in `Recording`.
        status: String,
        /// Time of the last row, s, where the motion ended early; None if it was completed.
        ended_at: Option<f64>,
    }
}
