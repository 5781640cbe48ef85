//! Laws of one side of a coupling: the order of calls, the force, what is refused.

use proptest::prelude::*;
use telespring::session::motion::MAX_VALUE;
use telespring::session::wire::LENGTH;
use telespring::session::{
    DatagramError, Endpoint, EndpointSettings, EventKind, Law, LocalTime, Motion, Packet, PacketError,
    PeerTime, PlayoutSettings, Span, WatchdogSettings,
};

const MILLISECOND: u64 = 1_000_000;

fn at(x: f64) -> Motion {
    Motion { position: [x, -x], velocity: [2.0 * x, 0.0] }
}

fn unwatched(session: u64, law: Law, delay: Span) -> Endpoint {
    Endpoint::new(EndpointSettings { watchdog: None, ..EndpointSettings::new(session, law, delay) }).unwrap()
}

fn packet(session: u64, sequence: u64, sent: u64, motion: Motion) -> [u8; LENGTH] {
    Packet { session, ..Packet::of(sequence, PeerTime(sent), motion) }.encode()
}

#[test]
fn law_the_force_is_zero_until_both_sides_are_known() {
    let law = Law { stiffness: 50.0, damping: 2.0 };
    let mut side = unwatched(1, law, Span(2_000));
    side.handle_datagram(LocalTime(0), &packet(2, 0, 0, at(0.1))).unwrap();
    assert_eq!(side.force(LocalTime(1_000)), [0.0; 2]);
    side.handle_measurement(LocalTime(1_500), at(0.3)).unwrap();
    assert_eq!(side.force(LocalTime(1_999)), [0.0; 2]);
    side.handle_measurement(LocalTime(2_000), at(0.3)).unwrap();
    // 50·(0.1 − 0.3) + 2·(0.2 − 0.6) on x, the opposite spring without damper on y
    let force = side.force(LocalTime(2_000));
    assert!((force[0] + 10.8).abs() < 1e-12 && (force[1] - 10.0).abs() < 1e-12, "{force:?}");
    // asked again without a new measurement, the force stays
    assert_eq!(side.force(LocalTime(2_500)), force);
}

#[test]
fn law_every_measurement_is_sent_once_with_a_number_of_its_own() {
    let mut side = unwatched(7, Law { stiffness: 71.2, damping: 0.0 }, Span(0));
    assert_eq!(side.poll_transmit(LocalTime(0)), None);
    for n in 0..5 {
        let now = LocalTime((n + 1) * MILLISECOND);
        side.handle_measurement(now, at(n as f64)).unwrap();
        let sent = Packet::decode(&side.poll_transmit(now).unwrap()).unwrap();
        assert_eq!((sent.session, sent.sequence, sent.sent), (7, n, now.seen_by_peer()));
        assert_eq!((sent.motion, sent.stiffness, sent.energy_sent), (at(n as f64), 71.2, 0.0));
        assert_eq!(side.poll_transmit(now), None);
    }
}

#[test]
fn law_a_packet_echoes_the_newest_stamp_and_how_long_it_was_held() {
    let mut side = unwatched(1, Law { stiffness: 1.0, damping: 0.0 }, Span(0));
    let mut echo = |came: u64, stamp: u64, sequence: u64, sent: u64| {
        side.handle_datagram(LocalTime(came), &packet(2, sequence, stamp, at(0.0))).unwrap();
        side.handle_measurement(LocalTime(sent), at(0.0)).unwrap();
        let echo = Packet::decode(&side.poll_transmit(LocalTime(sent)).unwrap()).unwrap().echo.unwrap();
        (echo.stamp.0, echo.held.0)
    };
    assert_eq!(echo(5_000, 3_000, 4, 5_200), (3_000, 200));
    assert_eq!(echo(6_000, 4_000, 5, 6_000), (4_000, 0));
    // an overtaken one is not the newest
    assert_eq!(echo(6_500, 3_500, 3, 7_000), (4_000, 1_000));
}

