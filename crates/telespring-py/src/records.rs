//! Results of the core as frozen Python classes: one macro gives them getters, `to_dict`, `repr`, equality,
//! hashing and pickling.

use numpy::{Element, PyArray, PyArrayMethods};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyList, PyTuple};
use telespring::InvalidInput;

use crate::arguments::written;
use crate::errors::Failure;

/// A value that a record holds, on its way to Python and back.
pub trait Value: Sized {
    /// What the attribute of a Python record reads as.
    fn to_python<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>>;

    /// A record's value from what its Python constructor takes.
    fn from_python(value: &Bound<'_, PyAny>) -> PyResult<Self>;

    /// What the constructor of a Python record takes to build this value again.
    fn to_argument<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.to_python(py)
    }

    /// What `json.dumps` takes of a record: None if a number is infinite, lists for tuples and arrays.
    fn to_json<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        static JSON_READY: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
        JSON_READY.import(py, "telespring._json", "json_ready")?.call1((self.to_python(py)?,))
    }
}

macro_rules! plain_values {
    ($($type:ty),*) => {$(
        impl Value for $type {
            /// A plain value of a record as Python reads it.
            fn to_python<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
                self.into_bound_py_any(py)
            }

            /// A plain value of a record from Python.
            fn from_python(value: &Bound<'_, PyAny>) -> PyResult<Self> {
                value.extract()
            }
        }
    )*};
}

plain_values!(f64, bool, usize, i64, i8, String);

impl<T: Value> Value for Option<T> {
    /// An optional value of a record as Python reads it.
    fn to_python<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.as_ref().map_or_else(|| Ok(py.None().into_bound(py)), |value| value.to_python(py))
    }

    /// An optional value of a record from Python.
    fn from_python(value: &Bound<'_, PyAny>) -> PyResult<Self> {
        if value.is_none() { Ok(None) } else { T::from_python(value).map(Some) }
    }

    /// An optional value of a record for `json.dumps`.
    fn to_json<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.as_ref().map_or_else(|| Ok(py.None().into_bound(py)), |value| value.to_json(py))
    }
}

impl<T: Value> Value for Vec<T> {
    /// A list in a record as Python reads it.
    fn to_python<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let items: Vec<_> = self.iter().map(|item| item.to_python(py)).collect::<PyResult<_>>()?;
        Ok(PyTuple::new(py, items)?.into_any())
    }

    /// A list in a record from Python.
    fn from_python(value: &Bound<'_, PyAny>) -> PyResult<Self> {
        value.try_iter()?.map(|item| T::from_python(&item?)).collect()
    }

    /// A list in a record for `json.dumps`.
    fn to_json<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let items: Vec<_> = self.iter().map(|item| item.to_json(py)).collect::<PyResult<_>>()?;
        Ok(PyList::new(py, items)?.into_any())
    }
}

impl<T: Value + Clone, const N: usize> Value for [T; N] {
    fn to_python<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.to_vec().to_python(py)
    }

    fn from_python(value: &Bound<'_, PyAny>) -> PyResult<Self> {
        let items = Vec::<T>::from_python(value)?;
        let got = items.len();
        items.try_into().map_err(|_| {
            pyo3::exceptions::PyValueError::new_err(format!("{N} items are required here, not {got}"))
        })
    }

    fn to_json<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.to_vec().to_json(py)
    }
}

/// A numpy array that a record holds; every read of the attribute returns the same one.
#[derive(Debug)]
pub struct Array<T, D>(pub Py<PyArray<T, D>>);

impl<T, D> From<Bound<'_, PyArray<T, D>>> for Array<T, D> {
    /// The array of a record from one of numpy.
    fn from(array: Bound<'_, PyArray<T, D>>) -> Self {
        Self(array.unbind())
    }
}

impl<T: Element + PartialEq, D: numpy::ndarray::Dimension> PartialEq for Array<T, D> {
    /// Whether the arrays of two records are equal; a missing number (NaN) equals another one.
    fn eq(&self, other: &Self) -> bool {
        #[expect(clippy::eq_op, reason = "of all values only NaN differs from itself")]
        let same = |(one, other): (&T, &T)| one == other || (one != one && other != other);
        Python::attach(|py| {
            let (own, other) = (self.0.bind(py).readonly(), other.0.bind(py).readonly());
            let (own, other) = (own.as_array(), other.as_array());
            own.shape() == other.shape() && own.iter().zip(other.iter()).all(same)
        })
    }
}

