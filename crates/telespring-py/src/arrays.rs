//! One computation over many axes at once: numbers and arrays in, broadcast against each other as numpy does.

use std::borrow::Cow;

use numpy::ndarray::IxDyn;
use numpy::{
    Element, IntoPyArray, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyFloat, PyInt, PyList, PyTuple};
use rayon::prelude::*;
use telespring::{InvalidInput, Result};

use crate::errors::Outcome;
use crate::interrupt::{Watch, in_parallel};

/// Whether an argument is an array whose dimensions have names.
fn is_labelled(value: &Bound<'_, PyAny>) -> PyResult<bool> {
    if value.is_instance_of::<PyList>()
        || value.is_instance_of::<PyTuple>()
        || value.cast::<PyUntypedArray>().is_ok()
    {
        return Ok(false);
    }
    labelling(value.py(), "is_labelled")?.call1((value,))?.extract()
}

/// A function for arrays whose dimensions have names.
fn labelling<'py>(py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("telespring._labelled")?.getattr(name)
}

/// A map over stiffness and delay, labelled if one of them is.
pub fn labelled_map<'py>(
    map: Bound<'py, PyAny>,
    k: &Numbers<'py>,
    delay: &Numbers<'py>,
) -> PyResult<Bound<'py, PyAny>> {
    if k.labelled.is_none() && delay.labelled.is_none() {
        return Ok(map);
    }
    let py = map.py();
    labelling(py, "label_map")?.call1((map, k.to_python(py)?, delay.to_python(py)?))
}

/// A number or an array of numbers, as the caller named it.
pub struct Numbers<'py> {
    name: &'static str,
    values: Values<'py>,
    /// The argument itself, if its dimensions have names.
    labelled: Option<Bound<'py, PyAny>>,
}

enum Values<'py> {
    One(f64),
    Many(PyReadonlyArrayDyn<'py, f64>),
}

/// Any array_like as an array of doubles, refused by its name.
pub fn as_numbers<'py>(name: &str, value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    static AS_NUMBERS: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    AS_NUMBERS.import(value.py(), "telespring._arrays", "as_numbers")?.call1((name, value))
}

impl<'py> Numbers<'py> {
    /// One number of an argument that may be an array.
    pub fn one(name: &'static str, value: f64) -> Self {
        Self { name, values: Values::One(value), labelled: None }
    }

    /// Any array_like; a number is read without numpy.
    pub fn read(name: &'static str, value: &Bound<'py, PyAny>) -> Outcome<Self> {
        if let Ok(number) = value.cast::<PyFloat>() {
            return Ok(Self::one(name, number.value()));
        }
        if value.is_exact_instance_of::<PyInt>()
            && let Ok(number) = value.extract::<f64>()
        {
            return Ok(Self::one(name, number));
        }
        let array: PyReadonlyArrayDyn<'py, f64> = as_numbers(name, value)?.extract()?;
        Ok(match array.ndim() {
            0 => Self::one(name, array.as_array()[IxDyn(&[])]),
            _ => Self {
                name,
                values: Values::Many(array),
                labelled: is_labelled(value)?.then(|| value.clone()),
            },
        })
    }

    /// The argument as Python passed it, or what replaces it.
    fn to_python(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        match (&self.labelled, &self.values) {
            (Some(labelled), _) => Ok(labelled.clone()),
            (None, Values::One(value)) => value.into_bound_py_any(py),
            (None, Values::Many(array)) => Ok(array.as_any().clone()),
        }
    }

    /// A single number, where an array has no meaning.
    pub fn single(&self) -> Result<f64> {
        match &self.values {
            Values::One(value) => Ok(*value),
            Values::Many(array) if array.len() == 1 => {
                Ok(array.as_array().iter().next().copied().unwrap_or(0.0))
            }
            Values::Many(array) => Err(InvalidInput::new(
                self.name,
                format!("an array of shape {}", tuple(array.shape())),
                "one number is required here",
                "Call the function once for each element.",
            )),
        }
    }

