//! Almost zero is zero in the limit, and the whole allowed domain of values ends.

use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use telespring::criteria::*;
use telespring::spectrum::spectral_abscissa;
use telespring::verdicts::{Network, Tier, verdicts};
use telespring::{Delay, Dyad, DyadAxis, Operator, Robot};

fn close(value: f64, expected: f64, relative: f64) {
    assert!(
        (value - expected).abs() <= relative * expected.abs(),
        "{value} is not within {relative:e} of {expected}"
    );
}

/// The x axis of the two H-MANs with one more value, such as an operator stiffness.
fn hman_x(kh1: f64, kh2: f64, c: f64) -> DyadAxis {
    DyadAxis::with_operators(0.8334, 7.7257, 0.7776, 7.4208, kh1, kh2, c).unwrap()
}

const VANISHING: [f64; 8] = [1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14, 1e-16, 1e-300];

/// Each number that a vanishing ε changes tends to the number at 0: to first order here.
fn tends(limit: f64, at: impl Fn(f64) -> f64) {
    for tiny in VANISHING {
        close(at(tiny), limit, 2.0 * tiny + 1e-11);
    }
}

#[test]
fn law_a_vanishing_operator_stiffness_is_a_free_handle() {
    let free = hman_x(0.0, 0.0, 0.0);
    for place in [[1.0, 0.0], [0.0, 1.0], [1.0, 0.3]] {
        let held = |tiny: f64| hman_x(tiny * place[0], tiny * place[1], 0.0);
        let stiffness = maximum_stiffness(&free, 0.1).unwrap();
        tends(stiffness, |tiny| maximum_stiffness(&held(tiny), 0.1).unwrap());
        let damping = minimum_damping(&free, 200.0, 0.1).unwrap();
        tends(damping, |tiny| minimum_damping(&held(tiny), 200.0, 0.1).unwrap());
        let delay = maximum_delay(&free, 71.2).unwrap();
        tends(delay, |tiny| maximum_delay(&held(tiny), 71.2).unwrap());
        for tiny in VANISHING {
            // The crossing enters at ω = 0: its stiffness moves with √ε.
            close(critical_stiffness(&held(tiny)), critical_stiffness(&free), 2.0 * tiny.sqrt() + 1e-9);
        }
    }
}

#[test]
fn law_a_vanishing_damping_or_damper_is_none() {
    let delay = 0.1;
    let limit = maximum_stiffness(&hman_x(0.0, 0.0, 0.0), delay).unwrap();
    tends(limit, |tiny| maximum_stiffness(&hman_x(0.0, 0.0, tiny), delay).unwrap());
    let half = |b2: f64| DyadAxis::new(0.8334, 7.7257, 0.7776, b2).unwrap();
    let limit = maximum_stiffness(&half(0.0), delay).unwrap();
    assert!(limit > 1.0);
    tends(limit, |tiny| maximum_stiffness(&half(tiny), delay).unwrap());
    let grounded = |b1: f64| DyadAxis::with_operators(1.0, b1, 2.0, 3.0, 40.0, 0.0, 0.0).unwrap();
    let limit = maximum_stiffness(&grounded(0.0), 0.4).unwrap();
    assert!(limit > 1.0, "{limit}");
    tends(limit, |tiny| maximum_stiffness(&grounded(tiny), 0.4).unwrap());
}

#[test]
fn law_sampled_verdicts_tend_to_the_free_and_to_the_continuous_ones() {
    let dyad = |kh: f64| {
        let robot = |m, b| Robot::new(vec![m], vec![b], None).unwrap();
        let operator = |kh| Operator::new(vec![0.0], vec![0.0], vec![kh]).unwrap();
        let operators = Some([operator(kh), operator(0.0)]);
        Dyad::new(robot(0.8334, 7.7257), robot(0.7776, 7.4208), operators, 0.0).unwrap()
    };
    let network =
        |h: f64, computing: f64| Network::new(Delay::each_way(0.1).unwrap(), 0.0, 0.0, h, computing).unwrap();
    let sampled = |kh: f64, h: f64| verdicts(&dyad(kh), None, 20.0, &network(h, 0.0)).unwrap();
    let free = sampled(0.0, 1e-3);
    let bound = free.axes[0].sampled_stiffness_bound.unwrap();
    for tiny in VANISHING {
        let held = sampled(tiny, 1e-3);
        assert_eq!(held.sampled_stable, Some(true), "{tiny:e}");
        close(held.axes[0].sampled_stiffness_bound.unwrap(), bound, 2.0 * tiny + 1e-11);
        // A hand that barely holds allows more than none, by the logarithm of its stiffness.
        let [any, none] = [&held, &free].map(|v| v.tier(Tier::AnyNetwork).stiffness_bound.unwrap());
        assert!(any >= none * (1.0 - 1e-12) && any < 1.1 * none, "{tiny:e} {any} {none}");
    }
    // A hold adds half a period to the age of both samples: the bound moves with h.
    let continuous = maximum_stiffness(&hman_x(0.0, 0.0, 0.0), 0.1).unwrap();
    for h in [1e-2, 1e-3, 1e-4, 1e-5, 1e-6] {
        let found = sampled(0.0, h).axes[0].sampled_stiffness_bound.unwrap();
        close(found, continuous, 20.0 * h);
        assert!(found < continuous);
    }
}

