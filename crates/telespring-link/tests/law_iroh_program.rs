//! Two programs over iroh on this machine, as people start them: keys, a session, a partner that dies and comes again.

mod sites;

use std::fs;
use std::net::UdpSocket;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

use serde_json::Value;
use sites::over_iroh;

fn program() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_telespring-link"));
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

fn run(arguments: &[&str]) -> Output {
    program().args(arguments).output().unwrap()
}

fn said(output: &Output) -> String {
    assert!(output.status.success(), "{output:?}");
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn refusal(arguments: &[&str]) -> String {
    let output = run(arguments);
    assert_eq!(output.status.code(), Some(2), "{arguments:?} {output:?}");
    String::from_utf8(output.stderr).unwrap()
}

/// A folder for one test, with the study of the examples and a key for each site.
fn folder(name: &str) -> (PathBuf, [String; 2]) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("iroh-{name}"));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples");
    fs::copy(examples.join("connect.toml"), folder.join("connect.toml")).unwrap();
    let ids = [1, 2].map(|side| {
        let key = folder.join(format!("{side}.key"));
        let made = said(&run(&["keygen", key.to_str().unwrap()]));
        assert_eq!(said(&run(&["id", key.to_str().unwrap()])), made);
        made.trim_end().to_owned()
    });
    (folder, ids)
}

/// Writes both site files.
fn write_sites(folder: &Path, ids: &[String; 2]) -> [PathBuf; 2] {
    let sockets = [(); 2].map(|()| UdpSocket::bind("127.0.0.1:0").unwrap());
    let addresses = sockets.map(|socket| socket.local_addr().unwrap());
    [0, 1].map(|side: usize| {
        let path = folder.join(format!("site-{}.toml", side + 1));
        let (here, there) = (addresses[side], addresses[1 - side]);
        let text = over_iroh("connect.toml", side + 1, &ids[1 - side], here, there);
        fs::write(&path, text + "[safety]\nstall = 0.5\n").unwrap();
        path
    })
}

fn start(site: &Path, seconds: &str) -> Child {
    program().arg("run").arg(site).args(["--seconds", seconds]).spawn().unwrap()
}

fn summary(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {output:?}"))
}

fn events(summary: &Value) -> Vec<&str> {
    summary["events"].as_array().unwrap().iter().map(|entry| entry["event"].as_str().unwrap()).collect()
}

#[test]
fn law_two_programs_are_coupled_and_say_goodbye() {
    let (folder, ids) = folder("session");
    let [first, second] = write_sites(&folder, &ids);
    let other = start(&second, "60");
    let first = start(&first, "8").wait_with_output().unwrap();
    let second = other.wait_with_output().unwrap();
    let sites = [summary(&first), summary(&second)];
    assert_eq!([first.status.code(), second.status.code()], [Some(0), Some(0)], "{sites:?}");
    assert_eq!([&sites[0]["cause"], &sites[1]["cause"]], ["time-over", "partner-left"]);
    for site in &sites {
        assert!(
            events(site).contains(&"path-direct") && events(site).contains(&"force-ramping-in"),
            "{site}"
        );
        assert!(site["path"]["connections"].as_u64().unwrap() >= 1, "{site}");
        assert_eq!([&site["path"]["strangers"], &site["path"]["every"]], [0, 1], "{site}");
        assert!(site["largest_force"].as_f64().unwrap() > 0.0, "{site}");
        assert!(site["energy"]["least_balance"].as_f64().unwrap() >= 0.0, "{site}");
    }
}

#[test]
fn law_a_partner_that_is_killed_and_started_again_is_greeted_anew() {
    let (folder, ids) = folder("killed");
    let [first, second] = write_sites(&folder, &ids);
    let stays = start(&first, "60");
    let mut dies = start(&second, "60");
    std::thread::sleep(Duration::from_secs(5));
    // this is SIGKILL
    dies.kill().unwrap();
    dies.wait().unwrap();
    std::thread::sleep(Duration::from_millis(500));
    let again = start(&second, "8").wait_with_output().unwrap();
    let stayed = stays.wait_with_output().unwrap();
    let [stayed, again] = [summary(&stayed), summary(&again)];
    assert_eq!([&stayed["cause"], &again["cause"]], ["partner-left", "time-over"], "{stayed} {again}");
    let agreed = events(&stayed).iter().filter(|event| **event == "agreed").count();
    assert_eq!(agreed, 2, "{stayed}");
    // the force was gone in between, because of silence
    let silences = stayed["events"].as_array().unwrap().iter();
    assert!(
        silences.clone().any(|entry| entry["event"] == "disengaged" && entry["cause"] == "silence"),
        "{stayed}"
    );
    // whether it is coupled again depends on where the two handles are: its robot starts from the beginning
    assert!(events(&again).contains(&"agreed"), "{again}");
    assert!(stayed["path"]["connections"].as_u64().unwrap() >= 2, "{stayed}");
    assert!(stayed["energy"]["least_balance"].as_f64().unwrap() >= 0.0, "{stayed}");
}

