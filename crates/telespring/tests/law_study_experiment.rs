//! Laws of the rehearsal in study files: what is written reads back the same, bit for bit, and no text
//! makes the reader panic.

use std::collections::BTreeMap;

use proptest::collection::{btree_map, vec};
use proptest::prelude::*;
use telespring::rig::Arm;
use telespring::study::{AgentChoice, Replacement, Study, Table, Task, Value};

const SECTIONS: [&str; 7] = ["arm1", "arm2", "agent1", "agent2", "task", "laboratory", "protocol"];

fn number(top: f64) -> BoxedStrategy<String> {
    prop_oneof![
        3 => (0.0..top).prop_map(|value| format!("{value:?}")),
        1 => Just("0".to_owned()),
        1 => Just("-0.0".to_owned()),
    ]
    .boxed()
}

fn positive(low: f64, top: f64) -> BoxedStrategy<String> {
    (low..top).prop_map(|value| format!("{value:?}")).boxed()
}

fn both(one: BoxedStrategy<String>) -> BoxedStrategy<String> {
    prop_oneof![one.clone(), (one.clone(), one).prop_map(|(a, b)| format!("[{a}, {b}]"))].boxed()
}

fn pair(one: BoxedStrategy<String>) -> BoxedStrategy<String> {
    (one.clone(), one).prop_map(|(a, b)| format!("[{a}, {b}]")).boxed()
}

fn words(choices: &'static [&'static str]) -> BoxedStrategy<String> {
    prop::sample::select(choices).prop_map(|word| format!("{word:?}")).boxed()
}

fn flag() -> BoxedStrategy<String> {
    any::<bool>().prop_map(|value| value.to_string()).boxed()
}