    /// A row of numbers, where arrays of more dimensions have no meaning; one number is a row of one.
    pub fn row(&self) -> Result<Vec<f64>> {
        match &self.values {
            Values::One(value) => Ok(vec![*value]),
            Values::Many(array) if array.ndim() == 1 => Ok(array.as_array().iter().copied().collect()),
            Values::Many(array) => Err(InvalidInput::new(
                self.name,
                format!("an array of shape {}", tuple(array.shape())),
                "one number or a one-dimensional array is required here",
                "Flatten it with numpy.ravel.",
            )),
        }
    }

    /// The shape of the array; empty for a number.
    fn shape(&self) -> &[usize] {
        match &self.values {
            Values::One(_) => &[],
            Values::Many(array) => array.shape(),
        }
    }
}

/// The shape of an array as Python writes it.
fn tuple(shape: &[usize]) -> String {
    match shape {
        [one] => format!("({one},)"),
        _ => format!("({})", shape.iter().map(usize::to_string).collect::<Vec<_>>().join(", ")),
    }
}

/// The shape that all arrays broadcast to.
fn common_shape(arguments: &[Numbers<'_>]) -> Result<Vec<usize>> {
    let dimensions = arguments.iter().map(|argument| argument.shape().len()).max().unwrap_or(0);
    let mut shape = vec![1; dimensions];
    for argument in arguments {
        let own = argument.shape();
        for (length, &mine) in shape[dimensions - own.len()..].iter_mut().zip(own) {
            if *length == 1 {
                *length = mine;
            } else if mine != 1 && mine != *length {
                let arrays = || arguments.iter().filter(|argument| !argument.shape().is_empty());
                let named = |argument: &Numbers<'_>| format!("{} {}", argument.name, tuple(argument.shape()));
                return Err(InvalidInput::new(
                    arrays().map(|argument| argument.name).collect::<Vec<_>>().join(", "),
                    arrays().map(named).collect::<Vec<_>>().join(", "),
                    "shapes must broadcast against each other",
                    "Give them the same shape, or add axes of length one.",
                ));
            }
        }
    }
    Ok(shape)
}

/// The field of the element that was refused, in the array as the caller passed it.
fn element(arguments: &[Numbers<'_>], field: &str, shape: &[usize], index: usize) -> Option<String> {
    let own = arguments.iter().find(|argument| argument.name == field)?.shape();
    if own.is_empty() {
        return None;
    }
    let mut rest = index;
    let mut place: Vec<usize> = shape
        .iter()
        .rev()
        .map(|&length| {
            let at = rest % length;
            rest /= length;
            at
        })
        .collect();
    place.reverse();
    let own_place = place[shape.len() - own.len()..].iter().zip(own);
    let text: Vec<_> = own_place.map(|(&at, &length)| if length == 1 { 0 } else { at }.to_string()).collect();
    Some(format!("{field}[{}]", text.join(", ")))
}

/// Below this many elements the threads cost more than they save (a criterion takes about 0.1 µs).
const PARALLEL_FROM: usize = 4096;
/// Elements that one thread takes at a time.
const CHUNK: usize = 1024;
/// The most arguments of one computation: seven numbers of an axis and two more.
const MOST: usize = 9;

/// The same where dimensions have names, by which they are broadcast; so has the result.
fn over_labelled<'py, T: Element + Copy + Default + IntoPyObject<'py>>(
    py: Python<'py>,
    arguments: &[Numbers<'py>],
    compute: impl Fn(&[f64]) -> Result<T> + Sync,
) -> Outcome<Bound<'py, PyAny>> {
    let names: Vec<_> = arguments.iter().map(|argument| argument.name).collect();
    let values = arguments.iter().map(|argument| argument.to_python(py)).collect::<PyResult<Vec<_>>>()?;
    let broadcast = labelling(py, "broadcast")?.call1((names.clone(), values.clone()))?;
    let (arrays, like): (Vec<Bound<'py, PyAny>>, Bound<'py, PyAny>) = broadcast.extract()?;
    let plain = names.into_iter().zip(&arrays).map(|(name, array)| Numbers::read(name, array));
    let result = over_arrays(
        py,
        &plain.collect::<Outcome<Vec<_>>>()?,
        &compute as &(dyn Fn(&[f64]) -> Result<T> + Sync),
    )?;
    let arguments: Vec<_> = [result, like].into_iter().chain(values).collect();
    Ok(labelling(py, "label")?.call1(PyTuple::new(py, arguments)?)?)
}

/// Computes each element from the arguments broadcast against each other, without holding the interpreter:
/// a number if all are numbers, else an array.
///
/// The refusal of the first element is reported, whatever the number of threads.
pub fn over_arrays<'py, T: Element + Copy + Default + IntoPyObject<'py>>(
    py: Python<'py>,
    arguments: &[Numbers<'py>],
    compute: impl Fn(&[f64]) -> Result<T> + Sync,
) -> Outcome<Bound<'py, PyAny>> {
    if arguments.iter().any(|argument| argument.labelled.is_some()) {
        return over_labelled(py, arguments, compute);
    }
    let mut row = [0.0; MOST];
    let mut all_numbers = true;
    for (value, argument) in row.iter_mut().zip(arguments) {
        match argument.values {
            Values::One(number) => *value = number,
            Values::Many(_) => all_numbers = false,
        }
    }
    if all_numbers {
        let row = &row[..arguments.len()];
        let value = py.detach(|| compute(row))?;
        return Ok(value.into_bound_py_any(py)?);
    }
    let shape = common_shape(arguments)?;
    let length = shape.iter().product();
    // columns of length one stay that way: a map over two parameters holds two large arrays, not nine
    let columns: Vec<Cow<'_, [f64]>> = arguments
        .iter()
        .map(|argument| match &argument.values {
            Values::One(value) => Cow::Owned(vec![*value]),
            Values::Many(array) => match array.as_array().to_slice() {
                Some(slice) if slice.len() == 1 || array.shape() == shape => Cow::Borrowed(slice),
                _ => {
                    let view = array.as_array();
                    let whole = view.broadcast(IxDyn(&shape)).expect("it broadcasts to the common shape");
                    Cow::Owned(whole.iter().copied().collect())
                }
            },
        })
        .collect();
    let columns: Vec<&[f64]> = columns.iter().map(Cow::as_ref).collect();
    let row_at = |row: &mut [f64], index: usize| {
        for (number, column) in row.iter_mut().zip(&columns) {
            *number = if column.len() == 1 { column[0] } else { column[index] };
        }
    };
    let mut values = vec![T::default(); length];
    let refused = if length < PARALLEL_FROM {
        py.detach(|| -> PyResult<_> {
            let mut watch = Watch::start();
            let mut row = [0.0; MOST];
            let row = &mut row[..columns.len()];
            for (index, value) in values.iter_mut().enumerate() {
                watch.look()?;
                row_at(row, index);
                match compute(row) {
                    Ok(computed) => *value = computed,
                    Err(refusal) => return Ok(Some((index, refusal))),
                }
            }
            Ok(None)
        })?
    } else {
        in_parallel(py, |stop| {
            let fill = |(chunk, values): (usize, &mut [T])| -> Option<(usize, InvalidInput)> {
                let mut row = [0.0; MOST];
                let row = &mut row[..columns.len()];
                for (offset, value) in values.iter_mut().enumerate() {
                    if stop.is_set() {
                        return None;
                    }
                    let index = chunk * CHUNK + offset;
                    row_at(row, index);
                    match compute(row) {
                        Ok(computed) => *value = computed,
                        Err(refusal) => return Some((index, refusal)),
                    }
                }
                None
            };
            values.par_chunks_mut(CHUNK).enumerate().filter_map(fill).min_by_key(|(index, _)| *index)
        })?
    };
    match refused {
        None => Ok(values.into_pyarray(py).reshape(IxDyn(&shape))?.into_any()),
        Some((index, mut refusal)) => {
            if let Some(field) = element(arguments, &refusal.field, &shape, index) {
                refusal.field = field;
            }
            Err(refusal.into())
        }
    }
}
