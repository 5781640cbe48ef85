//! The key of a site, in a file that only its owner may read, and the public ids of partners.
//!
//! A site is its ed25519 key. The file has one line: `telespring-key-1`, a blank, and the 32 secret bytes as 64 hexadecimal
//! digits. The public id, by which partners know the site, follows from it: 64 hexadecimal digits, too.

use std::fmt;
use std::fs::{OpenOptions, Permissions};
use std::io::{Read, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::Path;
use std::str::FromStr;

use iroh::{PublicKey, SecretKey};
use rustix::fs::OFlags;
use telespring::InvalidInput;

/// What stands before the digits: the version of the file.
const VERSION: &str = "telespring-key-1";
/// More bytes than a key file has.
const MOST_BYTES: u64 = 256;
/// Group and others.
const OF_OTHERS: u32 = 0o077;
const NEW_KEY: &str = "Make one with telespring-link keygen.";

/// The secret key of a site. It is never printed.
#[derive(Clone)]
pub struct SiteKey(SecretKey);

impl fmt::Debug for SiteKey {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "SiteKey of {}", self.id())
    }
}

/// The public id of a site.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct SiteId(PublicKey);

impl fmt::Display for SiteId {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}", self.0)
    }
}

impl FromStr for SiteId {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let is_digits = text.len() == 64 && text.bytes().all(|byte| byte.is_ascii_hexdigit());
        let id = if is_digits { text.parse().ok() } else { None };
        id.map(Self).ok_or("an id is the 64 hexadecimal digits that telespring-link id prints")
    }
}

impl SiteId {
    pub(crate) fn public(self) -> PublicKey {
        self.0
    }
}

impl From<PublicKey> for SiteId {
    fn from(public: PublicKey) -> Self {
        Self(public)
    }
}

/// The ids of an allow-list: at least one, no more than 16, none twice.
///
/// # Errors
///
/// [`InvalidInput`] with `field` and the entry that is no id.
pub fn parse_ids(field: &str, texts: &[String]) -> Result<Vec<SiteId>, InvalidInput> {
    let mut ids = Vec::with_capacity(texts.len().min(16));
    for text in texts {
        let id: SiteId = text.parse().map_err(|allowed| {
            InvalidInput::new(field, format!("{text:?}"), allowed, "Ask the partner for this line.")
        })?;
        if ids.contains(&id) {
            return Err(InvalidInput::new(field, id, "each id once", "Remove one of the two."));
        }
        ids.push(id);
    }
    if ids.is_empty() {
        return Err(InvalidInput::missing(
            field,
            "the partner's id",
            "Ask the partner for the line of telespring-link id.",
        ));
    }
    if ids.len() > 16 {
        return Err(InvalidInput::new(field, ids.len(), "at most 16 ids", "Name those who take part."));
    }
    Ok(ids)
}

impl SiteKey {
    /// A new key, drawn by the kernel's random numbers.
    pub fn generate() -> Self {
        Self(SecretKey::generate())
    }

    /// The public id.
    pub fn id(&self) -> SiteId {
        SiteId(self.0.public())
    }

    pub(crate) fn secret(&self) -> SecretKey {
        self.0.clone()
    }

    /// Draws a key and writes it into a new file that only its owner may read.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if there is such a file already, or it cannot be written.
    pub fn create(path: &Path) -> Result<Self, InvalidInput> {
        let refuse = |error: std::io::Error| {
            let (allowed, remedy) = if error.kind() == std::io::ErrorKind::AlreadyExists {
                ("there is a file already, and a key is never overwritten".to_owned(), "Give another path.")
            } else {
                (format!("the file cannot be written ({error})"), "Give a path in a folder of your own.")
            };
            InvalidInput::new("key", path.display(), allowed, remedy)
        };
        let key = Self::generate();
        let mut options = OpenOptions::new();
        // create_new: no file and no link of somebody else is written through
        let mut file = options.write(true).create_new(true).mode(0o600).open(path).map_err(refuse)?;
        let digits: String = key.0.to_bytes().iter().map(|byte| format!("{byte:02x}")).collect();
        // whatever the mask of the process says
        file.set_permissions(Permissions::from_mode(0o600))
            .and_then(|()| writeln!(file, "{VERSION} {digits}"))
            .and_then(|()| file.sync_all())
            .map_err(|error| {
                // half a key would be in the way of a whole one
                let _ = std::fs::remove_file(path);
                refuse(error)
            })?;
        Ok(key)
    }

