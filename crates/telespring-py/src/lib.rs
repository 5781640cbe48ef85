//! Python binding of `telespring`: newtypes and conversions only.
//!
//! Everything public is documented, broadcast and typed in `python/telespring`; what is here
//! takes flat contiguous arrays and releases the interpreter while it computes.

mod adversary;
mod agent_function;
mod architecture;
mod arguments;
mod arrays;
mod axis;
mod coupling;
mod criteria;
mod dde;
mod decision;
mod delay_system;
mod errors;
mod experiment;
mod interrupt;
mod judged_network;
mod model;
mod network;
mod operator_range;
mod participants;
mod plant;
mod population;
mod poses;
mod prediction;
mod recording;
mod records;
mod replay;
mod response;
mod rig;
mod robot_file;
mod roots;
mod simulation;
mod spectrum;
mod study;
mod study_values;
mod subject;
mod trace;
mod trial_outcome;
mod usual;
mod verdicts;

use pyo3::prelude::*;

/// The compiled core of `telespring`; use the functions of `telespring` itself.
#[pymodule]
mod _core {
    use numpy::PyArrayMethods;
    use pyo3::prelude::*;

    /// Version of the core.
    #[pymodule_export]
    #[expect(non_upper_case_globals, reason = "Python's name for it")]
    const __version__: &str = env!("CARGO_PKG_VERSION");
    /// Each bin of `tally_population` ends at this many times the value at which it begins.
    #[pymodule_export]
    const POPULATION_BIN_RATIO: f64 = telespring::population::BIN_RATIO;
    /// Share of the stiffness, and of the delay, that a stable dyad keeps in reserve.
    #[pymodule_export]
    const RESERVE: f64 = telespring::decision::RESERVE;
    /// A dyad whose robots have errors is marginal if it is stable with a smaller probability.
    #[pymodule_export]
    const LEAST_PROBABILITY: f64 = telespring::decision::LEAST_PROBABILITY;
    /// A factor that keeps rounding on the safe side of a limit.
    #[pymodule_export]
    const WITHIN: f64 = telespring::decision::WITHIN;
    /// The smallest stiffness that is judged, N/m.
    #[pymodule_export]
    const SOFTEST: f64 = telespring::quantity::STIFFNESS.minimum();
    /// The largest stiffness that is judged, N/m.
    #[pymodule_export]
    const STIFFEST: f64 = telespring::quantity::STIFFNESS.maximum();
    /// The longest delay that is judged, one way, s.
    #[pymodule_export]
    const LONGEST_DELAY: f64 = telespring::quantity::DELAY.maximum();
    #[pymodule_export]
    use crate::adversary::Adversary;
    #[pymodule_export]
    use crate::architecture::{Architecture, ComparisonPlan, GuardOverdraft};
    #[pymodule_export]
    use crate::axis::{Crossing, DyadAxis};
    #[pymodule_export]
    use crate::coupling::Coupling;
    #[pymodule_export]
    use crate::criteria::{
        critical_stiffness, crossings, decay_stiffness, maximum_delay, maximum_stiffness, minimum_damping,
        stability_map, stable_delays, unstable_root_count,
    };
    #[pymodule_export]
    use crate::dde::{DelaySolution, solve_dde};
    #[pymodule_export]
    use crate::decision::{
        Decision, Knowledge, Question, VaryingDelay, constant_delay, is_axis_stable, is_instability_proven,
        is_stable, is_within, stiffness_limit, tier_stiffness_limit, worst_status,
    };
    #[pymodule_export]
    use crate::delay_system::DelaySystem;
    #[pymodule_export]
    use crate::experiment::{Condition, Experiment, HeldCoupling, LaboratorySettings};
    #[pymodule_export]
    use crate::judged_network::JudgedNetwork;
    #[pymodule_export]
    use crate::model::{Dyad, Operator, Robot, hman};
    #[pymodule_export]
    use crate::network::Network;
    #[pymodule_export]
    use crate::operator_range::OperatorRange;
    #[pymodule_export]
    use crate::participants::{Agent, Arm, Task};
    #[pymodule_export]
    use crate::plant::{arm_operator, simulate_handle};
    #[pymodule_export]
    use crate::population::tally_population;
    #[pymodule_export]
    use crate::poses::{cross_inertia, pose_stability, pose_system};
    #[pymodule_export]
    use crate::prediction::{NoiseFit, fit_noise, predict_motion};
    #[pymodule_export]
    use crate::recording::{HandleMotion, Recording, Recordings};
    #[pymodule_export]
    use crate::replay::{RecordedSite, ReplayedSite, replay_pair, replay_site};
    #[pymodule_export]
    use crate::response::{
        FrequencyGrid, FrequencyMargin, FrequencyResponse, Nyquist, ResponseCurve, frequency_grid,
        frequency_response, mobility_matrix, nyquist, open_loop, partner_response, transfer_matrix,
    };
    #[pymodule_export]
    use crate::rig::{Laboratory, trial_seed};
    #[pymodule_export]
    use crate::robot_file::{RobotRecord, Uncertainty, robot_record};
    #[pymodule_export]
    use crate::roots::{certified_roots, characteristic_roots, spectral_abscissa};
    #[pymodule_export]
    use crate::simulation::simulate;
    #[pymodule_export]
    use crate::spectrum::Spectrum;
    #[pymodule_export]
    use crate::study::Study;
    #[pymodule_export]
    use crate::trace::{BurstFit, JitterFit, PlayedTrace, Trace, TraceFit, TraceStatistics};
    #[pymodule_export]
    use crate::usual::{check_usual, usual_range};
    #[pymodule_export]
    use crate::verdicts::{
        AxisTier, AxisVerdict, DelayBudget, DelayLimit, OperatorPoint, PaperVerdict, Remedies,
        SampledSpectrum, StiffnessAllowed, StiffnessMargin, Verdict, Verdicts, delay_limit,
        is_stable_over_delays, is_stable_over_stiffnesses, verdicts,
    };

    /// Prepares the module.
    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        // An exception, as that of Ctrl-C, in the first use of an array would be a panic: load NumPy's interface now.
        module.py().import("numpy")?;
        drop(numpy::PyArray1::<f64>::zeros(module.py(), 0, false).readonly());
        // the documented functions belong to the package, where their examples are run
        for name in [
            "certified_roots",
            "characteristic_roots",
            "critical_stiffness",
            "crossings",
            "decay_stiffness",
            "fit_noise",
            "hman",
            "maximum_delay",
            "maximum_stiffness",
            "minimum_damping",
            "spectral_abscissa",
            "stability_map",
            "stable_delays",
            "unstable_root_count",
        ] {
            module.getattr(name)?.setattr("__module__", "telespring")?;
        }
        // classes that the package does not list: pickles must find them
        for name in [
            "Decision",
            "HandleMotion",
            "Knowledge",
            "Recording",
            "Recordings",
            "ReplayedSite",
            "RobotRecord",
            "VaryingDelay",
        ] {
            module.getattr(name)?.setattr("__module__", "telespring._core")?;
        }
        Ok(())
    }
}
