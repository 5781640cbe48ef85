//! A probe in virtual time, over a path whose every packet the test sees: what it says is what happened.

mod common;

use std::cell::RefCell;
use std::rc::Rc;

use common::{VirtualClock, hman_study};
use telespring::rig::{Channel, Trace, trace::IrttDelay};
use telespring::session::wire::LENGTH;
use telespring::session::{LocalTime, Packet, Span};
use telespring_link::clock::Clock;
use telespring_link::probe::{End, Probe, ProbeSettings, Stage};
use telespring_link::transport::{ROOM, Transport, TransportReport};

/// The path towards one side, and what came over it: session, number and age (ns) of each packet.
#[derive(Debug)]
struct Path {
    channel: Box<dyn Channel>,
    is_cut: bool,
    sent: Vec<(u64, u64, u64)>,
    came: Vec<(u64, u64, i64)>,
    injected: Vec<Vec<u8>>,
}

type Paths = Rc<RefCell<[Path; 2]>>;

/// One end of both paths, on a clock that is ahead of the true time.
#[derive(Debug)]
struct End1 {
    side: usize,
    ahead: Span,
    paths: Paths,
}

impl Transport for End1 {
    fn send(&mut self, now: LocalTime, datagram: &[u8]) {
        let now = now - self.ahead;
        let path = &mut self.paths.borrow_mut()[1 - self.side];
        let datagram: [u8; LENGTH] = datagram.try_into().unwrap();
        if let Ok(packet) = Packet::decode(&datagram) {
            path.sent.push((packet.session, packet.sequence, now.0));
        }
        if !path.is_cut {
            path.channel.send(now, datagram);
        }
    }

    fn receive(&mut self, now: LocalTime, room: &mut [u8; ROOM]) -> Option<usize> {
        let now = now - self.ahead;
        let path = &mut self.paths.borrow_mut()[self.side];
        if let Some(datagram) = path.injected.pop() {
            room[..datagram.len()].copy_from_slice(&datagram);
            return Some(datagram.len());
        }
        let datagram = path.channel.deliver(now)?;
        if let Ok(packet) = Packet::decode(&datagram) {
            let sent = path.sent.iter().rfind(|sent| (sent.0, sent.1) == (packet.session, packet.sequence));
            path.came.push((packet.session, packet.sequence, now.0 as i64 - sent.unwrap().2 as i64));
        }
        room[..LENGTH].copy_from_slice(&datagram);
        Some(LENGTH)
    }

    fn report(&self) -> TransportReport {
        TransportReport::default()
    }
}

/// A clock ahead of the virtual one.
struct Ahead(VirtualClock, Span);

impl Clock for Ahead {
    fn now(&self) -> LocalTime {
        self.0.now() + self.1
    }
}

struct Pair {
    clock: VirtualClock,
    clocks: [Ahead; 2],
    paths: Paths,
    probes: [Probe<End1>; 2],
}

/// Two probes over a network with these keys; the clock of the second is 1000 s ahead.
fn pair(delay: f64, network: &str, seconds: f64) -> Pair {
    let study = hman_study(&format!("coupling.stiffness = 100\nnetwork = {{delay = {delay}{network}}}\n"));
    let model = study.laboratory().unwrap().network;
    let paths: Paths = Rc::new(RefCell::new([0, 1].map(|side| Path {
        channel: model.towards(side).channel(Span::from_seconds(delay), 5, side),
        is_cut: false,
        sent: Vec::new(),
        came: Vec::new(),
        injected: Vec::new(),
    })));
    let clock = VirtualClock::default();
    clock.0.set(7_000_000_000);
    let ahead = [Span(0), Span(1_000_000_000_000)];
    let clocks = ahead.map(|ahead| Ahead(clock.clone(), ahead));
    let probes = [0, 1].map(|side| {
        let settings = ProbeSettings {
            session: 31 + side as u64,
            period: Span(1_000_000),
            duration: Span::from_seconds(seconds),
        };
        Probe::new(settings, End1 { side, ahead: ahead[side], paths: Rc::clone(&paths) }).unwrap()
    });
    Pair { clock, clocks, paths, probes }
}

impl Pair {
    fn tick(&mut self, stop: bool) -> [Stage; 2] {
        self.clock.0.set(self.clock.0.get() + 1_000_000);
        [0, 1].map(|side| self.probes[side].tick(&self.clocks[side], stop))
    }

