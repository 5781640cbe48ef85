//! Study files: the paper's own, the schema, and every message as a person will read it.

use telespring::study::{Replacement, RobotFile, Study, Value};

const GOOD: &str = "\
name = \"test\"
[robot1]
mass = [1.0, 2.0]
damping = 5
[robot2]
mass = 1
damping = [5.0, 6.0]
[coupling]
stiffness = 20
[network]
delay = 0.05
[controller]
sample_period = 0.001
";

/// The good study with one text put in place of another.
fn with(from: &str, to: &str) -> String {
    assert!(GOOD.contains(from), "{from}");
    GOOD.replacen(from, to, 1)
}

fn refusal(text: &str) -> String {
    Study::from_toml(text).expect_err(text).to_string()
}

#[test]
fn ref_the_example_file_is_the_paper() {
    let text = include_str!("../../../examples/hman.toml");
    let study = Study::from_toml(text).unwrap();
    assert_eq!(study, Study::paper());
    assert_eq!(study.dyad(), &telespring::hman());
    assert_eq!(study.robot_names(), [Some("H-MAN 1"), Some("H-MAN 2")]);
    // Table III: K = 36 N/m, printed 71 N/m for twice its unrounded value, 167 ms.
    assert!((study.coupling().unwrap().stiffness - 2.0 * 35.615988).abs() < 1e-6);
    assert_eq!(study.network().unwrap().delay().mean(), 0.167);
}

#[test]
fn ref_every_form_of_a_value_is_read() {
    let study = Study::from_toml(&with(
        "[network]\ndelay = 0.05",
        "damping = 1.5\n[operator1]\nmass = 1\nstiffness = {min = 0, max = 300}\n\
         [operator2]\ndamping = [2, {min = 1, max = 3}]\n\
         [network]\ndelay = {forward = 0.04, backward = 6e-2}\njitter = 0.01\nmax_gap = 0.02",
    ))
    .unwrap();
    assert_eq!(study.dyad().robots()[0].damping(), [5.0, 5.0]);
    assert_eq!(study.dyad().robots()[1].mass(), [1.0, 1.0]);
    assert_eq!(study.dyad().axis_names(), ["x", "y"]);
    assert_eq!(study.coupling().unwrap().damping, 1.5);
    let [first, second] = study.operator_ranges().unwrap();
    assert_eq!((first.low().stiffness()[1], first.high().stiffness()[1]), (0.0, 300.0));
    assert_eq!((first.low().mass()[0], first.high().mass()[0]), (1.0, 1.0));
    assert_eq!((second.low().damping(), second.high().damping()), (&[2.0, 1.0][..], &[2.0, 3.0][..]));
    assert_eq!(study.dyad().operators()[0].stiffness(), [150.0, 150.0]);
    let network = study.network().unwrap();
    assert_eq!((network.delay().forward(), network.delay().backward()), (0.04, 0.06));
    assert_eq!((network.jitter(), network.max_gap(), network.sample_period()), (0.01, 0.02, 0.001));
}

#[test]
fn ref_one_axis_from_plain_numbers() {
    let study = Study::from_toml(
        "[robot1]\nmass=1\ndamping=5\n[robot2]\nmass=2\ndamping=5\n[coupling]\nstiffness=9\n[network]\ndelay=0",
    )
    .unwrap();
    assert_eq!(study.dyad().axis_names(), ["x"]);
    assert_eq!(study.name(), "unnamed study");
    assert!(study.operator_ranges().is_none());
}

#[test]
fn ref_axes_of_one_robot_hold_for_a_partner_of_single_numbers() {
    let lists = "axes = [\"a\", \"b\"]\nmass = [1.0, 2.0]\ndamping = 5";
    let text = with("mass = [1.0, 2.0]\ndamping = 5", lists);
    let text = text.replacen("mass = 1\ndamping = [5.0, 6.0]", "mass = 2\ndamping = 11", 1);
    let study = Study::from_toml(&text).unwrap();
    assert_eq!(study.dyad().axis_names(), ["a", "b"]);
    assert_eq!(study.dyad().robots()[1].mass(), [2.0, 2.0]);
}

