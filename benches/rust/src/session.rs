//! One tick of one side of a live coupling: measurement, packet out, packet in, force.

use std::error::Error;
use std::hint::black_box;

use telespring::session::{
    AdaptiveDelay, ClockSettings, Endpoint, EndpointSettings, Law, LocalTime, Motion, PlayoutSettings, Span,
};

use crate::Bench;

const PERIOD: u64 = 1_000_000;
/// Ticks that a packet travels, each way.
const TRAVEL: usize = 84;

/// Two sides and the packets on their way.
struct Pair {
    sides: [Endpoint; 2],
    travelling: [[Option<[u8; telespring::session::wire::LENGTH]>; TRAVEL]; 2],
    tick: u64,
}

impl Pair {
    fn new(adaptive: bool) -> Result<Self, telespring::InvalidInput> {
        let law = Law { stiffness: 71.2, damping: 0.0 };
        let side = |session| {
            let mut settings = EndpointSettings::new(session, law, Span(85 * PERIOD as i64));
            if adaptive {
                settings.playout = PlayoutSettings::Adaptive(AdaptiveDelay::default());
                settings.clock = ClockSettings::estimated();
            }
            Endpoint::new(settings)
        };
        Ok(Self { sides: [side(1)?, side(2)?], travelling: [[None; TRAVEL]; 2], tick: 0 })
    }

    fn step(&mut self) {
        let now = LocalTime(self.tick * PERIOD);
        let place = self.tick as usize % TRAVEL;
        for side in 0..2 {
            // what was sent that many ticks ago arrives, then its place is used again
            let came = self.travelling[side][place].take();
            let endpoint = &mut self.sides[side];
            let position = [0.1 * (self.tick as f64 * 1e-3 + side as f64).sin(), 0.0];
            let _ = endpoint.handle_measurement(now, Motion { position, velocity: [0.1, 0.0] });
            let packet = endpoint.poll_transmit(now);
            if let Some(packet) = came {
                let _ = endpoint.handle_datagram(now, &packet);
            }
            black_box(endpoint.force(now));
            self.travelling[1 - side][(place + side) % TRAVEL] = packet;
        }
        self.tick += 1;
    }
}

pub fn run(bench: &mut Bench) -> Result<(), Box<dyn Error>> {
    let ticks = if bench.quick { 500 } else { 10_000 };
    for (name, adaptive) in [("fixed", false), ("adaptive", true)] {
        let mut pair = Pair::new(adaptive)?;
        for _ in 0..2_000 {
            pair.step();
        }
        bench.time(&format!("session/{name}"), 2 * ticks, 1.0, || {
            for _ in 0..ticks {
                pair.step();
            }
        });
        let engaged = pair.sides.iter().all(|side| side.report().strategy.ticks > 1_000);
        bench.note(&format!("session/{name}/engaged"), engaged);
    }
    Ok(())
}
