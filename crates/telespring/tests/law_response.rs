//! What every frequency response obeys.

use num_complex::Complex64;
use proptest::prelude::*;
use telespring::response::{
    Convention, FrequencyResponse, GridStatus, frequency_grid, frequency_response, mobility_matrix, nyquist,
    open_loop, partner_response, transfer_matrix,
};
use telespring::{Delay, DyadAxis};

/// Masses, dampings, grounds, coupling damping, stiffness and delays of one dyad.
fn dyads() -> impl Strategy<Value = ([f64; 7], f64, [f64; 2])> {
    let decade = |low: f64, high: f64| (low.ln()..high.ln()).prop_map(f64::exp);
    let ground = || prop_oneof![Just(0.0), decade(0.1, 1e3)];
    let side = || (decade(0.05, 20.0), decade(1e-3, 20.0));
    let values = (side(), side(), ground(), ground(), prop_oneof![Just(0.0), decade(0.1, 10.0)])
        .prop_map(|((m1, b1), (m2, b2), h1, h2, c)| [m1, b1, m2, b2, h1, h2, c]);
    (values, decade(0.1, 1e3), [0.0..2.0, 0.0..2.0])
}

fn axis_of([m1, b1, m2, b2, h1, h2, c]: [f64; 7]) -> DyadAxis {
    DyadAxis::with_operators(m1, b1, m2, b2, h1, h2, c).unwrap()
}

