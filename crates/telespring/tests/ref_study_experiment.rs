//! The experiment of a study file: the paper's own, every key as it arrives, and every message.

use telespring::rig::{Agent, Arm, Elbow, Laboratory, NetworkModel, Target};
use telespring::study::{AgentChoice, Conditions, OptionValue, Study, Task, keys};

const ROBOTS: &str = "\
robot1 = {mass = [1.0, 2.0], damping = 5}
robot2 = {mass = 1, damping = [5.0, 6.0]}
coupling.stiffness = 20
network.delay = 0.05
";

fn with(text: &str) -> String {
    format!("{ROBOTS}{text}")
}

fn study(text: &str) -> Study {
    Study::from_toml(&with(text)).unwrap_or_else(|refused| panic!("{text}: {refused}"))
}

fn refusal(text: &str) -> String {
    Study::from_toml(&with(text)).expect_err(text).to_string()
}

#[test]
fn ref_the_paper_experiment() {
    // Du, Kulkarni, Kager and Campolo, section IV-C: Unconnected Mode and 4 × 4 conditions, 20 trials each.
    let protocol = Study::paper().protocol().unwrap();
    assert_eq!(protocol.conditions.len(), 17);
    assert_eq!(protocol.conditions[0], (None, 0.0));
    assert_eq!(protocol.trials, 20);
    // Table III, unrounded: K of Eq. 5 on x in closed form, Δ as four digits of DESIGN's 167.19 ms.
    let k = (7.7257_f64.powi(2) + 7.4208_f64.powi(2)) / (2.0 * (0.8334 + 0.7776));
    for (i, &(stiffness, delay)) in protocol.conditions[1..].iter().enumerate() {
        let (k_factor, delay_factor) = ([0.5, 1.0, 2.0, 4.0][i / 4], [0.0, 0.5, 1.0, 2.0][i % 4]);
        assert!((stiffness.unwrap() / (k_factor * k) - 1.0).abs() < 1e-12, "{stiffness:?}");
        assert!((delay - delay_factor * 0.167_186_32).abs() < 1e-8, "{delay}");
    }
    assert_eq!((protocol.duration, protocol.discard, protocol.record_rate), (29.111, 4.852, 100.0));
    assert_eq!((protocol.seed, protocol.shuffled), (1, false));
    assert_eq!(Study::paper().laboratory(), Ok(Laboratory::paper()));
}

#[test]
fn ref_the_example_with_two_link_arms() {
    let study = Study::from_toml(include_str!("../../../examples/two-link.toml")).unwrap();
    let laboratory = study.laboratory().unwrap();
    let [Arm::TwoLink(first), Arm::TwoLink(second)] = laboratory.stations.map(|side| side.arm) else {
        panic!("{laboratory:?}")
    };
    assert_eq!((first.elbow, second.elbow), (Elbow::Right, Elbow::Left));
    assert_eq!((first.base, first.link_length, first.link_mass), ([0.0, -0.45], [0.3, 0.3], [0.9, 0.7]));
    assert_eq!((first.link_centre, first.link_inertia), ([0.15, 0.15], [0.007, 0.0055]));
    assert_eq!((second.joint_damping, second.rotor_inertia), ([0.05, 0.05], [0.02, 0.01]));
    assert_eq!((first.torque_limit, second.torque_limit), ([20.0; 2], [f64::INFINITY; 2]));
    assert_eq!(laboratory.stations[1].handle.coulomb, [0.5, 0.5]);
    assert_eq!(laboratory.stations[0].agent, Agent::Skilled { stiffness: 150.0, damping: 5.0 });
    let Agent::Blurred { stiffness: 100.0, spots } = laboratory.stations[1].agent else { panic!() };
    assert_eq!((spots.count, spots.velocity, spots.lifetime), (5, 0.2, 0.25));
    let figure = Target::FigureEight { amplitude: [0.08, 0.12], angular_frequency: 1.6 };
    assert_eq!(laboratory.target, figure);
    let controller = laboratory.controller;
    assert!(controller.computing_tick);
    assert_eq!(
        (controller.sample_period, controller.actuator_lag, controller.encoder_resolution),
        (0.001, 0.002, 1e-5)
    );
    let NetworkModel { jitter, loss, .. } = laboratory.network.forward;
    assert_eq!((jitter, loss), (0.005, 0.02));
    assert_eq!(laboratory.network.backward, laboratory.network.forward);
    let protocol = study.protocol().unwrap();
    assert_eq!(protocol.conditions[2], (Some(40.0), 0.04));
    assert_eq!((protocol.conditions.len(), protocol.trials, protocol.seed), (5, 6, 7));
    assert_eq!((protocol.duration, protocol.discard, protocol.record_rate), (23.562, 7.854, 50.0));
    assert!(protocol.shuffled);
    let [uncertain, certain] = study.uncertainty();
    assert_eq!(uncertain.unwrap().mass_sd, [0.006, 0.008]);
    assert_eq!(uncertain.unwrap().damping_sd, [0.08, 0.1]);
    assert_eq!(uncertain.unwrap().correlation, [-0.1, -0.1]);
    assert_eq!(certain, None);
}