#[test]
fn ref_messages_verbatim() {
    let cases: &[(String, &str)] = &[
        (
            with("delay = 0.05", "delay = 167"),
            "network.delay = 167: a delay must be a number from 0 to 100 s. Everything is in SI units: \
             if 167 was meant in ms, write 0.167. See line 11.",
        ),
        (
            with("delay = 0.05", "delay = nan"),
            "network.delay = NaN: a delay must be a number from 0 to 100 s. Replace the missing value by \
             a number. See line 11.",
        ),
        (
            with("stiffness = 20", "stiffness = -20"),
            "coupling.stiffness = -20: a coupling stiffness must be a number from 0.000001 to 10000000 N/m. \
             Check the sign and the unit. See line 9.",
        ),
        (
            with("mass = [1.0, 2.0]", "mas = [1.0, 2.0]"),
            "robot1.mas = [1.0, 2.0]: [robot1] has the keys name, axes, mass, damping, coulomb, \
             ground_stiffness, mass_sd, \
             damping_sd, mass_damping_correlation. Did you mean \"mass\"? See line 3.",
        ),
        (
            with("[network]", "[netwrok]"),
            "netwrok = a section: a study has a name and the sections [robot1], [robot2], [operator1], \
             [operator2], [coupling], [network], [controller], [arm1], [arm2], [agent1], [agent2], [task], \
             [laboratory], [protocol], [session], [comparison]. Did you mean \"network\"? See line 10.",
        ),
        (
            with("stiffness = 20", "stiffness = 20\njitter = 0.01"),
            "coupling.jitter = 0.01: [coupling] has the keys stiffness, damping. It belongs under \
             [network] or [laboratory]. See line 10.",
        ),
        (
            with("stiffness = 20", "stiffness = 20\ncoulomb = 0.1"),
            "coupling.coulomb = 0.1: [coupling] has the keys stiffness, damping. It belongs under [robot1] or \
             [robot2]. See line 10.",
        ),
        (
            with("delay = 0.05", "delay = 0.05\nname = \"campus\""),
            "network.name = \"campus\": [network] has the keys delay, jitter, max_gap, \
             playout_buffer, distribution, loss, burst, duplicate, order, rate, blackout, trace, adversary. Remove it, \
             or correct its name. See line 12.",
        ),
        (
            with("mass = [1.0, 2.0]", "mass = [1.0, 0.0]"),
            "robot1.mass[1] = 0: a mass must be a number from 0.0001 to 10000 kg. \
             Check the unit: kg is expected. See line 3.",
        ),
        (
            with("mass = [1.0, 2.0]", "mass = \"1 kg\""),
            "robot1.mass = \"1 kg\": a number or a list of numbers, one per axis, is required. Write 1: \
             a study has numbers in kg, without quotes. See line 3.",
        ),
        (
            with("damping = [5.0, 6.0]", "damping = [5.0, 6.0, 7.0]"),
            "robot2.axes = 3 axes: both robots need the same number of axes, and robot1 has 2. Give both \
             robots one mass and one damping per axis. See line 5.",
        ),
        (
            with("damping = [5.0, 6.0]", "damping = [5.0, 6.0, 7.0]\naxes = [\"x\", \"y\"]"),
            "robot2.damping = [5.0, 6.0, 7.0]: one value per axis is required: 2, not 3. Give one value \
             per axis, or a single number for all of them. See line 7.",
        ),
        (String::new(), "Missing robot1.mass (kg). Add a section [robot1] with mass = 1.0."),
        (
            with("delay = 0.05", "delay = 80"),
            "network.delay = 80 s: a delay is usually up to 2 s. Did you mean 80 ms? Write 0.08. If it is \
             meant, write allow_unusual = true in the study, or --allow-unusual on the command line. See line \
             11.",
        ),
        (
            format!("allow_unusual = 1\n{}", with("delay = 0.05", "delay = 80")),
            "allow_unusual = 1: true or false is required. Write it without quotes. See line 1.",
        ),
        (
            with("delay = 0.05", "delay = {forward = 0.05}"),
            "Missing network.delay.backward. Add backward = …, or give one number. See line 11.",
        ),
        (
            with("sample_period = 0.001", "sample_period = 0.001\ncomputing_time = 0.002"),
            "controller.computing_time = 0.002: a computing time must fit into the sample period of 0.001 \
             s. Shorten it, or give the actual sample period of the controller. See line 14.",
        ),
        (
            with("[network]", "[operator1]\nstiffness = {min = 300, max = 0}\n[network]"),
            "operator1.stiffness = {min = 300, max = 0}: the minimum must not exceed the maximum. Swap \
             the two. See line 11.",
        ),
        (
            with("[controller]", "[task]\nkind = \"figure eight\"\n[controller]"),
            "task.kind = \"figure eight\": it must be one of \"figure-eight\", \"python\". Did you mean \
             \"figure-eight\"? See line 13.",
        ),
    ];
    for (text, message) in cases {
        assert_eq!(refusal(text), *message);
    }
}

