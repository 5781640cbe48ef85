//! What the tests of the adaptive solver share: solving a scalar or vector problem and measuring its error.

use std::convert::Infallible;

use telespring::dde::adaptive::{DelayKind, Delayed, Discontinuity, Options, Solution, Status, solve};

/// A problem with a closed-form solution.
pub struct Case<'a> {
    pub name: &'static str,
    pub dimension: usize,
    pub span: (f64, f64),
    pub initial: Option<Vec<f64>>,
    pub delays: Box<dyn Fn() -> Vec<DelayKind<'a, Infallible>> + 'a>,
    #[allow(clippy::type_complexity)]
    pub slope: Box<dyn Fn(f64, &[f64], Delayed<'_>, &mut [f64]) + 'a>,
    #[allow(clippy::type_complexity)]
    pub history: Box<dyn Fn(f64, &mut [f64]) + 'a>,
    #[allow(clippy::type_complexity)]
    pub exact: Box<dyn Fn(f64) -> Vec<f64> + 'a>,
    pub breakpoints: Vec<Discontinuity>,
}

/// Solves at `rtol` with an absolute tolerance of the same size.
pub fn run(case: &Case<'_>, rtol: f64) -> Solution<Infallible> {
    let options = Options {
        rtol: rtol.into(),
        atol: rtol.into(),
        breakpoints: case.breakpoints.clone(),
        ..Options::default()
    };
    solve(
        |t, y, delayed, out| {
            (case.slope)(t, y, delayed, out);
            Ok(())
        },
        (case.delays)(),
        |t, out| {
            (case.history)(t, out);
            Ok(())
        },
        case.dimension,
        case.initial.as_deref(),
        case.span,
        &options,
    )
    .expect("the problem is well posed")
}

/// The largest error over 1000 times of the whole span, dense output included, measured by 1 + |y|, which is
/// what the tolerances bound.
pub fn error(case: &Case<'_>, solution: &Solution<Infallible>) -> f64 {
    assert_eq!(solution.status, Status::Completed, "{}", case.name);
    let (start, end) = case.span;
    let times: Vec<f64> =
        (0..=1000).map(|i| (start + (end - start) * f64::from(i) / 1000.0).clamp(start, end)).collect();
    let values = solution.sample(&times).expect("the whole span is there");
    let mut largest = 0.0;
    for (&t, row) in times.iter().zip(values.chunks_exact(case.dimension)) {
        for (got, want) in row.iter().zip((case.exact)(t)) {
            largest = f64::max(largest, (got - want).abs() / (1.0 + want.abs()));
        }
    }
    largest
}

/// Asserts that the error stays below `factor` times the tolerance at 1e-4 … 1e-11, and prints what was measured.
#[expect(clippy::disallowed_macros, reason = "shows the errors to whoever asks for the output")]
pub fn assert_accurate(case: &Case<'_>, factor: f64) {
    for rtol in [1e-4, 1e-6, 1e-8, 1e-9, 1e-10, 1e-11] {
        let solution = run(case, rtol);
        let error = error(case, &solution);
        println!(
            "{:<34} rtol {rtol:e} error {error:.2e} ratio {:8.2} steps {:5} rejected {:4} calls {:6}",
            case.name,
            error / rtol,
            solution.steps,
            solution.rejected,
            solution.evaluations
        );
        assert!(
            error <= factor * rtol,
            "{}: error {error:e} at rtol {rtol:e} exceeds {factor} times the tolerance",
            case.name
        );
    }
}
