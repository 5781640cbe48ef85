//! Two programs that probe the path between them, as people and programs start them.

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::net::UdpSocket;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use serde_json::Value;
use telespring::rig::{Trace, trace::IrttDelay};

/// Both site files, in a folder of their own.
fn sites(name: &str) -> [PathBuf; 2] {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("probe-{name}"));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples");
    fs::copy(examples.join("connect.toml"), folder.join("connect.toml")).unwrap();
    let sockets = [(); 2].map(|()| UdpSocket::bind("127.0.0.1:0").unwrap());
    let addresses = sockets.map(|socket| socket.local_addr().unwrap());
    [0, 1].map(|side: usize| {
        let path = folder.join(format!("site-{}.toml", side + 1));
        let (local, peer) = (addresses[side], addresses[1 - side]);
        let text = format!(
            "study = \"connect.toml\"\nside = {}\n[network]\nlocal = \"{local}\"\npeer = \"{peer}\"\n",
            side + 1
        );
        fs::write(&path, text).unwrap();
        path
    })
}

fn probe(site: &Path, seconds: &str, more: &[&str]) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_telespring-link"));
    command.arg("probe").arg(site).args(["--seconds", seconds]).args(more);
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

/// What a probe with a console said at last, and what it complained of.
fn last(child: &mut Child) -> (Value, String) {
    let lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let found = serde_json::from_str(&lines.map(Result::unwrap).last().unwrap()).unwrap();
    let mut errors = String::new();
    child.stderr.take().unwrap().read_to_string(&mut errors).unwrap();
    (found, errors)
}

/// Reads lines until one says this.
fn wait_for_line(child: &mut Child, said: &str) {
    // byte by byte, so that what comes after it is there for the next reader
    let output = child.stdout.as_mut().unwrap();
    let mut line = String::new();
    while !line.contains(said) {
        let mut byte = [0];
        output.read_exact(&mut byte).unwrap();
        if byte == *b"\n" {
            line.clear();
        } else {
            line.push(char::from(byte[0]));
        }
    }
}

#[test]
fn law_two_probes_know_both_ways_and_write_what_telespring_trace_reads() {
    let [first, second] = sites("both");
    let trace = first.with_file_name("path.json");
    let other = probe(&second, "1.5", &[]);
    let output = probe(&first, "1.5", &["--trace", trace.to_str().unwrap()]).wait_with_output().unwrap();
    assert!(output.status.success(), "{output:?}");
    assert!(other.wait_with_output().unwrap().status.success());
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!([&found["type"], &found["end"]], ["summary", "complete"]);
    assert_eq!(found["side"], 1);
    let text = fs::read_to_string(&trace).unwrap();
    for (delay, way) in [(IrttDelay::Send, "towards_partner"), (IrttDelay::Receive, "towards_here")] {
        let rows = Trace::from_irtt(&text, delay).unwrap().rows().len();
        assert_eq!(found[way]["sent"].as_u64(), Some(rows as u64), "{found}");
    }
    // a file that is there is not written over
    let output = probe(&first, "1", &["--trace", trace.to_str().unwrap()]).wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    assert_eq!(fs::read_to_string(&trace).unwrap(), text);
}

#[test]
fn law_whoever_watched_a_probe_may_go_and_it_ends_and_tells() {
    // while it waits, and in the middle of a measurement
    let [first, second] = sites("parent");
    let mut alone = probe(&first, "600", &["--console"]);
    wait_for_line(&mut alone, "\"stage\":\"waiting\"");
    drop(alone.stdin.take());
    let (found, errors) = last(&mut alone);
    assert_eq!(found["end"], "stopped", "{found}");
    assert!(errors.contains("Nobody answered"), "{errors}");
    assert_eq!(alone.wait().unwrap().code(), Some(1));
    let [mut one, mut other] = [&first, &second].map(|site| probe(site, "600", &["--console"]));
    let _watched = other.stdin.take();
    wait_for_line(&mut one, "\"stage\":\"measuring\"");
    drop(one.stdin.take());
    for child in [&mut one, &mut other] {
        let (found, errors) = last(child);
        assert_eq!([&found["type"], &found["end"]], ["summary", "complete"], "{found} {errors}");
        assert!(child.wait().unwrap().success());
    }
}

#[test]
fn law_a_probe_whose_partner_is_killed_tells_the_way_that_it_knows() {
    let [first, second] = sites("killed");
    let mut stays = probe(&first, "3", &["--console"]);
    let mut dies = probe(&second, "3", &["--console"]);
    let _watched = [stays.stdin.take(), dies.stdin.take()];
    wait_for_line(&mut stays, "\"stage\":\"measuring\"");
    std::thread::sleep(std::time::Duration::from_millis(800));
    dies.kill().unwrap();
    dies.wait().unwrap();
    let (found, errors) = last(&mut stays);
    assert_eq!(stays.wait().unwrap().code(), Some(1));
    assert_eq!(found["end"], "partner-silent", "{found}");
    assert!(
        found["towards_partner"].is_null() && found["towards_here"]["received"].as_u64() > Some(100),
        "{found}"
    );
    assert!(errors.contains("fell silent"), "{errors}");
}
