//! Laws of the watchdog: what makes the force go, how it goes, and how it comes back.

use telespring::session::watchdog::Cause;
use telespring::session::wire::{Echo, Flags, Packet};
use telespring::session::{
    AdaptiveDelay, Architecture, ClockSettings, Endpoint, EndpointSettings, EventKind, Law, LocalTime,
    Motion, PeerTime, PlayoutSettings, SideFacts, Span, WatchdogSettings, WatchdogState,
};

const MILLISECOND: u64 = 1_000_000;
/// N/m; the own handle is at 0 and the partner's at 0.1 m, so the full force is 10 N.
const STIFFNESS: f64 = 100.0;
const FULL: f64 = 10.0;

fn milliseconds(number: u64) -> LocalTime {
    LocalTime(number * MILLISECOND)
}

fn at(x: f64) -> Motion {
    Motion { position: [x, 0.0], velocity: [0.0; 2] }
}

/// A side at 1 kHz whose partner is at 0.1 m.
struct Session {
    side: Endpoint,
    /// Milliseconds since the start.
    tick: u64,
    forces: Vec<f64>,
    events: Vec<(u64, EventKind)>,
}

/// What happens at one tick.
struct Happening {
    own: Option<Motion>,
    packet: Option<Packet>,
}

impl Session {
    fn new(settings: EndpointSettings) -> Self {
        Self { side: Endpoint::new(settings).unwrap(), tick: 0, forces: Vec::new(), events: Vec::new() }
    }

    fn plain() -> Self {
        Self::new(EndpointSettings::new(1, Law { stiffness: STIFFNESS, damping: 0.0 }, Span(0)))
    }

    /// The regular packet of this tick.
    fn packet(&self) -> Packet {
        Packet { session: 2, ..Packet::of(self.tick, PeerTime(self.tick * MILLISECOND), at(0.1)) }
    }

    fn step(&mut self, happening: Happening) {
        let now = milliseconds(self.tick);
        if let Some(own) = happening.own {
            let _ = self.side.handle_measurement(now, own);
        }
        self.side.poll_transmit(now);
        if let Some(packet) = happening.packet {
            let _ = self.side.handle_datagram(now, &packet.encode());
        }
        self.forces.push(self.side.force(now)[0]);
        while let Some(event) = self.side.poll_event() {
            self.events.push((event.time.0 / MILLISECOND, event.kind));
        }
        self.tick += 1;
    }

    /// Runs to a time in ms; `happens` changes what happens at a tick.
    fn run(&mut self, until: u64, happens: impl Fn(u64, Packet) -> Happening) {
        while self.tick < until {
            self.step(happens(self.tick, self.packet()));
        }
    }

    fn run_well(&mut self, until: u64) {
        self.run(until, well);
    }

    fn kinds_since(&self, since: u64) -> Vec<EventKind> {
        let impossible = |kind: &EventKind| matches!(kind, EventKind::ImpossibleValue { .. });
        self.events
            .iter()
            .filter(|(t, kind)| *t >= since && !impossible(kind))
            .map(|(_, kind)| *kind)
            .collect()
    }

    fn force_at(&self, millisecond: u64) -> f64 {
        self.forces[millisecond as usize]
    }

    /// The largest change of the force between two ticks.
    fn largest_step(&self) -> f64 {
        self.forces.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max)
    }
}

fn well(_: u64, packet: Packet) -> Happening {
    Happening { own: Some(at(0.0)), packet: Some(packet) }
}

/// One tick of the slower of both ramps changes the force by at most this, and a little for rounding.
const RAMP_STEP: f64 = FULL / 200.0 + 1e-9;

fn close(value: f64, expected: f64) -> bool {
    (value - expected).abs() < 1e-9
}

#[test]
fn law_a_session_begins_from_zero_force() {
    let mut session = Session::plain();
    session.run_well(1_000);
    assert_eq!(session.side.state(), WatchdogState::Engaged);
    let kinds = session.kinds_since(0);
    assert_eq!(kinds, [EventKind::PartnerFound { session: 2 }, EventKind::RampingIn, EventKind::Engaged]);
    for millisecond in 0..1_000_u64 {
        // well since 0 ms, in from 200 to 700 ms
        let expected = FULL * ((millisecond as f64 - 200.0) / 500.0).clamp(0.0, 1.0);
        assert!(close(session.force_at(millisecond), expected), "{millisecond}");
    }
}

