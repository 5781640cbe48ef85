//! The section `[network]` of a study.

use std::sync::Arc;

use telespring::InvalidInput;
use telespring::rig::{Adversary, Blackout, GilbertElliott, JitterDistribution, PacketOrder, RateLimit};
use telespring::study::Study;

use crate::recorded::read;

const ROBOTS: &str = "robot1 = {mass = [1, 1], damping = 5}\nrobot2 = {mass = [1, 1], damping = 5}\n";

fn study(text: &str) -> Result<Study, InvalidInput> {
    Study::from_toml(&format!("{ROBOTS}{text}"))
}

#[test]
fn law_the_section_network_says_everything_and_is_written_as_read() {
    let text = "[network]\ndelay = 0.05\njitter = {forward = 0.02, backward = 0.03}\nloss = 0.01\n\
                distribution = {forward = {kind = \"gamma\", mean = 0.004, sd = 0.002}}\n\
                burst = {backward = {to_bad = 0.01, to_good = 0.25}}\nduplicate = 0.1\norder = \"fifo\"\n\
                rate = {forward = 1e6, backward = {bits_per_second = 2e6, queue = 5}}\n\
                blackout = {start = 1, duration = 0.5, period = 4.0}\n";
    let given = study(text).unwrap();
    let network = given.laboratory().unwrap().network;
    assert_eq!((network.forward.jitter, network.backward.jitter), (0.02, 0.03));
    assert_eq!(network.forward.distribution, JitterDistribution::Gamma { mean: 0.004, sd: 0.002 });
    assert_eq!(network.backward.distribution, JitterDistribution::Uniform);
    assert_eq!(network.forward.burst, None);
    let burst = GilbertElliott { to_bad: 0.01, to_good: 0.25, loss_good: 0.0, loss_bad: 1.0 };
    assert_eq!(network.backward.burst, Some(burst));
    assert_eq!(network.forward.rate, Some(RateLimit { bits_per_second: 1e6, queue: RateLimit::QUEUE }));
    assert_eq!(network.backward.rate, Some(RateLimit { bits_per_second: 2e6, queue: 5 }));
    assert_eq!(network.forward.blackout, Some(Blackout { start: 1.0, duration: 0.5, period: Some(4.0) }));
    assert_eq!((network.forward.loss, network.backward.duplicate), (0.01, 0.1));
    assert_eq!(network.backward.order, PacketOrder::Fifo);
    // the verdicts assume the larger jitter
    assert_eq!(given.network().unwrap().jitter(), 0.03);
    assert_eq!(Study::from_toml(&given.to_toml()).unwrap(), given);
    assert!(given.moved_keys().is_empty());
}

#[test]
fn law_an_adversary_is_read_for_each_way_and_written_as_read() {
    for (written, expected) in [
        ("{kind = \"oldest-sample\", memory = 1}", Adversary::OldestSample { memory: 1.0 }),
        ("{kind = \"most-harmful-sample\", memory = 0.4}", Adversary::MostHarmfulSample { memory: 0.4 }),
        ("{kind = \"stretch-timed\", longest = 0.0}", Adversary::StretchTimed { longest: 0.0 }),
        (
            "{kind = \"lying-peer\", position = 0.05, stamp = -0.1, power = 5.0}",
            Adversary::LyingPeer { position: 0.05, stamp: -0.1, power: 5.0 },
        ),
    ] {
        for (value, both) in [
            (written.to_owned(), [Some(expected); 2]),
            (format!("{{forward = {written}}}"), [Some(expected), None]),
            (format!("{{backward = {written}}}"), [None, Some(expected)]),
        ] {
            let given = study(&format!("[network]\njitter = 0.01\nadversary = {value}\n")).unwrap();
            assert_eq!(given.adversaries(), both, "{value}");
            let network = given.laboratory().unwrap().network;
            assert_eq!([network.forward.adversary, network.backward.adversary], both, "{value}");
            assert_eq!(Study::from_toml(&given.to_toml()).unwrap(), given, "{value}");
        }
        assert!(written.contains(expected.kind()));
    }
    assert!(!study("").unwrap().to_toml().contains("adversary"));
    // the remedy for a word alone can be written as it stands
    let refused = study("network.adversary = \"lying-peer\"").unwrap_err();
    let remedy = refused.remedy.strip_prefix("Write ").unwrap().split(" with your").next().unwrap();
    let written = study(&format!("network.adversary = {remedy}")).unwrap();
    assert_eq!(written.adversaries()[0].unwrap().kind(), "lying-peer");
    // behind a recorded trace as behind any network
    let traced =
        study("[network]\ntrace = \"a.csv\"\nadversary = {kind = \"oldest-sample\", memory = 1.0}\n");
    let text = Some("time_s,delay_ms\n0,20\n1,40\n");
    let network = traced.unwrap().laboratory_on_texts([text, text]).unwrap().network;
    assert!(network.forward.trace.is_some() && network.forward.adversary.is_some());
}

