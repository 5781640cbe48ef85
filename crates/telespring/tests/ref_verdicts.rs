//! Verdicts against closed forms and the numbers of DESIGN section 2.

use telespring::verdicts::{Allowed, Assumption, Network, Tier, Unavailable, verdicts};
use telespring::{Delay, Dyad, Operator, Robot, hman};

fn constant(delay: f64) -> Network {
    Network::constant(Delay::each_way(delay).unwrap())
}

fn sampled(delay: f64, period: f64, computing: f64) -> Network {
    Network::new(Delay::each_way(delay).unwrap(), 0.0, 0.0, period, computing).unwrap()
}

/// The same robot twice, one axis.
fn twins(mass: f64, damping: f64, coupling_damping: f64, ground: Option<f64>) -> Dyad {
    let robot = Robot::new(vec![mass], vec![damping], None).unwrap();
    let operators = ground.map(|k| {
        let operator = Operator::new(vec![0.0], vec![0.0], vec![k]).unwrap();
        [operator.clone(), operator]
    });
    Dyad::new(robot.clone(), robot, operators, coupling_damping).unwrap()
}

fn bound(dyad: &Dyad, k: f64, network: &Network, tier: Tier) -> Option<f64> {
    verdicts(dyad, None, k, network).unwrap().tier(tier).stiffness_bound
}

fn close(got: f64, expected: f64, relative: f64) {
    assert!((got - expected).abs() <= relative * expected.abs(), "{got} is not {expected}");
}

#[test]
fn ref_any_network_of_the_h_mans() {
    // B²/(4M); the y axis of H-MAN₂, 9.3496²/(4 · 1.3407), is the worst of the four.
    let result = verdicts(&hman(), None, 10.0, &constant(0.1)).unwrap();
    close(result.axes[0].tiers[0].stiffness_bound.unwrap(), 7.4208_f64.powi(2) / (4.0 * 0.7776), 1e-15);
    close(result.tier(Tier::AnyNetwork).stiffness_bound.unwrap(), 9.3496_f64.powi(2) / (4.0 * 1.3407), 1e-15);
    assert_eq!(result.tier(Tier::AnyNetwork).worst_axis, Some(1));
    assert!(result.tier(Tier::AnyNetwork).satisfied);
}

#[test]
fn ref_any_network_of_h_man_1_sampled_at_1_khz() {
    // DESIGN section 2: 17.863 N/m; with a continuous controller 7.7257²/(4 · 0.8334) = 17.9045 N/m.
    let one = twins(0.8334, 7.7257, 0.0, None);
    close(bound(&one, 10.0, &constant(0.1), Tier::AnyNetwork).unwrap(), 17.9045, 3e-6);
    let held = bound(&one, 10.0, &sampled(0.1, 1e-3, 0.0), Tier::AnyNetwork).unwrap();
    close(held, 17.863, 2e-5);
    // B²/4M (1 − B T/4M) is its expansion to first order in T: the rest is of order (B T/M)² = 1e-4.
    close(held, 17.9045 * (1.0 - 7.7257e-3 / (4.0 * 0.8334)), 1e-4);
    let computing = bound(&one, 10.0, &sampled(0.1, 1e-3, 1e-3), Tier::AnyNetwork).unwrap();
    assert!(computing < held && computing > 0.98 * held, "{computing}");
}

