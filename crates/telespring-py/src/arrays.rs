//! One computation over many axes at once: flat columns in, one flat array out.

use numpy::{Element, IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use rayon::prelude::*;
use telespring::{DyadAxis, InvalidInput, Result};

use crate::errors::{Failure, Outcome};

/// A flat array of numbers, as long as all others or of length one.
pub type Column<'py> = PyReadonlyArray1<'py, f64>;

/// m1, b1, m2, b2, kh1, kh2, c: what describes an axis, a column each.
pub type Axes<'py> =
    (Column<'py>, Column<'py>, Column<'py>, Column<'py>, Column<'py>, Column<'py>, Column<'py>);

/// Below this many elements the threads cost more than they save (a criterion takes about 0.1 µs).
const PARALLEL_FROM: usize = 4096;
/// Elements that one thread takes at a time.
const CHUNK: usize = 1024;

/// A column of length one stands for every element.
fn at(column: &[f64], index: usize) -> f64 {
    if column.len() == 1 { column[0] } else { column[index] }
}

fn slices<'a, const N: usize>(names: [&str; N], columns: [&'a Column<'_>; N]) -> Outcome<[&'a [f64]; N]> {
    let mut out = [[].as_slice(); N];
    for ((slot, column), name) in out.iter_mut().zip(columns).zip(names) {
        *slot = column.as_slice().map_err(|_| {
            InvalidInput::new(
                name,
                "a strided array",
                "columns are contiguous",
                "Use numpy.ascontiguousarray on it first.",
            )
        })?;
    }
    Ok(out)
}

fn common_length(columns: &[&[f64]]) -> Outcome<usize> {
    let length = columns.iter().map(|column| column.len()).find(|&n| n != 1).unwrap_or(1);
    if columns.iter().all(|column| column.len() == 1 || column.len() == length) {
        return Ok(length);
    }
    Err(InvalidInput::new(
        "arrays",
        format!("lengths {:?}", columns.iter().map(|column| column.len()).collect::<Vec<_>>()),
        "all columns have the same length, or length one",
        "Broadcast the arrays against each other first.",
    )
    .into())
}

/// Applies `compute` to every axis and the `extra` values beside it, without holding the interpreter.
///
/// The refusal of lowest index is reported, whatever the number of threads.
pub fn map_axes<'py, T: Element + Copy + Default, const N: usize>(
    py: Python<'py>,
    axes: &Axes<'py>,
    extra: [&Column<'py>; N],
    compute: impl Fn(&DyadAxis, [f64; N]) -> Result<T> + Sync,
) -> Outcome<Bound<'py, PyArray1<T>>> {
    let (m1, b1, m2, b2, kh1, kh2, c) = axes;
    let axis_columns = slices(["m1", "b1", "m2", "b2", "kh1", "kh2", "c"], [m1, b1, m2, b2, kh1, kh2, c])?;
    let extra_columns = slices(["extra"; N], extra)?;
    let length = common_length(&[axis_columns.as_slice(), extra_columns.as_slice()].concat())?;

    let one = |index: usize| -> Result<T> {
        let [m1, b1, m2, b2, kh1, kh2, c] = axis_columns.map(|column| at(column, index));
        let axis = DyadAxis::with_operators(m1, b1, m2, b2, kh1, kh2, c)?;
        compute(&axis, extra_columns.map(|column| at(column, index)))
    };
    let fill = |(chunk, values): (usize, &mut [T])| -> std::result::Result<(), (usize, InvalidInput)> {
        for (offset, value) in values.iter_mut().enumerate() {
            let index = chunk * CHUNK + offset;
            *value = one(index).map_err(|refusal| (index, refusal))?;
        }
        Ok(())
    };

    let (values, refused) = py.detach(|| {
        let mut values = vec![T::default(); length];
        let refused = if length < PARALLEL_FROM {
            values.chunks_mut(CHUNK).enumerate().map(fill).find_map(std::result::Result::err)
        } else {
            values
                .par_chunks_mut(CHUNK)
                .enumerate()
                .map(fill)
                .filter_map(std::result::Result::err)
                .min_by_key(|(index, _)| *index)
        };
        (values, refused)
    });
    match refused {
        None => Ok(values.into_pyarray(py)),
        Some((index, refusal)) => Err(Failure::Refused { refusal, index: Some(index) }),
    }
}
