//! Two sites over UDP in real time, on a machine that may be busy: behaviour only, judged by the loop's own clock.

use std::net::UdpSocket;
use std::sync::atomic::{AtomicBool, Ordering};

use telespring::session::{Span, WatchdogState};
use telespring::study::Study;
use telespring_link::conduct::{Plan, conduct};
use telespring_link::demo::ROBOTS;
use telespring_link::device::{Simulated, UdpDevice};
use telespring_link::hello::draw_session;
use telespring_link::real_time::Limits;
use telespring_link::settings::{LoopChoice, PaceChoice};
use telespring_link::site::{Moment, Phase, Safety, SiteSettings};
use telespring_link::summary::Summary;
use telespring_link::transport::{Emulated, Udp};

/// A real-time priority where it is granted. Where it is not, a busy machine keeps a loop from its tick for tens of
/// milliseconds, again and again.
const PRIORITY: LoopChoice =
    LoopChoice { priority: Some(10), lock_memory: false, stay_awake: false, pace: PaceChoice::Clock };
/// For the same reason a standstill of the loop does not let the force go here: the partner's silence is judged.
const PATIENT: Span = Span(100_000_000);

fn study(stiffness: f64) -> Study {
    Study::from_toml(&format!(
        "{ROBOTS}coupling.stiffness = {stiffness}\nnetwork = {{delay = 0.02, jitter = 0.004, loss = 0.02}}\n\
         session = {{strategy = \"guard\", playout = \"adaptive\"}}"
    ))
    .unwrap()
}

/// One site of the study, over UDP and an emulated path, until `stop`.
fn site(study: &Study, side: u8, link: Udp, stop: &AtomicBool, watch: impl FnMut(&Moment)) -> Summary {
    let laboratory = study.laboratory().unwrap();
    let index = usize::from(side) - 1;
    let travel = Span(19_000_000);
    let transport = Emulated::new(link, laboratory.network.towards(index), travel, 3, index);
    let device = Simulated::new(&laboratory, index, 3).unwrap();
    let settings =
        SiteSettings::new(study, side, draw_session(), Safety { stall: PATIENT, ..Safety::default() })
            .unwrap()
            .simulated();
    // no test waits longer
    let limits = Limits { duration: Some(Span::from_seconds(60.0)) };
    let plan = Plan { real_time: PRIORITY, limits, ..Plan::default() };
    conduct(settings, device, transport, plan, stop, watch).unwrap()
}

/// Both ends of a UDP link on this machine.
fn links() -> [Udp; 2] {
    let sockets = [(); 2].map(|()| UdpSocket::bind("127.0.0.1:0").unwrap());
    let [here, there] = sockets.each_ref().map(|socket| socket.local_addr().unwrap());
    let [first, second] = sockets;
    [Udp::on(first, there).unwrap(), Udp::on(second, here).unwrap()]
}

#[test]
fn law_a_session_over_udp_keeps_force_and_account_in_bounds_and_ends_on_both_sides() {
    let (study, [first, second]) = (study(142.0), links());
    let stop = [AtomicBool::new(false), AtomicBool::new(false)];
    let mut engaged = 0;
    let [first, second] = std::thread::scope(|scope| {
        let other = scope.spawn(|| site(&study, 2, second, &stop[1], |_| {}));
        let summary = site(&study, 1, first, &stop[0], |moment| {
            // half a second of full force in all is enough to judge
            engaged += i32::from(moment.state == WatchdogState::Engaged && moment.phase == Phase::Running);
            if engaged == 500 {
                stop[0].store(true, Ordering::Relaxed);
            }
            assert!(moment.force.iter().all(|force| force.is_finite()));
            if !moment.phase.is_coupled() {
                assert_eq!(moment.force, [0.0; 2]);
            }
        });
        [summary, other.join().unwrap()]
    });
    assert!(engaged >= 500, "{engaged} ticks engaged: {first:#?}");
    assert_eq!([first.cause, second.cause], [Some("stop-requested"), Some("partner-left")]);
    for summary in [&first, &second] {
        assert!(summary.largest_force > 0.0 && summary.largest_force <= 20.0, "{summary:#?}");
        assert!(summary.energy.least_balance.unwrap() >= 0.0, "{summary:#?}");
        assert!(summary.loss.received > 300 && summary.loss.lost > 0, "{summary:#?}");
        assert_eq!(summary.refused.datagrams, 0, "{summary:#?}");
        // no packet takes less than the path, and no motion is used before it came
        assert!(summary.round_trip.smallest.unwrap() >= 0.038, "{summary:#?}");
        let error = summary.round_trip.clock_error.unwrap();
        assert!(summary.age.as_ref().unwrap().smallest >= 0.019 - error, "{summary:#?}");
        assert!(summary.round_trip.smallest.unwrap() >= 0.038);
        assert!(!summary.events.iter().any(|entry| entry.event == "clock-stepped"), "{summary:#?}");
    }
}

