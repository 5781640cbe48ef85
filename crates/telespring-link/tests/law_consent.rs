//! Random orders, faults, restarts, losses, repetitions and greetings of the past, in virtual time: no force without the
//! consent of both, and no two willing sides kept apart.

mod common;

use common::{Pair, hman_study};
use telespring::study::Study;
use telespring_link::hello::{Greeting, MAGIC};
use telespring_link::operator::Order;
use telespring_link::site::{Happened, Interruption, Phase};

fn study() -> Study {
    hman_study("coupling.stiffness = 100\nnetwork.delay = 0.02\nsession.strategy = \"guard\"")
}

/// Draws (Steele, Lea and Flood: SplitMix64).
struct Random(u64);

impl Random {
    fn below(&mut self, count: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (mixed ^ (mixed >> 31)) % count
    }
}

/// What the test itself knows of a side.
#[derive(Debug, Clone, Copy, Default)]
struct Known {
    /// Since when the person there consents, in ticks.
    consents: Option<u64>,
    /// When the side itself ended its coupling last, not the partner.
    left: u64,
    was_coupled: bool,
}

/// What has happened in all cases: a test that sees too little proves nothing.
#[derive(Debug, Default)]
struct Seen {
    couplings: u32,
    forces: u32,
    interruptions: u32,
    injected: u32,
    restarts: u32,
}

struct Case {
    pair: Pair,
    random: Random,
    known: [Known; 2],
    /// Datagrams of the past, towards each side.
    past: [Vec<Vec<u8>>; 2],
    sessions: u64,
    tick: u64,
}

impl Case {
    fn new(seed: u64) -> Self {
        let pair = Pair::with([&study(), &study()], 0.02, |settings| settings);
        let known = [Known::default(); 2];
        Self { pair, random: Random(seed), known, past: [Vec::new(), Vec::new()], sessions: 100, tick: 0 }
    }

    /// Somebody does something, or something breaks.
    fn disturb(&mut self, seen: &mut Seen) {
        let side = usize::try_from(self.random.below(2)).unwrap();
        let orders =
            [Order::Consent, Order::Consent, Order::Consent, Order::Resume, Order::Resume, Order::Clear];
        match self.random.below(400) {
            0..=11 => {
                let order = orders[usize::try_from(self.random.below(6)).unwrap()];
                self.pair.order(side, order);
            }
            12 => self.pair.order(side, Order::Pause),
            13 => self.pair.order(side, Order::Withdraw),
            14 if self.random.below(4) == 0 => {
                self.pair.devices[side].change(|script| script.is_stopped = true)
            }
            15..=20 => {
                self.pair.devices[side].change(|script| (script.is_stopped, script.is_ready) = (false, true))
            }
            21 if self.random.below(4) == 0 => {
                self.pair.devices[side].change(|script| script.is_ready = false)
            }
            22 if self.random.below(6) == 0 => {
                self.sessions += 1;
                self.pair.restart(&study(), side, self.sessions);
                self.known[side] = Known { left: self.tick, ..Known::default() };
                seen.restarts += 1;
            }
            23..=60 => self.inject(side, seen),
            _ => {}
        }
        let is_bad = self.tick / 700 % 3 == 1;
        let mut wire = self.pair.ends[0].wire.borrow_mut();
        for side in 0..2 {
            wire.is_cut[side] = self.random.below(100) < if is_bad { 60 } else { 3 };
        }
    }

    /// Delivers a datagram of the past, greetings above all, once more.
    fn inject(&mut self, side: usize, seen: &mut Seen) {
        let count = self.past[side].len() as u64;
        if count > 0 {
            let which = usize::try_from(self.random.below(count)).unwrap();
            let datagram = self.past[side][which].clone();
            self.pair.ends[0].wire.borrow_mut().injected[side].push(datagram);
            seen.injected += 1;
        }
    }

    fn step(&mut self, seen: &mut Seen) {
        self.pair.tick();
        self.tick += 1;
        for side in 0..2 {
            let latest = self.pair.ends[0].wire.borrow_mut().latest[side].take();
            if let Some(datagram) =
                latest.filter(|datagram| datagram.starts_with(&MAGIC) || self.tick.is_multiple_of(50))
            {
                self.past[side].push(datagram.to_vec());
            }
        }
        for side in 0..2 {
            self.note(side, seen);
        }
        for side in 0..2 {
            self.judge(side, seen);
        }
    }