#[test]
fn law_a_device_that_reports_nonsense_is_refused() {
    let mut side = unwatched(1, Law { stiffness: 50.0, damping: 0.0 }, Span(0));
    side.handle_datagram(LocalTime(0), &packet(2, 0, 0, at(0.0))).unwrap();
    side.handle_measurement(LocalTime(0), at(0.1)).unwrap();
    assert!(side.poll_transmit(LocalTime(0)).is_some());
    assert_eq!(side.force(LocalTime(0)), [-5.0, 5.0]);
    for value in [f64::NAN, f64::INFINITY, -2e6] {
        let refused = side.handle_measurement(LocalTime(1), at(value)).unwrap_err();
        assert!(refused.value.is_nan() == value.is_nan() && !(refused.value.abs() <= MAX_VALUE));
        // nothing is sent, and without a watchdog nothing acts
        assert_eq!(side.poll_transmit(LocalTime(1)), None);
        assert_eq!(side.force(LocalTime(1)), [0.0; 2]);
    }
    assert!(matches!(
        std::iter::from_fn(|| side.poll_event()).last().unwrap().kind,
        EventKind::ImpossibleValue { .. }
    ));
    assert_eq!(side.report().impossible_values, 3);
    side.handle_measurement(LocalTime(2), at(0.1)).unwrap();
    assert_eq!(side.force(LocalTime(2)), [-5.0, 5.0]);
    assert!(side.handle_datagram(LocalTime(2), b"").is_err());
    assert_eq!(side.force(LocalTime(2)), [-5.0, 5.0]);
}

#[test]
fn law_packets_of_this_side_of_the_future_and_of_former_sessions_are_refused() {
    let mut side = unwatched(1, Law { stiffness: 50.0, damping: 0.0 }, Span(0));
    let now = LocalTime(10 * MILLISECOND);
    assert_eq!(side.handle_datagram(now, &packet(1, 0, 0, at(0.0))), Err(DatagramError::OwnSession));
    let refused = side.handle_datagram(now, &packet(2, 0, 12 * MILLISECOND, at(0.0))).unwrap_err();
    assert_eq!(refused, DatagramError::FromTheFuture { ahead: Span(2_000_000) });
    assert!(refused.to_string().contains("0.002 s"), "{refused}");
    side.handle_datagram(now, &packet(2, 8, 2_000, at(0.0))).unwrap();
    side.handle_datagram(now, &packet(3, 0, 3_000, at(0.0))).unwrap();
    let refused = side.handle_datagram(now, &packet(2, 9, 4_000, at(0.0)));
    assert_eq!(refused, Err(DatagramError::FormerSession { session: 2 }));
    let report = side.report();
    assert_eq!((report.received, report.refused, report.restarts, report.partner), (2, 3, 1, Some(3)));
}

#[test]
fn law_energy_totals_survive_loss_repetition_and_restarts() {
    // the strategy sees the largest total of each session, added up: here through the report of what it is told
    let mut side = unwatched(1, Law { stiffness: 50.0, damping: 0.0 }, Span(0));
    let mut total = |now: u64, session: u64, sequence: u64, energy_sent: f64| {
        let bytes = Packet { session, energy_sent, ..Packet::of(sequence, PeerTime(now), at(0.0)) }.encode();
        let _ = side.handle_datagram(LocalTime(now), &bytes);
        side.partner_energy()
    };
    assert_eq!(total(1_000, 2, 0, 0.5), 0.5);
    assert_eq!(total(2_000, 2, 3, 2.0), 2.0);
    assert_eq!(total(2_000, 2, 3, 2.0), 2.0); // repeated
    assert_eq!(total(3_000, 2, 4, 1.0), 2.0); // a total that falls
    assert_eq!(total(4_000, 3, 0, 0.25), 2.25); // the partner has restarted
    assert_eq!(total(5_000, 2, 5, 9.0), 2.25); // a packet of the session that is over
    assert_eq!(total(6_000, 3, 0, 3.0), 5.0); // the same session begins again: no energy twice
}

