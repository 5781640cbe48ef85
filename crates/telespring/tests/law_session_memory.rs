//! After its construction an endpoint allocates nothing, whatever comes in, and every force is finite.

mod watched_allocator;

use telespring::session::strategy::{
    Guard, InjectedDamping, InjectedDampingSettings, SetPositionModulation, SetPositionSettings,
    StrategyChoice, TankSettings, TimeDomainPassivity, TwoLayer, WaveSettings, WaveVariables,
};
use telespring::session::wire::{LENGTH, Packet};
use telespring::session::{
    AccountSettings, AdaptiveDelay, ClockSettings, Endpoint, EndpointSettings, Law, LocalTime, Motion,
    PeerTime, PlayoutSettings, Span,
};
use watched_allocator::{FORBIDDEN, USES};

/// Runs without the allocator and returns how often it was used all the same.
fn without_allocator(run: impl FnOnce()) -> u64 {
    USES.set(0);
    FORBIDDEN.set(true);
    run();
    FORBIDDEN.set(false);
    USES.get()
}

/// A small generator of its own (splitmix64): it allocates nothing.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ bits >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ bits >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^ bits >> 31
    }

    fn below(&mut self, end: u64) -> u64 {
        self.next() % end
    }

    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// A partner and a network at their worst: lost, late, repeated and damaged packets, restarts, clocks that are set, noise,
/// floods; a device that reports nonsense; a caller whose time stands still, goes back or leaps.
fn torment(side: &mut Endpoint, ticks: u64, random: &mut Random) {
    const LATE: usize = 512;
    let mut travelling = [(0_u64, [0_u8; LENGTH]); LATE];
    let (mut session, mut sequence, mut now) = (2_u64, 0_u64, 0_u64);
    for tick in 0..ticks {
        now = match random.below(20_000) {
            0 => now + random.below(5_000_000_000),
            1 => now.saturating_sub(random.below(1_000_000_000)),
            2 => now,
            _ => now + 990_000 + random.below(20_000),
        };
        let time = LocalTime(now);
        let mut peer = now;
        let value = match random.below(300) {
            0 => [f64::NAN, f64::INFINITY, -1e300, 1e6, 5e-324][random.below(5) as usize],
            _ => random.unit() - 0.5,
        };
        let motion = Motion { position: [value, 0.1], velocity: [random.unit(), -value] };
        if random.below(200) > 0 {
            let _ = side.handle_measurement(time, motion);
        }
        if random.below(10) == 0 {
            side.handle_acted([value, 1.0]);
        }
        side.handle_target(time, motion);
        let _ = side.poll_transmit(time);
        match random.below(5_000) {
            0 => (session, sequence) = (random.below(1 << 40), 0),
            1 => sequence = 0,
            2 => peer = peer.saturating_sub(random.below(10_000_000_000)),
            _ => sequence += 1,
        }
        let extreme = if random.below(50) == 0 { 1e6 } else { 0.1 };
        let there = Motion { position: [extreme * random.unit(), -extreme], velocity: [extreme; 2] };
        let packet = Packet {
            session,
            energy_sent: random.unit() * 1e9,
            stiffness: random.unit() * 1e6,
            signal: [extreme, -extreme],
            ..Packet::of(sequence, PeerTime(peer), there)
        };
        let mut bytes = packet.encode();
        if random.below(100) == 0 {
            bytes[random.below(LENGTH as u64) as usize] = random.next() as u8;
        }
        let late = if random.below(10) == 0 { random.below(500) } else { random.below(20) };
        travelling[(tick + late) as usize % LATE] = (tick + late, bytes);
        let (due, bytes) = travelling[tick as usize % LATE];
        let repeat = if random.below(1_000) == 0 { 300 } else { random.below(3) };
        for _ in 0..if due == tick { repeat } else { 0 } {
            let _ = side.handle_datagram(time, &bytes);
        }
        if random.below(20) == 0 {
            let length = random.below(LENGTH as u64 + 1) as usize;
            let _ = side.handle_datagram(time, &bytes[..length]);
        }
        let force = side.force(time);
        assert!(force.iter().all(|value| value.is_finite()), "{tick}: {force:?}");
        if random.below(50) == 0 {
            let _ = (side.report(), side.next_timeout());
            side.handle_timeout(time);
        }
        if random.below(3_000) == 0 {
            while side.poll_event().is_some() {}
        }
    }
}

