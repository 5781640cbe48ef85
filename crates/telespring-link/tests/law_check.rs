//! `telespring-link check`: what it finds, and that no force is commanded meanwhile.

use std::fs;
use std::net::UdpSocket;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use serde_json::Value;
use telespring::session::Motion;
use telespring_link::device::protocol::{Order, State};

const SECONDS: &str = "3";

fn check(site: &Path) -> Child {
    Command::new(env!("CARGO_BIN_EXE_telespring-link"))
        .arg("check")
        .arg(site)
        .args(["--seconds", SECONDS])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

fn report(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {output:?}"))
}

/// Verdict and finding of an item.
fn item<'a>(report: &'a Value, name: &str) -> (&'a str, &'a str) {
    let items = report["items"].as_array().unwrap();
    let item = items.iter().find(|item| item["item"] == name).unwrap_or_else(|| panic!("{name}: {report}"));
    assert_eq!(item["verdict"] == "ok", item.get("remedy").is_none(), "{item}");
    (item["verdict"].as_str().unwrap(), item["found"].as_str().unwrap())
}

/// Both site files of a study each, the first with a robot behind the device protocol, whose socket is returned.
fn sites(name: &str, stiffness: [f64; 2]) -> ([PathBuf; 2], UdpSocket) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples");
    let study = fs::read_to_string(examples.join("connect.toml")).unwrap();
    let sockets = [(); 4].map(|()| UdpSocket::bind("127.0.0.1:0").unwrap());
    let [one, two, link, device] = sockets.each_ref().map(|socket| socket.local_addr().unwrap());
    let [.., robot] = sockets;
    robot.connect(link).unwrap();
    let device =
        format!("[device]\nkind = \"udp\"\nlocal = \"{link}\"\ndevice = \"{device}\"\ndeadline = 1.0\n");
    let parts = [(one, two, device.as_str()), (two, one, "")];
    let paths = [0, 1].map(|index| {
        let (local, peer, device) = parts[index];
        let side = index + 1;
        let text = study.replace("stiffness = 100.0", &format!("stiffness = {}", stiffness[index]));
        fs::write(folder.join(format!("study-{side}.toml")), text).unwrap();
        let path = folder.join(format!("site-{side}.toml"));
        let network = format!("[network]\nlocal = \"{local}\"\npeer = \"{peer}\"\n");
        let site =
            format!("study = \"study-{side}.toml\"\nside = {side}\n{network}{device}[loop]\npriority = 10\n");
        fs::write(&path, site).unwrap();
        path
    });
    (paths, robot)
}

/// Sends a row per millisecond until `stop`; returns every command that came.
fn serve(robot: &UdpSocket, is_enabled: bool, stop: &AtomicBool) -> Vec<Order> {
    robot.set_nonblocking(true).unwrap();
    let (mut orders, mut sequence) = (Vec::new(), 0.0);
    let mut row = [0; 100];
    while !stop.load(Ordering::Relaxed) {
        sequence += 1.0;
        let state = State {
            sequence,
            time: sequence * 1e-3,
            motion: Motion { position: [0.05, 0.0], velocity: [0.1, 0.0] },
            measured_force: None,
            is_enabled,
            is_homed: true,
            is_stopped: false,
        };
        // nobody may listen yet
        let _ = robot.send(&state.encode());
        while let Ok(length) = robot.recv(&mut row) {
            orders.extend(Order::decode(&row[..length]));
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    orders
}

/// Both checks at a time, beside a robot; their outputs and the commands that the robot saw.
fn both(paths: &[PathBuf; 2], robot: &UdpSocket, is_enabled: bool) -> ([Output; 2], Vec<Order>) {
    let stop = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let robot = scope.spawn(|| serve(robot, is_enabled, &stop));
        let outputs = paths.each_ref().map(|path| check(path)).map(|child| child.wait_with_output().unwrap());
        stop.store(true, Ordering::Relaxed);
        (outputs, robot.join().unwrap())
    })
}

#[test]
fn law_a_check_finds_device_and_partner_and_commands_zero_only() {
    let (paths, robot) = sites("check", [100.0; 2]);
    let (outputs, orders) = both(&paths, &robot, true);
    assert!(orders.len() > 100, "{}", orders.len());
    for order in &orders {
        assert_eq!((order.force, order.is_running), ([0.0; 2], false));
    }
    for (output, side) in outputs.iter().zip(1..) {
        let report = report(output);
        assert_eq!((&report["schema"], &report["side"]), (&1.into(), &side.into()));
        assert_eq!(item(&report, "site-file").0, "ok");
        assert_eq!(item(&report, "network").0, "ok");
        assert_eq!(item(&report, "partner"), ("ok", "it is there and agrees on every term"));
        assert!(item(&report, "loop").1.contains(" ticks, "), "{report}");
        assert!(report["lateness"]["ticks"].as_u64().unwrap() > 100, "{report}");
        item(&report, "privileges");
        // how a busy machine keeps time is its own affair
        let is_failed = report["verdict"] == "failed";
        assert_eq!(output.status.code(), Some(i32::from(is_failed)), "{report}");
    }
    let report = report(&outputs[0]);
    let (_, found) = item(&report, "device");
    assert!(found.contains("rows per second"), "{report}");
    assert!(!found.contains("not ready"), "{report}");
}

#[test]
fn law_a_check_says_what_is_missing() {
    let (paths, robot) = sites("check-missing", [100.0, 101.0]);
    let (outputs, _) = both(&paths, &robot, false);
    let [first, second] = outputs.each_ref().map(report);
    for (report, [here, there]) in [(&first, [100, 101]), (&second, [101, 100])] {
        let found = format!(
            "it is there, and disagrees on: coupling: {here} N/m and 0 N·s/m here, {there} N/m and 0 N·s/m there"
        );
        assert_eq!(item(report, "partner"), ("failed", found.as_str()));
        assert_eq!(report["verdict"], "failed");
    }
    assert!(outputs.iter().all(|output| output.status.code() == Some(1)), "{outputs:?}");
    let (verdict, found) = item(&first, "device");
    assert_eq!(verdict, "warning", "{found}");
    assert!(found.ends_with("the robot is not ready: its motors are not enabled"), "{found}");
    // nobody there at all
    let output = check(&paths[0]).wait_with_output().unwrap();
    let alone = report(&output);
    let (device, partner) = (item(&alone, "device"), item(&alone, "partner"));
    assert_eq!((device.0, device.1), ("failed", "no row of data came"));
    assert_eq!((partner.0, partner.1), ("warning", "nobody listens at its address yet"));
}

#[test]
fn law_a_check_of_a_taken_port_is_a_finding_and_of_a_wrong_file_a_refusal() {
    let ([site, _], _robot) = sites("check-taken", [100.0; 2]);
    let text = fs::read_to_string(&site).unwrap();
    let taken = UdpSocket::bind("127.0.0.1:0").unwrap();
    let line = text.lines().find(|line| line.starts_with("local")).unwrap();
    let other = format!("local = \"{}\"", taken.local_addr().unwrap());
    fs::write(&site, text.replacen(line, &other, 1)).unwrap();
    let output = check(&site).wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let taken_report = report(&output);
    assert_eq!(item(&taken_report, "network").0, "failed");
    assert!(taken_report["lateness"].is_null());
    fs::write(&site, text.replace("side = 1", "side = 3")).unwrap();
    let output = check(&site).wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("side = 3"));
}
