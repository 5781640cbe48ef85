//! Nuño, Basañez and Ortega (2011): the injected damping is exactly what the rule of bounded delays asks for.

use crate::driver::hman_damping;
use telespring::session::Motion;
use telespring::session::strategy::{InjectedDamping, InjectedDampingSettings, PartnerView, Strategy, Tick};
use telespring::verdicts::{Network, Tier, verdicts};
use telespring::{Delay, Dyad, Robot};

/// The stiffness bound of the rule for the H-MANs with more damping, by the verdicts, one axis.
fn bound(axis: usize, added: f64, network: &Network) -> f64 {
    let robots =
        hman_damping().map(|damping| Robot::new(vec![1.0], vec![damping[axis] + added], None).unwrap());
    let [one, two] = robots;
    let dyad = Dyad::new(one, two, None, 0.0).unwrap();
    let verdicts = verdicts(&dyad, None, 142.0, network).unwrap();
    verdicts.tier(Tier::BoundedVaryingDelay).stiffness_bound.unwrap()
}

#[test]
fn ref_the_injected_damping_puts_the_stiffness_on_the_bound_of_the_rule() {
    let [own_damping, partner_damping] = hman_damping();
    for (delay, jitter, period) in [(0.084, 0.0, 0.0), (0.084, 0.0, 0.001), (0.15, 0.05, 0.002)] {
        let network = Network::new(Delay::each_way(delay).unwrap(), jitter, 0.0, period, 0.0).unwrap();
        let round_trip = network.oldest_partner_sample().iter().sum();
        let own_age = network.oldest_own_sample();
        let sized = |own_damping, partner_damping| {
            let settings = InjectedDampingSettings { own_damping, partner_damping, round_trip, own_age };
            InjectedDamping::new(142.0, settings).unwrap().damping()
        };
        let added = sized(own_damping, partner_damping);
        // both sides come to the same
        assert_eq!(added, sized(partner_damping, own_damping));
        for axis in 0..2 {
            let (bound, without) = (bound(axis, added[axis], &network), bound(axis, 0.0, &network));
            println!("{delay} s, axis {axis}: {:.4} N·s/m, {without:.2} to {bound:.6} N/m", added[axis]);
            assert!((bound / 142.0 - 1.0).abs() < 1e-12, "{bound}");
            assert!(without < 142.0 || added[axis] == 0.0);
        }
    }
    // where the rule holds without, nothing is injected
    let settings = InjectedDampingSettings { own_damping, partner_damping, round_trip: 0.2, own_age: 0.001 };
    assert_eq!(InjectedDamping::new(70.0, settings).unwrap().damping(), [0.0; 2]);
}

#[test]
fn law_the_force_is_the_spring_less_the_damper() {
    let settings = InjectedDampingSettings {
        own_damping: [4.0, 12.0],
        partner_damping: [4.0, 12.0],
        round_trip: 0.2,
        own_age: 0.0,
    };
    let mut side = InjectedDamping::new(100.0, settings).unwrap();
    let own = Motion { position: [0.0, 0.1], velocity: [0.5, 0.5] };
    let wanted = Motion { position: [0.02, 0.1], velocity: [9.0; 2] };
    let partner = PartnerView {
        wanted,
        played: wanted,
        age: 0.1,
        fresh: true,
        signal: [0.0; 2],
        energy_sent: 0.0,
        stiffness: 100.0,
    };
    let tick =
        Tick { elapsed: 0.001, own, previous: own, acted: [0.0; 2], partner: Some(partner), enabled: 0.5 };
    // half of 100 · 0.02 − 6 · 0.5 on x; the damping of y is enough
    assert_eq!(side.force(&tick), [-0.5, 0.0]);
    assert_eq!(side.force(&Tick { partner: None, ..tick }), [0.0; 2]);
    assert_eq!(side.report().limited_ticks, 1);
}

#[test]
fn law_each_value_is_refused_with_its_field() {
    let good = InjectedDampingSettings {
        own_damping: [1.0; 2],
        partner_damping: [1.0; 2],
        round_trip: 0.1,
        own_age: 0.0,
    };
    let field = |stiffness, settings| InjectedDamping::new(stiffness, settings).unwrap_err().field;
    assert_eq!(field(f64::NAN, good), "stiffness");
    assert_eq!(field(1.0, InjectedDampingSettings { own_damping: [1.0, -1.0], ..good }), "own_damping[1]");
    assert_eq!(
        field(1.0, InjectedDampingSettings { partner_damping: [1e9, 1.0], ..good }),
        "partner_damping[0]"
    );
    assert_eq!(field(1.0, InjectedDampingSettings { round_trip: -0.1, ..good }), "round_trip");
    assert_eq!(field(1.0, InjectedDampingSettings { own_age: f64::NAN, ..good }), "own_age");
}
