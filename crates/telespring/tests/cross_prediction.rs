//! Verdicts of prediction, against the roots of a delay system, the live predictors, and time simulation.

#![allow(clippy::disallowed_macros, reason = "the tests print what they measure")]

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use telespring::criteria::{
    maximum_delay, maximum_stiffness, predicted_maximum_delay, predicted_maximum_stiffness,
    predicted_stability_map, predicted_unstable_root_count, unstable_root_count,
};
use telespring::prediction::Prediction;
use telespring::session::architecture::{KalmanDesign, PredictorDesign};
use telespring::session::predictor::{
    Hold, Kalman, Linear, MotionModel, Noise, Played, Predictor, SharedTarget,
};
use telespring::session::{Motion, PeerTime, Span};
use telespring::{Delay, DyadAxis, hman};

const MODELS: [MotionModel; 2] = [MotionModel::ConstantVelocity, MotionModel::ConstantAcceleration];

/// A filter with this cut-off frequency (rad/s) at this sample period (s).
fn kalman(model: MotionModel, cutoff: f64, sample_period: f64) -> Prediction {
    let power = if model == MotionModel::ConstantVelocity { 4 } else { 6 };
    let position = 1e-4;
    let process = cutoff.powi(power) * position * position * sample_period;
    let design = KalmanDesign { model, noise: Noise { process, position } };
    Prediction::new(PredictorDesign::Kalman(design), sample_period).unwrap()
}

fn linear() -> Prediction {
    Prediction::new(PredictorDesign::Linear, 1e-3).unwrap()
}

fn unchanged() -> [Prediction; 2] {
    [PredictorDesign::Hold, PredictorDesign::SharedTarget]
        .map(|predictor| Prediction::new(predictor, 1e-3).unwrap())
}

fn kinds(cutoff: f64) -> [Prediction; 3] {
    [linear(), kalman(MODELS[0], cutoff, 1e-3), kalman(MODELS[1], cutoff, 1e-3)]
}

/// A random axis, half of them with operators and a coupling damper.
fn random_axis(random: &mut ChaCha8Rng) -> DyadAxis {
    let mut spread = |low: f64, high: f64| low * (high / low).powf(random.random_range(0.0..1.0));
    let [m1, m2] = [(); 2].map(|()| spread(0.3, 5.0));
    let [b1, b2] = [(); 2].map(|()| spread(1.0, 30.0));
    if spread(0.1, 10.0) < 1.0 {
        return DyadAxis::new(m1, b1, m2, b2).unwrap();
    }
    let [h1, h2, c] = [spread(10.0, 500.0), spread(10.0, 500.0), spread(0.1, 5.0)];
    DyadAxis::with_operators(m1, b1, m2, b2, h1, h2, c).unwrap()
}

#[test]
fn cross_the_count_is_that_of_the_roots_of_the_delay_system() {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let mut unstable = 0;
    for _ in 0..60 {
        let axis = random_axis(&mut random);
        let stiffness = 10.0 * 100.0_f64.powf(random.random_range(0.0..1.0));
        let delay = 0.01 * 30.0_f64.powf(random.random_range(0.0..1.0));
        let cutoff = 20.0 * 10.0_f64.powf(random.random_range(0.0..1.0));
        for prediction in kinds(cutoff) {
            let counted = predicted_unstable_root_count(&axis, &prediction, stiffness, delay).unwrap();
            let system = axis
                .predicted_delay_system(stiffness, &Delay::each_way(delay).unwrap(), &prediction)
                .unwrap();
            let spectrum = system.characteristic_roots(counted as usize + 3).unwrap();
            assert!(spectrum.certificate.is_complete(), "{}", spectrum.certificate);
            let found = spectrum.roots.iter().filter(|root| root.re > 1e-9).count();
            assert_eq!(counted as usize, found, "{axis:?}, {prediction:?}, {stiffness}, {delay}");
            unstable += usize::from(counted > 0);
        }
    }
    assert!((40..140).contains(&unstable), "{unstable}");
}

