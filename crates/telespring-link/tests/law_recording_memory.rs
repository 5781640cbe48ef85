//! What a long recording takes of the memory; alone in its process, which is measured.

mod common;
mod recorded;
mod recording;

use std::fs;

use recorded::{items, recorder};
use telespring_link::feed::Observer;

/// Memory of this process, bytes.
fn memory() -> u64 {
    let text = fs::read_to_string("/proc/self/statm").unwrap();
    text.split(' ').nth(1).unwrap().parse::<u64>().unwrap() * 4096
}

#[test]
fn law_a_long_recording_needs_no_more_memory_than_a_short_one() {
    let items: Vec<_> = items(2000);
    let (mut recorder, recording, _) = recorder(std::io::sink(), 1);
    let mut round = || items.iter().for_each(|item| recorder.take(item));
    (0..5).for_each(|_| round());
    let before = memory();
    // ten minutes of ticks
    (0..300).for_each(|_| round());
    let grown = memory().saturating_sub(before);
    let written = recording.summary().bytes;
    // other tests of this process run beside it, with megabytes of their own
    assert!(written > 120_000_000 && grown < 100_000_000, "{grown} of {written} bytes");
}