impl<T: Element, D: numpy::ndarray::Dimension> Value for Array<T, D> {
    /// The array of a record as Python reads it.
    fn to_python<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(self.0.bind(py).clone().into_any())
    }

    /// The array of a record from Python.
    fn from_python(value: &Bound<'_, PyAny>) -> PyResult<Self> {
        Ok(Self(value.cast::<PyArray<T, D>>().map_err(PyErr::from)?.clone().unbind()))
    }
}

/// The value of a record's attribute, or a refusal with its name.
pub fn read<T: Value>(field: &str, value: &Bound<'_, PyAny>) -> PyResult<T> {
    T::from_python(value).map_err(|error| {
        let py = value.py();
        // a value in it that was refused already says what it must be
        let why = match error.value(py).getattr("allowed") {
            Ok(allowed) => allowed.to_string(),
            Err(_) => format!("a value of another type is required ({})", error.value(py)),
        };
        let remedy = "Results are computed by functions; pickle and copy rebuild them.";
        Failure::from(InvalidInput::new(field, written(value), why, remedy)).into()
    })
}

/// A record's attribute as `repr` shows it: whole where it is short, else its type.
pub fn short(value: &Bound<'_, PyAny>) -> PyResult<String> {
    let text = value.repr()?.to_string();
    if text.chars().count() <= 40 && !text.contains('\n') {
        return Ok(text);
    }
    if let Ok(items) = value.cast::<PyTuple>()
        && items.len() <= 4
    {
        let items: Vec<_> = items.iter().map(|item| short(&item)).collect::<PyResult<_>>()?;
        return Ok(format!("({})", items.join(", ")));
    }
    Ok(format!("<{}>", value.get_type().name()?))
}

/// The attributes of an object as a table for notebooks.
pub fn html_table<'py>(title: &str, attributes: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    static TABLE: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    TABLE.import(attributes.py(), "telespring._html", "table")?.call1((title, attributes))
}

/// A status of the core as the word that Python reads.
macro_rules! words {
    ($type:ty { $($variant:ident = $word:literal),* $(,)? }) => {
        impl $crate::records::Value for $type {
            /// A status in a record as its Python word.
            fn to_python<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
                let word = match self {
                    $(Self::$variant => $word,)*
                    #[allow(unreachable_patterns, reason = "only some of the core's enums may grow")]
                    _ => "other",
                };
                Ok(pyo3::types::PyString::intern(py, word).into_any())
            }

            /// A status in a record from its Python word.
            fn from_python(value: &Bound<'_, PyAny>) -> PyResult<Self> {
                match value.extract::<std::borrow::Cow<'_, str>>()?.as_ref() {
                    $($word => Ok(Self::$variant),)*
                    other => {
                        let words = [$($word),*].map(|word: &str| format!("{word:?}")).join(", ");
                        let allowed = format!("one of {words} is required");
                        let refusal = telespring::InvalidInput::new("value", other, allowed, "Choose one of them.");
                        Err(crate::errors::Failure::from(refusal).into())
                    }
                }
            }
        }
    };
}