#[test]
fn cross_a_pair_of_roots_is_on_the_axis_at_the_limits_and_at_none_before() {
    let mut random = ChaCha8Rng::seed_from_u64(4);
    for _ in 0..8 {
        let axis = random_axis(&mut random);
        let delay = 0.02 * 12.0_f64.powf(random.random_range(0.0..1.0));
        for prediction in kinds(60.0) {
            let limit = predicted_maximum_stiffness(&axis, &prediction, delay).unwrap();
            let abscissa = |stiffness: f64, age: f64| {
                let delay = Delay::each_way(age).unwrap();
                let system = axis.predicted_delay_system(stiffness, &delay, &prediction).unwrap();
                system.spectral_abscissa_without_zero().value
            };
            assert!(abscissa(limit, delay).abs() < 1e-6, "{axis:?}, {prediction:?}, {delay}: {limit}");
            for share in [0.02, 0.1, 0.3, 0.6, 0.9, 0.999] {
                assert!(abscissa(share * limit, delay) < 0.0, "{axis:?}, {prediction:?}, {share}");
            }
            let longest = predicted_maximum_delay(&axis, &prediction, 0.99 * limit).unwrap();
            assert!(abscissa(0.99 * limit, longest).abs() < 1e-6, "{axis:?}, {prediction:?}: {longest}");
            let map =
                predicted_stability_map(&axis, &prediction, &[0.99 * limit, 1.01 * limit], &[delay]).unwrap();
            assert!(map[0], "{axis:?}, {prediction:?}, {delay}");
        }
    }
}

#[test]
fn law_hold_and_a_shared_target_leave_the_verdicts_as_they_are() {
    let x = hman().axis(0).unwrap();
    for prediction in unchanged() {
        for delay in [0.0, 0.05, 0.2] {
            assert_eq!(predicted_maximum_stiffness(&x, &prediction, delay), maximum_stiffness(&x, delay));
            assert_eq!(
                predicted_unstable_root_count(&x, &prediction, 142.0, delay),
                unstable_root_count(&x, 142.0, delay)
            );
        }
        assert_eq!(predicted_maximum_delay(&x, &prediction, 71.0), maximum_delay(&x, 71.0));
    }
}

/// As the delay goes to 0 the linear prediction has nothing to add; a fast filter predicts as its exact derivatives do.
#[test]
fn law_the_predictors_meet_in_their_limits() {
    let x = hman().axis(0).unwrap();
    let hold = maximum_stiffness(&x, 1e-6).unwrap();
    let at =
        |prediction: &Prediction, delay: f64| predicted_maximum_stiffness(&x, prediction, delay).unwrap();
    // a shorter delay leaves less to predict, but also a higher crossing: what is gained is a fixed share
    assert!(hold > 1e5 && at(&linear(), 1e-6) > hold, "{hold}");
    assert_eq!(at(&linear(), 0.0), f64::INFINITY);
    for delay in [0.05, 0.12, 0.3] {
        let [slow, fast] = [1e2, 1e5].map(|cutoff| at(&kalman(MODELS[0], cutoff, 1e-6), delay));
        let linear = at(&linear(), delay);
        assert!((fast / linear - 1.0).abs() < 1e-3, "{delay}: {fast} {linear}");
        assert!((slow / linear - 1.0).abs() > 1e-3, "{delay}: {slow} {linear}");
    }
}

/// The live predictor of a prediction.
fn live(prediction: &Prediction) -> Box<dyn Predictor> {
    match prediction.predictor() {
        PredictorDesign::Kalman(KalmanDesign { model, noise }) => {
            Box::new(Kalman::new(model, noise).unwrap())
        }
        _ => Box::new(Linear),
    }
}

/// The amplitude and phase with which a live predictor answers a wave of one frequency, over those of the wave itself.
fn measured_response(
    predictor: &mut dyn Predictor,
    frequency: f64,
    age: f64,
    period: f64,
) -> num_complex::Complex64 {
    let (mut sum, mut own) = (num_complex::Complex64::ZERO, 0.0);
    let wave = |time: f64| Motion {
        position: [(frequency * time).cos(), (frequency * time).sin()],
        velocity: [-frequency * (frequency * time).sin(), frequency * (frequency * time).cos()],
    };
    let settled = 2000;
    let whole = (10.0 * std::f64::consts::TAU / frequency / period).round() as usize;
    for n in 0..settled + whole {
        let now = n as f64 * period + age;
        let played = Played {
            motion: wave(now - age),
            time: PeerTime::from_seconds(now - age),
            age: Span::from_seconds(age),
            held: false,
        };
        let [re, im] = predictor.predict(&played, None).position;
        if n >= settled {
            // position on both axes is one complex number that turns
            sum += num_complex::Complex64::new(re, im)
                * num_complex::Complex64::from_polar(1.0, -frequency * now);
            own += 1.0;
        }
    }
    sum / own
}