#[test]
fn ref_python_agents_and_targets_keep_their_text() {
    let study = study(
        "[agent2]\nkind = \"python\"\nclass = \"patients.stroke:Tremor\"\n\
         options = {gain = 2.5, order = 3, side = \"left\", on = true, poles = [1.0, [2, \"a\"]], \"größe\" = 1}\n\
         [task]\nkind = \"python\"\nfunction = \"targets:circle\"",
    );
    let AgentChoice::Python(agent) = &study.setup().agents[1] else { panic!() };
    assert_eq!(agent.path, "patients.stroke:Tremor");
    assert_eq!(agent.options["gain"], OptionValue::Number(2.5));
    assert_eq!(agent.options["order"], OptionValue::Whole(3));
    assert_eq!(agent.options["side"], OptionValue::Text("left".to_owned()));
    assert_eq!(agent.options["on"], OptionValue::Boolean(true));
    let inner = OptionValue::List(vec![OptionValue::Whole(2), OptionValue::Text("a".to_owned())]);
    assert_eq!(agent.options["poles"], OptionValue::List(vec![OptionValue::Number(1.0), inner]));
    let Task::Python(task) = &study.setup().task else { panic!() };
    assert_eq!((task.path.as_str(), task.options.len()), ("targets:circle", 0));
    let laboratory = study.laboratory().unwrap();
    assert_eq!(laboratory.stations[1].agent, Agent::External);
    assert_eq!(laboratory.target, Target::Sampled(Vec::new()));
    // without a period known: 30 s, of which the first 5 are left out
    let protocol = study.protocol().unwrap();
    assert_eq!((protocol.duration, protocol.discard), (30.0, 5.0));
    assert_eq!(Study::from_toml(&study.to_toml()), Ok(study));
}

#[test]
fn ref_defaults_follow_from_the_study() {
    // [controller] gives the laboratory its period, and 333 Hz are kept whole, halved, … to about 100
    let slow = study("controller.sample_period = 0.003\n[task]\nangular_frequency = 2.0");
    assert_eq!(slow.sample_period(), Ok(0.003));
    let protocol = slow.protocol().unwrap();
    assert!((protocol.record_rate - 1000.0 / 12.0).abs() < 1e-9, "{}", protocol.record_rate);
    // twelve periods and two in whole ticks
    assert!((protocol.duration / 0.003 - (12.0 * std::f64::consts::PI / 0.003).round()).abs() < 1e-6);
    assert!((protocol.discard / 0.003 - (2.0 * std::f64::consts::PI / 0.003).round()).abs() < 1e-6);
    // the one list that is named, with the multiples of the other
    let named = study("protocol.stiffness = [10.0, 30]");
    let stiffnesses: Vec<_> = named.protocol().unwrap().conditions.iter().map(|each| each.0).collect();
    assert_eq!(stiffnesses[1..5], [Some(10.0); 4]);
    assert_eq!(stiffnesses.len(), 9);
    let alone = study("[protocol]\nconditions = []");
    assert_eq!(alone.protocol().unwrap().conditions, [(None, 0.0)]);
    let coupled = study("[protocol]\nunconnected = false\nconditions = [{stiffness = 20, delay = 0.1}]");
    assert_eq!(coupled.protocol().unwrap().conditions, [(Some(20.0), 0.1)]);
    // operators hold the handles in the verdicts only: the multiples are those of free robots
    let held = study("[operator1]\nstiffness = 500\nmass = 3");
    assert_eq!(held.protocol(), study("").protocol());
    // a kind that is not named is the side's own
    let Conditions::Combinations { stiffness: None, delay: None } =
        telespring::study::ProtocolChoice::paper().conditions
    else {
        panic!()
    };
    let fewer = study("[agent2]\nspots = 3");
    assert!(matches!(fewer.setup().agents[1], AgentChoice::Blurred { spots, .. } if spots.count == 3));
}