/// Exactly b²/(2m) is representable here: F touches zero at ω = 0, and no delay destabilises.
#[test]
fn ref_at_exactly_the_critical_stiffness_no_delay_destabilises() {
    for (m, b) in [(1.0, 3.0), (0.5, 3.0), (1.5, 3.0), (0.75, 1.5), (3.0, 3.0), (2.5, 5.0), (0.375, 0.75)] {
        let identical = DyadAxis::new(m, b, m, b).unwrap();
        assert_eq!(maximum_delay(&identical, b * b / (2.0 * m)).unwrap(), f64::INFINITY, "{m} {b}");
    }
}

/// Without delay two undamped robots drift together for ever; any short delay stops them.
#[test]
fn law_undamped_robots_with_a_coupling_damper_have_a_maximum_delay() {
    for (m1, m2, k, c) in [(1.0, 2.0, 5.0, 1.0), (0.3, 0.7, 50.0, 4.0), (2.0, 2.0, 20.0, 0.3)] {
        let axis = DyadAxis::with_operators(m1, 0.0, m2, 0.0, 0.0, 0.0, c).unwrap();
        let end = maximum_delay(&axis, k).unwrap();
        assert_eq!(stable_delays(&axis, k, 2.0 * end).unwrap()[0].1, end);
        let abscissa =
            |part: f64| spectral_abscissa(&axis, k, &Delay::each_way(part * end).unwrap()).unwrap().value;
        assert!(abscissa(0.01) < 0.0 && abscissa(0.99) < 0.0 && abscissa(1.01) > 0.0, "{axis:?}");
        let damped = DyadAxis::with_operators(m1, 1e-12, m2, 1e-12, 0.0, 0.0, c).unwrap();
        close(maximum_delay(&damped, k).unwrap(), end, 1e-10);
        assert!(maximum_stiffness(&axis, 0.5 * end).unwrap() > k);
    }
}

/// A short delay feeds the relative motion, ω² = k (1/m₁ + 1/m₂), by its phase ωT; the dampings take
/// (b₁ m₂/m₁ + b₂ m₁/m₂) ω/k of phase: K T tends to that sum.
#[test]
fn ref_the_stiffness_at_a_vanishing_delay() {
    for [m1, b1, m2, b2] in [
        [0.8334, 7.7257, 0.7776, 7.4208],
        [1.0, 1e-3, 1.0, 0.0],
        [2.0, 0.0, 0.3, 5.0],
        [8e3, 2e-3, 5e-4, 0.0],
        [1e-4, 3.0, 1e4, 1e-6],
    ] {
        let axis = DyadAxis::new(m1, b1, m2, b2).unwrap();
        let sum = b1 * m2 / m1 + b2 * m1 / m2;
        // Short beside every time constant.
        let delay = 1e-6 * (m1.min(m2) / b1.max(b2)).min((m1.min(m2)).powi(2) / (sum * m1.max(m2)));
        close(2.0 * delay * maximum_stiffness(&axis, delay).unwrap(), sum, 1e-6);
    }
}

#[test]
fn law_a_slow_decay_is_no_reason_to_refuse() {
    let x = hman_x(0.0, 0.0, 0.0);
    let [(soft, stiff)] = decay_stiffness(&x, 0.02, 1e-7).unwrap()[..] else { panic!("one range") };
    // The slow root of two free robots under a soft spring: k (1/b₁ + 1/b₂).
    close(soft, 1e-7 / (1.0 / 7.7257 + 1.0 / 7.4208), 1e-5);
    close(stiff, maximum_stiffness(&x, 0.02).unwrap(), 1e-6);
}

