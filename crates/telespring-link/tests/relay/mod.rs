//! iroh's own relay, with the configuration that the program prints, on an address of this machine.

use std::fs;
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU8, Ordering::Relaxed};
use std::time::{Duration, Instant};

use telespring_link::keys::SiteId;

/// Where the server program is.
const VARIABLE: &str = "TELESPRING_RELAY";
/// Each relay of a test has an address of its own, for its port for QUIC is fixed.
static NEXT: AtomicU8 = AtomicU8::new(1);

/// A relay that serves two sites only.
pub struct Relay {
    server: Child,
    /// What a site file names.
    pub url: String,
    /// The file of its authority.
    pub authority: PathBuf,
}

impl Relay {
    /// Starts a relay for these sites in a folder of its own; `None`, with a word, where something is missing.
    pub fn start(name: &str, ids: [SiteId; 2]) -> Option<Self> {
        let Some(program) = std::env::var_os(VARIABLE) else {
            eprintln!("SKIPPED: ${VARIABLE} does not say where iroh-relay is; make test-relay builds it");
            return None;
        };
        if Command::new("openssl").arg("version").stdout(Stdio::null()).status().is_err() {
            eprintln!("SKIPPED: openssl, which makes the relay's certificate, is missing");
            return None;
        }
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("relay-{name}"));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        let host = format!("127.83.{}.{}", std::process::id() % 250, NEXT.fetch_add(1, Relaxed));
        let port = || TcpListener::bind((host.as_str(), 0)).unwrap().local_addr().unwrap().port();
        let (https, http) = (port(), port());
        let printed = Command::new(env!("CARGO_BIN_EXE_telespring-link"))
            .args(["relay-config", &host, "--own-certificate"])
            .args(ids.iter().flat_map(|id| ["--id".to_owned(), id.to_string()]))
            .output()
            .unwrap();
        assert!(printed.status.success(), "{printed:?}");
        let printed = String::from_utf8(printed.stdout).unwrap();
        make_certificates(&printed, &folder);
        // nothing else is changed: these ports need rights, or are all addresses
        let mut configuration = printed;
        for (usual, here) in [("[::]:443", https), ("[::]:80", http), ("[::]:7842", 7842)] {
            assert!(configuration.contains(usual), "{usual}");
            configuration = configuration.replace(usual, &format!("{host}:{here}"));
        }
        fs::write(folder.join("relay.toml"), configuration).unwrap();
        let log = fs::File::create(folder.join("relay.log")).unwrap();
        let server = Command::new(program)
            .args(["--config-path", "relay.toml"])
            .current_dir(&folder)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(log)
            .spawn()
            .unwrap();
        let relay =
            Self { server, url: format!("https://{host}:{https}"), authority: folder.join("authority.pem") };
        relay.wait(&format!("{host}:{https}").parse().unwrap(), &folder);
        Some(relay)
    }

    /// Waits until it answers.
    fn wait(&self, address: &SocketAddr, folder: &Path) {
        let start = Instant::now();
        while TcpStream::connect_timeout(address, Duration::from_secs(1)).is_err() {
            let log = || fs::read_to_string(folder.join("relay.log")).unwrap_or_default();
            assert!(start.elapsed() < Duration::from_secs(30), "the relay does not answer: {}", log());
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

impl Drop for Relay {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// Runs the commands of OpenSSL that the configuration tells.
fn make_certificates(configuration: &str, folder: &Path) {
    let comments = configuration.lines().filter_map(|line| line.strip_prefix("#   "));
    let script: Vec<&str> = comments.skip_while(|line| !line.starts_with("openssl")).collect();
    assert!(script.len() >= 2, "{configuration}");
    let made = Command::new("sh").args(["-ec", &script.join("\n")]).current_dir(folder).output().unwrap();
    assert!(made.status.success(), "{script:?}: {made:?}");
}
