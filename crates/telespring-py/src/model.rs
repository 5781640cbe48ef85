//! Robots, operators and dyads as Python classes.

use numpy::{PyArray1, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyIterator, PyList, PyTuple};
use telespring::InvalidInput;

use crate::arguments::{Argument, AxisChoice, DelayChoice, Number, PerAxis, hash};
use crate::axis::DyadAxis;
use crate::delay_system::DelaySystem;
use crate::errors::Outcome;
use crate::prediction::read_prediction;
use crate::records::html_table;

/// A robot with independent axes, each a mass with viscous damping.
///
/// Parameters
/// ----------
/// mass : float or sequence of float
///     Mass, kg, one per axis.
/// damping : float or sequence of float
///     Viscous damping, N·s/m, one per axis.
/// axes : sequence of str, optional
///     Names of the axes; x, y, z, axis4, … by default.
///
/// A single number applies to every axis.
///
/// Raises
/// ------
/// InvalidInput
///     If a mass is not in 1e-4 to 1e4 kg, a damping not in 0 to 1e6 N·s/m, or lengths differ.
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> ts.Robot(mass=[0.8334, 1.0649], damping=[7.7257, 10.1168])
/// Robot(mass=[0.8334, 1.0649], damping=[7.7257, 10.1168], axes=['x', 'y'])
#[pyclass(frozen, eq, module = "telespring")]
#[derive(Debug, Clone, PartialEq)]
pub struct Robot(pub telespring::Robot);

#[pymethods]
impl Robot {
    #[new]
    #[pyo3(signature = (mass, damping, axes=Argument::Given(None)), text_signature = "(mass, damping, axes=None)")]
    fn new(
        mass: Argument<PerAxis>,
        damping: Argument<PerAxis>,
        axes: Argument<Option<Vec<String>>>,
    ) -> Outcome<Self> {
        let (mass, damping, axes) = (mass.named("mass")?, damping.named("damping")?, axes.named("axes")?);
        let count = mass.count().or(damping.count()).unwrap_or(1);
        Ok(Self(telespring::Robot::new(mass.on(count), damping.on(count), axes)?))
    }

    /// Mass, kg, one per axis.
    #[getter]
    fn mass<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.mass().to_pyarray(py)
    }

    /// Viscous damping, N·s/m, one per axis.
    #[getter]
    fn damping<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.damping().to_pyarray(py)
    }

    /// The axes' names.
    #[getter]
    fn axes(&self) -> Vec<String> {
        self.0.axes().to_vec()
    }

    /// The robot's numbers as a dict that `json.dumps` takes.
    pub fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let out = PyDict::new(py);
        out.set_item("axes", self.axes())?;
        out.set_item("mass", self.0.mass().to_vec())?;
        out.set_item("damping", self.0.damping().to_vec())?;
        Ok(out)
    }

    fn _repr_html_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        html_table("Robot", self.to_dict(py)?.as_any())
    }

    fn __repr__(&self) -> String {
        format!(
            "Robot(mass={:?}, damping={:?}, axes={})",
            self.0.mass(),
            self.0.damping(),
            names(self.0.axes())
        )
    }

    fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
        hash(self.__getnewargs__().into_pyobject(py)?.as_any())
    }

    fn __getnewargs__(&self) -> (Vec<f64>, Vec<f64>, Vec<String>) {
        (self.0.mass().to_vec(), self.0.damping().to_vec(), self.axes())
    }
}

/// A list of the axes' names as Python writes it.
fn names(axes: &[String]) -> String {
    let quoted: Vec<_> =
        axes.iter().map(|name| format!("'{}'", name.replace('\\', "\\\\").replace('\'', "\\'"))).collect();
    format!("[{}]", quoted.join(", "))
}

/// The operator at a robot's handle: a hand, an arm, another robot. All zero is a free handle.
///
/// Parameters
/// ----------
/// mass : float or sequence of float
///     Mass that moves with the handle, kg.
/// damping : float or sequence of float
///     Viscous damping to the ground, N·s/m.
/// stiffness : float or sequence of float
///     Stiffness to the ground, N/m.
///
/// A single number applies to every axis of the dyad.
///
/// Raises
/// ------
/// InvalidInput
///     If a value is negative, not finite or out of range, or lengths differ.
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> ts.Operator(stiffness=120.0)
/// Operator(mass=0.0, damping=0.0, stiffness=120.0)
#[pyclass(frozen, eq, module = "telespring")]
#[derive(Debug, Clone, PartialEq)]
pub struct Operator {
    mass: PerAxis,
    damping: PerAxis,
    stiffness: PerAxis,
}