/// Values over the whole domain of the quantities, a third of the dampings and half of the grounds zero.
fn any_allowed() -> impl Strategy<Value = (DyadAxis, f64, f64)> {
    let decades = |low: f64, high: f64| (low..high).prop_map(|exponent| 10f64.powf(exponent));
    let or_zero = |low, high| prop_oneof![1 => Just(0.0), 2 => decades(low, high)];
    (
        prop::array::uniform2(decades(-4.0, 4.0)),
        prop::array::uniform2(or_zero(-6.0, 6.0)),
        prop::array::uniform2(or_zero(-18.0, 7.0)),
        or_zero(-6.0, 6.0),
        decades(-6.0, 7.0),
        decades(-9.0, 2.0),
    )
        .prop_map(|(m, b, kh, c, k, delay)| {
            (DyadAxis::with_operators(m[0], b[0], m[1], b[1], kh[0], kh[1], c).unwrap(), k, delay)
        })
}

/// Every criterion ends with a number that the count of roots confirms, or with a refusal; returns the number of
/// refusals.
fn ends(axis: &DyadAxis, k: f64, delay: f64) -> usize {
    let critical = critical_stiffness(axis);
    assert!(critical >= 0.0);
    assert!(maximum_delay(axis, k).unwrap() >= 0.0);
    let mut refused = 0;
    let is_allowed = |k: f64| (1e-6..1e7).contains(&k);
    match maximum_stiffness(axis, delay) {
        Ok(most) => {
            for part in [0.1, 0.5, 0.9, 0.99, 0.9999] {
                // Below 1e-6 of the elastic terms two crossings lie too close for the count of roots.
                let resolved = axis.sides.iter().all(|side| part * most > 1e-6 * side.ground_stiffness);
                if is_allowed(part * most) && resolved {
                    let count = unstable_root_count(axis, part * most, delay).unwrap();
                    assert_eq!(count, 0, "{part} of {most} {axis:?} {delay}");
                }
            }
        }
        Err(refusal) => {
            assert!(refusal.to_string().contains("did not end"), "{refusal}");
            refused += 1;
        }
    }
    match minimum_damping(axis, k, delay) {
        Ok(added) => {
            for part in [1.0001, 1.01, 1.5, 10.0] {
                let mut damped = *axis;
                damped.sides.iter_mut().for_each(|side| side.damping += part * added);
                // Rounding hides an addition of 1e-9 of a side's damping.
                let is_seen = axis.sides.iter().all(|side| added > 1e-9 * side.damping);
                let count = unstable_root_count(&damped, k, delay).unwrap();
                assert!(count == 0 || !is_seen, "{part} of {added} {axis:?} {k} {delay}");
            }
        }
        Err(refusal) => {
            assert!(refusal.to_string().contains("did not end"), "{refusal}");
            refused += 1;
        }
    }
    refused
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..Default::default() })]

    #[test]
    fn law_the_whole_domain_ends((axis, k, delay) in any_allowed()) {
        ends(&axis, k, delay);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..Default::default() })]

    #[test]
    #[ignore = "minutes; make verify"]
    fn law_the_whole_domain_ends_2000((axis, k, delay) in any_allowed()) {
        ends(&axis, k, delay);
    }
}

#[test]
fn law_a_dyad_at_its_limit_has_verdicts_and_needs_hardly_any_damping() {
    // A root pair on the imaginary axis lies at no added damping, up to rounding.
    let mut random = ChaCha8Rng::seed_from_u64(41);
    for _ in 0..300 {
        let [m1, m2] = [0, 1].map(|_| random.random_range(0.5..3.0));
        let [b1, b2] = [0, 1].map(|_| random.random_range(2.0..20.0));
        let axis = DyadAxis::new(m1, b1, m2, b2).unwrap();
        let k = 2.0 * critical_stiffness(&axis);
        let delay = maximum_delay(&axis, k).unwrap();
        let added = minimum_damping(&axis, k, delay).unwrap();
        assert!(added < 1e-6, "{added} N·s/m at {axis:?}, {k} N/m, {delay} s");
        let more = DyadAxis::new(m1, b1 + added + 1e-6, m2, b2 + added + 1e-6).unwrap();
        assert!(maximum_delay(&more, k).unwrap() > delay);
        let robots = [(m1, b1), (m2, b2)].map(|(m, b)| Robot::new(vec![m], vec![b], None).unwrap());
        let [one, other] = robots;
        let dyad = Dyad::new(one, other, None, 0.0).unwrap();
        for factor in [1.0 - 1e-15, 1.0, 1.0 + 1e-15] {
            let network = Network::constant(Delay::each_way(factor * delay).unwrap());
            assert!(verdicts(&dyad, None, k, &network).is_ok());
        }
    }
}
