//! What a robot file tells beside mass and damping: uncertainty and record of the identification.

use numpy::{PyArray1, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::PyString;
use telespring::InvalidInput;
use telespring::study::RobotFile;

use crate::arguments::{Argument, hash, written};
use crate::errors::Outcome;
use crate::records::record;

/// Uncertainty of a robot's identified parameters, per axis.
///
/// Mass and damping of an axis have a normal distribution with these standard deviations and this
/// correlation; axes and robots are independent. `Study.uncertainty` returns it.
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> study = ts.Study.from_toml('''
/// ... robot1 = {mass = 1, damping = 5, mass_sd = 0.02, damping_sd = 0.1}
/// ... robot2 = {mass = 1, damping = 5}
/// ... coupling.stiffness = 20
/// ... network.delay = 0.05
/// ... ''')
/// >>> first, second = study.uncertainty
/// >>> first.mass_sd, second is None
/// (array([0.02]), True)
#[pyclass(frozen, eq, module = "telespring")]
#[derive(Debug, Clone, PartialEq)]
pub struct Uncertainty(pub telespring::study::Uncertainty);

#[pymethods]
impl Uncertainty {
    #[new]
    fn new(
        mass_sd: Argument<Vec<f64>>,
        damping_sd: Argument<Vec<f64>>,
        correlation: Argument<Vec<f64>>,
    ) -> Outcome<Self> {
        Ok(Self(telespring::study::Uncertainty {
            mass_sd: mass_sd.named("mass_sd")?,
            damping_sd: damping_sd.named("damping_sd")?,
            correlation: correlation.named("correlation")?,
        }))
    }

    /// Standard deviation of the mass per axis, kg.
    #[getter]
    fn mass_sd<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.mass_sd.to_pyarray(py)
    }

    /// Standard deviation of the damping per axis, N·s/m.
    #[getter]
    fn damping_sd<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.damping_sd.to_pyarray(py)
    }

    /// Correlation of mass and damping per axis, −1 to 1.
    #[getter]
    fn correlation<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.correlation.to_pyarray(py)
    }

    fn __repr__(&self) -> String {
        let telespring::study::Uncertainty { mass_sd, damping_sd, correlation } = &self.0;
        format!("Uncertainty(mass_sd={mass_sd:?}, damping_sd={damping_sd:?}, correlation={correlation:?})")
    }

    fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
        hash(self.__getnewargs__().into_pyobject(py)?.as_any())
    }

    fn __getnewargs__(&self) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        (self.0.mass_sd.clone(), self.0.damping_sd.clone(), self.0.correlation.clone())
    }
}

record! {
    /// What identification recorded in a robot file in addition to the robot's parameters.
    RobotRecord(telespring::study::RobotRecord) {
        /// Whether the axes are free of inertial coupling; None if that is unknown.
        independent,
        /// Reservations about the estimates, as sentences.
        warnings,
        /// How many logs the estimates are from; None if that is unknown. The scatter between logs is in the
        /// standard deviations only of two logs or more.
        logs,
        /// Stiffness of a spring between the robot and the ground, N/m per axis; None if none was found.
        stiffness,
    }
}

/// What identification recorded in a robot file, in its section `[identification]`.
///
/// Parameters
/// ----------
/// robot_file : path_like or str
///     The file's path, or its text if it is a `str`.
///
/// Returns
/// -------
/// RobotRecord
///     Nothing known and no warnings if the section is missing.
///
/// Raises
/// ------
/// InvalidInput
///     If the text is no robot file.
/// OSError
///     If the file cannot be read.
///
/// Examples
/// --------
/// >>> from telespring.study.robot_file import robot_record
/// >>> text = "[robot]\nmass = 0.84\ndamping = 7.7\n[identification]\naxes_independent = false"
/// >>> robot_record(text)
/// RobotRecord(independent=False, warnings=(), logs=None, stiffness=None)
#[pyfunction]
pub fn robot_record(robot_file: &Bound<'_, PyAny>) -> Outcome<RobotRecord> {
    Ok(RobotRecord(read_robot_file(robot_file)?.record()?))
}

/// A robot file by its path, or by its text.
pub fn read_robot_file(path_or_text: &Bound<'_, PyAny>) -> Outcome<RobotFile> {
    // a robot file's text assigns values, the name of a file does not
    let is_text = |text: &Bound<'_, PyString>| text.to_cow().is_ok_and(|text| text.contains(['=', '\n']));
    Ok(match path_or_text.cast::<PyString>() {
        Ok(text) if is_text(text) => RobotFile::from_toml(&text.to_cow()?, "the robot's text")?,
        _ => RobotFile::from_toml(&read_text(path_or_text, "a robot file")?, &path_or_text.to_string())?,
    })
}

/// The text of a study or robot file in UTF-8; `kind` names it in a refusal.
pub fn read_text(path: &Bound<'_, PyAny>, kind: &str) -> Outcome<String> {
    // Python's own reading raises OSError with the file's name
    let path_of = path.py().import("pathlib")?.getattr("Path")?;
    let Ok(file) = path_of.call1((path,)) else {
        let allowed = "the path of a file is required";
        return Err(InvalidInput::new("path", written(path), allowed, "Give a str or a pathlib.Path.").into());
    };
    let bytes = file.call_method0("read_bytes")?;
    let bytes: Vec<u8> = bytes.extract()?;
    String::from_utf8(bytes).map_err(|error| {
        // a spreadsheet, MATLAB or Parquet file, not text in another encoding
        let is_binary = error.as_bytes().contains(&0);
        let before = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = 1 + before.iter().filter(|&&byte| byte == b'\n').count();
        InvalidInput::new(
            path.to_string(),
            format!("a byte on line {line}"),
            format!("{kind} is text in UTF-8"),
            if is_binary {
                "This file is not text. If it is a log, make a robot file of it: telespring identify LOG --out \
                 robot.toml."
            } else {
                "Save it in that encoding."
            },
        )
        .into()
    })
}
