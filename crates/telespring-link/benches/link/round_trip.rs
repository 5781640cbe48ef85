//! The round trip of a packet between two sites on this machine, 1000 times per second, over raw UDP and over iroh in turns.
//!
//! Both sides look for packets every 20 µs, so that the transport shows and not a tick.

use std::net::UdpSocket;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use super::{Failure, median};
use telespring::session::{LocalTime, Span};
use telespring_link::clock::{Clock, MonotonicClock};
use telespring_link::keys::SiteKey;
use telespring_link::transport::{Iroh, IrohSettings, ROOM, Transport, Udp};

const PERIOD: Span = Span(1_000_000);
/// From one look to the next.
const POLL: Span = Span(20_000);
const CLOCK: MonotonicClock = MonotonicClock;

type Site = Box<dyn Transport + Send>;

fn sites(kind: &str) -> Result<[Site; 2], Failure> {
    let sockets = [UdpSocket::bind("127.0.0.1:0")?, UdpSocket::bind("127.0.0.1:0")?];
    let [here, there] = [sockets[0].local_addr()?, sockets[1].local_addr()?];
    let [first, second] = sockets;
    if kind == "udp" {
        return Ok([Box::new(Udp::on(first, there)?), Box::new(Udp::on(second, here)?)]);
    }
    drop((first, second));
    let keys = [SiteKey::generate(), SiteKey::generate()];
    let site = |side: usize| -> Result<Site, Failure> {
        let (local, peer) = if side == 0 { (here, there) } else { (there, here) };
        Ok(Box::new(Iroh::new(&IrohSettings {
            key: keys[side].clone(),
            peer_ids: vec![keys[1 - side].id()],
            peers: vec![peer],
            local: vec![local],
            relay: None,
            relay_authority: None,
            relayed: false,
            priority: Some(40),
        })?))
    };
    let mut sites = [site(0)?, site(1)?];
    while sites.iter_mut().any(|site| site.report().round_trip.is_none()) {
        CLOCK.sleep_until(CLOCK.now() + PERIOD);
    }
    Ok(sites)
}

/// Half of the round trips, and 99 of 100, take no longer than this, s.
fn measure(kind: &str, seconds: u64) -> Result<[f64; 2], Failure> {
    let [mut site, mut partner] = sites(kind)?;
    let is_over = AtomicBool::new(false);
    let mut times = Vec::new();
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let mut room = [0; ROOM];
            while !is_over.load(Relaxed) {
                while let Some(length) = partner.receive(CLOCK.now(), &mut room) {
                    partner.send(CLOCK.now(), &room[..length]);
                }
                CLOCK.sleep_until(CLOCK.now() + POLL);
            }
        });
        let mut room = [0; ROOM];
        let mut due = CLOCK.now();
        for _ in 0..1000 * seconds {
            due = due + PERIOD;
            let mut content = [0; 112];
            content[..8].copy_from_slice(&CLOCK.now().0.to_le_bytes());
            site.send(CLOCK.now(), &content);
            while CLOCK.now() < due {
                while site.receive(CLOCK.now(), &mut room).is_some() {
                    let sent = LocalTime(u64::from_le_bytes(room[..8].try_into().unwrap_or_default()));
                    times.push((CLOCK.now() - sent).seconds());
                }
                CLOCK.sleep_until(CLOCK.now() + POLL);
            }
        }
        is_over.store(true, Relaxed);
    });
    times.sort_by(f64::total_cmp);
    let at =
        |share: f64| times.get((share * (times.len() as f64 - 1.0)) as usize).copied().unwrap_or(f64::NAN);
    Ok([at(0.5), at(0.99)])
}

/// Prints round trips and ratios: the medians of these rounds.
pub fn compare(rounds: usize, seconds: u64) -> Result<(), Failure> {
    let mut all = [Vec::new(), Vec::new()];
    for _ in 0..rounds {
        for (kind, times) in ["udp", "iroh"].into_iter().zip(&mut all) {
            times.push(measure(kind, seconds)?);
        }
    }
    let [udp, iroh] =
        all.each_ref().map(|times| [0, 1].map(|which| median(times.iter().map(|time| time[which]))));
    for (which, name, target) in [(0, "half below", 2.5), (1, "99 of 100 below", 1.5)] {
        println!(
            "round trip, {name}: iroh {:.0} µs, raw UDP {:.0} µs, ratio {:.2} (target {target})",
            1e6 * iroh[which],
            1e6 * udp[which],
            iroh[which] / udp[which]
        );
    }
    Ok(())
}
