//! After the hands let go, both robots come to rest.

use crate::case::Case;
use crate::run::run;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use telespring::session::Span;

/// How fast the losses that are not given out again take the motion of an axis at least, 1/s.
fn decay(case: &Case) -> f64 {
    let axes = case.sides.iter().flat_map(|side| {
        [0, 1].map(|axis| {
            (side.damping[axis] - side.settings.share * side.settings.damping[axis]) / side.mass[axis]
        })
    });
    axes.fold(f64::INFINITY, f64::min)
}

/// Dyads that lose enough come to rest on every network whose totals are true, with the shared target still moving. For how
/// long a little energy lets a handle creep towards its partner, nobody can say: what is certain is the bound on the losses,
/// `DiesOut`, which every random case obeys. Here a minute is enough for less than 5 mm/s: 5 s for what waits to be taken in,
/// and 55 time constants or more.
#[test]
fn law_both_robots_come_to_rest_after_the_hands_let_go() {
    let (mut tried, mut number) = (0, 0);
    while tried < 25 {
        number += 1;
        let mut random = ChaCha8Rng::seed_from_u64(number);
        let mut case = Case::random(&mut random, 0).at_period(Span(4_000_000));
        if !(case.is_honest(0) && case.is_honest(1)) || decay(&case) < 1.0 {
            continue;
        }
        tried += 1;
        (case.let_go, case.ticks) = (500, 500 + 15_000);
        let outcome = run(&case, random.next_u64(), &[]).unwrap();
        println!("case {number}: {:.1e} m/s", outcome.last_speed);
        assert!(outcome.last_speed < 5e-3, "{number}: {} m/s\n{case:#?}", outcome.last_speed);
    }
}
