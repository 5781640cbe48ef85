//! Laws of the energy account alone, each at its edge.

use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use telespring::session::strategy::Guard;
use telespring::session::{AccountSettings, EnergyAccount, Law};

/// An account without damping: it changes by what is given out alone.
fn account(stiffness: f64, capacity: f64, encoder_step: f64, computing_tick: bool) -> EnergyAccount {
    let settings = AccountSettings {
        capacity,
        encoder_step,
        computing_tick,
        ..AccountSettings::new(stiffness, [0.0; 2])
    };
    EnergyAccount::new(settings).unwrap()
}

#[test]
fn law_the_overdraft_of_a_held_force_is_reached_and_no_larger() {
    let (stiffness, step) = (100.0, 1e-3);
    let mut deepest = 0.0_f64;
    for held in 1..400 {
        let start = 1e-7 * f64::from(held * held);
        let mut account = account(stiffness, start, 0.0, false);
        for _ in 0..30 {
            // the spring pulls as hard as it may, and the hand goes with it
            let force = account.pay([1e6, 0.0], 0.0);
            account.settle(1e-3, [step, 0.0], force, 0.0);
            deepest = deepest.min(account.balance());
        }
    }
    let stated = 0.5 * stiffness * step * step;
    println!("held: {:.3} k dx^2", -deepest / (stiffness * step * step));
    assert!(-deepest <= stated * (1.0 + 1e-9) && -deepest > 0.99 * stated, "{deepest} {stated}");
}

#[test]
fn law_the_overdraft_with_a_computing_tick_is_reached_and_no_larger() {
    let (stiffness, step) = (100.0, 1e-3);
    let mut random = ChaCha8Rng::seed_from_u64(4);
    let mut deepest = 0.0_f64;
    for _ in 0..20_000 {
        let mut account = account(stiffness, 1e-4 * random.random_range(0.0..30.0), 0.0, true);
        let (mut pending, rest) = ([0.0; 2], random.random_range(0..4));
        for tick in 0..12 {
            let acting =
                std::mem::replace(&mut pending, account.pay([random.random_range(0.1..3.0), 0.0], 0.0));
            let moved = if tick < rest { 0.0 } else { step };
            account.settle(1e-3, [moved, 0.0], acting, 0.0);
            deepest = deepest.min(account.balance());
        }
    }
    let stated = 2.0 * stiffness * step * step;
    println!("computing tick: {:.3} k dx^2", -deepest / (stiffness * step * step));
    assert!(-deepest <= stated * (1.0 + 1e-9) && -deepest > 0.95 * stated, "{deepest} {stated}");
}

#[test]
fn law_what_the_encoder_hides_is_debited_exactly() {
    let step = 1e-3;
    let mut random = ChaCha8Rng::seed_from_u64(8);
    for hostile in [false, true] {
        let mut account = account(100.0, 10.0, step, false);
        let (mut position, mut measured, mut given_out, mut debited) = (0.0, 0.0, 0.0, 0.0);
        for tick in 0..4000 {
            let force = if hostile {
                [if tick % 2 == 0 { 3.0 } else { -3.0 }, 0.0]
            } else {
                [random.random_range(-5.0..5.0), 0.0]
            };
            let next: f64 = if hostile {
                // the error of the encoder is half a step, always the wrong way
                if tick % 2 == 0 { 0.4999 * step } else { -0.4999 * step }
            } else {
                position + random.random_range(-2e-3..2e-3)
            };
            let seen = (next / step).round() * step;
            account.settle(1e-3, [seen - measured, 0.0], force, 0.0);
            given_out += force[0] * (next - position);
            (position, measured) = (next, seen);
            debited = 10.0 - account.balance();
            assert!(debited >= given_out - 1e-12, "tick {tick}: {debited} {given_out}");
        }
        if hostile {
            // nothing is seen of all that
            assert_eq!(account.given_out(), 0.0);
            assert!(debited < 1.001 * given_out + 0.01, "{debited} {given_out}");
        }
    }
}

#[test]
fn law_what_the_encoder_hides_is_debited_while_the_force_acts() {
    let (step, force) = (1e-3, 3.0);
    let mut account = account(100.0, 10.0, step, false);
    account.settle(1e-3, [0.0; 2], [0.0; 2], 0.0);
    // almost a whole step with the force, of which the encoder shows nothing
    account.settle(1e-3, [0.0; 2], [force, 0.0], 0.0);
    let debited = 10.0 - account.balance();
    assert!(debited >= 0.9998 * step * force, "{debited}");
    // letting go costs nothing more
    account.settle(1e-3, [0.0; 2], [0.0; 2], 0.0);
    assert_eq!(10.0 - account.balance(), debited);
}

/// A device that lags or comes late gives out energy that its commanded force does not show: at speeds up to v this is
/// what an encoder step larger by 2 v τ hides.
#[test]
fn law_a_lag_of_the_device_is_covered_by_a_larger_encoder_step() {
    let (period, lag, speed) = (1e-3, 8e-3, 0.5_f64);
    let mut random = ChaCha8Rng::seed_from_u64(9);
    let mut uncovered = false;
    for _ in 0..200 {
        let mut covered = account(100.0, 10.0, 2.0 * speed * lag, false);
        let mut bare = account(100.0, 10.0, 0.0, false);
        let (mut real, mut given_out, mut command, mut velocity) = (0.0, 0.0, 0.0, 0.0);
        for _ in 0..500 {
            if random.random_bool(0.1) {
                command = random.random_range(-5.0..5.0);
                // a hand that knows of the lag: it moves along with the force that has not gone yet
                velocity = speed * f64::signum(real - command);
            }
            let rest = f64::exp(-period / lag);
            let impulse = command * period + (real - command) * lag * (1.0 - rest);
            real = command + (real - command) * rest;
            given_out += velocity * impulse;
            for account in [&mut covered, &mut bare] {
                account.settle(period, [velocity * period, 0.0], [command, 0.0], 0.0);
            }
            assert!(10.0 - covered.balance() >= given_out - 1e-12);
            uncovered |= 10.0 - bare.balance() < given_out - 1e-3;
        }
    }
    assert!(uncovered);
}

