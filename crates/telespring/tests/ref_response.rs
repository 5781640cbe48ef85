//! Frequency response against published numbers and closed forms.

use num_complex::Complex64;
use telespring::response::{
    Convention, NyquistStatus, frequency_response, nyquist, open_loop, partner_response, transfer_matrix,
};
use telespring::{Delay, DyadAxis};

/// H-MAN₁, x axis, twice (Du, Kulkarni, Kager and Campolo, Table III).
const MASS: f64 = 0.8334;
const DAMPING: f64 = 7.7257;

fn identical() -> DyadAxis {
    DyadAxis::new(MASS, DAMPING, MASS, DAMPING).unwrap()
}

/// Eq. 10: the crossing frequency and the first critical delay of identical robots.
fn identical_crossing(mass: f64, damping: f64, stiffness: f64) -> (f64, f64) {
    let root = (2.0 * mass * stiffness - damping * damping).sqrt();
    let cosine = (mass * stiffness - damping * damping) / (mass * stiffness);
    let sine = damping * root / (mass * stiffness);
    (root / mass, mass / root * sine.atan2(cosine))
}

#[test]
fn ref_fig_3_only_panel_i_is_unstable() {
    let k = DAMPING * DAMPING / (2.0 * MASS);
    let (frequency, delta) = identical_crossing(MASS, DAMPING, 2.0 * k);
    for stiffness in [0.5, 1.0, 2.0] {
        for delay in [0.5, 1.0, 2.0] {
            let plot =
                nyquist(&identical(), stiffness * k, &Delay::each_way(delay * delta).unwrap()).unwrap();
            let expected = if stiffness == 2.0 && delay == 2.0 { 2 } else { 0 };
            assert!(plot.rigid_body);
            assert_eq!(plot.unstable_roots, expected, "{stiffness} K, {delay} Δ");
            assert_eq!(plot.encirclements, expected as i64);
            if stiffness == 2.0 && delay == 1.0 {
                // Marginal: −1 is met at the crossing frequency; 1e-9: the width of rounding there.
                let NyquistStatus::OnTheAxis { frequency: met } = plot.status else {
                    panic!("2K, Δ is marginal: {:?}", plot.status);
                };
                assert!((met / frequency - 1.0).abs() < 1e-9, "{met} {frequency}");
                assert!(plot.minimum_distance.value < 1e-12 && plot.delay_margin.is_none());
            } else {
                assert_eq!(plot.status, NyquistStatus::Counted, "{stiffness} K, {delay} Δ");
            }
        }
    }
}

#[test]
fn ref_delay_margin_is_eq_10_less_the_delay() {
    for factor in [1.001, 2.0, 4.0, 100.0] {
        let k = factor * DAMPING * DAMPING / (2.0 * MASS);
        let (frequency, delta) = identical_crossing(MASS, DAMPING, k);
        let plot = nyquist(&identical(), k, &Delay::new(0.0, 0.6 * delta).unwrap()).unwrap();
        let margin = plot.delay_margin.unwrap();
        // 1e-12: at 1.001 K the crossing frequency itself is known to a few hundred roundings.
        assert!(((margin.value + 0.3 * delta) / delta - 1.0).abs() < 1e-11);
        assert!((margin.frequency / frequency - 1.0).abs() < 1e-11);
        assert!(plot.phase_margin.unwrap().value <= 2.0 * margin.value * margin.frequency + 1e-9);
    }
}

#[test]
fn ref_delay_margin_of_the_hman_axes() {
    // Checked two independent ways when the criteria were fixed: δ_m at 2K_xy and 4K_xy.
    let dyad = telespring::hman();
    let k = 35.61599;
    let exact = 0.5 * (7.7257_f64.powi(2) + 7.4208_f64.powi(2)) / (0.8334 + 0.7776);
    assert!((k / exact - 1.0).abs() < 1e-6);
    let published =
        [(0, 2.0, 0.16718632424), (1, 2.0, 0.23185110031), (0, 4.0, 0.06434961099), (1, 4.0, 0.08661465432)];
    for (axis, factor, maximum_delay) in published {
        let axis = dyad.axis(axis).unwrap();
        let plot = nyquist(&axis, factor * exact, &Delay::each_way(0.01).unwrap()).unwrap();
        assert!(((plot.delay_margin.unwrap().value + 0.01) / maximum_delay - 1.0).abs() < 1e-10);
        for (delay, roots) in [(0.999 * maximum_delay, 0), (1.001 * maximum_delay, 2)] {
            let plot = nyquist(&axis, factor * exact, &Delay::each_way(delay).unwrap()).unwrap();
            assert_eq!((plot.unstable_roots, plot.status), (roots, NyquistStatus::Counted));
        }
    }
}

