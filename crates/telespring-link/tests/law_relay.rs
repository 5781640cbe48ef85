//! Two sites and a relay of their own, iroh's server program: a direct way is found through it, packets go over it only where
//! both sites allow it, and whoever is not on its list gets nowhere.
//!
//! `make test-relay` builds the server and says where it is; without it each test is skipped.

mod links;
mod lossy;
mod relay;

use std::fs;
use std::net::{SocketAddr, UdpSocket};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::Ordering::Relaxed;
use std::time::{Duration, Instant};

use serde_json::Value;
use telespring_link::keys::SiteKey;
use telespring_link::transport::{Authority, Iroh, IrohSettings, PathEvent, ROOM, Transport};

use links::{NOW, exchange, free_address, wait, wait_for};
use lossy::Lossy;
use relay::Relay;

/// Both ends of IPv4 and of IPv6 on this machine: from one to the other there is no direct way.
const APART: [&str; 2] = ["127.0.0.1:0", "[::1]:0"];
/// There is one.
const TOGETHER: [&str; 2] = ["127.0.0.1:0", "127.0.0.1:0"];

/// Two sites that know each other's keys and the relay, and no address; `None` where something is missing.
fn sites(name: &str, local: [&str; 2], relayed: [bool; 2]) -> Option<(Relay, [IrohSettings; 2])> {
    if UdpSocket::bind("[::1]:0").is_err() {
        eprintln!("SKIPPED: this machine has no IPv6 on loopback");
        return None;
    }
    let keys = [(); 2].map(|()| SiteKey::generate());
    let relay = Relay::start(name, keys.each_ref().map(SiteKey::id))?;
    let settings = [0, 1].map(|side: usize| IrohSettings {
        key: keys[side].clone(),
        peer_ids: vec![keys[1 - side].id()],
        peers: Vec::new(),
        local: vec![local[side].parse().unwrap()],
        relay: Some(relay.url.parse().unwrap()),
        relay_authority: Some(Authority::read("network.relay_authority", &relay.authority).unwrap()),
        relayed: relayed[side],
        priority: Some(40),
    });
    Some((relay, settings))
}

fn open(settings: &[IrohSettings; 2]) -> [Iroh; 2] {
    settings.each_ref().map(|settings| Iroh::new(settings).unwrap())
}

