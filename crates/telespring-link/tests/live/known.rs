//! Two sites that know each other's keys, each in its namespace: on a thread of the test, or as the real program.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use telespring::session::Span;
use telespring_link::keys::SiteKey;
use telespring_link::transport::{Iroh, IrohSettings};

use super::sites::over_iroh;
use super::{Live, study_text};
use crate::netns::{Joined, Path, Started, Way, at};

/// Where both sites listen.
pub const PORT: u16 = 4500;

/// Two namespaces, and what the sites in them are told.
#[derive(Debug)]
pub struct Known {
    pub joined: Joined,
    pub settings: [IrohSettings; 2],
    /// A partner that is silent for longer leads to a pause.
    pub silence: Span,
    /// Keys and site files.
    folder: PathBuf,
}

impl Known {
    /// Both, if this machine can have namespaces. A seed belongs to one test.
    pub fn new(way: Way, seed: u64) -> Option<Self> {
        let joined = Joined::new(way, seed)?;
        let name = format!("namespaces-{}-{seed}", std::process::id());
        let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("study.toml"), study_text()).unwrap();
        let keys = [1, 2].map(|side| SiteKey::create(&folder.join(format!("{side}.key"))).unwrap());
        let settings = [0, 1].map(|side: usize| IrohSettings {
            key: keys[side].clone(),
            peer_ids: vec![keys[1 - side].id()],
            peers: vec![at(1 - side, PORT)],
            local: vec![at(side, PORT)],
            relay: None,
            relay_authority: None,
            relayed: false,
            priority: None,
        });
        Some(Self { joined, settings, silence: Span(600_000_000_000), folder })
    }

    pub fn path(&self) -> &Path {
        &self.joined.path
    }

    /// Starts the site of side 0 or 1 on a thread.
    pub fn start(&self, side: usize) -> Live {
        let settings = self.settings[side].clone();
        Live::start(&self.joined, side, &study_text(), self.silence, move || Iroh::new(&settings).unwrap())
    }

    /// Both on threads, engaged.
    pub fn engaged(&self) -> [Live; 2] {
        let sites = [self.start(0), self.start(1)];
        sites.iter().for_each(|site| site.wait_engaged(300));
        sites
    }

    /// Starts the program `telespring-link run` as the site of side 0 or 1, for this long at most, s. Its summary is its output.
    pub fn program(&self, side: usize, seconds: f64) -> Started {
        let number = side + 1;
        let peer_id = self.settings[side].peer_ids[0].to_string();
        let text = format!(
            "{}\n\
             [safety]\nstall = 0.1\n\n[session]\nalignment = 10.0\nrest = 10.0\n\n\
             [fallback]\nloss = 1.0\nheld = 1.0\nage = 60.0\nsoftened = 1.0\npatience = 600.0\nsilence = {}\n\n\
             [loop]\npriority = 10\nlock_memory = false\n",
            over_iroh("study.toml", number, &peer_id, at(side, PORT), at(1 - side, PORT)),
            self.silence.seconds(),
        );
        let site = self.folder.join(format!("site-{number}.toml"));
        fs::write(&site, text).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_telespring-link"));
        command.arg("run").arg(site).args(["--seconds", &seconds.to_string()]);
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        self.joined.namespaces[side].start(&mut command)
    }
}

impl Drop for Known {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.folder);
    }
}