    /// Ticks until both are done.
    fn run(&mut self) -> [Stage; 2] {
        for _ in 0..100_000 {
            let stages = self.tick(false);
            if stages.iter().all(|stage| matches!(stage, Stage::Done(_))) {
                return stages;
            }
        }
        panic!("the probes did not end");
    }
}

#[test]
fn law_both_sides_say_what_happened_to_every_packet_of_both_ways() {
    let mut pair = pair(0.03, ", jitter = 0.02, loss = 0.05", 4.0);
    assert_eq!(pair.run(), [Stage::Done(End::Complete); 2]);
    let outcomes = [0, 1].map(|side| pair.probes[side].outcome());
    let paths = pair.paths.borrow();
    for (side, outcome) in outcomes.iter().enumerate() {
        // the last 4000 packets that the partner sent are those of its measurement
        let sent = paths[side].sent.iter().rev().take(4000).map(|sent| sent.1).min().unwrap();
        let came: Vec<_> = paths[side].came.iter().filter(|came| came.1 >= sent).collect();
        let way = outcome.towards_here.as_ref().unwrap();
        assert_eq!((way.sent, way.received), (4000, came.len() as u64));
        assert!(way.received < 4000);
        assert!((way.lost_share - (4000.0 - came.len() as f64) / 4000.0).abs() < 1e-12);
        let error = outcome.clock_error.unwrap();
        assert!(error > 0.0 && error < 0.05, "{error}");
        let mut ages: Vec<i64> = came.iter().map(|came| came.2).collect();
        ages.sort_unstable();
        let age = way.age.unwrap();
        for (said, true_age) in [
            (age.smallest, ages[0]),
            (age.median, ages[ages.len().div_ceil(2) - 1]),
            (age.largest, *ages.last().unwrap()),
        ] {
            assert!((said - true_age as f64 * 1e-9).abs() <= error + 1e-4, "{said} {true_age} {error}");
        }
        let mut highest = 0;
        let overtaken = came.iter().filter(|came| {
            highest = highest.max(came.1);
            came.1 < highest
        });
        assert_eq!(way.overtaken, overtaken.count() as u64);
        assert!(way.overtaken > 100);
        // the partner tells the same of its way here, each with its own clock
        let told = outcomes[1 - side].towards_partner.as_ref().unwrap();
        assert_eq!((told.sent, told.received, told.bursts), (way.sent, way.received, way.bursts));
        let both = error + outcomes[1 - side].clock_error.unwrap() + 1e-6;
        assert!((told.age.unwrap().median - age.median).abs() <= both);
    }
}

#[test]
fn law_the_trace_is_read_as_it_was() {
    let mut pair = pair(0.02, ", jitter = 0.002, loss = 0.1", 2.0);
    pair.run();
    let outcome = pair.probes[0].outcome();
    let text = pair.probes[0].trace().unwrap();
    for (delay, way) in
        [(IrttDelay::Send, outcome.towards_partner), (IrttDelay::Receive, outcome.towards_here)]
    {
        let (trace, way) = (Trace::from_irtt(&text, delay).unwrap(), way.unwrap());
        let rows = trace.rows();
        assert_eq!(rows.len() as u64, way.sent);
        let came: Vec<f64> = rows.iter().filter(|row| !row.lost).map(|row| row.delay).collect();
        assert_eq!(came.len() as u64, way.received);
        assert!(way.received < way.sent);
        let largest = came.iter().copied().fold(0.0, f64::max);
        assert!((largest - way.age.unwrap().largest).abs() < 1e-9);
    }
}

#[test]
fn law_a_blackout_is_one_burst_and_one_silence() {
    let mut pair = pair(0.01, "", 3.0);
    for tick in 0..100_000 {
        let at = tick as f64 * 1e-3;
        pair.paths.borrow_mut()[1].is_cut = (1.0..1.4).contains(&at);
        if pair.tick(false).iter().all(|stage| matches!(stage, Stage::Done(_))) {
            break;
        }
    }
    let [here, there] = [0, 1].map(|side| pair.probes[side].outcome());
    assert_eq!([here.end, there.end], ["complete"; 2]);
    let (cut, whole) = (there.towards_here.unwrap(), here.towards_here.unwrap());
    assert_eq!((cut.bursts.count, cut.bursts.longest, cut.silences), (1, 400, 1));
    assert!((cut.longest_silence - 0.401).abs() < 1e-3, "{cut:?}");
    assert_eq!((whole.received, whole.bursts.count, whole.silences), (3000, 0, 0));
    assert_eq!(here.towards_partner.unwrap().bursts, cut.bursts);
}

