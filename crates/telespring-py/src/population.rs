//! Counts of a population of dyads as Python reads them.

use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use rayon::prelude::*;
use telespring::InvalidInput;
use telespring::population::{BINS, LogRange, Population, Tally};

use crate::errors::Outcome;
use crate::interrupt::in_parallel;

/// A range as Python gives it.
type Pair = (f64, f64);
/// Per cell: dyads, unsafe ones, the largest ratio, and the histogram of the ratios.
type Counts<'py> = (
    Bound<'py, PyArray1<u64>>,
    Bound<'py, PyArray1<u64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray2<u64>>,
);

/// Draws dyads `first` to `first + count` of every cell of a population, and counts what the paper's critical
/// stiffness is worth.
#[pyfunction]
#[pyo3(signature = (*, mass, damping, mass_ratio, damping_ratio, cells, operator_mass, operator_damping, seed, first, count))]
#[expect(clippy::too_many_arguments, reason = "all are keywords in Python")]
pub fn tally_population<'py>(
    py: Python<'py>,
    mass: Pair,
    damping: Pair,
    mass_ratio: Pair,
    damping_ratio: Pair,
    cells: (usize, usize),
    operator_mass: f64,
    operator_damping: f64,
    seed: u64,
    first: u64,
    count: u64,
) -> Outcome<Counts<'py>> {
    let range = |(low, high): Pair| LogRange { low, high };
    let population = Population {
        mass: range(mass),
        damping: range(damping),
        mass_ratio: range(mass_ratio),
        damping_ratio: range(damping_ratio),
        cells: [cells.0, cells.1],
        operator_mass,
        operator_damping,
        seed,
    }
    .checked()?;
    let tallies = in_parallel(py, |stop| {
        (0..cells.0 * cells.1)
            .into_par_iter()
            // nobody reads them after a signal
            .map(|cell| if stop.is_set() { Ok(Tally::empty()) } else { population.tally(cell, first, count) })
            .collect::<Result<Vec<Tally>, InvalidInput>>()
    })??;
    let dyads: Vec<u64> = tallies.iter().map(|tally| tally.dyads).collect();
    let unsafe_dyads: Vec<u64> = tallies.iter().map(|tally| tally.unsafe_dyads).collect();
    let largest: Vec<f64> = tallies.iter().map(|tally| tally.largest).collect();
    let histogram: Vec<u64> = tallies.into_iter().flat_map(|tally| tally.histogram).collect();
    let shape = [dyads.len(), BINS];
    Ok((
        dyads.into_pyarray(py),
        unsafe_dyads.into_pyarray(py),
        largest.into_pyarray(py),
        histogram.into_pyarray(py).reshape(shape)?,
    ))
}
