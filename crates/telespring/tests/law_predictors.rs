//! Laws of the predictors, and the Kalman filter against all samples at once.

use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use telespring::session::predictor::{
    FitEnd, Hold, Kalman, Linear, MotionModel, Noise, Played, Predictor, SharedTarget, SharedTargetView,
    fit_noise,
};
use telespring::session::{Motion, PeerTime, Span};

fn played(time: f64, age: f64, position: [f64; 2], velocity: [f64; 2]) -> Played {
    Played {
        motion: Motion { position, velocity },
        time: PeerTime::from_seconds(time),
        age: Span::from_seconds(age),
        held: false,
    }
}

#[test]
fn ref_a_straight_motion_is_predicted_exactly() {
    let at = |time: f64| [0.1 + 0.3 * time, -0.2 * time];
    let noise = Noise { process: 1.0, position: 1e-6 };
    let mut filters = [MotionModel::ConstantVelocity, MotionModel::ConstantAcceleration]
        .map(|model| Kalman::new(model, noise).unwrap());
    for n in 0..200 {
        let time = 1e-3 * f64::from(n);
        let played = played(time, 0.1, at(time), [0.3, -0.2]);
        let expected = at(time + 0.1);
        let check = |predicted: Motion, tolerance: f64| {
            for axis in 0..2 {
                assert!((predicted.position[axis] - expected[axis]).abs() < tolerance, "{n}: {predicted:?}");
            }
        };
        check(Linear.predict(&played, None), 1e-15);
        for filter in &mut filters {
            check(filter.predict(&played, None), 1e-8);
        }
        assert_eq!(Hold.predict(&played, None), played.motion);
    }
}

#[test]
fn ref_a_held_motion_is_carried_on_by_its_age() {
    let mut filter =
        Kalman::new(MotionModel::ConstantVelocity, Noise { process: 1.0, position: 1e-6 }).unwrap();
    for n in 0..100 {
        let time = 1e-2 * f64::from(n);
        filter.predict(&played(time, 0.05, [0.5 * time, 0.0], [0.5, 0.0]), None);
    }
    // the same sample again, and one that was overtaken: both say where the partner is now
    for (time, age) in [(0.99, 0.35), (0.95, 0.39)] {
        let predicted = filter.predict(&played(time, age, [0.5 * time, 0.0], [0.5, 0.0]), None);
        assert!((predicted.position[0] - 0.5 * 1.34).abs() < 1e-6, "{predicted:?}");
    }
}

/// A constant error of the clock offset moves "then" along the target: the prediction is wrong by at most the error times
/// the largest speed of the target.
#[test]
fn law_the_shared_target_is_exact_up_to_the_offset_of_the_clocks() {
    let target = |time: f64| Motion {
        position: [0.05 * (2.0 * time).sin(), 0.1 * time.sin()],
        velocity: [0.1 * (2.0 * time).cos(), 0.1 * time.cos()],
    };
    let speed = 0.1 * 2.0_f64.sqrt();
    for offset in [0.0, 0.002, -0.01] {
        let mut worst = 0.0_f64;
        for n in 0..2000 {
            let (then, age) = (5e-3 * f64::from(n), 0.2);
            let away = [0.01, -0.02];
            let partner = target(then).position;
            let sample =
                played(then, age, [partner[0] + away[0], partner[1] + away[1]], target(then).velocity);
            let view = SharedTargetView { now: target(then + age), then: target(then + offset) };
            let predicted = SharedTarget.predict(&sample, Some(&view)).position;
            let truth = target(then + age).position;
            worst = worst.max((predicted[0] - truth[0] - away[0]).hypot(predicted[1] - truth[1] - away[1]));
        }
        assert!(
            worst <= speed * offset.abs() + 1e-15 && worst >= 0.95 * speed * offset.abs(),
            "{offset}: {worst}"
        );
    }
    let sample = played(0.0, 0.1, [0.3, 0.4], [0.0; 2]);
    assert_eq!(SharedTarget.predict(&sample, None), sample.motion);
}