/// The force after a fault that begins at 1 s and is held, if it lasts.
fn ramp_out(since: f64, millisecond: u64) -> f64 {
    FULL * (1.0 - (millisecond as f64 - since) / 200.0).clamp(0.0, 1.0)
}

#[test]
fn law_after_silence_the_force_is_held_ramped_out_and_begun_again_from_zero() {
    let mut session = Session::plain();
    session.run_well(1_000);
    session.run(3_000, |_, _| Happening { own: Some(at(0.0)), packet: None });
    session.run_well(5_000);
    // the last packet came at 999 ms: silent at 1019, held to 1119, out at 1319; well from 3000
    use EventKind::{Disengaged, Engaged, Holding, RampingIn, RampingOut};
    let kinds =
        [Holding(Cause::Silence), RampingOut(Cause::Silence), Disengaged(Cause::Silence), RampingIn, Engaged];
    assert_eq!(session.kinds_since(1_000), kinds);
    for millisecond in 1_000..3_000 {
        let expected = ramp_out(1_119.0, millisecond);
        assert!(close(session.force_at(millisecond), expected), "{millisecond}");
    }
    for millisecond in 3_000..5_000 {
        let expected = FULL * ((millisecond as f64 - 3_200.0) / 500.0).clamp(0.0, 1.0);
        assert!(close(session.force_at(millisecond), expected), "{millisecond}");
    }
    assert!(session.largest_step() <= RAMP_STEP, "{}", session.largest_step());
}

#[test]
fn law_a_short_silence_changes_nothing() {
    let mut session = Session::plain();
    session.run_well(1_000);
    session.run(1_100, |_, _| Happening { own: Some(at(0.0)), packet: None });
    session.run_well(1_500);
    let kinds = session.kinds_since(1_000);
    assert_eq!(kinds, [EventKind::Holding(Cause::Silence), EventKind::Engaged]);
    assert!(session.forces[1_000..].iter().all(|force| *force == FULL));
}

#[test]
fn law_a_fault_while_the_force_grows_lets_it_fall_from_there() {
    let mut session = Session::plain();
    session.run_well(450);
    assert!(close(session.force_at(449), FULL * 249.0 / 500.0));
    session.run(1_000, |_, _| Happening { own: Some(at(0.0)), packet: None });
    // silent at 469 ms with a factor of 0.538, which falls by 1 in 200 ms
    for millisecond in 469..1_000_u64 {
        let expected = (0.538 - (millisecond as f64 - 469.0) / 200.0).max(0.0) * FULL;
        assert!(close(session.force_at(millisecond), expected), "{millisecond}");
    }
    assert_eq!(session.side.state(), WatchdogState::Disengaged { cause: Cause::Silence });
}

#[test]
fn law_a_partner_whose_stamps_stand_still_is_frozen() {
    // the same packet again and again; a count that goes on without a clock; packets of the past
    let frozen: [fn(Packet) -> Packet; 3] = [
        |packet| Packet { sequence: 999, sent: PeerTime(999 * MILLISECOND), ..packet },
        |packet| Packet { sent: PeerTime(999 * MILLISECOND), ..packet },
        |packet| Packet {
            sequence: packet.sequence - 900,
            sent: PeerTime(packet.sent.0 - 900 * MILLISECOND),
            ..packet
        },
    ];
    for freeze in frozen {
        let mut session = Session::plain();
        session.run_well(1_000);
        session.run(1_800, |_, packet| Happening { own: Some(at(0.0)), packet: Some(freeze(packet)) });
        // no later stamp since 999 ms: frozen at 1099, held to 1199
        use EventKind::{Disengaged, Holding, RampingOut};
        let kinds =
            [Holding(Cause::FrozenStamps), RampingOut(Cause::FrozenStamps), Disengaged(Cause::FrozenStamps)];
        assert_eq!(session.kinds_since(1_000), kinds);
        for millisecond in 1_000..1_399 {
            assert!(close(session.force_at(millisecond), ramp_out(1_199.0, millisecond)), "{millisecond}");
        }
        assert!(session.forces[1_399..].iter().all(|force| *force == 0.0));
    }
}

