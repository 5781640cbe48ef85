//! Whatever comes in, every strategy answers with a finite force and goes on.

use crate::driver::{KINDS, pair};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use telespring::session::Motion;
use telespring::session::strategy::{PartnerView, Strategy, Tick};

fn value(random: &mut ChaCha8Rng) -> f64 {
    const ODD: [f64; 12] =
        [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300, 1e-320, 0.0, -0.0, 1e9, -1e9, 1e6, -1e6];
    if random.random_range(0..4) == 0 {
        ODD[random.random_range(0..ODD.len())]
    } else {
        random.random_range(-0.2..0.2)
    }
}

fn motion(random: &mut ChaCha8Rng) -> Motion {
    Motion { position: [(); 2].map(|()| value(random)), velocity: [(); 2].map(|()| value(random)) }
}

#[test]
fn law_every_force_and_everything_sent_is_finite() {
    for kind in KINDS {
        for seed in 0..20 {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            let [mut side, _] = pair(kind, 0.1);
            for n in 0..5000 {
                // at times all is well again
                let odd = n % 1000 < 500;
                let at = |random: &mut ChaCha8Rng| if odd { motion(random) } else { Motion::default() };
                let number = |random: &mut ChaCha8Rng| if odd { value(random) } else { 0.001 };
                let wanted = at(&mut random);
                let partner = PartnerView {
                    wanted,
                    played: wanted,
                    age: number(&mut random),
                    fresh: random.random(),
                    signal: [(); 2].map(|()| number(&mut random)),
                    energy_sent: number(&mut random),
                    stiffness: number(&mut random),
                };
                let tick = Tick {
                    elapsed: number(&mut random),
                    own: at(&mut random),
                    previous: at(&mut random),
                    acted: [(); 2].map(|()| number(&mut random)),
                    partner: (random.random_range(0..10) > 0).then_some(partner),
                    enabled: random.random(),
                };
                side.settle(&tick);
                let force = side.force(&tick);
                assert!(force.iter().all(|force| force.is_finite()), "{kind} {seed} {n}: {force:?} {tick:?}");
                let (out, report) = (side.outgoing(), side.report());
                let numbers =
                    [out.energy_sent, out.signal[0], out.signal[1], report.given_out, report.energy_received];
                assert!(
                    numbers.iter().all(|number| number.is_finite()),
                    "{kind} {seed} {n}: {out:?} {report:?}"
                );
                assert!(report.balance.is_none_or(f64::is_finite), "{kind} {seed} {n}: {report:?}");
            }
        }
    }
}