    /// What the log of a side says of this tick.
    fn note(&mut self, side: usize, seen: &mut Seen) {
        let (tick, known) = (self.tick, &mut self.known[side]);
        for (_, happened) in self.pair.site_of(side).log().news() {
            match happened {
                Happened::Consented => known.consents = Some(tick),
                Happened::Interrupted(interruption) => {
                    seen.interruptions += 1;
                    if !matches!(interruption, Interruption::Partner(_) | Interruption::PartnerChanged) {
                        known.left = tick;
                    }
                }
                _ => {}
            }
        }
        if !self.pair.moment(side).consents[0] {
            known.consents = None;
        }
    }

    fn judge(&mut self, side: usize, seen: &mut Seen) {
        let moment = self.pair.moment(side);
        let is_coupled = matches!(moment.phase, Phase::RampingIn | Phase::Running);
        let has_force = moment.force != [0.0; 2];
        seen.forces += u32::from(has_force);
        assert!(!has_force || moment.phase.is_coupled(), "{moment:?}");
        // the own consent, always
        assert!(!is_coupled || self.known[side].consents.is_some(), "{moment:?}");
        if is_coupled && !self.known[side].was_coupled {
            seen.couplings += 1;
            let own = self.known[side];
            let there = self.past[side].iter().rev().filter_map(|datagram| Greeting::decode(datagram).ok());
            // the partner has said so lately, and after this side ended the last coupling
            let said = there.take(40).find(|greeting| greeting.stance.has_consented);
            assert!(said.is_some(), "{moment:?}");
            if let Some(given) = self.known[1 - side].consents {
                assert!(given > own.left, "{given} {own:?} {moment:?}");
            }
        }
        self.known[side].was_coupled = is_coupled;
    }
}

#[test]
fn law_no_history_of_losses_restarts_and_old_greetings_starts_a_force_without_two_consents() {
    let mut seen = Seen::default();
    for seed in 0..40 {
        let mut case = Case::new(seed);
        for _ in 0..8000 {
            case.disturb(&mut seen);
            case.step(&mut seen);
        }
        // all is well again, and both are willing
        case.pair.ends[0].wire.borrow_mut().is_cut = [false; 2];
        for device in &case.pair.devices {
            device.change(|script| (script.is_stopped, script.is_ready) = (false, true));
        }
        for round in 0..40 {
            for side in 0..2 {
                let order = [Order::Clear, Order::Resume, Order::Consent][round % 3];
                case.pair.order(side, order);
            }
            (0..100).for_each(|_| case.step(&mut seen));
        }
        let log = |side| {
            let entries = case.pair.site_of(side).log().entries();
            entries[entries.len().saturating_sub(20)..].to_vec()
        };
        let (phases, logs) = (case.pair.phases(), [log(0), log(1)]);
        assert_eq!(phases, [Phase::Running; 2], "{seed}: kept apart: {logs:#?}");
    }
    println!("{seen:?}");
    assert!(seen.couplings > 200 && seen.forces > 20_000 && seen.interruptions > 200, "{seen:?}");
    assert!(seen.injected > 10_000 && seen.restarts > 40, "{seen:?}");
}

#[test]
fn law_a_partner_that_lies_about_its_consent_moves_nobody_who_did_not_consent() {
    let mut pair = Pair::with([&study(), &study()], 0.02, |settings| settings);
    pair.run(500, |_, _| {});
    let claim = |pair: &Pair, change: &dyn Fn(&mut Greeting)| {
        let mut greeting = Greeting::decode(&pair.ends[0].wire.borrow().latest[0].unwrap()).ok()?;
        change(&mut greeting);
        Some(greeting.encode().to_vec())
    };
    for tick in 0..3000_u32 {
        let lie = claim(&pair, &|greeting| {
            greeting.stance.has_consented = true;
            greeting.stance.is_aligned = true;
            greeting.stance.round = tick * 1_000_000;
            greeting.stamps.sent += u64::from(tick);
        });
        if let Some(lie) = lie {
            pair.ends[0].wire.borrow_mut().injected[0].push(lie);
        }
        pair.tick();
        assert_eq!(pair.forces(), [[0.0; 2]; 2]);
        assert!(!pair.phases()[0].is_coupled());
    }
    assert!(!pair.moment(0).consents[0]);
}