#[test]
fn law_a_partner_that_says_it_moves_and_stays_is_frozen_and_one_at_rest_is_not() {
    let with = |velocity: f64| {
        let mut session = Session::plain();
        session.run(2_000, |tick, packet| {
            let velocity = if tick < 1_000 { 0.0 } else { velocity };
            let motion = Motion { position: [0.1, 0.0], velocity: [0.0, velocity] };
            Happening { own: Some(at(0.0)), packet: Some(Packet { motion, ..packet }) }
        });
        session
    };
    // at rest, and with a velocity that goes less than 1 cm in the second
    for velocity in [0.0, 0.009] {
        assert_eq!(with(velocity).side.state(), WatchdogState::Engaged, "{velocity}");
    }
    // 0.2 m/s go 1 cm in 50 ms; the position has been the same for longer than 100 ms then
    let session = with(0.2);
    assert_eq!(session.kinds_since(1_000)[0], EventKind::Holding(Cause::FrozenMotion));
    let begun = session.events.iter().find(|(_, kind)| *kind == EventKind::Holding(Cause::FrozenMotion));
    assert_eq!(begun.unwrap().0, 1_049);
    assert_eq!(session.side.state(), WatchdogState::Disengaged { cause: Cause::FrozenMotion });
}

#[test]
fn law_a_restarted_partner_is_begun_with_again_from_zero() {
    // another session id from sequence 0; the same one from sequence 0; a clock that was set back
    let restarts: [fn(Packet) -> Packet; 3] = [
        |packet| Packet { session: 3, sequence: packet.sequence - 1_000, ..packet },
        |packet| Packet { sequence: packet.sequence - 1_000, ..packet },
        |packet| Packet { sent: PeerTime(packet.sent.0 - 700 * MILLISECOND), ..packet },
    ];
    for (n, restart) in restarts.into_iter().enumerate() {
        let mut session = Session::plain();
        session.run_well(1_000);
        // it comes back elsewhere: the force falls along the last motion of before
        session.run(3_000, |_, packet| {
            let packet = Packet { motion: at(0.5), ..restart(packet) };
            Happening { own: Some(at(0.0)), packet: Some(packet) }
        });
        use EventKind::{Disengaged, Engaged, PartnerRestarted, RampingIn, RampingOut};
        let kinds = [
            PartnerRestarted { session: if n == 0 { 3 } else { 2 } },
            RampingOut(Cause::PartnerRestarted),
            Disengaged(Cause::PartnerRestarted),
            RampingIn,
            Engaged,
        ];
        assert_eq!(session.kinds_since(1_000), kinds);
        for millisecond in 1_000..1_400 {
            assert!(close(session.force_at(millisecond), ramp_out(1_000.0, millisecond)), "{millisecond}");
        }
        // out at 1200, well for 200 ms, in within 500
        for millisecond in 1_400..3_000_u64 {
            let expected = 5.0 * FULL * ((millisecond as f64 - 1_400.0) / 500.0).clamp(0.0, 1.0);
            assert!(close(session.force_at(millisecond), expected), "{n}: {millisecond}");
        }
        assert_eq!(session.side.report().restarts, 1);
    }
}

#[test]
fn law_a_partner_whose_clock_is_set_is_begun_with_again_from_zero() {
    let law = Law { stiffness: STIFFNESS, damping: 0.0 };
    let settings = EndpointSettings::new(1, law, Span(5_000_000));
    let mut session = Session::new(EndpointSettings { clock: ClockSettings::estimated(), ..settings });
    // 2 ms each way; three hours ahead, and from 1000 ms on five
    let run = |session: &mut Session, until: u64, hours: u64| {
        session.run(until, |tick, packet| {
            let sent = PeerTime((tick + hours * 3_600_000) * MILLISECOND - 2 * MILLISECOND);
            let echo = tick.checked_sub(4).filter(|stamp| *stamp > 0);
            let echo = echo.map(|stamp| Echo { stamp: milliseconds(stamp), held: Span(0) });
            Happening { own: Some(at(0.0)), packet: Some(Packet { sent, echo, ..packet }) }
        });
    };
    run(&mut session, 1_000, 3);
    assert_eq!(session.side.state(), WatchdogState::Engaged);
    run(&mut session, 3_000, 5);
    use EventKind::{ClockStepped, Disengaged, Engaged, RampingIn, RampingOut};
    let cause = Cause::ClockStepped;
    let kinds = [ClockStepped, RampingOut(cause), Disengaged(cause), RampingIn, Engaged];
    assert_eq!(session.kinds_since(1_000), kinds);
    assert!(session.largest_step() <= RAMP_STEP, "{}", session.largest_step());
    assert!(session.forces.contains(&0.0) && session.forces.last() == Some(&FULL));
}

