//! The criteria of one axis: published values, laws, and other ways to the same number.

use num_complex::Complex64;
use proptest::prelude::*;
use telespring::criteria::*;
use telespring::{Delay, DyadAxis, Result, hman};

fn close(value: f64, expected: f64, relative: f64) {
    assert!(
        (value - expected).abs() <= relative * expected.abs(),
        "{value} is not within {relative:e} of {expected}"
    );
}

fn axis(m1: f64, b1: f64, m2: f64, b2: f64) -> DyadAxis {
    DyadAxis::new(m1, b1, m2, b2).expect("a valid axis")
}

/// Du, Kulkarni, Kager, Campolo, Table III; the unrounded values were computed independently.
#[test]
fn ref_hman_critical_stiffness_and_maximum_delay() {
    let dyad = hman();
    let (x, y) = (dyad.axis(0).unwrap(), dyad.axis(1).unwrap());
    let k = critical_stiffness(&x);
    close(k, 35.615988, 1e-8);
    close(critical_stiffness(&y), 39.442273, 1e-8);
    close(maximum_delay(&x, 2.0 * k).unwrap(), 0.16718632424, 1e-10);
    close(maximum_delay(&y, 2.0 * k).unwrap(), 0.23185110031, 1e-10);
    close(maximum_delay(&x, 4.0 * k).unwrap(), 0.06434961099, 1e-10);
    close(maximum_delay(&y, 4.0 * k).unwrap(), 0.08661465432, 1e-10);
}

#[test]
fn ref_unequal_damping_breaks_equation_5() {
    let unequal = axis(1.0, 1.0, 1.0, 10.0);
    close(critical_stiffness(&unequal), 9.4610953, 1e-8);
    close(paper_critical_stiffness(&unequal).unwrap(), 25.25, 1e-15);
    let stable = stable_delays(&unequal, 24.9975, 10.0).unwrap();
    assert_eq!(stable.len(), 1);
    close(stable[0].1, 0.1718, 1e-3);
    assert!(unstable_root_count(&unequal, 24.9975, 0.175).unwrap() > 0);
}

/// Identical robots: the paper's Eq. 10 and b²/(2m).
#[test]
fn ref_identical_robots_have_a_closed_form() {
    for (m, b, factor) in [(0.8334, 7.7257, 2.0), (3.0, 0.2, 1.001), (1e-3, 1.0, 50.0), (900.0, 3.0, 1e4)] {
        let identical = axis(m, b, m, b);
        let critical = b * b / (2.0 * m);
        close(critical_stiffness(&identical), critical, 1e-14);
        let k = factor * critical;
        let root = (2.0 * m * k - b * b).sqrt();
        let delay = -m / root * (-b * root / (m * k)).atan2((m * k - b * b) / (m * k));
        close(maximum_delay(&identical, k).unwrap(), delay, 1e-12);
    }
}

#[test]
fn ref_equation_5_fails_beyond_a_damping_ratio_of_one_plus_root_two() {
    let limit = 1.0 + 2f64.sqrt();
    let ratio = |ratio: f64| {
        let unequal = axis(1.0, 1.0, 1.0, ratio);
        critical_stiffness(&unequal) / paper_critical_stiffness(&unequal).unwrap()
    };
    close(ratio(limit * (1.0 - 1e-6)), 1.0, 1e-15);
    assert!(ratio(limit * (1.0 + 1e-3)) < 1.0 - 1e-8);
}

#[test]
fn ref_stability_returns_at_a_longer_delay() {
    let returning = axis(0.97670822, 2.15372614, 0.30379312, 4.59594729);
    let stable = stable_delays(&returning, 9.174736188, 50.0).unwrap();
    assert_eq!(stable.len(), 2);
    assert_eq!(stable[0].0, 0.0);
    close(stable[0].1, 0.8508, 1e-4);
    close(stable[1].0, 1.7738, 1e-4);
    close(stable[1].1, 2.1128, 1e-4);
    assert_eq!(stable, stable_delays(&returning, 9.174736188, f64::INFINITY).unwrap());
}