fn response(axis: &DyadAxis, stiffness: f64, delay: &Delay, frequency: &[f64]) -> FrequencyResponse {
    frequency_response(axis, stiffness, delay, frequency, Convention::Exact).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn law_exchanging_the_partners_exchanges_the_matrix((p, k, [forward, backward]) in dyads()) {
        let [m1, b1, m2, b2, h1, h2, c] = p;
        let (axis, swapped) = (axis_of(p), axis_of([m2, b2, m1, b1, h2, h1, c]));
        let frequency = [0.1, 1.0, 30.0];
        let there = response(&axis, k, &Delay::new(forward, backward).unwrap(), &frequency);
        let back = response(&swapped, k, &Delay::new(backward, forward).unwrap(), &frequency);
        for i in 0..3 {
            for (output, input) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                let (a, b) = (there.value[i][output][input], back.value[i][1 - output][1 - input]);
                // Near a resonance rounding is magnified by its sharpness.
                prop_assert!((a - b).norm() <= 1e-8 * a.norm());
                let (a, b) = (there.phase[i][output][input], back.phase[i][1 - output][1 - input]);
                prop_assert!((a - b).abs() <= 1e-8 * (1.0 + a.abs()));
            }
        }
        let plots = [(axis, forward, backward), (swapped, backward, forward)]
            .map(|(axis, there, back)| nyquist(&axis, k, &Delay::new(there, back).unwrap()).unwrap());
        prop_assert_eq!(plots[0].unstable_roots, plots[1].unstable_roots);
    }

    #[test]
    fn law_conjugate_frequencies_give_conjugate_responses((p, k, [f, b]) in dyads(), re in -0.5..0.5, im in 0.01..50.0) {
        let delay = Delay::new(f, b).unwrap();
        let at = |s| transfer_matrix(&axis_of(p), k, &delay, s, Convention::Exact).unwrap();
        let s = Complex64::new(re, im);
        let (above, below) = (at(s), at(s.conj()));
        for (a, b) in above.iter().flatten().zip(below.iter().flatten()) {
            prop_assert!((a.conj() - b).norm() <= 1e-14 * a.norm());
        }
        let velocity = mobility_matrix(&axis_of(p), k, &delay, s).unwrap();
        for (v, x) in velocity.iter().flatten().zip(above.iter().flatten()) {
            prop_assert!((v - s * x).norm() <= 1e-14 * v.norm());
        }
    }

    #[test]
    fn law_without_delay_the_dyad_is_passive((p, k, _) in dyads(), w in 1e-3..100.0) {
        let delay = Delay::each_way(0.0).unwrap();
        let m = mobility_matrix(&axis_of(p), k, &delay, Complex64::new(0.0, w)).unwrap();
        // The power that both forces put in is never negative: Hermitian part positive semidefinite.
        let off = 0.5 * (m[0][1] + m[1][0].conj());
        let size = m[0][0].norm().max(m[1][1].norm());
        prop_assert!(m[0][0].re >= -1e-12 * size && m[1][1].re >= -1e-12 * size);
        prop_assert!(m[0][0].re * m[1][1].re - off.norm_sqr() >= -1e-9 * size * size);
        prop_assert!(nyquist(&axis_of(p), k, &delay).unwrap().is_stable());
    }

    #[test]
    fn law_a_clock_that_runs_otherwise_scales_everything((p, k, [f, b]) in dyads(), w in 0.1..30.0) {
        // t → t/4: b·4, k·16, c·4, delays/4, ω·4; positions per force/16. Powers of two round alike.
        let [m1, b1, m2, b2, h1, h2, c] = p;
        let fast = axis_of([m1, 4.0 * b1, m2, 4.0 * b2, 16.0 * h1, 16.0 * h2, 4.0 * c]);
        let (slow_delay, fast_delay) = (Delay::new(f, b).unwrap(), Delay::new(f / 4.0, b / 4.0).unwrap());
        let slow = response(&axis_of(p), k, &slow_delay, &[w]);
        let scaled = response(&fast, 16.0 * k, &fast_delay, &[4.0 * w]);
        for (a, b) in slow.value[0].iter().flatten().zip(scaled.value[0].iter().flatten()) {
            prop_assert!((a - 16.0 * b).norm() <= 1e-12 * a.norm());
        }
        let (a, b) = (
            nyquist(&axis_of(p), k, &slow_delay).unwrap(),
            nyquist(&fast, 16.0 * k, &fast_delay).unwrap(),
        );
        prop_assert_eq!(a.unstable_roots, b.unstable_roots);
        if let (Some(a), Some(b)) = (a.delay_margin, b.delay_margin) {
            prop_assert!((a.value - 4.0 * b.value).abs() <= 1e-9 * a.value.max(1e-3));
        }
    }

    #[test]
    fn law_the_phase_is_continuous_and_fits_the_value((p, k, [f, b]) in dyads()) {
        let axis = axis_of(p);
        let delay = Delay::new(f, b).unwrap();
        let grid = frequency_grid(&axis, k, &delay, 1e-3, 200.0, 0.2, 1_000_000).unwrap();
        prop_assert_eq!(&grid.status, &GridStatus::Resolved);
        let dense = response(&axis, k, &delay, &grid.frequency);
        prop_assert!(dense.poles_on_axis.is_empty());
        for (output, input) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let curve = dense.entry(output, input).unwrap();
            for (i, (value, phase)) in curve.value.iter().zip(&curve.phase).enumerate() {
                let gap = Complex64::from_polar(1.0, *phase) * value.norm() - value;
                prop_assert!(gap.norm() <= 1e-7 * value.norm(), "ω = {}", curve.frequency[i]);
                if i > 0 {
                    // Three factors of at most about 0.2 each, and the delay.
                    prop_assert!((phase - curve.phase[i - 1]).abs() < 1.0);
                }
            }
        }
        // Asked for alone, or out of order, a frequency has the same phase.
        let last = grid.frequency.len() - 1;
        let few = response(&axis, k, &delay, &[grid.frequency[last], grid.frequency[last / 2]]);
        prop_assert!((few.phase[0][1][0] - dense.phase[last][1][0]).abs() < 1e-6);
        prop_assert!((few.phase[1][1][0] - dense.phase[last / 2][1][0]).abs() < 1e-6);
    }

    #[test]
    fn law_the_loop_is_minus_the_product_of_both_sides((p, k, [f, b]) in dyads(), w in 0.0..50.0) {
        let delay = Delay::new(f, b).unwrap();
        let sides = [0, 1].map(|robot| partner_response(&axis_of(p), k, &delay, robot, &[w]).unwrap());
        let whole = open_loop(&axis_of(p), k, &delay, &[w]).unwrap();
        let product = -sides[0].value[0] * sides[1].value[0];
        prop_assert!((product - whole.value[0]).norm() <= 1e-12 * product.norm());
        let phase = std::f64::consts::PI + sides[0].phase[0] + sides[1].phase[0];
        prop_assert!((phase - whole.phase[0]).abs() <= 1e-12 * (1.0 + phase.abs()));
    }
}