#[test]
fn law_a_partner_that_comes_back_after_a_silence_with_an_earlier_clock_has_restarted() {
    let mut session = Session::plain();
    session.run_well(1_000);
    session.run(2_000, |_, _| Happening { own: Some(at(0.0)), packet: None });
    session.run(4_000, |tick, packet| {
        let back = 1_900;
        let sent = PeerTime(packet.sent.0 - back * MILLISECOND);
        // what it echoes shows that it is not an old packet sent once more
        let echo = Some(Echo { stamp: milliseconds(tick - 1), held: Span(0) });
        let packet = Packet { sequence: packet.sequence - back, sent, echo, ..packet };
        Happening { own: Some(at(0.0)), packet: Some(packet) }
    });
    assert_eq!(session.kinds_since(2_000)[0], EventKind::PartnerRestarted { session: 2 });
    assert_eq!(session.side.state(), WatchdogState::Engaged);
    assert_eq!(session.side.report().restarts, 1);
}

#[test]
fn law_a_device_that_reports_nonsense_or_nothing_is_let_go() {
    for own in [Some(at(f64::NAN)), Some(at(1e9)), None] {
        let mut session = Session::plain();
        session.run_well(1_000);
        session.run(2_000, |_, packet| Happening { own, packet: Some(packet) });
        let cause = if own.is_some() { Cause::OwnMeasurement } else { Cause::OwnSilence };
        use EventKind::{Disengaged, Holding, RampingOut};
        assert_eq!(session.kinds_since(1_000), [Holding(cause), RampingOut(cause), Disengaged(cause)]);
        // held for 5 ms: from the first nonsense at 1000, or from two periods after the last report at 999
        let since = if own.is_some() { 1_005.0 } else { 1_006.0 };
        for millisecond in 1_000..2_000 {
            assert!(close(session.force_at(millisecond), ramp_out(since, millisecond)), "{millisecond}");
        }
        session.run_well(3_000);
        assert_eq!(session.side.state(), WatchdogState::Engaged);
        assert!(session.largest_step() <= RAMP_STEP, "{}", session.largest_step());
    }
    // a single bad value changes nothing
    let mut session = Session::plain();
    session.run_well(1_000);
    session.run(1_002, |_, packet| Happening { own: Some(at(f64::NAN)), packet: Some(packet) });
    session.run_well(1_100);
    assert!(session.forces[1_000..].iter().all(|force| *force == FULL));
}

#[test]
fn law_a_device_may_be_given_longer_before_it_counts_as_silent() {
    let watchdog = WatchdogSettings { own_silence: Span(20_000_000), ..WatchdogSettings::default() };
    let settings = EndpointSettings::new(1, Law { stiffness: STIFFNESS, damping: 0.0 }, Span(0));
    let mut session = Session::new(EndpointSettings { watchdog: Some(watchdog), ..settings });
    session.run_well(1_000);
    // a report every 15 ms is enough
    session.run(2_000, |tick, packet| Happening {
        own: (tick % 15 == 0).then_some(at(0.0)),
        packet: Some(packet),
    });
    assert!(session.forces[1_000..].iter().all(|force| *force == FULL));
    // the last one at 1995
    session.run(3_000, |_, packet| Happening { own: None, packet: Some(packet) });
    for millisecond in 2_000..3_000 {
        assert!(close(session.force_at(millisecond), ramp_out(2_020.0, millisecond)), "{millisecond}");
    }
    let refused = WatchdogSettings { own_silence: Span(-1), ..watchdog }.check().unwrap_err();
    assert_eq!(refused.field, "watchdog.own_silence");
}