    /// Reads a key from a file that nobody but its owner may read or write. A link counts as the file that it leads to.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] with `field` if there is no such file, others may read it, or it is no key.
    pub fn read(field: &str, path: &Path) -> Result<Self, InvalidInput> {
        let refuse =
            |allowed: String, remedy: &str| InvalidInput::new(field, path.display(), allowed, remedy);
        let unreadable = |error| refuse(format!("the file cannot be read ({error})"), NEW_KEY);
        // a pipe must not hold the program up before it is known as such
        let mut options = OpenOptions::new();
        let flags = OFlags::NONBLOCK.bits().cast_signed();
        let file = options.read(true).custom_flags(flags).open(path).map_err(unreadable)?;
        // of the open file, so that nobody exchanges it in between
        let facts = file.metadata().map_err(unreadable)?;
        if !facts.is_file() {
            return Err(refuse("a file".to_owned(), NEW_KEY));
        }
        if facts.mode() & OF_OTHERS != 0 {
            let mode = facts.mode() & 0o777;
            let allowed = format!("only its owner may read or write a key, and its mode is {mode:03o}");
            let remedy = "chmod 600 it, and make a new key if somebody may have read it.";
            return Err(refuse(allowed, remedy));
        }
        let mut text = String::new();
        let bytes = file.take(MOST_BYTES).read_to_string(&mut text);
        let digits = bytes.ok().and_then(|_| text.trim_end().strip_prefix(VERSION)?.strip_prefix(' '));
        let secret = digits.and_then(decode);
        // what stands in the file is not repeated: it may be nearly a key
        secret
            .map(|secret| Self(SecretKey::from_bytes(&secret)))
            .ok_or_else(|| refuse(format!("one line: {VERSION}, a blank and 64 hexadecimal digits"), NEW_KEY))
    }
}

