//! Linear systems with several constant delays.

use nalgebra::DMatrix;
use num_complex::Complex64;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2, ToPyArray};
use pyo3::prelude::*;
use telespring::InvalidInput;

use crate::arguments::{Argument, Count, hash};
use crate::arrays::as_numbers;
use crate::errors::Outcome;
use crate::interrupt::apart;
use crate::spectrum::{Spectrum, warn};

/// x′(t) = A0 x(t) + Σ Aj x(t - τj): a linear system with several constant delays.
///
/// The general form of a dyad, and of three or more partners. Terms with the same delay are summed, those
/// without delay are added to A0; the others are sorted by delay.
///
/// Parameters
/// ----------
/// a0 : array_like, (n, n)
///     The matrix A0, 1/s for states of one unit; n from 1 to 64.
/// delayed : sequence of (float, array_like)
///     The pairs (τj, Aj): a delay, s, and its matrix.
///
/// Raises
/// ------
/// InvalidInput
///     If a matrix is not square or differs in size from A0, an entry is not a number or exceeds
///     1e12, or a delay is not in 0 to 100 s.
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> system = ts.DelaySystem([[0.0]], [(1.0, [[-1.0]])])  # x′(t) = -x(t - 1)
/// >>> round(system.spectral_abscissa(), 12)
/// -0.318131505205
#[pyclass(frozen, eq, module = "telespring")]
#[derive(Debug, Clone, PartialEq)]
pub struct DelaySystem(pub telespring::delay_system::DelaySystem);

type Matrix<'py> = Bound<'py, PyArray2<f64>>;

/// Reads any array_like as a matrix.
fn matrix(name: &str, value: &Bound<'_, PyAny>) -> Outcome<DMatrix<f64>> {
    let array = as_numbers(name, value)?;
    let Ok(array) = array.extract::<PyReadonlyArray2<'_, f64>>() else {
        let shape = array.getattr("shape")?;
        return Err(InvalidInput::new(
            name,
            format!("an array of shape {shape}"),
            "a matrix of rows and columns is required",
            "Give a nested list or a two-dimensional array.",
        )
        .into());
    };
    let array = array.as_array();
    Ok(DMatrix::from_row_iterator(array.nrows(), array.ncols(), array.iter().copied()))
}

/// The delay system's matrix as a numpy array.
fn to_python<'py>(py: Python<'py>, matrix: &DMatrix<f64>) -> PyResult<Matrix<'py>> {
    // columns are contiguous in a DMatrix
    matrix.as_slice().to_pyarray(py).reshape([matrix.ncols(), matrix.nrows()])?.transpose()
}

impl DelaySystem {
    /// A long computation with the matrices of the delay system, which a signal can interrupt.
    fn apart<T: Send + 'static>(
        &self,
        py: Python<'_>,
        compute: impl FnOnce(&telespring::delay_system::DelaySystem) -> T + Send + 'static,
    ) -> PyResult<T> {
        let system = self.0.clone();
        apart(py, move || compute(&system))
    }
}

