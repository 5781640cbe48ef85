//! `telespring-link keygen`.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use telespring_link::keys::SiteKey;

use super::Failure;

/// Makes the key of a site, in a new file that only its owner may read, and prints the site's public id
#[derive(Debug, Args)]
pub struct Keygen {
    /// The new file
    path: PathBuf,
}

impl Keygen {
    pub(super) fn run(self) -> Result<ExitCode, Failure> {
        println!("{}", SiteKey::create(&self.path)?.id());
        Ok(ExitCode::SUCCESS)
    }
}
