//! The sections `[session]` and `[comparison]` of a study: what they say, what they refuse, and that they write what they
//! read.

use proptest::prelude::*;
use telespring::session::architecture::{PlayoutDesign, PredictorDesign, StrategyDesign};
use telespring::session::{AdaptiveDelay, Architecture, Span};
use telespring::study::Study;

const ROBOTS: &str = "robot1 = {mass = [1, 1], damping = 5}\nrobot2 = {mass = [1, 1], damping = 5}\n";

fn study(text: &str) -> Result<Study, telespring::InvalidInput> {
    Study::from_toml(&format!("{ROBOTS}{text}"))
}

#[test]
fn ref_a_session_says_strategy_predictor_and_play_out() {
    let read = |text: &str| *study(text).unwrap().session();
    assert_eq!(read(""), Architecture::default());
    for kind in StrategyDesign::KINDS {
        let strategy = StrategyDesign::of_kind(kind).unwrap();
        assert_eq!(strategy.kind(), kind);
        for text in
            [format!("session.strategy = {kind:?}"), format!("session.strategy = {{kind = {kind:?}}}")]
        {
            assert_eq!(read(&text), Architecture { strategy, ..Architecture::default() });
        }
    }
    for kind in PredictorDesign::KINDS {
        let predictor = PredictorDesign::of_kind(kind).unwrap();
        assert_eq!(predictor.kind(), kind);
        let text = format!("session.predictor = {kind:?}");
        assert_eq!(read(&text), Architecture { predictor, ..Architecture::default() });
    }
    let playout = read("session.playout = {kind = \"fixed\", delay = 0.05}").playout;
    assert_eq!(playout, PlayoutDesign::Fixed { delay: Some(0.05) });
    let playout = read("session.playout = {kind = \"adaptive\", margin = 0.002, largest = 0.3}").playout;
    let adaptive =
        AdaptiveDelay { margin: Span(2_000_000), largest: Span(300_000_000), ..AdaptiveDelay::default() };
    assert_eq!(playout, PlayoutDesign::Adaptive(adaptive));
}

/// The laboratory of a study runs its session, with the lower end of each robot's 95 % interval.
#[test]
fn ref_the_laboratory_has_the_study_s_session() {
    let text = "robot1 = {mass = [1, 1], damping = [5, 6], damping_sd = [1, 0], mass_sd = 0.01}\n\
                robot2 = {mass = [1, 1], damping = 5}\n\
                network = {delay = 0.05, jitter = {forward = 0.02, backward = 0.05}, max_gap = 0.01, playout_buffer = true}\n\
                session = {strategy = \"guard\", predictor = \"shared-target\"}";
    let study = Study::from_toml(text).unwrap();
    let plan = study.laboratory().unwrap().session;
    assert_eq!(plan.architecture, *study.session());
    assert_eq!(plan.architecture.label(), "guard + shared-target");
    assert!((plan.least_damping[0][0] - (5.0 - 1.959964)).abs() < 1e-6);
    assert_eq!((plan.least_damping[0][1], plan.least_damping[1]), (6.0, [5.0; 2]));
    let [forward, backward] = plan.lateness;
    assert!((forward - 0.03).abs() < 1e-15 && (backward - 0.06).abs() < 1e-15 && plan.has_playout_buffer);
    let certain = Study::paper().laboratory().unwrap().session;
    assert_eq!(certain.least_damping[0], [7.7257, 10.1168]);
}

#[test]
fn ref_a_comparison_says_architectures_and_networks() {
    let usual = study("").unwrap();
    let labels: Vec<String> = usual.compared_architectures().iter().map(Architecture::label).collect();
    let expected = [
        "spring",
        "spring, adaptive",
        "guard",
        "guard + linear",
        "guard + kalman",
        "guard + shared-target",
        "injected-damping",
        "wave-variables",
        "time-domain-passivity",
        "two-layer",
        "set-position-modulation",
    ];
    assert_eq!(labels, expected);
    assert_eq!(usual.compared_networks(), None);
    let damped = study("coupling.damping = 1").unwrap().compared_architectures();
    assert!(damped.iter().all(|architecture| architecture.strategy.has_coupling_damper()));
    assert_eq!(damped.len(), 8);
    let text = "[comparison]\n\
                architectures = [\"spring\", {strategy = \"guard\", predictor = \"shared-target\"}]\n\
                [[comparison.networks]]\nname = \"still\"\n\
                [[comparison.networks]]\nname = \"Wi-Fi\"\njitter = 0.02\ndelay = [0, 0.05]\n\
                burst = {to_bad = 0.01, to_good = 0.25}";
    let chosen = study(text).unwrap();
    let labels: Vec<String> = chosen.compared_architectures().iter().map(Architecture::label).collect();
    assert_eq!(labels, ["spring", "guard + shared-target"]);
    let networks = chosen.compared_networks().unwrap();
    assert_eq!((networks[0].name.as_str(), networks[0].keys.len()), ("still", 0));
    assert_eq!((&networks[0].delays, &networks[1].delays), (&None, &Some(vec![0.0, 0.05])));
    assert_eq!(networks[1].keys["jitter"].as_float(), Some(0.02));
    assert_eq!(Study::from_toml(&chosen.to_toml()).unwrap(), chosen);
}

