//! Recordings: what is read back is what the loop saw, bit for bit; what cannot be written costs no tick.

mod common;
mod recording;

use std::fs;
use std::io::{Error, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use common::{VirtualClock, hman_study, wire};
use recording::{File, number, pair, read, value, whole, word};
use telespring::session::{Endpoint, LocalTime, Motion, Packet, Span};
use telespring::study::Study;
use telespring_link::conduct::{Plan, conduct};
use telespring_link::device::Simulated;
use telespring_link::feed::{self, Item, Observer};
use telespring_link::operator::Order;
use telespring_link::real_time::Limits;
use telespring_link::record::{Facts, Recorder, Recording};
use telespring_link::settings::LoopChoice;
use telespring_link::site::{Happened, Moment, Safety, Site, SiteSettings};
use telespring_link::summary::Summary;

/// A file in memory that several may look at.
#[derive(Debug, Clone, Default)]
struct Shared(Arc<Mutex<Vec<u8>>>);

impl Shared {
    fn file(&self) -> File {
        read(&self.0.lock().unwrap())
    }
}

impl Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.lock().unwrap().extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

fn study() -> Study {
    hman_study(
        "coupling.stiffness = 142\nnetwork = {delay = 0.03, jitter = 0.004, loss = 0.02}\n\
         session = {strategy = \"guard\", predictor = \"kalman\", playout = \"adaptive\"}",
    )
}

fn settings(study: &Study, side: u8) -> SiteSettings {
    let settings = SiteSettings::new(study, side, 20 + u64::from(side), Safety::default()).unwrap();
    SiteSettings {
        limits: telespring_link::site::Limits { force: 1.0, ..settings.limits },
        ..settings.simulated()
    }
}

fn recorder(writer: impl Write + Send + 'static, side: u8) -> (Recorder, Recording, Facts) {
    let study = study();
    let facts = Facts::new(&study, &settings(&study, side)).with("device", "simulated");
    let (recorder, recording) = Recorder::on(Box::new(writer), PathBuf::from("session.mcap"), &facts);
    (recorder, recording, facts)
}

/// All that the loop of side 1 would tell of this many ticks of a session in virtual time, as `real_time::run` tells it. There
/// is a pause from 1.2 to 1.6 s.
fn items(ticks: usize) -> Vec<Item> {
    let study = study();
    let laboratory = study.laboratory().unwrap();
    let ends = wire(Span(29_000_000));
    let clock = VirtualClock::default();
    clock.0.set(9_000_000_000);
    let mut sites = [0, 1].map(|side| {
        let device = Simulated::new(&laboratory, side, 7).unwrap();
        let number = u8::try_from(side).unwrap() + 1;
        Site::new(settings(&study, number), device, ends[side].clone()).unwrap()
    });
    let (mut orders, queue) = rtrb::RingBuffer::new(2);
    sites[0].obey(queue);
    let (mut items, mut told) = (Vec::new(), 0);
    for tick in 0..ticks {
        match tick {
            1200 => orders.push(Order::Pause).unwrap(),
            1600 => orders.push(Order::Resume).unwrap(),
            _ => {}
        }
        clock.0.set(clock.0.get() + 1_000_000);
        if tick % 100 == 50 {
            // refused, of any length
            let mut wire = ends[0].wire.borrow_mut();
            wire.injected[0].extend([vec![7; 300], b"no packet".to_vec()]);
        }
        let moments = sites.each_mut().map(|site| site.tick(&clock, false));
        let entries = sites[0].log().entries();
        items.extend(
            entries[told..].iter().map(|(time, happened)| Item::Event { time: *time, happened: *happened }),
        );
        told = entries.len();
        items.extend(sites[0].arrivals().iter().copied().map(Item::Arrival));
        let lateness = Span(i64::try_from(tick).unwrap() * 11);
        items.push(Item::Tick { moment: moments[0], lateness, duration: Span(40_000), overruns: 3 });
    }
    items
}

fn moments(items: &[Item]) -> Vec<(Moment, Span)> {
    let ticks = items.iter().filter_map(|item| match item {
        Item::Tick { moment, lateness, .. } => Some((*moment, *lateness)),
        _ => None,
    });
    ticks.collect()
}

fn motion(message: &prost_reflect::DynamicMessage, path: &str) -> Option<Motion> {
    let position = pair(message, &format!("{path}.position"))?;
    Some(Motion { position, velocity: pair(message, &format!("{path}.velocity")).unwrap() })
}

#[test]
fn law_what_is_read_back_is_what_the_loop_saw() {
    let items = items(4000);
    let file = Shared::default();
    let (mut recorder, recording, facts) = recorder(file.clone(), 1);
    items.iter().for_each(|item| recorder.take(item));
    let summary = summary();
    recorder.finish(&summary);
    assert_eq!(recording.summary().status, "complete");
    let file = file.file();
    assert!(file.is_whole);
    // messages stand in the order of the loop
    let mut messages = file.messages.iter().filter(|message| {
        ["tick", "arrival", "event"].map(|name| format!("/site1/{name}")).contains(&message.topic)
    });
    let (mut coupled, mut predicted, mut limited, mut taken, mut refused) = (0, 0, 0, 0, 0);
    for item in &items {
        let message = messages.next().unwrap();
        let content = &message.content;
        match item {
            Item::Tick { moment, lateness, duration, overruns } => {
                assert_eq!(whole(content, "overruns"), Some(*overruns));
                assert_eq!(value(content, "is_timed").unwrap().as_bool(), Some(moment.is_timed));
                assert_eq!(number(content, "share"), Some(moment.share));
                assert_eq!(pair(content, "handle_offset"), moment.offset);
                assert_eq!(message.topic, "/site1/tick");
                assert_eq!(whole(content, "tick"), Some(moment.tick));
                assert_eq!(whole(content, "time"), Some(moment.time.0));
                assert_eq!(whole(content, "asked_time"), moment.asked.map(|time| time.0));
                assert_eq!(whole(content, "commanded_time"), Some(moment.commanded.0));
                assert_eq!(number(content, "lateness"), Some(lateness.seconds()));
                assert_eq!(number(content, "duration"), Some(duration.seconds()));
                assert_eq!(word(content, "phase").as_deref(), Some(moment.phase.word()));
                assert_eq!(value(content, "is_measured").unwrap().as_bool(), Some(moment.is_measured));
                assert_eq!(motion(content, "own"), moment.motion);
                assert_eq!(motion(content, "target"), moment.target);
                assert_eq!(number(content, "device_sequence"), moment.stamp.map(|stamp| stamp.sequence));
                assert_eq!(pair(content, "commanded_force"), Some(moment.force));
                assert_eq!(pair(content, "wanted_force"), moment.forces.wanted);
                assert_eq!(pair(content, "told_force"), moment.forces.told);
                assert_eq!(pair(content, "measured_force"), moment.forces.measured);
                let used = moment.used_partner();
                assert_eq!(motion(content, "partner_played"), used.map(|used| used.played));
                assert_eq!(motion(content, "partner_predicted"), used.map(|used| used.wanted));
                assert_eq!(number(content, "played_age"), used.map(|used| used.age));
                let newest = moment.newest;
                assert_eq!(motion(content, "partner_newest"), newest.map(|newest| newest.packet.motion));
                assert_eq!(whole(content, "partner_arrival_time"), newest.map(|newest| newest.arrival.0));
                assert_eq!(whole(content, "partner_sent_time"), newest.map(|newest| newest.packet.sent.0));
                assert_eq!(number(content, "energy_balance"), moment.balance);
                let session = moment.session;
                let offset = value(content, "clock_offset").map(|value| value.as_i64().unwrap());
                assert_eq!(offset, session.clock.offset.map(|span| span.0));
                assert_eq!(number(content, "round_trip"), session.clock.round_trip.map(Span::seconds));
                assert_eq!(number(content, "stiffness"), Some(session.outgoing.stiffness));
                assert_eq!(number(content, "stiffness_wanted"), Some(142.0));
                assert_eq!(number(content, "energy_given_out"), Some(session.strategy.given_out));
                assert_eq!(whole(content, "packets_received"), Some(session.received));
                assert_eq!(whole(content, "packets_refused"), Some(session.refused));
                let latency = moment.latency(*lateness);
                assert_eq!(number(content, "latency_loop"), Some(latency.control));
                assert_eq!(number(content, "latency_network"), latency.network);
                assert_eq!(number(content, "latency_playout"), latency.playout);
                coupled += u64::from(moment.asked.is_some());
                predicted += u64::from(used.is_some_and(|used| used.wanted != used.played));
                limited += u64::from(moment.forces.wanted.is_some_and(|wanted| wanted != moment.force));
            }
            Item::Arrival(arrival) => {
                assert_eq!(message.topic, "/site1/arrival");
                assert_eq!(whole(content, "tick"), Some(arrival.tick));
                assert_eq!(whole(content, "time"), Some(arrival.time.0));
                assert_eq!(whole(content, "length"), Some(arrival.length as u64));
                let datagram = value(content, "datagram").unwrap().as_bytes().unwrap().clone();
                assert_eq!(datagram, arrival.bytes());
                assert_eq!(value(content, "is_taken").unwrap().as_bool(), Some(arrival.is_taken));
                let packet = Packet::decode(&datagram).ok().filter(|_| arrival.length == datagram.len());
                assert_eq!(packet.is_some(), arrival.is_taken);
                taken += u64::from(arrival.is_taken);
                refused += u64::from(!arrival.is_taken);
            }
            Item::Event { time, .. } => {
                assert_eq!(message.topic, "/site1/event");
                assert_eq!(whole(content, "time"), Some(time.0));
            }
        }
        let time = whole(content, "time").unwrap();
        assert_eq!([message.log_time, message.publish_time], [facts.zero + time; 2]);
    }
    assert!(messages.next().is_none());
    // the session had all of it
    assert!(
        coupled > 2000 && predicted > 500 && limited > 100 && taken > 2000,
        "{coupled} {predicted} {limited} {taken}"
    );
    assert!(refused >= 20, "{refused}");
    let events: Vec<_> = file.events(1).into_iter().map(|(event, _)| event).collect();
    assert!(
        ["agreed", "phase", "partner-found", "engaged"]
            .iter()
            .all(|event| events.contains(&(*event).to_owned())),
        "{events:?}"
    );
    assert_eq!(file.of("/site1/log").count(), events.len());
    // 60 per second of 4 s
    for topic in ["/site1/handle", "/site1/target"] {
        assert!((235..=242).contains(&file.of(topic).count()), "{topic} {}", file.of(topic).count());
    }
    let telespring = &file.metadata["telespring"];
    for (key, expected) in
        [("format_version", "1"), ("side", "1"), ("session", "0x0000000000000015"), ("device", "simulated")]
    {
        assert_eq!(telespring[key], expected, "{key}");
    }
    assert_eq!(telespring["wall_time_zero"], facts.zero.to_string());
    assert_eq!(file.metadata["end"]["missed"], "0");
    let read_study = Study::from_toml(std::str::from_utf8(&file.attachments["study.toml"]).unwrap()).unwrap();
    assert_eq!(read_study.to_toml(), study().to_toml());
    let read_summary: serde_json::Value = serde_json::from_slice(&file.attachments["summary.json"]).unwrap();
    assert_eq!(read_summary["side"], 1);
}

#[test]
fn law_an_endpoint_that_is_told_what_the_file_says_wants_what_it_wanted() {
    let items = items(4000);
    let file = Shared::default();
    let (mut recorder, ..) = recorder(file.clone(), 1);
    items.iter().for_each(|item| recorder.take(item));
    recorder.finish(&summary());
    let file = file.file();
    let mut endpoint = Endpoint::new(settings(&study(), 1).endpoint).unwrap();
    let (mut arrivals, mut compared, mut timed, mut largest) = (Vec::new(), 0, 0, 0.0_f64);
    for message in &file.messages {
        let content = &message.content;
        let time = || LocalTime(whole(content, "time").unwrap());
        if message.topic == "/site1/arrival" {
            let mut datagram = value(content, "datagram").unwrap().as_bytes().unwrap().to_vec();
            datagram.resize(usize::try_from(whole(content, "length").unwrap()).unwrap(), 0);
            arrivals.push((time(), datagram));
        }
        if message.topic != "/site1/tick" {
            continue;
        }
        if value(content, "is_measured").unwrap().as_bool() == Some(true) {
            if let Some(told) = pair(content, "told_force") {
                endpoint.handle_acted(told);
            }
            let _ = endpoint.handle_measurement(time(), motion(content, "own").unwrap());
            if let Some(target) = motion(content, "target") {
                endpoint.handle_target(time(), target);
            }
            endpoint.poll_transmit(time()).unwrap();
        }
        if value(content, "is_timed").unwrap().as_bool() == Some(true) {
            endpoint.handle_timeout(time());
            timed += 1;
        }
        for (time, datagram) in arrivals.drain(..) {
            let _ = endpoint.handle_datagram(time, &datagram);
        }
        if let Some(asked) = whole(content, "asked_time") {
            let force = endpoint.force(LocalTime(asked));
            assert_eq!(
                Some(force.map(f64::to_bits)),
                pair(content, "wanted_force").map(|force| force.map(f64::to_bits))
            );
            compared += 1;
            largest = force.iter().fold(largest, |largest, force| largest.max(force.abs()));
        }
    }
    assert!(compared > 2000 && timed > 10 && largest > 1.0, "{compared} {timed} {largest}");
}

/// A session without a partner, and what became of its recording.
fn short(seconds: f64, observers: Vec<Box<dyn Observer>>, recording: Option<Recording>) -> Summary {
    let study = study();
    let laboratory = study.laboratory().unwrap();
    let ends = wire(Span(1_000_000));
    let device = Simulated::new(&laboratory, 0, 7).unwrap();
    let real_time = LoopChoice { priority: None, lock_memory: false, ..LoopChoice::default() };
    let limits = Limits { duration: Some(Span::from_seconds(seconds)) };
    let plan = Plan { real_time, limits, observers, recording, ..Plan::default() };
    let stop = std::sync::atomic::AtomicBool::new(false);
    conduct(settings(&study, 1), device, ends[0].clone(), plan, &stop, |_| {}).unwrap()
}

fn summary() -> Summary {
    short(0.3, Vec::new(), None)
}

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
    for bytes in [0, 3000, 40_000] {
        let (recorder, recording, _) = recorder(Full(bytes), 1);
        let summary = short(1.5, vec![Box::new(recorder)], Some(recording));
        assert_eq!((summary.state, summary.cause), ("ended", Some("stop-requested")), "{bytes}");
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
    // five minutes of ticks
    (0..150).for_each(|_| round());
    let grown = memory().saturating_sub(before);
    let written = recording.summary().bytes;
    // other tests of this process run beside it
    assert!(written > 60_000_000 && grown < 40_000_000, "{grown} of {written} bytes");
}

#[test]
fn law_the_page_has_every_topic_and_field() {
    let page = include_str!("../../../docs/recording.md");
    let file = Shared::default();
    let (mut recorder, ..) = recorder(file.clone(), 1);
    items(1900).iter().for_each(|item| recorder.take(item));
    recorder.finish(&summary());
    let file = file.file();
    assert_eq!(file.schemas.len(), 8);
    for (topic, schema) in &file.schemas {
        assert!(page.contains(&topic.replace("site1", "siteSIDE")), "{topic}");
        assert!(page.contains(&format!("`{}`", schema.full_name())), "{}", schema.full_name());
        if ["/site1/tick", "/site1/arrival", "/site1/event"].contains(&topic.as_str()) {
            for field in schema.fields() {
                assert!(page.contains(&format!("`{}`", field.name())), "{topic} {}", field.name());
            }
        }
    }
    for (name, record) in &file.metadata {
        assert!(page.contains(&format!("metadata `{name}`")), "{name}");
        for key in record.keys() {
            assert!(page.contains(&format!("`{key}`")), "{name} {key}");
        }
    }
    for name in file.attachments.keys() {
        assert!(page.contains(&format!("attachment `{name}`")), "{name}");
    }
}

#[test]
fn law_the_layout_shows_what_is_recorded() {
    let text = include_str!("../../../examples/foxglove-layout.json");
    let layout: serde_json::Value = serde_json::from_str(text).unwrap();
    let file = Shared::default();
    let (mut recorder, ..) = recorder(file.clone(), 1);
    items(1900).iter().for_each(|item| recorder.take(item));
    recorder.finish(&summary());
    let schemas = file.file().schemas;
    let schema = |topic: &str| {
        let alike = topic.replace("/site2/", "/site1/");
        schemas.get(&alike).unwrap_or_else(|| panic!("{topic}")).clone()
    };
    // every panel stands once in the tree, and has a kind that the viewers know
    let mut shown = Vec::new();
    panels(&layout["layout"], &mut shown);
    shown.sort();
    let panels = layout["configById"].as_object().unwrap();
    assert_eq!(shown, panels.keys().cloned().collect::<Vec<_>>());
    let mut paths = 0;
    for (panel, settings) in panels {
        match panel.split_once('!').unwrap().0 {
            "Plot" | "StateTransitions" => {
                for path in settings["paths"].as_array().unwrap() {
                    assert_eq!(path["timestampMethod"], "receiveTime");
                    let (topic, fields) = path["value"].as_str().unwrap().split_once('.').unwrap();
                    let mut message = Some(schema(topic));
                    for name in fields.split('.') {
                        let field = message.unwrap().get_field_by_name(name);
                        let kind = field.unwrap_or_else(|| panic!("{topic}.{fields}")).kind();
                        message = kind.as_message().cloned();
                    }
                    assert!(message.is_none(), "{topic}.{fields} is no value");
                    paths += 1;
                }
            }
            "3D" => {
                for topic in settings["topics"].as_object().unwrap().keys() {
                    assert_eq!(schema(topic).full_name(), "foxglove.PoseInFrame", "{topic}");
                }
                assert_eq!(settings["followTf"], "study");
            }
            "RosOut" => {
                let topic = settings["topicToRender"].as_str().unwrap();
                assert_eq!(schema(topic).full_name(), "foxglove.Log", "{topic}");
            }
            other => panic!("{other}"),
        }
    }
    assert!(paths > 30, "{paths}");
}

/// The panels of a tree of splits.
fn panels(node: &serde_json::Value, found: &mut Vec<String>) {
    if let Some(panel) = node.as_str() {
        found.push(panel.to_owned());
        return;
    }
    let split = node.as_object().unwrap();
    assert!(["row", "column"].contains(&split["direction"].as_str().unwrap()), "{node}");
    let share = split["splitPercentage"].as_f64().unwrap();
    assert!(share > 0.0 && share < 100.0);
    for part in ["first", "second"] {
        panels(&split[part], found);
    }
}