#[test]
fn ref_text_that_is_not_toml_names_its_line() {
    let message = refusal(&with("delay = 0.05", "delay = 50 ms"));
    assert!(message.starts_with("study = \"delay = 50 ms\": a study must be valid TOML: "), "{message}");
    assert!(message.ends_with("Correct line 11."), "{message}");
    let twice = refusal(&with("delay = 0.05", "delay = 0.05\ndelay = 0.06"));
    assert!(twice.contains("duplicate key") && twice.ends_with("Correct line 12."), "{twice}");
}

#[test]
fn ref_hostile_text_is_refused() {
    for text in [
        "[".repeat(100_000),
        format!("a = {}", "[".repeat(100_000)),
        format!("a = {}", "{a=".repeat(100_000)),
        format!("{} = 1", vec!["a"; 100_000].join(".")),
        "a".repeat(2 << 20),
        "\u{feff}\0\r\n".to_owned(),
        "robot1 = 3".to_owned(),
        "robot1 = []".to_owned(),
        "[[robot1]]\nmass = 1".to_owned(),
        with("delay = 0.05", "delay = 1979-05-27T07:32:00Z"),
        with("delay = 0.05", "delay = 1e999"),
        with("delay = 0.05", "delay = 0xFFFFFFFFFFFFFFFF"),
        with("delay = 0.05", "delay = 99999999999999999999999999999999999999999999"),
        with("delay = 0.05", "delay = {}"),
        with("delay = 0.05", "delay = []"),
        with("mass = 1", "mass = []"),
        with("mass = 1", "mass = [{min = 1, max = 2}]"),
        with("mass = 1", "mass = 1\naxes = []"),
        with("mass = 1", "mass = 1\naxes = [\"x\", \"x\"]"),
        with("mass = 1", "mass = 1\nname = 7"),
        with("name = \"test\"", "name = 7"),
    ] {
        let message = refusal(&text);
        assert!(message.len() < 600, "{message}");
    }
}

#[test]
fn ref_a_study_may_leave_stiffness_and_delay_open() {
    let open = with("stiffness = 20", "").replace("delay = 0.05", "jitter = 0.05");
    let study = Study::from_toml(&open).unwrap();
    assert!(!study.has_stiffness() && !study.has_delay());
    assert_eq!(Study::from_toml(&study.to_toml()).unwrap(), study);
    assert_eq!(
        study.coupling().unwrap_err().to_string(),
        "Missing coupling.stiffness (N/m). Add a section [coupling] with stiffness = 20.0."
    );
    assert_eq!(
        study.network().unwrap_err().to_string(),
        "Missing network.delay (s, one way). Add a section [network] with delay = 0.05."
    );
}

#[test]
fn ref_controllers_sample_each_millisecond_unless_a_file_says_otherwise() {
    let period = |text: &str| Study::from_toml(text).unwrap().network().unwrap().sample_period();
    let silent = with("sample_period = 0.001", "");
    assert_eq!(period(&silent), 0.001);
    assert_eq!(period(&with("sample_period = 0.001", "sample_period = 0")), 0.0);
    assert_eq!(period(&format!("{silent}[laboratory]\nsample_period = 0.002\n")), 0.002);
    assert_eq!(Study::paper().network().unwrap().sample_period(), 0.0);
}

#[test]
fn law_a_study_that_allows_unusual_values_stays_so() {
    let text = format!("allow_unusual = true\n{}", with("delay = 0.05", "delay = 80"));
    let study = Study::from_toml(&text).unwrap();
    assert_eq!(Study::from_toml(&study.to_toml()).unwrap(), study);
    assert_eq!(study.network().unwrap().delay().forward(), 80.0);
}

