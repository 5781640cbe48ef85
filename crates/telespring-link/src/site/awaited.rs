//! Who has not come yet, told once: whoever starts a site for the first time would see nothing happen.

use telespring::session::{LocalTime, Span};

use super::{Happened, Log};

/// A device program that says nothing for so long after the start is told, …
const DEVICE: Span = Span(2_000_000_000);
/// … and so is a partner.
const PARTNER: Span = Span(5_000_000_000);

/// Who is missing, and has not been told to be.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Awaited {
    began: Option<LocalTime>,
    pub(super) device: bool,
    pub(super) partner: bool,
}

impl Awaited {
    pub(super) fn new() -> Self {
        Self { began: None, device: true, partner: true }
    }

    /// Tells who is missing.
    pub(super) fn tell(&mut self, now: LocalTime, log: &mut Log) {
        let waited = now - *self.began.get_or_insert(now);
        for (missing, patience, happened) in [
            (&mut self.device, DEVICE, Happened::DeviceAwaited),
            (&mut self.partner, PARTNER, Happened::PartnerAwaited),
        ] {
            if waited >= patience && std::mem::take(missing) {
                log.push(now, happened);
            }
        }
    }
}