#[pymethods]
impl DelaySystem {
    #[new]
    #[pyo3(signature = (a0, delayed=Argument::Given(Vec::new())), text_signature = "(a0, delayed=())")]
    fn new(a0: &Bound<'_, PyAny>, delayed: Argument<Vec<(f64, Bound<'_, PyAny>)>>) -> Outcome<Self> {
        let delayed = delayed.named("delayed")?;
        let a0 = matrix("a0", a0)?;
        let delayed = delayed
            .iter()
            .enumerate()
            .map(|(j, (delay, value))| Ok((*delay, matrix(&format!("delayed[{j}].matrix"), value)?)))
            .collect::<Outcome<_>>()?;
        Ok(Self(telespring::delay_system::DelaySystem::new(a0, delayed)?))
    }

    /// The Python attribute `a0`: matrix A0, terms of delay 0 added, 1/s.
    #[getter]
    fn a0<'py>(&self, py: Python<'py>) -> PyResult<Matrix<'py>> {
        to_python(py, self.0.instantaneous())
    }

    /// The pairs of delay, s, and matrix, 1/s, as numpy arrays by delay.
    #[getter]
    fn delayed<'py>(&self, py: Python<'py>) -> PyResult<Vec<(f64, Matrix<'py>)>> {
        self.0.delayed().iter().map(|(delay, matrix)| Ok((*delay, to_python(py, matrix)?))).collect()
    }

    /// The `count` rightmost characteristic roots as an array, 1/s.
    ///
    /// They are the zeros of det(s I - A0 - Σ Aj exp(-s τj)). A root at s = 0, such as the common
    /// motion of free robots, is one of them, exactly 0; `telespring.characteristic_roots` divides it out.
    ///
    /// Parameters
    /// ----------
    /// count : int
    ///     How many roots to return, 1 to 1000; without any delay there are n in all.
    ///
    /// Returns
    /// -------
    /// ndarray of complex
    ///     The roots, rightmost first.
    ///
    /// Raises
    /// ------
    /// InvalidInput
    ///     If `count` is out of its range.
    ///
    /// Warns
    /// -----
    /// CertificateWarning
    ///     If the argument principle does not confirm that no root was missed; `certified_roots` reports
    ///     the same without a warning.
    ///
    /// References
    /// ----------
    /// D. Breda, S. Maset, R. Vermiglio, 2005, doi:10.1137/030601600, for the starting values.
    ///
    /// Examples
    /// --------
    /// >>> import telespring as ts
    /// >>> system = ts.DelaySystem([[0.0]], [(1.0, [[-1.0]])])
    /// >>> system.characteristic_roots(2).round(6)
    /// array([-0.318132+1.337236j, -0.318132-1.337236j])
    #[pyo3(signature = (count=Count::Given(8)), text_signature = "($self, count=8)")]
    fn characteristic_roots<'py>(
        &self,
        py: Python<'py>,
        count: Count,
    ) -> Outcome<Bound<'py, PyArray1<Complex64>>> {
        let count = count.check()?;
        let roots = self.apart(py, move |system| system.characteristic_roots(count))??;
        warn(py, "roots'", &roots.certificate)?;
        Ok(roots.roots.into_pyarray(py))
    }

    /// The largest real part of the characteristic roots, 1/s, a root at s = 0 included.
    ///
    /// Returns
    /// -------
    /// float
    ///     The spectral abscissa; below zero every motion decays.
    ///
    /// Warns
    /// -----
    /// CertificateWarning
    ///     If the argument principle does not confirm that no root was missed.
    ///
    /// Examples
    /// --------
    /// >>> import telespring as ts
    /// >>> ts.DelaySystem([[-2.0]]).spectral_abscissa()
    /// -2.0
    fn spectral_abscissa(&self, py: Python<'_>) -> PyResult<f64> {
        let abscissa = self.apart(py, telespring::delay_system::DelaySystem::spectral_abscissa)?;
        warn(py, "abscissa's", &abscissa.certificate)?;
        Ok(abscissa.value)
    }

    /// The largest real part of the roots other than s = 0, 1/s.
    ///
    /// Returns
    /// -------
    /// float
    ///     The spectral abscissa; below zero every motion decays except those that `roots_at_zero` counts.
    ///     Minus infinity if s = 0 is the only root.
    ///
    /// Warns
    /// -----
    /// CertificateWarning
    ///     If the argument principle does not confirm that no root was missed.
    ///
    /// Examples
    /// --------
    /// >>> import telespring as ts
    /// >>> system = ts.hman().delay_system(71.2, (0.1, 0.2))
    /// >>> system.spectral_abscissa(), system.spectral_abscissa_without_zero() < -0.1
    /// (0.0, True)
    fn spectral_abscissa_without_zero(&self, py: Python<'_>) -> PyResult<f64> {
        let abscissa =
            self.apart(py, telespring::delay_system::DelaySystem::spectral_abscissa_without_zero)?;
        warn(py, "abscissa's", &abscissa.certificate)?;
        Ok(abscissa.value)
    }

    /// Multiplicity of the root s = 0 as an int, within rounding: 1 for two free robots, which can drift together.
    #[getter]
    fn roots_at_zero(&self) -> usize {
        self.0.roots_at_zero()
    }

    /// The delay system's rightmost characteristic roots together with their certificate.
    ///
    /// Parameters
    /// ----------
    /// count : int
    ///     How many roots to return, 1 to 1000.
    ///
    /// Returns
    /// -------
    /// Spectrum
    ///     A failed certificate is reported in it; there is no warning. `rigid_body` is always False, as a root
    ///     at s = 0 stays in the list.
    ///
    /// Raises
    /// ------
    /// InvalidInput
    ///     If `count` is out of its range.
    ///
    /// Examples
    /// --------
    /// >>> import telespring as ts
    /// >>> spectrum = ts.hman().delay_system(71.2, (0.1, 0.2)).certified_roots(5)
    /// >>> spectrum.complete, bool(abs(spectrum.roots).min() == 0.0)
    /// (True, True)
    #[pyo3(signature = (count=Count::Given(8)), text_signature = "($self, count=8)")]
    fn certified_roots(&self, py: Python<'_>, count: Count) -> Outcome<Spectrum> {
        let count = count.check()?;
        Ok(Spectrum::of(py, self.apart(py, move |system| system.characteristic_roots(count))??))
    }

    fn __repr__(&self) -> String {
        let rows = |matrix: &DMatrix<f64>| {
            let rows: Vec<String> =
                matrix.row_iter().map(|row| format!("{:?}", row.iter().collect::<Vec<_>>())).collect();
            format!("[{}]", rows.join(", "))
        };
        let delayed: Vec<String> =
            self.0.delayed().iter().map(|(delay, term)| format!("({delay:?}, {})", rows(term))).collect();
        format!("DelaySystem({}, [{}])", rows(self.0.instantaneous()), delayed.join(", "))
    }

    fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
        hash(self.__getnewargs__(py)?.into_pyobject(py)?.as_any())
    }

    fn __getnewargs__<'py>(&self, py: Python<'py>) -> PyResult<(Matrix<'py>, Vec<(f64, Matrix<'py>)>)> {
        Ok((self.a0(py)?, self.delayed(py)?))
    }
}
