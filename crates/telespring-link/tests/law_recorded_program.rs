//! The program with a recording: killed, on a full disk, with viewers, and with its real-time priority.

mod recording;

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use recording::{read, whole};
use serde_json::Value;

fn program() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_telespring-link"));
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// A folder for one test, empty.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// The recordings of a folder: of side 1, of side 2.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort_by_key(|path| path.to_str().unwrap().split("-site").last().unwrap().to_owned());
    files
}

fn summary(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {output:?}"))
}

/// Waits until something holds, for a minute at most.
fn wait(mut holds: impl FnMut() -> bool) {
    let end = Instant::now() + Duration::from_secs(60);
    while !holds() {
        assert!(Instant::now() < end, "it does not come");
        std::thread::sleep(Duration::from_millis(20));
    }
}

fn signal(child: &Child, name: &str) {
    assert!(Command::new("kill").args([name, &child.id().to_string()]).status().unwrap().success());
}

fn record(folder: &Path, seconds: &str, more: &[&str]) -> Command {
    let mut command = program();
    command.args(["demo", "--delay", "0.02", "--seconds", seconds, "--record"]).arg(folder).args(more);
    command
}

#[test]
fn law_both_sides_of_a_session_are_recorded_whole() {
    let folder = folder("whole");
    let output = record(&folder, "2", &[]).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let summary = summary(&output);
    let files = files(&folder);
    assert_eq!(files.len(), 2);
    for (side, path) in (1_u8..).zip(&files) {
        let bytes = fs::read(path).unwrap();
        let file = read(&bytes);
        assert!(file.is_whole);
        let site = &summary["sites"][usize::from(side) - 1];
        assert_eq!(site["recording"]["path"], path.to_str().unwrap());
        assert_eq!(site["recording"]["status"], "complete");
        assert_eq!(site["recording"]["bytes"], bytes.len());
        // every tick of the loop, none twice
        let topic = format!("/site{side}/tick");
        let ticks: Vec<_> = file.of(&topic).collect();
        assert_eq!(site["recording"]["missed"], 0, "{site}");
        assert_eq!(site["lateness"]["ticks"], ticks.len());
        assert!((0..).zip(&ticks).all(|(number, tick)| whole(&tick.content, "tick") == Some(number)));
        let events: Vec<_> = file.events(side).into_iter().map(|(event, _)| event).collect();
        let said: Vec<_> =
            site["events"].as_array().unwrap().iter().map(|event| event["event"].as_str().unwrap()).collect();
        assert_eq!(events, said);
        // the partner says who it is
        let partner = files[2 - usize::from(side)].to_str().unwrap();
        let (_, session) = file.events(side).into_iter().find(|(event, _)| event == "agreed").unwrap();
        assert!(partner.contains(session.unwrap().trim_start_matches("0x")));
    }
}

#[test]
fn law_markers_of_the_command_line_are_in_the_record() {
    let folder = folder("marked");
    let marks = ["--trial", "7, eyes closed", "--condition", " 142 N/m", "--participant", "P-07"];
    for console in [&[][..], &["--console"]] {
        let output =
            record(&folder, "0.5", &[&marks[..], console].concat()).stdin(Stdio::null()).output().unwrap();
        // whether it came to a session in this time or not
        assert!([Some(0), Some(1)].contains(&output.status.code()), "{output:?}");
    }
    let files = files(&folder);
    assert_eq!(files.len(), 4);
    for path in files {
        let side = if path.to_str().unwrap().contains("-site1-") { 1 } else { 2 };
        let mut marks = read(&fs::read(&path).unwrap()).events(side);
        marks.retain(|(event, _)| event == "mark");
        let expected = ["participant P-07", "condition 142 N/m", "trial 7, eyes closed"];
        assert_eq!(marks, expected.map(|text| ("mark".to_owned(), Some(text.to_owned()))), "{path:?}");
    }
    for (option, text, said) in [
        ("--participant", "Anna", "--participant = Anna"),
        ("--condition", "für", "--condition = für"),
        ("--trial", " ", "--trial"),
    ] {
        let output = program().args(["demo", option, text]).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(message.contains(said), "{message}");
    }
}

