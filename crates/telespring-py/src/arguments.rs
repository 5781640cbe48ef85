//! Arguments as Python passes them. One of the wrong type is refused by its name, like a value out of range.

use numpy::{PyArrayDescrMethods, PyReadonlyArray2, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyTuple};
use std::convert::Infallible;
use telespring::spectrum::MAX_ROOTS;
use telespring::{Delay, InvalidInput};

use crate::arrays::as_numbers;
use crate::errors::Outcome;
use crate::model::{Dyad, Operator, Robot};
use crate::network::Network;

/// An argument, or its representation where it has another type.
pub enum Argument<T> {
    /// Of the expected type.
    Given(T),
    /// Of another type, as Python writes it.
    Other(String),
}

impl<'a, 'py, T: FromPyObject<'a, 'py>> FromPyObject<'a, 'py> for Argument<T> {
    type Error = Infallible;

    /// The argument in its type, or as written text if Python passed another type.
    fn extract(value: Borrowed<'a, 'py, PyAny>) -> Result<Self, Infallible> {
        if holds_truth_value(&value) {
            return Ok(Self::Other(written(&value)));
        }
        Ok(value.extract().map_or_else(|_| Self::Other(written(&value)), Self::Given))
    }
}

/// Whether a value is True or False, or a list or an array with one: Python counts them as 1 and 0, but a user
/// who passes one has mixed up two arguments.
pub fn holds_truth_value(value: &Bound<'_, PyAny>) -> bool {
    if value.is_exact_instance_of::<PyFloat>() || value.is_exact_instance_of::<PyInt>() {
        return false;
    }
    if value.is_instance_of::<PyBool>() {
        return true;
    }
    if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        let items = value.try_iter().map(|items| items.flatten().any(|item| holds_truth_value(&item)));
        return items.unwrap_or(false);
    }
    if let Ok(array) = value.cast::<PyUntypedArray>() {
        return array.dtype().kind() == b'b';
    }
    let name = value.get_type().fully_qualified_name();
    name.is_ok_and(|name| name.to_cow().is_ok_and(|name| matches!(&*name, "numpy.bool" | "numpy.bool_")))
}

/// An argument that is True or False.
pub struct Truth(Result<bool, String>);

impl Truth {
    /// The argument as a boolean, or a refusal with this field.
    pub fn named(self, field: &str) -> Outcome<bool> {
        Ok(self
            .0
            .map_err(|text| InvalidInput::new(field, text, "True or False is required", "Give a bool."))?)
    }
}

impl FromPyObject<'_, '_> for Truth {
    type Error = Infallible;

    fn extract(value: Borrowed<'_, '_, PyAny>) -> Result<Self, Infallible> {
        Ok(Self(value.extract().map_err(|_| written(&value))))
    }
}

/// The representation of a Python object, shortened to fit a message.
pub fn written(value: &Bound<'_, PyAny>) -> String {
    let text = value.repr().map_or_else(|_| "an object".to_owned(), |text| text.to_string());
    match text.char_indices().nth(57) {
        Some((end, _)) if text.chars().count() > 60 => format!("{}...", &text[..end]),
        _ => text,
    }
}

impl<T> Argument<T> {
    /// The argument in its type, or a refusal.
    pub fn or_refuse(self, field: &str, allowed: impl Into<String>, remedy: &str) -> telespring::Result<T> {
        match self {
            Self::Given(value) => Ok(value),
            Self::Other(text) => Err(InvalidInput::new(field, text, allowed.into(), remedy)),
        }
    }
}

/// What an argument of each type must be, and what to pass.
macro_rules! named {
    ($($type:ty: $allowed:literal, $remedy:literal;)*) => {$(
        impl Argument<$type> {
            /// The argument in its type, or a refusal with this field.
            pub fn named(self, field: &str) -> Outcome<$type> {
                Ok(self.or_refuse(field, $allowed, $remedy)?)
            }
        }
    )*};
}

named! {
    String: "a string is required", "Give a str.";
    usize: "a whole number of 0 or more is required", "Give an int.";
    Option<Vec<String>>: "a name for each axis is required, in a list", "Write it such as ['x', 'y'].";
}

macro_rules! named_classes {
    ($($type:ty: $allowed:literal, $remedy:literal;)*) => {$(
        impl<'py> Argument<$type> {
            /// The argument in its class, or a refusal with this field.
            pub fn named(self, field: &str) -> Outcome<$type> {
                Ok(self.or_refuse(field, $allowed, $remedy)?)
            }
        }
    )*};
}

