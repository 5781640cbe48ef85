//! `telespring-link id`.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use telespring_link::keys::SiteKey;

use super::Failure;

/// Prints the public id of a site's key: the line that the partner puts into its site file
#[derive(Debug, Args)]
pub struct Id {
    /// The file of the key
    path: PathBuf,
}

impl Id {
    pub(super) fn run(self) -> Result<ExitCode, Failure> {
        println!("{}", SiteKey::read("key", &self.path)?.id());
        Ok(ExitCode::SUCCESS)
    }
}
