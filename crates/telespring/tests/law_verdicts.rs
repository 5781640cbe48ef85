//! Laws of the verdicts: exchange of partners, scaling, the order of the tiers, ranges of operators.

use proptest::prelude::*;
use telespring::verdicts::{
    Network, OperatorRange, Tier, Unavailable, Verdicts, delay_limit, is_stable_over_delays,
    sampled_spectral_radius, verdicts,
};
use telespring::{Delay, Dyad, DyadAxis, Operator, Robot, hman};

#[derive(Debug, Clone, Copy)]
struct Case {
    m: [f64; 2],
    b: [f64; 2],
    kh: [f64; 2],
    c: f64,
    k: f64,
    delay: [f64; 2],
    jitter: f64,
    gap: f64,
    h: f64,
    computing: f64,
}

impl Case {
    fn dyad(&self) -> Dyad {
        let robot = |i: usize| Robot::new(vec![self.m[i]], vec![self.b[i]], None).unwrap();
        let operator = |i: usize| Operator::new(vec![0.0], vec![0.0], vec![self.kh[i]]).unwrap();
        Dyad::new(robot(0), robot(1), Some([operator(0), operator(1)]), self.c).unwrap()
    }

    fn network(&self) -> Network {
        let delay = Delay::new(self.delay[0], self.delay[1]).unwrap();
        Network::new(delay, self.jitter, self.gap, self.h, self.computing).unwrap()
    }

    fn verdicts(&self) -> Verdicts {
        verdicts(&self.dyad(), None, self.k, &self.network()).unwrap()
    }

    fn bounds(&self) -> [Option<f64>; 5] {
        self.verdicts().tiers.map(|verdict| verdict.stiffness_bound)
    }
}

fn case() -> impl Strategy<Value = Case> {
    (
        prop::array::uniform2(0.3..3.0_f64),
        prop::array::uniform2(2.0..20.0_f64),
        prop::array::uniform2(prop_oneof![Just(0.0), 1.0..300.0_f64]),
        prop_oneof![3 => Just(0.0), 1 => 0.1..5.0_f64],
        1.0..200.0_f64,
        prop::array::uniform2(0.005..0.3_f64),
        prop_oneof![Just((0.0, 0.0)), (0.0..0.1_f64, 0.0..0.1_f64)],
        prop_oneof![2 => Just((0.0, 0.0)), 1 => Just((2e-3, 0.0)), 1 => Just((2e-3, 7e-4))],
    )
        .prop_map(|(m, b, kh, c, k, delay, (jitter, gap), (h, computing))| Case {
            m,
            b,
            kh,
            c,
            k,
            delay,
            jitter,
            gap,
            h,
            computing,
        })
}

