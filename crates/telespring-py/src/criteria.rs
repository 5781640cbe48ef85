//! The criteria over arrays of axes; each is one line over `map_axes`.

use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;
use rayon::prelude::*;
use telespring::criteria;
use telespring::quantity::{DELAY, STIFFNESS};
use telespring::{DyadAxis, Result};

use crate::arrays::{Axes, Column, map_axes};
use crate::errors::Outcome;

type FloatArray<'py> = Bound<'py, PyArray1<f64>>;

/// Smallest stiffness at which some constant delay destabilises, N/m; `paper` takes Eq. 5.
#[pyfunction]
pub fn critical_stiffness<'py>(py: Python<'py>, axes: Axes<'py>, paper: bool) -> Outcome<FloatArray<'py>> {
    if paper {
        map_axes(py, &axes, [], |axis, []| criteria::paper_critical_stiffness(axis))
    } else {
        map_axes(py, &axes, [], |axis, []| Ok(criteria::critical_stiffness(axis)))
    }
}

/// End of the first interval of stable delays, s; `paper` takes Eqs. 5 to 9.
#[pyfunction]
pub fn maximum_delay<'py>(
    py: Python<'py>,
    axes: Axes<'py>,
    k: Column<'py>,
    paper: bool,
) -> Outcome<FloatArray<'py>> {
    if paper {
        map_axes(py, &axes, [&k], |axis, [k]| criteria::paper_maximum_delay(axis, STIFFNESS.check("k", k)?))
    } else {
        map_axes(py, &axes, [&k], |axis, [k]| criteria::maximum_delay(axis, STIFFNESS.check("k", k)?))
    }
}

/// Stiffness below which every stiffness is stable at this delay, N/m.
#[pyfunction]
pub fn maximum_stiffness<'py>(
    py: Python<'py>,
    axes: Axes<'py>,
    delay: Column<'py>,
) -> Outcome<FloatArray<'py>> {
    map_axes(py, &axes, [&delay], |axis, [delay]| {
        criteria::maximum_stiffness(axis, DELAY.check("delay", delay)?)
    })
}

/// Damping added to both robots above which every larger damping is stable, N·s/m.
#[pyfunction]
pub fn minimum_damping<'py>(
    py: Python<'py>,
    axes: Axes<'py>,
    k: Column<'py>,
    delay: Column<'py>,
) -> Outcome<FloatArray<'py>> {
    map_axes(py, &axes, [&k, &delay], |axis, [k, delay]| {
        criteria::minimum_damping(axis, STIFFNESS.check("k", k)?, DELAY.check("delay", delay)?)
    })
}

/// Characteristic roots with positive real part, the rigid-body root not counted.
#[pyfunction]
pub fn unstable_root_count<'py>(
    py: Python<'py>,
    axes: Axes<'py>,
    k: Column<'py>,
    delay: Column<'py>,
) -> Outcome<Bound<'py, PyArray1<i64>>> {
    map_axes(py, &axes, [&k, &delay], |axis, [k, delay]| {
        criteria::unstable_root_count(axis, STIFFNESS.check("k", k)?, DELAY.check("delay", delay)?)
            .map(i64::from)
    })
}

/// Rows of stiffness that one thread takes at a time.
const ROWS: usize = 16;

/// Whether each pair of stiffness and delay is stable, a row per stiffness.
#[pyfunction]
pub fn stability_map<'py>(
    py: Python<'py>,
    axis: AxisValues,
    k: PyReadonlyArray1<'py, f64>,
    delay: PyReadonlyArray1<'py, f64>,
) -> Outcome<Bound<'py, PyArray2<bool>>> {
    let (k, delay) = (k.as_array().to_vec(), delay.as_array().to_vec());
    let shape = [k.len(), delay.len()];
    let stable = py.detach(|| -> Result<Vec<bool>> {
        let axis = axis.check()?;
        for (i, &value) in k.iter().enumerate() {
            STIFFNESS.check("k", value).map_err(|mut refusal| {
                refusal.field = format!("k[{i}]");
                refusal
            })?;
        }
        let rows: Vec<_> =
            k.par_chunks(ROWS).map(|k| criteria::stability_map(&axis, k, &delay)).collect::<Result<_>>()?;
        Ok(rows.concat())
    })?;
    Ok(stable.into_pyarray(py).reshape(shape)?)
}

/// One axis by value: m1, b1, m2, b2, kh1, kh2, c.
#[derive(FromPyObject)]
pub struct AxisValues(f64, f64, f64, f64, f64, f64, f64);

impl AxisValues {
    fn check(&self) -> Result<DyadAxis> {
        let Self(m1, b1, m2, b2, kh1, kh2, c) = *self;
        DyadAxis::with_operators(m1, b1, m2, b2, kh1, kh2, c)
    }
}

/// Every crossing as (delay, frequency, direction).
#[pyfunction]
pub fn crossings(py: Python<'_>, axis: AxisValues, k: f64) -> Outcome<Vec<(f64, f64, i8)>> {
    py.detach(|| {
        let found = criteria::crossings(&axis.check()?, STIFFNESS.check("k", k)?)?;
        Ok(found.iter().map(|crossing| (crossing.delay, crossing.frequency, crossing.direction)).collect())
    })
}

/// Stable one-way delays up to the horizon as half-open intervals, s.
#[pyfunction]
pub fn stable_delays(py: Python<'_>, axis: AxisValues, k: f64, horizon: f64) -> Outcome<Vec<(f64, f64)>> {
    py.detach(|| Ok(criteria::stable_delays(&axis.check()?, STIFFNESS.check("k", k)?, horizon)?))
}

/// Ranges of stiffness in which every root but s = 0 decays faster than `decay_rate`, N/m.
#[pyfunction]
pub fn decay_stiffness(
    py: Python<'_>,
    axis: AxisValues,
    delay: f64,
    decay_rate: f64,
) -> Outcome<Vec<(f64, f64)>> {
    py.detach(|| Ok(criteria::decay_stiffness(&axis.check()?, DELAY.check("delay", delay)?, decay_rate)?))
}