impl Operator {
    /// The Python operator on a dyad with that many axes.
    pub fn on(&self, axes: usize) -> telespring::Result<telespring::Operator> {
        let values = [("mass", &self.mass), ("damping", &self.damping), ("stiffness", &self.stiffness)];
        for (name, values) in values {
            if let Some(count) = values.count().filter(|&count| count != axes) {
                return Err(InvalidInput::new(
                    name,
                    format!("{count} value(s)"),
                    format!("one value per axis is required, that is {axes}"),
                    "Give one value per axis, or a single number for all of them.",
                ));
            }
        }
        telespring::Operator::new(self.mass.on(axes), self.damping.on(axes), self.stiffness.on(axes))
    }

    /// The values of a Python operator as an array.
    fn array<'py>(&self, py: Python<'py>, values: &PerAxis) -> Bound<'py, PyArray1<f64>> {
        values.on(self.count()).to_pyarray(py)
    }

    /// How many axes the Python operator was written for: 1 if all values are single numbers.
    pub fn count(&self) -> usize {
        [&self.mass, &self.damping, &self.stiffness].iter().find_map(|v| v.count()).unwrap_or(1)
    }
}

impl From<&telespring::Operator> for Operator {
    /// The Python operator with the values of one of the core.
    fn from(operator: &telespring::Operator) -> Self {
        Self {
            mass: PerAxis::Each(operator.mass().to_vec()),
            damping: PerAxis::Each(operator.damping().to_vec()),
            stiffness: PerAxis::Each(operator.stiffness().to_vec()),
        }
    }
}

#[pymethods]
impl Operator {
    #[new]
    #[pyo3(signature = (mass=Argument::Given(PerAxis::All(0.0)), damping=Argument::Given(PerAxis::All(0.0)), stiffness=Argument::Given(PerAxis::All(0.0))),
           text_signature = "(mass=0.0, damping=0.0, stiffness=0.0)")]
    fn new(
        mass: Argument<PerAxis>,
        damping: Argument<PerAxis>,
        stiffness: Argument<PerAxis>,
    ) -> Outcome<Self> {
        let operator = Self {
            mass: mass.named("mass")?,
            damping: damping.named("damping")?,
            stiffness: stiffness.named("stiffness")?,
        };
        operator.on(operator.count())?;
        Ok(operator)
    }

    /// Mass that moves with the handle, kg; one value for a single number.
    #[getter]
    fn mass<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.array(py, &self.mass)
    }

    /// Viscous damping to the ground, N·s/m; one value for a single number.
    #[getter]
    fn damping<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.array(py, &self.damping)
    }

    /// Stiffness to the ground, N/m; one value for a single number.
    #[getter]
    fn stiffness<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.array(py, &self.stiffness)
    }

    pub(crate) fn __repr__(&self) -> String {
        format!(
            "Operator(mass={}, damping={}, stiffness={})",
            self.mass.text(),
            self.damping.text(),
            self.stiffness.text()
        )
    }

    fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
        hash(self.__getnewargs__(py)?.as_any())
    }

    fn __getnewargs__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(
            py,
            [self.mass.to_python(py)?, self.damping.to_python(py)?, self.stiffness.to_python(py)?],
        )
    }
}

/// Two robots, their operators, and the damper in parallel with the virtual spring.
///
/// Parameters
/// ----------
/// robot1, robot2 : Robot
///     Two robots with the same axes.
/// operators : pair of Operator or None, optional
///     The operator at each handle; None is a free handle, for one or for both.
/// coupling_damping : float, optional
///     A damper in parallel with the virtual spring, subject to the same delay, N·s/m.
///
/// Raises
/// ------
/// InvalidInput
///     If axes do not match or the coupling damping is negative or not finite.
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> robot = ts.Robot(mass=1.0, damping=4.0)
/// >>> ts.Dyad(robot, robot, operators=(None, ts.Operator(stiffness=120.0))).operators[1].stiffness
/// array([120.])
#[pyclass(frozen, eq, module = "telespring")]
#[derive(Debug, Clone, PartialEq)]
pub struct Dyad(pub telespring::Dyad);

