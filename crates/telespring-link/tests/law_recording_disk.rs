//! Recordings on a disk that is slow, full, cut off or gone: what is there stays whole, and no tick waits.

mod common;
mod recorded;
mod recording;

use std::fs;
use std::io::{Error, ErrorKind, Write};
use std::path::Path;
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use recorded::{Shared, items, moments, recorder, settings, short, study, summary};
use recording::{File, read};
use telespring::session::LocalTime;
use telespring_link::feed::{self, Item, Observer};
use telespring_link::record::{Facts, Recorder};
use telespring_link::site::Happened;

#[test]
fn law_what_was_taken_is_with_the_system_within_half_a_second() {
    let items = items(1500);
    let file = Shared::default();
    let (mut recorder, recording, _) = recorder(file.clone(), 1);
    let (first, rest) = items.split_at(items.len() / 2);
    first.iter().for_each(|item| recorder.take(item));
    // the recorder's own clock: 0.4 s
    std::thread::sleep(Duration::from_millis(410));
    recorder.rest();
    let whole = file.file();
    assert!(!whole.is_whole);
    assert_eq!(whole.of("/site1/tick").count(), moments(first).len());
    assert_eq!(recording.summary().status, "unfinished");
    // taken while it is due, without a rest
    std::thread::sleep(Duration::from_millis(410));
    recorder.take(&rest[0]);
    let later = file.file();
    let count = |file: &File| {
        let of = |name: &str| file.messages.iter().filter(|message| message.topic.ends_with(name)).count();
        of("/tick") + of("/arrival") + of("/event")
    };
    assert_eq!(count(&later), first.len() + 1);
}

#[test]
fn law_a_file_that_is_cut_anywhere_is_read_up_to_the_last_whole_chunk() {
    let items = items(800);
    let file = Shared::default();
    let (mut recorder, ..) = recorder(file.clone(), 1);
    for part in items.chunks(items.len() / 3) {
        part.iter().for_each(|item| recorder.take(item));
        std::thread::sleep(Duration::from_millis(410));
        recorder.rest();
    }
    let bytes = file.0.lock().unwrap().clone();
    let all = read(&bytes).messages.len();
    assert!(read(&bytes).chunks >= 3);
    let (mut last, mut steps) = (0, 0);
    for length in (0..bytes.len()).step_by(997).skip(1) {
        let count = read(&bytes[..length]).messages.len();
        assert!(count >= last && count <= all, "{length}");
        steps += usize::from(count > last);
        last = count;
    }
    assert!(steps >= 2, "{steps}");
}

#[test]
fn law_a_recording_is_complete_once_all_of_it_is_on_the_medium() {
    let study = study();
    let facts = Facts::new(&study, &settings(&study, 1));
    for is_broken in [false, true] {
        let file = Shared::default();
        let synced = Arc::new(Mutex::new(None));
        let sync = {
            let (file, synced) = (file.clone(), Arc::clone(&synced));
            move || {
                *synced.lock().unwrap() = Some(file.file().is_whole);
                if is_broken { Err(Error::from(ErrorKind::StorageFull)) } else { Ok(()) }
            }
        };
        let (mut recorder, recording) =
            Recorder::on(Box::new(file), Box::new(sync), "session.mcap".into(), &facts);
        assert_eq!(*synced.lock().unwrap(), None);
        recorder.finish(&summary());
        assert_eq!(*synced.lock().unwrap(), Some(true));
        assert_eq!(recording.summary().status, if is_broken { "broken" } else { "complete" });
    }
}

/// A disk of this many bytes.
struct Full(usize);