/// A later band of stiffness is delay-independent again: crossings at 20 and 25 N/m, none from 30 to
/// 80 N/m, again at 100 N/m.
#[test]
fn ref_grounded_dyad_with_a_later_stable_band() {
    let banded = DyadAxis::with_operators(100.0, 10.0, 1.0, 0.2, 12000.0, 100.0, 0.0).unwrap();
    let crossed = |k: f64| !crossings(&banded, k).unwrap().is_empty();
    let critical = critical_stiffness(&banded);
    assert!(critical > 17.0 && critical < 20.0);
    assert!(!crossed(critical * (1.0 - 1e-8)) && crossed(critical * (1.0 + 1e-8)));
    assert!(crossed(20.0) && crossed(25.0) && crossed(100.0));
    assert!([30.0, 50.0, 80.0].iter().all(|&k| !crossed(k)));
}

/// The paper's arms hold the handles with k_c = 120 N/m (Eq. 13), which moves the boundary.
#[test]
fn ref_hman_in_the_arms_of_the_experiment() {
    let dyad = hman();
    let held = |i| {
        let mut axis = dyad.axis(i).unwrap();
        axis.sides.iter_mut().for_each(|side| side.ground_stiffness = 120.0);
        axis
    };
    let k = critical_stiffness(&dyad.axis(0).unwrap());
    for i in 0..2 {
        assert_eq!(maximum_delay(&held(i), 2.0 * k).unwrap(), f64::INFINITY);
    }
    let gap = |i| {
        let stable = stable_delays(&held(i), 4.0 * k, 1.0).unwrap();
        (stable[0].1, stable[1].0)
    };
    close(gap(0).0, 0.078, 1e-2);
    close(gap(0).1, 0.152, 1e-2);
    close(gap(1).0, 0.119, 2e-2);
    close(gap(1).1, 0.166, 1e-2);
}

/// A tangency made on purpose: at the critical stiffness of an unequal pair F only touches zero.
#[test]
fn ref_next_to_a_tangency_no_root_is_missed() {
    for (m1, b1, m2, b2) in [(1.0, 1.0, 1.0, 10.0), (0.5, 1.0, 0.7, 8.0), (2.0, 30.0, 1.5, 1.0)] {
        let unequal = axis(m1, b1, m2, b2);
        let critical = critical_stiffness(&unequal);
        assert!(critical < 0.99 * paper_critical_stiffness(&unequal).unwrap());
        for distance in [1e-6, 1e-9, 1e-12, 1e-14] {
            let above = crossings(&unequal, critical * (1.0 + distance)).unwrap();
            assert_eq!(above.iter().map(|c| c.direction).collect::<Vec<_>>(), [-1, 1], "{distance:e}");
            assert!(crossings(&unequal, critical * (1.0 - distance)).unwrap().is_empty(), "{distance:e}");
        }
    }
}

#[test]
fn ref_undamped_sides() {
    // Without any damping both robots oscillate against each other and every delay feeds them.
    let undamped = axis(1.0, 0.0, 2.0, 0.0);
    assert_eq!(critical_stiffness(&undamped), 0.0);
    assert_eq!(maximum_delay(&undamped, 5.0).unwrap(), 0.0);
    assert!(stable_delays(&undamped, 5.0, 1.0).unwrap().is_empty());
    // One damped side carries the other, but not at every delay.
    let half = axis(1.0, 2.0, 1.0, 0.0);
    assert_eq!(critical_stiffness(&half), 0.0);
    let end = maximum_delay(&half, 5.0).unwrap();
    assert!(end > 0.0 && end.is_finite());
}

#[test]
fn ref_extreme_parameters_neither_overflow_nor_miss() {
    for m1 in [1e-3, 1.0, 1e3] {
        for m2 in [1e-3, 1.0, 1e3] {
            for b in [1e-2, 1.0, 1e2] {
                let extreme = axis(m1, b, m2, 2.0 * b);
                for k in [1e-3, 1.0, 1e3, 1e6] {
                    let independent = critical_stiffness(&extreme) > k;
                    let end = maximum_delay(&extreme, k).unwrap();
                    assert!(end > 0.0);
                    assert_eq!(end.is_infinite(), independent, "{m1} {m2} {b} {k}");
                }
            }
        }
    }
}