fn same(a: [Option<f64>; 5], b: [Option<f64>; 5], factor: f64, tolerance: f64) -> Result<(), TestCaseError> {
    for (tier, (a, b)) in Tier::ALL.into_iter().zip(a.into_iter().zip(b)) {
        // The search for the age in a range ends 2e-5 below the first failure of its rule, at a κ of its own.
        let tolerance = if tier == Tier::AgeInRange { tolerance.max(1e-3) } else { tolerance };
        match (a, b) {
            (Some(a), Some(b)) => {
                prop_assert!((a * factor - b).abs() <= tolerance * b.abs(), "{} {b}", a * factor);
            }
            (a, b) => prop_assert_eq!(a, b),
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..Default::default() })]

    #[test]
    fn law_exchange_of_partners(case in case()) {
        let [m, b, kh, delay] = [case.m, case.b, case.kh, case.delay].map(|[first, second]| [second, first]);
        let exchanged = Case { m, b, kh, delay, ..case };
        // Bisections end within 1e-13, criteria on other orders of the same sums.
        same(case.bounds(), exchanged.bounds(), 1.0, 1e-9)?;
        for tier in Tier::ALL {
            let [own, other] = [&case, &exchanged].map(|case| *case.verdicts().tier(tier));
            let is_near = own.stiffness_bound.is_some_and(|bound| (bound / case.k - 1.0).abs() < 1e-3);
            prop_assert!(own.satisfied == other.satisfied || is_near, "{own:?} {other:?}");
        }
    }

    #[test]
    fn law_scaling_of_force_and_of_time(case in case()) {
        // Powers of two leave every rounding as it is.
        let heavier = Case {
            m: case.m.map(|v| 8.0 * v),
            b: case.b.map(|v| 8.0 * v),
            kh: case.kh.map(|v| 8.0 * v),
            c: 8.0 * case.c,
            k: 8.0 * case.k,
            ..case
        };
        same(case.bounds(), heavier.bounds(), 8.0, 1e-9)?;
        let slower = Case {
            b: case.b.map(|v| v / 4.0),
            kh: case.kh.map(|v| v / 16.0),
            c: case.c / 4.0,
            k: case.k / 16.0,
            delay: case.delay.map(|v| 4.0 * v),
            jitter: 4.0 * case.jitter,
            gap: 4.0 * case.gap,
            h: 4.0 * case.h,
            computing: 4.0 * case.computing,
            ..case
        };
        same(case.bounds(), slower.bounds(), 1.0 / 16.0, 1e-9)?;
        let radius = |case: &Case| case.verdicts().axes[0].sampled.map(|sampled| sampled.radius);
        if let (Some(a), Some(b), Some(c)) = (radius(&case), radius(&heavier), radius(&slower)) {
            prop_assert!((a - b).abs() < 1e-10 && (a - c).abs() < 1e-10, "{a} {b} {c}");
        }
    }

    #[test]
    fn law_what_more_networks_allow_fewer_allow_too(case in case()) {
        let [first, second, ages, third, fourth] = case.bounds();
        let (third, fourth) = (third.unwrap(), fourth.unwrap());
        prop_assert!(third <= fourth * (1.0 + 1e-9));
        // Ages in a range are among those below its upper end.
        if let (Some(second), Some(ages)) = (second, ages) {
            prop_assert!(ages >= second * (1.0 - 1e-6), "{ages} {second}");
        }
        if case.h == 0.0 {
            // The longest delay behind a buffer is one of the ages.
            let ages = ages.unwrap();
            prop_assert!(ages <= fourth * (1.0 + 1e-9), "{ages} {fourth}");
            // A constant delay is one of the networks that tiers 1 and 2 admit.
            prop_assert!(first.is_none_or(|first| first <= third * (1.0 + 1e-9)), "{first:?} {third}");
            prop_assert!(second.is_none_or(|second| second <= fourth * (1.0 + 1e-9)), "{second:?} {fourth}");
        }
    }

    #[test]
    fn law_tiers_1_2_and_5_hold_for_the_sampled_dyad(case in case(), ticks in prop::array::uniform2(0..400_u32)) {
        // At a delay of whole periods no sample in use is older than T₁, T₂ and h.
        let h = 2e-3;
        let delay = ticks.map(|ticks| f64::from(ticks) * h);
        let case = Case { h, delay, jitter: 0.0, gap: 0.0, ..case };
        let axis = case.dyad().axis(0).unwrap();
        let [first, second, ages, ..] = case.bounds();
        for bound in [first, second, ages].into_iter().flatten() {
            let spectrum = sampled_spectral_radius(&axis, 0.999 * bound, &case.network()).unwrap();
            prop_assert!(spectrum.is_stable(), "{bound} {spectrum:?}");
        }
    }

    #[test]
    fn law_the_solved_stiffness_keeps_tier_2_with_equality(case in case()) {
        let case = Case { c: 0.0, ..case };
        let k = case.bounds()[1].unwrap();
        let network = case.network();
        let [t1, t2] = network.oldest_partner_sample();
        let h = network.oldest_own_sample();
        let [d1, d2] = case.b.map(|b| b - k * h);
        prop_assert!(d1 > 0.0 && d2 > 0.0);
        // The differences B − k h lose at most a digit or two here.
        prop_assert!((k * (t1 + t2) / (2.0 * (d1 * d2).sqrt()) - 1.0).abs() < 1e-11);
    }

    #[test]
    fn law_a_worse_network_never_allows_more(case in case(), more in 1.0..3.0_f64) {
        let [base, jitter, gap, delay] = [
            case,
            Case { jitter: case.jitter * more + 1e-3, ..case },
            Case { gap: case.gap * more + 1e-3, ..case },
            Case { delay: case.delay.map(|v| v * more), ..case },
        ].map(|case| case.bounds());
        for worse in [jitter, gap, delay] {
            // Not so for tier 4: some dyads are stable again at a longer delay.
            if let (Some(base), Some(worse)) = (base[1], worse[1]) {
                prop_assert!(worse <= base * (1.0 + 1e-9), "{worse} {base}");
            }
            prop_assert_eq!((base[0], base[3]), (worse[0], worse[3]));
        }
        // A longer delay may be a stable one again for ages in a range, too; more of them never help.
        for worse in [jitter, gap] {
            if let (Some(base), Some(worse)) = (base[2], worse[2]) {
                prop_assert!(worse <= base * (1.0 + 1e-3), "{worse} {base}");
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 6, failure_persistence: None, ..Default::default() })]

    #[test]
    fn law_no_operator_in_the_range_is_worse_than_the_worst(
        case in case(), parts in prop::collection::vec(prop::array::uniform6(0.0..1.0_f64), 20),
        held in any::<bool>(),
    ) {
        let case = Case { c: 0.0, kh: [0.0; 2], h: if held { 0.0 } else { 2e-3 }, computing: 0.0, ..case };
        let top = [1.5, 10.0, 200.0];
        let operator = |part: &[f64]| {
            let [m, b, k] = [0, 1, 2].map(|i| vec![part[i] * top[i]]);
            Operator::new(m, b, k).unwrap()
        };
        let range = OperatorRange::new(operator(&[0.0; 3]), operator(&[1.0; 3])).unwrap();
        let dyad = case.dyad();
        let over = verdicts(&dyad, Some(&[range.clone(), range]), case.k, &case.network()).unwrap();
        for part in parts {
            let [first, second] = dyad.robots().clone();
            let dyad = Dyad::new(first, second, Some([operator(&part[..3]), operator(&part[3..])]), 0.0).unwrap();
            let one = verdicts(&dyad, None, case.k, &case.network()).unwrap();
            for tier in Tier::ALL {
                let (all, one) = (over.tier(tier), one.tier(tier));
                // Tiers 3 and 4 are searched, to 1e-4 of the box; tier 5 ends just below its first failure.
                let slack = if tier >= Tier::AgeInRange { 1e-3 } else { 1e-9 };
                let (all_bound, one_bound) = (all.stiffness_bound.unwrap(), one.stiffness_bound.unwrap());
                prop_assert!(all_bound <= one_bound * (1.0 + slack), "{tier:?} {all_bound} {one_bound} {part:?}");
            }
        }
    }

    #[test]
    fn law_a_range_of_one_operator_is_that_operator(case in case()) {
        let dyad = case.dyad();
        let ranges = dyad.operators().each_ref().map(|o| OperatorRange::new(o.clone(), o.clone()).unwrap());
        let ranged = verdicts(&dyad, Some(&ranges), case.k, &case.network()).unwrap();
        prop_assert_eq!(ranged, case.verdicts());
    }
}