#[test]
fn law_a_second_fault_does_not_wait_for_the_first() {
    // the partner is silent from 1019 and held to 1119; from 1050 on the own device reports nonsense and is held for 5 ms
    let mut session = Session::plain();
    session.run_well(1_000);
    session.run(1_400, |tick, _| Happening {
        own: Some(at(if tick < 1_050 { 0.0 } else { f64::NAN })),
        packet: None,
    });
    for millisecond in 1_000..1_400 {
        assert!(close(session.force_at(millisecond), ramp_out(1_055.0, millisecond)), "{millisecond}");
    }
}

#[test]
fn law_a_controller_that_stood_still_begins_again_from_zero() {
    let mut session = Session::plain();
    session.run_well(1_000);
    session.tick = 2_000;
    session.forces.resize(2_000, f64::NAN);
    session.run_well(2_100);
    assert!(session.forces[2_000..].iter().all(|force| *force == 0.0));
    assert_eq!(session.side.state(), WatchdogState::Disengaged { cause: Cause::OwnSilence });
    session.run_well(3_000);
    assert_eq!(session.side.state(), WatchdogState::Engaged);
}

#[test]
fn law_the_states_do_not_depend_on_how_often_the_watchdog_is_asked() {
    // everything falls silent: the same states at the same times, asked at the timeouts only, or every millisecond; the
    // own device, silent first, is waited for longer
    let quiet = || {
        let watchdog = WatchdogSettings { own_hold: Span(1 << 40), ..WatchdogSettings::default() };
        let settings = EndpointSettings::new(1, Law { stiffness: STIFFNESS, damping: 0.0 }, Span(0));
        let mut session = Session::new(EndpointSettings { watchdog: Some(watchdog), ..settings });
        session.run_well(1_000);
        session
    };
    let mut often = quiet();
    let mut states = Vec::new();
    for millisecond in 1_000..1_600 {
        often.side.handle_timeout(milliseconds(millisecond));
        states.push(often.side.state());
    }
    let mut seldom = quiet();
    let mut seen = 0;
    while let Some(timeout) = seldom.side.next_timeout().filter(|timeout| *timeout < milliseconds(1_600)) {
        seldom.side.handle_timeout(timeout);
        let state = seldom.side.state();
        assert_eq!(state, states[(timeout.0.div_ceil(MILLISECOND) - 1_000) as usize], "{timeout:?}");
        seen += 1;
        assert!(seen < 10, "no end of timeouts: {timeout:?} {state:?}");
    }
    // the own device, the silence, the stamps; the end of the hold, of the ramp
    assert_eq!(seen, 5);
    assert_eq!(Some(&seldom.side.state()), states.last());
    // and asked just once, long after
    let mut once = quiet();
    once.side.handle_timeout(milliseconds(1_599));
    assert_eq!(once.side.state(), seldom.side.state());
}

#[test]
fn law_the_partner_is_told_the_state() {
    let mut session = Session::plain();
    let flags = |session: &mut Session| {
        let now = milliseconds(session.tick);
        session.side.handle_measurement(now, at(0.0)).unwrap();
        Packet::decode(&session.side.poll_transmit(now).unwrap()).unwrap().flags
    };
    assert_eq!(flags(&mut session), Flags::default());
    session.run_well(300);
    assert_eq!(flags(&mut session), Flags { ramping: true, ..Flags::default() });
    session.run_well(1_000);
    assert_eq!(flags(&mut session), Flags { engaged: true, ..Flags::default() });
    session.run(1_050, |_, _| Happening { own: Some(at(0.0)), packet: None });
    assert_eq!(flags(&mut session), Flags { engaged: true, holding: true, ..Flags::default() });
    session.run(1_060, |_, packet| Happening {
        own: Some(at(0.0)),
        packet: Some(Packet { session: 3, ..packet }),
    });
    assert_eq!(flags(&mut session), Flags { ramping: true, restarted: true, ..Flags::default() });
}

