use proptest::prelude::*;

use super::*;

/// The polynomial with the given roots, in double-double, so that its coefficients are exact for
/// the roots used here.
fn from_roots(roots: &[f64], scale: f64) -> Polynomial<TwoFloat, 7> {
    let mut coefficient = [TwoFloat::from(0.0); 7];
    coefficient[0] = TwoFloat::from(scale);
    for (degree, &root) in roots.iter().enumerate() {
        for i in (0..=degree + 1).rev() {
            let below = if i > 0 { coefficient[i - 1] } else { TwoFloat::from(0.0) };
            coefficient[i] = below - coefficient[i] * root;
        }
    }
    Polynomial { magnitude: coefficient.map(|c| c.to_f64().abs()), coefficient }
}

fn solve(fine: Polynomial<TwoFloat, 7>) -> Vec<(f64, i8)> {
    let coarse = Polynomial { coefficient: fine.coefficient.map(|c| c.to_f64()), magnitude: fine.magnitude };
    positive_roots(&coarse, || fine).iter().map(|root| (root.at, root.slope)).collect()
}

#[test]
fn ref_wilkinson_roots_are_found() {
    let roots = solve(from_roots(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], 1.0));
    assert_eq!(roots.len(), 6);
    for (i, (at, slope)) in roots.iter().enumerate() {
        assert!((at - (i + 1) as f64).abs() < 1e-14 * at);
        assert_eq!(*slope, if i % 2 == 0 { -1 } else { 1 });
    }
}

#[test]
fn ref_double_root_touches_and_triple_root_crosses() {
    assert_eq!(solve(from_roots(&[2.0, 2.0, -1.0], 3.0)), vec![(2.0, 0)]);
    let triple = solve(from_roots(&[0.5, 0.5, 0.5, -3.0], 1.0));
    assert_eq!(triple.len(), 1);
    assert!((triple[0].0 - 0.5).abs() < 1e-9 && triple[0].1 == 1);
}

#[test]
fn ref_close_pair_is_not_missed() {
    // Far closer than f64 can tell apart from its rounded coefficients.
    for exponent in [4, 6, 8, 10, 12] {
        let gap = 2f64.powi(-3 * exponent);
        let roots = solve(from_roots(&[1.0, 1.0 + gap, -2.0, 40.0], 1.0));
        assert_eq!(roots.len(), 3, "gap {gap:e}");
        assert!((roots[1].0 - roots[0].0 - gap).abs() < 1e-2 * gap + 2.3e-16, "gap {gap:e}");
    }
}

#[test]
fn ref_roots_over_many_decades() {
    let roots = solve(from_roots(&[1e-9, 1e-3, 1e3, 1e9], 1e-7));
    let expected = [1e-9, 1e-3, 1e3, 1e9];
    assert_eq!(roots.len(), 4);
    for ((at, _), expected) in roots.iter().zip(expected) {
        assert!((at - expected).abs() < 1e-13 * expected);
    }
}

#[test]
fn ref_no_positive_root() {
    assert!(solve(from_roots(&[-1.0, -2.0, -3.0], 1.0)).is_empty());
    assert!(solve(from_roots(&[], 5.0)).is_empty());
}

proptest! {
    #[test]
    fn law_every_positive_root_is_found(
        exponents in prop::collection::vec(-4.0f64..4.0, 1..=5),
        negative in prop::collection::vec(0.01f64..100.0, 0..=1),
        scale in 1e-3f64..1e3,
    ) {
        let mut positive: Vec<f64> = exponents.iter().map(|e| 10f64.powf(*e)).collect();
        positive.sort_by(f64::total_cmp);
        prop_assume!(positive.windows(2).all(|pair| pair[1] > pair[0] * (1.0 + 1e-4)));
        let all: Vec<f64> = positive.iter().copied().chain(negative.iter().map(|x| -x)).collect();
        let found = solve(from_roots(&all, scale));
        prop_assert_eq!(found.len(), positive.len());
        for ((at, _), expected) in found.iter().zip(&positive) {
            prop_assert!((at - expected).abs() < 1e-11 * expected, "{} for {}", at, expected);
        }
    }
}

#[test]
fn ref_a_tiny_root_is_as_accurate_as_any() {
    let coefficient =
        [1.0104815208486978e-28, -595821443.5137093, -595821443.5137254, -595821443.5137254, 0.0];
    let magnitude = coefficient.map(f64::abs);
    let fine = || Polynomial { coefficient: coefficient.map(TwoFloat::from), magnitude };
    let roots = positive_roots(&Polynomial { coefficient, magnitude }, fine);
    let expected = coefficient[0] / -coefficient[1];
    assert_eq!(roots.len(), 1);
    assert!((roots[0].at - expected).abs() < 1e-14 * expected, "{} {expected}", roots[0].at);
}

#[test]
fn ref_a_root_beyond_every_number_does_no_harm() {
    // x² − 3x + 1 with a leading term that rules only from 1e300 on, or never.
    let golden = (3.0 - 5.0_f64.sqrt()) / 2.0;
    for leading in [1e-300, 1e-308, 5e-324] {
        let coefficient = [-1.0, 3.0, -1.0, leading, 0.0];
        let magnitude = coefficient.map(f64::abs);
        let fine = || Polynomial { coefficient: coefficient.map(TwoFloat::from), magnitude };
        let roots = positive_roots(&Polynomial { coefficient, magnitude }, fine);
        assert!(roots.len() >= 2, "{leading:e} {:?}", &*roots);
        assert!((roots[0].at - golden).abs() < 1e-14 && (roots[1].at - 1.0 / golden).abs() < 1e-14);
    }
}

#[test]
fn ref_a_double_double_quotient_has_all_its_digits() {
    // Times the divisor it is the dividend again, to 2⁻¹⁰⁰; the crate's own division stops at 2⁻⁵³.
    let mut seed = 12345_u64;
    let mut random = || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        0.5 + (seed >> 11) as f64 / (1u64 << 53) as f64
    };
    for _ in 0..1000 {
        let [a, b] = [0, 1].map(|_| TwoFloat::new_add(random(), 1e-17 * random()));
        let quotient = a.divided_by(b);
        assert!((quotient * b - a).to_f64().abs() < 1e-30, "{a} / {b}");
    }
    let third = TwoFloat::from(1.0).divided_by(TwoFloat::from(3.0));
    assert!((third * 3.0 - 1.0).to_f64().abs() < 1e-31);
}