#[test]
fn ref_a_study_with_one_axis_has_no_experiment() {
    let text = "[robot1]\nmass=1\ndamping=5\n[robot2]\nmass=2\ndamping=5\n[coupling]\nstiffness=9\n[network]\ndelay=0";
    let study = Study::from_toml(text).unwrap();
    assert!(!study.is_planar());
    assert_eq!(study.laboratory().unwrap_err().field, "robot1.axes");
    assert_eq!(study.protocol().unwrap_err().field, "robot1.axes");
    let refused = Study::from_toml(&format!("{text}\n[task]\nangular_frequency = 2")).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "task = a section: a rehearsal, or a live session, needs robots with exactly the two axes \"x\" and \"y\", but \
         these have [\"x\"]. Give both robots these axes, or remove the section for a study that is neither rehearsed \
         nor run live. docs/your-robot.md says how a robot with one axis takes part. See line 11."
    );
}

#[test]
fn ref_robots_without_damping_have_no_multiples() {
    let text =
        with("").replace("damping = 5}", "damping = 0}").replace("damping = [5.0, 6.0]", "damping = [0, 0]");
    let study = Study::from_toml(&text).unwrap();
    let refused = study.protocol().unwrap_err();
    assert_eq!(refused.field, "protocol.stiffness");
    assert!(refused.remedy.contains("protocol.delay"), "{refused}");
    let named = format!("{text}[protocol]\nstiffness = [5]\ndelay = [0]");
    assert_eq!(Study::from_toml(&named).unwrap().protocol().unwrap().conditions.len(), 2);
}