/// Two robots in the hands of operators between nothing and `firm` (mass, damping, stiffness).
fn over_operators(robots: [[f64; 2]; 2], firm: [f64; 3], k: f64, network: &Network) -> Verdicts {
    let operator = |part: f64| {
        let [m, b, kh] = firm.map(|v| vec![part * v]);
        Operator::new(m, b, kh).unwrap()
    };
    let [first, second] = robots.map(|[m, b]| Robot::new(vec![m], vec![b], None).unwrap());
    let range = OperatorRange::new(operator(0.0), operator(1.0)).unwrap();
    let dyad = Dyad::new(first, second, None, 0.0).unwrap();
    verdicts(&dyad, Some(&[range.clone(), range]), k, network).unwrap()
}

/// A bound over a range is proven or not given. That of one pair of operators holds, and is kept, where its proof ends early.
#[test]
fn law_a_bound_of_any_network_is_sound_or_not_given() {
    let [first, second] = [[1.2, 6.0], [2.0, 9.0]].map(|[m, b]| Robot::new(vec![m], vec![b], None).unwrap());
    let held = |m: f64, b: f64, ground: f64| Operator::new(vec![m], vec![b], vec![ground]).unwrap();
    let judged = |damper: f64, high: Operator, computing: f64| {
        let delay = Delay::each_way(0.04).unwrap();
        let network = Network::new(delay, 0.01, 0.0, 1e-3, computing).unwrap();
        let dyad = Dyad::new(first.clone(), second.clone(), None, damper).unwrap();
        let range = OperatorRange::new(held(0.0, 0.0, 0.0), high).unwrap();
        verdicts(&dyad, Some(&[range.clone(), range]), 1.0, &network).unwrap()
    };
    let reason = Some(Unavailable::UnprovenOverRange);
    for found in [judged(4.0, held(1.0, 2.0, 0.0), 0.0), judged(0.0, held(1.0, 2.0, 50.0), 5e-4)] {
        let tier = found.tier(Tier::AnyNetwork);
        assert_eq!((tier.stiffness_bound, tier.unavailable, tier.satisfied), (None, reason, false));
        assert!(!tier.proven && !tier.attained && tier.margin.is_none());
        assert!(found.stiffness_allowed.is_none_or(|allowed| allowed.tier != Tier::AnyNetwork));
        assert!(found.axes[0].tiers[0].least_found.is_some_and(|least| least > 1.0));
    }
    for found in [judged(0.0, held(1.0, 2.0, 0.0), 5e-4), judged(0.0, held(1.0, 2.0, 50.0), 0.0)] {
        let tier = found.tier(Tier::AnyNetwork);
        assert!(tier.satisfied && tier.unavailable.is_none() && tier.stiffness_bound.is_some());
    }
    // A computing time and a ground of 1e-9 N/m: the proof ends early, and what it proved counts.
    let weak = Some([held(0.0, 0.0, 0.0), held(0.0, 0.0, 1e-9)]);
    let dyad = Dyad::new(first.clone(), second.clone(), weak, 0.0).unwrap();
    let network = Network::new(Delay::each_way(0.04).unwrap(), 0.0, 0.0, 1e-3, 5e-4).unwrap();
    let bound = verdicts(&dyad, None, 1.0, &network).unwrap().tier(Tier::AnyNetwork).stiffness_bound;
    let softer = verdicts(&dyad, None, (0.5 * bound.unwrap()).max(1e-6), &network).unwrap();
    let tier = softer.tier(Tier::AnyNetwork);
    assert!(!tier.proven && tier.satisfied, "{tier:?}");
}