#[test]
fn ref_a_coupling_damper_equal_to_the_damping_raises_any_network_fourfold() {
    // (B + c)²/(4M) at c = B is B²/M; for c > B it grows as B c/M.
    let network = constant(0.1);
    let plain = bound(&twins(0.8, 8.0, 0.0, None), 1.0, &network, Tier::AnyNetwork).unwrap();
    let equal = bound(&twins(0.8, 8.0, 8.0, None), 1.0, &network, Tier::AnyNetwork).unwrap();
    close(equal / plain, 4.0, 1e-15);
    let more = bound(&twins(0.8, 8.0, 24.0, None), 1.0, &network, Tier::AnyNetwork).unwrap();
    close(more, 8.0 * 24.0 / 0.8, 1e-15);
    // The sampled rule tends to the continuous one; at 10 µs they differ by some B T/M = 1e-4 parts. With
    // c > B the two are equal: the condition c λ = k solves to k = c (1 − E)/φ = B c/M for every period.
    for (c, expected) in [(0.0, plain), (4.0, 144.0 / 3.2), (8.0, equal), (24.0, more)] {
        let fine = bound(&twins(0.8, 8.0, c, None), 1.0, &sampled(0.1, 1e-5, 0.0), Tier::AnyNetwork).unwrap();
        close(fine, expected, 1e-3);
        assert!(fine <= expected * (1.0 + 1e-14), "{fine} {expected}");
        let coarse =
            bound(&twins(0.8, 8.0, c, None), 1.0, &sampled(0.1, 1e-3, 0.0), Tier::AnyNetwork).unwrap();
        assert!(coarse <= fine * (1.0 + 1e-14) && (c <= 8.0 || (coarse / expected - 1.0).abs() < 1e-13));
    }
}

#[test]
fn ref_grounded_identical_robots_reach_the_closed_form() {
    // γ = 1 for each: k/(k + k_h) coth(πB/(2√(4M(k + k_h) − B²))) = 1, evaluated at the bound returned.
    let (m, b, kh) = (0.8_f64, 8.0_f64, 120.0_f64);
    let k = bound(&twins(m, b, 0.0, Some(kh)), 1.0, &constant(0.1), Tier::AnyNetwork).unwrap();
    let argument = std::f64::consts::PI * b / (2.0 * (4.0 * m * (k + kh) - b * b).sqrt());
    close(k / (k + kh) / argument.tanh(), 1.0, 1e-14);
    assert!(k > b * b / (4.0 * m), "a grounded operator helps here: {k}");
}

#[test]
fn ref_bounded_varying_delay_without_sampling() {
    // k < 2√(B₁B₂)/(T₁ + T₂), the rule of Nuño, Basañez and Ortega (2011) for h = 0.
    let network = Network::new(Delay::new(0.02, 0.03).unwrap(), 0.01, 0.005, 0.0, 0.0).unwrap();
    let result = verdicts(&hman(), None, 10.0, &network).unwrap();
    let x = 2.0 * (7.7257_f64 * 7.4208).sqrt() / 0.08;
    close(result.axes[0].tiers[1].stiffness_bound.unwrap(), x, 1e-15);
    assert_eq!(bound(&hman(), 10.0, &constant(0.0), Tier::BoundedVaryingDelay), Some(f64::INFINITY));
    assert_eq!(result.any_passive_operator, result.tier(Tier::BoundedVaryingDelay).stiffness_bound);
}

#[test]
fn ref_constant_delays_of_the_h_mans() {
    // k_m and δ_m computed independently: 35.615988 and 39.442273 N/m; 0.16718632424 s at 2 k_m on x.
    let km = 35.615988;
    let result = verdicts(&hman(), None, 2.0 * 35.61598813, &constant(0.167)).unwrap();
    let third = result.tier(Tier::AnyConstantDelay);
    close(third.stiffness_bound.unwrap(), km, 1e-7);
    assert!(third.attained || third.stiffness_bound.unwrap() < km * (1.0 + 1e-7));
    assert_eq!((third.worst_axis, third.satisfied), (Some(0), false));
    let fourth = result.tier(Tier::ConstantDelay);
    assert!(fourth.satisfied && fourth.margin.unwrap().ratio > 1.0 && fourth.margin.unwrap().ratio < 1.01);
    assert!(result.paper.stable && result.paper.agrees);
    close(result.axes[0].maximum_delay, 0.16718632424, 1e-8);
    close(result.axes[0].paper_maximum_delay, 0.16718632424, 1e-8);
    assert_eq!(result.remedies, Default::default());
}

