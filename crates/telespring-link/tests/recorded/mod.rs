//! What the loop of a site tells, made in virtual time, and recorders that take it.

#![allow(dead_code, reason = "every test uses its part")]

use std::io::Write;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use telespring::session::Span;
use telespring::study::Study;
use telespring_link::conduct::{Plan, conduct};
use telespring_link::device::Simulated;
use telespring_link::feed::{Item, Observer};
use telespring_link::operator::Order;
use telespring_link::real_time::Limits;
use telespring_link::record::{Facts, Recorder, Recording};
use telespring_link::settings::LoopChoice;
use telespring_link::site::{Moment, Safety, Site, SiteSettings};
use telespring_link::summary::Summary;

use super::common::{VirtualClock, hman_study, wire};
use super::recording::{File, read};

/// A file in memory that several may look at.
#[derive(Debug, Clone, Default)]
pub struct Shared(pub Arc<Mutex<Vec<u8>>>);

impl Shared {
    pub fn file(&self) -> File {
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

pub fn study() -> Study {
    hman_study(
        "coupling.stiffness = 142\nnetwork = {delay = 0.03, jitter = 0.004, loss = 0.02}\n\
         session = {strategy = \"guard\", predictor = \"kalman\", playout = \"adaptive\"}",
    )
}

pub fn settings(study: &Study, side: u8) -> SiteSettings {
    let settings = SiteSettings::new(study, side, 20 + u64::from(side), Safety::default()).unwrap();
    SiteSettings {
        limits: telespring_link::site::Limits { force: 1.0, ..settings.limits },
        ..settings.simulated()
    }
}

/// A recorder on a writer that is no file.
pub fn recorder(writer: impl Write + Send + 'static, side: u8) -> (Recorder, Recording, Facts) {
    let study = study();
    let facts = Facts::new(&study, &settings(&study, side)).with("device", "simulated");
    let (recorder, recording) =
        Recorder::on(Box::new(writer), Box::new(|| Ok(())), PathBuf::from("session.mcap"), &facts);
    (recorder, recording, facts)
}

/// All that the loop of side 1 would tell of this many ticks of a session in virtual time, as `real_time::run` tells it. There
/// is a pause from 1.2 to 1.6 s.
pub fn items(ticks: usize) -> Vec<Item> {
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

pub fn moments(items: &[Item]) -> Vec<(Moment, Span)> {
    let ticks = items.iter().filter_map(|item| match item {
        Item::Tick { moment, lateness, .. } => Some((*moment, *lateness)),
        _ => None,
    });
    ticks.collect()
}

/// A session without a partner, and what became of its recording.
pub fn short(seconds: f64, observers: Vec<Box<dyn Observer>>, recording: Option<Recording>) -> Summary {
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

pub fn summary() -> Summary {
    short(0.3, Vec::new(), None)
}