named_classes! {
    Bound<'py, Dyad>: "a Dyad is required", "Pass Dyad(robot1, robot2).";
    Bound<'py, Robot>: "a Robot is required", "Pass Robot(mass, damping).";
    Bound<'py, Network>: "a Network is required", "Pass Network(delay, sample_period=0.001).";
    Bound<'py, Operator>: "an Operator is required", "Pass Operator(mass, damping, stiffness).";
    Option<[Option<Bound<'py, Operator>>; 2]>:
        "a pair is required, for each robot an Operator or None", "Write it such as (operator, None).";
    Vec<(f64, Bound<'py, PyAny>)>:
        "pairs of a delay and a matrix are required", "Write them such as [(0.1, [[-1.0]])].";
}

/// A hash of what a frozen class is built from; equal values have equal hashes, also 0.0 and -0.0.
pub fn hash(value: &Bound<'_, PyAny>) -> PyResult<isize> {
    fn hashable<'py>(value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let py = value.py();
        if let Ok(dict) = value.cast::<PyDict>() {
            let items = dict.iter().map(|(key, value)| Ok((key, hashable(&value)?)));
            let items: Vec<(Bound<'_, PyAny>, Bound<'_, PyAny>)> = items.collect::<PyResult<_>>()?;
            return Ok(pyo3::types::PyFrozenSet::new(py, PyTuple::new(py, items)?)?.into_any());
        }
        if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
            let items = value.try_iter()?.map(|item| hashable(&item?));
            return Ok(PyTuple::new(py, items.collect::<PyResult<Vec<_>>>()?)?.into_any());
        }
        match value.getattr("tolist") {
            Ok(convert) => hashable(&convert.call0()?),
            Err(_) => Ok(value.clone()),
        }
    }
    hashable(value)?.hash()
}

/// A real number.
pub type Number = Argument<f64>;

impl Number {
    /// The argument as a number, or a refusal with this field.
    pub fn named(self, field: &str) -> Outcome<f64> {
        Ok(self.or_refuse(field, "a real number is required", "Give one number.")?)
    }
}

impl Argument<(f64, f64)> {
    /// The argument as the ends of a range, or a refusal with this field.
    pub fn named(self, field: &str) -> Outcome<(f64, f64)> {
        Ok(self.or_refuse(field, "two real numbers are required", "Write them such as (0.5, 1.5).")?)
    }
}

impl Argument<Option<f64>> {
    /// The argument as a number or `None`, or a refusal with this field.
    pub fn named(self, field: &str) -> Outcome<Option<f64>> {
        Ok(self.or_refuse(field, "a real number or None is required", "Give one number, or None.")?)
    }
}

impl Argument<Option<[Option<Py<PyAny>>; 2]>> {
    /// The argument as a pair or `None`, or a refusal with this field.
    pub fn named(self, field: &str) -> Outcome<Option<[Option<Py<PyAny>>; 2]>> {
        let allowed = "a pair is required, for each robot a program or None";
        Ok(self.or_refuse(field, allowed, "Write it such as (agent, None).")?)
    }
}

impl Argument<u64> {
    /// The argument as a whole number, or a refusal with this field.
    pub fn named(self, field: &str) -> Outcome<u64> {
        let allowed = format!("a whole number from 0 to {} is required", u64::MAX);
        Ok(self.or_refuse(field, allowed, "Give an int in this range.")?)
    }
}

impl Argument<Vec<f64>> {
    /// The argument as numbers, or a refusal with this field.
    pub fn named(self, field: &str) -> Outcome<Vec<f64>> {
        Ok(self.or_refuse(field, "a row of real numbers is required", "Give a flat array of floats.")?)
    }
}

impl Argument<Vec<u64>> {
    /// The argument as whole numbers, or a refusal with this field.
    pub fn named(self, field: &str) -> Outcome<Vec<u64>> {
        let allowed = format!("a row of whole numbers from 0 to {} is required", u64::MAX);
        Ok(self.or_refuse(field, allowed, "Give a flat array of integers.")?)
    }
}

impl Argument<[f64; 2]> {
    /// The argument as numbers, or a refusal with this field.
    pub fn named(self, field: &str) -> Outcome<[f64; 2]> {
        Ok(self.or_refuse(
            field,
            "two real numbers, along x and y, are required",
            "Give a pair of floats.",
        )?)
    }
}

impl Argument<PerAxis> {
    /// The argument as numbers, or a refusal with this field.
    pub fn named(self, field: &str) -> Outcome<PerAxis> {
        let allowed = "a number, or one number per axis, is required";
        Ok(self.or_refuse(field, allowed, "Give a number or a list of numbers.")?)
    }
}

/// One number for every axis, or one per axis.
#[derive(Debug, Clone, PartialEq)]
pub enum PerAxis {
    /// The same on every axis, however many there are.
    All(f64),
    /// One per axis.
    Each(Vec<f64>),
}

impl FromPyObject<'_, '_> for PerAxis {
    type Error = PyErr;

    fn extract(value: Borrowed<'_, '_, PyAny>) -> PyResult<Self> {
        if let Ok(number) = value.extract::<f64>() {
            return Ok(Self::All(number));
        }
        value.extract::<Vec<f64>>().map(Self::Each)
    }
}

impl PerAxis {
    /// How many axes the argument is written for; None if one number applies to all.
    pub fn count(&self) -> Option<usize> {
        match self {
            Self::All(_) => None,
            Self::Each(values) => Some(values.len()),
        }
    }