/// The best linear estimate from all samples at once: states at all sample times are jointly normal.
fn batch_estimate(
    model: MotionModel,
    noise: Noise,
    times: &[f64],
    positions: &[f64],
    velocity: f64,
    at: f64,
) -> f64 {
    let acceleration = if model == MotionModel::ConstantVelocity { 0.0 } else { 100.0 };
    let start = [noise.position.powi(2), 1.0, acceleration];
    let first = times[0];
    // the covariance of the position at two times, given the first sample: that of the start, and of the noise since
    let covariance = |a: f64, b: f64| {
        let (a, b) = (a - first, b - first);
        let (low, high) = (a.min(b), a.max(b));
        let initial = start[0] + start[1] * a * b + start[2] * (a * b).powi(2) / 4.0;
        // ∫₀^low of the two responses to white noise, by Gauss's rule with three points (exact to degree 5)
        let response =
            |time: f64| if model == MotionModel::ConstantVelocity { time } else { 0.5 * time * time };
        let integral: f64 = [(-0.6_f64.sqrt(), 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.6_f64.sqrt(), 5.0 / 9.0)]
            .iter()
            .map(|(node, weight)| {
                let s = 0.5 * low * (1.0 + node);
                0.5 * low * weight * response(low - s) * response(high - s)
            })
            .sum();
        initial + noise.process * integral
    };
    let mean = |time: f64| positions[0] + velocity * (time - first);
    let later = &times[1..];
    let between = DMatrix::from_fn(later.len(), later.len(), |i, j| {
        covariance(later[i], later[j]) + if i == j { noise.position.powi(2) } else { 0.0 }
    });
    let with = DVector::from_fn(later.len(), |i, _| covariance(later[i], at));
    let rest = DVector::from_fn(later.len(), |i, _| positions[i + 1] - mean(later[i]));
    mean(at) + with.dot(&between.lu().solve(&rest).unwrap())
}

#[test]
fn cross_the_kalman_filter_is_the_best_estimate_from_all_samples_at_once() {
    let noise = Noise { process: 0.3, position: 2e-3 };
    let times = [0.0, 0.011, 0.02, 0.034, 0.05, 0.0502, 0.09, 0.13, 0.14, 0.2];
    let positions = times.map(|time: f64| 0.05 * (9.0 * time).sin() + 0.002 * (400.0 * time).cos());
    for model in [MotionModel::ConstantVelocity, MotionModel::ConstantAcceleration] {
        let mut filter = Kalman::new(model, noise).unwrap();
        for (n, (&time, &position)) in times.iter().zip(&positions).enumerate() {
            let predicted =
                filter.predict(&played(time, 0.08, [position, 0.0], [0.4, 0.0]), None).position[0];
            if n == 0 {
                continue;
            }
            let expected = batch_estimate(model, noise, &times[..=n], &positions[..=n], 0.4, time + 0.08);
            assert!((predicted - expected).abs() < 1e-9, "{model:?}, sample {n}: {predicted} {expected}");
        }
    }
}

/// A motion driven by white acceleration or jerk of this density, drawn in steps too small to matter.
fn random_motion(model: MotionModel, noise: Noise, samples: usize, step: f64) -> (Vec<f64>, Vec<[f64; 2]>) {
    let mut random = ChaCha8Rng::seed_from_u64(12);
    let mut draw = || StandardNormal.sample(&mut random);
    let (fine, parts) = (step / 20.0, 20);
    let mut state = [[0.0_f64; 3]; 2];
    let mut positions = Vec::new();
    for _ in 0..samples {
        for _ in 0..parts {
            for [x, v, a] in &mut state {
                let kick: f64 = draw();
                let kick = kick * (noise.process * fine).sqrt();
                let (before, earlier) = (*a, *v);
                match model {
                    MotionModel::ConstantVelocity => *v += kick,
                    MotionModel::ConstantAcceleration => {
                        *a += kick;
                        *v += 0.5 * (before + *a) * fine;
                    }
                }
                *x += 0.5 * (earlier + *v) * fine;
            }
        }
        positions.push(state.map(|[x, _, _]| {
            let error: f64 = draw();
            x + noise.position * error
        }));
    }
    ((0..samples).map(|n| n as f64 * step).collect(), positions)
}