/// Sends both ways for a while; nothing may come.
fn nothing_comes(sites: &mut [Iroh; 2], seconds: u64) {
    let start = Instant::now();
    let mut room = [0; ROOM];
    while start.elapsed() < Duration::from_secs(seconds) {
        for site in &mut *sites {
            site.send(NOW, b"over the relay");
            assert_eq!(site.receive(NOW, &mut room), None);
        }
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn law_a_direct_way_is_found_through_a_relay() {
    let Some((_relay, settings)) = sites("direct", TOGETHER, [false; 2]) else { return };
    let mut sites = open(&settings);
    for site in &mut sites {
        wait_for(site, PathEvent::Direct);
    }
    let [first, second] = &mut sites;
    exchange(first, second, b"there");
    exchange(second, first, b"and back");
}

#[test]
fn law_without_leave_no_packet_goes_over_a_relay() {
    let Some((_relay, settings)) = sites("withheld", APART, [false; 2]) else { return };
    let mut sites = open(&settings);
    for site in &mut sites {
        wait_for(site, PathEvent::Withheld);
    }
    nothing_comes(&mut sites, 2);
    for site in &sites {
        let report = site.report();
        assert_eq!((report.sent, report.received), (0, 0), "{report:?}");
        assert!(report.unsent > 100 && report.connections > 0, "{report:?}");
    }
}

#[test]
fn law_leave_at_one_site_is_none_at_the_other() {
    for allowed in 0..2 {
        let mut relayed = [false; 2];
        relayed[allowed] = true;
        let Some((_relay, settings)) = sites(&format!("one-{allowed}"), APART, relayed) else { return };
        let mut sites = open(&settings);
        let start = Instant::now();
        let mut events = [None; 2];
        // from the first moment on, and after it
        while events.iter().any(Option::is_none) || start.elapsed() < Duration::from_secs(4) {
            assert!(start.elapsed() < Duration::from_secs(60), "{events:?}");
            for side in 0..2 {
                sites[side].send(NOW, b"over the relay");
                assert_eq!(sites[side].receive(NOW, &mut [0; ROOM]), None);
                let told = sites[side].poll_path();
                let is_way = matches!(told, Some(PathEvent::Relayed | PathEvent::Withheld));
                events[side] = told.filter(|_| is_way).or(events[side]);
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        assert_eq!(events[allowed], Some(PathEvent::Relayed));
        assert_eq!(events[1 - allowed], Some(PathEvent::Withheld));
        // one sends, and the other one does not take it
        assert!(sites[allowed].report().sent > 0);
        let other = sites[1 - allowed].report();
        assert_eq!((other.sent, other.received), (0, 0), "{other:?}");
    }
}

#[test]
fn law_with_leave_at_both_sites_packets_go_over_a_relay() {
    let Some((_relay, settings)) = sites("relayed", APART, [true; 2]) else { return };
    let mut sites = open(&settings);
    for site in &mut sites {
        wait_for(site, PathEvent::Relayed);
    }
    let [first, second] = &mut sites;
    exchange(first, second, b"there");
    exchange(second, first, b"and back");
    let mut came = 0;
    for _ in 0..2000 {
        first.send(NOW, &[7; 112]);
        while second.receive(NOW, &mut [0; ROOM]).is_some() {
            came += 1;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    println!("{came} of 2000 came, {:?}", first.report());
    assert!(came > 200, "{came}: {:?}", first.report());
}

#[test]
fn law_a_relay_serves_nobody_else() {
    let Some((_relay, [mine, partner])) = sites("stranger", APART, [true; 2]) else { return };
    // it has every address and the partner's id, and another key
    let stranger = IrohSettings { key: SiteKey::generate(), ..partner.clone() };
    let mut site = Iroh::new(&mine).unwrap();
    let mut other = Iroh::new(&stranger).unwrap();
    for _ in 0..4000 {
        other.send(NOW, b"let me in");
        assert_eq!(site.receive(NOW, &mut [0; ROOM]), None);
        std::thread::sleep(Duration::from_millis(1));
    }
    // it did not even come to the door
    let reports = [site.report(), other.report()];
    assert_eq!(reports.map(|report| (report.connections, report.strangers)), [(0, 0); 2], "{reports:?}");
    drop(other);
    let mut partner = Iroh::new(&partner).unwrap();
    exchange(&mut partner, &mut site, b"it is me");
}

#[test]
fn law_a_relay_with_a_certificate_of_another_authority_is_not_used() {
    let Some((relay, settings)) = sites("authority", APART, [true; 2]) else { return };
    let settings = settings.map(|settings| IrohSettings { relay_authority: None, ..settings });
    let mut sites = open(&settings);
    nothing_comes(&mut sites, 4);
    assert_eq!(sites.map(|site| site.report().connections), [0; 2]);
    drop(relay);
}

/// The next path event that is one of these.
fn next(site: &mut Iroh, among: &[PathEvent]) -> PathEvent {
    let mut told = None;
    wait(&format!("{among:?}"), || {
        told = site.poll_path().filter(|event| among.contains(event));
        told.is_some()
    });
    told.unwrap()
}

#[test]
fn law_a_direct_way_that_fails_is_told_and_found_again_and_the_relay_takes_over_only_with_leave() {
    for relayed in [true, false] {
        let name = format!("over-{relayed}");
        let Some((_relay, mut settings)) = sites(&name, APART, [relayed; 2]) else { return };
        let six = UdpSocket::bind("[::1]:0").unwrap();
        let addresses: [SocketAddr; 2] = [six.local_addr().unwrap(), free_address()];
        drop(six);
        let path = Lossy::new(addresses, 0.0).unwrap();
        for side in 0..2 {
            settings[side].local = vec![addresses[side]];
            settings[side].peers = vec![path.doors[side]];
        }
        let mut sites = open(&settings);
        for site in &mut sites {
            wait_for(site, PathEvent::Direct);
        }
        path.is_cut.store(true, Relaxed);
        let after = if relayed { PathEvent::Relayed } else { PathEvent::Withheld };
        for site in &mut sites {
            assert_eq!(next(site, &[PathEvent::Relayed, PathEvent::Withheld]), after);
        }
        // what was on its way
        std::thread::sleep(Duration::from_millis(300));
        for site in &mut sites {
            while site.receive(NOW, &mut [0; ROOM]).is_some() {}
        }
        let [first, second] = &mut sites;
        if relayed {
            exchange(first, second, b"over the relay");
            exchange(second, first, b"and back");
        } else {
            nothing_comes(&mut sites, 2);
            // iroh does not try the addresses that it was given again, unless the two connect anew
            path.is_cut.store(false, Relaxed);
            for site in &mut sites {
                let start = Instant::now();
                while site.poll_path() != Some(PathEvent::Direct) {
                    assert!(start.elapsed() < Duration::from_secs(90), "the direct way is not found again");
                    std::thread::sleep(Duration::from_millis(1));
                }
            }
            let [first, second] = &mut sites;
            exchange(first, second, b"directly again");
            exchange(second, first, b"and back");
        }
    }
}

/// Two site files of simulated robots, and the programs that run them over a relay.
fn programs(name: &str, relayed: bool) -> Option<[Value; 2]> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("over-relay-{name}"));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    let keys = [1, 2].map(|side| SiteKey::create(&folder.join(format!("{side}.key"))).unwrap());
    let relay = Relay::start(&format!("program-{name}"), keys.each_ref().map(SiteKey::id))?;
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples");
    fs::copy(examples.join("connect.toml"), folder.join("connect.toml")).unwrap();
    fs::copy(&relay.authority, folder.join("authority.pem")).unwrap();
    let children: [Child; 2] = [0, 1].map(|side: usize| {
        let site: PathBuf = folder.join(format!("site-{}.toml", side + 1));
        let (number, id, local, url) = (side + 1, keys[1 - side].id(), APART[side], &relay.url);
        let text = format!(
            "study = \"connect.toml\"\nside = {number}\n[network]\ntransport = \"iroh\"\nkey = \"{number}.key\"\n\
             peer_id = \"{id}\"\nlocal = \"{local}\"\nrelay = \"{url}\"\nrelay_authority = \"authority.pem\"\n\
             relayed = {relayed}\n[safety]\nstall = 0.5\n"
        );
        fs::write(&site, text).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_telespring-link"));
        command.arg("run").arg(site).args(["--seconds", "10"]);
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    });
    Some(children.map(|child| {
        let output = child.wait_with_output().unwrap();
        serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {output:?}"))
    }))
}

fn has(summary: &Value, event: &str) -> bool {
    summary["events"].as_array().unwrap().iter().any(|entry| entry["event"] == event)
}

#[test]
fn law_two_programs_are_coupled_over_a_relay_only_with_leave() {
    if UdpSocket::bind("[::1]:0").is_err() {
        eprintln!("SKIPPED: this machine has no IPv6 on loopback");
        return;
    }
    let Some(sites) = programs("relayed", true) else { return };
    for site in &sites {
        // both sides have heard each other; how much comes in time depends on the machine, which runs the relay as well
        assert!(has(site, "path-relayed") && has(site, "agreed") && has(site, "partner-consented"), "{site}");
        assert!(site["energy"]["least_balance"].as_f64().unwrap() >= 0.0, "{site}");
    }
    let Some(sites) = programs("withheld", false) else { return };
    for site in &sites {
        assert!(has(site, "path-withheld") && !has(site, "agreed"), "{site}");
        assert_eq!([&site["largest_force"], &site["coupled_share"]], [0.0, 0.0], "{site}");
        assert_eq!(site["loss"]["received"], 0, "{site}");
    }
}