/// The label says the kinds; of the same kinds with other settings, the second is numbered.
#[test]
fn ref_labels_are_distinct() {
    let text = "comparison.architectures = [\"guard\", {strategy = {kind = \"guard\", share = 0.5}}, \"spring\",\
                {strategy = {kind = \"guard\", share = 0.4}, playout = \"fixed\"}]";
    let labels = Architecture::labels(&study(text).unwrap().compared_architectures());
    assert_eq!(labels, ["guard", "guard (2)", "spring", "guard (3)"]);
}

/// Text, and the field of its refusal with words of its remedy.
const REFUSED: [(&str, &str, &str); 30] = [
    ("session.strategy = \"gard\"", "session.strategy", "Did you mean \"guard\"?"),
    ("session.strategy = 3", "session.strategy", "Choose one of them."),
    ("session.strategy = {share = 0.5}", "session.strategy.kind", "kind = \"spring\""),
    ("session.strategy = {kind = \"spring\", share = 0.5}", "session.strategy.share", ""),
    ("session.strategy = {kind = \"guard\", shar = 0.5}", "session.strategy.shar", "share"),
    ("session.strategy = {kind = \"guard\", share = 1}", "session.strategy.share", "0.7"),
    ("session.strategy = {kind = \"guard\", share = 80}", "session.strategy.share", "0.8"),
    ("session.strategy = {kind = \"guard\", capacity = 50}", "session.strategy.capacity", "Write 0.05"),
    ("session.strategy = {kind = \"guard\", intake = \"0.3 W\"}", "session.strategy.intake", "Write 0.3"),
    ("session.strategy = {kind = \"wave-variables\", impedance = 0}", "session.strategy.impedance", ""),
    ("session.predictor = \"kalmann\"", "session.predictor", "\"kalman\""),
    ("session.predictor = {kind = \"kalman\", model = \"constant\"}", "session.predictor.model", ""),
    (
        "session.predictor = {kind = \"kalman\", model = \"constant-velocity\"}",
        "session.predictor.process",
        "process = 1.0",
    ),
    ("session.predictor = {kind = \"kalman\", position = 10}", "session.predictor.position", "Write 0.01."),
    ("session.predictor = {kind = \"hold\", process = 1}", "session.predictor.process", ""),
    ("session.playout = {kind = \"fixed\", delay = 50}", "session.playout.delay", "Write 0.05"),
    ("session.playout = {kind = \"adaptive\", smallest = 0.6}", "session.playout.largest", ""),
    ("session.playout = {kind = \"adaptive\", slew = 0}", "session.playout.slew", "0.1"),
    ("session.playout = {kind = \"adaptive\", delay = 0.1}", "session.playout.delay", ""),
    ("session.jitter = 0.1", "session.jitter", "[network]"),
    ("coupling.damping = 1\nsession.strategy = \"wave-variables\"", "session.strategy", "coupling.damping"),
    (
        "coupling.damping = 1\ncomparison.architectures = [\"spring\", \"injected-damping\"]",
        "comparison.architectures[1]",
        "coupling.damping",
    ),
    ("comparison.architectures = []", "comparison.architectures", "Leave the key out"),
    ("comparison.architectures = [\"guard\", \"guard\"]", "comparison.architectures[1]", "Remove it."),
    ("comparison.architectures = [\"guards\"]", "comparison.architectures[0]", "\"guard\""),
    ("comparison.networks = [\"Wi-Fi\"]", "comparison.networks[0]", "name ="),
    ("comparison.networks = [{jitter = 0.1}]", "comparison.networks[0].name", "name ="),
    ("comparison.networks = [{name = \"a\"}, {name = \"a\"}]", "comparison.networks[1]", "another name"),
    ("comparison.networks = [{name = \"a\", los = 1}]", "comparison.networks[0].los", "loss"),
    (
        "comparison.networks = [{name = \"a\", delay = {forward = 0}}]",
        "comparison.networks[0].delay",
        "one number",
    ),
];