#[test]
fn ref_the_paper_is_wrong_for_unequal_dampings() {
    // DESIGN section 2, line 3: m = 1, 1, b = 1, 10, k = 24.9975: the paper's k_m is 25.25 N/m, the
    // truth 9.4610953 N/m, and stability is lost at 0.1718 s.
    let robot = |b| Robot::new(vec![1.0], vec![b], None).unwrap();
    let dyad = Dyad::new(robot(1.0), robot(10.0), None, 0.0).unwrap();
    let result = verdicts(&dyad, None, 24.9975, &constant(0.175)).unwrap();
    close(result.paper.critical_stiffness, 25.25, 1e-15);
    close(result.tier(Tier::AnyConstantDelay).stiffness_bound.unwrap(), 9.4610953, 1e-7);
    assert!(!result.tier(Tier::AnyConstantDelay).attained, "a tangency is not attained");
    assert!(result.paper.stable && !result.paper.agrees && !result.tier(Tier::ConstantDelay).satisfied);
    close(result.axes[0].maximum_delay, 0.1718, 1e-3);
    // Every remedy alone mends it.
    let remedies = result.remedies;
    let holds = |dyad: &Dyad, k, delay| {
        verdicts(dyad, None, k, &constant(delay)).unwrap().tier(Tier::ConstantDelay).satisfied
    };
    assert!(holds(&dyad, 0.999 * remedies.stiffness.unwrap(), 0.175));
    assert!(holds(&dyad, 24.9975, 0.999 * remedies.delay.unwrap()));
    let added = 1.001 * remedies.damping.unwrap();
    let mended = Dyad::new(robot(1.0 + added), robot(10.0 + added), None, 0.0).unwrap();
    assert!(holds(&mended, 24.9975, 0.175));
    assert!(!holds(&dyad, 1.001 * remedies.stiffness.unwrap(), 0.175));
}

#[test]
fn ref_identical_robots_attain_their_critical_stiffness() {
    // b²/(2m): the root enters at ω = 0, where every delay is still stable.
    let result = verdicts(&twins(1.0, 4.0, 0.0, None), None, 4.0, &constant(1.0)).unwrap();
    let third = result.tier(Tier::AnyConstantDelay);
    close(third.stiffness_bound.unwrap(), 8.0, 1e-8);
    assert!(third.attained && third.satisfied);
}

#[test]
fn ref_stability_comes_back_at_a_longer_delay() {
    // DESIGN section 2, line 4: stable on [0, 0.8508) and (1.7738, 2.1128).
    let robot = |m, b| Robot::new(vec![m], vec![b], None).unwrap();
    let dyad = Dyad::new(robot(0.97670822, 2.15372614), robot(0.30379312, 4.59594729), None, 0.0).unwrap();
    for (delay, stable) in [(0.8, true), (0.9, false), (1.7, false), (1.9, true), (2.2, false)] {
        let result = verdicts(&dyad, None, 9.174736188, &constant(delay)).unwrap();
        assert_eq!(result.tier(Tier::ConstantDelay).satisfied, stable, "{delay}");
    }
}

#[test]
fn ref_tier_1_exceeds_tier_2_beyond_a_round_trip_of_8_m_over_b() {
    // b²/(4m) > 2b/(T₁ + T₂) where T₁ + T₂ > 8m/b, DESIGN section 2.
    let (m, b) = (0.9, 7.0);
    let dyad = twins(m, b, 0.0, None);
    for (factor, is_larger) in [(0.999, false), (1.001, true)] {
        let oldest = factor * 4.0 * m / b;
        let network = Network::new(Delay::each_way(0.0).unwrap(), oldest, 0.0, 0.0, 0.0).unwrap();
        let found = verdicts(&dyad, None, 1.0, &network).unwrap();
        let bound = |tier: Tier| found.tier(tier).stiffness_bound.unwrap();
        assert_eq!(bound(Tier::AnyNetwork) > bound(Tier::BoundedVaryingDelay), is_larger);
        // Of the tiers that a network with jitter meets the largest bound counts.
        let tiers = [Tier::AnyNetwork, Tier::BoundedVaryingDelay, Tier::AgeInRange].map(bound);
        let Some(Allowed { stiffness, .. }) = found.stiffness_allowed else { panic!("{found:?}") };
        assert_eq!(stiffness, tiers.into_iter().fold(0.0, f64::max));
    }
}

