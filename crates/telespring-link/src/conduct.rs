//! One session on its own thread: from the settings to the summary.

use std::sync::atomic::AtomicBool;

use telespring::InvalidInput;
use telespring::session::Span;

use crate::device::Device;
use crate::real_time::{self, Limits, Pace};
use crate::settings::LoopChoice;
use crate::site::{Moment, Site, SiteSettings};
use crate::summary::Summary;
use crate::transport::Transport;

/// Runs the session of a site on this thread until it has ended.
///
/// # Errors
///
/// [`InvalidInput`] for a setting out of range; nothing has been sent then.
pub fn conduct<D: Device, T: Transport>(
    settings: SiteSettings,
    device: D,
    transport: T,
    choice: LoopChoice,
    limits: Limits,
    stop: &AtomicBool,
    watch: impl FnMut(&Moment),
) -> Result<Summary, InvalidInput> {
    let side = settings.terms.side;
    let period = Span::from_seconds(settings.terms.sample_period);
    let mut site = Site::new(settings, device, transport)?;
    let mut pace = Pace::new(period);
    let privileges = real_time::claim(choice.priority, choice.lock_memory);
    real_time::run(&mut site, &mut pace, limits, stop, watch);
    Ok(Summary::new(side, &site, &pace.lateness(), &privileges))
}
