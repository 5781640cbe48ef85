//! Laws of one side of a coupling: bytes, play-out and force.

use proptest::prelude::*;
use telespring::session::motion::MAX_VALUE;
use telespring::session::wire::LENGTH;
use telespring::session::{Endpoint, Law, Motion, Nanoseconds, Packet, PacketError, Playout};

fn at(x: f64) -> Motion {
    Motion { position: [x, -x], velocity: [2.0 * x, 0.0] }
}

fn motions() -> impl Strategy<Value = Motion> {
    let value = -MAX_VALUE..=MAX_VALUE;
    [value.clone(), value.clone(), value.clone(), value]
        .prop_map(|[x, y, u, v]| Motion { position: [x, y], velocity: [u, v] })
}

proptest! {
    #[test]
    fn law_a_packet_comes_back_as_it_went(sequence: u64, time: u64, motion in motions()) {
        let packet = Packet { sequence, time: Nanoseconds(time), motion };
        prop_assert_eq!(Packet::decode(&packet.encode()), Ok(packet));
    }

    #[test]
    fn law_no_bytes_are_taken_for_a_packet_or_break_it(bytes in prop::collection::vec(any::<u8>(), 0..80)) {
        prop_assert!(Packet::decode(&bytes).is_err());
    }

    #[test]
    fn law_a_damaged_packet_never_leads_to_a_force_that_is_not_finite(
        damage in prop::collection::vec((0..LENGTH, any::<u8>()), 0..6),
        times in prop::collection::vec(any::<u64>(), 1..20),
        motion in motions(),
        now: u64,
    ) {
        let mut side = Endpoint::new(Law { stiffness: 1e7, damping: 1e6 }, Nanoseconds(5_000));
        let mut now = Nanoseconds(now);
        for time in times {
            let mut bytes = Packet { sequence: 0, time: Nanoseconds(time), motion }.encode();
            for &(place, value) in &damage {
                bytes[place] = value;
            }
            now = now.plus(Nanoseconds(1_000));
            side.send(now, motion).unwrap();
            let _ = side.receive(now, &bytes);
            prop_assert!(side.force(now).iter().all(|force| force.is_finite()));
        }
    }

    #[test]
    fn law_the_order_of_arrival_does_not_matter(
        order in Just((0..30_u64).collect::<Vec<_>>()).prop_shuffle(),
        played in 0_u64..30_000,
    ) {
        // all come before any is due
        let delay = Nanoseconds(100_000);
        let (mut sorted, mut shuffled) = (Playout::new(delay), Playout::new(delay));
        for n in 0..30 {
            sorted.insert(Nanoseconds(0), Nanoseconds(n * 1_000), at((n * n) as f64));
        }
        for n in order {
            shuffled.insert(Nanoseconds(0), Nanoseconds(n * 1_000), at((n * n) as f64));
        }
        let now = delay.plus(Nanoseconds(played));
        prop_assert_eq!(sorted.motion(now), shuffled.motion(now));
    }
}

#[test]
fn law_each_refusal_says_what_came() {
    let good = Packet { sequence: 1, time: Nanoseconds(2), motion: at(0.1) }.encode();
    let with = |place: usize, bytes: &[u8]| {
        let mut packet = good;
        packet[place..place + bytes.len()].copy_from_slice(bytes);
        Packet::decode(&packet).unwrap_err()
    };
    assert_eq!(Packet::decode(&good[..53]).unwrap_err(), PacketError::Length { length: 53 });
    assert_eq!(Packet::decode(&[]).unwrap_err(), PacketError::Length { length: 0 });
    assert_eq!(with(0, b"HTTP"), PacketError::Foreign { found: *b"HTTP" });
    assert_eq!(with(4, &[2]), PacketError::Version { found: 2 });
    assert_eq!(with(5, &[3]), PacketError::Axes { found: 3 });
    assert_eq!(with(30, &2e6_f64.to_le_bytes()), PacketError::Value { value: 2e6 });
    assert_eq!(with(46, &f64::INFINITY.to_le_bytes()), PacketError::Value { value: f64::INFINITY });
    let text = with(22, &f64::NAN.to_le_bytes()).to_string();
    assert!(text.contains("NaN") && text.contains("finite"), "{text}");
    assert!(with(4, &[2]).to_string().contains("version 2"));
}

