//! What a partner can make a site log, whatever it says, in virtual time; and that nothing that happens here is lost in it.

mod common;

use common::{Pair, hman_study};
use telespring::study::Study;
use telespring_link::hello::{Disagreement, Greeting};
use telespring_link::operator::{Label, Mark, MarkKind, Order};
use telespring_link::site::{Happened, LOG_CAPACITY, Phase};

fn study() -> Study {
    hman_study("coupling.stiffness = 100\nnetwork.delay = 0.02\nsession.strategy = \"guard\"")
}

/// News per second that a partner can cause for good, and in a row.
const MOST_PER_SECOND: usize = 250;
const MOST_IN_A_ROW: usize = 512;

#[test]
fn law_a_partner_that_changes_its_mind_all_the_time_fills_neither_log_nor_recording() {
    type Change = fn(&mut Greeting, u64);
    let whims: [(&str, Change); 4] = [
        ("another session", |greeting, number| greeting.session = 1000 + number),
        ("another refusal", |greeting, number| {
            let refusals = [None, Some(Disagreement::Study), Some(Disagreement::Robots)];
            greeting.refusal = refusals[(number % 3) as usize];
        }),
        ("consents and not", |greeting, number| greeting.stance.has_consented = number % 2 == 0),
        ("stops and not", |greeting, number| greeting.stance.is_stopped = number % 2 == 0),
    ];
    for (name, whim) in whims {
        let mut pair = Pair::with([&study(), &study()], 0.02, |settings| settings);
        pair.run(500, |_, _| {});
        assert_eq!(pair.phases(), [Phase::Consenting; 2]);
        let heard = pair.ends[0].wire.borrow().latest[0].unwrap();
        let honest = Greeting::decode(&heard).unwrap();
        let (mut news, mut number) = (0, 0);
        for _ in 0..10_000 {
            for _ in 0..20 {
                let mut greeting = honest;
                number += 1;
                // later than any that the honest partner sends
                greeting.stamps.sent += 1_000_000_000_000 + number;
                whim(&mut greeting, number);
                pair.ends[0].wire.borrow_mut().injected[0].insert(0, greeting.encode().to_vec());
            }
            pair.tick();
            news += pair.site_of(0).log().news().len();
            assert_eq!(pair.forces()[0], [0.0; 2]);
        }
        assert!(news <= MOST_IN_A_ROW + 10 * MOST_PER_SECOND + 100, "{name}: {news}");
        // what happens here is on record all the same
        pair.devices[0].change(|script| script.is_stopped = true);
        pair.tick();
        assert!(pair.happened(0, &Happened::EmergencyStop { is_own: true }), "{name}");
        let log = pair.site_of(0).log();
        assert!(log.entries().len() < LOG_CAPACITY && log.missed() > 0, "{name}");
    }
}

#[test]
fn law_a_device_that_marks_all_the_time_leaves_room_for_what_happens() {
    let mut pair = Pair::with([&study(), &study()], 0.02, |settings| settings);
    let mark = Mark { kind: MarkKind::Note, label: Label::number(7) };
    let mut news = 0;
    for _ in 0..10_000 {
        pair.order(0, Order::Mark(mark));
        pair.tick();
        news += pair.site_of(0).log().news().len();
    }
    assert!(news <= MOST_IN_A_ROW + 10 * MOST_PER_SECOND + 100, "{news}");
    assert!(pair.happened(0, &Happened::Entered(Phase::Consenting)));
    pair.devices[0].change(|script| script.is_stopped = true);
    pair.tick();
    assert!(pair.happened(0, &Happened::EmergencyStop { is_own: true }));
}