fn settings() -> impl Iterator<Item = EndpointSettings> {
    let law = Law { stiffness: 1e4, damping: 10.0 };
    let plain = move || EndpointSettings::new(1, law, Span(40_000_000));
    let adaptive = PlayoutSettings::Adaptive(AdaptiveDelay::default());
    [
        plain(),
        EndpointSettings { watchdog: None, computing_tick: true, ..plain() },
        EndpointSettings { playout: adaptive, ..plain() },
        EndpointSettings { playout: adaptive, clock: ClockSettings::estimated(), ..plain() },
    ]
    .into_iter()
}

/// One strategy of every kind, but the bare spring.
fn strategies() -> [StrategyChoice; 6] {
    let law = Law { stiffness: 1e4, damping: 0.0 };
    let damping = [7.0, 9.0];
    let sizes = InjectedDampingSettings {
        own_damping: damping,
        partner_damping: damping,
        round_trip: 0.2,
        own_age: 0.001,
    };
    [
        StrategyChoice::Guard(Guard::new(law, AccountSettings::new(1e4, damping)).unwrap()),
        StrategyChoice::InjectedDamping(InjectedDamping::new(1e4, sizes).unwrap()),
        StrategyChoice::WaveVariables(WaveVariables::new(WaveSettings::new(1e4, 10.0)).unwrap()),
        StrategyChoice::TimeDomainPassivity(TimeDomainPassivity::new(law, 100.0).unwrap()),
        StrategyChoice::TwoLayer(TwoLayer::new(law, TankSettings::new(1e4)).unwrap()),
        StrategyChoice::SetPositionModulation(
            SetPositionModulation::new(SetPositionSettings::new(1e4, 10.0)).unwrap(),
        ),
    ]
}

#[test]
fn law_no_strategy_allocates_and_every_force_is_finite() {
    let law = Law { stiffness: 1e4, damping: 0.0 };
    for (seed, strategy) in strategies().into_iter().enumerate() {
        // without a watchdog a strategy acts always
        let settings = EndpointSettings::new(1, law, Span(40_000_000));
        let mut side = Endpoint::new(EndpointSettings { strategy, watchdog: None, ..settings }).unwrap();
        let mut random = Random(200 + seed as u64);
        assert_eq!(without_allocator(|| torment(&mut side, 100_000, &mut random)), 0, "{seed}");
        assert!(side.report().strategy.ticks > 1_000);
    }
}

#[test]
fn law_an_endpoint_allocates_nothing_after_its_construction() {
    // the count works
    assert!(without_allocator(|| drop(std::hint::black_box(Box::new(1)))) > 0);
    for (seed, settings) in settings().enumerate() {
        let mut side = Endpoint::new(settings).unwrap();
        let mut random = Random(seed as u64);
        let uses = without_allocator(|| torment(&mut side, 100_000, &mut random));
        assert_eq!(uses, 0);
        let report = side.report();
        assert!(report.refused > 1_000 && report.restarts > 10 && report.playout.lost > 100, "{report:?}");
        assert!(seed == 3 || report.playout.ticks > 1_000, "{report:?}");
    }
}

#[test]
#[ignore = "ten million ticks"]
fn law_ten_million_ticks_of_torment_leave_every_force_finite() {
    for (seed, settings) in settings().enumerate() {
        let mut side = Endpoint::new(settings).unwrap();
        let uses = without_allocator(|| torment(&mut side, 2_500_000, &mut Random(100 + seed as u64)));
        assert_eq!(uses, 0);
    }
}