/// With a damper and hands from 0 to 300 N/m the sampled bound is near the continuous one, and it holds for hands drawn.
#[test]
fn law_a_damper_and_hands_from_nothing_have_a_sampled_bound() {
    let [first, second] = [[1.2, 6.0], [2.0, 9.0]].map(|[m, b]| Robot::new(vec![m], vec![b], None).unwrap());
    let held = |ground: f64| Operator::new(vec![0.0], vec![0.0], vec![ground]).unwrap();
    let network = Network::new(Delay::each_way(0.04).unwrap(), 0.0, 0.0, 1e-3, 0.0).unwrap();
    let dyad = Dyad::new(first, second, None, 2.0).unwrap();
    let range = OperatorRange::new(held(0.0), held(300.0)).unwrap();
    let found = verdicts(&dyad, Some(&[range.clone(), range]), 150.0, &network).unwrap();
    assert_eq!((found.sampled_stable, found.sampled_proven), (Some(true), Some(true)));
    let bound = found.axes[0].sampled_stiffness_bound.unwrap();
    let continuous = found.tier(Tier::ConstantDelay).stiffness_bound.unwrap();
    assert!(bound > 0.9 * continuous && bound <= continuous, "{bound} {continuous}");
    for i in 1..=300 {
        let part = |step: f64| (f64::from(i) * step).fract();
        let (one, other) = (300.0 * part(0.618_034), 300.0 * part(0.754_878));
        let axis = DyadAxis::with_operators(1.2, 6.0, 2.0, 9.0, one, other, 2.0).unwrap();
        for k in [0.999 * bound, bound * part(0.569_84), 1e-3 * bound] {
            assert!(sampled_spectral_radius(&axis, k, &network).unwrap().is_stable(), "{one} {other} {k}");
        }
    }
}

/// The largest sampled |z| over the corners of the range.
fn largest_radius(robots: [[f64; 2]; 2], firm: [f64; 3], k: f64, network: &Network) -> f64 {
    (0..64).fold(0.0, |largest: f64, bits: u32| {
        let end = |i: u32| if bits >> i & 1 == 1 { firm[i as usize % 3] } else { 0.0 };
        let [[m1, b1], [m2, b2]] = robots;
        let axis = telespring::DyadAxis::with_operators(
            m1 + end(0),
            b1 + end(1),
            m2 + end(3),
            b2 + end(4),
            end(2),
            end(5),
            0.0,
        )
        .unwrap();
        largest.max(sampled_spectral_radius(&axis, k, network).unwrap().radius)
    })
}

