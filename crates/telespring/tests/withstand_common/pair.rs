//! Two robots, each driven by an endpoint, tick by tick, with a channel towards each.

use super::plant::{AxisPlant, Step};
use telespring::rig::{Channel, Datagram};
use telespring::session::{Endpoint, LocalTime, Motion, Span};

/// What a side does to the force before it acts on its handle.
#[derive(Debug, Clone, Copy)]
pub struct Actuator {
    /// A force acts one period after the motion that it was computed from.
    pub computing_tick: bool,
    /// The largest force per axis, N.
    pub limit: f64,
    /// The endpoint is told the mean force that acted; otherwise it knows it by itself.
    pub is_told: bool,
}

impl Actuator {
    /// An actuator that does at once what it is told.
    pub const IDEAL: Self = Self { computing_tick: false, limit: f64::INFINITY, is_told: false };
}

/// The clock of a side: it reads `offset` at 0 s and runs faster by a share.
#[derive(Debug, Clone, Copy)]
pub struct SideClock {
    pub offset: Span,
    pub drift: f64,
}

impl SideClock {
    pub const TRUE: Self = Self { offset: Span(0), drift: 0.0 };

    pub fn at(&self, time: LocalTime) -> LocalTime {
        time + self.offset + Span((time.0 as f64 * self.drift).round() as i64)
    }
}

/// One side.
pub struct Station {
    pub plants: [AxisPlant; 2],
    pub endpoint: Endpoint,
    pub actuator: Actuator,
    pub clock: SideClock,
    /// The step of the position sensor, m; 0 for none.
    pub encoder_step: f64,
    /// The channel towards this side.
    pub channel: Box<dyn Channel>,
    /// The motion as measured last.
    pub measured: Motion,
    /// The force computed at the previous tick, N.
    pending: [f64; 2],
}

impl Station {
    pub fn new(plants: [AxisPlant; 2], endpoint: Endpoint, channel: Box<dyn Channel>) -> Self {
        Self {
            plants,
            endpoint,
            actuator: Actuator::IDEAL,
            clock: SideClock::TRUE,
            encoder_step: 0.0,
            channel,
            measured: Motion::default(),
            pending: [0.0; 2],
        }
    }

    /// The motion as the sensor sees it.
    fn measure(&self) -> Motion {
        let step = self.encoder_step;
        let round = |x: f64| if step > 0.0 { (x / step).round() * step } else { x };
        Motion {
            position: self.plants.each_ref().map(|plant| round(plant.position)),
            velocity: self.plants.each_ref().map(|plant| plant.velocity),
        }
    }

    /// Hands over what has arrived, first to `listen`, with whether the endpoint took it; the force, N.
    pub fn answer(&mut self, now: LocalTime, mut listen: impl FnMut(&Datagram, bool)) -> [f64; 2] {
        let local = self.clock.at(now);
        self.channel.observe(self.measured);
        while let Some(packet) = self.channel.deliver(now) {
            let is_taken = self.endpoint.handle_datagram(local, &packet).is_ok();
            listen(&packet, is_taken);
        }
        self.endpoint.force(local)
    }

    /// Moves the robot over one period with the force just computed and the hand's forces, N.
    pub fn advance(&mut self, computed: [f64; 2], hand: [f64; 2]) -> [Step; 2] {
        let Actuator { computing_tick, limit, is_told } = self.actuator;
        let before = std::mem::replace(&mut self.pending, computed);
        let command = if computing_tick { before } else { computed };
        let steps = [0, 1]
            .map(|axis| self.plants[axis].advance_robot(command[axis].clamp(-limit, limit), hand[axis]));
        if is_told {
            self.endpoint.handle_acted(steps.map(|step| step.mean));
        }
        steps
    }
}

/// Both sides measure and send; the packets go into the channels.
pub fn measure_and_send(stations: &mut [Station; 2], now: LocalTime) {
    for side in 0..2 {
        let station = &mut stations[side];
        let local = station.clock.at(now);
        station.measured = station.measure();
        station.endpoint.handle_measurement(local, station.measured).unwrap();
        let packet = station.endpoint.poll_transmit(local).unwrap();
        stations[1 - side].channel.send(now, packet);
    }
}
