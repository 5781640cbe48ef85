//! What gets lost under 20 ms ± 3 ms and 2 % of loss each way, over raw UDP and over iroh in turns, 1000 packets per second.

use std::net::UdpSocket;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};

use super::netns::{Joined, Way, at};
use super::{Failure, median};
use telespring::session::Span;
use telespring_link::clock::{Clock, MonotonicClock};
use telespring_link::keys::SiteKey;
use telespring_link::transport::{Iroh, IrohSettings, ROOM, Transport, Udp};

const CLOCK: MonotonicClock = MonotonicClock;
const PERIOD: Span = Span(1_000_000);
const WAY: Way = Way { delay: 0.02, jitter: 0.003, loss: 0.02, ..Way::IDEAL };

type Site = Box<dyn Transport + Send>;

fn site(kind: &str, side: usize, port: u16, keys: &[SiteKey; 2]) -> Site {
    if kind == "udp" {
        let socket = UdpSocket::bind(at(side, port)).expect("a socket");
        return Box::new(Udp::on(socket, at(1 - side, port)).expect("the partner's address"));
    }
    let settings = IrohSettings {
        key: keys[side].clone(),
        peer_ids: vec![keys[1 - side].id()],
        peers: vec![at(1 - side, port)],
        local: vec![at(side, port)],
        relay: None,
        relay_authority: None,
        relayed: false,
        priority: Some(40),
    };
    Box::new(Iroh::new(&settings).expect("a site"))
}

/// The share that did not come, of both ways.
fn measure(joined: &Joined, kind: &str, port: u16, seconds: u64) -> f64 {
    let keys = [SiteKey::generate(), SiteKey::generate()];
    let count = 1000 * seconds;
    let (ready, came) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let is_over = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let sides: Vec<_> = (0..2)
            .map(|side| {
                let (keys, ready, came, is_over) = (&keys, &ready, &came, &is_over);
                scope.spawn(move || {
                    joined.namespaces[side].enter();
                    let mut site = site(kind, side, port, keys);
                    while kind != "udp" && site.report().round_trip.is_none() {
                        CLOCK.sleep_until(CLOCK.now() + PERIOD);
                    }
                    ready.fetch_add(1, Relaxed);
                    while ready.load(Relaxed) < 2 {
                        CLOCK.sleep_until(CLOCK.now() + PERIOD);
                    }
                    let mut room = [0; ROOM];
                    let mut due = CLOCK.now();
                    // the last packets have a second
                    for number in 0..count + 1000 {
                        due = due + PERIOD;
                        if number < count {
                            site.send(CLOCK.now(), &[side as u8; 112]);
                        }
                        while site.receive(CLOCK.now(), &mut room).is_some() {
                            came.fetch_add(1, Relaxed);
                        }
                        CLOCK.sleep_until(due);
                    }
                    is_over.store(true, Relaxed);
                })
            })
            .collect();
        sides.into_iter().for_each(|side| side.join().expect("a side"));
    });
    1.0 - came.load(Relaxed) as f64 / (2 * count) as f64
}

/// Prints the loss of both and the difference: the medians of these rounds.
pub fn compare(rounds: usize, seconds: u64) -> Result<(), Failure> {
    let mut losses = [Vec::new(), Vec::new()];
    for round in 0..rounds {
        for (kind, (losses, port)) in ["udp", "iroh"].into_iter().zip(losses.iter_mut().zip([4600, 4700])) {
            let Some(joined) = Joined::new(WAY, round as u64) else { return Ok(()) };
            losses.push(measure(&joined, kind, port, seconds));
        }
    }
    let [udp, iroh] = losses.map(|losses| median(losses.into_iter()));
    println!(
        "loss at 20 ms ± 3 ms and 2 % each way: iroh {:.2} %, raw UDP {:.2} %, difference {:.2} percentage points (target 1)",
        100.0 * iroh,
        100.0 * udp,
        100.0 * (iroh - udp)
    );
    Ok(())
}
