//! One session on its own thread: from the settings to the summary.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use rtrb::Consumer;
use telespring::InvalidInput;
use telespring::session::Span;

use crate::device::Device;
use crate::feed::{self, Item, Observer};
use crate::operator::Order;
use crate::real_time::{self, Limits, Pace};
use crate::record::live::LiveServer;
use crate::record::{Facts, Recorder, Recording};
use crate::settings::{LoopChoice, PaceChoice};
use crate::site::{Moment, Site, SiteSettings};
use crate::summary::Summary;
use crate::transport::Transport;

/// How a session is run.
#[derive(Debug, Default)]
pub struct Plan {
    /// What the loop asks the operating system for.
    pub real_time: LoopChoice,
    /// When it ends by itself.
    pub limits: Limits,
    /// Who sees it, each on a thread of its own.
    pub observers: Vec<Box<dyn Observer>>,
    /// What the people at the site order.
    pub orders: Option<Consumer<Order>>,
    /// The recording that one of the observers writes.
    pub recording: Option<Recording>,
}

impl Plan {
    /// The same, recorded in `folder`, which a field of the input names, and shown by `server`.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if no file can be created in the folder.
    pub fn watched(
        mut self,
        facts: &Facts,
        folder: Option<(&str, &PathBuf)>,
        server: Option<&Arc<LiveServer>>,
    ) -> Result<Self, InvalidInput> {
        if let Some((field, folder)) = folder {
            let (recorder, recording) = Recorder::create(field, folder, facts)?;
            self.observers.push(Box::new(recorder));
            self.recording = Some(recording);
        }
        if let Some(server) = server {
            self.observers.push(Box::new(server.view(facts)));
        }
        Ok(self)
    }
}

/// Why a session did not take place.
#[derive(Debug, thiserror::Error)]
pub enum ConductError {
    /// A value out of range.
    #[error(transparent)]
    Input(#[from] InvalidInput),
    /// The operating system gave no thread.
    #[error("the operating system refused: {0}")]
    System(#[from] std::io::Error),
}

/// Runs the session of a site on this thread until it has ended. `watch` sees every tick, on this thread.
///
/// # Errors
///
/// [`ConductError`]; nothing has been sent then.
pub fn conduct<D: Device, T: Transport>(
    settings: SiteSettings,
    device: D,
    transport: T,
    plan: Plan,
    stop: &AtomicBool,
    mut watch: impl FnMut(&Moment),
) -> Result<Summary, ConductError> {
    let Plan { real_time, limits, observers, orders, recording } = plan;
    let LoopChoice { priority, lock_memory, stay_awake, pace: choice } = real_time;
    let follows = choice == PaceChoice::Device;
    let side = settings.terms.side;
    let period = Span::from_seconds(settings.terms.sample_period);
    let mut site = Site::new(settings, device, transport)?;
    if let Some(orders) = orders {
        site.obey(orders);
    }
    if let Some(recording) = &recording {
        site.watch_recording(recording.alarm());
    }
    let mut pace = Pace::new(period);
    let (mut feed, observers) = feed::start(observers)?;
    let privileges = real_time::claim(priority, lock_memory, stay_awake);
    real_time::run(&mut site, &mut pace, limits, stop, follows, |item| {
        if let Item::Tick { moment, .. } = &item {
            watch(moment);
        }
        feed.publish(item);
    });
    let mut summary = Summary::new(side, &site, &pace.lateness(), &privileges);
    for name in observers.finish(&summary) {
        eprintln!("The {name} did not finish.");
    }
    summary.recording = recording.map(|recording| recording.summary());
    Ok(summary)
}