#[test]
fn ref_long_delays_collect_one_pair_per_turn() {
    // Identical robots cross at one frequency only, and every further turn 2ωδ of 2π adds a pair.
    for (mass, damping, stiffness) in
        [(MASS, DAMPING, 71.6), (1.0, 1e-3, 10.0), (1.0, 4.0, 8.01), (0.01, 0.5, 900.0)]
    {
        let axis = DyadAxis::new(mass, damping, mass, damping).unwrap();
        let (frequency, delta) = identical_crossing(mass, damping, stiffness);
        for delay in [0.9 * delta, 1.1 * delta, 3.0, 20.0, 100.0_f64] {
            let plot = nyquist(&axis, stiffness, &Delay::each_way(delay).unwrap()).unwrap();
            let turns = (delay - delta) * frequency / std::f64::consts::PI;
            let expected = if turns < 0.0 { 0 } else { 2 * (turns.floor() as usize + 1) };
            assert_eq!(plot.status, NyquistStatus::Counted);
            assert_eq!(plot.unstable_roots, expected, "m {mass} b {damping} k {stiffness} δ {delay}");
        }
    }
}

#[test]
fn ref_stability_returns_at_a_longer_delay() {
    // Stable on [0, 0.8508) and (1.7738, 2.1128), found by two independent ways.
    let axis = DyadAxis::new(0.97670822, 2.15372614, 0.30379312, 4.59594729).unwrap();
    let stable = |delay| nyquist(&axis, 9.174736188, &Delay::each_way(delay).unwrap()).unwrap().is_stable();
    for (delay, expected) in
        [(0.85, true), (0.852, false), (1.773, false), (1.775, true), (2.112, true), (2.114, false)]
    {
        assert_eq!(stable(delay), expected, "δ = {delay} s");
    }
}

#[test]
fn ref_the_papers_critical_stiffness_is_not_sufficient() {
    let axis = DyadAxis::new(1.0, 1.0, 1.0, 10.0).unwrap();
    let plot = nyquist(&axis, 24.9975, &Delay::each_way(0.175).unwrap()).unwrap();
    assert_eq!(plot.unstable_roots, 2);
    assert!(nyquist(&axis, 24.9975, &Delay::each_way(0.171).unwrap()).unwrap().is_stable());
    // Below 9.4610953 N/m no crossing exists, so no delay is too long; above, one does.
    assert_eq!(nyquist(&axis, 9.461, &Delay::each_way(0.1).unwrap()).unwrap().delay_margin, None);
    assert!(nyquist(&axis, 9.462, &Delay::each_way(0.1).unwrap()).unwrap().delay_margin.is_some());
}

#[test]
fn ref_undamped_free_robots_without_delay_are_marginal() {
    // χ = s² (m₁m₂ s² + k (m₁ + m₂)): a double root at 0 and a pair at √(k (m₁+m₂)/(m₁m₂)).
    let axis = DyadAxis::new(1.0, 0.0, 2.0, 0.0).unwrap();
    let plot = nyquist(&axis, 6.0, &Delay::each_way(0.0).unwrap()).unwrap();
    assert_eq!((plot.unstable_roots, plot.status), (0, NyquistStatus::OnTheAxis { frequency: 0.0 }));
    assert!(!plot.is_stable());
    let response =
        frequency_response(&axis, 6.0, &Delay::each_way(0.0).unwrap(), &[0.5, 4.0], Convention::Exact)
            .unwrap();
    assert_eq!(response.poles_on_axis.len(), 2);
    assert!((response.poles_on_axis[1] - 3.0).abs() < 1e-9);
    // X₂/F₁ = k/χ: −π from the double root, −π more past the pair.
    let [before, after] = [0, 1].map(|i| response.phase[i][1][0] / std::f64::consts::PI);
    assert!((before + 1.0).abs() < 1e-12 && (after + 2.0).abs() < 1e-12, "{before} {after}");
}

#[test]
fn ref_undamped_robots_with_any_delay_are_unstable() {
    let axis = DyadAxis::new(1.0, 0.0, 1.0, 0.0).unwrap();
    for delay in [1e-3, 0.1, 1.0] {
        let plot = nyquist(&axis, 10.0, &Delay::each_way(delay).unwrap()).unwrap();
        assert!(plot.unstable_roots >= 2 && plot.status == NyquistStatus::Counted, "δ = {delay}");
        let (frequency, _) = identical_crossing(1.0, 0.0, 10.0);
        let turns = (delay * frequency / std::f64::consts::PI).floor() as usize + 1;
        assert_eq!(plot.unstable_roots, 2 * turns, "δ = {delay}");
    }
}

