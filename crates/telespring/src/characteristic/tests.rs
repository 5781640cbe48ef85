use super::*;

fn cases() -> impl Iterator<Item = (Characteristic, Complex64)> {
    let axes = [
        DyadAxis::with_operators(0.8, 7.0, 0.9, 6.0, 0.0, 0.0, 0.0),
        DyadAxis::with_operators(0.8, 7.0, 2.5, 1.0, 0.0, 0.0, 3.0),
        DyadAxis::with_operators(0.8, 7.0, 2.5, 1.0, 30.0, 10.0, 3.0),
    ];
    axes.into_iter().flat_map(|axis| {
        let chi = Characteristic::new(&axis.unwrap(), 71.2, 0.3);
        (-20..20).flat_map(move |i| {
            (1..20).map(move |j| (chi, Complex64::new(0.2 * f64::from(i), 0.7 * f64::from(j))))
        })
    })
}

/// What rounding may change of either form, relative to the sizes of its terms.
fn size(chi: &Characteristic, s: Complex64) -> f64 {
    let [one, two] = chi.sides.map(|side| side.bounds(s.norm())[0]);
    let coupling = chi.coupling(s).norm_sqr();
    one * two + coupling * (1.0 + (-s.re * chi.round_trip).exp())
}

#[test]
fn law_both_forms_agree() {
    for (chi, s) in cases() {
        let exponential = DelayExponential::at(s, chi.round_trip);
        let (a, b) = (chi.jet_by_sides(s, &exponential), chi.jet_by_remainder(s, &exponential));
        let rounding = 1e-14 * size(&chi, s) * (1.0 + s.norm().recip());
        assert!((a.value - b.value).norm() < rounding, "{chi:?} {s}");
        assert!((a.value - chi.value(s)).norm() < rounding, "{chi:?} {s}");
        assert!((a.slope - b.slope).norm() < 10.0 * rounding, "{chi:?} {s}");
    }
}

#[test]
fn law_the_slope_is_the_limit_of_differences_and_the_curvature_bounds_the_rest() {
    let step = 1e-3;
    for (chi, s) in cases() {
        let direction = Complex64::new(0.6, 0.8) * step;
        let jet = chi.jet(s);
        let change = chi.value(s + direction) - jet.value;
        let growth = (-(s.re - step) * chi.round_trip).exp().max(1.0);
        let bound = chi.curvature(s.norm() - step, s.norm() + step, growth);
        let rounding = 1e-13 * size(&chi, s);
        let rest = (change - jet.slope * direction).norm();
        assert!(rest <= 0.5 * bound * step * step + rounding, "{chi:?} {s}: {rest}");
    }
}

#[test]
fn law_normalising_divides_by_both_masses() {
    for (chi, s) in cases() {
        let product = chi.sides[0].mass * chi.sides[1].mass;
        let (whole, unit) = (chi.jet(s), chi.normalised().jet(s));
        let rounding = 1e-13 * size(&chi, s) / product;
        assert!((whole.value / product - unit.value).norm() < rounding, "{chi:?} {s}");
        assert!((whole.slope / product - unit.slope).norm() < 10.0 * rounding, "{chi:?} {s}");
    }
}

#[test]
fn ref_the_held_exponential_has_its_taylor_series_about_rest() {
    let round_trip: f64 = 0.5;
    // On both sides of |T s| = 1e-3, where the closed form takes over.
    for size in [0.0, 1e-9, 1e-4, 1.9e-3, 2.1e-3, 1e-2] {
        let s = Complex64::from_polar(size, 0.8);
        let (mut value, mut slope) = (Complex64::ZERO, Complex64::ZERO);
        let mut term = Complex64::from(round_trip);
        let mut derived = Complex64::from(-0.5 * round_trip * round_trip);
        for n in 1..12 {
            value += term;
            slope += derived;
            term *= -s * round_trip / f64::from(n + 1);
            derived *= -s * round_trip * f64::from(n + 1) / (f64::from(n) * f64::from(n + 2));
        }
        let held = DelayExponential::at(s, round_trip).integral(s, round_trip);
        assert!((held.value - value).norm() < 1e-15, "{s}");
        // The closed form of the slope loses ε/|T s| to cancellation, at most 2e-13 here.
        assert!((held.slope - slope).norm() < 1e-12, "{s}");
    }
}