#[test]
fn law_the_sampled_bound_holds_at_every_corner_whatever_is_asked() {
    let hman = [[0.8334, 7.7257], [0.7776, 7.4208]];
    let cases = [
        ([[0.38, 7.4], [0.55, 6.6]], [0.0, 1.75, 290.0], 0.036, 0.05, 0.045),
        (hman, [0.0, 2.0, 300.0], 0.01, 0.01, 0.01),
        (hman, [0.0, 2.0, 300.0], 0.01, 0.004, 0.004),
    ];
    for (robots, firm, delay, period, computing) in cases {
        let network = Network::new(Delay::each_way(delay).unwrap(), 0.0, 0.0, period, computing).unwrap();
        let bound = |k: f64| {
            over_operators(robots, firm, k, &network).axes[0]
                .sampled_stiffness_bound
                .expect("a sample period")
        };
        let least = bound(1.4);
        assert_eq!(least, bound(80.0));
        // The search over all operators ends within 1 % of the truth, unless a slow hold keeps it from that.
        let inside = largest_radius(robots, firm, 0.9999 * least, &network);
        let outside = largest_radius(robots, firm, 1.01 * least, &network);
        let verdicts = over_operators(robots, firm, 1.01 * least, &network);
        assert!(inside < 1.0, "{least} {inside}");
        assert!(outside > 1.0 || verdicts.sampled_proven == Some(false), "{least} {outside}");
        assert!(outside < 1.0 || verdicts.sampled_stable == Some(false), "{least} {outside}");
        assert_eq!(over_operators(robots, firm, 0.9999 * least, &network).sampled_stable, Some(true));
    }
}

/// Zero or a number over all decades between two.
fn wide(low: f64, high: f64) -> impl Strategy<Value = f64> {
    prop_oneof![1 => Just(0.0), 4 => (low.log10()..high.log10()).prop_map(|v| 10.0_f64.powf(v))]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 32, failure_persistence: None, ..Default::default() })]

    #[test]
    fn law_every_valid_input_has_a_verdict(
        m in prop::array::uniform2(wide(0.1, 10.0)), b in prop::array::uniform2(wide(0.1, 100.0)),
        kh in prop::array::uniform2(wide(1.0, 1e3)), c in wide(0.01, 10.0), k in wide(0.1, 1e4),
        delay in prop::array::uniform2(wide(1e-4, 1.0)), jitter in wide(1e-4, 0.1), h in wide(1e-4, 0.1),
        part in 0.0..1.0_f64,
    ) {
        let m = m.map(|m| m.max(0.1));
        let case = Case { m, b, kh, c, k: k.max(0.1), delay, jitter, gap: 0.0, h, computing: part * h };
        let result = case.verdicts();
        for verdict in &result.tiers {
            prop_assert!(verdict.stiffness_bound.is_none_or(|bound| bound >= 0.0), "{verdict:?}");
            prop_assert_eq!(verdict.stiffness_bound.is_none(), verdict.unavailable.is_some());
            // Below a bound every stiffness is allowed.
            let below = verdict.margin.is_some_and(|margin| margin.ratio > 1.0 + 1e-9);
            prop_assert!(!below || verdict.satisfied, "{verdict:?}");
        }
        for axis in &result.axes {
            prop_assert!(axis.sampled.is_none_or(|sampled| sampled.radius >= 0.0), "{axis:?}");
            prop_assert!(axis.sampled_stiffness_bound.is_none_or(|bound| bound >= 0.0), "{axis:?}");
        }
        prop_assert!(result.stiffness_allowed_behind_buffer.is_some());
    }
}

proptest! {
    /// Sampled controllers round each way up to whole periods: another share of a round trip adds one period at most.
    #[test]
    fn law_the_share_of_a_round_trip_adds_one_sample_period_at_most(
        m in prop::array::uniform2(0.3..3.0_f64), b in prop::array::uniform2(0.5..20.0_f64), k in 5.0..300.0_f64,
        round_trip in 0.0..0.2_f64, share in 0.0..1.0_f64, h in 0.001..0.02_f64,
    ) {
        let axis = DyadAxis::new(m[0], b[0], m[1], b[1]).unwrap();
        let radius = |forward: f64, backward: f64| {
            let delay = Delay::new(forward, backward).unwrap();
            sampled_spectral_radius(&axis, k, &Network::new(delay, 0.0, 0.0, h, 0.0).unwrap()).unwrap().radius
        };
        let shared = radius(share * round_trip, (1.0 - share) * round_trip);
        let least = (round_trip / h).ceil();
        prop_assert!(shared == radius(least * h, 0.0) || shared == radius(0.0, (least + 1.0) * h));
    }
}