#[test]
fn ref_messages_verbatim() {
    let cases: &[(&str, &str)] = &[
        (
            "[agent1]\nspots = 5",
            "agent1.spots = 5: [agent1] of kind \"skilled\" has the keys kind, stiffness, damping. It \
             belongs to kind = \"blurred\": set that kind, or remove the key. See line 6.",
        ),
        (
            "[arm1]\nkind = \"two-links\"",
            "arm1.kind = \"two-links\": it must be one of \"massless\", \"lumped\", \"two-link\". Did you \
             mean \"two-link\"? See line 6.",
        ),
        (
            "[arm1]\nkind = \"lumped\"\nmas = 1",
            "arm1.mas = 1: [arm1] of kind \"lumped\" has the keys kind, mass, damping. Did you mean \"mass\"? \
             See line 7.",
        ),
        (
            "[arm2]\nkind = \"lumped\"\nmass = [1.0, 2.0, 3.0]",
            "arm2.mass = [1.0, 2.0, 3.0]: one number or a list of two is required. Write, for example, \
             [1.0, 2.0]. See line 7.",
        ),
        (
            "[arm1]\nkind = \"two-link\"\nelbow = \"left\"\nbase = [0, -450]",
            "arm1.base[1] = -450: a position must be a number from -10 to 10 m. Everything is in SI units: if \
             -450 was meant in mm, write -0.45. See line 8.",
        ),
        (
            "[agent2]\nkind = \"python\"\nclass = \"patients.py\"",
            "agent2.class = \"patients.py\": a module and a name in it are required, separated by a colon. \
             Write, for example, \"agents:Patient\". See line 7.",
        ),
        (
            "[agent2]\nkind = \"python\"\nclass = \"a:B\"\noptions = {gain = nan}",
            "agent2.options.gain = nan: an option is a finite number, a string, true, false or a list of these. \
             Replace it by a finite number. See line 8.",
        ),
        (
            "[agent2]\nkind = \"python\"\nclass = \"a:B\"\noptions = {\"2nd\" = 1}",
            "agent2.options.2nd = 1: the name of an option consists of letters, digits and _, and does \
             not begin with a digit. Use the name of a Python argument. See line 8.",
        ),
        (
            "[task]\namplitude = [50, 100]",
            "task.amplitude[0] = 50: an amplitude must be a number from 0 to 10 m. Everything is in SI units: if \
             50 was meant in mm, write 0.05. See line 6.",
        ),
        (
            "laboratory.sample_period = 0.01\n[agent2]\nspot_lifetime = 0.002",
            "agent2.spot_lifetime = 0.002: a spot must live for at least one sample period, here 0.01 s. \
             Give a lifetime in s, such as 0.2. See line 7.",
        ),
        (
            "[laboratory]\nloss = 2",
            "laboratory.loss = 2: a probability must be a number from 0 to 1. Everything is in SI units: if 2 was \
             meant in %, write 0.02. See line 6.",
        ),
        (
            "[laboratory]\ncomputing_tick = 1",
            "laboratory.computing_tick = 1: true or false is required. Write it without quotes. See line 6.",
        ),
        (
            "controller.sample_period = 0.001\n[laboratory]\nsample_period = 0.002",
            "laboratory.sample_period = 0.002: [controller] gives 0.001 s for the same controllers. Give \
             it once, or the same value twice. See line 7.",
        ),
        (
            "[protocol]\nstiffness = [71, 71.0]",
            "protocol.stiffness[1] = 71.0: every value must be distinct. Remove it. See line 6.",
        ),
        (
            "[protocol]\nstiffness = []",
            "protocol.stiffness = []: a list of at least one number is required. Write conditions = [] to \
             run the unconnected condition only. See line 6.",
        ),
        (
            "[protocol]\nconditions = [{stiffness = 71}]",
            "Missing protocol.conditions[0].delay. Add delay = …. See line 6.",
        ),
        (
            "[protocol]\nconditions = []\ndelay = [0.1]",
            "protocol.conditions = []: a protocol has either a list of conditions or lists of stiffness \
             and delay. Remove one of them. See line 6.",
        ),
        (
            "[protocol]\nconditions = []\nunconnected = false",
            "protocol.conditions = 0 conditions: a protocol has 1 to 1000 conditions, the unconnected one \
             included. Give a condition, or write unconnected = true. See line 6.",
        ),
        (
            "[protocol]\ntrials = 20.5",
            "protocol.trials = 20.5: the number of trials must be a whole number from 1 to 10000. Write \
             it without a decimal point, quotes or a unit. See line 6.",
        ),
        (
            "[protocol]\ntrials = 20000",
            "protocol.trials = 20000: the number of trials must be a whole number from 1 to 10000. Choose a number \
             in that range. See line 6.",
        ),
        (
            "[protocol]\nduration = 4",
            "protocol.discard = 4.852 (by default): the discarded part must be shorter than the trial \
             of 4.0 s. Give a longer duration, or a shorter part to discard. See line 5.",
        ),
        (
            "[protocol]\nduration = 29111",
            "protocol.duration = 29111: a trial's duration must be a number from 0.001 to 3600 s. Everything is in \
             SI units: if 29111 was meant in ms, write 29.111. See line 6.",
        ),
        (
            "[protocol]\nrecord_rate = 300",
            "protocol.record_rate = 300: the record rate must divide the controllers' rate, 1000 Hz. \
             Write 333.3333333333333, or another integer fraction of it. See line 6.",
        ),
        (
            "[protocol]\nrecord_rate = 1000\ntrials = 500",
            "protocol.trials = 500: all trials together record at most 50000000 samples, but 17 \
             conditions of 29.111 s at 1000.0 Hz give 247452000. Run fewer or shorter trials, or record \
             fewer samples per second. See line 7.",
        ),
        (
            "[protocol]\norder = \"random\"",
            "protocol.order = \"random\": it must be one of \"blocks\", \"shuffled\". Choose one of them. \
             See line 6.",
        ),
        (
            "[network2]\nloss = 0.1",
            "network2 = a section: a study has a name and the sections [robot1], [robot2], [operator1], \
             [operator2], [coupling], [network], [controller], [arm1], [arm2], [agent1], [agent2], [task], \
             [laboratory], [protocol], [session], [comparison]. Did you mean \"network\"? See line 5.",
        ),
    ];
    for (text, message) in cases {
        assert_eq!(refusal(text), *message);
    }
}

#[test]
fn ref_uncertainty_is_whole_or_refused() {
    let robot = |more: &str| with("").replace("damping = 5}", &format!("damping = 5, {more}}}"));
    let certain = Study::from_toml(&robot("mass_sd = 0, damping_sd = [0, 0]")).unwrap();
    assert_eq!(certain.uncertainty(), [None, None]);
    let alone = Study::from_toml(&robot("mass_sd = 0.1, mass_damping_correlation = 0.5")).unwrap_err();
    assert_eq!(
        alone.to_string(),
        "robot1.mass_damping_correlation = 0.5: a correlation needs mass_sd and damping_sd above 0 on the same \
         axis. Add both standard deviations, or remove the correlation. See line 1."
    );
    let outside = Study::from_toml(&robot("mass_sd = 1, damping_sd = 1, mass_damping_correlation = 1.5"));
    assert!(outside.unwrap_err().to_string().contains("a correlation must be a number from -1 to 1. Check"));
    let three = Study::from_toml(&robot("coulomb = [1, 2, 3]")).unwrap_err();
    assert!(three.to_string().contains("one value per axis is required: 2, not 3"), "{three}");
}

