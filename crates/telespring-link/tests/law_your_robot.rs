//! docs/your-robot.md as a newcomer follows it: its commands in terminals, its orders typed.

#![allow(unsafe_code, reason = "no safe crate here opens a terminal")]

use std::fs::{self, File};
use std::io::{Read, Write};
use std::net::UdpSocket;
use std::os::fd::{FromRawFd, OwnedFd};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// A busy machine takes its time.
const PATIENCE: Duration = Duration::from_secs(120);

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The commands of the page, in their order.
fn commands() -> Vec<Vec<String>> {
    let page = fs::read_to_string(root().join("docs/your-robot.md")).unwrap();
    let is_command = |line: &&str| {
        line.starts_with("    target/release/telespring-link ") || line.starts_with("    python ")
    };
    page.lines().filter(is_command).map(|line| line.split_whitespace().map(str::to_owned).collect()).collect()
}

/// A folder with the examples, on ports that are free now; those of the page are 4500, 4502, 4600 and 4601.
fn folder() -> (PathBuf, impl Fn(&[String]) -> Vec<String>) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("your-robot");
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(folder.join("examples")).unwrap();
    let sockets = [(); 4].map(|()| UdpSocket::bind("127.0.0.1:0").unwrap());
    let free = sockets.each_ref().map(|socket| socket.local_addr().unwrap().port());
    let on_free_ports = move |text: &str| {
        [4500, 4502, 4600, 4601].iter().zip(free).fold(text.to_owned(), |text, (port, free)| {
            text.replace(&format!("127.0.0.1:{port}"), &format!("127.0.0.1:{free}"))
        })
    };
    for name in ["connect.toml", "site-1.toml", "site-2.toml", "device.py"] {
        let mut text = on_free_ports(&fs::read_to_string(root().join("examples").join(name)).unwrap());
        if name.starts_with("site") {
            // a busy machine stands still for long
            text = text.replace("kind = \"udp\"", "kind = \"udp\"\ndeadline = 1.0")
                + "\n[safety]\nstall = 0.5\n";
        }
        fs::write(folder.join("examples").join(name), text).unwrap();
    }
    (folder, move |words: &[String]| words.iter().map(|word| on_free_ports(word)).collect())
}

/// A program in a terminal of its own.
struct Terminal {
    child: Child,
    keys: File,
    said: Arc<Mutex<String>>,
}

impl Terminal {
    /// Starts a command of the page.
    fn start(folder: &Path, words: &[String]) -> Self {
        let program = match words[0].as_str() {
            "python" => "python3",
            _ => env!("CARGO_BIN_EXE_telespring-link"),
        };
        let (mut master, mut slave) = (0, 0);
        let nothing = std::ptr::null_mut();
        // SAFETY: both numbers outlive the call, which writes the descriptors of a new terminal there; the rest may be null.
        let outcome = unsafe {
            libc::openpty(&raw mut master, &raw mut slave, nothing, std::ptr::null(), std::ptr::null())
        };
        assert_eq!(outcome, 0, "{}", std::io::Error::last_os_error());
        // SAFETY: the call above has opened them, and nobody else owns them.
        let (keys, slave) = unsafe { (File::from_raw_fd(master), OwnedFd::from_raw_fd(slave)) };
        let [input, output, errors] = [(); 3].map(|()| Stdio::from(slave.try_clone().unwrap()));
        let child = Command::new(program)
            .args(&words[1..])
            .current_dir(folder)
            .stdin(input)
            .stdout(output)
            .stderr(errors)
            .spawn()
            .unwrap();
        drop(slave);
        let said = Arc::new(Mutex::new(String::new()));
        let (mut screen, all) = (keys.try_clone().unwrap(), Arc::clone(&said));
        // the terminal is gone with the program
        std::thread::spawn(move || {
            let mut room = [0; 4096];
            while let Ok(length @ 1..) = screen.read(&mut room) {
                all.lock().unwrap().push_str(&String::from_utf8_lossy(&room[..length]));
            }
        });
        Self { child, keys, said }
    }

    fn said(&self) -> String {
        self.said.lock().unwrap().clone()
    }