/// 80 ms at a period of 10 ms: 4 + 4 periods, or 5 + 4. Between their limits the share decides.
#[test]
fn ref_the_share_of_a_ping_can_decide_over_stability() {
    let network = |forward: f64, backward: f64| {
        Network::new(Delay::new(forward, backward).unwrap(), 0.0, 0.0, 0.01, 0.0).unwrap()
    };
    let bound =
        |network: &Network| verdicts(&hman(), None, 50.0, network).unwrap().axes[0].sampled_stiffness_bound;
    let (even, uneven) = (bound(&network(0.04, 0.04)).unwrap(), bound(&network(0.045, 0.035)).unwrap());
    assert_eq!(bound(&network(0.045, 0.035)), bound(&network(0.041, 0.039)));
    assert!(uneven < 0.97 * even, "{even} {uneven}");
    let between = 0.5 * (even + uneven);
    let stable =
        |network: &Network| verdicts(&hman(), None, between, network).unwrap().axes[0].sampled_stable;
    assert_eq!(stable(&network(0.04, 0.04)), Some(true));
    assert_eq!(stable(&network(0.045, 0.035)), Some(false));
}

/// Without damping worth the name the search for the sampled bound may end before it decides: the bound is then the
/// stiffness up to which stability is proven, and the status says so. Otherwise a stiffer spring is unstable.
#[test]
fn law_a_sampled_bound_is_called_proven_only_if_a_stiffer_spring_is_unstable() {
    let side = |mass: f64, damping: f64| Robot::new(vec![mass], vec![damping], None).unwrap();
    let held = |stiffness: f64| Operator::new(vec![0.0], vec![0.0], vec![stiffness]).unwrap();
    let cases = [
        ([1.1122649, 0.00184373], [2.90655e-5, 1.447e-7], [0.0, 41.91], 0.8337655597, 0.001),
        (
            [1.0895889044043683, 0.0184593931848644],
            [2.408705685336556e-7, 1.431324737836219e-6],
            [25.335320295626577, 59.980157047441836],
            0.0896932337378196,
            0.0001,
        ),
        ([0.8, 0.9], [7.0, 8.0], [0.0, 100.0], 0.1, 0.001),
    ];
    let proven = cases.map(|(mass, damping, ground, delay, period)| {
        let operators = Some(ground.map(held));
        let dyad = Dyad::new(side(mass[0], damping[0]), side(mass[1], damping[1]), operators, 0.0).unwrap();
        let network = Network::new(Delay::each_way(delay).unwrap(), 0.0, 0.0, period, 0.0).unwrap();
        let axis = &verdicts(&dyad, None, 1.0, &network).unwrap().axes[0];
        let bound = axis.sampled_stiffness_bound.unwrap();
        let stable = |k: f64| {
            let found = sampled_spectral_radius(&dyad.axis(0).unwrap(), k, &network).unwrap();
            found.is_stable()
        };
        assert!(stable(0.999 * bound), "{mass:?} {bound}");
        let limited = Some(1.0001 * bound) >= axis.tiers[Tier::ConstantDelay as usize].stiffness_bound;
        assert_eq!(axis.sampled_proven, Some(limited || !stable(1.0001 * bound)), "{mass:?} {bound}");
        axis.sampled_proven
    });
    assert_eq!(proven, [Some(true); 3]);
}

/// The end of a range of delays counts in whole periods as the same delay does alone, rounding included.
#[test]
fn law_the_end_of_a_range_of_delays_counts_as_that_delay_alone() {
    let robot = |mass: f64, damping: f64| Robot::new(vec![mass], vec![damping], None).unwrap();
    let dyad = Dyad::new(robot(1.2, 6.0), robot(2.0, 9.0), None, 0.0).unwrap();
    let (k, period) = (40.0, 0.001);
    let network = |delay: f64| Network::new(Delay::each_way(delay).unwrap(), 0.0, 0.0, period, 0.0).unwrap();
    let limit = delay_limit(&dyad, None, k, &network(0.1)).unwrap().delay;
    assert!(limit / period > 50.0);
    let answers = [-0.5, 0.0, 1e-10, 2e-8, 1e-6, 0.5].map(|periods| {
        let network = network(limit + periods * period);
        let alone = sampled_spectral_radius(&dyad.axis(0).unwrap(), k, &network).unwrap().is_stable();
        assert_eq!(is_stable_over_delays(&dyad, None, k, &network, (0.9, 1.0)).unwrap(), alone, "{periods}");
        alone
    });
    assert_eq!(answers, [true, true, true, false, false, false]);
}

