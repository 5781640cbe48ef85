//! Two sites over iroh on this machine: who is let in, what strangers change, and a partner that comes, goes and comes again.

use std::net::{SocketAddr, UdpSocket};
use std::time::{Duration, Instant};

use telespring::session::LocalTime;
use telespring_link::keys::SiteKey;
use telespring_link::transport::{Iroh, IrohSettings, PathEvent, ROOM, Transport};

/// How long anything may take on a busy machine.
const PATIENCE: Duration = Duration::from_secs(30);
const NOW: LocalTime = LocalTime(0);

fn free_address() -> SocketAddr {
    UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap()
}

/// Both sides of a pair that know each other; each at an address of its own.
fn pair() -> [IrohSettings; 2] {
    let keys = [(); 2].map(|()| SiteKey::generate());
    let addresses = [(); 2].map(|()| free_address());
    [0, 1].map(|side: usize| IrohSettings {
        key: keys[side].clone(),
        peer_ids: vec![keys[1 - side].id()],
        peers: vec![addresses[1 - side]],
        local: vec![addresses[side]],
        relay: None,
        relayed: false,
    })
}

/// Waits until `done` says so.
fn wait(what: &str, mut done: impl FnMut() -> bool) {
    let start = Instant::now();
    while !done() {
        assert!(start.elapsed() < PATIENCE, "{what}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Waits for a path event.
fn wait_for(site: &mut Iroh, expected: PathEvent) {
    wait(&format!("{expected:?}"), || site.poll_path() == Some(expected));
}

/// Sends from one to the other until something arrives, and returns it.
fn exchange(from: &mut Iroh, to: &mut Iroh, content: &[u8]) -> Vec<u8> {
    let mut room = [0; ROOM];
    let mut got = None;
    wait("a datagram", || {
        from.send(NOW, content);
        while let Some(length) = to.receive(NOW, &mut room) {
            if room.starts_with(content) {
                got = Some(room[..length].to_vec());
            }
        }
        got.is_some()
    });
    got.unwrap()
}

#[test]
fn law_two_sites_find_each_other_and_exchange() {
    let [first, second] = pair().map(|settings| Iroh::new(&settings).unwrap());
    let [mut first, mut second] = [first, second];
    wait_for(&mut first, PathEvent::Direct);
    wait_for(&mut second, PathEvent::Direct);
    assert_eq!(exchange(&mut first, &mut second, b"there"), b"there");
    assert_eq!(exchange(&mut second, &mut first, b"and back"), b"and back");
    for site in [&first, &second] {
        let report = site.report();
        assert!(report.connections >= 1 && report.sent > 0 && report.received > 0, "{report:?}");
        assert_eq!((report.strangers, report.thinned, report.every), (0, 0, 1), "{report:?}");
        assert!(report.round_trip.is_some(), "{report:?}");
    }
    // one of the two connections that both have dialled is left, and all goes over it
    let settled = [first.report().connections, second.report().connections];
    std::thread::sleep(Duration::from_millis(500));
    assert_eq!([first.report().connections, second.report().connections], settled);
}

#[test]
fn law_one_reachable_side_is_enough() {
    for open in 0..2 {
        let mut settings = pair();
        // the open side is dialled and dials nobody
        settings[open].peers.clear();
        let [mut first, mut second] = settings.map(|settings| Iroh::new(&settings).unwrap());
        exchange(&mut first, &mut second, b"there");
        exchange(&mut second, &mut first, b"back");
    }
}

#[test]
fn law_an_unknown_key_is_refused_and_changes_nothing() {
    let [mine, partner] = pair();
    // at the partner's address, knowing this site, but with another key
    let stranger = IrohSettings { key: SiteKey::generate(), ..partner.clone() };
    let mut site = Iroh::new(&mine).unwrap();
    let mut other = Iroh::new(&stranger).unwrap();
    let mut room = [0; ROOM];
    wait("a refusal", || {
        other.send(NOW, b"let me in");
        site.report().strangers > 0
    });
    for _ in 0..200 {
        other.send(NOW, b"let me in");
        assert_eq!(site.receive(NOW, &mut room), None);
        std::thread::sleep(Duration::from_millis(1));
    }
    let report = site.report();
    assert_eq!((report.connections, report.received, report.sent), (0, 0, 0), "{report:?}");
    assert_eq!(site.poll_path(), None);
    // the true partner is let in nevertheless
    drop(other);
    let mut partner = Iroh::new(&partner).unwrap();
    exchange(&mut partner, &mut site, b"it is me");
}

#[test]
fn law_a_partner_that_starts_anew_comes_back() {
    // whichever side starts anew, with the smaller or the larger id
    for restarted in 0..2 {
        let settings = pair();
        let [first, second] = settings.each_ref().map(|settings| Some(Iroh::new(settings).unwrap()));
        let mut sites = [first, second];
        for round in 0..3_u8 {
            let [Some(first), Some(second)] = &mut sites else { panic!() };
            exchange(first, second, &[b'a', round]);
            exchange(second, first, &[b'b', round]);
            sites[restarted] = None;
            sites[restarted] = Some(Iroh::new(&settings[restarted]).unwrap());
        }
        let stayed = sites[1 - restarted].as_ref().unwrap().report();
        assert!(stayed.connections >= 3, "{stayed:?}");
    }
}

#[test]
fn law_a_port_that_somebody_has_is_refused() {
    let [settings, _] = pair();
    let taken = UdpSocket::bind(settings.local[0]).unwrap();
    assert!(Iroh::new(&settings).is_err());
    drop(taken);
    assert!(Iroh::new(&settings).is_ok());
}