#[test]
fn law_what_is_older_than_half_a_second_outlives_a_kill() {
    let folder = folder("killed");
    let mut child = record(&folder, "60", &[]).spawn().unwrap();
    // some chunks of both sides
    wait(|| files(&folder).iter().filter(|path| fs::metadata(path).unwrap().len() > 600_000).count() == 2);
    signal(&child, "-KILL");
    child.wait().unwrap();
    for (side, path) in (1_u8..).zip(files(&folder)) {
        let file = read(&fs::read(path).unwrap());
        assert!(!file.is_whole && !file.metadata.contains_key("end"));
        assert!(file.metadata.contains_key("telespring") && file.attachments.contains_key("study.toml"));
        let topic = format!("/site{side}/tick");
        let ticks: Vec<_> = file.of(&topic).collect();
        assert!((0..).zip(&ticks).all(|(number, tick)| whole(&tick.content, "tick") == Some(number)));
        assert!(file.chunks >= 3 && ticks.len() > 500, "{} {}", file.chunks, ticks.len());
        // by the loops' own clock, no chunk held much more than its time
        let mut spans: Vec<_> = file.spans.iter().map(|(first, last)| last - first).collect();
        spans.sort_unstable();
        assert!(spans[spans.len() / 2] < 500_000_000, "{spans:?}");
    }
}

#[test]
fn law_a_full_disk_ends_the_recording_and_not_the_session() {
    let folder = folder("full");
    let mounted =
        Command::new("mount").args(["-t", "tmpfs", "-o", "size=256k", "telespring"]).arg(&folder).output();
    if !mounted.is_ok_and(|output| output.status.success()) {
        eprintln!("SKIPPED: a small disk cannot be mounted here (root is needed)");
        return;
    }
    let output = record(&folder, "4", &[]).output();
    let whole: Vec<_> = files(&folder).iter().map(|path| read(&fs::read(path).unwrap())).collect();
    assert!(Command::new("umount").arg(&folder).status().unwrap().success());
    let output = output.unwrap();
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let summary = summary(&output);
    for (side, file) in whole.iter().enumerate() {
        let site = &summary["sites"][side];
        assert_eq!(site["recording"]["status"], "broken", "{site}");
        assert!(site["recording"]["cause"].as_str().unwrap().contains("No space left"), "{site}");
        assert!(site["coupled_share"].as_f64().unwrap() > 0.1, "{site}");
        let events = site["events"].as_array().unwrap();
        assert_eq!(events.iter().filter(|event| event["event"] == "recording-broken").count(), 1, "{site}");
        assert!(!file.is_whole && file.attachments.contains_key("study.toml"), "{side}");
    }
}

/// The threads of a process: name, whether of a real-time schedule.
fn threads(child: &Child) -> Vec<(String, bool)> {
    let tasks = fs::read_dir(format!("/proc/{}/task", child.id())).unwrap();
    let threads = tasks.filter_map(|task| {
        let text = fs::read_to_string(task.unwrap().path().join("stat")).ok()?;
        let (head, rest) = text.rsplit_once(')')?;
        // the schedule is field 41, counted from 1; the name is field 2
        let policy: u32 = rest.split_whitespace().nth(38)?.parse().ok()?;
        Some((head.split_once('(')?.1.to_owned(), policy != 0))
    });
    threads.collect()
}

#[test]
fn law_recorder_and_viewers_have_no_priority_and_take_no_signal() {
    let folder = folder("threads");
    let mut child = record(&folder, "60", &["--live", "127.0.0.1:0"]).spawn().unwrap();
    let count =
        |name: &str, threads: &[(String, bool)]| threads.iter().filter(|(known, _)| known == name).count();
    wait(|| files(&folder).iter().filter(|path| fs::metadata(path).unwrap().len() > 200_000).count() == 2);
    let threads = threads(&child);
    signal(&child, "-TERM");
    let status = child.wait().unwrap();
    let mut text = String::new();
    child.stdout.take().unwrap().read_to_string(&mut text).unwrap();
    let summary: Value = serde_json::from_str(&text).unwrap();
    // a signal ends the session in an orderly way
    assert_eq!(status.code(), Some(0), "{summary}");
    assert_eq!(summary["sites"][0]["cause"], "stop-requested");
    assert_eq!(summary["sites"][0]["recording"]["status"], "complete");
    assert_eq!(count("recording", &threads), 2, "{threads:?}");
    // both views and their server
    assert!(count("live view", &threads) >= 2, "{threads:?}");
    let urgent: Vec<_> =
        threads.iter().filter(|(_, is_urgent)| *is_urgent).map(|(name, _)| name.as_str()).collect();
    if summary["sites"][0]["real_time"]["priority"] == "granted" {
        assert!(!urgent.is_empty() && urgent.iter().all(|name| name.starts_with("site ")), "{urgent:?}");
    } else {
        eprintln!("SKIPPED in part: no real-time priority is granted here");
        assert!(urgent.is_empty(), "{urgent:?}");
    }
}