#[test]
fn ref_a_network_with_jitter_is_constant_only_behind_a_buffer() {
    let network = Network::new(Delay::new(0.05, 0.07).unwrap(), 0.02, 0.01, 0.0, 0.0).unwrap();
    let result = verdicts(&hman(), None, 30.0, &network).unwrap();
    let Assumption::MetBehindPlayoutBuffer { delay: [forward, backward] } =
        result.tier(Tier::ConstantDelay).assumption
    else {
        panic!("{:?}", result.tier(Tier::ConstantDelay).assumption)
    };
    close(forward, 0.08, 1e-15);
    close(backward, 0.10, 1e-15);
    assert_eq!(result.tier(Tier::AnyNetwork).assumption, Assumption::Met);
    let bare = result.stiffness_allowed.unwrap();
    let buffered = result.stiffness_allowed_behind_buffer.unwrap();
    assert_eq!((bare.tier, buffered.tier), (Tier::AgeInRange, Tier::ConstantDelay));
    assert!(buffered.stiffness > bare.stiffness);
}

#[test]
fn ref_tiers_without_a_rule_say_why() {
    let network = constant(0.1);
    let reasons = |dyad: &Dyad, network: &Network| {
        verdicts(dyad, None, 1.0, network).unwrap().tiers.map(|verdict| verdict.unavailable)
    };
    let grounded = Some(Unavailable::CouplingDampingWithGroundedOperator);
    let damped = Some(Unavailable::CouplingDamping);
    assert_eq!(reasons(&twins(1.0, 5.0, 2.0, Some(100.0)), &network), [grounded, damped, None, None, None]);
    assert_eq!(reasons(&twins(1.0, 5.0, 2.0, None), &network), [None, damped, None, None, None]);
    assert_eq!(reasons(&twins(1.0, 5.0, 0.0, Some(100.0)), &network), [None; 5]);
    let computing = Some(Unavailable::CouplingDampingWithComputingTime);
    assert_eq!(
        reasons(&twins(1.0, 5.0, 2.0, None), &sampled(0.1, 1e-3, 5e-4)),
        [computing, damped, Some(Unavailable::CouplingDampingWithSampledControllers), None, None]
    );
}

#[test]
fn ref_the_delay_budget_is_itemised() {
    let network = Network::new(Delay::new(0.05, 0.03).unwrap(), 0.01, 0.02, 0.001, 0.0005).unwrap();
    let [forward, backward] = network.budget();
    close(forward.total(), 0.0815, 1e-14);
    close(backward.total(), 0.0615, 1e-14);
    close(forward.shares()[0].1, 0.05 / 0.0815, 1e-14);
    close(forward.shares().iter().map(|item| item.1).sum(), 1.0, 1e-15);
}

#[test]
fn ref_a_network_is_checked_at_the_door() {
    let delay = Delay::each_way(0.1).unwrap();
    let message = |j, g, s, c| Network::new(delay, j, g, s, c).unwrap_err().to_string();
    assert_eq!(
        message(0.0, 0.0, 1e-3, 2e-3),
        "computing_time = 0.002: a computing time must fit into the sample period of 0.001 s. Shorten it, \
         or give the actual sample period of the controller."
    );
    assert!(message(-1.0, 0.0, 0.0, 0.0).starts_with("jitter = -1: a time span must be"));
    assert!(message(0.0, f64::NAN, 0.0, 0.0).starts_with("max_gap = NaN"));
    assert!(message(60.0, 60.0, 0.0, 0.0).contains("together must not exceed 100 s, but are 120.1 s"));
    assert!(message(0.0, 0.0, 1e-9, 0.0).starts_with("sample_period = 0.000000001"));
}
