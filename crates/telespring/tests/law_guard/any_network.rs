//! Laws of the guard: whatever the network, the partner or the prediction, no side gives out energy that it has not.

use std::collections::BTreeSet;

use crate::support::copy::{GuardCopy, Missing};
use crate::support::{Case, Law as Broken, Network, run};
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
#[allow(clippy::disallowed_methods, reason = "make verify passes its seed this way")]
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

/// The laws that are found broken first over random cases without one term of the account, `unchecked` ones left out; no
/// further case is tried once one of the `expected` is found.
fn broken_without(missing: Missing, unchecked: &'static [Broken], expected: &[Broken]) -> BTreeSet<Broken> {
    let mut broken = BTreeSet::new();
    for number in 0..80 {
        let mut random = ChaCha8Rng::seed_from_u64(77 + number);
        let mut case = Case { unchecked, ..Case::random(&mut random, 1500) };
        if matches!(missing, Missing::Pending | Missing::Committed) {
            case.network = Network::Liar;
            for side in &mut case.sides {
                side.settings.computing_tick = true;
            }
        }
        let strategies = case.sides.each_ref().map(|side| {
            let strategy: Box<dyn Strategy> = Box::new(GuardCopy::new(missing, case.law, side.settings));
            strategy
        });
        if let Err(violation) = run(&case, strategies, &mut random) {
            broken.insert(violation.law);
            if expected.contains(&violation.law) {
                break;
            }
        }
    }
    broken
}

/// The account's own balance is checked first, so it sees most mistakes. That the mistakes matter is seen without it: then
/// the robot gives out energy that it has not.
#[test]
fn law_every_term_of_the_account_is_needed() {
    use Broken::{Account, Bounded, DiesOut, Energy, Force, Intake, Overdraft, Together};
    const BOOKS: &[Broken] = &[Account, Force, Intake, Overdraft];
    const ONE_SIDE: &[Broken] = &[Account, Force, Intake, Overdraft, Energy, Bounded, Together];
    for (missing, in_the_books, in_the_energy, in_the_end) in [
        (Missing::Nothing, &[][..], &[][..], &[][..]),
        (Missing::GivenOut, &[Account], &[Energy], &[DiesOut]),
        (Missing::ActedForce, &[Account], &[Together], &[]),
        (Missing::Share, &[Account], &[Energy], &[DiesOut]),
        (Missing::LowerEnd, &[Account], &[Energy], &[DiesOut]),
        (Missing::HiddenByEncoder, &[Account], &[Energy, Together], &[]),
        (Missing::EncoderInLoss, &[Account], &[Together], &[]),
        (Missing::RunningTotal, &[Intake], &[Energy], &[DiesOut]),
        (Missing::IntakePower, &[Intake], &[Energy], &[]),
        (Missing::Sent, &[Account], &[Energy], &[]),
        (Missing::Deficit, &[Account], &[Energy], &[]),
        (Missing::Limit, &[Force], &[Energy], &[DiesOut]),
        (Missing::Pending, &[Overdraft], &[Energy], &[]),
        (Missing::Committed, &[Overdraft], &[], &[]),
    ] {
        for (unchecked, expected) in [(&[][..], in_the_books), (BOOKS, in_the_energy), (ONE_SIDE, in_the_end)]
        {
            if expected.is_empty() && missing != Missing::Nothing {
                continue;
            }
            let broken = broken_without(missing, unchecked, expected);
            let found = expected.is_empty() || expected.iter().any(|law| broken.contains(law));
            assert!(found, "{missing:?} without {unchecked:?}: {broken:?}");
            assert!(missing != Missing::Nothing || broken.is_empty(), "{broken:?}");
        }
    }
}