#[test]
fn law_only_the_changed_study_is_judged() {
    let robot = RobotFile::from_toml("[robot]\nmass = 0.84\ndamping = 7.7", "left.toml").unwrap();
    let key = |value| Replacement::Keys([("delay".to_owned(), Some(Value::from(value)))].into());
    let wrong = with("delay = 0.05", "delay = -1");
    let study = Study::from_changed_toml(
        &wrong,
        [Some(&robot), Some(&robot)],
        &[("network".to_owned(), key(0.1))].into(),
    );
    let study = study.unwrap();
    assert_eq!(study.dyad().axis_names(), ["x"]);
    assert_eq!(study.network().unwrap().delay().forward(), 0.1);
    // What is refused in the text still has its line, what is refused in a change has none.
    let refused = Study::from_changed_toml(&wrong, [None, None], &[].into()).unwrap_err();
    assert!(refused.remedy.ends_with("See line 11."), "{refused}");
    let changed = [("network".to_owned(), key(-2.0))].into();
    let refused = Study::from_changed_toml(&wrong, [None, None], &changed).unwrap_err();
    assert_eq!((refused.field.as_str(), refused.value.as_str()), ("network.delay", "-2"));
    assert!(!refused.remedy.contains("line"), "{refused}");
    let bad = RobotFile::from_toml("[robot]\nmass = -1\ndamping = 7.7", "left.toml").unwrap();
    let refused = Study::from_changed_toml(GOOD, [Some(&bad), Some(&robot)], &[].into()).unwrap_err();
    assert!(refused.remedy.ends_with("See [robot] in left.toml."), "{refused}");
}

/// A robot file replaces a robot whole; a spring to the ground that identification found is the operator's.
#[test]
fn ref_a_robot_file_replaces_the_robot_and_adds_its_spring_to_the_operator() {
    let study = Study::from_toml(
        "[robot1]\nmass = [1, 2]\ndamping = [5, 6]\ncoulomb = 0.3\n[robot2]\nmass = [1, 2]\ndamping = [5, 6]\n\
         [operator2]\nmass = 0.5\nstiffness = [{min = 10, max = 300}, 40]\n\
         [coupling]\nstiffness = 20\n[network]\ndelay = 0.05\n[agent1]\nkind = \"skilled\"",
    )
    .unwrap();
    let text = "[robot]\nname = \"mine\"\nmass = [0.84, 1.07]\ndamping = [7.7, 10.1]\nmass_sd = 0.01\n\
                [identification]\nlogs = 2\nstiffness = [3.0, 0.0]";
    let file = RobotFile::from_toml(text, "mine.toml").unwrap();

    let first = study.with_robot(0, &file).unwrap();
    let robot = &first.dyad().robots()[0];
    assert_eq!((robot.mass(), robot.damping()), (&[0.84, 1.07][..], &[7.7, 10.1][..]));
    assert_eq!(first.robot_names()[0], Some("mine"));
    // Nothing of the old robot stays: neither its friction nor the free handle, which now has the spring.
    assert_eq!(first.coulomb()[0], [0.0, 0.0]);
    assert_eq!(first.uncertainty()[0].unwrap().mass_sd, [0.01, 0.01]);
    let [held, other] = first.operator_ranges().unwrap();
    assert_eq!((held.low().stiffness(), held.high().stiffness()), (&[3.0, 0.0][..], &[3.0, 0.0][..]));
    // Everything else stays.
    assert_eq!(first.dyad().robots()[1], study.dyad().robots()[1]);
    assert_eq!(other, &study.operator_ranges().unwrap()[1]);
    assert_eq!(first.names_arms_or_agents(), study.names_arms_or_agents());
    assert_eq!(first.coupling().unwrap().stiffness, 20.0);
    assert_eq!(first.network().unwrap().delay().forward(), 0.05);

    // The spring is added to both ends of a range, and to a single number.
    let second = study.with_robot(1, &file).unwrap();
    let range = &second.operator_ranges().unwrap()[1];
    assert_eq!((range.low().stiffness(), range.high().stiffness()), (&[13.0, 40.0][..], &[303.0, 40.0][..]));
    assert_eq!(range.low().mass(), [0.5, 0.5]);
    assert_eq!(Study::from_toml(&second.to_toml()).unwrap(), second);

    // A refusal names the file and its key.
    let short = RobotFile::from_toml(
        "[robot]\nmass = 1\ndamping = 5\n[identification]\nstiffness = [3.0, 1.0, 2.0]",
        "short.toml",
    )
    .unwrap();
    let refused = study.with_robot(0, &short).unwrap_err();
    assert_eq!(refused.field, "robot1.ground_stiffness");
    assert!(refused.remedy.contains("stiffness in [identification] in short.toml"), "{refused}");
    let negative = RobotFile::from_toml("[robot]\nmass = -1\ndamping = 5", "negative.toml").unwrap();
    let refused = study.with_robot(1, &negative).unwrap_err();
    assert_eq!(refused.field, "robot2.mass");
}
