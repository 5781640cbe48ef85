//! The file: how bytes get there, and what becomes of them if they do not.

use std::fmt::{Debug, Formatter};
use std::io::{Seek, SeekFrom, Write};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use serde::Serialize;

/// How a recording fares, for those who wait for it.
#[derive(Debug, Default)]
pub struct Status {
    /// Items that found no room in the queue.
    pub(super) missed: AtomicU64,
    /// Bytes written.
    pub(super) bytes: AtomicU64,
    /// Why the recording broke off.
    pub(super) trouble: OnceLock<String>,
    pub(super) is_closed: AtomicBool,
    /// Set when the recording breaks off; the loop says so, and resets it.
    alarm: Arc<AtomicBool>,
}

impl Status {
    /// Notes that the recording has broken off, once.
    pub(super) fn fail(&self, trouble: String) {
        if self.trouble.set(trouble).is_ok() {
            self.alarm.store(true, Ordering::Relaxed);
        }
    }

    pub(super) fn has_failed(&self) -> bool {
        self.trouble.get().is_some()
    }
}

/// A recording as seen from outside its thread.
#[derive(Debug, Clone)]
pub struct Recording {
    pub(super) path: PathBuf,
    pub(super) status: Arc<Status>,
}

/// What became of a recording.
#[derive(Debug, Clone, Serialize)]
pub struct RecordingSummary {
    /// The file.
    pub path: String,
    /// `complete`; `broken`: what is there is whole up to some time; `unfinished`: it could not be closed in time.
    pub status: &'static str,
    /// Why it broke off.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cause: Option<String>,
    /// Bytes written.
    pub bytes: u64,
    /// Items that found no room in the queue.
    pub missed: u64,
}

impl Recording {
    /// The switch that the recording sets when it breaks off.
    pub fn alarm(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.status.alarm)
    }

    /// What has become of it so far.
    pub fn summary(&self) -> RecordingSummary {
        let Status { missed, bytes, trouble, is_closed, .. } = &*self.status;
        let status = match (trouble.get(), is_closed.load(Ordering::Acquire)) {
            (Some(_), _) => "broken",
            (None, true) => "complete",
            (None, false) => "unfinished",
        };
        RecordingSummary {
            path: self.path.display().to_string(),
            status,
            cause: trouble.get().cloned(),
            bytes: bytes.load(Ordering::Relaxed),
            missed: missed.load(Ordering::Relaxed),
        }
    }
}

/// A writer that never fails: what cannot be written is reported once, and nothing is written from then on. So the file stays
/// whole up to there, and nobody above must cope with half a record.
pub(super) struct Watched<W> {
    inner: W,
    status: Arc<Status>,
    position: u64,
}

impl<W> Debug for Watched<W> {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> std::fmt::Result {
        formatter.debug_struct("Watched").field("position", &self.position).finish_non_exhaustive()
    }
}

impl<W: Write> Watched<W> {
    pub(super) fn new(inner: W, status: Arc<Status>) -> Self {
        Self { inner, status, position: 0 }
    }

    fn attempt(&mut self, action: impl FnOnce(&mut W) -> std::io::Result<()>) {
        if !self.status.has_failed()
            && let Err(error) = action(&mut self.inner)
        {
            self.status.fail(error.to_string());
        }
    }
}

impl<W: Write> Write for Watched<W> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.attempt(|inner| inner.write_all(bytes));
        if !self.status.has_failed() {
            self.status.bytes.fetch_add(bytes.len() as u64, Ordering::Relaxed);
        }
        self.position = self.position.saturating_add(bytes.len() as u64);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.attempt(Write::flush);
        Ok(())
    }
}

impl<W: Write> Seek for Watched<W> {
    /// Says where it is; a recording goes forwards only.
    fn seek(&mut self, to: SeekFrom) -> std::io::Result<u64> {
        match to {
            SeekFrom::Current(0) | SeekFrom::End(0) => Ok(self.position),
            SeekFrom::Start(position) if position == self.position => Ok(self.position),
            _ => Err(std::io::ErrorKind::Unsupported.into()),
        }
    }
}