#[test]
fn ref_the_noise_that_made_a_motion_is_found_again() {
    for (model, noise) in [
        (MotionModel::ConstantVelocity, Noise { process: 0.5, position: 1e-4 }),
        (MotionModel::ConstantAcceleration, Noise { process: 20.0, position: 3e-5 }),
    ] {
        let (times, positions) = random_motion(model, noise, 20_000, 0.005);
        let fit = fit_noise(model, &times, &positions).unwrap();
        let ratios = [fit.noise.process / noise.process, fit.noise.position / noise.position];
        assert_eq!(fit.end, FitEnd::Maximum);
        // 40,000 innovations: a standard error of about 1 %
        assert!(ratios.iter().all(|ratio| (ratio - 1.0).abs() < 0.05), "{model:?}: {ratios:?}");
        // the other model explains the record worse
        let other = match model {
            MotionModel::ConstantVelocity => MotionModel::ConstantAcceleration,
            MotionModel::ConstantAcceleration => MotionModel::ConstantVelocity,
        };
        assert!(fit_noise(other, &times, &positions).unwrap().log_likelihood < fit.log_likelihood - 10.0);
    }
}

#[test]
fn law_a_fit_says_how_it_ended_or_what_is_wrong_with_the_record() {
    let times: Vec<f64> = (0..200).map(|n| 0.01 * f64::from(n)).collect();
    let wave: Vec<[f64; 2]> = times.iter().map(|t| [0.1 * (5.0 * t).sin(), 0.1 * (5.0 * t).cos()]).collect();
    let model = MotionModel::ConstantVelocity;
    // a wave is smoother than white acceleration; an error that alternates on a straight line leaves nothing else to explain
    assert_eq!(fit_noise(model, &times, &wave).unwrap().end, FitEnd::NoMeasurementNoise);
    let line: Vec<[f64; 2]> =
        (0..200).map(|n| [0.002 * f64::from(n) + 1e-4 * f64::from(n % 2), 0.0]).collect();
    assert_eq!(fit_noise(model, &times, &line).unwrap().end, FitEnd::NoProcessNoise);
    let field = |times: &[f64], positions: &[[f64; 2]]| fit_noise(model, times, positions).unwrap_err().field;
    assert_eq!(field(&times[..19], &wave[..19]), "positions");
    assert_eq!(field(&times[..50], &wave), "positions");
    assert_eq!(field(&times, &vec![[0.2; 2]; 200]), "positions");
    let mut broken = times.clone();
    broken[70] = broken[69];
    assert_eq!(field(&broken, &wave), "times[70]");
    let mut broken = wave.clone();
    broken[30][1] = f64::NAN;
    assert_eq!(field(&times, &broken), "positions[30]");
    for (noise, field) in [
        (Noise { process: 0.0, position: 1e-4 }, "process"),
        (Noise { process: f64::NAN, position: 1e-4 }, "process"),
        (Noise { process: 1.0, position: -1e-4 }, "position"),
    ] {
        assert_eq!(Kalman::new(model, noise).unwrap_err().field, field);
    }
}

proptest! {
    #[test]
    fn law_whatever_comes_in_a_handle_can_have_the_predicted_motion(
        samples in prop::collection::vec((any::<u64>(), any::<i64>(), any::<[f64; 2]>(), any::<[f64; 2]>()), 1..40),
        near in any::<u64>(),
    ) {
        let noise = Noise { process: 1.0, position: 1e-5 };
        let mut predictors: [Box<dyn Predictor>; 4] = [
            Box::new(Linear),
            Box::new(SharedTarget),
            Box::new(Kalman::new(MotionModel::ConstantVelocity, noise).unwrap()),
            Box::new(Kalman::new(MotionModel::ConstantAcceleration, noise).unwrap()),
        ];
        for (n, (time, age, position, velocity)) in samples.into_iter().enumerate() {
            let position = position.map(|x| if x.abs() <= 1e6 { x } else { 1e6 });
            let motion = Motion { position, velocity: velocity.map(|v| if v.abs() <= 1e6 { v } else { -1e6 }) };
            // some samples near one another, some anywhere
            let time = if n % 3 == 0 { time } else { near.saturating_add(time % 1_000_000_000) };
            let played = Played { motion, time: PeerTime(time), age: Span(age), held: false };
            let target = SharedTargetView { now: Motion { position: velocity, velocity }, then: motion };
            for predictor in &mut predictors {
                let predicted = predictor.predict(&played, Some(&target));
                prop_assert!(predicted.impossible_value().is_none(), "{predicted:?}");
            }
        }
    }
}
