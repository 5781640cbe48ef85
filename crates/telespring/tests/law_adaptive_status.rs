//! How the adaptive delay solver ends: each status, each refusal, and a callback's error handed through.

use telespring::InvalidInput;
use telespring::dde::adaptive::{DelayKind, Discontinuity, Options, Solution, Status, Tolerance, solve};

type Fault = String;

fn scalar(
    slope: impl Fn(f64, f64, &[f64]) -> Result<f64, Fault>,
    delays: Vec<DelayKind<'_, Fault>>,
    history: impl Fn(f64) -> Result<f64, Fault>,
    span: (f64, f64),
    options: &Options,
) -> Result<Solution<Fault>, InvalidInput> {
    solve(
        |t, y, delayed, out| {
            out[0] = slope(t, y[0], delayed.as_slice())?;
            Ok(())
        },
        delays,
        |t, out| {
            out[0] = history(t)?;
            Ok(())
        },
        1,
        None,
        span,
        options,
    )
}

#[test]
fn law_blow_up_ends_at_its_time() {
    // y' = y², y(0) = 1 is 1/(1 − t).
    let solution = scalar(|_, y, _| Ok(y * y), vec![], |_| Ok(1.0), (0.0, 2.0), &Options::default()).unwrap();
    let (Status::StepTooSmall { at } | Status::NonFinite { at }) = solution.status else {
        panic!("{:?}", solution.status);
    };
    assert!((at - 1.0).abs() < 1e-3, "{at}");
    assert_eq!(solution.end(), at);
    let mut y = [0.0];
    solution.evaluate(0.5, &mut y).unwrap();
    assert!((y[0] - 2.0).abs() < 1e-4);
    let refused = solution.evaluate(1.5, &mut y).unwrap_err();
    assert!(refused.to_string().contains("the solution is known from 0 to"), "{refused}");
}

#[test]
fn law_not_a_number_ends_where_it_begins() {
    let slope = |t: f64, _: f64, _: &[f64]| Ok(if t > 0.5 { f64::NAN } else { 1.0 });
    let solution = scalar(slope, vec![], |_| Ok(0.0), (0.0, 1.0), &Options::default()).unwrap();
    let Status::NonFinite { at } = solution.status else { panic!("{:?}", solution.status) };
    assert!((at - 0.5).abs() < 1e-9, "{at}");
    let first =
        scalar(|_, _, _| Ok(0.0), vec![], |_| Ok(f64::INFINITY), (0.0, 1.0), &Options::default()).unwrap();
    assert_eq!(first.status, Status::NonFinite { at: 0.0 });
}

#[test]
fn law_steps_used_up() {
    let options = Options { max_steps: 7, ..Options::default() };
    let solution =
        scalar(|t, _, _| Ok((50.0 * t).cos()), vec![], |_| Ok(0.0), (0.0, 10.0), &options).unwrap();
    assert_eq!(solution.status, Status::TooManySteps { at: solution.end() });
    assert_eq!(solution.steps + solution.rejected, 7);
    assert!(solution.status.to_string().contains("max_steps"));
}

#[test]
fn law_sticking_friction_ends_with_a_status() {
    let slope = |_: f64, y: f64, _: &[f64]| Ok(-y.signum());
    let options = Options { max_steps: 2000, ..Options::default() };
    let solution = scalar(slope, vec![], |_| Ok(0.5), (0.0, 1.0), &options).unwrap();
    assert_ne!(solution.status, Status::Completed);
    assert!((solution.end() - 0.5).abs() < 1e-3, "{:?}", solution.status);
}

#[test]
fn law_a_callback_error_comes_through_unharmed() {
    let slope = |t: f64, _: f64, _: &[f64]| if t > 0.4 { Err("boom".to_owned()) } else { Ok(1.0) };
    let solution = scalar(slope, vec![], |_| Ok(0.0), (0.0, 1.0), &Options::default()).unwrap();
    assert_eq!(solution.failure.as_deref(), Some("boom"));
    assert_eq!(solution.status, Status::Stopped { at: solution.end() });
    let in_history = scalar(
        |_, _, z| Ok(z[0]),
        vec![DelayKind::Constant(1.0)],
        |t| if t < 0.0 { Err("past".to_owned()) } else { Ok(1.0) },
        (0.0, 1.0),
        &Options::default(),
    );
    assert_eq!(in_history.unwrap().failure.as_deref(), Some("past"));
    let in_delay = scalar(
        |_, _, z| Ok(z[0]),
        vec![DelayKind::Time(Box::new(|_| Err("lag".to_owned())))],
        |_| Ok(1.0),
        (0.0, 1.0),
        &Options::default(),
    );
    assert_eq!(in_delay.unwrap().failure.as_deref(), Some("lag"));
}