#[test]
fn cross_the_live_predictors_answer_as_the_theory_says() {
    let (age, period) = (0.1, 1e-3);
    for frequency in [3.0, 10.0, 30.0, 60.0] {
        let check = |predictor: &mut dyn Predictor, prediction: &Prediction, tolerance: f64| {
            let measured = measured_response(predictor, frequency, age, period);
            let expected = prediction.response(frequency, age);
            assert!(
                (measured - expected).norm() < tolerance * expected.norm(),
                "{prediction:?} at {frequency} rad/s: {measured} instead of {expected}"
            );
        };
        check(&mut Hold, &unchanged()[0], 1e-6);
        check(&mut SharedTarget, &unchanged()[1], 1e-6);
        check(&mut Linear, &linear(), 1e-6);
        for model in MODELS {
            for cutoff in [50.0, 300.0] {
                let prediction = kalman(model, cutoff, period);
                // the sampled filter has seen the latest sample: it is half a period ahead of the continuous one
                check(&mut *live(&prediction), &prediction, 0.01 + 0.5 * frequency * period);
            }
        }
    }
}

/// How much the distance between two robots grows from 6 s to 16 s, under springs that predict; the force is held for one
/// period, and each robot moves exactly.
fn growth(
    axis: &DyadAxis,
    stiffness: f64,
    delay: f64,
    predictors: &mut [Box<dyn Predictor>; 2],
    period: f64,
) -> f64 {
    let lag = (delay / period).round() as usize;
    let ticks = (16.0 / period) as usize;
    let mut states = [[0.01, 0.0], [-0.01, 0.0]];
    let mut past: Vec<[[f64; 2]; 2]> = Vec::new();
    let mut largest = [0.0_f64; 2];
    for n in 0..ticks {
        past.push(states);
        let old = past[n.saturating_sub(lag)];
        let forces = [0, 1].map(|own: usize| {
            let [position, velocity] = old[1 - own];
            let time = n as f64 * period;
            let played = Played {
                motion: Motion { position: [position, 0.0], velocity: [velocity, 0.0] },
                time: PeerTime::from_seconds(10.0 + time - delay),
                age: Span::from_seconds(delay),
                held: false,
            };
            stiffness * (predictors[own].predict(&played, None).position[0] - states[own][0])
        });
        for ((state, force), side) in states.iter_mut().zip(forces).zip(&axis.sides) {
            // m x″ + b x′ = F
            let (rate, last) = (side.damping / side.mass, force / side.damping);
            let decay = (-rate * period).exp();
            let moved = state[1] - last;
            *state = [state[0] + last * period + moved * (1.0 - decay) / rate, last + moved * decay];
        }
        let seconds = n as f64 * period;
        if seconds >= 6.0 {
            let half = usize::from(seconds >= 11.0);
            largest[half] = largest[half].max((states[0][0] - states[1][0]).abs());
        }
        if !states[0][0].is_finite() || states[0][0].abs() > 1e3 {
            return f64::INFINITY;
        }
    }
    largest[1] / largest[0]
}

#[test]
fn cross_simulated_springs_that_predict_diverge_above_the_limit_only() {
    let axis = hman().axis(0).unwrap();
    let period = 2.5e-4;
    for delay in [0.05, 0.12, 0.25] {
        for prediction in [
            linear(),
            kalman(MODELS[0], 60.0, period),
            kalman(MODELS[1], 60.0, period),
            kalman(MODELS[1], 200.0, period),
        ] {
            let limit = predicted_maximum_stiffness(&axis, &prediction, delay).unwrap();
            let run = |share: f64| {
                let mut predictors = [(); 2].map(|()| live(&prediction));
                growth(&axis, share * limit, delay, &mut predictors, period)
            };
            let (below, above) = (run(0.93), run(1.07));
            println!("{prediction:?}, {delay} s: {limit:.1} N/m, {below:.3} below, {above:.3} above");
            assert!(below < 1.0 && above > 1.0, "{prediction:?}, {delay} s: {limit} N/m, {below}, {above}");
        }
    }
}

#[test]
fn law_what_the_theory_cannot_say_is_refused() {
    let field = |model, process, position, sample_period| {
        let design = KalmanDesign { model, noise: Noise { process, position } };
        Prediction::new(PredictorDesign::Kalman(design), sample_period).map_err(|error| error.field)
    };
    // a cut-off of 999 and 1001 rad/s at 1 kHz
    assert!(field(MODELS[1], 999.0_f64.powi(6) * 1e-11, 1e-4, 1e-3).is_ok());
    assert_eq!(field(MODELS[1], 1001.0_f64.powi(6) * 1e-11, 1e-4, 1e-3).unwrap_err(), "predictor.position");
    assert_eq!(field(MODELS[0], 0.0, 1e-4, 1e-3).unwrap_err(), "process");
    assert_eq!(field(MODELS[0], 1.0, f64::NAN, 1e-3).unwrap_err(), "position");
    assert_eq!(field(MODELS[0], 1.0, 1e-4, 0.0).unwrap_err(), "sample_period");
}
