//! The problems of DDETST with closed-form solutions: W. H. Enright and H. Hayashi (1997), "The evaluation of
//! numerical software for delay differential equations", in Boisvert (ed.), The Quality of Numerical Software,
//! Chapman & Hall, pp. 179-192; numbering as there. Facts in python/telespring/references/enright1997.toml.
//!
//! Each allowed factor is the problem's own amplification of local errors, measured once and rounded up to the next
//! of 1, 3, 10, 30, …: an error in the method or in the tracking of breaks shows as orders of magnitude.

mod adaptive_support;

use adaptive_support::{Case, assert_accurate, run};
use telespring::dde::adaptive::{DelayKind, Status};

/// B1 (Neves 1975): the delay vanishes at t = 1.
#[test]
fn ref_enright1997_b1_delay_vanishes_inside() {
    let case = Case {
        name: "DDETST B1",
        dimension: 1,
        span: (0.1, 10.0),
        initial: None,
        delays: Box::new(|| vec![DelayKind::time(|t: f64| t - (1.0 - 1.0 / t).exp())]),
        slope: Box::new(|_, _, delayed, out| out[0] = 1.0 - delayed[0][0]),
        history: Box::new(|t, out| out[0] = t.ln()),
        exact: Box::new(|t| vec![t.ln()]),
        breakpoints: vec![],
    };
    assert_accurate(&case, 3.0);
}

/// B2 (Neves and Thompson 1992): the right-hand side switches with the sign of y(t/2); the history is one point.
#[test]
fn ref_enright1997_b2_switches_with_the_delayed_state() {
    let case = Case {
        name: "DDETST B2",
        dimension: 1,
        span: (0.0, 2.0 * 66f64.ln()),
        initial: None,
        delays: Box::new(|| vec![DelayKind::time(|t: f64| 0.5 * t)]),
        slope: Box::new(|_, y, delayed, out| {
            out[0] = if delayed[0][0] < 0.0 { 1.0 - y[0] } else { -1.0 - y[0] };
        }),
        history: Box::new(|t, out| out[0] = if t == 0.0 { 1.0 } else { f64::NAN }),
        exact: Box::new(|t: f64| {
            vec![if t <= 2.0 * 2f64.ln() {
                2.0 * (-t).exp() - 1.0
            } else if t <= 2.0 * 6f64.ln() {
                1.0 - 6.0 * (-t).exp()
            } else {
                66.0 * (-t).exp() - 1.0
            }]
        }),
        breakpoints: vec![],
    };
    assert_accurate(&case, 300.0);
}

/// D1 (Neves 1975): a state-dependent delay that vanishes at t = 1.
#[test]
fn ref_enright1997_d1_state_dependent() {
    let case = Case {
        name: "DDETST D1",
        dimension: 2,
        span: (0.1, 5.0),
        initial: None,
        delays: Box::new(|| vec![DelayKind::state(|t, y: &[f64]| t - (1.0 - y[1]).exp())]),
        slope: Box::new(|_, y, delayed, out| {
            out[0] = y[1];
            out[1] = -delayed[0][1] * y[1] * y[1] * (1.0 - y[1]).exp();
        }),
        history: Box::new(|t, out| {
            out[0] = t.ln();
            out[1] = 1.0 / t;
        }),
        exact: Box::new(|t| vec![t.ln(), 1.0 / t]),
        breakpoints: vec![],
    };
    assert_accurate(&case, 30.0);
    // Where the delay vanishes, the state's error makes it negative by a hair, which is no request for the future.
    for i in 0..=80 {
        let rtol = 10f64.powf(-3.0 - 0.1 * f64::from(i));
        assert_eq!(run(&case, rtol).status, Status::Completed, "rtol {rtol:e}");
    }
}