#[test]
fn law_the_playout_interpolates_between_samples() {
    let mut playout = Playout::new(Nanoseconds(10_000));
    for (time, x) in [(0, 0.0), (1_000, 1.0), (2_000, 5.0)] {
        playout.insert(Nanoseconds(0), Nanoseconds(time), at(x));
    }
    assert_eq!(playout.motion(Nanoseconds(9_999)), None);
    for (now, x) in
        [(10_000, 0.0), (10_250, 0.25), (11_000, 1.0), (11_500, 3.0), (12_000, 5.0), (99_000, 5.0)]
    {
        assert_eq!(playout.motion(Nanoseconds(now)), Some(at(x)), "{now}");
    }
}

#[test]
fn law_a_lost_sample_is_bridged_and_a_late_one_taken_up() {
    let mut playout = Playout::new(Nanoseconds(1_000));
    playout.insert(Nanoseconds(0), Nanoseconds(0), at(0.0));
    // the sample of 1000 is missing: the one before is held …
    assert_eq!(playout.motion(Nanoseconds(1_500)), Some(at(0.0)));
    // … bridged by the one after it …
    playout.insert(Nanoseconds(1_600), Nanoseconds(2_000), at(4.0));
    assert_eq!(playout.motion(Nanoseconds(1_600)), Some(at(1.2)));
    // … and used when it comes after all
    playout.insert(Nanoseconds(1_700), Nanoseconds(1_000), at(1.0));
    assert_eq!(playout.motion(Nanoseconds(1_700)), Some(at(0.7)));
    // after its turn it changes nothing, and neither does a second one of the same time
    playout.insert(Nanoseconds(3_000), Nanoseconds(500), at(9.0));
    playout.insert(Nanoseconds(3_000), Nanoseconds(2_000), at(9.0));
    assert_eq!(playout.motion(Nanoseconds(3_000)), Some(at(4.0)));
}

#[test]
fn law_the_playout_keeps_no_more_than_it_may_play() {
    let mut playout = Playout::new(Nanoseconds(5_000));
    for n in 0..1_000 {
        let now = Nanoseconds(n * 1_000);
        playout.insert(now, now, at(0.0));
        assert!(playout.len() <= 7, "{}", playout.len());
    }
    // samples that never become due are bounded too
    let mut playout = Playout::new(Nanoseconds(u64::MAX));
    for n in 0..telespring::session::playout::CAPACITY as u64 + 100 {
        playout.insert(Nanoseconds(0), Nanoseconds(n), at(0.0));
    }
    assert_eq!(playout.len(), telespring::session::playout::CAPACITY);
}

#[test]
fn law_the_force_is_zero_until_both_sides_are_known() {
    let law = Law { stiffness: 50.0, damping: 2.0 };
    let mut side = Endpoint::new(law, Nanoseconds(2_000));
    let mut partner = side.clone();
    let packet = partner.send(Nanoseconds(0), at(0.1)).unwrap();
    side.receive(Nanoseconds(0), &packet).unwrap();
    assert_eq!(side.force(Nanoseconds(5_000)), [0.0; 2]);
    side.send(Nanoseconds(1_000), at(0.3)).unwrap();
    assert_eq!(side.force(Nanoseconds(1_999)), [0.0; 2]);
    // 50·(0.1 − 0.3) + 2·(0.2 − 0.6) on x, the opposite spring without damper on y
    let force = side.force(Nanoseconds(2_000));
    assert!((force[0] + 10.8).abs() < 1e-12 && (force[1] - 10.0).abs() < 1e-12, "{force:?}");
}

#[test]
fn law_a_device_that_reports_nonsense_is_refused_and_its_last_motion_stays() {
    let mut side = Endpoint::new(Law { stiffness: 50.0, damping: 0.0 }, Nanoseconds(0));
    let packet = side.clone().send(Nanoseconds(0), at(0.0)).unwrap();
    side.receive(Nanoseconds(0), &packet).unwrap();
    side.send(Nanoseconds(0), at(0.1)).unwrap();
    assert!(side.send(Nanoseconds(1), at(f64::NAN)).is_err());
    assert_eq!(side.force(Nanoseconds(1)), [-5.0, 5.0]);
    assert!(side.receive(Nanoseconds(1), b"").is_err());
    assert_eq!(side.force(Nanoseconds(1)), [-5.0, 5.0]);
}