#[test]
fn law_a_partner_that_dies_leaves_the_way_towards_here_known() {
    // in the middle of its measurement, and after it, before it has told anything
    for (alive, expected) in [(1_200, 1_100..1_200), (2_500, 1_990..2_010)] {
        let mut pair = pair(0.01, "", 2.0);
        let mut last = Stage::Waiting;
        for tick in 0..30_000 {
            pair.clock.0.set(pair.clock.0.get() + 1_000_000);
            last = pair.probes[0].tick(&pair.clocks[0], false);
            if tick < alive {
                pair.probes[1].tick(&pair.clocks[1], false);
            }
        }
        assert_eq!(last, Stage::Done(End::Silent));
        let outcome = pair.probes[0].outcome();
        assert!(outcome.towards_partner.is_none());
        assert!(pair.probes[0].trace().is_none());
        let way = outcome.towards_here.unwrap();
        assert!(expected.contains(&way.received) && way.received == way.sent, "{way:?}");
        let error = outcome.clock_error.unwrap() + 1e-3;
        assert!((way.age.unwrap().median - 0.01).abs() <= error, "{way:?} {error}");
    }
}

#[test]
fn law_a_stop_at_one_side_ends_both_measurements_and_what_was_sent_is_reported() {
    for stopped in [[true, true], [true, false], [false, true]] {
        let mut pair = pair(0.01, "", 600.0);
        (0..1_500).for_each(|_| {
            pair.tick(false);
        });
        pair.clock.0.set(pair.clock.0.get() + 1_000_000);
        for side in 0..2 {
            pair.probes[side].tick(&pair.clocks[side], stopped[side]);
        }
        // stragglers of both sides, the reports, and the last word
        let start = pair.clock.0.get();
        let stages = pair.run();
        let took = (pair.clock.0.get() - start) as f64 * 1e-9;
        assert!(took < 5.0, "{stopped:?}: {took} s");
        assert_eq!(stages, [Stage::Done(End::Complete); 2]);
        for side in 0..2 {
            let outcome = pair.probes[side].outcome();
            assert!(pair.probes[side].trace().is_some());
            for way in [outcome.towards_here.unwrap(), outcome.towards_partner.unwrap()] {
                assert!(
                    (1_400..3_000).contains(&way.sent) && way.received == way.sent,
                    "{stopped:?} {way:?}"
                );
            }
        }
    }
}

#[test]
fn law_of_two_durations_the_shorter_counts() {
    let mut short = pair(0.01, "", 1.0);
    let settings =
        ProbeSettings { session: 77, period: Span(1_000_000), duration: Span::from_seconds(600.0) };
    let end = End1 { side: 1, ahead: Span(1_000_000_000_000), paths: Rc::clone(&short.paths) };
    short.probes[1] = Probe::new(settings, end).unwrap();
    assert_eq!(short.run(), [Stage::Done(End::Complete); 2]);
    let way = short.probes[0].outcome().towards_here.unwrap();
    assert!((1_000..3_000).contains(&way.sent), "{way:?}");
}

#[test]
fn law_garbage_and_strangers_change_nothing_but_a_count() {
    let mut pair = pair(0.01, "", 1.0);
    for tick in 0..20_000_u64 {
        let mut stranger = [0_u8; LENGTH];
        stranger[0] = tick as u8;
        pair.paths.borrow_mut()[0].injected = vec![stranger.to_vec(), b"garbage".to_vec()];
        if pair.tick(false).iter().all(|stage| matches!(stage, Stage::Done(_))) {
            break;
        }
    }
    let outcome = pair.probes[0].outcome();
    assert_eq!(outcome.end, "complete");
    assert!(outcome.strange > 1_000 && !outcome.partner_runs_session);
    assert_eq!(outcome.towards_here.unwrap().received, 1000);
}

#[test]
fn law_a_probe_of_no_packet_or_of_too_many_is_refused() {
    let transport = || End1 { side: 0, ahead: Span(0), paths: pair(0.01, "", 1.0).paths };
    for seconds in [0.0, 1e-4, 1001.0, -1.0, f64::NAN] {
        let settings =
            ProbeSettings { session: 1, period: Span(1_000_000), duration: Span::from_seconds(seconds) };
        let refusal = Probe::new(settings, transport()).unwrap_err().to_string();
        assert!(refusal.contains("seconds") && refusal.contains("Give 60."), "{refusal}");
    }
}