/// A limit is attained where the dyad is stable at it, on all axes: also a limit of no delay.
#[test]
fn law_a_limit_is_attained_where_it_is_stable() {
    let robot = |scale: f64| Robot::new(vec![0.8, 0.8 * scale], vec![5.0, 5.0 * scale], None).unwrap();
    let network = |delay: f64| Network::new(Delay::each_way(delay).unwrap(), 0.0, 0.0, 0.001, 0.0).unwrap();
    let mut found = std::collections::BTreeSet::new();
    for scale in [0.6, 1.0, 3.0] {
        let dyad = Dyad::new(robot(scale), robot(scale), None, 0.0).unwrap();
        for step in 0..=60 {
            let k = 50.0 * 10f64.powf(f64::from(step) / 12.0);
            let limit = delay_limit(&dyad, None, k, &network(0.05)).unwrap();
            let is_stable = (0..2).all(|at| {
                sampled_spectral_radius(&dyad.axis(at).unwrap(), k, &network(limit.delay))
                    .unwrap()
                    .is_stable()
            });
            assert_eq!(limit.attained, is_stable, "{k} N/m, scale {scale}, {limit:?}");
            found.insert((limit.delay > 0.0, limit.attained));
        }
    }
    assert_eq!(found.into_iter().collect::<Vec<_>>(), [(false, false), (false, true), (true, true)]);
}

/// Over a range a limit of no delay is attained only where all of it is stable, not its middle alone.
#[test]
fn law_a_limit_over_a_range_is_attained_where_all_of_it_is_stable() {
    let robot = || Robot::new(vec![1.0], vec![5.0], None).unwrap();
    let hand = |damping: f64| Operator::new(vec![0.0], vec![damping], vec![0.0]).unwrap();
    let dyad = Dyad::new(robot(), robot(), None, 0.0).unwrap();
    let range = OperatorRange::new(hand(0.0), hand(20.0)).unwrap();
    let network = |delay: f64| Network::new(Delay::each_way(delay).unwrap(), 0.0, 0.0, 0.001, 0.0).unwrap();
    let ranges = [range.clone(), range];
    let found = [4000.0, 6000.0].map(|k| {
        let limit = delay_limit(&dyad, Some(&ranges), k, &network(0.05)).unwrap();
        let judged = verdicts(&dyad, Some(&ranges), k, &network(0.0)).unwrap();
        assert_eq!(judged.axes[0].sampled_stable, Some(limit.attained));
        (limit.delay, limit.attained)
    });
    assert_eq!(found, [(0.0, true), (0.0, false)]);
}

/// The worst operators of a range have its ends, or values apart from them: no remainder of a subtraction.
#[test]
fn law_the_worst_operators_have_the_ends_of_their_range() {
    let mut state = 7_u64;
    let mut uniform = |low: f64, high: f64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let operator =
        |values: [f64; 3]| Operator::new(vec![values[0]], vec![values[1]], vec![values[2]]).unwrap();
    for _ in 0..60 {
        let robots =
            [0, 1].map(|_| Robot::new(vec![uniform(0.3, 3.0)], vec![uniform(0.5, 12.0)], None).unwrap());
        let most = [0, 1].map(|_| [uniform(0.0, 2.0), uniform(0.1, 9.0), uniform(10.0, 300.0)]);
        let ranges = most.map(|most| OperatorRange::new(operator([0.0; 3]), operator(most)).unwrap());
        let [one, two] = robots;
        let dyad = Dyad::new(one, two, None, 0.0).unwrap();
        let network =
            Network::new(Delay::each_way(uniform(0.01, 0.3)).unwrap(), 0.0, 0.0, 0.001, 0.0).unwrap();
        for tier in &verdicts(&dyad, Some(&ranges), uniform(5.0, 100.0), &network).unwrap().axes[0].tiers {
            for (at, most) in tier.operators.iter().zip(most) {
                for (value, high) in [at.mass, at.damping, at.stiffness].into_iter().zip(most) {
                    let apart = value.min(high - value);
                    assert!(apart == 0.0 || apart > 1e-12, "{value:e} of {high:e}");
                }
            }
        }
    }
}