#[test]
fn law_light_damping_and_long_delays_are_resolved() {
    let axis = DyadAxis::new(1.0, 1e-3, 2.0, 1e-3).unwrap();
    let plot = nyquist(&axis, 10.0, &Delay::each_way(100.0).unwrap()).unwrap();
    assert_eq!(plot.locus_status, GridStatus::Resolved);
    assert!(plot.unstable_roots.is_multiple_of(2) && plot.unstable_roots > 100);
    // The peak of one side, |k/P₁| = k/(b √(k/m)) at its resonance, is met within the resolution.
    let frequency = &plot.frequency;
    let peak = partner_response(&axis, 10.0, &Delay::each_way(0.0).unwrap(), 0, frequency).unwrap();
    let highest = peak.magnitude.iter().copied().fold(0.0, f64::max);
    let expected = 10.0 / (1e-3 * 10f64.sqrt());
    assert!((highest / expected - 1.0).abs() < 0.01, "{highest} {expected}");
}

#[test]
fn law_a_grid_that_reaches_its_limit_says_so() {
    let axis = DyadAxis::new(1.0, 4.0, 1.0, 4.0).unwrap();
    let delay = Delay::each_way(100.0).unwrap();
    let grid = frequency_grid(&axis, 10.0, &delay, 0.1, 100.0, 0.1, 1000).unwrap();
    assert_eq!(grid.status, GridStatus::TooManyPoints);
    assert!(grid.frequency.len() > 500 && grid.frequency.len() <= 1000 && grid.frequency.is_sorted());
    assert_eq!((grid.frequency[0], grid.frequency[grid.frequency.len() - 1]), (0.1, 100.0));
}

#[test]
fn law_bad_input_is_refused_by_name() {
    let axis = DyadAxis::new(1.0, 4.0, 1.0, 4.0).unwrap();
    let delay = Delay::each_way(0.1).unwrap();
    let field = |stiffness, frequency: &[f64]| {
        frequency_response(&axis, stiffness, &delay, frequency, Convention::Exact).unwrap_err().field
    };
    assert_eq!(field(-1.0, &[1.0]), "stiffness");
    assert_eq!(field(10.0, &[1.0, f64::NAN]), "frequency[1]");
    assert_eq!(field(10.0, &[-1.0]), "frequency[0]");
    assert_eq!(field(10.0, &[1.0, 0.0]), "frequency[1]"); // the rigid-body pole
    let refused = |low, high, resolution, limit| {
        frequency_grid(&axis, 10.0, &delay, low, high, resolution, limit).unwrap_err().field
    };
    assert_eq!(refused(2.0, 1.0, 0.1, 100), "high");
    assert_eq!(refused(0.1, 1.0, 0.0, 100), "resolution");
    assert_eq!(refused(0.1, 1.0, 0.1, 1), "limit");
    assert_eq!(partner_response(&axis, 10.0, &delay, 2, &[1.0]).unwrap_err().field, "robot");
    let at = |s| transfer_matrix(&axis, 10.0, &delay, s, Convention::Exact).unwrap_err().field;
    assert_eq!(at(Complex64::ZERO), "s");
    assert_eq!(at(Complex64::new(-1e6, 0.0)), "s");
    let mut broken = axis;
    broken.sides[1].mass = f64::NAN;
    assert_eq!(nyquist(&broken, 10.0, &delay).unwrap_err().field, "m2");
}

#[test]
fn law_a_heavy_damper_between_undamped_robots_is_counted_or_told() {
    // c² outweighs everything by 10¹⁰ and more; deciding must neither fail nor take for ever.
    let axis = DyadAxis::with_operators(0.0023, 0.0, 0.6, 0.0, 1.5e-5, 0.0, 77_677.0).unwrap();
    let without_delay = nyquist(&axis, 0.0869, &Delay::each_way(0.0).unwrap()).unwrap();
    // Only robot 1 is grounded, so the damper is felt by every mode, however little.
    assert!(without_delay.is_stable());
    let delayed = nyquist(&axis, 0.0869, &Delay::each_way(0.01).unwrap()).unwrap();
    assert_eq!(delayed.unstable_roots % 2, 0);
}