/// 32 bytes from 64 hexadecimal digits.
fn decode(digits: &str) -> Option<[u8; 32]> {
    let mut bytes = [0; 32];
    if digits.len() != 64 || !digits.bytes().all(|digit| digit.is_ascii_hexdigit()) {
        return None;
    }
    for (byte, at) in bytes.iter_mut().zip((0..).step_by(2)) {
        *byte = u8::from_str_radix(digits.get(at..at + 2)?, 16).ok()?;
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A folder for one test, empty.
    fn folder(name: &str) -> std::path::PathBuf {
        let folder = std::env::temp_dir().join(format!("telespring-keys-{}-{name}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        folder
    }

    fn set_mode(path: &Path, mode: u32) {
        std::fs::set_permissions(path, Permissions::from_mode(mode)).unwrap();
    }

    #[test]
    fn law_a_key_comes_back_and_is_the_owners_alone() {
        let folder = folder("round");
        let path = folder.join("site.key");
        let key = SiteKey::create(&path).unwrap();
        assert_eq!(std::fs::metadata(&path).unwrap().mode() & 0o777, 0o600);
        let again = SiteKey::read("key", &path).unwrap();
        assert_eq!(again.id(), key.id());
        assert_eq!(again.secret().to_bytes(), key.secret().to_bytes());
        assert_eq!(key.id().to_string().parse(), Ok(key.id()));
        // two keys are two sites
        assert_ne!(SiteKey::generate().id(), key.id());
        // nothing prints the secret
        let text = std::fs::read_to_string(&path).unwrap();
        let secret = text.trim_end().split(' ').nth(1).unwrap();
        assert!(!format!("{key:?}").contains(secret));
        // a link counts as what it leads to
        let link = folder.join("link.key");
        std::os::unix::fs::symlink(&path, &link).unwrap();
        assert_eq!(SiteKey::read("key", &link).unwrap().id(), key.id());
        // neither a key nor a link is overwritten
        for taken in [&path, &link] {
            let refusal = SiteKey::create(taken).unwrap_err().to_string();
            assert!(refusal.contains("never overwritten"), "{refusal}");
        }
        assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn law_a_key_that_others_may_read_is_refused() {
        let folder = folder("modes");
        let path = folder.join("site.key");
        SiteKey::create(&path).unwrap();
        let link = folder.join("link.key");
        std::os::unix::fs::symlink(&path, &link).unwrap();
        for mode in [0o640, 0o604, 0o620, 0o602, 0o601, 0o644] {
            set_mode(&path, mode);
            for path in [&path, &link] {
                let refusal = SiteKey::read("network.key", path).unwrap_err().to_string();
                assert!(
                    refusal.contains("network.key") && refusal.contains(&format!("{mode:03o}")),
                    "{refusal}"
                );
                assert!(refusal.contains("chmod 600"), "{refusal}");
            }
        }
        set_mode(&path, 0o400);
        assert!(SiteKey::read("key", &path).is_ok());
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn law_what_is_no_key_is_refused_and_not_repeated() {
        let folder = folder("contents");
        let path = folder.join("site.key");
        let digits = "ab".repeat(32);
        for content in [
            String::new(),
            digits.clone(),
            format!("telespring-key-2 {digits}"),
            format!("telespring-key-1 {}", &digits[1..]),
            format!("telespring-key-1 {digits}0"),
            format!("telespring-key-1 {digits}\n{digits}"),
            format!("telespring-key-1 +{}", &digits[1..]),
            format!("telespring-key-1{digits}"),
            "x".repeat(1 << 20),
        ] {
            std::fs::write(&path, content).unwrap();
            set_mode(&path, 0o600);
            let refusal = SiteKey::read("network.key", &path).unwrap_err().to_string();
            assert!(refusal.contains("64 hexadecimal digits") && !refusal.contains("abab"), "{refusal}");
        }
        std::fs::write(&path, format!("telespring-key-1 {digits}\n")).unwrap();
        assert!(SiteKey::read("network.key", &path).is_ok());
        let pipe = folder.join("pipe");
        let mode = rustix::fs::Mode::from_raw_mode(0o600);
        rustix::fs::mknodat(rustix::fs::CWD, &pipe, rustix::fs::FileType::Fifo, mode, 0).unwrap();
        for absent in [folder.join("absent"), folder.clone(), pipe] {
            assert!(SiteKey::read("network.key", &absent).is_err());
        }
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn law_an_allow_list_names_each_partner_once() {
        let [first, second] = [(); 2].map(|()| SiteKey::generate().id());
        let texts = [first.to_string(), second.to_string()];
        assert_eq!(parse_ids("network.peer_id", &texts), Ok(vec![first, second]));
        let long = first.to_string();
        for (texts, said) in [
            (vec![], "Missing network.peer_id"),
            (vec![long.clone(), long.clone()], "each id once"),
            (vec![long[1..].to_owned()], "64 hexadecimal digits"),
            (vec![format!("{}g", &long[1..])], "64 hexadecimal digits"),
            (vec![String::new()], "64 hexadecimal digits"),
        ] {
            let refusal = parse_ids("network.peer_id", &texts).unwrap_err().to_string();
            assert!(refusal.contains(said), "{texts:?}: {refusal}");
        }
        // about half of all numbers are no points of the curve
        let is_point = |first: u8| format!("{first:02x}{}", "0".repeat(62)).parse::<SiteId>().is_ok();
        assert!((0..32).any(is_point) && !(0..32).all(is_point));
        let many: Vec<String> = (0..17).map(|_| SiteKey::generate().id().to_string()).collect();
        assert!(parse_ids("network.peer_id", &many).is_err());
    }
}