impl Write for Full {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0 = self.0.checked_sub(bytes.len()).ok_or(Error::from(ErrorKind::StorageFull))?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[test]
fn law_a_session_goes_on_without_its_recording_and_says_so_once() {
    // full from the start, and full later
    for bytes in [0, 3000, 6000] {
        let (recorder, recording, _) = recorder(Full(bytes), 1);
        let summary = short(1.5, vec![Box::new(recorder)], Some(recording));
        assert_eq!((summary.state, summary.cause), ("ended", Some("time-over")), "{bytes}");
        let told = summary.events.iter().filter(|entry| entry.event == "recording-broken").count();
        let recording = summary.recording.unwrap();
        assert_eq!(recording.status, "broken", "{bytes}");
        assert!(recording.cause.unwrap().contains("storage"), "{bytes}");
        assert!(recording.bytes <= bytes as u64);
        assert_eq!(told, 1, "{bytes}");
    }
}

/// A disk that stands still from the first byte of the session on, until its other end is gone.
struct Stalled(usize, Receiver<()>);

impl Write for Stalled {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0 = self.0.saturating_sub(bytes.len());
        if self.0 == 0 {
            let _ = self.1.recv();
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[test]
fn law_a_disk_that_stands_still_delays_no_tick_and_no_end() {
    let (_release, stalled) = channel();
    // what is written before the session fits
    let (recorder, recording, _) = recorder(Stalled(4096, stalled), 1);
    let begin = std::time::Instant::now();
    let summary = short(0.3, vec![Box::new(recorder)], Some(recording));
    assert_eq!(summary.state, "ended");
    // 0.35 s of ticks: done or counted as left out
    let all = summary.lateness.ticks + summary.lateness.overruns;
    assert!((300..=2000).contains(&all), "{all}");
    assert_eq!(summary.recording.unwrap().status, "unfinished");
    assert!(begin.elapsed() < Duration::from_secs(60));
}

/// A disk that stands still while somebody holds the gate.
struct Gated(Shared, Arc<Mutex<()>>);

impl Write for Gated {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let _open = self.1.lock().unwrap();
        self.0.write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        let _open = self.1.lock().unwrap();
        Ok(())
    }
}

#[test]
fn law_what_finds_no_room_is_counted_in_the_file_and_in_the_summary() {
    let (file, gate) = (Shared::default(), Arc::<Mutex<()>>::default());
    let (recorder, recording, _) = recorder(Gated(file.clone(), Arc::clone(&gate)), 1);
    let count = 40_000;
    let observers = {
        let _closed = gate.lock().unwrap();
        let (mut feed, observers) = feed::start(vec![Box::new(recorder)]).unwrap();
        // its next flush stands still
        std::thread::sleep(Duration::from_millis(600));
        for time in 0..count {
            feed.publish(Item::Event { time: LocalTime(time), happened: Happened::Restored });
        }
        observers
    };
    assert!(observers.finish(&summary()).is_empty());
    let summary = recording.summary();
    assert_eq!(summary.status, "complete");
    let file = file.file();
    let events = file.events(1);
    let seen = events.iter().filter(|(event, _)| event == "restored").count() as u64;
    let missed = events.iter().filter(|(event, _)| event == "recording-missed");
    let told: u64 = missed.map(|(_, cause)| cause.as_ref().unwrap().parse::<u64>().unwrap()).sum();
    assert!(told > 0);
    assert_eq!((seen + told, told), (count, summary.missed));
    assert_eq!(file.metadata["end"]["missed"], summary.missed.to_string());
}

#[test]
fn law_no_file_is_written_over_and_a_folder_that_is_none_is_refused() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("recordings");
    let _ = fs::remove_dir_all(&folder);
    let study = study();
    let facts = Facts::new(&study, &settings(&study, 1));
    let refusal = Recorder::create("recording.folder", &folder, &facts).unwrap_err().to_string();
    assert!(refusal.contains("recording.folder = ") && refusal.contains("a folder that exists"), "{refusal}");
    fs::create_dir_all(&folder).unwrap();
    // two within one second have one name
    let refused = (0..10).find_map(|_| {
        let (_, first) = Recorder::create("recording.folder", &folder, &facts).ok()?;
        let before = fs::read(&first.summary().path).unwrap();
        let second = Recorder::create("recording.folder", &folder, &facts);
        assert_eq!(fs::read(&first.summary().path).unwrap(), before);
        second.err()
    });
    assert!(refused.unwrap().to_string().contains("a folder that can be written"));
    let names: Vec<_> = fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    assert!(names.iter().all(|name| name.ends_with("-site1-0000000000000015.mcap")), "{names:?}");
}
