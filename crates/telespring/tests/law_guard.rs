//! Laws of the guard: whatever the network, the partner or the prediction, no side gives out energy that it has not.

mod guard_support;

use std::collections::BTreeSet;

use guard_support::copy::{GuardCopy, Missing};
use guard_support::{Case, Law as Broken, run};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use telespring::session::strategy::{Guard, Strategy};

fn guards(case: &Case) -> [Box<dyn Strategy>; 2] {
    case.sides.each_ref().map(|side| {
        let guard: Box<dyn Strategy> = Box::new(Guard::new(case.law, side.settings).unwrap());
        guard
    })
}

/// The seed of the random cases: fixed, or drawn by `make verify`.
fn seed() -> u64 {
    std::env::var("TELESPRING_VERIFY").ok().and_then(|seed| seed.parse().ok()).unwrap_or(20_260_214)
}

fn check_cases(cases: u64, ticks: usize) {
    for number in 0..cases {
        let mut random = ChaCha8Rng::seed_from_u64(seed() ^ (number << 32));
        let case = Case::random(&mut random, ticks);
        let stream = random.next_u64();
        if let Err(violation) = run(&case, guards(&case), &mut ChaCha8Rng::seed_from_u64(stream)) {
            panic!("case {number} of seed {}: {violation:?}\n{case:#?}", seed());
        }
    }
}

#[test]
fn law_no_network_partner_or_prediction_breaks_the_account() {
    check_cases(300, 2000);
}

#[test]
#[ignore = "10^4 cases take minutes"]
fn law_no_network_partner_or_prediction_breaks_the_account_in_many_cases() {
    check_cases(10_000, 5000);
}

/// The laws that are broken first, over random cases, without one term of the account.
fn first_broken(missing: Missing, cases: u64) -> BTreeSet<Broken> {
    let mut broken = BTreeSet::new();
    for number in 0..cases {
        let mut random = ChaCha8Rng::seed_from_u64(77 + number);
        let case = Case::random(&mut random, 1500);
        let strategies = case.sides.each_ref().map(|side| {
            let strategy: Box<dyn Strategy> = Box::new(GuardCopy::new(missing, case.law, side.settings));
            strategy
        });
        if let Err(violation) = run(&case, strategies, &mut random) {
            broken.insert(violation.law);
        }
    }
    broken
}

#[test]
fn law_every_term_of_the_account_is_needed() {
    for (missing, expected) in [
        (Missing::Nothing, &[][..]),
        (Missing::GivenOut, &[Broken::Account]),
        (Missing::ActedForce, &[Broken::Account]),
        (Missing::Share, &[Broken::Account]),
        (Missing::LowerEnd, &[Broken::Account]),
        (Missing::HiddenByEncoder, &[Broken::Account]),
        (Missing::EncoderInLoss, &[Broken::Account]),
        (Missing::RunningTotal, &[Broken::Intake]),
        (Missing::IntakePower, &[Broken::Intake]),
        (Missing::Sent, &[Broken::Account]),
        (Missing::Deficit, &[Broken::Account]),
        (Missing::Limit, &[Broken::Force]),
    ] {
        let broken = first_broken(missing, 40);
        println!("{missing:?}: {broken:?}");
        assert!(expected.iter().all(|law| broken.contains(law)), "{missing:?}: {broken:?}");
        assert_eq!(broken.is_empty(), expected.is_empty(), "{missing:?}: {broken:?}");
    }
}
