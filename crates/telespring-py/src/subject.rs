//! What a criterion is asked about: a dyad, one of its axes, or numbers and arrays in their place.

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString, PyTuple};
use telespring::{InvalidInput, Result};

use crate::arguments::{Argument, written};
use crate::arrays::{Numbers, over_arrays};
use crate::axis::{DyadAxis, is_paper};
use crate::errors::Outcome;
use crate::model::Dyad;

/// What a criterion is computed for.
#[expect(clippy::large_enum_variant, reason = "one lives for one call")]
pub enum Subject<'py> {
    /// m1, b1, m2, b2, kh1, kh2, c: numbers or arrays.
    Numbers([Numbers<'py>; 7]),
    /// One axis.
    Axis(telespring::DyadAxis),
    /// All axes of a dyad.
    Dyad(Vec<telespring::DyadAxis>),
}

const NUMBERS: [&str; 7] = ["m1", "b1", "m2", "b2", "kh1", "kh2", "c"];

impl<'py> Subject<'py> {
    /// The dyad or axis that a documented criterion was called with, if it is one.
    fn read(value: &Bound<'py, PyAny>) -> Option<Self> {
        if let Ok(dyad) = value.cast::<Dyad>() {
            return Some(Self::Dyad(dyad.get().0.axes().collect()));
        }
        value.cast::<DyadAxis>().ok().map(|axis| Self::Axis(axis.get().axis))
    }

    /// Each axis that a criterion is called with by itself, where arrays have no meaning.
    pub fn axes(&self) -> Result<Vec<telespring::DyadAxis>> {
        match self {
            Self::Numbers([m1, b1, m2, b2, kh1, kh2, c]) => {
                let [m1, b1, m2, b2] = [m1.single()?, b1.single()?, m2.single()?, b2.single()?];
                let [kh1, kh2, c] = [kh1.single()?, kh2.single()?, c.single()?];
                Ok(vec![telespring::DyadAxis::with_operators(m1, b1, m2, b2, kh1, kh2, c)?])
            }
            Self::Axis(axis) => Ok(vec![*axis]),
            Self::Dyad(axes) => Ok(axes.clone()),
        }
    }

    /// A criterion as one number per element, and of a dyad's axes the `worst` of two.
    pub fn evaluate<T: numpy::Element + Copy + Default + IntoPyObject<'py>, const N: usize>(
        self,
        py: Python<'py>,
        others: [Numbers<'py>; N],
        worst: impl Fn(T, T) -> T + Sync,
        compute: impl Fn(&telespring::DyadAxis, [f64; N]) -> Result<T> + Sync,
    ) -> Outcome<Bound<'py, PyAny>> {
        let tail = |row: &[f64]| {
            let mut out = [0.0; N];
            out.copy_from_slice(&row[row.len() - N..]);
            out
        };
        match self {
            Self::Numbers(numbers) => {
                let arguments: Vec<_> = numbers.into_iter().chain(others).collect();
                over_arrays(py, &arguments, |row| {
                    let [m1, b1, m2, b2, kh1, kh2, c] =
                        [row[0], row[1], row[2], row[3], row[4], row[5], row[6]];
                    let axis = telespring::DyadAxis::with_operators(m1, b1, m2, b2, kh1, kh2, c)?;
                    compute(&axis, tail(row))
                })
            }
            Self::Axis(axis) => over_arrays(py, &others, |row| compute(&axis, tail(row))),
            Self::Dyad(axes) => over_arrays(py, &others, |row| {
                let (first, rest) = axes.split_first().expect("a dyad has at least one axis");
                rest.iter().try_fold(compute(first, tail(row))?, |so_far, axis| {
                    Ok(worst(so_far, compute(axis, tail(row))?))
                })
            }),
        }
    }
}