#[test]
fn law_a_delay_into_the_future_is_named() {
    let timed = vec![DelayKind::Constant(0.1), DelayKind::time(|t| 0.5 - t)];
    let solution =
        scalar(|_, _, z| Ok(z[0] - z[1]), timed, |_| Ok(1.0), (0.0, 2.0), &Options::default()).unwrap();
    let Status::InvalidDelay { at, delay: 1, value } = solution.status else {
        panic!("{:?}", solution.status);
    };
    assert!(at > 0.5 && value < 0.0 && (value - (0.5 - at)).abs() < 1e-12);
    assert!(solution.status.to_string().contains("delay 1 is -"));
    // Through the state: τ = y − 1 with y falling below 1 at t = 1.
    let by_state = vec![DelayKind::state(|_, y: &[f64]| y[0] - 1.0)];
    let solution =
        scalar(|_, _, _| Ok(-1.0), by_state, |_| Ok(2.0), (0.0, 2.0), &Options::default()).unwrap();
    assert!(
        matches!(solution.status, Status::InvalidDelay { delay: 0, value, .. } if value < 0.0),
        "{:?}",
        solution.status
    );
    let missing = vec![DelayKind::time(|_| f64::NAN)];
    let solution = scalar(|_, _, _| Ok(0.0), missing, |_| Ok(1.0), (0.0, 1.0), &Options::default()).unwrap();
    assert!(matches!(solution.status, Status::InvalidDelay { .. }), "{:?}", solution.status);
}

#[test]
fn law_bad_input_is_refused_by_name() {
    let with = |delays, span, options: Options| {
        scalar(|_, _, _| Ok(0.0), delays, |_| Ok(1.0), span, &options).unwrap_err()
    };
    let span = (0.0, 1.0);
    let ok = Options::default;
    assert_eq!(with(vec![], (1.0, 1.0), ok()).field, "span");
    assert_eq!(with(vec![], (0.0, f64::INFINITY), ok()).field, "span");
    assert_eq!(with(vec![DelayKind::Constant(-0.1)], span, ok()).field, "delays[0]");
    assert_eq!(with(vec![DelayKind::Constant(f64::NAN)], span, ok()).field, "delays[0]");
    assert_eq!(with(vec![], span, Options { rtol: 1e-16.into(), ..ok() }).field, "rtol");
    assert_eq!(with(vec![], span, Options { atol: 0.0.into(), ..ok() }).field, "atol");
    let per = Tolerance::from(vec![f64::NAN]);
    assert_eq!(with(vec![], span, Options { atol: per, ..ok() }).field, "atol[0]");
    let two = Tolerance::from(vec![1e-6, 1e-6]);
    assert_eq!(with(vec![], span, Options { rtol: two, ..ok() }).field, "rtol");
    assert_eq!(with(vec![], span, Options { max_step: Some(0.0), ..ok() }).field, "max_step");
    assert_eq!(with(vec![], span, Options { initial_step: Some(-1.0), ..ok() }).field, "initial_step");
    let jump = vec![Discontinuity::jump(0.5)];
    assert_eq!(with(vec![], span, Options { breakpoints: jump, ..ok() }).field, "breakpoints[0]");
    let initial = |dimension, initial: Option<&[f64]>| {
        solve(
            |_, _, _, _| Ok::<(), Fault>(()),
            vec![],
            |_, _| Ok(()),
            dimension,
            initial,
            span,
            &Options::default(),
        )
        .unwrap_err()
        .field
    };
    assert_eq!(initial(0, None), "dimension");
    assert_eq!(initial(2, Some(&[1.0])), "initial");
    assert_eq!(initial(2, Some(&[1.0, f64::NAN])), "initial[1]");
}

/// A tolerance of its own for each component: the loose one does not hold the tight one back.
#[test]
fn law_tolerances_per_component() {
    let run = |atol: Vec<f64>| {
        solve(
            |t, _, _, out| {
                out[0] = (40.0 * t).cos();
                out[1] = 1.0;
                Ok::<(), Fault>(())
            },
            vec![],
            |_, out| {
                out.fill(0.0);
                Ok(())
            },
            2,
            None,
            (0.0, 10.0),
            &Options { rtol: 1e-12.into(), atol: atol.into(), ..Options::default() },
        )
        .unwrap()
        .steps
    };
    assert!(run(vec![1.0, 1e-12]) * 10 < run(vec![1e-12, 1.0]));
}
