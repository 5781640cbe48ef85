//! What a trial of the laboratory tells, as numbers for Python.

use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use telespring::rig::{Schedule, Status, TrialOutcome};
use telespring::session::playout::Ages;
use telespring::session::{SessionReport, Span};

/// The recorded instants of a laboratory's trial as an array, s.
pub fn times<'py>(
    py: Python<'py>,
    schedule: &Schedule,
    rows: usize,
    sample_period: f64,
) -> Bound<'py, PyArray1<f64>> {
    (0..rows).map(|row| schedule.time(row, sample_period)).collect::<Vec<_>>().into_pyarray(py)
}

/// What both sides tell of a laboratory's trial, per robot, in the order of the attributes of `Recording`; NaN where
/// nothing can be said.
pub fn told_by_sides(outcome: &TrialOutcome) -> [[f64; 2]; 9] {
    let Some(sessions) = &outcome.sessions else { return [[f64::NAN; 2]; 9] };
    let of = |value: fn(&SessionReport) -> f64| sessions.each_ref().map(value);
    let age = |of: fn(&Ages) -> Span| {
        sessions.each_ref().map(|side| side.playout.ages.as_ref().map_or(f64::NAN, |ages| of(ages).seconds()))
    };
    [
        of(|side| side.strategy.limited_ticks as f64 / side.strategy.ticks as f64),
        of(|side| if side.strategy.ticks == 0 { f64::NAN } else { side.strategy.withheld }),
        of(|side| side.strategy.given_out),
        of(|side| side.strategy.energy_sent),
        age(|ages| ages.mean),
        age(|ages| ages.smallest),
        age(|ages| ages.largest),
        of(|side| side.playout.held_ticks as f64 / side.playout.ticks as f64),
        of(|side| side.playout.lost as f64),
    ]
}

/// The status of a laboratory's trial by its name, and the time (s) of an early end.
pub fn ended(outcome: &TrialOutcome) -> (&'static str, Option<f64>) {
    match outcome.status {
        Status::Diverged { at } => ("diverged", Some(at)),
        Status::OutOfReach { at } => ("out of reach", Some(at)),
        Status::TooStiff { at } => ("too stiff", Some(at)),
        _ => ("completed", None),
    }
}
