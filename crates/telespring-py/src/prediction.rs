//! Predictors: as arguments of the criteria, on recorded motion, and the noise fitted to it.

use numpy::{IntoPyArray, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyMapping, PyString};
use telespring::InvalidInput;
use telespring::prediction::Prediction;
use telespring::session::architecture::{KalmanDesign, PredictorDesign};
use telespring::session::predictor::{
    FitEnd, Hold, Kalman, Linear, MotionModel, Noise, Played, Predictor, SharedTarget, SharedTargetView,
};
use telespring::session::{Motion, PeerTime, Span};

use crate::arguments::{Argument, Number, rows, written};
use crate::arrays::Numbers;
use crate::errors::Outcome;
use crate::interrupt::apart;
use crate::records::record;

/// The time between two samples if nothing else is said, s: that of the laboratory and of the live session.
const SAMPLE_PERIOD: f64 = 1e-3;

/// The refusal of what is no predictor.
fn no_predictor(field: &str, text: String) -> InvalidInput {
    let words = PredictorDesign::KINDS.map(|word| format!("{word:?}")).join(", ");
    InvalidInput::new(
        field,
        text,
        format!("a predictor is one of {words}"),
        "Write the word, or for a Kalman filter {\"kind\": \"kalman\", \"model\": \"constant-velocity\", \
         \"process\": 1.0, \"position\": 1e-4}.",
    )
}

/// A motion model by its word.
fn motion_model(field: &str, value: &Bound<'_, PyAny>) -> Outcome<MotionModel> {
    let word = value.cast::<PyString>().ok().map(|word| word.to_string());
    Ok(word.as_deref().and_then(MotionModel::of_word).ok_or_else(|| {
        InvalidInput::new(
            field,
            written(value),
            format!("the models are {:?} and {:?}", MotionModel::WORDS[0], MotionModel::WORDS[1]),
            "Choose one of them.",
        )
    })?)
}

/// A predictor as its word or as a table with its settings, and the time between its samples, s.
fn read_design(value: &Bound<'_, PyAny>) -> Outcome<(PredictorDesign, f64)> {
    if let Ok(word) = value.cast::<PyString>() {
        let design = PredictorDesign::of_kind(word.to_str()?);
        return Ok((design.ok_or_else(|| no_predictor("predictor", written(value)))?, SAMPLE_PERIOD));
    }
    let Ok(table) = value.cast::<PyMapping>() else {
        return Err(no_predictor("predictor", written(value)).into());
    };
    let Ok(kind) = table.get_item("kind") else {
        return Err(no_predictor("predictor.kind", "missing".to_owned()).into());
    };
    let word = kind.cast::<PyString>().ok().map(|word| word.to_string());
    let design = word.as_deref().and_then(PredictorDesign::of_kind);
    let mut design = design.ok_or_else(|| no_predictor("predictor.kind", written(&kind)))?;
    let has_settings = matches!(design, PredictorDesign::Kalman(_));
    let mut sample_period = SAMPLE_PERIOD;
    for item in table.items()?.iter() {
        let (key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>) = item.extract()?;
        let key = key.str()?.to_string();
        let field = format!("predictor.{key}");
        let Ok(number) = value.extract::<Number>();
        match (key.as_str(), &mut design) {
            ("kind", _) => {}
            ("model", PredictorDesign::Kalman(filter)) => filter.model = motion_model(&field, &value)?,
            ("process", PredictorDesign::Kalman(filter)) => filter.noise.process = number.named(&field)?,
            ("position", PredictorDesign::Kalman(filter)) => filter.noise.position = number.named(&field)?,
            ("sample_period", PredictorDesign::Kalman(_)) => sample_period = number.named(&field)?,
            _ => {
                let allowed = if has_settings {
                    "a Kalman filter has the settings kind, model, process, position and sample_period"
                } else {
                    "only a Kalman filter has settings besides its kind"
                };
                return Err(InvalidInput::new(field, written(&value), allowed, "Leave it out.").into());
            }
        }
    }
    Ok((design, sample_period))
}