/// The two equations of motion with e^(st) forces, solved as a complex 2×2 system by Gauss.
fn equations_of_motion(p: &[f64; 9], delay: [f64; 2], s: Complex64) -> [[Complex64; 2]; 2] {
    let [m1, b1, h1, m2, b2, h2, c, k, _] = *p;
    let a11 = s * s * m1 + s * b1 + h1 + k + s * c;
    let a22 = s * s * m2 + s * b2 + h2 + k + s * c;
    // Robot 1 sees where robot 2 was one backward delay ago, and robot 2 where 1 was one forward delay ago.
    let a12 = -(s * c + k) * (-s * delay[1]).exp();
    let a21 = -(s * c + k) * (-s * delay[0]).exp();
    let factor = a21 / a11;
    let pivot = a22 - factor * a12;
    let solve = |f1: Complex64, f2: Complex64| {
        let x2 = (f2 - factor * f1) / pivot;
        [(f1 - a12 * x2) / a11, x2]
    };
    let (first, second) = (solve(1.0.into(), 0.0.into()), solve(0.0.into(), 1.0.into()));
    [[first[0], second[0]], [first[1], second[1]]]
}

#[test]
fn ref_transfer_matrix_solves_the_equations_of_motion() {
    let p = [1.3, 4.0, 20.0, 0.7, 2.0, 0.0, 1.5, 60.0, 0.0];
    let axis = DyadAxis::with_operators(p[0], p[1], p[3], p[4], p[2], p[5], p[6]).unwrap();
    let delay = Delay::new(0.08, 0.21).unwrap();
    for s in [(0.0, 0.3), (0.0, 9.0), (0.0, 400.0), (0.5, 2.0), (-1.0, 7.0)] {
        let s = Complex64::new(s.0, s.1);
        let expected = equations_of_motion(&p, [0.08, 0.21], s);
        let matrix = transfer_matrix(&axis, 60.0, &delay, s, Convention::Exact).unwrap();
        let paper = transfer_matrix(&axis, 60.0, &delay, s, Convention::Paper).unwrap();
        for (output, input) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let error = (matrix[output][input] - expected[output][input]).norm();
            // 1e-12: both solve a system of condition below 10³.
            assert!(error < 1e-12 * expected[output][input].norm(), "{s} {output} {input}");
        }
        assert_eq!([paper[0][0], paper[1][1]], [matrix[1][1], matrix[0][0]]);
        assert_eq!([paper[0][1], paper[1][0]], [matrix[0][1], matrix[1][0]]);
    }
}

#[test]
fn ref_free_handles_near_rest_drift_as_one_body() {
    // X₁/F₁ → 1/(s (b₁ + b₂ + 2δk)) as s → 0, and the plain formula has lost all digits by s = 1e-9j.
    let axis = DyadAxis::new(1.0, 4.0, 2.0, 5.0).unwrap();
    let delay = Delay::each_way(0.1).unwrap();
    for w in [1e-6, 1e-9, 1e-12] {
        let matrix = transfer_matrix(&axis, 10.0, &delay, Complex64::new(0.0, w), Convention::Exact).unwrap();
        let drift = Complex64::new(0.0, -1.0 / (w * (4.0 + 5.0 + 0.2 * 10.0)));
        // The next term is of relative size w.
        assert!((matrix[0][0] - drift).norm() < 2.0 * (w + 1e-15) * drift.norm(), "ω = {w}");
    }
}

#[test]
fn ref_fig_4_the_partner_response_exceeds_1_above_the_critical_stiffness() {
    let k = DAMPING * DAMPING / (2.0 * MASS);
    let frequency: Vec<f64> = (1..4000).map(|i| 0.005 * f64::from(i)).collect();
    let peak = |stiffness: f64, delay: f64| {
        let delay = Delay::each_way(delay).unwrap();
        let curve = partner_response(&identical(), stiffness, &delay, 1, &frequency).unwrap();
        let loop_curve = open_loop(&identical(), stiffness, &delay, &frequency).unwrap();
        for (side, whole) in curve.value.iter().zip(&loop_curve.value) {
            assert!((side * side + whole).norm() < 1e-13 * whole.norm().max(1.0));
        }
        (curve.magnitude.iter().copied().fold(0.0, f64::max), curve.phase)
    };
    assert!(peak(0.5 * k, 0.1).0 < 1.0 && peak(0.999 * k, 0.1).0 < 1.0);
    assert!(peak(1.01 * k, 0.1).0 > 1.0 && peak(4.0 * k, 0.1).0 > peak(2.0 * k, 0.1).0);
    // (b): delay alone leaves the magnitude and lags the phase by ωδ.
    let ((near, early), (far, late)) = (peak(2.0 * k, 0.1), peak(2.0 * k, 0.3));
    assert_eq!(near, far);
    for ((w, early), late) in frequency.iter().zip(early).zip(late) {
        assert!((early - late - 0.2 * w).abs() < 1e-12);
    }
}