#[test]
fn law_two_watched_sides_with_clocks_of_their_own_meet_and_pull_each_other() {
    // the second clock is 100 s ahead and 50 ppm fast; 30 ms there, 10 ms back; adaptive play-out
    let law = Law { stiffness: STIFFNESS, damping: 0.0 };
    let settings = |session| EndpointSettings {
        clock: ClockSettings::estimated(),
        playout: PlayoutSettings::Adaptive(AdaptiveDelay::default()),
        ..EndpointSettings::new(session, law, Span(0))
    };
    let mut sides = [1, 2].map(|session| Endpoint::new(settings(session)).unwrap());
    let ways = [10, 30];
    let mut travelling: [Vec<(u64, Vec<u8>)>; 2] = [Vec::new(), Vec::new()];
    let clock = |side: usize, tick: u64| {
        LocalTime(if side == 0 { tick * MILLISECOND } else { 100_000_000_000 + tick * 1_000_050 })
    };
    let mut forces = [0.0; 2];
    for tick in 0..3_000_u64 {
        for side in 0..2 {
            let now = clock(side, tick);
            sides[side].handle_measurement(now, at([0.0, 0.1][side])).unwrap();
            let packet = sides[side].poll_transmit(now).unwrap().to_vec();
            travelling[1 - side].push((tick + ways[1 - side], packet));
        }
        for side in 0..2 {
            let now = clock(side, tick);
            travelling[side].retain(|(arrival, packet)| {
                if *arrival <= tick {
                    sides[side].handle_datagram(now, packet).unwrap();
                }
                *arrival > tick
            });
            forces[side] = sides[side].force(now)[0];
        }
    }
    assert!(close(forces[0], FULL) && close(forces[1], -FULL), "{forces:?}");
    for (side, offset) in [(0, 100.0), (1, -100.0)] {
        let report = sides[side].report();
        assert_eq!(report.state, WatchdogState::Engaged);
        let (found, error) = (report.clock.offset.unwrap().seconds(), report.clock.offset_error.unwrap());
        assert!((found - offset).abs() < error.seconds() + 2e-4, "{found}");
        assert!((report.clock.round_trip.unwrap().seconds() - 0.040).abs() < 0.0021, "{report:?}");
    }
}

/// A live side at a rate, Hz.
fn side_at(rate: f64, session: u64, architecture: &Architecture) -> Endpoint {
    let facts = SideFacts {
        session,
        law: Law { stiffness: 1.0, damping: 0.0 },
        delays: [0.05; 2],
        lateness: [0.0; 2],
        missing: [0.0; 2],
        has_playout_buffer: false,
        sample_period: 1.0 / rate,
        computing_tick: false,
        encoder_step: 0.0,
        actuator_lag: 0.0,
        least_damping: [[7.7, 10.1]; 2],
        least_mass: [0.83, 1.07],
    };
    Endpoint::new(architecture.endpoint_settings(&facts).unwrap()).unwrap()
}

/// The defaults fit the controllers of slow robots: with every architecture two live sides engage and stay engaged while one
/// packet in ten is lost, and disengage when the partner falls silent.
#[test]
fn law_sides_of_slow_controllers_engage_and_stay_engaged() {
    for rate in [5.0, 30.0, 50.0, 100.0] {
        for architecture in Architecture::usual() {
            let label = architecture.label();
            let mut sides = [1, 2].map(|session| side_at(rate, session, &architecture));
            let mut faults = Vec::new();
            for tick in 0..(8.0 * rate) as u64 {
                let seconds = tick as f64 / rate;
                let now = LocalTime::from_seconds(seconds);
                let packets = sides.each_mut().map(|side| {
                    side.handle_measurement(now, at(0.02 * seconds.sin())).unwrap();
                    side.poll_transmit(now).unwrap()
                });
                for (index, side) in sides.iter_mut().enumerate() {
                    if tick % 10 != 7 && seconds < 6.0 {
                        side.handle_datagram(now, &packets[1 - index]).unwrap();
                    }
                    side.force(now);
                    while let Some(event) = side.poll_event() {
                        if matches!(event.kind, EventKind::RampingOut(_) | EventKind::Disengaged(_)) {
                            faults.push(seconds);
                        }
                    }
                }
                if (3.0..6.0).contains(&seconds) {
                    let states = sides.each_ref().map(Endpoint::state);
                    assert_eq!(states, [WatchdogState::Engaged; 2], "{label} at {rate} Hz, {seconds} s");
                }
            }
            assert!(
                !faults.is_empty() && faults.iter().all(|time| *time > 6.0),
                "{label} {rate}: {faults:?}"
            );
        }
    }
}