#[test]
fn law_the_old_place_is_read_and_a_contradiction_refused() {
    let old = study("[laboratory]\njitter = 0.01\nloss = 0.1\n").unwrap();
    assert_eq!(old, study("[network]\njitter = 0.01\nloss = 0.1\n").unwrap());
    let moved = [("laboratory.jitter", "network.jitter"), ("laboratory.loss", "network.loss")];
    assert_eq!(old.moved_keys(), moved.map(|(old, new)| (old.to_owned(), new.to_owned())));
    let both = "network.delay = 0.05\nnetwork.jitter = 0.02\nlaboratory.jitter = ";
    assert_eq!(study(&format!("{both}0.02")).unwrap().emulated_network().jitter(), 0.02);
    assert_eq!(study(&format!("{both}0.01")).unwrap_err().field, "laboratory.jitter");
    // what replaces the one replaces the other
    use telespring::study::{Replacement, Value};
    let replaced = |section: &str| {
        let keys = [("jitter".to_owned(), Some(Value::from(0.005)))];
        old.replace(&[(section.to_owned(), Replacement::Keys(keys.into()))].into()).unwrap()
    };
    assert_eq!(replaced("network"), replaced("laboratory"));
    assert_eq!(replaced("network").emulated_network().jitter(), 0.005);
}

#[test]
fn law_a_network_that_cannot_be_is_refused_by_its_key() {
    for (text, field) in [
        ("distribution = \"gamma\"", "network.distribution"),
        ("distribution = {kind = \"gamma\", mean = 0.004, sd = 0.002}", "network.distribution.kind"),
        (
            "jitter = 0.01\ndistribution = {kind = \"normal\", mean = 0.02, sd = 0.002}",
            "network.distribution.mean",
        ),
        (
            "jitter = 0.01\ndistribution = {kind = \"normal\", mean = 0.002, sd = 0.02}",
            "network.distribution.sd",
        ),
        ("distribution = {kind = \"uniform\", mean = 0.1}", "network.distribution"),
        ("loss = 2", "network.loss"),
        ("loss = {forward = 0.1, backward = 1.5}", "network.loss.backward"),
        ("burst = 0.1", "network.burst"),
        ("burst = {to_bad = 0.1}", "network.burst.to_good"),
        ("burst = {to_bad = 0.1, to_good = 1.5}", "network.burst.to_good"),
        ("burst = {p = 0.1}", "network.burst.p"),
        ("order = \"lifo\"", "network.order"),
        ("rate = 0", "network.rate"),
        ("rate = {bits_per_second = 1e6, queue = -1}", "network.rate.queue"),
        ("blackout = {start = 1}", "network.blackout.duration"),
        ("blackout = {duration = 1, period = 0.5}", "network.blackout.period"),
        ("adversary = \"oldest-sample\"", "network.adversary"),
        ("adversary = 1.0", "network.adversary"),
        ("adversary = \"worst\"", "network.adversary"),
        ("adversary = {kind = \"worst\", memory = 1.0}", "network.adversary.kind"),
        ("adversary = {memory = 1.0}", "network.adversary.kind"),
        ("adversary = {kind = \"oldest-sample\"}", "network.adversary.memory"),
        ("adversary = {kind = \"oldest-sample\", memory = -1.0}", "network.adversary.memory"),
        ("adversary = {kind = \"most-harmful-sample\", memory = 1000.0}", "network.adversary.memory"),
        ("adversary = {kind = \"stretch-timed\", memory = 1.0}", "network.adversary.memory"),
        ("adversary = {backward = {kind = \"stretch-timed\"}}", "network.adversary.backward.longest"),
        ("adversary = {kind = \"lying-peer\", position = 0.1}", "network.adversary.stamp"),
        (
            "adversary = {kind = \"lying-peer\", position = 0.1, stamp = 0, power = -1}",
            "network.adversary.power",
        ),
        // no laboratory has 50 s
        (
            "adversary = {forward = {kind = \"stretch-timed\", longest = 50}}",
            "network.adversary.forward.longest",
        ),
        (
            "trace = \"a.csv\"\njitter = 0.1\ndistribution = {kind = \"normal\", mean = 0.002, sd = 0.02}",
            "network.distribution",
        ),
    ] {
        let refused = study(&format!("[network]\n{text}\n")).unwrap_err();
        assert_eq!(refused.field, field, "{text}: {refused}");
    }
}