#[test]
fn law_the_acted_force_is_that_of_the_last_tick_or_of_the_one_before() {
    // the energy given out is the force that acted times the displacement; own positions 0, 1, 3, 6, partner at 10
    let positions = [0.0, 1.0, 3.0, 6.0];
    let forces = positions.map(|x| 2.0 * (10.0 - x));
    let given_out = |computing_tick: bool, told: Option<f64>| {
        let settings = EndpointSettings::new(1, Law { stiffness: 2.0, damping: 0.0 }, Span(0));
        let mut side =
            Endpoint::new(EndpointSettings { watchdog: None, computing_tick, ..settings }).unwrap();
        for (n, x) in positions.into_iter().enumerate() {
            let now = LocalTime(n as u64 * MILLISECOND);
            if let Some(force) = told {
                side.handle_acted([force, 0.0]);
            }
            side.handle_measurement(now, Motion { position: [x, 0.0], velocity: [0.0; 2] }).unwrap();
            let partner = Motion { position: [10.0, 0.0], velocity: [0.0; 2] };
            side.handle_datagram(now, &packet(2, n as u64, now.0, partner)).unwrap();
            assert_eq!(side.force(now)[0], forces[n]);
        }
        side.report().strategy.given_out
    };
    assert_eq!(given_out(false, None), forces[0] * 1.0 + forces[1] * 2.0 + forces[2] * 3.0);
    assert_eq!(given_out(true, None), 0.0 * 1.0 + forces[0] * 2.0 + forces[1] * 3.0);
    assert_eq!(given_out(true, Some(7.0)), 7.0 * 6.0);
}

#[test]
fn law_each_setting_is_refused_with_its_field() {
    let law = Law { stiffness: 1.0, damping: 0.0 };
    let good = || EndpointSettings::new(1, law, Span(0));
    let field = |settings: EndpointSettings| Endpoint::new(settings).unwrap_err().field;
    assert_eq!(field(EndpointSettings { sample_period: Span(0), watchdog: None, ..good() }), "sample_period");
    assert_eq!(
        field(EndpointSettings { playout: PlayoutSettings::Fixed { delay: Span(-1) }, ..good() }),
        "delay"
    );
    let long = PlayoutSettings::Fixed { delay: Span(i64::MAX) };
    assert_eq!(field(EndpointSettings { playout: long, ..good() }), "delay");
    let watchdog = Some(WatchdogSettings { silence: Span(1_500_000), ..WatchdogSettings::default() });
    assert_eq!(field(EndpointSettings { watchdog, ..good() }), "watchdog.silence");
    let watchdog = Some(WatchdogSettings { frozen: Span(1_500_000), ..WatchdogSettings::default() });
    assert_eq!(field(EndpointSettings { watchdog, ..good() }), "watchdog.frozen");
    let watchdog = Some(WatchdogSettings { ramp_out: Span(0), ..WatchdogSettings::default() });
    assert_eq!(field(EndpointSettings { watchdog, ..good() }), "watchdog.ramp_out");
}

proptest! {
    #[test]
    fn law_a_damaged_packet_never_leads_to_a_force_that_is_not_finite(
        damage in prop::collection::vec((0..LENGTH, any::<u8>()), 0..6),
        times in prop::collection::vec(any::<u64>(), 1..20),
        x in -MAX_VALUE..MAX_VALUE,
        now: u64,
    ) {
        let mut side = unwatched(1, Law { stiffness: 1e7, damping: 1e6 }, Span(5_000));
        let motion = Motion { position: [x, -x], velocity: [-x, x] };
        let mut now = LocalTime(now);
        for time in times {
            let mut bytes = packet(2, 0, time >> 1, motion);
            for &(place, value) in &damage {
                bytes[place] = value;
            }
            now = now + Span(1_000);
            side.handle_measurement(now, motion).unwrap();
            let _ = side.handle_datagram(now, &bytes);
            prop_assert!(side.force(now).iter().all(|force| force.is_finite()));
        }
    }
}

#[test]
fn law_a_refusal_is_one_event_a_second_and_counted() {
    let mut side = unwatched(1, Law { stiffness: 1.0, damping: 0.0 }, Span(0));
    for n in 0..2_500 {
        assert!(side.handle_datagram(LocalTime(n * MILLISECOND), b"noise").is_err());
    }
    let events: Vec<_> = std::iter::from_fn(|| side.poll_event()).collect();
    assert_eq!(events.len(), 3, "{events:?}");
    let expected = EventKind::Refused(DatagramError::Packet(PacketError::Length { length: 5 }));
    assert!(events.iter().all(|event| event.kind == expected));
    assert_eq!(side.report().refused, 2_500);
}