#[test]
fn ref_bad_values_are_refused_with_their_name() {
    let message = |result: Result<f64>| result.unwrap_err().to_string();
    let good = axis(1.0, 1.0, 1.0, 1.0);
    assert!(message(maximum_delay(&good, -3.0)).starts_with("stiffness = -3"));
    assert!(message(maximum_stiffness(&good, 167.0)).contains("if 167 was meant in ms, write 0.167"));
    assert!(message(maximum_delay(&good, f64::NAN)).contains("NaN"));
    let held = DyadAxis::with_operators(1.0, 1.0, 1.0, 1.0, 5.0, 0.0, 0.0).unwrap();
    assert!(message(paper_critical_stiffness(&held)).contains("free handles"));
}

#[test]
fn ref_decay_range_is_too_soft_below_and_too_stiff_above() {
    let x = hman().axis(0).unwrap();
    let ranges = decay_stiffness(&x, 0.02, 3.0).unwrap();
    assert_eq!(ranges.len(), 1);
    let (soft, stiff) = ranges[0];
    let abscissa = |k: f64| {
        let delay = Delay::each_way(0.02).unwrap();
        telespring::spectrum::spectral_abscissa(&x, k, &delay).unwrap().value
    };
    close(abscissa(soft), -3.0, 1e-9);
    close(abscissa(stiff), -3.0, 1e-9);
    assert!(abscissa(0.9 * soft) > -3.0 && abscissa(1.1 * stiff) > -3.0);
    for i in 1..100 {
        assert!(abscissa(soft + (stiff - soft) * f64::from(i) / 100.0) < -3.0);
    }
    // Without a wanted decay it is the stable range.
    let stable = decay_stiffness(&x, 0.167, 0.0).unwrap();
    assert_eq!(stable[0].0, 0.0);
    close(stable[0].1, maximum_stiffness(&x, 0.167).unwrap(), 1e-9);
    assert_eq!(decay_stiffness(&x, 0.0, 0.0).unwrap(), [(0.0, f64::INFINITY)]);
    assert!(decay_stiffness(&x, 0.5, 9.0).unwrap().is_empty());
    assert!(decay_stiffness(&x, 0.5, 60.0).unwrap_err().to_string().contains("at most 5, that is 10 1/s"));
}

#[test]
fn ref_the_paper_promises_no_delay_without_damping() {
    // Eq. 9 is 0/0: without any damping every short delay destabilises.
    let undamped = axis(1.0, 0.0, 2.0, 0.0);
    assert_eq!(paper_maximum_delay(&undamped, 5.0).unwrap(), 0.0);
    assert_eq!(maximum_delay(&undamped, 5.0).unwrap(), 0.0);
}

/// The first unstable stiffness of a logarithmic range, if any.
fn unstable_between(axis: &DyadAxis, delay: f64, low: f64, high: f64) -> Option<f64> {
    (0..=300)
        .map(|i| low * (high / low).powf(f64::from(i) / 300.0))
        .find(|&k| unstable_root_count(axis, k, delay).unwrap() > 0)
}

#[test]
fn law_an_undamped_resonance_may_be_lost_at_the_softest_spring() {
    let grounded = |m: [f64; 2], b: [f64; 2], kh: [f64; 2]| {
        DyadAxis::with_operators(m[0], b[0], m[1], b[1], kh[0], kh[1], 0.0).unwrap()
    };
    let cases = [
        (grounded([1.0, 1.0], [0.0, 0.0], [10.0, 0.0]), 0.05),
        (grounded([3.41446, 1.07732], [0.0, 0.0], [9.5715, 0.0]), 0.09498),
        (grounded([3.41446, 1.07732], [0.0, 1.9e-6], [9.5715, 0.0]), 0.09498),
    ];
    for (axis, delay) in cases {
        assert_eq!(maximum_stiffness(&axis, delay).unwrap(), 0.0, "{axis:?}");
        let exchanged = DyadAxis { sides: [axis.sides[1], axis.sides[0]], ..axis };
        assert_eq!(maximum_stiffness(&exchanged, delay).unwrap(), 0.0, "{axis:?}");
    }
}

