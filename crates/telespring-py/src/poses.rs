//! A dyad in jointed arms, its poses judged in parallel.

use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use rayon::prelude::*;
use telespring::poses::{DyadInArms, FrozenSide};
use telespring::rig::Arm;

use crate::arguments::{Argument, DelayChoice, Number, rows};
use crate::delay_system::DelaySystem;
use crate::errors::{Failure, Outcome};
use crate::interrupt::in_parallel;
use crate::model::Dyad;
use crate::plant::arm_of;

type Arms<'py> = [Option<Bound<'py, PyAny>>; 2];

/// The dyad as held in its arms, for the poses.
fn held(dyad: Argument<Bound<'_, Dyad>>, arms: &Arms<'_>, agent_stiffness: [f64; 2]) -> Outcome<DyadInArms> {
    let arm = |robot: usize| match &arms[robot] {
        None => Ok(Arm::Lumped { mass: [0.0; 2], damping: [0.0; 2] }),
        Some(arm) => arm_of(arm).map_err(|failure| match failure {
            Failure::Refused(mut refusal) => {
                refusal.field = refusal.field.replacen("arm", &format!("arm{}", robot + 1), 1);
                Failure::Refused(refusal)
            }
            raised @ Failure::Python(_) => raised,
        }),
    };
    Ok(DyadInArms::new(&dyad.named("dyad")?.get().0, [arm(0)?, arm(1)?], agent_stiffness)?)
}

/// Both sides of the dyad in every pose.
fn sides(held: &DyadInArms, positions: &[[f64; 2]]) -> telespring::Result<Vec<[FrozenSide; 2]>> {
    positions
        .iter()
        .enumerate()
        .map(|(index, position)| {
            held.sides_at(*position).map_err(|mut refusal| {
                refusal.field = format!("positions[{index}]");
                refusal
            })
        })
        .collect()
}

/// Whether two poses' abscissae are complete, with them.
type Stability<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>, bool);

/// Spectral abscissa of every pose, the same with x and y independent, and whether no root was missed.
#[pyfunction]
pub fn pose_stability<'py>(
    py: Python<'py>,
    dyad: Argument<Bound<'py, Dyad>>,
    arms: Arms<'py>,
    stiffness: Number,
    delay: DelayChoice,
    positions: &Bound<'py, PyAny>,
    agent_stiffness: Argument<[f64; 2]>,
) -> Outcome<Stability<'py>> {
    let (stiffness, delay) = (stiffness.named("stiffness")?, delay.check()?);
    let (held, positions) =
        (held(dyad, &arms, agent_stiffness.named("agent_stiffness")?)?, rows("positions", positions)?);
    let poses = in_parallel(py, |stop| {
        sides(&held, &positions)?
            .par_iter()
            .take_any_while(|_| !stop.is_set())
            .map(|sides| held.stability(sides, stiffness, &delay))
            .collect::<telespring::Result<Vec<_>>>()
    })??;
    let complete = poses.iter().all(|pose| pose.is_complete);
    let values = |value: fn(&telespring::poses::PoseStability) -> f64| {
        poses.iter().map(value).collect::<Vec<_>>().into_pyarray(py)
    };
    Ok((values(|pose| pose.spectral_abscissa), values(|pose| pose.uncoupled_abscissa), complete))
}

/// Cross-axis inertia of every pose and robot, arm included.
#[pyfunction]
pub fn cross_inertia<'py>(
    py: Python<'py>,
    dyad: Argument<Bound<'py, Dyad>>,
    arms: Arms<'py>,
    positions: &Bound<'py, PyAny>,
) -> Outcome<Bound<'py, PyArray2<f64>>> {
    let (held, positions) = (held(dyad, &arms, [0.0; 2])?, rows("positions", positions)?);
    let values: Vec<f64> =
        sides(&held, &positions)?.iter().flatten().map(FrozenSide::cross_inertia).collect();
    Ok(values.into_pyarray(py).reshape([positions.len(), 2])?)
}

/// One frozen pose as a linear system with delays.
#[pyfunction]
pub fn pose_system(
    dyad: Argument<Bound<'_, Dyad>>,
    arms: Arms<'_>,
    stiffness: Number,
    delay: DelayChoice,
    position: [f64; 2],
    agent_stiffness: Argument<[f64; 2]>,
) -> Outcome<DelaySystem> {
    let (stiffness, delay) = (stiffness.named("stiffness")?, delay.check()?);
    let held = held(dyad, &arms, agent_stiffness.named("agent_stiffness")?)?;
    let [sides] = sides(&held, &[position])?.try_into().expect("one pose for one position");
    Ok(DelaySystem(held.system(&sides, stiffness, &delay)?))
}
