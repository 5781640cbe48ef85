//! Two people who consent by order, and a force that must not step.

#![allow(dead_code, reason = "every test uses its part")]

use super::common::{Pair, hman_study};
use telespring::study::Study;
use telespring_link::operator::Order;
use telespring_link::site::Phase;

pub const GUARD: &str = "coupling.stiffness = 100\nnetwork.delay = 0.02\nsession.strategy = \"guard\"";
/// The force of the spring between two handles 2 cm apart, N.
pub const FORCE: f64 = 2.0;

pub fn study() -> Study {
    hman_study(GUARD)
}

/// A pair of people who consent by order, up to the consent.
pub fn consenting() -> Pair {
    let mut pair = Pair::with([&study(), &study()], 0.02, |settings| settings);
    pair.run(500, |_, forces| assert_eq!(forces, [[0.0; 2]; 2]));
    assert_eq!(pair.phases(), [Phase::Consenting; 2]);
    pair
}

/// Runs, and sees to it that no force steps: it changes by no more than the steepest ramps do, unless it is let go.
pub fn run_smoothly(pair: &mut Pair, milliseconds: usize, may_let_go: bool) {
    let mut before = pair.forces();
    pair.run(milliseconds, |_, forces| {
        for side in 0..2 {
            let step = (forces[side][0] - before[side][0]).abs();
            let is_let_go = may_let_go && forces[side] == [0.0; 2];
            assert!(is_let_go || step <= FORCE / 100.0 + FORCE / 78.0 + 1e-9, "{side}: {step} N");
        }
        before = forces;
    });
}

pub fn consent(pair: &mut Pair) {
    for side in 0..2 {
        pair.order(side, Order::Consent);
    }
    run_smoothly(pair, 1200, false);
    assert_eq!(pair.phases(), [Phase::Running; 2]);
    let [[first, _], [second, _]] = pair.forces();
    assert!((first - FORCE).abs() < 1e-9 && (second + FORCE).abs() < 1e-9, "{first} {second}");
}

pub fn running() -> Pair {
    let mut pair = consenting();
    consent(&mut pair);
    pair
}