#[test]
fn ref_the_document_lists_every_key() {
    let document = include_str!("../../../docs/study-file.md");
    for key in keys() {
        // robots, operators, arms and agents share their lists
        let dotted = key.replace(['1', '2'], "N");
        assert!(document.contains(&format!("| `{dotted}` |")), "{dotted} is not in docs/study-file.md");
    }
    let documented = document.lines().filter(|line| line.starts_with("| `")).count();
    let mut distinct: Vec<_> = keys().iter().map(|key| key.replace(['1', '2'], "N")).collect();
    distinct.sort();
    distinct.dedup();
    assert_eq!(documented, distinct.len(), "a key that is documented is read");
}

#[test]
fn ref_the_ranges_of_an_arm_are_the_same_at_every_door() {
    let arm = |key: &str, value: &str| {
        let mut values = [
            ("base", "[0.0, -0.5]"),
            ("elbow", "\"left\""),
            ("link_length", "[0.3, 0.3]"),
            ("link_mass", "1"),
            ("link_centre", "0.1"),
            ("link_inertia", "0.01"),
        ]
        .to_vec();
        values.retain(|(name, _)| *name != key);
        values.push((key, value));
        let lines: String = values.iter().map(|(name, value)| format!("{name} = {value}\n")).collect();
        format!("allow_unusual = true\n{}", with(&format!("[arm1]\nkind = \"two-link\"\n{lines}")))
    };
    for (key, least, below, most, above) in [
        ("link_length", "0.01", "0.009", "10", "10.1"),
        ("link_mass", "0", "-1", "1000", "1001"),
        ("link_inertia", "0", "-1", "1000", "1001"),
        ("rotor_inertia", "0", "-1", "1000", "1001"),
        ("joint_damping", "0", "-1", "10000", "10001"),
        ("torque_limit", "1e-6", "0", "inf", "nan"),
    ] {
        for inside in [least, most] {
            if let Ok(study) = Study::from_toml(&arm(key, inside)) {
                let Arm::TwoLink(arm) = study.setup().arms[0] else { panic!() };
                assert_eq!(arm.checked(), Ok(arm), "{key} = {inside}");
            } else {
                panic!("{key} = {inside}: {}", Study::from_toml(&arm(key, inside)).unwrap_err());
            }
        }
        for outside in [below, above] {
            let refused = Study::from_toml(&arm(key, outside)).unwrap_err();
            // by the reader itself, not by a second opinion
            assert_eq!(refused.field, format!("arm1.{key}"), "{outside}");
        }
    }
}

#[test]
fn ref_no_text_holds_the_character_zero() {
    for text in [
        "name = \"a\\u0000b\"\n",
        "robot1.name = \"\\u0000\"\n",
        "[agent1]\nkind = \"python\"\nclass = \"a:B\"\noptions = {c = [\"\\u0000\"]}\n",
    ] {
        let study = if text.starts_with("name") { format!("{text}{ROBOTS}") } else { with(text) };
        let study = study.replace("robot1 = {", "robot1 = {name = \"\\u0000\", ");
        let study = if text.starts_with("robot1") {
            study.replace(text, "")
        } else {
            study.replace("name = \"\\u0000\", ", "")
        };
        let refused = Study::from_toml(&study).expect_err(text).to_string();
        assert!(refused.contains("U+0000"), "{refused}");
    }
}

#[test]
fn ref_a_protocol_keeps_something_to_judge() {
    let fast = format!("allow_unusual = true\n{}", with("[task]\nangular_frequency = 1e4"));
    let refused = Study::from_toml(&fast).unwrap_err().to_string();
    assert!(refused.starts_with("protocol.duration") && refused.contains("record_rate"), "{refused}");
    for text in
        ["[protocol]\nduration = 0.009\ndiscard = 0.001", "[protocol]\nduration = 5.0\ndiscard = 4.995"]
    {
        let refused = refusal(text);
        assert!(refused.starts_with("protocol.duration") && refused.contains("record_rate"), "{refused}");
    }
    assert_eq!(study("[protocol]\nduration = 5.0\ndiscard = 4.99").protocol().unwrap().discard, 4.99);
    assert!(study("[protocol]\nduration = 0.01\ndiscard = 0.0").protocol().is_ok());
}

#[test]
fn ref_a_seed_too_large_is_reported_as_out_of_range() {
    let refused = refusal("[protocol]\nseed = 9223372036854775808");
    assert!(refused.contains("Choose a number in that range."), "{refused}");
    assert!(refusal("[protocol]\nseed = 1.0").contains("without a decimal point"));
}
