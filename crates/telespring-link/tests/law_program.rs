//! The program as people start it: what it prints, its exit status, its refusals, and a robot written in Python.

use std::fs;
use std::io::Write;
use std::net::UdpSocket;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

use serde_json::Value;
use telespring_link::site::Phase;
use telespring_link::telemetry::{VALUES, phase_code};

fn program() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_telespring-link"));
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

fn examples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples")
}

/// A folder for one test, empty.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// Ports of this machine that are free now.
fn ports<const N: usize>() -> [u16; N] {
    let sockets = [(); N].map(|()| UdpSocket::bind("127.0.0.1:0").unwrap());
    sockets.map(|socket| socket.local_addr().unwrap().port())
}

/// Writes the site files of the examples with these ports: of both sites, of the device link and of the device.
fn write_sites(folder: &Path, [one, two, link, device]: [u16; 4]) -> [PathBuf; 2] {
    fs::copy(examples().join("connect.toml"), folder.join("connect.toml")).unwrap();
    ["site-1.toml", "site-2.toml"].map(|name| {
        let mut text = fs::read_to_string(examples().join(name)).unwrap();
        for (from, to) in [(4500, one), (4502, two), (4601, link), (4600, device)] {
            text = text.replace(&format!("127.0.0.1:{from}\""), &format!("127.0.0.1:{to}\""));
        }
        // a busy machine stands still for long
        text.push_str("deadline = 1.0\n".repeat(usize::from(name == "site-1.toml")).as_str());
        text.push_str("\n[safety]\nstall = 0.5\n");
        let path = folder.join(name);
        fs::write(&path, text).unwrap();
        path
    })
}

fn summary(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {output:?}"))
}

fn events(summary: &Value) -> Vec<&str> {
    summary["events"].as_array().unwrap().iter().map(|entry| entry["event"].as_str().unwrap()).collect()
}

fn refusal(arguments: &[&str]) -> String {
    let output = program().args(arguments).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{arguments:?} {output:?}");
    assert!(output.stdout.is_empty());
    String::from_utf8(output.stderr).unwrap()
}

#[test]
fn law_the_demonstration_ends_by_itself_and_says_what_happened() {
    let output = program().args(["demo", "--seconds", "3", "--delay", "0.03"]).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let summary = summary(&output);
    for (side, site) in summary["sites"].as_array().unwrap().iter().enumerate() {
        assert_eq!(site["side"], side + 1);
        assert_eq!(site["state"], "ended");
        assert!(site["coupled_share"].as_f64().unwrap() > 0.1, "{site}");
        // there and back
        assert!(site["round_trip"]["smallest"].as_f64().unwrap() >= 0.058, "{site}");
        assert!(site["loss"]["received"].as_u64().unwrap() > 100, "{site}");
        assert!(site["te"].as_f64().unwrap() > 0.0, "{site}");
        assert!(site["energy"]["least_balance"].as_f64().unwrap() >= 0.0, "{site}");
        for key in ["age", "lateness", "limited_share", "events", "real_time", "refused"] {
            assert!(!site[key].is_null(), "{key}: {site}");
        }
        let events = events(site);
        assert_eq!(events.first().copied(), Some("agreed"));
        assert_eq!(events.last().copied(), Some("ended"));
    }
    let study = summary["study"].as_str().unwrap();
    assert!(telespring::study::Study::from_toml(study).is_ok());
}

#[test]
fn law_input_that_cannot_be_is_refused_with_the_field_and_a_remedy() {
    for (arguments, said) in [
        (vec!["fly"], "unrecognized subcommand 'fly'"),
        (vec!["demo", "--loss"], "a value is required for '--loss"),
        (vec!["demo", "--loss", "2"], "network.loss"),
        (vec!["demo", "--seconds", "-1"], "seconds = -1"),
        (vec!["demo", "--seconds", "soon"], "invalid value 'soon' for '--seconds"),
        (vec!["demo", "--strategy", "hope"], "invalid value 'hope' for '--strategy"),
        (vec!["demo", "--speed", "1"], "unexpected argument '--speed'"),
        (vec!["demo", "site.toml"], "unexpected argument 'site.toml'"),
        (vec!["run"], "<SITE>"),
        (vec!["run", "nowhere.toml"], "site = nowhere.toml"),
        (vec!["demo", "--record", "nowhere"], "--record = nowhere"),
        (vec!["demo", "--live", "0.0.0.0:8765"], "--live = 0.0.0.0:8765"),
    ] {
        let message = refusal(&arguments);
        assert!(message.contains(said), "{arguments:?}: {message}");
    }
    assert_eq!(program().output().unwrap().status.code(), Some(2));
    assert_eq!(program().arg("--help").output().unwrap().status.code(), Some(0));
}