/// The arguments of a criterion in which a dyad or an axis may replace the seven numbers.
///
/// `names` are the arguments after m1, b1, m2, b2; those that are optional come last.
pub fn bind<'py, const N: usize>(
    function: &str,
    args: &Bound<'py, PyTuple>,
    kwargs: Option<&Bound<'py, PyDict>>,
    names: [&'static str; N],
    required: usize,
) -> Outcome<(Subject<'py>, [Option<Bound<'py, PyAny>>; N])> {
    let first = match (args.get_item(0), kwargs) {
        (Ok(first), _) => Some(first),
        (Err(_), Some(kwargs)) => kwargs.get_item("m1")?,
        (Err(_), None) => None,
    };
    let subject = first.as_ref().and_then(Subject::read);
    let mixed = |name: &str, value: &Bound<'py, PyAny>| {
        InvalidInput::new(
            name,
            written(value),
            format!("a dyad or an axis replaces all of {}", NUMBERS.join(", ")),
            format!("Write {function}({}).", [&["dyad"], &names[..required]].concat().join(", ")),
        )
    };
    let mut numbers: [Option<Bound<'py, PyAny>>; 7] = [const { None }; 7];
    let mut others: [Option<Bound<'py, PyAny>>; N] = [const { None }; N];
    for (place, value) in args.iter().enumerate() {
        let place = if subject.is_some() { place + 3 } else { place };
        match place {
            3 if subject.is_some() => {}
            0..4 => numbers[place] = Some(value),
            _ if place - 4 < N => others[place - 4] = Some(value),
            _ if subject.is_some() => return Err(mixed("arguments", args.as_any()).into()),
            _ => {
                let text = format!("{function}() takes at most {} positional arguments", 4 + N);
                return Err(PyTypeError::new_err(text).into());
            }
        }
    }
    for (name, value) in kwargs.into_iter().flatten() {
        let name = name.cast::<PyString>().map_err(PyErr::from)?.to_str()?.to_owned();
        let number = NUMBERS.iter().position(|known| *known == name);
        if subject.is_some() && number.is_some() && !(name == "m1" && args.is_empty()) {
            return Err(mixed(&name, &value).into());
        }
        let slot = match (number, names.iter().position(|known| *known == name)) {
            (Some(place), _) => &mut numbers[place],
            (None, Some(place)) => &mut others[place],
            (None, None) => {
                let text = format!("{function}() got an unexpected keyword argument '{name}'");
                return Err(PyTypeError::new_err(text).into());
            }
        };
        if slot.replace(value).is_some() {
            let text = format!("{function}() got multiple values for argument '{name}'");
            return Err(PyTypeError::new_err(text).into());
        }
    }
    let missing: Vec<&str> = NUMBERS[..4]
        .iter()
        .zip(&numbers)
        .filter(|(_, number)| subject.is_none() && number.is_none())
        .chain(names[..required].iter().zip(&others).filter(|(_, other)| other.is_none()))
        .map(|(name, _)| *name)
        .collect();
    if !missing.is_empty() {
        let text = format!(
            "{function}() takes a Dyad, a DyadAxis or the numbers m1, b1, m2, b2; missing: {}",
            missing.join(", ")
        );
        return Err(PyTypeError::new_err(text).into());
    }
    if let Some(subject) = subject {
        return Ok((subject, others));
    }
    let mut read = NUMBERS.map(|name| Numbers::one(name, 0.0));
    for (name, (slot, given)) in NUMBERS.into_iter().zip(read.iter_mut().zip(&numbers)) {
        if let Some(value) = given {
            *slot = Numbers::read(name, value)?;
        }
    }
    Ok((Subject::Numbers(read), others))
}

/// The `method` of a criterion as text, refused by its name where it is something else.
pub fn paper(method: Option<&Bound<'_, PyAny>>) -> Result<bool> {
    match method {
        None => Ok(false),
        Some(method) => {
            let Ok(method) = method.extract::<Argument<String>>();
            is_paper(&method)
        }
    }
}

/// The numbers of a criterion that `bind` has found to be there.
pub fn numbers<'py>(name: &'static str, value: Option<Bound<'py, PyAny>>) -> Outcome<Numbers<'py>> {
    Numbers::read(name, &value.expect("a required argument was bound"))
}
