//! Two sites over iroh on this machine: who is let in, what strangers change, and a partner that comes, goes and comes again.

mod links;
mod lossy;

use std::net::UdpSocket;
use std::sync::atomic::Ordering::Relaxed;
use std::time::{Duration, Instant};

use telespring_link::keys::SiteKey;
use telespring_link::transport::{Iroh, IrohSettings, PathEvent, ROOM, Transport};

use links::{NOW, exchange, free_address, wait, wait_for};
use lossy::Lossy;

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
        relay_authority: None,
        relayed: false,
        priority: Some(40),
    })
}

/// Waits until nothing comes or goes for a second; returns how many connections there have been.
fn settle(first: &mut Iroh, second: &mut Iroh) -> [u64; 2] {
    wait_for(first, PathEvent::Direct);
    wait_for(second, PathEvent::Direct);
    let mut quiet = Instant::now();
    let mut connections = [0; 2];
    wait("quiet", || {
        let now = [first.report().connections, second.report().connections];
        if first.poll_path().is_some() || second.poll_path().is_some() || now != connections {
            (connections, quiet) = (now, Instant::now());
        }
        quiet.elapsed() > Duration::from_secs(1)
    });
    connections
}

#[test]
fn law_two_sites_find_each_other_and_exchange() {
    let [first, second] = pair().map(|settings| Iroh::new(&settings).unwrap());
    let [mut first, mut second] = [first, second];
    assert_eq!(exchange(&mut first, &mut second, b"there"), b"there");
    assert_eq!(exchange(&mut second, &mut first, b"and back"), b"and back");
    // one of the two connections that both may have dialled is left, and all goes over it
    let connections = settle(&mut first, &mut second);
    assert!(connections.iter().all(|number| *number <= 2), "{connections:?}");
    for site in [&first, &second] {
        let report = site.report();
        assert!(report.connections >= 1 && report.sent > 0 && report.received > 0, "{report:?}");
        assert_eq!((report.strangers, report.thinned, report.every), (0, 0, 1), "{report:?}");
        assert!(report.round_trip.is_some(), "{report:?}");
    }
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

/// Both sides of a pair with a path that loses this share of the datagrams, and nothing else, between them.
fn lossy_pair(probability: f64) -> Option<(Lossy, [Iroh; 2])> {
    let Ok(six) = UdpSocket::bind("[::1]:0") else {
        eprintln!("SKIPPED: this machine has no IPv6 on loopback");
        return None;
    };
    let sites = [six.local_addr().unwrap(), free_address()];
    drop(six);
    let path = Lossy::new(sites, probability).unwrap();
    let mut settings = pair();
    for side in 0..2 {
        (settings[side].local, settings[side].peers) = (vec![sites[side]], vec![path.doors[side]]);
    }
    let mut links = settings.map(|settings| Iroh::new(&settings).unwrap());
    for link in &mut links {
        wait_for(link, PathEvent::Direct);
    }
    Some((path, links))
}

/// Numbers that have come.
fn take(site: &mut Iroh, got: &mut [bool]) {
    let mut room = [0; ROOM];
    while let Some(length) = site.receive(NOW, &mut room) {
        let number = u64::from_le_bytes(room[..8].try_into().unwrap());
        assert_eq!(length, 112);
        if let Some(place) = got.get_mut(number as usize) {
            *place = true;
        }
    }
}

#[test]
fn law_loss_on_the_wire_makes_hardly_more_loss_in_the_session() {
    const NUMBER: usize = 6000;
    let Some((path, mut sites)) = lossy_pair(0.02) else { return };
    let mut got = [(); 2].map(|()| vec![false; NUMBER]);
    for number in 0..NUMBER {
        let mut content = [0; 112];
        content[..8].copy_from_slice(&number.to_le_bytes());
        for side in 0..2 {
            sites[side].send(NOW, &content);
            // what the machine holds up is not what is judged here
            wait("the thread of the network", || {
                let report = sites[side].report();
                report.sent + report.unsent > number as u64
            });
            take(&mut sites[side], &mut got[side]);
        }
        std::thread::sleep(Duration::from_micros(700));
    }
    std::thread::sleep(Duration::from_millis(300));
    for side in 0..2 {
        take(&mut sites[side], &mut got[side]);
        let lost = got[side].iter().filter(|came| !**came).count() as f64 / NUMBER as f64;
        let wire = path.share(1 - side);
        let report = sites[1 - side].report();
        println!("{lost:.4} of the packets, {wire:.4} of the datagrams");
        assert!(lost <= wire + 0.01, "{lost} of the packets, {wire} of the datagrams: {report:?}");
        assert!(lost > 0.005 && report.unsent == 0 && report.every == 1, "{lost} {report:?}");
        // QUIC knows what got lost, and no more than that
        let known = report.lost as f64 / NUMBER as f64;
        assert!((known - wire).abs() < 0.015, "{known} {wire}");
    }
}

#[test]
fn law_loss_that_lasts_halves_the_rate_and_not_that_of_greetings() {
    let Some((path, mut sites)) = lossy_pair(0.35) else { return };
    let [site, partner] = &mut sites;
    let mut room = [0; ROOM];
    let mut slower = None;
    wait("a lower rate", || {
        if site.is_due() {
            site.send(NOW, &[7; 112]);
        }
        partner.send(NOW, &[7; 112]);
        while site.receive(NOW, &mut room).is_some() || partner.receive(NOW, &mut room).is_some() {}
        if let Some(PathEvent::Rate { every }) = site.poll_path() {
            slower = Some(every);
        }
        slower.is_some()
    });
    assert_eq!(slower, Some(2));
    assert!(path.share(0) > 0.3);
    let thinned = site.report().thinned;
    // a greeting does not ask
    for _ in 0..20 {
        site.send(NOW, b"TSPH a greeting");
    }
    assert_eq!(site.report().thinned, thinned);
    let due = (0..20).filter(|_| site.is_due()).count();
    assert!(due <= 10 && site.report().thinned >= thinned + 10);
}

#[test]
fn law_a_silent_path_is_lost_and_found_again() {
    let Some((path, mut sites)) = lossy_pair(0.0) else { return };
    let [first, second] = &mut sites;
    exchange(first, second, b"there");
    path.is_cut.store(true, Relaxed);
    for site in [&mut *first, &mut *second] {
        wait_for(site, PathEvent::Lost);
    }
    path.is_cut.store(false, Relaxed);
    for site in [&mut *first, &mut *second] {
        wait_for(site, PathEvent::Direct);
    }
    exchange(first, second, b"there again");
    exchange(second, first, b"and back");
}

#[test]
fn law_there_is_one_partner_at_a_time_and_a_former_one_is_not_heard() {
    let Ok(six) = UdpSocket::bind("[::1]:0") else {
        eprintln!("SKIPPED: this machine has no IPv6 on loopback");
        return;
    };
    let addresses = [six.local_addr().unwrap(), free_address()];
    drop(six);
    // the first partner is behind a path that can be cut, the second one is not
    let path = Lossy::new(addresses, 0.0).unwrap();
    let [mut here, mut first] = pair();
    let mut second = IrohSettings { key: SiteKey::generate(), ..first.clone() };
    here.peer_ids.push(second.key.id());
    (here.local, here.peers) = (vec![addresses[0]], vec![path.doors[0]]);
    (first.local, first.peers) = (vec![addresses[1]], vec![path.doors[1]]);
    (second.local, second.peers) = (vec!["[::1]:0".parse().unwrap()], vec![addresses[0]]);
    let [mut site, mut former] = [&here, &first].map(|settings| Iroh::new(settings).unwrap());
    exchange(&mut former, &mut site, b"former");
    let mut other = Iroh::new(&second).unwrap();
    let mut room = [0; ROOM];
    wait("a second partner that is turned away", || {
        other.send(NOW, b"other");
        former.send(NOW, b"former");
        while site.receive(NOW, &mut room).is_some() {
            assert!(!room.starts_with(b"other"));
        }
        site.report().strangers > 0
    });
    path.is_cut.store(true, Relaxed);
    exchange(&mut other, &mut site, b"other");
    // the first one speaks again while the second one is there
    path.is_cut.store(false, Relaxed);
    let (start, mut came) = (Instant::now(), 0);
    while start.elapsed() < Duration::from_secs(3) {
        other.send(NOW, b"other");
        former.send(NOW, b"former");
        while site.receive(NOW, &mut room).is_some() {
            assert!(!room.starts_with(b"former"));
            came += 1;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(came > 100, "{came}");
}

#[test]
fn law_garbage_and_floods_at_the_port_change_nothing() {
    let settings = pair();
    let addresses = settings.each_ref().map(|settings| settings.local[0]);
    let [mut first, mut second] = settings.map(|settings| Iroh::new(&settings).unwrap());
    exchange(&mut first, &mut second, b"before");
    exchange(&mut second, &mut first, b"before");
    let connections = settle(&mut first, &mut second);
    let stranger = UdpSocket::bind("127.0.0.1:0").unwrap();
    let mut state = 1_u64;
    for number in 0..20_000_u32 {
        let mut garbage = [0; 1300];
        for bytes in garbage.chunks_mut(8) {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            bytes.copy_from_slice(&state.to_le_bytes()[..bytes.len()]);
        }
        if number % 2 == 0 {
            // the beginning of a first packet of QUIC, version 1, with ids of 8 bytes
            garbage[..6].copy_from_slice(&[0xc0, 0, 0, 0, 1, 8]);
            garbage[14] = 8;
        }
        let length = [1200, 1300, 21, 112, 1][number as usize % 5];
        let _ = stranger.send_to(&garbage[..length], addresses[number as usize / 2 % 2]);
        if number % 1000 == 0 {
            assert_eq!(exchange(&mut first, &mut second, &number.to_le_bytes()), number.to_le_bytes());
            assert_eq!(exchange(&mut second, &mut first, &number.to_le_bytes()), number.to_le_bytes());
        }
    }
    exchange(&mut first, &mut second, b"after");
    exchange(&mut second, &mut first, b"after");
    assert_eq!([first.report().connections, second.report().connections], connections);
    for site in [&mut first, &mut second] {
        assert_eq!(site.poll_path(), None);
    }
}