#[test]
fn law_after_the_partner_has_died_the_force_is_zero_in_time() {
    let (study, [first, second]) = (study(142.0), links());
    let (stop, dead) = (AtomicBool::new(false), AtomicBool::new(false));
    let mut judged = 0;
    std::thread::scope(|scope| {
        let (study, dead) = (&study, &dead);
        // Its thread ends in the middle of a tick, and the socket with it: no goodbye.
        let partner = scope.spawn(move || {
            let never = AtomicBool::new(false);
            let killed = std::panic::AssertUnwindSafe(|| {
                site(study, 2, second, &never, |_| {
                    if dead.load(Ordering::Relaxed) {
                        std::panic::resume_unwind(Box::new("killed"));
                    }
                })
            });
            assert!(std::panic::catch_unwind(killed).is_err());
        });
        let mut full = 0;
        let summary = site(study, 1, first, &stop, |moment| {
            full += i32::from(moment.state == WatchdogState::Engaged && moment.force != [0.0; 2]);
            if full == 100 {
                dead.store(true, Ordering::Relaxed);
            }
            let silent = moment.heard.map(|heard| moment.time - heard);
            if silent.is_some_and(|silent| silent >= Span(150_000_000)) {
                assert_eq!(moment.force, [0.0; 2], "{moment:?}");
                judged += 1;
            }
            if judged == 300 {
                stop.store(true, Ordering::Relaxed);
            }
        });
        partner.join().unwrap();
        assert!(full >= 100 && judged >= 300, "{full} {judged} {summary:#?}");
        assert_eq!(summary.cause, Some("stop-requested"));
        assert!(summary.loss.unreachable > 0, "{summary:#?}");
        assert!(summary.energy.least_balance.unwrap() >= 0.0);
        let silence = ("disengaged", Some("silence"));
        assert!(
            summary.events.iter().any(|entry| (entry.event, entry.cause.as_deref()) == silence),
            "{summary:#?}"
        );
    });
}

#[test]
fn law_nothing_but_a_new_row_of_the_device_sets_the_pace() {
    let study = study(142.0);
    let [link, _partner] = links();
    let [robot, site] = [(); 2].map(|()| UdpSocket::bind("127.0.0.1:0").unwrap());
    let [here, there] = [&robot, &site].map(|socket| socket.local_addr().unwrap());
    robot.connect(there).unwrap();
    // after its deadline a device may count from the beginning: not here
    let device = UdpDevice::on(site, here, Span(10_000_000_000)).unwrap();
    let over = AtomicBool::new(false);
    let seconds = 0.6;
    let summary = std::thread::scope(|scope| {
        let over = &over;
        // noise, rows of zeros, orders, and one row again and again, as fast as a flood
        scope.spawn(move || {
            let row =
                |values: &[f64]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
            let mut sequence = 0.0;
            while !over.load(Ordering::Relaxed) {
                sequence += 1.0;
                let state = row(&[1.0, 7.0, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0]);
                for bytes in [b"noise".to_vec(), vec![0; 104], row(&[1.0, sequence, 14.0, 1.0]), state] {
                    let _ = robot.send(&bytes);
                }
                std::thread::sleep(std::time::Duration::from_micros(100));
            }
        });
        let settings = SiteSettings::new(&study, 1, draw_session(), Safety::default()).unwrap();
        let real_time = LoopChoice { priority: None, pace: PaceChoice::Device, ..PRIORITY };
        let limits = Limits { duration: Some(Span::from_seconds(seconds)) };
        let plan = Plan { real_time, limits, ..Plan::default() };
        let summary = conduct(settings, device, link, plan, &AtomicBool::new(false), |_| {}).unwrap();
        over.store(true, Ordering::Relaxed);
        summary
    });
    // the only row that is new may come in the middle of a period; the goodbye takes 50 ms
    let most = (1e3 * (seconds + 0.06)) as u64;
    assert!(summary.lateness.ticks <= most && summary.lateness.followed <= 1, "{:?}", summary.lateness);
    assert_eq!(summary.cause, Some("time-over"));
}