#[test]
fn law_a_site_file_is_refused_with_the_key() {
    let folder = folder("refusals");
    let [site, _] = write_sites(&folder, ports());
    let good = fs::read_to_string(&site).unwrap();
    let study = fs::read_to_string(folder.join("connect.toml")).unwrap();
    for (from, to, said) in [
        ("side = 1", "side = 3", "side = 3"),
        ("side = 1", "", "missing field `side`"),
        ("side = 1", "side = 1\nsid = 2", "unknown field `sid`"),
        ("study = \"connect.toml\"", "study = \"absent.toml\"", "absent.toml"),
        ("kind = \"udp\"", "kind = \"hebi\"", "unknown variant `hebi`"),
        ("127.0.0.1:", "localhost:", "expected an address with a port, such as \"127.0.0.1:4500\""),
        ("local = \"127.0.0.1:", "local = \"0.0.0.0:", "network.local = 0.0.0.0:"),
        ("peer = \"127.0.0.1:", "peer = \"192.0.2.7:", "network.peer = 192.0.2.7:"),
        ("device = \"127.0.0.1:", "device = \"192.0.2.7:", "device.device = 192.0.2.7:"),
        ("deadline = 1.0", "deadline = 0.0001", "device.deadline = 0.0001 s"),
        ("stall = 0.5", "stall = 100", "safety.stall = 100 s"),
        ("stall = 0.5", "stall = 0.5\n[limits]\nforce = -1.0", "limits.force = -1"),
        ("stall = 0.5", "stall = 0.5\n[limits.person]\nforce = 0.0", "limits.person.force = 0"),
        ("stall = 0.5", "stall = 0.5\n[limits]\nscale = 1.5", "limits.scale = 1.5"),
        ("stall = 0.5", "stall = 0.5\n[limits]\nvelocity = 0.0", "limits.velocity = 0"),
        ("stall = 0.5", "stall = 0.5\n[limits]\nworkspace.x = [0.1, 0.0]", "limits.workspace"),
        ("stall = 0.5", "stall = 0.5\n[limits]\nlock = [\"z\"]", "unknown variant `z`"),
        ("stall = 0.5", "stall = 0.5\n[session]\nconsent = \"automatic\"", "whoever holds a robot consents"),
        ("stall = 0.5", "stall = 0.5\n[session]\nalignment = 0.0", "session.alignment = 0"),
        ("stall = 0.5", "stall = 0.5\n[fallback]\nloss = 2.0", "fallback.loss = 2"),
        ("stall = 0.5", "stall = 0.5\n[fallback]\npatience = 0.0", "fallback.patience = 0 s"),
        ("stall = 0.5", "silence = 0.01", "safety.silence = 0.01 s"),
        ("side = 1", "side = 1\nloop.priority = 100", "loop.priority = 100"),
        ("side = 1", "side = 1\nseconds = 0.0", "seconds = 0 s"),
        ("side = 1", "side = 1\ntelemetry.address = 4700", "up to 4 of them in brackets"),
        ("side = 1", "side = 1\ntelemetry.address = []", "telemetry.address = 0 addresses"),
        (
            "side = 1",
            "side = 1\ntelemetry.address = \"192.0.2.7:4700\"",
            "telemetry.address = 192.0.2.7:4700",
        ),
        ("side = 1", "side = 1\ntelemetry = {address = \"127.0.0.1:1\", every = 0}", "telemetry.every = 0"),
    ] {
        assert!(good.contains(from), "{from}");
        fs::write(&site, good.replace(from, to)).unwrap();
        let message = refusal(&["run", site.to_str().unwrap()]);
        assert!(message.contains(said), "{to}: {message}");
    }
    fs::write(&site, &good).unwrap();
    for (from, to, said) in [
        ("\"guard\"", "\"spring\"", "study.session.strategy = \"spring\""),
        ("[session]", "[session]\npredictor = \"shared-target\"", "study.session.predictor"),
        ("stiffness = 100.0", "stiffness = -1.0", "study.coupling.stiffness"),
        // 40 ms after its motion a force acts last: 0.1 · 0.7776 / 0.04² = 48.6 N/m
        ("[session]", "[laboratory]\nactuator_lag = 0.039\n[session]", "proven up to 48.6 N/m only"),
        ("stiffness = 100.0", "damping = 0.0", "Write stiffness = 20.0 under [coupling]"),
        (", damping = 8.0", "", "the least damping that the robot certainly has"),
    ] {
        assert!(study.contains(from), "{from}");
        fs::write(folder.join("connect.toml"), study.replace(from, to)).unwrap();
        let message = refusal(&["run", site.to_str().unwrap()]);
        assert!(message.contains(said), "{to}: {message}");
    }
    // a robot with one axis is sent where it finds how to take part, whatever else the study has
    let robots = |axes: &str, damping: &str| {
        let robot = format!("{{axes = [{axes}], mass = 1, damping = {damping}}}");
        format!("robot1 = {robot}\nrobot2 = {robot}\ncoupling.stiffness = 100\nnetwork.delay = 0.003\n")
    };
    let guarded = |text: String| text + "session.strategy = \"guard\"\n";
    for (text, said) in [
        (robots("\"x\"", "8"), "docs/your-robot.md says how a robot with one axis takes part"),
        (guarded(robots("\"x\"", "8")), "docs/your-robot.md says how a robot with one axis takes part"),
        (guarded(robots("\"x\", \"y\"", "0")), "the guard needs robots with damping above 0"),
    ] {
        fs::write(folder.join("connect.toml"), text).unwrap();
        let message = refusal(&["run", site.to_str().unwrap()]);
        assert!(message.contains(said), "{message}");
    }
    // a port that somebody has
    fs::write(folder.join("connect.toml"), &study).unwrap();
    let taken = UdpSocket::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port();
    let [site, _] = write_sites(&folder, [port, 1, 2, 3]);
    assert!(refusal(&["run", site.to_str().unwrap()]).contains("network.local = 127.0.0.1:"));
}