/// The lines of a section: those that must stand there, and any of the others.
fn section(
    name: &'static str,
    must: Vec<(&'static str, BoxedStrategy<String>)>,
    may: Vec<(&'static str, BoxedStrategy<String>)>,
) -> BoxedStrategy<String> {
    let line = |(key, value): (&'static str, BoxedStrategy<String>)| {
        value.prop_map(move |value| format!("{key} = {value}\n")).boxed()
    };
    let must: Vec<_> = must.into_iter().map(line).collect();
    let may: Vec<_> = may.into_iter().map(line).map(prop::option::of).collect();
    (must, may)
        .prop_map(move |(must, may)| {
            format!("[{name}]\n{}{}", must.concat(), may.into_iter().flatten().collect::<String>())
        })
        .boxed()
}

fn kind(word: &'static str) -> (&'static str, BoxedStrategy<String>) {
    ("kind", Just(format!("{word:?}")).boxed())
}

fn arm(name: &'static str) -> BoxedStrategy<String> {
    let lumped = vec![("mass", both(number(5.0))), ("damping", both(number(9.0)))];
    prop_oneof![
        Just(String::new()),
        section(name, vec![], vec![kind("massless")]),
        section(name, vec![kind("lumped")], lumped),
        section(
            name,
            vec![
                kind("two-link"),
                // far enough off that every pose of the default task is within reach
                ("base", Just("[0.0, -0.9]".to_owned()).boxed()),
                ("elbow", words(&["left", "right"])),
                ("link_length", both(positive(0.8, 0.9))),
                ("link_mass", both(number(2.0))),
                ("link_centre", both(number(0.3))),
                ("link_inertia", both(number(0.1))),
            ],
            vec![
                ("joint_damping", both(number(1.0))),
                ("rotor_inertia", both(number(0.1))),
                ("torque_limit", pair(prop_oneof![positive(0.1, 50.0), Just("inf".to_owned())].boxed())),
            ],
        ),
    ]
    .boxed()
}

fn options() -> BoxedStrategy<String> {
    let leaf = prop_oneof![
        any::<bool>().prop_map(|value| value.to_string()),
        any::<i64>().prop_map(|value| value.to_string()),
        any::<f64>().prop_filter("finite", |value| value.is_finite()).prop_map(|value| format!("{value:?}")),
        "\\PC{0,9}".prop_map(|text| toml::Value::String(text).to_string()),
        "([^\0\n]|\n|\"|'){0,9}".prop_map(|text| toml::Value::String(text).to_string()),
    ];
    let value = leaf.prop_recursive(2, 8, 4, |inner| {
        vec(inner, 0..4).prop_map(|items| format!("[{}]", items.join(", ")))
    });
    btree_map("[a-zé_][a-z0-9_ß]{0,5}", value, 0..4)
        .prop_map(|options| {
            let each: Vec<_> = options.iter().map(|(name, value)| format!("\"{name}\" = {value}")).collect();
            format!("{{{}}}", each.join(", "))
        })
        .boxed()
}

fn agent(name: &'static str) -> BoxedStrategy<String> {
    prop_oneof![
        Just(String::new()),
        section(name, vec![kind("skilled")], vec![("stiffness", number(500.0)), ("damping", number(20.0))]),
        section(
            name,
            vec![kind("blurred")],
            vec![
                ("stiffness", number(500.0)),
                ("spots", (1..1000_u32).prop_map(|count| count.to_string()).boxed()),
                ("spot_velocity", number(3.0)),
                ("spot_lifetime", positive(0.01, 9.0)),
            ],
        ),
        section(
            name,
            vec![kind("python"), ("class", words(&["a:B", "agents.of_ours:Patient.Weak"]))],
            vec![("options", options())],
        ),
    ]
    .boxed()
}

fn task() -> BoxedStrategy<String> {
    prop_oneof![
        Just(String::new()),
        section(
            "task",
            vec![],
            vec![
                kind("figure-eight"),
                ("amplitude", pair(number(0.2))),
                ("angular_frequency", positive(0.5, 9.0)),
            ],
        ),
        section(
            "task",
            vec![kind("python"), ("function", Just("\"targets:circle\"".to_owned()).boxed())],
            vec![("options", options())],
        ),
    ]
    .boxed()
}

fn laboratory() -> BoxedStrategy<String> {
    let parts = vec![
        ("sample_period", words(&["0.001", "0.002", "5e-4"]).prop_map(|text| text.replace('"', "")).boxed()),
        ("computing_tick", flag()),
        ("actuator_lag", number(0.01)),
        ("encoder_resolution", number(1e-4)),
    ];
    prop_oneof![Just(String::new()), section("laboratory", vec![], parts)].boxed()
}

/// What the network does to the packets: a value for both ways or for one.
fn network() -> BoxedStrategy<String> {
    let ways = |value: BoxedStrategy<String>| {
        prop_oneof![
            value.clone(),
            value.clone().prop_map(|value| format!("{{forward = {value}}}")),
            (value.clone(), value)
                .prop_map(|(one, other)| format!("{{forward = {one}, backward = {other}}}")),
        ]
        .boxed()
    };
    let burst = (number(1.0), number(1.0), number(1.0));
    let burst = burst
        .prop_map(|(bad, good, lost)| format!("{{to_bad = {bad}, to_good = {good}, loss_good = {lost}}}"));
    let rate = (1..1_000_000_000_u32, 0..100_u32);
    let rate = rate.prop_map(|(rate, queue)| format!("{{bits_per_second = {rate}, queue = {queue}}}"));
    let blackout = prop_oneof![Just("{start = 3, duration = 0.5}"), Just("{duration = 1.5, period = 7.25}")];
    let parts = vec![
        ("jitter", ways(number(0.05))),
        ("loss", ways(number(1.0))),
        ("duplicate", ways(number(1.0))),
        ("order", ways(words(&["any", "fifo"]))),
        ("burst", ways(burst.boxed())),
        ("rate", ways(prop_oneof![rate, Just("2e6".to_owned())].boxed())),
        ("blackout", ways(blackout.prop_map(str::to_owned).boxed())),
    ];
    let sure = vec![("delay", Just("0.05".to_owned()).boxed())];
    let drawn = "jitter = 0.05\ndistribution = {kind = \"gamma\", mean = 0.01, sd = 0.02}\n";
    let fixed = format!("[network]\ndelay = 0.05\n{drawn}");
    prop_oneof![4 => section("network", sure, parts), 1 => Just(fixed)].boxed()
}

fn protocol() -> BoxedStrategy<String> {
    let rest = || {
        vec![
            ("trials", (1..50_u32).prop_map(|count| count.to_string()).boxed()),
            ("duration", positive(30.0, 60.0)),
            ("discard", number(8.0)),
            ("record_rate", words(&["100.0", "50", "10"]).prop_map(|text| text.replace('"', "")).boxed()),
            ("seed", (0..i64::MAX).prop_map(|seed| seed.to_string()).boxed()),
            ("order", words(&["blocks", "shuffled"])),
        ]
    };
    let list = |top: f64| {
        vec(1e-3..top, 1..5).prop_map(|mut values| {
            values.sort_by(f64::total_cmp);
            values.dedup();
            format!("{values:?}")
        })
    };
    let listed = vec((1e-3..500.0_f64, 0.0..1.0_f64), 0..5).prop_map(|mut conditions| {
        conditions.sort_by(|a, b| a.0.total_cmp(&b.0));
        conditions.dedup();
        let each: Vec<_> = conditions
            .iter()
            .map(|(stiffness, delay)| format!("{{stiffness = {stiffness:?}, delay = {delay:?}}}"))
            .collect();
        format!("[{}]", each.join(", "))
    });
    let mut combined = rest();
    combined.extend([
        ("unconnected", flag()),
        ("stiffness", list(500.0).boxed()),
        ("delay", list(1.0).boxed()),
    ]);
    prop_oneof![
        Just(String::new()),
        section("protocol", vec![], combined),
        section("protocol", vec![("conditions", listed.boxed())], rest()),
    ]
    .boxed()
}

fn robot(name: &'static str) -> BoxedStrategy<String> {
    let uncertain = vec![
        ("coulomb", both(number(2.0))),
        ("mass_sd", both(number(0.1))),
        ("damping_sd", both(number(0.5))),
    ];
    let sure = vec![("mass", pair(positive(0.5, 3.0))), ("damping", pair(positive(2.0, 20.0)))];
    let correlated = section(
        name,
        vec![
            ("mass", pair(positive(0.5, 3.0))),
            ("damping", both(positive(2.0, 20.0))),
            ("mass_sd", both(positive(1e-3, 0.1))),
            ("damping_sd", both(positive(1e-3, 0.1))),
            ("mass_damping_correlation", both(positive(-1.0, 1.0))),
        ],
        vec![],
    );
    prop_oneof![section(name, sure, uncertain), correlated].boxed()
}

fn study() -> impl Strategy<Value = String> {
    let robots = (robot("robot1"), robot("robot2"));
    let sides = (arm("arm1"), arm("arm2"), agent("agent1"), agent("agent2"));
    (robots, sides, task(), (network(), laboratory()), protocol()).prop_map(
        |((robot1, robot2), (arm1, arm2, agent1, agent2), task, (network, laboratory), protocol)| {
            format!(
                "allow_unusual = true\n{robot1}{robot2}[coupling]\nstiffness = 20\n{network}\
                 {arm1}{arm2}{agent1}{agent2}{task}{laboratory}{protocol}"
            )
        },
    )
}

/// A study that the reader must take, save for a target beyond the reach of an arm.
fn read(text: &str) -> Result<Option<Study>, TestCaseError> {
    match Study::from_toml(text) {
        Ok(study) => Ok(Some(study)),
        Err(refused) if refused.to_string().contains("reach") => Ok(None),
        Err(refused) => Err(TestCaseError::fail(format!("{refused}\n{text}"))),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..Default::default() })]

    #[test]
    fn law_a_rehearsal_reads_back_the_same(text in study()) {
        let Some(first) = read(&text)? else { return Ok(()) };
        let written = first.to_toml();
        let second = Study::from_toml(&written)
            .map_err(|refused| TestCaseError::fail(format!("{refused}\n{written}")))?;
        prop_assert_eq!(&first, &second);
        prop_assert_eq!(first.laboratory(), second.laboratory());
        prop_assert_eq!(first.protocol(), second.protocol());
        prop_assert_eq!(written, second.to_toml());
    }

    #[test]
    fn law_a_section_of_defaults_is_not_written(text in study()) {
        let Some(study) = read(&text)? else { return Ok(()) };
        let written = study.to_toml();
        let paper = Study::paper();
        for name in SECTIONS {
            let same = match name {
                "arm1" => study.setup().arms[0] == paper.setup().arms[0],
                "arm2" => study.setup().arms[1] == paper.setup().arms[1],
                "agent1" => study.setup().agents[0] == paper.setup().agents[0],
                "agent2" => study.setup().agents[1] == paper.setup().agents[1],
                "task" => study.setup().task == paper.setup().task,
                _ => continue,
            };
            prop_assert_eq!(written.contains(&format!("\n[{name}]\n")), !same, "{}", name);
        }
    }

    #[test]
    fn law_replacing_nothing_or_a_section_by_itself_changes_nothing(text in study()) {
        let Some(study) = read(&text)? else { return Ok(()) };
        prop_assert_eq!(study.replace(&BTreeMap::new()), Ok(study.clone()));
        let tables: Table = study.to_toml().parse().expect("a study writes TOML");
        for (name, section) in &tables {
            let replacement = match section {
                Value::Table(keys) => Replacement::Keys(
                    keys.iter().map(|(key, value)| (key.clone(), Some(value.clone()))).collect(),
                ),
                value => Replacement::Value(value.clone()),
            };
            let replaced = study.replace(&[(name.clone(), replacement)].into());
            prop_assert_eq!(replaced, Ok(study.clone()), "{}", name);
        }
    }

    #[test]
    fn law_a_section_alone_reads_as_in_its_study(text in study()) {
        let Some(study) = read(&text)? else { return Ok(()) };
        let tables: Table = study.to_toml().parse().expect("a study writes TOML");
        let section = |name: &str| tables.get(name).and_then(Value::as_table);
        if let Some(arm) = section("arm2") {
            prop_assert_eq!(Arm::from_table(arm), Ok(study.setup().arms[1]));
        }
        if let Some(agent) = section("agent2") {
            prop_assert_eq!(AgentChoice::from_table(agent), Ok(study.setup().agents[1].clone()));
        }
        if let Some(task) = section("task") {
            prop_assert_eq!(Task::from_table(task), Ok(study.setup().task.clone()));
        }
    }

    #[test]
    fn law_no_mutation_makes_the_reader_panic(
        text in study(), at in any::<prop::sample::Index>(), length in 0..20_usize,
        patch in "[-\\[\\]{}=.,\"#0-9a-z\n_ éµ]{0,8}",
    ) {
        let letters: Vec<char> = text.chars().collect();
        let start = at.index(letters.len());
        let end = (start + length).min(letters.len());
        let mutated: String =
            letters[..start].iter().copied().chain(patch.chars()).chain(letters[end..].iter().copied()).collect();
        match Study::from_toml(&mutated) {
            Ok(study) => {
                let _ = (study.laboratory(), study.protocol());
                prop_assert_eq!(Study::from_toml(&study.to_toml()), Ok(study));
            }
            Err(refused) => {
                prop_assert!(!refused.field.is_empty() && !refused.allowed.is_empty());
                prop_assert!(refused.remedy.ends_with('.'), "{}", refused);
            }
        }
    }
}