#[test]
fn law_claims_count_once_and_no_faster_than_the_set_power() {
    let mut account = account(100.0, 0.0, 0.0, false);
    let mut settle = |claimed: f64| {
        account.settle(0.01, [0.0; 2], [0.0; 2], claimed);
        account.received()
    };
    for nonsense in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -5.0] {
        assert_eq!(settle(nonsense), 0.0);
    }
    assert_eq!(settle(0.001), 0.001);
    assert_eq!(settle(0.001), 0.001);
    assert_eq!(settle(0.0), 0.001);
    // 0.3 W
    assert!((settle(50.0) - 0.004).abs() < 1e-15);
    assert!((settle(0.0) - 0.007).abs() < 1e-15);
    assert!((settle(1e300) - 0.010).abs() < 1e-15);
    // a clock that jumps brings in a tenth of a second
    account.settle(1e9, [0.0; 2], [0.0; 2], 1e300);
    assert!((account.received() - 0.040).abs() < 1e-15);
}

#[test]
fn law_what_cannot_be_taken_in_within_five_seconds_is_lost() {
    let mut account = account(100.0, 0.0, 0.0, false);
    for tick in 1..=10_000 {
        // 50 J at once, nothing after; 0.3 W
        account.settle(1e-3, [0.0; 2], [0.0; 2], 50.0);
        let expected = 0.3 * 1e-3 * f64::from(tick.min(5001));
        assert!((account.received() - expected).abs() < 1e-12, "tick {tick}: {}", account.received());
    }
    // it is not held against what comes later
    account.settle(1e-3, [0.0; 2], [0.0; 2], 50.0001);
    assert!((account.received() - 1.5004).abs() < 1e-12, "{}", account.received());
}

#[test]
fn law_a_displacement_or_a_force_that_is_not_a_number_empties_the_account() {
    for (displacement, acted) in
        [([f64::NAN, 0.0], [1.0; 2]), ([0.0; 2], [f64::INFINITY, 0.0]), ([1e200; 2], [1e200; 2])]
    {
        let mut account = account(100.0, 1.0, 0.0, false);
        account.settle(1e-3, displacement, acted, 0.0);
        assert_eq!(account.balance(), 0.0);
        assert_eq!(account.pay([1.0, 1.0], 0.0), [0.0; 2]);
    }
}

#[test]
fn law_each_refusal_names_its_setting() {
    let good = AccountSettings::new(100.0, [6.0, 5.0]);
    for (field, settings) in [
        ("stiffness", AccountSettings { stiffness: 0.0, ..good }),
        ("damping[0]", AccountSettings { damping: [-1.0, 5.0], ..good }),
        ("damping[1]", AccountSettings { damping: [6.0, f64::NAN], ..good }),
        ("share", AccountSettings { share: 1.0, ..good }),
        ("share", AccountSettings { share: f64::NAN, ..good }),
        ("capacity", AccountSettings { capacity: -0.1, ..good }),
        ("intake", AccountSettings { intake: f64::INFINITY, ..good }),
        ("encoder_step", AccountSettings { encoder_step: 1.0, ..good }),
    ] {
        assert_eq!(EnergyAccount::new(settings).unwrap_err().field, field);
    }
    let law = |damping| Law { stiffness: 100.0, damping };
    assert_eq!(Guard::new(Law { stiffness: 99.0, damping: 0.0 }, good).unwrap_err().field, "stiffness");
    assert_eq!(Guard::new(law(-1.0), good).unwrap_err().field, "coupling_damping");
    assert!(Guard::new(law(2.0), good).is_ok());
}

proptest! {
    #[test]
    fn law_whatever_comes_in_the_account_stays_finite(
        ticks in prop::collection::vec((any::<f64>(), any::<[f64; 4]>(), any::<f64>(), any::<[f64; 3]>()), 1..60),
        computing_tick: bool,
        encoder_step in prop_oneof![Just(0.0), 1e-6..0.1],
    ) {
        let settings = AccountSettings { encoder_step, computing_tick, ..AccountSettings::new(80.0, [6.0, 4.0]) };
        let mut account = EnergyAccount::new(settings).unwrap();
        let mut largest_claim = 0.0_f64;
        for (elapsed, [dx, dy, fx, fy], claimed, [x, y, stored]) in ticks {
            let sent = account.sent();
            account.settle(elapsed, [dx, dy], [fx, fy], claimed);
            let most = account.largest_force();
            let force = account.pay([x, y], stored);
            if claimed.is_finite() {
                largest_claim = largest_claim.max(claimed);
            }
            prop_assert!(force.iter().all(|force| force.is_finite()));
            prop_assert!(force[0].hypot(force[1]) <= most * (1.0 + 1e-12));
            prop_assert!(account.balance().is_finite() && account.given_out().is_finite());
            prop_assert!(account.sent().is_finite() && account.sent() >= sent);
            prop_assert!(account.received() >= 0.0 && account.received() <= largest_claim);
            prop_assert!(account.credited().is_finite());
        }
    }
}