    /// The argument as one number for each of that many axes.
    pub fn on(&self, axes: usize) -> Vec<f64> {
        match self {
            Self::All(value) => vec![*value; axes],
            Self::Each(values) => values.clone(),
        }
    }

    /// The argument as Python passed it.
    pub fn to_python<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(match self {
            Self::All(value) => value.into_pyobject(py)?.into_any(),
            Self::Each(values) => PyList::new(py, values)?.into_any(),
        })
    }

    /// The argument as Python writes it.
    pub fn text(&self) -> String {
        match self {
            Self::All(value) => format!("{value:?}"),
            Self::Each(values) => format!("{values:?}"),
        }
    }
}

/// The requested number of roots.
pub type Count = Argument<usize>;

impl Count {
    /// The argument as a number of roots; the core checks its range.
    pub fn check(self) -> telespring::Result<usize> {
        let allowed = format!("the number of roots must be a whole number from 1 to {MAX_ROOTS}");
        self.or_refuse("count", allowed, "Give an int.")
    }
}

/// An axis by its index or its name.
#[derive(FromPyObject)]
pub enum AxisKind {
    /// Counted from 0.
    Index(i64),
    /// As the dyad names it.
    Name(String),
}

/// An axis by its index or its name.
pub type AxisChoice = Argument<AxisKind>;

impl AxisChoice {
    /// The first axis, the default.
    pub const FIRST: Self = Self::Given(AxisKind::Index(0));

    /// The argument for the axis with this name.
    pub fn named(name: &str) -> Self {
        Self::Given(AxisKind::Name(name.to_owned()))
    }

    /// The index of the axis that the argument chooses in the dyad.
    pub fn index(&self, dyad: &telespring::Dyad) -> telespring::Result<usize> {
        let names = dyad.axis_names();
        let (index, text) = match self {
            Self::Given(AxisKind::Index(index)) => (usize::try_from(*index).ok(), index.to_string()),
            Self::Given(AxisKind::Name(name)) => {
                (names.iter().position(|known| known == name), format!("{name:?}"))
            }
            Self::Other(text) => (None, text.clone()),
        };
        index.filter(|&index| index < names.len()).ok_or_else(|| {
            InvalidInput::new(
                "axis",
                text,
                format!("this dyad has the axes {names:?}, counted from 0"),
                "Choose one of them by its index or its name.",
            )
        })
    }

    /// The axis that the argument chooses in the dyad.
    pub fn of(&self, dyad: &telespring::Dyad) -> telespring::Result<telespring::DyadAxis> {
        dyad.axis(self.index(dyad)?)
    }
}

/// One delay (or jitter) each way, or (forward, backward), s.
pub enum DelayChoice {
    /// The same each way.
    EachWay(f64),
    /// Forward and backward, and the representation; `check` checks the length.
    Row(Vec<f64>, String),
    /// Neither a number nor a row of numbers.
    Other(String),
}

impl FromPyObject<'_, '_> for DelayChoice {
    type Error = Infallible;

    fn extract(value: Borrowed<'_, '_, PyAny>) -> Result<Self, Infallible> {
        if holds_truth_value(&value) {
            return Ok(Self::Other(written(&value)));
        }
        // The row first: numpy makes a number of an array of one.
        if let Ok(row) = value.extract::<Vec<f64>>() {
            return Ok(Self::Row(row, written(&value)));
        }
        Ok(value.extract::<f64>().map_or_else(|_| Self::Other(written(&value)), Self::EachWay))
    }
}

impl DelayChoice {
    /// The argument as a delay, checked.
    pub fn check(&self) -> telespring::Result<Delay> {
        if let Self::EachWay(delay) = self {
            return Delay::each_way(*delay);
        }
        let [forward, backward] = self.both_ways("delay")?;
        Delay::new(forward, backward)
    }

    /// The numbers of both ways, or a refusal with this field.
    pub fn both_ways(&self, field: &str) -> telespring::Result<[f64; 2]> {
        let text = match self {
            Self::EachWay(value) => return Ok([*value; 2]),
            Self::Row(row, text) => match row[..] {
                [forward, backward] => return Ok([forward, backward]),
                _ => text,
            },
            Self::Other(text) => text,
        };
        Err(InvalidInput::new(
            field,
            text,
            format!("a {field} is one number for both ways, s, or the two numbers (forward, backward)"),
            "Give a float or a pair of floats.",
        ))
    }
}

/// Reads an argument of rows (x, y) from any array_like.
pub fn rows(name: &str, value: &Bound<'_, PyAny>) -> Outcome<Vec<[f64; 2]>> {
    let array = as_numbers(name, value)?;
    if let Ok(array) = array.extract::<PyReadonlyArray2<'_, f64>>()
        && array.as_array().ncols() == 2
    {
        return Ok(array.as_array().outer_iter().map(|row| [row[0], row[1]]).collect());
    }
    let shape = array.getattr("shape")?;
    Err(InvalidInput::new(
        name,
        format!("an array of shape {shape}"),
        "rows of two numbers, x and y, are required",
        "Give an array of shape (n, 2).",
    )
    .into())
}