    fn type_line(&mut self, line: &str) {
        writeln!(self.keys, "{line}").unwrap();
    }

    /// Waits until it says something new that `is_it`.
    fn wait(&self, after: usize, what: &str) -> usize {
        let start = Instant::now();
        loop {
            let said = self.said();
            if let Some(at) = said[after..].find(what) {
                return after + at + what.len();
            }
            assert!(start.elapsed() < PATIENCE, "waiting for {what:?}: {said}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Consents until both are coupled: a busy machine may let a device stand still, and then both are asked anew.
    fn couple(&mut self, after: usize) -> usize {
        let start = Instant::now();
        loop {
            self.type_line("consent");
            std::thread::sleep(Duration::from_millis(500));
            if let Some(at) = self.said()[after..].find(" running") {
                return after + at;
            }
            assert!(start.elapsed() < PATIENCE, "it does not run: {}", self.said());
        }
    }

    /// Waits for its end, and returns what it said.
    fn end(mut self) -> String {
        let start = Instant::now();
        loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                std::thread::sleep(Duration::from_millis(200));
                assert!(status.success(), "{status}: {}", self.said());
                return self.said();
            }
            assert!(start.elapsed() < PATIENCE, "it does not end: {}", self.said());
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        // a test that has failed leaves nothing behind
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The way of site 1's handle in a line such as "move the handle of site 1 by 26 mm in x and -89 mm in y, or …", mm.
fn way(line: &str) -> [f64; 2] {
    let (_, rest) = line.split_once("move the handle of site 1 by ").unwrap();
    let (own, _) = rest.split_once(", or").unwrap();
    let words: Vec<&str> = own.split_whitespace().collect();
    ["x", "y"].map(|axis| {
        let place = words.iter().position(|word| *word == axis);
        place.map_or(0.0, |place| words[place - 3].parse().unwrap())
    })
}

#[test]
fn law_the_page_leads_from_nothing_to_a_session_and_through_a_pause() {
    let commands = commands();
    let [device, partner, site, keygen_1, keygen_2, check] = &commands[..] else { panic!("{commands:?}") };
    let (folder, on_free_ports) = folder();
    if Command::new("python3").arg("--version").output().is_err() {
        eprintln!("SKIPPED: there is no python3 for the page docs/your-robot.md");
        return;
    }
    let start = |words: &[String]| Terminal::start(&folder, &on_free_ports(words));

    for keygen in [keygen_1, keygen_2] {
        assert_eq!(start(keygen).end().trim().len(), 64);
    }
    let mut device = start(device);
    // a person takes longer than a device program used to wait
    std::thread::sleep(Duration::from_secs(6));
    let found = {
        let mut check = start(check);
        check.child.wait().unwrap();
        std::thread::sleep(Duration::from_millis(200));
        check.said()
    };
    // on a busy machine the device is slow, and the loop late
    assert!(found.contains("rows per second") && !found.contains("no row"), "{found}");
    let partner = start(partner);
    let mut site = start(site);
    let mut at = site.wait(0, "consenting");
    site.type_line("consnt");
    at = site.wait(at, "no such order: \"consnt\". The orders are consent, ");
    at = site.couple(at);
    site.type_line("pause");
    at = site.wait(at, " paused");
    site.type_line("resume");
    at = site.wait(at, " aligning");
    // whatever the offset, the hand goes there; it is told anew while it changes
    let start = Instant::now();
    let mut told = at;
    while !site.said()[at..].contains("consenting") {
        assert!(start.elapsed() < PATIENCE, "{}", site.said());
        let said = site.said();
        if let Some(offset) = said[told..].find("move the handle of site 1")
            && let Some(length) = said[told + offset..].find('\n')
        {
            let [x, y] = way(&said[told + offset..told + offset + length]);
            told += offset + length;
            device.type_line(&format!("{x} {y}"));
        }
        std::thread::sleep(Duration::from_millis(100));
    }
    site.couple(at);
    site.type_line("stop");
    let said = site.end();
    assert!(said.contains("ended: stop-requested") && said.contains("coupled for "), "{said}");
    assert!(partner.end().contains("ended: partner-left"));
    assert!(device.end().contains(" N at most"));
}