#[test]
fn law_a_study_with_a_trace_needs_its_content() {
    let text = "[network]\ntrace = {file = \"a.csv\", round_trip = true}\ndelay = 0.05\njitter = 0.02\n[protocol]\ntrials = 2\n";
    let given = study(text).unwrap();
    assert_eq!(Study::from_toml(&given.to_toml()).unwrap(), given);
    assert_eq!(given.laboratory().unwrap_err().field, "network.trace");
    let trace = Arc::new(read("time_s,delay_ms\n0,20\n1,40\n").unwrap());
    let laboratory = given.laboratory_on([Some(trace.clone()), Some(trace.clone())]).unwrap();
    laboratory.check().unwrap();
    let way = laboratory.network.backward.clone();
    assert_eq!((way.jitter, way.trace.unwrap().rows()[1].delay), (0.0, 0.02));
    // the same from the text of the files, with their names where they are refused
    let text = Some("time_s,delay_ms\n0,20\n1,40\n");
    assert_eq!(given.laboratory_on_texts([text, text]).unwrap(), laboratory);
    let refused = given.laboratory_on_texts([text, Some("time_s\n0\n")]).unwrap_err();
    assert_eq!(refused.field, "a.csv, trace, column delay");
    // of IRTT the round trip is halved, and one way is that of the direction
    let stamps = r#""timestamps": {"client": {"send": {"monotonic": 0}}}"#;
    let trip = |ms: u32| {
        let delay = r#""delay": {"rtt": 30000000, "send": 20000000, "receive": 10000000}"#;
        format!(
            r#"{{"lost": "false", {}, {delay}}}"#,
            stamps.replace(": 0", &format!(": {}", ms * 1_000_000))
        )
    };
    let irtt = format!(r#"{{"round_trips": [{}, {}]}}"#, trip(0), trip(10));
    let delays = |study: &Study| {
        let network = study.laboratory_on_texts([Some(&irtt), Some(&irtt)]).unwrap().network;
        [network.forward, network.backward].map(|way| way.trace.unwrap().rows()[1].delay)
    };
    assert_eq!(delays(&given), [0.015, 0.015]);
    let one_way = study("network.trace = \"a.json\"").unwrap();
    assert_eq!(delays(&one_way), [0.02, 0.01]);
    assert_eq!(study("").unwrap().laboratory_on([Some(trace), None]).unwrap_err().field, "traces");
}
