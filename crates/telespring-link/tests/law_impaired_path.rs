//! The impaired path that the tests of faults rest on does what it is asked to: in virtual time, and between two namespaces.

mod netns;

use std::net::UdpSocket;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use netns::{Counts, Joined, Line, Way, at};

const PACKETS: u64 = 20_000;

/// Sends packets of 100 bytes, one per ms, and returns when each came (s), with its number, and the counts.
fn passage(way: Way, seed: u64, packets: u64) -> (Vec<(f64, u64)>, Counts) {
    let mut line = Line::new(way, seed);
    let mut came = Vec::new();
    for step in 0..packets * 20 + 100_000 {
        let now = step as f64 * 5e-5;
        if step % 20 == 0 && step / 20 < packets {
            let mut packet = [0; 100];
            packet[..8].copy_from_slice(&(step / 20).to_le_bytes());
            line.take(now, &packet);
        }
        while let Some(packet) = line.give(now) {
            assert_eq!(packet.len(), 100);
            came.push((now, u64::from_le_bytes(packet[..8].try_into().unwrap())));
        }
    }
    let counts = line.counts();
    assert_eq!((counts.taken, counts.given), (packets, came.len() as u64));
    assert_eq!(counts.travelling(), 0);
    (came, counts)
}

/// 4 standard errors of a share.
fn error(share: f64) -> f64 {
    4.0 * (share * (1.0 - share) / PACKETS as f64).sqrt()
}

#[test]
fn law_delay_jitter_and_loss_are_as_asked() {
    let way = Way { delay: 0.02, jitter: 0.003, loss: 0.02, ..Way::IDEAL };
    let (came, counts) = passage(way, 1, PACKETS);
    assert!((counts.lost as f64 / PACKETS as f64 - 0.02).abs() < error(0.02), "{counts:?}");
    let taken: Vec<f64> = came.iter().map(|(now, number)| now - *number as f64 * 1e-3).collect();
    // looked for every 50 µs
    assert!(taken.iter().all(|taken| (0.017 - 1e-9..0.0231).contains(taken)));
    let mean = taken.iter().sum::<f64>() / taken.len() as f64;
    // half a look, and 4 standard errors of a uniform distribution
    let spread = 4.0 * 0.003 / 3.0_f64.sqrt() / (PACKETS as f64).sqrt();
    assert!((mean - 0.02 - 2.5e-5).abs() < spread + 2.5e-5, "{mean}");
    // one per ms over 6 ms: most are out of order
    assert!(counts.overtaken > PACKETS / 4, "{counts:?}");
    assert_eq!(counts.overtaken, overtaken(&came));
    assert_eq!(passage(way, 1, 500), passage(way, 1, 500));
    assert_ne!(passage(way, 1, 500).0, passage(way, 2, 500).0);
}

/// How many came after one that was sent later.
fn overtaken(came: &[(f64, u64)]) -> u64 {
    let mut newest = 0;
    let late = came.iter().filter(|(_, number)| {
        let is_late = *number < newest;
        newest = newest.max(*number);
        is_late
    });
    late.count() as u64
}

#[test]
fn law_copies_order_darkness_and_a_slow_link_are_as_asked() {
    let way = Way { delay: 0.01, jitter: 0.003, copies: 0.1, keeps_order: true, ..Way::IDEAL };
    let (came, counts) = passage(way, 3, PACKETS);
    assert!((counts.copied as f64 / PACKETS as f64 - 0.1).abs() < error(0.1), "{counts:?}");
    assert_eq!(counts.given, PACKETS + counts.copied);
    // a copy of an earlier packet may come between two; none overtakes
    assert_eq!(counts.overtaken, 0, "{counts:?}");
    assert_eq!(overtaken(&came), 0);
    let (came, counts) = passage(Way { is_dark: true, ..way }, 3, 100);
    assert!(came.is_empty() && counts.dark == 100);
    // 100 bytes at 50 kB/s take 2 ms: packet n waits for n ms, then half of all are lost
    let slow = Way { rate: Some(50e3), longest_wait: 0.05, ..Way::IDEAL };
    let (came, counts) = passage(slow, 4, 1000);
    for (now, number) in came.iter().take_while(|(_, number)| *number < 50) {
        let expected = *number as f64 * 2e-3 + 2e-3;
        assert!((now - expected).abs() < 1.1e-4, "{number}: {now} {expected}");
    }
    assert!(counts.crowded.abs_diff(1000 / 2 - 25) <= 2, "{counts:?}");
}