#[pymethods]
impl Dyad {
    #[new]
    #[pyo3(signature = (robot1, robot2, operators=Argument::Given(None), coupling_damping=Number::Given(0.0)), text_signature = "(robot1, robot2, operators=None, coupling_damping=0.0)")]
    fn new(
        robot1: Argument<Bound<'_, Robot>>,
        robot2: Argument<Bound<'_, Robot>>,
        operators: Argument<Option<[Option<Bound<'_, Operator>>; 2]>>,
        coupling_damping: Number,
    ) -> Outcome<Self> {
        let coupling_damping = coupling_damping.named("coupling_damping")?;
        let robot1 = robot1.named("robot1")?.get().0.clone();
        let robot2 = robot2.named("robot2")?.get().0.clone();
        let axes = robot1.axes().len();
        let lower = |operator: Option<Bound<'_, Operator>>| match operator {
            Some(operator) => operator.get().on(axes),
            None => Ok(telespring::Operator::free(axes)),
        };
        let operators = match operators.named("operators")? {
            Some([first, second]) => Some([
                lower(first).map_err(|refusal| refusal.within("operators[0]"))?,
                lower(second).map_err(|refusal| refusal.within("operators[1]"))?,
            ]),
            None => None,
        };
        Ok(Self(telespring::Dyad::new(robot1, robot2, operators, coupling_damping)?))
    }

    /// Both robots of the Python dyad.
    #[getter]
    fn robots(&self) -> (Robot, Robot) {
        let [first, second] = self.0.robots();
        (Robot(first.clone()), Robot(second.clone()))
    }

    /// Both operators, one value per axis.
    #[getter]
    fn operators(&self) -> (Operator, Operator) {
        let [first, second] = self.0.operators();
        (first.into(), second.into())
    }

    /// The damper in parallel with the virtual spring, N·s/m.
    #[getter]
    fn coupling_damping(&self) -> f64 {
        self.0.coupling_damping()
    }

    /// The names of the dyad's axes as a list.
    #[getter]
    fn axes(&self) -> Vec<String> {
        self.0.axis_names().to_vec()
    }

