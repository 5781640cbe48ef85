//! The recording of a session, and the live view: every tick, arrival and event as messages.
//!
//! Both watch the loop through a queue and a thread of their own (`feed`): a disk or a viewer that stands still costs messages,
//! which are counted, and never a tick. `docs/recording.md` has the format.

mod facts;
mod file;
pub mod live;
pub mod messages;
mod scene;
mod topics;

pub use facts::Facts;
pub use file::{Recording, RecordingSummary};
pub use topics::Topics;

use std::borrow::Cow;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant, SystemTime};

use foxglove::{Context, FoxgloveError, McapAttachment, McapCompression, McapWriteOptions, McapWriterHandle};
use telespring::InvalidInput;

use crate::feed::{Item, Observer};
use crate::summary::Summary;
use file::{Status, Watched};

/// A chunk is closed and handed to the operating system after this time, so that half a second at most is lost with the
/// program; or once it has this size, bytes.
const FLUSH_INTERVAL: Duration = Duration::from_millis(400);
const CHUNK_SIZE: u64 = 1 << 20;

/// The file of a recording while it is written.
type Sink = McapWriterHandle<Watched<Box<dyn Write + Send>>>;

/// Brings what was written to the medium, so that it outlives a loss of power.
pub type SyncDisk = Box<dyn FnOnce() -> std::io::Result<()> + Send>;

/// Writes a session to a file.
pub struct Recorder {
    topics: Topics,
    /// `None` once it is closed or has broken off.
    sink: Option<Sink>,
    /// What is done at the end.
    sync: Option<SyncDisk>,
    status: Arc<Status>,
    zero: u64,
    flushed: Instant,
}

/// A folder that recordings can go to.
///
/// # Errors
///
/// [`InvalidInput`] if it is none.
pub fn check_folder(field: &str, folder: &Path) -> Result<(), InvalidInput> {
    if folder.is_dir() {
        return Ok(());
    }
    let remedy = "Create the folder, or check the path.";
    Err(InvalidInput::new(field, folder.display(), "a folder that exists", remedy))
}

impl Recorder {
    /// Begins a recording in a new file of a folder.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] with the field if no file can be created there.
    pub fn create(field: &str, folder: &Path, facts: &Facts) -> Result<(Self, Recording), InvalidInput> {
        check_folder(field, folder)?;
        let path = folder.join(name(facts));
        // an existing file is never written to
        let file = File::create_new(&path).map_err(|error| {
            let allowed = format!("a folder that can be written ({error})");
            InvalidInput::new(
                field,
                path.display(),
                allowed,
                "Check its permissions, or give another folder.",
            )
        })?;
        let refuse = |error: std::io::Error| {
            InvalidInput::new(field, path.display(), format!("a file ({error})"), "Give another folder.")
        };
        let (disk, entry) = (file.try_clone().map_err(refuse)?, File::open(folder).map_err(refuse)?);
        // some file systems sync no folder: there the file's own sync must do
        let _ = entry.sync_all();
        let sync = move || disk.sync_all();
        Ok(Self::on(Box::new(BufWriter::new(file)), Box::new(sync), path, facts))
    }

    /// Begins a recording on a writer, which `sync` brings to the medium in the end; `path` is what it is called.
    pub fn on(
        writer: Box<dyn Write + Send>,
        sync: SyncDisk,
        path: PathBuf,
        facts: &Facts,
    ) -> (Self, Recording) {
        let status = Arc::new(Status::default());
        let context = Context::new();
        let options = McapWriteOptions::new()
            .compression(Some(McapCompression::Lz4))
            .chunk_size(Some(CHUNK_SIZE))
            // a chunk is put together in memory: the file grows by whole records
            .disable_seeking(true);
        let writer = Watched::new(writer, Arc::clone(&status));
        let sink = context.mcap_writer_with_options(options).create(writer);
        let mut recorder = Self {
            topics: Topics::new(&context, facts.side, facts.zero),
            sink: None,
            sync: Some(sync),
            status: Arc::clone(&status),
            zero: facts.zero,
            flushed: Instant::now(),
        };
        match sink {
            Ok(sink) => recorder.sink = Some(sink),
            Err(error) => status.fail(error.to_string()),
        }
        recorder.describe(facts);
        (recorder, Recording { path, status })
    }

    /// Writes what is known before the session.
    fn describe(&mut self, facts: &Facts) {
        for (name, record) in &facts.records {
            self.write(|sink| sink.write_metadata(name, record.clone()));
        }
        self.attach("study.toml", "application/toml", facts.study.as_bytes());
        self.flush();
    }

    fn attach(&mut self, name: &str, media_type: &str, data: &[u8]) {
        let zero = self.zero;
        self.write(|sink| {
            sink.attach(&McapAttachment {
                log_time: zero,
                create_time: zero,
                name: name.to_owned(),
                media_type: media_type.to_owned(),
                data: Cow::Borrowed(data),
            })
        });
    }

    /// Writes, unless the recording has broken off; it does if that fails.
    fn write(&mut self, action: impl FnOnce(&Sink) -> Result<(), FoxgloveError>) {
        let Some(sink) = &self.sink else { return };
        if let Err(error) = action(sink) {
            self.status.fail(error.to_string());
        }
        if self.status.has_failed() {
            self.sink = None;
        }
    }

    fn flush(&mut self) {
        self.flushed = Instant::now();
        self.write(McapWriterHandle::flush);
    }

    fn flush_if_due(&mut self) {
        if self.flushed.elapsed() >= FLUSH_INTERVAL {
            self.flush();
        }
    }
}

impl std::fmt::Debug for Recorder {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_struct("Recorder").field("status", &self.status).finish_non_exhaustive()
    }
}

impl Observer for Recorder {
    fn name(&self) -> &'static str {
        "recording"
    }

    fn take(&mut self, item: &Item) {
        if self.sink.is_some() {
            self.topics.publish(item);
            self.flush_if_due();
        }
    }

    fn miss(&mut self, count: u64) {
        self.status.missed.fetch_add(count, Ordering::Relaxed);
        self.topics.miss(count);
    }

    fn rest(&mut self) {
        self.flush_if_due();
    }

    fn finish(&mut self, summary: &Summary) {
        if let Ok(text) = serde_json::to_string_pretty(summary) {
            self.attach("summary.json", "application/json", text.as_bytes());
        }
        let missed = self.status.missed.load(Ordering::Relaxed).to_string();
        self.write(|sink| sink.write_metadata("end", [("missed".to_owned(), missed)].into()));
        if let Some(sink) = self.sink.take()
            && let Err(trouble) = close(sink, self.sync.take())
        {
            self.status.fail(trouble);
        }
        self.status.is_closed.store(true, Ordering::Release);
    }
}

/// Writes the end of a file, and brings all of it to the medium; the trouble if that fails. What could not be written is in the
/// status already.
fn close(sink: Sink, sync: Option<SyncDisk>) -> Result<(), String> {
    let mut writer = sink.close().map_err(|error| error.to_string())?;
    writer.flush().map_err(|error| error.to_string())?;
    sync.map_or(Ok(()), |sync| sync().map_err(|error| error.to_string()))
}

/// The name of a file: date, site and session, so that no two are alike.
fn name(facts: &Facts) -> String {
    let date = humantime::format_rfc3339_seconds(SystemTime::now()).to_string().replace(':', "-");
    format!("{date}-site{}-{:016x}.mcap", facts.side, facts.session)
}
