//! Lines for whoever reads the standard output: a reader that stalls or leaves holds nobody up.

use std::io::Result;
use std::os::fd::{AsFd, OwnedFd};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use serde::Serialize;

use super::numbers;

/// A pipe that says that it can be written to takes this many bytes without waiting (`PIPE_BUF`).
const AT_ONCE: usize = 4096;

/// Lines of JSON, one object each, or of text, from several threads.
#[derive(Debug, Clone)]
pub struct Output(Arc<Mutex<Target>>);

#[derive(Debug)]
struct Target {
    file: OwnedFd,
    /// The reader has left, or has only half a line: nothing more is written.
    is_closed: bool,
    /// Lines that were not written.
    dropped: u64,
}

/// What a line says: an object, and of which type it is.
#[derive(Debug, Serialize)]
pub struct Line<'a, T> {
    /// The type.
    #[serde(rename = "type")]
    pub kind: &'static str,
    /// The object.
    #[serde(flatten)]
    pub content: &'a T,
}

impl Output {
    /// Lines on the standard output.
    ///
    /// # Errors
    ///
    /// Those of the operating system.
    pub fn stdout() -> Result<Self> {
        Ok(Self::on(std::io::stdout().as_fd().try_clone_to_owned()?))
    }

    /// Lines on the standard error.
    ///
    /// # Errors
    ///
    /// Those of the operating system.
    pub fn stderr() -> Result<Self> {
        Ok(Self::on(std::io::stderr().as_fd().try_clone_to_owned()?))
    }

    /// Lines into a file, a pipe or a socket.
    pub fn on(file: OwnedFd) -> Self {
        Self(Arc::new(Mutex::new(Target { file, is_closed: false, dropped: 0 })))
    }

    /// Writes an object as a line, its type first. Waits for the reader no longer than `patience`, then drops it.
    pub fn write(&self, kind: &'static str, content: &impl Serialize, patience: Duration) {
        let Ok(mut line) = numbers::line(&Line { kind, content }) else { return };
        line.push(b'\n');
        self.write_line(&line, patience);
    }

    fn write_line(&self, line: &[u8], patience: Duration) {
        // a thread that broke off while it wrote has left at most half a line
        let mut target = self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if !target.write(line, Instant::now() + patience) {
            target.dropped += 1;
        }
    }

    /// Writes a line of text, as [`Output::write`] does.
    pub fn write_text(&self, text: &str, patience: Duration) {
        self.write_line(format!("{text}\n").as_bytes(), patience);
    }

    /// Lines that were not written, because the reader stalled or left.
    pub fn dropped(&self) -> u64 {
        self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner).dropped
    }
}

impl Target {
    /// Writes a line until `end`; false if the reader did not take the whole of it.
    fn write(&mut self, line: &[u8], end: Instant) -> bool {
        let mut rest = line;
        while !rest.is_empty() && !self.is_closed && self.is_writable(end) {
            let part = rest.get(..AT_ONCE).unwrap_or(rest);
            match rustix::io::write(&self.file, part) {
                Ok(written) => rest = rest.get(written..).unwrap_or_default(),
                Err(rustix::io::Errno::INTR | rustix::io::Errno::AGAIN) => {}
                Err(_) => self.is_closed = true,
            }
        }
        // half a line is no JSON, and would spoil the next one
        self.is_closed |= !rest.is_empty() && rest.len() < line.len();
        rest.is_empty()
    }

    /// Waits until the reader has room, at most until `end`.
    fn is_writable(&self, end: Instant) -> bool {
        let left = end.saturating_duration_since(Instant::now());
        let left = Timespec { tv_sec: left.as_secs().cast_signed(), tv_nsec: left.subsec_nanos().into() };
        let mut files = [PollFd::new(&self.file, PollFlags::OUT)];
        // a reader that has left is noticed by writing
        match poll(&mut files, Some(&left)) {
            Ok(count) => count > 0,
            Err(rustix::io::Errno::INTR) => Instant::now() < end,
            Err(_) => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use super::*;

    #[test]
    fn law_a_reader_that_stalls_costs_lines_and_no_time() {
        let (mut reader, writer) = std::io::pipe().unwrap();
        let output = Output::on(writer.into());
        let content = serde_json::json!({"number": 7});
        // far more than a pipe holds
        let count: u64 = 100_000;
        for _ in 0..count {
            output.write("status", &content, Duration::ZERO);
        }
        let dropped = output.dropped();
        assert!(dropped > 0 && dropped < count, "{dropped}");
        drop(output);
        let mut text = String::new();
        reader.read_to_string(&mut text).unwrap();
        assert_eq!(text.lines().count() as u64, count - dropped);
        assert!(text.lines().all(|line| line == r#"{"type":"status","number":7}"#));
    }

    #[test]
    fn law_a_reader_that_leaves_is_no_error() {
        let (reader, writer) = std::io::pipe().unwrap();
        let output = Output::on(writer.into());
        drop(reader);
        for _ in 0..3 {
            output.write("status", &serde_json::json!({}), Duration::from_secs(60));
        }
        assert_eq!(output.dropped(), 3);
    }

    #[test]
    fn law_half_a_line_is_the_last_one() {
        let (mut reader, writer) = std::io::pipe().unwrap();
        let output = Output::on(writer.into());
        output.write("event", &serde_json::json!({"long": "x".repeat(200_000)}), Duration::ZERO);
        output.write("event", &serde_json::json!({"short": 1}), Duration::ZERO);
        assert_eq!(output.dropped(), 2);
        drop(output);
        let mut text = String::new();
        reader.read_to_string(&mut text).unwrap();
        assert!(!text.contains('\n'), "{}", text.len());
    }
}