    /// One axis as a delay system with the states x1, v1, x2, v2 (m, m/s).
    ///
    /// Robot 1 feels its partner's state of one backward delay ago, robot 2 that of one forward delay ago.
    ///
    /// Parameters
    /// ----------
    /// stiffness : float
    ///     Stiffness of the virtual spring, N/m.
    /// delay : float or (float, float)
    ///     One-way delay, s, or the pair (forward, backward).
    /// axis : int or str
    ///     The axis by its index or its name.
    /// predictor : {"hold", "linear", "kalman", "shared-target"} or mapping
    ///     What predicts the partner's motion, as for `telespring.maximum_stiffness`. A Kalman filter adds its estimates
    ///     to the states, two or three per side.
    ///
    /// Returns
    /// -------
    /// DelaySystem
    ///     With two free handles s = 0 is one of its roots.
    ///
    /// Raises
    /// ------
    /// InvalidInput
    ///     If a value is out of its range.
    ///
    /// Examples
    /// --------
    /// >>> import telespring as ts
    /// >>> dyad = ts.Dyad(ts.Robot(1.0, 4.0), ts.Robot(2.0, 4.0))
    /// >>> delay, matrix = dyad.delay_system(10.0, (0.1, 0.2)).delayed[0]
    /// >>> delay, float(matrix[3, 0])  # robot 2 is pulled towards x1(t - 0.1)
    /// (0.1, 5.0)
    #[pyo3(signature = (stiffness, delay, axis=AxisChoice::FIRST, *, predictor=None),
           text_signature = "($self, stiffness, delay, axis=0, *, predictor='hold')")]
    fn delay_system(
        &self,
        stiffness: Number,
        delay: DelayChoice,
        axis: AxisChoice,
        predictor: Option<&Bound<'_, PyAny>>,
    ) -> Outcome<DelaySystem> {
        let (axis, delay) = (axis.of(&self.0)?, delay.check()?);
        let stiffness = stiffness.named("stiffness")?;
        Ok(DelaySystem(match predictor {
            None => axis.delay_system(stiffness, &delay)?,
            Some(predictor) => {
                axis.predicted_delay_system(stiffness, &delay, &read_prediction(predictor)?)?
            }
        }))
    }

    fn __repr__(&self) -> String {
        let ((robot1, robot2), (first, second)) = (self.robots(), self.operators());
        format!(
            "Dyad({}, {}, operators=({}, {}), coupling_damping={:?})",
            robot1.__repr__(),
            robot2.__repr__(),
            first.__repr__(),
            second.__repr__(),
            self.0.coupling_damping()
        )
    }

    fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
        hash(self.__getnewargs__().into_pyobject(py)?.as_any())
    }

    fn __getnewargs__(&self) -> (Robot, Robot, (Operator, Operator), f64) {
        let (robot1, robot2) = self.robots();
        (robot1, robot2, self.operators(), self.coupling_damping())
    }

    /// One axis of the dyad by name or index, operators added to the robots.
    ///
    /// Parameters
    /// ----------
    /// axis : int or str
    ///     The axis by its index or its name.
    ///
    /// Returns
    /// -------
    /// DyadAxis
    ///     With the criteria and the spectrum as methods; ``dyad["x"]`` is the same.
    ///
    /// Raises
    /// ------
    /// InvalidInput
    ///     If the dyad has no such axis.
    ///
    /// Examples
    /// --------
    /// >>> import telespring as ts
    /// >>> round(ts.hman().axis("x").critical_stiffness(), 6)
    /// 35.615988
    /// >>> dyad = ts.hman()
    /// >>> [round(dyad[name].maximum_delay(71.2), 4) for name in dyad.axes]
    /// [0.1673, 0.232]
    fn axis(&self, axis: AxisChoice) -> Outcome<DyadAxis> {
        let index = axis.index(&self.0)?;
        Ok(DyadAxis { name: self.0.axis_names()[index].clone(), index, axis: self.0.axis(index)? })
    }

    fn __getitem__(&self, axis: AxisChoice) -> Outcome<DyadAxis> {
        self.axis(axis)
    }

    fn __len__(&self) -> usize {
        self.0.axis_names().len()
    }

    fn __contains__(&self, name: Argument<String>) -> bool {
        matches!(name, Argument::Given(name) if self.0.axis_names().contains(&name))
    }

    /// The dyad's numbers as a dict that `json.dumps` takes.
    pub fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let out = PyDict::new(py);
        let axes = (0..self.0.axis_names().len()).map(|index| -> PyResult<_> {
            let axis = PyDict::new(py);
            axis.set_item("axis", &self.0.axis_names()[index])?;
            for (number, robot) in self.0.robots().iter().enumerate() {
                axis.set_item(format!("mass{}", number + 1), robot.mass()[index])?;
                axis.set_item(format!("damping{}", number + 1), robot.damping()[index])?;
            }
            for (number, operator) in self.0.operators().iter().enumerate() {
                axis.set_item(format!("operator_mass{}", number + 1), operator.mass()[index])?;
                axis.set_item(format!("operator_damping{}", number + 1), operator.damping()[index])?;
                axis.set_item(format!("operator_stiffness{}", number + 1), operator.stiffness()[index])?;
            }
            Ok(axis)
        });
        out.set_item("axes", axes.collect::<PyResult<Vec<_>>>()?)?;
        out.set_item("coupling_damping", self.0.coupling_damping())?;
        Ok(out)
    }

    fn _repr_html_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        html_table("Dyad", self.to_dict(py)?.as_any())
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> Outcome<Bound<'py, PyIterator>> {
        let axes = self.0.axis_names().iter().map(|name| self.axis(AxisChoice::named(name)));
        PyList::new(py, axes.collect::<Outcome<Vec<_>>>()?)?.try_iter().map_err(Into::into)
    }
}

/// The two H-MANs of Du, Kulkarni, Kager and Campolo (Table III) as a dyad with free handles.
///
/// Returns
/// -------
/// Dyad
///
/// Examples
/// --------
/// >>> import telespring as ts
/// >>> ts.hman().axes
/// ['x', 'y']
#[pyfunction]
pub fn hman() -> Dyad {
    Dyad(telespring::hman())
}