#[test]
fn law_two_sites_with_other_studies_refuse_each_other() {
    let folder = folder("other-studies");
    let [_, second] = write_sites(&folder, ports());
    let text = fs::read_to_string(&second).unwrap();
    let other = folder.join("other.toml");
    let study = fs::read_to_string(folder.join("connect.toml")).unwrap();
    fs::write(&other, study.replace("stiffness = 100.0", "stiffness = 101.0")).unwrap();
    let first = folder.join("first.toml");
    let addresses: Vec<&str> = text.lines().filter(|line| line.contains("127.0.0.1")).collect();
    let [local, peer] = [addresses[0], addresses[1]];
    fs::write(
        &first,
        format!(
            "study = \"other.toml\"\nside = 1\n[network]\n{}\n{}\n",
            peer.replace("peer", "local"),
            local.replace("local", "peer")
        ),
    )
    .unwrap();
    let children: Vec<Child> = [&first, &second]
        .map(|path| program().arg("run").arg(path).args(["--seconds", "60"]).spawn().unwrap())
        .into();
    for child in children {
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{output:?}");
        let summary = summary(&output);
        assert_eq!(summary["cause"], "refused");
        assert_eq!(summary["disagreement"], "coupling");
        let told = summary["events"].as_array().unwrap().iter().find(|entry| entry["event"] == "disagreed");
        let cause = told.unwrap()["cause"].as_str().unwrap();
        assert!(cause.contains("101 N/m") && cause.contains("100 N/m"), "{cause}");
        assert_eq!(summary["largest_force"], 0.0);
        assert_eq!(summary["coupled_share"], 0.0);
    }
}

