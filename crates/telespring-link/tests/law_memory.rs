//! From its start on a loop allocates nothing: in real time, through a greeting, a session, garbage and its end.

#[path = "../../telespring/tests/watched_allocator/mod.rs"]
mod watched_allocator;

use std::net::UdpSocket;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use telespring::session::Span;
use telespring::study::Study;
use telespring_link::device::Simulated;
use telespring_link::keys::SiteKey;
use telespring_link::real_time::{Limits, Pace, run};
use telespring_link::site::{Cause, Phase, Safety, Site, SiteSettings};
use telespring_link::transport::{Iroh, IrohSettings, Transport, Udp};
use watched_allocator::{FORBIDDEN, USES};

/// Runs one side for a second and returns the uses of the allocator by its loop, and how the session went.
fn uses(
    study: &Study,
    side: u8,
    link: impl Transport,
    seconds: f64,
    flood: Option<&UdpSocket>,
) -> (u64, Phase, Cause, u64) {
    let laboratory = study.laboratory().unwrap();
    let device = Simulated::new(&laboratory, usize::from(side) - 1, 1).unwrap();
    let settings = SiteSettings::new(study, side, u64::from(side), Safety::default()).unwrap().simulated();
    let mut site = Site::new(settings, device, link).unwrap();
    let limits = Limits { duration: Some(Span::from_seconds(seconds)) };
    let stop = AtomicBool::new(false);
    let mut pace = Pace::new(Span(1_000_000));
    USES.set(0);
    FORBIDDEN.set(true);
    run(&mut site, &mut pace, limits, &stop, true, |_| {
        if let Some(flood) = flood {
            let _ = flood.send(b"no packet");
        }
    });
    FORBIDDEN.set(false);
    (USES.get(), site.phase(), site.cause().unwrap(), site.session_report().refused)
}

fn study() -> Study {
    FORBIDDEN.set(true);
    drop(std::hint::black_box(Box::new(1)));
    FORBIDDEN.set(false);
    // the count works
    assert!(USES.get() > 0);
    Study::from_toml(
        "robot1 = {mass = 1, damping = 8, axes = [\"x\", \"y\"]}\n\
         robot2 = {mass = 1, damping = 8, axes = [\"x\", \"y\"]}\n\
         coupling.stiffness = 100\nnetwork.delay = 0.005\nsession = {strategy = \"guard\", playout = \"adaptive\"}",
    )
    .unwrap()
}

#[test]
fn law_the_loop_allocates_nothing() {
    let study = study();
    let sockets = [(); 2].map(|()| UdpSocket::bind("127.0.0.1:0").unwrap());
    let [here, there] = sockets.each_ref().map(|socket| socket.local_addr().unwrap());
    let [first, second] = sockets;
    // garbage from the partner's own address
    let flood = second.try_clone().unwrap();
    let links = [Udp::on(first, there).unwrap(), Udp::on(second, here).unwrap()];
    let [first, second] = links;
    let [first, second] = std::thread::scope(|scope| {
        let study = &study;
        let flood = &flood;
        let first = scope.spawn(move || uses(study, 1, first, 1.5, None));
        let second = scope.spawn(move || uses(study, 2, second, 10.0, Some(flood)));
        [first.join().unwrap(), second.join().unwrap()]
    });
    assert_eq!((first.0, first.1, first.2), (0, Phase::Ended, Cause::TimeOver));
    assert_eq!((second.0, second.1, second.2), (0, Phase::Ended, Cause::PartnerLeft));
    assert!(first.3 > 100, "{}", first.3);
}

#[test]
fn law_the_loop_allocates_nothing_over_iroh() {
    let study = study();
    let keys = [(); 2].map(|()| SiteKey::generate());
    let places = [(); 2].map(|()| UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap());
    let [first, second] = [0, 1].map(|side: usize| {
        Iroh::new(&IrohSettings {
            key: keys[side].clone(),
            peer_ids: vec![keys[1 - side].id()],
            peers: vec![places[1 - side]],
            local: vec![places[side]],
            relay: None,
            relay_authority: None,
            relayed: false,
            priority: Some(40),
        })
        .unwrap()
    });
    let start = Instant::now();
    while first.report().connections == 0 || second.report().connections == 0 {
        assert!(start.elapsed() < Duration::from_secs(30));
        std::thread::sleep(Duration::from_millis(1));
    }
    let [first, second] = std::thread::scope(|scope| {
        let study = &study;
        let first = scope.spawn(move || uses(study, 1, first, 2.0, None));
        let second = scope.spawn(move || uses(study, 2, second, 10.0, None));
        [first.join().unwrap(), second.join().unwrap()]
    });
    assert_eq!((first.0, first.1, first.2), (0, Phase::Ended, Cause::TimeOver));
    assert_eq!((second.0, second.1, second.2), (0, Phase::Ended, Cause::PartnerLeft));
}