/// Sends numbered packets from namespace 0 to namespace 1, one per ms, and returns those that came, with how long each took
/// (s). So few that the receiver's buffer holds all of them, should it not get the processor.
fn ping(joined: &Joined, port: u16, packets: u64) -> Vec<(u64, f64)> {
    let [from, to] =
        [0, 1].map(|side| joined.namespaces[side].within(|| UdpSocket::bind(at(side, port)).unwrap()));
    let start = Instant::now();
    let is_over = AtomicBool::new(false);
    to.set_read_timeout(Some(Duration::from_millis(20))).unwrap();
    std::thread::scope(|scope| {
        let receiver = scope.spawn(|| {
            let (mut came, mut room) = (Vec::new(), [0; 200]);
            loop {
                // before the look: what is there when all is at rest is taken, too
                let is_last = is_over.load(Ordering::Relaxed);
                while let Ok((length, sender)) = to.recv_from(&mut room) {
                    assert_eq!((length, sender), (100, at(0, port)));
                    let number = u64::from_le_bytes(room[..8].try_into().unwrap());
                    let sent = f64::from_le_bytes(room[8..16].try_into().unwrap());
                    came.push((number, start.elapsed().as_secs_f64() - sent));
                }
                if is_last {
                    return came;
                }
            }
        });
        for number in 0..packets {
            let mut packet = [0; 100];
            packet[..8].copy_from_slice(&number.to_le_bytes());
            packet[8..16].copy_from_slice(&start.elapsed().as_secs_f64().to_le_bytes());
            from.send_to(&packet, at(1, port)).unwrap();
            std::thread::sleep(Duration::from_millis(1));
        }
        joined.path.counts_at_rest();
        is_over.store(true, Ordering::Relaxed);
        receiver.join().unwrap()
    })
}

fn numbers(came: &[(u64, f64)]) -> Vec<u64> {
    let mut numbers: Vec<u64> = came.iter().map(|(number, _)| *number).collect();
    numbers.sort_unstable();
    numbers
}

#[test]
fn law_between_two_namespaces_the_path_does_as_in_virtual_time() {
    let way = Way { delay: 0.02, jitter: 0.003, loss: 0.1, copies: 0.1, ..Way::IDEAL };
    let Some(joined) = Joined::new(way, 5) else { return };
    let came = ping(&joined, 4000, 200);
    let [there, back] = joined.path.counts();
    assert_eq!((there.taken, back), (200, Counts::default()));
    // the same chances, so the very same packets
    let (expected, counts) = passage(way, 10, 200);
    assert_eq!((there.lost, there.copied), (counts.lost, counts.copied));
    let expected: Vec<(u64, f64)> = expected.iter().map(|(now, number)| (*number, *now)).collect();
    assert_eq!(numbers(&came), numbers(&expected));
    // never earlier than asked, and later only where the machine is busy
    let shortest = came.iter().map(|(_, taken)| *taken).fold(f64::INFINITY, f64::min);
    assert!((0.017..0.02).contains(&shortest), "{shortest}");
}

#[test]
fn law_a_test_turns_the_light_off_and_on_and_pairs_do_not_meet() {
    let Some(joined) = Joined::new(Way::IDEAL, 1) else { return };
    // the same addresses, another world
    let Some(other) = Joined::new(Way::IDEAL, 1) else { return };
    assert_eq!(numbers(&ping(&joined, 4000, 20)), (0..20).collect::<Vec<u64>>());
    joined.path.change_from(0, |way| way.is_dark = true);
    assert_eq!(ping(&joined, 4001, 20), []);
    joined.path.change(|way| way.is_dark = false);
    assert_eq!(ping(&joined, 4002, 20).len(), 20);
    assert_eq!(joined.path.counts()[0], Counts { taken: 60, dark: 20, given: 40, ..Counts::default() });
    assert_eq!(other.path.counts(), [Counts::default(); 2]);
    assert_eq!(ping(&other, 4000, 20).len(), 20);
}