#[test]
fn law_an_undamped_resonance_may_be_lost_just_above_the_softest_spring() {
    // The delay turns the bare resonance by half a turn, by one, and a little less or more.
    let axis = DyadAxis::with_operators(1.0, 0.0, 2.0, 0.0, 10.0, 0.0, 0.0).unwrap();
    let damped = DyadAxis::with_operators(1.0, 0.0, 2.0, 1e-3, 10.0, 0.0, 0.0).unwrap();
    let turn = std::f64::consts::PI / 10.0_f64.sqrt();
    for beside in [1e-3, 1e-5, 1e-7] {
        // Re s grows with sin(ω T): past half a turn it falls first, past a whole one it rises.
        for (turns, stable) in [(1.0 - beside, false), (1.0 + beside, true), (2.0 + beside, false)] {
            let most = maximum_stiffness(&axis, 0.5 * turns * turn).unwrap();
            assert_eq!(most > 0.0, stable, "{turns} {most}");
        }
        // Just short of a turn: lost where (1 + k/10)^½ makes up for it: K = 10 `beside` to first order.
        let most = maximum_stiffness(&axis, 0.5 * (2.0 - beside) * turn).unwrap();
        close(most, 10.0 * beside, 10.0 * beside + 1e-9);
        let most = maximum_stiffness(&damped, 0.5 * (2.0 - 0.1) * turn).unwrap();
        assert!(most > 0.0 && unstable_between(&damped, 0.95 * turn, 1e-3 * most, most * 0.999).is_none());
    }
}

#[test]
fn ref_an_undamped_held_side_beside_a_damper_has_a_critical_stiffness() {
    let held = |kh1, kh2| DyadAxis::with_operators(1.0, 0.0, 2.0, 3.0, kh1, kh2, 4.0).unwrap();
    let axis = held(50.0, 20.0);
    let critical = critical_stiffness(&axis);
    assert!(critical > 1e-3);
    for i in 1..400 {
        assert!(crossings(&axis, critical * f64::from(i) / 400.0).unwrap().is_empty());
    }
    assert!(!crossings(&axis, critical * (1.0 + 1e-6)).unwrap().is_empty());
    // Tuned alike and undamped on both sides, the common motion never meets the damper.
    let alike = DyadAxis::with_operators(1.0, 0.0, 2.0, 0.0, 10.0, 20.0, 4.0).unwrap();
    assert_eq!(critical_stiffness(&alike), 0.0);
    let refused = decay_stiffness(&alike, 0.1, 0.0).unwrap_err();
    assert!(refused.to_string().contains("a decay rate above 0 is required"));
}

/// The smallest stiffness of a fine grid at which the delay is unstable.
fn first_unstable(axis: &DyadAxis, delay: f64, up_to: f64, steps: u32) -> Option<f64> {
    (1..=steps)
        .map(|i| up_to * f64::from(i) / f64::from(steps))
        .find(|&k| unstable_root_count(axis, k, delay).unwrap() > 0)
}

fn any_axis() -> impl Strategy<Value = DyadAxis> {
    let decade = || (-1.0f64..1.0).prop_map(|e| 10f64.powf(e));
    let ground = || prop_oneof![Just(0.0), (0.0f64..3.0).prop_map(|e| 10f64.powf(e))];
    let damper = prop_oneof![Just(0.0), (-1.0f64..1.0).prop_map(|e| 10f64.powf(e))];
    (decade(), decade(), decade(), decade(), ground(), ground(), damper).prop_map(
        |(m1, b1, m2, b2, kh1, kh2, c)| DyadAxis::with_operators(m1, b1, m2, b2, kh1, kh2, c).unwrap(),
    )
}

#[test]
fn law_a_search_without_an_answer_is_refused() {
    let damped = |b: f64| DyadAxis::new(1.0, b, 1.0, b).unwrap();
    for (axis, delay, outcome) in [
        (damped(7.0), 1e-320, "found none below an unstable stiffness"),
        (damped(1e-200), 0.1, "found no unstable stiffness"),
    ] {
        let refusal = maximum_stiffness(&axis, delay).unwrap_err();
        assert!(refusal.allowed.contains(outcome), "{refusal}");
    }
    // The remedy: what is negligible is set to 0.
    assert_eq!(maximum_stiffness(&damped(7.0), 0.0).unwrap(), f64::INFINITY);
    assert_eq!(maximum_stiffness(&damped(0.0), 0.1).unwrap(), 0.0);
}