#[test]
fn law_a_wrong_key_is_refused_counted_and_moves_nothing() {
    let (folder, ids) = folder("wrong");
    let [first, second] = write_sites(&folder, &ids);
    // the second site is at the right address, with another key
    fs::remove_file(folder.join("2.key")).unwrap();
    said(&run(&["keygen", folder.join("2.key").to_str().unwrap()]));
    let other = start(&second, "8");
    let first = summary(&start(&first, "8").wait_with_output().unwrap());
    let second = summary(&other.wait_with_output().unwrap());
    assert!(first["path"]["strangers"].as_u64().unwrap() > 0, "{first}");
    for site in [&first, &second] {
        assert_eq!([&site["largest_force"], &site["coupled_share"]], [0.0, 0.0], "{site}");
        assert_eq!([&site["path"]["connections"], &site["loss"]["received"]], [0, 0], "{site}");
        assert!(!events(site).contains(&"agreed"), "{site}");
    }
    // nothing fills the log, and both are told
    assert_eq!(events(&first), ["path-stranger", "partner-awaited", "ended"], "{first}");
    assert_eq!(events(&second), ["path-refused", "partner-awaited", "ended"], "{second}");
    // so do their checks say
    let [site, other] = write_sites(&folder, &ids);
    let checks = [&site, &other].map(|site| program().arg("check").arg(site).spawn().unwrap());
    let expected = [("warning", "was refused"), ("failed", "does not know")];
    for (check, (verdict, said)) in checks.into_iter().zip(expected) {
        let report = summary(&check.wait_with_output().unwrap());
        let items = report["items"].as_array().unwrap();
        let partner = items.iter().find(|item| item["item"] == "partner").unwrap();
        assert_eq!(partner["verdict"], verdict, "{report}");
        assert!(partner["found"].as_str().unwrap().contains(said), "{report}");
    }
}

#[test]
fn law_what_cannot_be_is_refused_at_the_door() {
    let (folder, ids) = folder("refusals");
    let [site, _] = write_sites(&folder, &ids);
    let good = fs::read_to_string(&site).unwrap();
    let two = format!("peer_id = [\"{}\", \"{0}\"]", ids[1]);
    let id = format!("peer_id = \"{}\"", ids[1]);
    let own = format!("peer_id = \"{}\"", ids[0]);
    let key = "key = \"1.key\"";
    for (from, to, said) in [
        ("transport = \"iroh\"", "transport = \"tcp\"", "unknown variant `tcp`"),
        ("transport = \"iroh\"", "", "network.key = given"),
        (key, "", "Missing network.key"),
        (key, "key = \"absent.key\"", "network.key"),
        (key, "key = \"connect.toml\"", "only its owner"),
        (&id, "", "Missing network.peer_id"),
        (&id, "peer_id = \"ab\"", "64 hexadecimal digits"),
        (&id, two.as_str(), "each id once"),
        (&id, own.as_str(), "the partner's id, not this site's"),
        ("local = \"", "local = \"[::1]:1\" # \"", "network.peer"),
        ("local = \"", "locale = \"", "unknown field `locale`"),
        ("local = \"127", "local = \"x127", "expected an address with a port, such as \"127.0.0.1:4500\""),
        ("local = \"", "local = [\"0.0.0.0:1\", \"0.0.0.0:2\"] # \"", "at most one address of IPv4"),
        ("peer = [\"", "peer = [\"0.0.0.0:1\", \"", "network.peer = 0.0.0.0:1"),
        ("peer = [\"", "peer = [\"127.0.0.1:0\", \"", "network.peer = 127.0.0.1:0"),
        ("peer = [\"", "peer = [\"224.0.0.1:5\", \"", "network.peer = 224.0.0.1:5"),
        (key, "key = \"1.key\"\nrelayed = true", "network.relayed"),
        (key, "key = \"1.key\"\nrelay_authority = \"connect.toml\"", "network.relay_authority = given"),
        (
            key,
            "key = \"1.key\"\nrelay = \"https://relay.example.org\"\nrelay_authority = \"connect.toml\"",
            "BEGIN CERTIFICATE",
        ),
        (key, "key = \"1.key\"\nrelay = \"relay.example.org\"", "network.relay"),
        (key, "key = \"1.key\"\nrelay = \"http://relay.example.org\"", "network.relay"),
        (key, "key = \"1.key\"\nrelay = \"https://a:b@relay.example.org\"", "network.relay"),
    ] {
        assert!(good.contains(from), "{from}");
        fs::write(&site, good.replacen(from, to, 1)).unwrap();
        let message = refusal(&["run", site.to_str().unwrap(), "--seconds", "1"]);
        assert!(message.contains(said), "{to}: {message}");
    }
    fs::write(&site, &good).unwrap();
    let key = folder.join("1.key");
    fs::set_permissions(&key, fs::Permissions::from_mode(0o644)).unwrap();
    let message = refusal(&["run", site.to_str().unwrap(), "--seconds", "1"]);
    assert!(message.contains("chmod 600"), "{message}");
    let message = refusal(&["keygen", key.to_str().unwrap()]);
    assert!(message.contains("never overwritten"), "{message}");
    let message = refusal(&["relay-config", "relay.example.org", "--id", "no id"]);
    assert!(message.contains("--id"), "{message}");
    // iroh-relay gets no certificate without an address, and would not start
    let message = refusal(&["relay-config", "relay.example.org", "--id", &ids[0]]);
    assert!(message.contains("--contact"), "{message}");
    for certificate in [&["--contact", "you@example.org"][..], &["--own-certificate"]] {
        let asked = ["relay-config", "relay.example.org", "--id", &ids[0], "--id", &ids[1]];
        let printed = said(&run(&[&asked[..], certificate].concat()));
        assert!(
            printed.contains(&ids[0]) && printed.contains(&ids[1]) && printed.contains("allowlist"),
            "{printed}"
        );
    }
}