/// A frozen Python class: around a type of the core, or with fields of its own where these are arrays.
///
/// `computed` lists attributes that the constructor does not take, `methods` what else the class offers; `repr`
/// replaces the list of attributes that `repr()` gives otherwise. With `as tuple` the record also reads, unpacks and compares as the tuple of its fields.
macro_rules! record {
    // around a type of the core
    ($(#[$doc:meta])* $class:ident($core:path) $(as $tuple:ident)? { $($(#[$about:meta])* $field:ident,)* }
     $(computed { $($(#[$more_about:meta])* $more:ident = $compute:expr,)* })?
     $(methods { $($method:tt)* })?
     $(repr { $repr:expr })?) => {
        #[pyclass(frozen, module = "telespring")]
        #[derive(Debug, Clone, PartialEq)]
        $(#[$doc])*
        pub struct $class(pub $core);

        impl std::ops::Deref for $class {
            type Target = $core;
            /// The value of the core that a record holds.
            fn deref(&self) -> &$core {
                &self.0
            }
        }

        impl $crate::records::Value for $core {
            /// The record around a value of the core.
            fn to_python<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
                Ok(Bound::new(py, $class(self.clone()))?.into_any())
            }

            /// The value of the core in a Python record.
            fn from_python(value: &Bound<'_, PyAny>) -> PyResult<Self> {
                Ok(value.cast::<$class>()?.get().0.clone())
            }

            /// The record around a value of the core, for `json.dumps`.
            fn to_json<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
                Ok($class(self.clone()).to_dict(py)?.into_any())
            }
        }

        $crate::records::record! { @tuple $class [$($tuple)?]
            { type Core = $core; Self(Core { $($field: $crate::records::read(stringify!($field), $field)?),* }) }
            { $($($method)*)? } [$($repr)?]
            $($(#[$about])* $field,)* ; $($($(#[$more_about])* $more = $compute,)*)? }
    };
    // with fields of its own
    ($(#[$doc:meta])* $class:ident $(as $tuple:ident)? { $($(#[$about:meta])* $field:ident: $type:ty,)* }
     $(computed { $($(#[$more_about:meta])* $more:ident = $compute:expr,)* })?
     $(methods { $($method:tt)* })?
     $(repr { $repr:expr })?) => {
        #[pyclass(frozen, module = "telespring")]
        #[derive(Debug, PartialEq)]
        $(#[$doc])*
        pub struct $class { $($(#[$about])* pub $field: $type,)* }

        $crate::records::record! { @tuple $class [$($tuple)?]
            { Self { $($field: $crate::records::read(stringify!($field), $field)?),* } }
            { $($($method)*)? } [$($repr)?]
            $($(#[$about])* $field,)* ; $($($(#[$more_about])* $more = $compute,)*)? }
    };
    (@tuple $class:ident [] $build:block { $($method:tt)* } [$($repr:expr)?] $($rest:tt)*) => {
        $crate::records::record! { @class $class $build { $($method)* } [$($repr)?] |_, _| false; $($rest)* }
    };
    (@tuple $class:ident [tuple] $build:block { $($method:tt)* } [$($repr:expr)?] $($rest:tt)*) => {
        $crate::records::record! { @class $class $build {
            fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
                Ok(self.__getnewargs__(py)?.len())
            }

            fn __getitem__<'py>(&self, index: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
                self.__getnewargs__(index.py())?.as_any().get_item(index)
            }

            fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, pyo3::types::PyIterator>> {
                self.__getnewargs__(py)?.as_any().try_iter()
            }

            $($method)*
        } [$($repr)?] |record: &$class, other: &Bound<'_, PyAny>| {
            record.__getnewargs__(other.py()).and_then(|own| own.as_any().eq(other)).unwrap_or(false)
        }; $($rest)* }
    };
    (@class $class:ident $build:block { $($method:tt)* } [$($repr:expr)?] $equals_tuple:expr;
     $($(#[$about:meta])* $field:ident,)* ; $($(#[$more_about:meta])* $more:ident = $compute:expr,)*) => {
        #[pymethods]
        impl $class {
            #[new]
            #[allow(clippy::too_many_arguments, reason = "one for each attribute")]
            fn new($($field: &Bound<'_, PyAny>),*) -> PyResult<Self> {
                Ok($build)
            }

            $(
                $(#[$about])*
                #[getter]
                fn $field<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
                    $crate::records::Value::to_python(&self.$field, py)
                }
            )*

            $(
                $(#[$more_about])*
                #[getter]
                fn $more<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
                    let compute: fn(&Self) -> _ = $compute;
                    $crate::records::Value::to_python(&compute(self), py)
                }
            )*

            /// The attributes of the record as a dict that `json.dumps(..., allow_nan=False)` takes.
            ///
            /// JSON has no infinity: an infinite number is None.
            fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, pyo3::types::PyDict>> {
                let out = pyo3::types::PyDict::new(py);
                $(out.set_item(stringify!($field), $crate::records::Value::to_json(&self.$field, py)?)?;)*
                $({
                    let compute: fn(&Self) -> _ = $compute;
                    out.set_item(stringify!($more), $crate::records::Value::to_json(&compute(self), py)?)?;
                })*
                Ok(out)
            }

            fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
                let own: &[fn(&Self) -> String] = &[$($repr)?];
                if let Some(own) = own.first() {
                    return Ok(own(self));
                }
                let fields = [
                    $(format!("{}={}", stringify!($field), $crate::records::short(&self.$field(py)?)?)),*
                ];
                Ok(format!("{}({})", stringify!($class), fields.join(", ")))
            }

            fn _repr_html_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
                $crate::records::html_table(stringify!($class), self.to_dict(py)?.as_any())
            }

            fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
                let equals_tuple: fn(&Self, &Bound<'_, PyAny>) -> bool = $equals_tuple;
                match other.cast::<Self>() {
                    Ok(other) => self == other.get(),
                    Err(_) => equals_tuple(self, other),
                }
            }

            fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
                self.__getnewargs__(py)?.as_any().hash()
            }

            fn __getnewargs__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, pyo3::types::PyTuple>> {
                let fields = vec![$($crate::records::Value::to_argument(&self.$field, py)?),*];
                pyo3::types::PyTuple::new(py, fields)
            }

            $($method)*
        }
    };
}

pub(crate) use record;
pub(crate) use words;