/// Rounding hid the valley of the light side: the critical stiffness was three times, the maximum four times too
/// large. The maximum is from characteristic roots counted with 120 digits.
#[test]
fn ref_a_light_side_at_a_heavy_one() {
    let axis = DyadAxis::with_operators(
        5.1005063247995423e2,
        1.4610507688675192e5,
        4.689497401853613e-4,
        1.0121099142450593e-6,
        0.0,
        6.049123375253727e-16,
        4.921014415145325e-5,
    )
    .unwrap();
    let critical = critical_stiffness(&axis);
    assert!(crossings(&axis, critical * (1.0 - 1e-6)).unwrap().is_empty(), "{critical}");
    assert!(!crossings(&axis, critical * (1.0 + 1e-6)).unwrap().is_empty(), "{critical}");
    let most = maximum_stiffness(&axis, 2.7342371819029864e-6).unwrap();
    assert!((most / 11_318_365.164 - 1.0).abs() < 1e-8, "{most}");
}

#[test]
fn law_delays_that_were_not_examined_are_not_stable() {
    let axis = DyadAxis::with_operators(1.0, 2.0, 1.0, 2.0, 50.0, 50.0, 0.0).unwrap();
    // The softest spring with a crossing: two of them follow each other for more than a million periods.
    let critical = critical_stiffness(&axis);
    let (mut none, mut some) = (critical * (1.0 - 1e-8), critical * (1.0 + 1e-8));
    for _ in 0..60 {
        let middle = 0.5 * (none + some);
        if crossings(&axis, middle).unwrap().is_empty() { none = middle } else { some = middle }
    }
    let last = stable_delays(&axis, some, f64::INFINITY).unwrap().last().unwrap().1;
    let followed = crossings(&axis, some)
        .unwrap()
        .iter()
        .map(|crossing| crossing.delay + 1e6 * crossing.period())
        .fold(f64::INFINITY, f64::min);
    assert!(last <= followed, "{last} {followed}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn law_partners_may_be_exchanged(axis in any_axis(), k in 0.1f64..500.0) {
        let exchanged = DyadAxis { sides: [axis.sides[1], axis.sides[0]], ..axis };
        let (a, b) = (maximum_delay(&axis, k).unwrap(), maximum_delay(&exchanged, k).unwrap());
        prop_assert!(a == b || (a - b).abs() < 1e-10 * a, "{} {}", a, b);
        let (a, b) = (critical_stiffness(&axis), critical_stiffness(&exchanged));
        prop_assert!((a - b).abs() <= 1e-9 * a, "{} {}", a, b);
    }

    #[test]
    fn law_time_scales(axis in any_axis(), k in 0.1f64..500.0, scale in 0.1f64..10.0) {
        // In a time that runs `scale` times slower, damping falls with it and stiffness with its square.
        let mut slow = axis;
        for side in &mut slow.sides {
            side.damping /= scale;
            side.ground_stiffness /= scale * scale;
        }
        slow.coupling_damping /= scale;
        let (a, b) = (
            maximum_delay(&axis, k).unwrap() * scale,
            maximum_delay(&slow, k / (scale * scale)).unwrap(),
        );
        prop_assert!(a == b || (a - b).abs() < 1e-9 * a, "{} {}", a, b);
    }

    #[test]
    fn law_crossings_solve_the_characteristic_equation(axis in any_axis(), k in 0.1f64..500.0) {
        for crossing in crossings(&axis, k).unwrap().iter() {
            let s = Complex64::new(0.0, crossing.frequency);
            let c = axis.coupling_damping;
            let [p1, p2] = axis.sides.map(|side| {
                s * s * side.mass + s * (side.damping + c) + k + side.ground_stiffness
            });
            let spring = s * c + k;
            let returned = spring * spring * (-s * 2.0 * crossing.delay).exp();
            prop_assert!((p1 * p2 - returned).norm() < 1e-9 * returned.norm());
        }
    }

    #[test]
    fn law_critical_stiffness_parts_none_from_some(axis in any_axis()) {
        let critical = critical_stiffness(&axis);
        for fraction in [0.01, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99, 0.999, 0.999_999, 1.0 - 1e-8] {
            prop_assert!(crossings(&axis, critical * fraction).unwrap().is_empty(), "{}", fraction);
        }
        prop_assert!(!crossings(&axis, critical * (1.0 + 1e-8)).unwrap().is_empty());
    }

    #[test]
    fn law_maximum_stiffness_is_the_first_loss(axis in any_axis(), turns in 0.05f64..6.0) {
        let critical = critical_stiffness(&axis);
        let mass = axis.sides[0].mass.min(axis.sides[1].mass);
        let delay = (turns * (mass / critical).sqrt()).min(50.0);
        let most = maximum_stiffness(&axis, delay).unwrap();
        prop_assert!(most >= critical * (1.0 - 1e-9));
        prop_assert_eq!(first_unstable(&axis, delay, most * (1.0 - 1e-9), 400), None);
        // A crossing really lies there.
        let near = stable_delays(&axis, most, 2.0 * delay).unwrap();
        let distance = near
            .iter()
            .flat_map(|&(a, b)| [(a - delay).abs(), (b - delay).abs()])
            .fold(f64::INFINITY, f64::min);
        prop_assert!(distance < 1e-6 * delay, "{:?} {} {}", near, delay, most);
    }

    #[test]
    fn law_maximum_stiffness_of_undamped_sides(
        axis in any_axis(), turns in 0.05f64..6.0, undamped in 0usize..3, light in prop_oneof![Just(0.0), (-8.0f64..-2.0).prop_map(|e| 10f64.powf(e))],
    ) {
        let mut axis = axis;
        axis.coupling_damping = 0.0;
        for (i, side) in axis.sides.iter_mut().enumerate() {
            if undamped == i || undamped == 2 {
                side.damping = 0.0;
            } else {
                side.damping = light;
            }
        }
        let [first, second] = axis.sides.map(|side| side.mass / side.ground_stiffness.max(1.0));
        let delay = (turns * first.min(second).sqrt()).min(50.0);
        let most = maximum_stiffness(&axis, delay).unwrap();
        // Below 1e-4 of the elastic terms two crossings lie too close for the count of roots.
        let resolved = 1e-4 * axis.sides.iter().map(|side| side.ground_stiffness).fold(1.0, f64::max);
        if most > 1.01 * resolved {
            prop_assert_eq!(unstable_between(&axis, delay, resolved, most * (1.0 - 1e-6)), None, "{}", most);
        }
        if most > 0.0 {
            prop_assert!(most < resolved || unstable_between(&axis, delay, most * (1.0 + 1e-6), most * 1.001).is_some(), "{}", most);
        } else {
            // Unstable from the softest spring on.
            prop_assert!(unstable_between(&axis, delay, resolved, 10.0 * resolved).is_some());
        }
    }

    #[test]
    fn law_minimum_damping_is_the_last_loss(axis in any_axis(), factor in 0.5f64..6.0, turns in 0.05f64..6.0) {
        let k = factor * critical_stiffness(&axis);
        let mass = axis.sides[0].mass.min(axis.sides[1].mass);
        let delay = (turns * (mass / k).sqrt()).min(50.0);
        let added = minimum_damping(&axis, k, delay).unwrap();
        let unstable = |d: f64| {
            let mut damped = axis;
            damped.sides.iter_mut().for_each(|side| side.damping += d);
            unstable_root_count(&damped, k, delay).unwrap()
        };
        let largest =
            axis.sides.iter().map(|s| (2.0 * s.mass * (k + s.ground_stiffness)).sqrt()).fold(1.0, f64::max);
        for i in 1..=200 {
            let d = added * (1.0 + 1e-9) + largest * f64::from(i) / 200.0;
            prop_assert_eq!(unstable(d), 0, "{} beyond {}", d, added);
        }
        if added > 0.0 {
            prop_assert_ne!(unstable(added * (1.0 - 1e-7)), unstable(added * (1.0 + 1e-7)));
        } else {
            prop_assert_eq!(unstable(0.0), 0);
        }
    }

    #[test]
    fn law_map_agrees_with_the_count_of_roots(axis in any_axis(), k in 0.1f64..500.0) {
        let delays: Vec<f64> = (0..50).map(|i| 0.02 * f64::from(i)).collect();
        let map = stability_map(&axis, &[k], &delays).unwrap();
        for (&delay, stable) in delays.iter().zip(map) {
            prop_assert_eq!(stable, unstable_root_count(&axis, k, delay).unwrap() == 0);
        }
    }
}