/// A predictor as a part of the loop.
pub fn read_prediction(value: &Bound<'_, PyAny>) -> Outcome<Prediction> {
    let (design, sample_period) = read_design(value)?;
    Ok(Prediction::new(design, sample_period).map_err(in_predictor)?)
}

/// The refusal of a setting of a predictor, named by its place in the argument.
fn in_predictor(mut error: InvalidInput) -> InvalidInput {
    if !error.field.starts_with("predictor") {
        error.field = format!("predictor.{}", error.field);
    }
    error
}

/// Takes `predictor` out of the keywords of a criterion; `None` if the loop stays as it is.
pub fn take_predictor<'py>(
    kwargs: Option<&Bound<'py, PyDict>>,
) -> Outcome<(Option<Prediction>, Option<Bound<'py, PyDict>>)> {
    let Some(kwargs) = kwargs else { return Ok((None, None)) };
    let Some(value) = kwargs.get_item("predictor")? else { return Ok((None, Some(kwargs.clone()))) };
    let rest = kwargs.copy()?;
    rest.del_item("predictor")?;
    let prediction = read_prediction(&value)?;
    let is_unchanged =
        matches!(prediction.predictor(), PredictorDesign::Hold | PredictorDesign::SharedTarget);
    Ok(((!is_unchanged).then_some(prediction), Some(rest)))
}

record! {
    /// The noise of a Kalman filter, fitted to recorded motion.
    NoiseFit {
        /// "constant-velocity" or "constant-acceleration".
        model: String,
        /// Spectral density of the white acceleration, m²/s³, or of the white jerk, m²/s⁵.
        process: f64,
        /// Standard deviation of a measured position, m.
        position: f64,
        /// Logarithmic likelihood: larger by some units means a better model of the same record.
        log_likelihood: f64,
        /// "maximum"; "no measurement noise" or "no process noise" if the record does not tell that noise from none.
        end: String,
    }
}

/// Fit the noise of a Kalman filter to recorded motion by maximum likelihood.
///
/// The likelihood is that of predictions over one step of the record. Over an age of many steps another noise may
/// predict better: `telespring.compare_predictors` shows the errors.
///
/// Parameters
/// ----------
/// times : array_like, (n,)
///     Times of the samples, s, rising; they need not be regular.
/// positions : array_like, (n, 2)
///     Positions on both axes, m.
/// model : {"constant-acceleration", "constant-velocity"}
///     What the filter takes for constant except for white noise.
///
/// Returns
/// -------
/// NoiseFit
///     Process and position noise, their likelihood, and how the fit ended.
///
/// Raises
/// ------
/// InvalidInput
///     If there are fewer than 20 samples, the times do not rise, a value is not finite, or nothing moves.
///
/// References
/// ----------
/// Y. Bar-Shalom, X. R. Li, T. Kirubarajan, *Estimation with Applications to Tracking and Navigation*, 2001, 6.2.
///
/// Examples
/// --------
/// >>> import numpy as np, telespring as ts
/// >>> t = np.arange(4000) * 0.005
/// >>> circle = 0.05 * np.column_stack([np.cos(3 * t), np.sin(3 * t)])
/// >>> fit = ts.fit_noise(t, circle.round(4))  # a sensor with steps of 0.1 mm
/// >>> fit.end, round(fit.position, 5)  # m; a step of 0.1 mm divided by √12 is 29 µm
/// ('maximum', 3e-05)
#[pyfunction]
#[pyo3(signature = (times, positions, model=None),
       text_signature = "(times, positions, model='constant-acceleration')")]
