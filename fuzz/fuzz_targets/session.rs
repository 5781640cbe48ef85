//! Whatever the device, the network and the clock of the caller do, one side of a coupling answers with finite forces.

#![no_main]

use libfuzzer_sys::fuzz_target;
use telespring::session::wire::LENGTH;
use telespring::session::{
    AdaptiveDelay, ClockSettings, Endpoint, EndpointSettings, Law, LocalTime, Motion, Packet, PeerTime,
    PlayoutSettings, Span,
};

/// Takes numbers from the front of the input; zeros behind its end.
struct Input<'a>(&'a [u8]);

impl Input<'_> {
    fn byte(&mut self) -> u8 {
        let Some((first, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        *first
    }

    fn whole(&mut self) -> u64 {
        u64::from_le_bytes(std::array::from_fn(|_| self.byte()))
    }

    fn number(&mut self) -> f64 {
        f64::from_bits(self.whole())
    }

    fn motion(&mut self) -> Motion {
        Motion { position: [self.number(), self.number()], velocity: [self.number(), self.number()] }
    }
}

fuzz_target!(|bytes: &[u8]| {
    let mut input = Input(bytes);
    let choice = input.byte();
    let mut settings = EndpointSettings::new(1, Law { stiffness: 1e7, damping: 1e6 }, Span(5_000_000));
    if choice & 1 != 0 {
        settings.playout = PlayoutSettings::Adaptive(AdaptiveDelay::default());
    }
    if choice & 2 != 0 {
        settings.clock = ClockSettings::estimated();
    }
    if choice & 4 != 0 {
        settings.watchdog = None;
    }
    settings.computing_tick = choice & 8 != 0;
    let mut side = Endpoint::new(settings).expect("the settings are allowed");
    let mut now = LocalTime(0);
    while !input.0.is_empty() {
        match input.byte() % 8 {
            0 => now = LocalTime(input.whole()),
            1 => now = now + Span(i64::from(input.byte()) * 100_000),
            2 => {
                let _ = side.handle_measurement(now, input.motion());
            }
            3 => side.handle_target(now, input.motion()),
            4 => side.handle_acted([input.number(), input.number()]),
            5 => {
                let length = usize::from(input.byte()).min(input.0.len()).min(LENGTH);
                let (datagram, rest) = input.0.split_at(length);
                input.0 = rest;
                let _ = side.handle_datagram(now, datagram);
            }
            6 => {
                let motion = Motion { position: [0.1, -0.1], velocity: [f64::from(input.byte()); 2] };
                let sent = PeerTime(now.0.saturating_sub(u64::from(input.byte()) * 1_000_000));
                let session = u64::from(input.byte() % 4);
                let packet = Packet { session, ..Packet::of(u64::from(input.byte()), sent, motion) };
                let _ = side.handle_datagram(now, &packet.encode());
            }
            _ => {
                let _ = (side.poll_transmit(now), side.poll_event(), side.next_timeout(), side.report());
            }
        }
        assert!(side.force(now).iter().all(|force| force.is_finite()));
    }
});
