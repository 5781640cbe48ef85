//! Is this site ready? Its loop, device and partner are tried before anyone holds a handle, and no force is commanded.
//!
//! The site is run as in a session, on its loop, with its device and its network. Only the device seems not to be ready, so
//! that no session begins, and every command is zero whatever the site asks for.

mod judge;
mod watched;

pub use watched::{Seen, Watched};

use std::sync::atomic::AtomicBool;

use serde::Serialize;
use telespring::session::Span;

use crate::conduct::{ConductError, Plan, conduct};
use crate::device::Device;
use crate::real_time::Limits;
use crate::settings::LoopChoice;
use crate::site::SiteSettings;
use crate::summary::{LatenessSummary, Summary};
use crate::transport::Transport;

/// The version of the report.
pub const SCHEMA: u32 = 1;

/// How something is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// As it should be.
    Ok,
    /// A session is possible, and not as it should be.
    Warning,
    /// No session is possible, or it would not last.
    Failed,
}

/// Something that was tried.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Item {
    /// What.
    pub item: &'static str,
    /// How it is.
    pub verdict: Verdict,
    /// What was found.
    pub found: String,
    /// What to do about it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub remedy: Option<String>,
}

/// What was found.
#[derive(Debug, Clone, Serialize)]
pub struct Report {
    /// [`SCHEMA`].
    pub schema: u32,
    /// The robot of the study, 1 or 2.
    pub side: u8,
    /// The worst of all items.
    pub verdict: Verdict,
    /// What was tried.
    pub items: Vec<Item>,
    /// How late the loop was; `null` if it did not run.
    pub lateness: Option<LatenessSummary>,
}

impl Item {
    /// Something that is as it should be.
    pub fn fine(item: &'static str, found: impl Into<String>) -> Self {
        Self { item, verdict: Verdict::Ok, found: found.into(), remedy: None }
    }

    /// Something that is not, and what to do about it.
    pub fn wrong(
        item: &'static str,
        verdict: Verdict,
        found: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self { item, verdict, found: found.into(), remedy: Some(remedy.into()) }
    }
}

impl Report {
    /// The report on these items.
    pub fn new(side: u8, items: Vec<Item>, lateness: Option<LatenessSummary>) -> Self {
        let verdict = items.iter().map(|item| item.verdict).max().unwrap_or(Verdict::Ok);
        Self { schema: SCHEMA, side, verdict, items, lateness }
    }
}

/// Tries the loop, the device and the partner of a site for `duration`, or until `stop`. `before` is what is known already.
///
/// # Errors
///
/// [`ConductError`] if the site cannot be made.
pub fn check<D: Device, T: Transport>(
    settings: SiteSettings,
    device: D,
    transport: T,
    real_time: LoopChoice,
    duration: Span,
    stop: &AtomicBool,
    before: Vec<Item>,
) -> Result<Report, ConductError> {
    let (side, period, stall) = (settings.terms.side, settings.terms.sample_period, settings.safety.stall);
    let (device, seen) = Watched::new(device);
    let plan = Plan { real_time, limits: Limits { duration: Some(duration) }, ..Plan::default() };
    let summary = conduct(settings, device, transport, plan, stop, |_| {})?;
    let Summary { lateness, real_time, .. } = &summary;
    let mut items = before;
    items.push(judge::privileges(real_time));
    items.push(judge::timing(lateness, period, stall));
    items.push(judge::device(&seen.get(), period, summary.seconds));
    items.push(judge::partner(&summary));
    Ok(Report::new(side, items, Some(summary.lateness)))
}