pub fn fit_noise(
    py: Python<'_>,
    times: &Bound<'_, PyAny>,
    positions: &Bound<'_, PyAny>,
    model: Option<&Bound<'_, PyAny>>,
) -> Outcome<NoiseFit> {
    let model = model.map_or(Ok(MotionModel::ConstantAcceleration), |model| motion_model("model", model))?;
    let times = Numbers::read("times", times)?.row()?;
    let positions = rows("positions", positions)?;
    let fit = apart(py, move || telespring::session::predictor::fit_noise(model, &times, &positions))??;
    let end = match fit.end {
        FitEnd::Maximum => "maximum",
        FitEnd::NoMeasurementNoise => "no measurement noise",
        FitEnd::NoProcessNoise => "no process noise",
    };
    Ok(NoiseFit {
        model: model.word().to_owned(),
        process: fit.noise.process,
        position: fit.noise.position,
        log_likelihood: fit.log_likelihood,
        end: end.to_owned(),
    })
}

/// The live predictor of a design.
fn live(design: PredictorDesign) -> telespring::Result<Box<dyn Predictor + Send>> {
    Ok(match design {
        PredictorDesign::Hold => Box::new(Hold),
        PredictorDesign::Linear => Box::new(Linear),
        PredictorDesign::Kalman(KalmanDesign { model, noise: Noise { process, position } }) => {
            Box::new(Kalman::new(model, Noise { process, position })?)
        }
        PredictorDesign::SharedTarget => Box::new(SharedTarget),
    })
}

/// Predict recorded motion over one age by a live predictor, sample by sample.
///
/// Parameters
/// ----------
/// times : array_like, (n,)
///     Times of the samples, s, rising.
/// positions, velocities : array_like, (n, 2)
///     Motion on both axes, m and m/s.
/// age : float
///     How far ahead, s.
/// predictor : str or mapping
///     As for `telespring.maximum_stiffness`.
/// targets : pair of array_like, (n, 2), optional
///     The target that both sides show at the times of the samples and one age later, for "shared-target".
///
/// Returns
/// -------
/// ndarray, (n, 2)
///     For every sample the position predicted for one age later, m.
#[pyfunction]
#[pyo3(signature = (times, positions, velocities, age, predictor, targets=None))]
pub fn predict_motion<'py>(
    py: Python<'py>,
    times: &Bound<'py, PyAny>,
    positions: &Bound<'py, PyAny>,
    velocities: &Bound<'py, PyAny>,
    age: Argument<f64>,
    predictor: &Bound<'py, PyAny>,
    targets: Option<(Bound<'py, PyAny>, Bound<'py, PyAny>)>,
) -> Outcome<Bound<'py, PyArray2<f64>>> {
    let times = Numbers::read("times", times)?.row()?;
    let positions = rows("positions", positions)?;
    let velocities = rows("velocities", velocities)?;
    let age = telespring::quantity::DELAY.check("age", age.named("age")?)?;
    let targets =
        targets.map(|(then, now)| Outcome::Ok((rows("targets[0]", &then)?, rows("targets[1]", &now)?)));
    let targets = targets.transpose()?;
    let (then, now) = targets.unwrap_or_default();
    let lengths = [times.len(), velocities.len()];
    let has_targets = !then.is_empty();
    if lengths != [positions.len(); 2] || (has_targets && [then.len(), now.len()] != [positions.len(); 2]) {
        return Err(InvalidInput::new(
            "positions",
            format!("{} positions at {} times", positions.len(), times.len()),
            "every time needs one position, velocity and target",
            "Give arrays of the same length.",
        )
        .into());
    }
    let (design, _) = read_design(predictor)?;
    let mut predictor = live(design).map_err(in_predictor)?;
    let predicted = apart(py, move || {
        let mut predicted = Vec::with_capacity(2 * times.len());
        for (n, &time) in times.iter().enumerate() {
            let played = Played {
                motion: Motion { position: positions[n], velocity: velocities[n] },
                time: PeerTime::from_seconds(time - times[0]),
                age: Span::from_seconds(age),
                held: false,
            };
            let at = |position| Motion { position, velocity: [0.0; 2] };
            let view = has_targets.then(|| SharedTargetView { now: at(now[n]), then: at(then[n]) });
            predicted.extend(predictor.predict(&played, view.as_ref()).position);
        }
        predicted
    })?;
    let shape = [predicted.len() / 2, 2];
    Ok(predicted.into_pyarray(py).reshape(shape)?)
}
