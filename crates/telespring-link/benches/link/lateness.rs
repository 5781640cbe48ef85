//! How late the loops of two sites begin their ticks, beside cyclictest's two threads, in turns; and what two sites cost.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use telespring_link::demo::ROBOTS;
use telespring_link::keys::SiteKey;

use super::sites::over_iroh;
use super::{Failure, median};

const PROGRAM: &str = env!("CARGO_BIN_EXE_telespring-link");
const SESSION: &str = "\
coupling.stiffness = 100
network = {delay = 0.005}
session = {strategy = \"guard\", playout = \"adaptive\"}
";

/// What a round of two sites tells.
struct Round {
    /// 99 of 100 ticks began no later than this, s; the later of the two.
    late: f64,
    overruns: f64,
    /// The share of a core per site.
    load: f64,
}

/// 99 of 100 wake-ups of cyclictest's two threads were no later than this, s; `None` where it is missing.
fn cyclictest(seconds: u64) -> Result<Option<f64>, Failure> {
    let loops = (1000 * seconds).to_string();
    let output = Command::new("cyclictest")
        .args(["--quiet", "--mlockall", "--priority=80", "--threads=2", "--interval=1000", "--distance=0"])
        .args([format!("--loops={loops}"), "--histogram=100000".to_owned()])
        .output();
    let output = match output {
        Ok(output) if output.status.success() => String::from_utf8(output.stdout)?,
        Ok(output) => return Err(String::from_utf8_lossy(&output.stderr).into_owned().into()),
        Err(error) => {
            eprintln!("SKIPPED lateness: no cyclictest here ({error}); Debian's package is rt-tests");
            return Ok(None);
        }
    };
    let mut counts: Vec<(u64, u64)> = Vec::new();
    for line in output.lines().filter(|line| line.starts_with(|first: char| first.is_ascii_digit())) {
        let mut numbers = line.split_whitespace().filter_map(|number| number.parse::<u64>().ok());
        if let Some(late) = numbers.next() {
            counts.push((late, numbers.sum()));
        }
    }
    let all: u64 = counts.iter().map(|(_, count)| count).sum();
    let mut seen = 0;
    let found = counts.iter().find(|(_, count)| {
        seen += count;
        100 * seen >= 99 * all
    });
    Ok(found.map(|(late, _)| *late as f64 * 1e-6))
}

/// Two sites over iroh on this machine.
fn sites(folder: &Path, seconds: u64) -> Result<Round, Failure> {
    let mut children: Vec<Child> = Vec::new();
    for side in [1, 2] {
        let site = folder.join(format!("site-{side}.toml"));
        let length = if side == 1 { seconds } else { seconds + 20 };
        children.push(
            Command::new(PROGRAM)
                .arg("run")
                .arg(site)
                .args(["--seconds", &length.to_string()])
                .stdout(Stdio::piped())
                .spawn()?,
        );
    }
    let before = used()?;
    let mut round = Round { late: 0.0, overruns: 0.0, load: 0.0 };
    let mut length = 0.0_f64;
    for child in children {
        let output = child.wait_with_output()?;
        let summary: serde_json::Value = serde_json::from_slice(&output.stdout)?;
        let number = |key: &str| summary["lateness"][key].as_f64().ok_or("no lateness");
        round.late = round.late.max(number("quantile_99")?);
        round.overruns += number("overruns")?;
        length = length.max(summary["seconds"].as_f64().unwrap_or(f64::NAN));
        if summary["real_time"]["priority"] != "granted" {
            eprintln!("no real-time priority was granted: lateness is that of an ordinary thread");
        }
    }
    round.load = (used()? - before) / length / 2.0;
    Ok(round)
}

/// The processor time that ended children of this process have used, s.
fn used() -> Result<f64, Failure> {
    let state = fs::read_to_string("/proc/self/stat")?;
    let (_, rest) = state.rsplit_once(')').ok_or("no state")?;
    let fields: Vec<&str> = rest.split_whitespace().collect();
    let ticks: u64 =
        fields.get(13..15).ok_or("no times")?.iter().filter_map(|field| field.parse::<u64>().ok()).sum();
    // clock ticks per second, 100 on every Linux of today
    Ok(ticks as f64 / 100.0)
}

/// Prints lateness, ratio, overruns and load: the medians of these rounds.
pub fn compare(rounds: usize, seconds: u64) -> Result<(), Failure> {
    let folder = std::env::temp_dir().join(format!("telespring-link-bench-{}", std::process::id()));
    fs::create_dir_all(&folder)?;
    fs::write(folder.join("study.toml"), format!("{ROBOTS}{SESSION}"))?;
    let keys = [1, 2].map(|side| SiteKey::create(&folder.join(format!("{side}.key"))));
    let [first, second] = keys;
    let ids = [first?.id(), second?.id()];
    let places = {
        let sockets = [std::net::UdpSocket::bind("127.0.0.1:0")?, std::net::UdpSocket::bind("127.0.0.1:0")?];
        [sockets[0].local_addr()?, sockets[1].local_addr()?]
    };
    for side in 0..2 {
        let peer_id = ids[1 - side].to_string();
        let text = over_iroh("study.toml", side + 1, &peer_id, places[side], places[1 - side]);
        fs::write(folder.join(format!("site-{}.toml", side + 1)), text)?;
    }
    let (mut theirs, mut ours) = (Vec::new(), Vec::new());
    for _ in 0..rounds {
        let Some(late) = cyclictest(seconds)? else { break };
        theirs.push(late);
        ours.push(sites(&folder, seconds)?);
    }
    fs::remove_dir_all(&folder)?;
    if theirs.is_empty() {
        return Ok(());
    }
    let [late, theirs] = [median(ours.iter().map(|round| round.late)), median(theirs.into_iter())];
    println!(
        "lateness, 99 of 100 below: loop {:.0} µs, cyclictest {:.0} µs, ratio {:.2} (target 1.3)",
        1e6 * late,
        1e6 * theirs,
        late / theirs
    );
    println!(
        "ticks left out per {seconds} s and two sites: {:.0}",
        median(ours.iter().map(|round| round.overruns))
    );
    println!(
        "load per site: {:.1} % of a core (target 10)",
        100.0 * median(ours.iter().map(|round| round.load))
    );
    Ok(())
}
