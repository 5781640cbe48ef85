//! The laws over random cases.

use std::collections::BTreeMap;

use crate::case::{Case, predictors};
use crate::run::run;
use crate::withstand_common::seed::seed;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use telespring::rig::{Adversary, NetworkModel};
use telespring::session::PlayoutSettings;

/// The seed of the random cases, unless `make verify` draws one.
const SEED: u64 = 20_261_128;

/// What a case contains, in words.
fn contents(case: &Case) -> Vec<&'static str> {
    let mut found = vec![predictors()[case.predictor].0];
    let mut note = |is_there: bool, name: &'static str| {
        if is_there {
            found.push(name);
        }
    };
    for side in 0..2 {
        let NetworkModel { jitter, loss, burst, duplicate, rate, blackout, trace, adversary, .. } =
            case.network.towards(side);
        note(*jitter > 0.0, "jitter");
        note(*loss > 0.0, "loss");
        note(burst.is_some(), "burst");
        note(*duplicate > 0.0, "duplicate");
        note(rate.is_some(), "rate");
        note(blackout.is_some(), "blackout");
        note(trace.is_some(), "trace");
        match adversary {
            Some(Adversary::OldestSample { .. }) => note(true, "oldest"),
            Some(Adversary::MostHarmfulSample { .. }) => note(true, "most harmful"),
            Some(Adversary::StretchTimed { .. }) => note(true, "stretch-timed"),
            Some(Adversary::LyingPeer { .. }) => note(true, "lying peer"),
            None => {}
        }
        note(case.has_liar[side], "nothing true");
    }
    note(case.network.forward != case.network.backward, "asymmetric");
    note(case.is_watched, "watchdog");
    note(matches!(case.playout, PlayoutSettings::Adaptive(_)), "adaptive");
    note(case.sides[0].settings.computing_tick, "computing tick");
    note(case.sides[0].settings.encoder_step > 0.0, "encoder");
    note(case.force_limit.is_finite(), "saturation");
    note(case.lag > 0.0, "lag");
    note(case.law.damping > 0.0, "coupling damping");
    note(case.clocks[0].offset != case.clocks[1].offset, "own clocks");
    found
}

fn check_cases(cases: u64, ticks: usize) {
    let seed = seed(SEED);
    let (mut counts, mut limited, mut sent) = (BTreeMap::new(), 0, 0);
    for number in 0..cases {
        let mut random = ChaCha8Rng::seed_from_u64(seed ^ (number << 32));
        let case = Case::random(&mut random, ticks);
        match run(&case, random.next_u64(), &[]) {
            Ok(outcome) => {
                limited += u64::from(outcome.limited.iter().any(|share| *share > 0.01));
                sent += u64::from(outcome.sent > 1e-3);
            }
            Err(violation) => {
                panic!("case {number} of seed {seed}: {violation:?}\n{case:#?}");
            }
        }
        for name in contents(&case) {
            *counts.entry(name).or_insert(0) += 1;
        }
    }
    println!("{cases} cases, limited in {limited}, energy exchanged in {sent}: {counts:?}");
    assert_eq!(counts.len(), 26, "a kind is missing: {counts:?}");
    // where nothing is limited and nothing sent, nothing is tested
    assert!(2 * limited > cases && 2 * sent > cases, "{limited} {sent}");
}

#[test]
fn law_no_dyad_network_partner_or_prediction_gets_energy_that_is_not_there() {
    check_cases(300, 2500);
}

#[test]
#[ignore = "10^4 cases take minutes"]
fn law_no_dyad_network_partner_or_prediction_gets_energy_that_is_not_there_in_many_cases() {
    check_cases(10_000, 5000);
}