#[test]
fn law_a_signal_ends_a_session_in_an_orderly_way() {
    let folder = folder("signal");
    let [_, second] = write_sites(&folder, ports());
    let mut child = program().arg("run").arg(second).args(["--seconds", "60"]).spawn().unwrap();
    // give it time to begin; before that the signal ends it without a summary
    std::thread::sleep(std::time::Duration::from_secs(2));
    assert!(child.try_wait().unwrap().is_none());
    let pid = child.id().to_string();
    assert!(Command::new("kill").args(["-TERM", &pid]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    let summary = summary(&output);
    assert_eq!([&summary["state"], &summary["cause"]], ["ended", "stop-requested"]);
    // nobody came
    assert_eq!(output.status.code(), Some(1));
    assert!(summary["loss"]["unreachable"].as_u64().unwrap() > 0, "{summary}");
}

/// The tables of a site file.
const TABLES: [&str; 10] = [
    "network",
    "device",
    "safety",
    "loop",
    "limits",
    "session",
    "fallback",
    "telemetry",
    "recording",
    "live",
];

#[test]
fn law_the_page_has_every_key() {
    let page = fs::read_to_string(examples().join("../docs/connect.md")).unwrap();
    let folder = folder("page");
    let [site, _] = write_sites(&folder, ports());
    let good = fs::read_to_string(&site).unwrap();
    // what is allowed is said where a key is refused
    let mut keys = 0;
    for (section, at) in [
        ("", "study = "),
        ("network.", "[network]\n"),
        ("device.", "[device]\n"),
        ("safety.", "[safety]\n"),
        ("limits.", "[limits]\n"),
        ("session.", "[session]\n"),
        ("fallback.", "[fallback]\n"),
        ("loop.", "[loop]\n"),
        ("telemetry.", "[telemetry]\n"),
        ("recording.", "[recording]\n"),
        ("live.", "[live]\n"),
    ] {
        let text = format!(
            "{good}\n[loop]\npriority = 0\n[limits]\n[session]\n[fallback]\n\n[telemetry]\naddress = \"127.0.0.1:1\"\n\n\
             [recording]\n\n[live]\n"
        );
        let place = text.find(at).unwrap() + if section.is_empty() { 0 } else { at.len() };
        fs::write(&site, format!("{}absent = 1\n{}", &text[..place], &text[place..])).unwrap();
        let message = refusal(&["run", site.to_str().unwrap()]);
        let allowed = message.split("expected ").nth(1).unwrap_or_else(|| panic!("{message}"));
        for key in allowed.split('`').skip(1).step_by(2) {
            if !(section.is_empty() && TABLES.contains(&key)) {
                assert!(page.contains(&format!("`{section}{key}`")), "{section}{key} {message}");
                keys += 1;
            }
        }
    }
    assert!(keys >= 37, "{keys}");
    let output = program().args(["demo", "--seconds", "0.2"]).output().unwrap();
    for key in summary(&output)["sites"][0].as_object().unwrap().keys() {
        // as a key of its own or of a group
        assert!(page.contains(&format!("`{key}`")), "{key}");
    }
}

#[test]
fn law_the_telemetry_of_a_session_reaches_who_listens() {
    let folder = folder("telemetry");
    let [one, two] = ports::<2>().map(|port| format!("\"127.0.0.1:{port}\""));
    let listener = UdpSocket::bind("127.0.0.1:0").unwrap();
    listener.set_read_timeout(Some(std::time::Duration::from_secs(30))).unwrap();
    let address = listener.local_addr().unwrap();
    fs::copy(examples().join("connect.toml"), folder.join("connect.toml")).unwrap();
    let children = [(1, &one, &two), (2, &two, &one)].map(|(side, local, peer)| {
        let path = folder.join(format!("{side}.toml"));
        let telemetry = if side == 2 {
            format!("[telemetry]\naddress = \"{address}\"\nevery = 2\n")
        } else {
            String::new()
        };
        let text = format!(
            "study = \"connect.toml\"\nside = {side}\n[network]\nlocal = {local}\npeer = {peer}\n\
             [safety]\nstall = 0.5\n{telemetry}"
        );
        fs::write(&path, text).unwrap();
        program()
            .arg("run")
            .arg(path)
            .args(["--seconds", if side == 1 { "3" } else { "60" }])
            .spawn()
            .unwrap()
    });
    let mut rows: Vec<[f64; VALUES]> = Vec::new();
    // until the session has ended
    while rows.last().is_none_or(|row| row[4] != phase_code(Phase::Ended)) {
        let mut room = [0; 8 * VALUES + 1];
        assert_eq!(listener.recv(&mut room).unwrap(), 8 * VALUES);
        let value = |place: usize| f64::from_le_bytes(room[8 * place..8 * place + 8].try_into().unwrap());
        rows.push(std::array::from_fn(value));
    }
    for child in children {
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{output:?}");
    }
    for (number, row) in (1_u32..).zip(&rows) {
        // the version, each row once, the side, the interval; nothing was missed
        assert_eq!([row[0], row[1], row[2], row[35], row[36]], [1.0, f64::from(number), 2.0, 0.002, 0.0]);
    }
    assert!(rows.windows(2).all(|rows| rows[0][3] < rows[1][3]));
    let mut phases: Vec<f64> = rows.iter().map(|row| row[4]).collect();
    phases.dedup();
    let [first, .., last] = phases[..] else { panic!("{phases:?}") };
    assert_eq!([first, last], [Phase::Connecting, Phase::Ended].map(phase_code));
    for phase in [Phase::RampingIn, Phase::Running, Phase::RampingOut] {
        assert!(phases.contains(&phase_code(phase)), "{phases:?}");
    }
    let running: Vec<_> = rows.iter().filter(|row| row[4] == phase_code(Phase::Running)).collect();
    assert!(running.len() > 100, "{}", running.len());
    assert!(running.iter().any(|row| row[19].hypot(row[20]) > 0.0));
    // position, target, stiffness wanted, balance
    assert!(running.iter().all(|row| [7, 8, 15, 16, 23, 26].iter().all(|place| row[*place].is_finite())));
}

/// The name of Python, if there is one.
fn python() -> Option<&'static str> {
    ["python3", "python"].into_iter().find(|name| {
        let mut version = Command::new(name);
        version.args(["-c", "import sys; sys.exit(sys.version_info < (3, 11))"]);
        version.status().is_ok_and(|status| status.success())
    })
}

#[test]
fn cross_a_robot_in_python_is_coupled_and_let_go() {
    let Some(python) = python() else {
        eprintln!("SKIPPED: there is no Python 3.11 or newer on the path");
        return;
    };
    let mut robot = Command::new(python);
    robot.arg(examples().join("device.py"));
    assert_is_coupled_and_let_go("python", robot);
}

#[test]
fn cross_a_robot_in_c_is_coupled_and_let_go() {
    let robot = folder("c-compiled").join("device");
    let mut compiler = Command::new("cc");
    compiler.args(["-std=c11", "-pedantic", "-O2", "-Wall", "-Wextra", "-Werror", "-o"]).arg(&robot);
    match compiler.arg(examples().join("device.c")).arg("-lm").output() {
        Ok(output) => assert!(output.status.success(), "{output:?}"),
        Err(error) => {
            eprintln!("SKIPPED: there is no C compiler cc on the path ({error})");
            return;
        }
    }
    assert_is_coupled_and_let_go("c", Command::new(robot));
}

/// Joins a robot of one's own, as the examples are, with a simulated partner for some seconds.
fn assert_is_coupled_and_let_go(name: &str, mut robot: Command) {
    let folder = folder(name);
    let ports = ports();
    let [_, _, link, device] = ports;
    let [first, second] = write_sites(&folder, ports);
    let robot = robot
        .args(["--listen", &format!("127.0.0.1:{device}"), "--site", &format!("127.0.0.1:{link}")])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let other = program().arg("run").arg(second).args(["--seconds", "60"]).spawn().unwrap();
    // whoever holds the robot consents; before it is asked for, that is refused and said
    let mut site = program();
    site.arg("run").arg(first).args(["--seconds", "8", "--console"]).stdin(Stdio::piped());
    let mut site = site.spawn().unwrap();
    let mut orders = site.stdin.take().unwrap();
    for order in ["nonsense", "mark participant P-01"].into_iter().chain(["consent"; 12]) {
        // a site that has ended takes none
        let _ = writeln!(orders, "{order}");
        std::thread::sleep(std::time::Duration::from_millis(500));
    }
    let site = site.wait_with_output().unwrap();
    let other = other.wait_with_output().unwrap();
    let robot = robot.wait_with_output().unwrap();
    assert_eq!(site.status.code(), Some(0), "{site:?} {robot:?}");
    assert_eq!(other.status.code(), Some(0), "{other:?}");
    // of a console the last line
    let last = String::from_utf8_lossy(&site.stdout).lines().last().unwrap().to_owned();
    let [site, other] = [serde_json::from_str(&last).unwrap(), summary(&other)];
    assert_eq!([&site["cause"], &other["cause"]], ["time-over", "partner-left"]);
    for event in ["order-refused", "mark", "consented", "partner-consented", "force-ramping-in"] {
        assert!(events(&site).contains(&event), "{event}: {site}");
    }
    // what is told is in the order of its time
    for summary in [&site, &other] {
        let times: Vec<f64> = summary["events"]
            .as_array()
            .unwrap()
            .iter()
            .map(|entry| entry["time"].as_f64().unwrap())
            .collect();
        assert!(times.is_sorted(), "{summary}");
    }
    // its rows set the pace; the other side has none
    assert!(site["lateness"]["followed"].as_u64().unwrap() > 100, "{site}");
    assert_eq!(other["lateness"]["followed"], 0);
    let largest = site["largest_force"].as_f64().unwrap();
    assert!(largest > 0.0 && largest <= 20.0, "{site}");
    assert!(site["energy"]["least_balance"].as_f64().unwrap() >= 0.0, "{site}");
    // what the robot itself saw
    assert!(robot.status.success(), "{robot:?}");
    let said = String::from_utf8(robot.stdout).unwrap();
    let numbers: Vec<f64> = said.split(' ').filter_map(|word| word.parse().ok()).collect();
    let [rows, commands, felt] = numbers[..] else { panic!("{said}") };
    assert!(rows > 100.0 && commands > 100.0, "{said}");
    // it prints three digits, and may have missed the largest
    assert!(felt > 0.0 && felt <= largest + 1e-3, "{said} {largest}");
}