#[test]
fn ref_what_is_wrong_is_refused_with_its_field() {
    for (text, field, remedy) in REFUSED {
        let refusal = study(text).expect_err(text);
        assert_eq!(refusal.field, field, "{text}: {refusal}");
        assert!(refusal.remedy.contains(remedy) && refusal.remedy.contains("See line"), "{text}: {refusal}");
    }
    // a value of a network is refused as that of a study, at its place in the comparison
    let refusal = study("comparison.networks = [{name = \"a\"}, {name = \"b\", loss = 2}]").unwrap_err();
    assert_eq!(refusal.field, "comparison.networks[1].loss");
    let refusal = study("comparison.networks = [{name = \"a\", jitter = 20}]").unwrap_err();
    assert_eq!(refusal.field, "comparison.networks[0].jitter");
    assert!(refusal.remedy.contains("Write 0.02."), "{refusal}");
    // what only a condition tells: 2000 times the stiffness is no stiffness any more
    let text = "protocol.conditions = [{stiffness = 15000, delay = 0}]\nsession.strategy = {kind = \"two-layer\", saturation = 1000}";
    assert_eq!(study(text).unwrap_err().field, "session.saturation");
}

/// What the remedies say is accepted.
#[test]
fn ref_the_remedies_work() {
    for text in [
        "session.strategy = \"guard\"",
        "session.strategy = {kind = \"guard\", share = 0.8, capacity = 0.05, intake = 0.3}",
        "session.predictor = {kind = \"kalman\", position = 0.00001}",
        "session.predictor = {kind = \"kalman\", model = \"constant-velocity\", process = 1.0}",
        "session.playout = {kind = \"fixed\", delay = 0.05}",
        "session.playout = {kind = \"adaptive\", slew = 0.1}",
        "coupling.damping = 1\nsession.strategy = \"guard\"",
        "comparison.networks = [{name = \"Wi-Fi\", jitter = 0.02, delay = [0.0, 0.05]}]",
        "allow_unusual = true\nsession.strategy = {kind = \"guard\", capacity = 50}",
    ] {
        study(text).expect(text);
    }
    let one_axis =
        "robot1 = {mass = 1, damping = 5}\nrobot2 = {mass = 1, damping = 5}\nsession.strategy = \"guard\"";
    assert_eq!(Study::from_toml(one_axis).unwrap_err().field, "session");
}

/// Any strategy, predictor and play-out as a study writes it.
fn any_session() -> impl Strategy<Value = String> {
    let number = |low: f64, high: f64| (low..high).prop_map(|value| format!("{value:?}"));
    let strategy = prop_oneof![
        prop::sample::select(StrategyDesign::KINDS.to_vec()).prop_map(|kind| format!("{kind:?}")),
        (number(0.0, 0.999), number(0.0, 4.0)).prop_map(|(share, capacity)| {
            format!("{{kind = \"guard\", share = {share}, capacity = {capacity}}}")
        }),
        number(0.5, 900.0).prop_map(|b| format!("{{kind = \"wave-variables\", impedance = {b}}}")),
        number(0.0, 900.0)
            .prop_map(|b| format!("{{kind = \"time-domain-passivity\", largest_damping = {b}}}")),
        number(1.0, 9.0).prop_map(|ratio| format!("{{kind = \"two-layer\", saturation = {ratio}}}")),
        number(0.0, 4.0)
            .prop_map(|energy| format!("{{kind = \"set-position-modulation\", ceiling = {energy}}}")),
    ];
    let predictor = prop_oneof![
        prop::sample::select(PredictorDesign::KINDS.to_vec()).prop_map(|kind| format!("{kind:?}")),
        (number(1e-3, 1e6), number(1e-8, 9e-3)).prop_map(|(process, position)| format!(
            "{{kind = \"kalman\", model = \"constant-velocity\", process = {process}, position = {position}}}"
        )),
    ];
    let playout = prop_oneof![
        Just("\"fixed\"".to_owned()),
        number(0.0, 1.9).prop_map(|delay| format!("{{kind = \"fixed\", delay = {delay}}}")),
        (number(0.0, 0.5), number(0.5, 1.9), number(0.0, 1.0)).prop_map(
            |(smallest, largest, quantile)| format!(
                "{{kind = \"adaptive\", smallest = {smallest}, largest = {largest}, quantile = {quantile}}}"
            )
        ),
    ];
    (strategy, predictor, playout).prop_map(|(strategy, predictor, playout)| {
        format!("{{strategy = {strategy}, predictor = {predictor}, playout = {playout}}}")
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn law_a_study_reads_back_what_it_writes(
        session in any_session(),
        compared in any_session(),
        loss in 0.0..1.0_f64,
        delays in prop::collection::btree_set(0..1000_u32, 1..4),
    ) {
        let delays: Vec<String> = delays.into_iter().map(|ms| format!("{:?}", f64::from(ms) * 1e-3)).collect();
        let text = format!(
            "session = {session}\ncomparison.architectures = [{compared}]\n\
             comparison.networks = [{{name = \"n \\\" ö\", loss = {loss:?}, delay = [{}]}}]",
            delays.join(", ")
        );
        let read = study(&text).unwrap();
        prop_assert_eq!(Study::from_toml(&read.to_toml()).unwrap(), read.clone());
        let table = read.session().to_table();
        prop_assert_eq!(Architecture::from_table(&table).unwrap(), *read.session());
    }
}
