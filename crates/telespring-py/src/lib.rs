//! Python binding of `telespring`: newtypes and conversions only.
//!
//! Everything public is documented, broadcast and typed in `python/telespring`; what stands here
//! takes flat contiguous arrays and lets go of the interpreter while it computes.

mod arguments;
mod arrays;
mod criteria;
mod dde;
mod delay_system;
mod errors;
mod experiment;
mod model;
mod participants;
mod plant;
mod poses;
mod recording;
mod response;
mod rig;
mod simulation;
mod spectrum;
mod study;
mod study_values;
mod verdicts;

use pyo3::prelude::*;

/// The compiled core of `telespring`; use the functions of `telespring` itself.
#[pymodule]
mod _core {
    /// Version of the core.
    #[pymodule_export]
    #[expect(non_upper_case_globals, reason = "Python's name for it")]
    const __version__: &str = env!("CARGO_PKG_VERSION");
    #[pymodule_export]
    use crate::criteria::{
        critical_stiffness, crossings, decay_stiffness, maximum_delay, maximum_stiffness, minimum_damping,
        stability_map, stable_delays, unstable_root_count,
    };
    #[pymodule_export]
    use crate::dde::{DdeSolution, solve_dde};
    #[pymodule_export]
    use crate::delay_system::DelaySystem;
    #[pymodule_export]
    use crate::experiment::{Condition, Experiment, LaboratorySettings};
    #[pymodule_export]
    use crate::model::{Dyad, Operator, Robot, hman};
    #[pymodule_export]
    use crate::participants::{Agent, Arm, Task};
    #[pymodule_export]
    use crate::plant::{arm_operator, simulate_handle};
    #[pymodule_export]
    use crate::poses::{cross_inertia, pose_stability, pose_system};
    #[pymodule_export]
    use crate::recording::{HandleMotion, Recording, Recordings};
    #[pymodule_export]
    use crate::response::{
        frequency_grid, frequency_response, mobility_matrix, nyquist, open_loop, partner_response,
        transfer_matrix,
    };
    #[pymodule_export]
    use crate::rig::{Laboratory, trial_seed};
    #[pymodule_export]
    use crate::simulation::simulate;
    #[pymodule_export]
    use crate::spectrum::{characteristic_roots, spectral_abscissa};
    #[pymodule_export]
    use crate::study::{Coupling, Network, OperatorRange, RobotRecord, Study, Uncertainty, robot_record};
    #[pymodule_export]
    use crate::verdicts::verdicts;
}
