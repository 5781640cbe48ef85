//! The robot of a study with its simulated person.

use telespring::InvalidInput;
use telespring::rig::{Laboratory, SimulatedRobot};
use telespring::session::{LocalTime, Span};

use super::{Command, Device, Fault, Reading, Stamp};

/// The most steps of one call: after a longer standstill the simulated robot skips time.
const MOST_STEPS: i64 = 10_000;

/// The robot of a study with its simulated person, moved as far as the time that has passed. The person rests on the first
/// target until the session runs, and on the latest one while it does not run any more. Like a real device, it acts on a command for [`Simulated::deadline`] only.
#[derive(Debug, Clone)]
pub struct Simulated {
    robot: SimulatedRobot,
    period: Span,
    command: Command,
    /// When the session began to run, less the time during which it did not; and when the robot was moved and told last.
    began: Option<LocalTime>,
    moved: LocalTime,
    told: LocalTime,
    /// Whether the actuator lags.
    lags: bool,
    /// Measurements so far.
    measurements: u64,
}

impl Simulated {
    /// The robot of a side, 0 or 1; `seed` draws what the simulated person sees.
    ///
    /// # Errors
    ///
    /// Those of [`SimulatedRobot::new`].
    pub fn new(laboratory: &Laboratory, side: usize, seed: u64) -> Result<Self, InvalidInput> {
        Ok(Self {
            robot: SimulatedRobot::new(laboratory, side, seed)?,
            period: Span::from_seconds(laboratory.controller.sample_period),
            command: Command::default(),
            began: None,
            moved: LocalTime(0),
            told: LocalTime(0),
            lags: laboratory.controller.actuator_lag > 0.0,
            measurements: 0,
        })
    }

    /// How long the robot acts on a command; then its force is zero until the next one.
    pub fn deadline(&self) -> Span {
        Span(self.period.0.saturating_mul(20))
    }

    /// Moves the robot up to `now`, by one step or, after a standstill, by several of a sample period. Returns the mean
    /// force if it was not the command.
    fn advance(&mut self, began: LocalTime, now: LocalTime) -> Result<Option<[f64; 2]>, Fault> {
        let whole = now - self.moved;
        let end = self.told + self.deadline();
        let steps = (whole.0 / self.period.0.max(1)).clamp(1, MOST_STEPS);
        let (mut impulse, mut expired) = ([0.0; 2], false);
        for step in 0..steps {
            let (from, to) = (whole.0 * step / steps, whole.0 * (step + 1) / steps);
            let at = self.moved + Span(from);
            let shown = if self.command.is_running { at } else { self.moved };
            let span = Span(to - from).seconds();
            expired |= at >= end;
            let force = if at >= end { [0.0; 2] } else { self.command.force };
            let acted =
                self.robot.advance((shown - began).seconds(), force, span).map_err(|_| Fault::Halted)?;
            impulse = [0, 1].map(|axis| impulse[axis] + acted[axis] * span);
        }
        self.moved = now;
        let mean = impulse.map(|impulse| impulse / whole.seconds());
        Ok((self.lags || expired).then_some(mean))
    }
}

impl Device for Simulated {
    fn read(&mut self, now: LocalTime) -> Result<Reading, Fault> {
        let acted = match self.began {
            Some(began) if now > self.moved => {
                let stood_still = now - self.moved;
                let acted = self.advance(began, now)?;
                if !self.command.is_running {
                    self.began = Some(began + stood_still);
                }
                acted
            }
            _ => None,
        };
        // The clock of the person starts with the first measurement of a session that runs.
        if self.command.is_running && self.began.is_none() {
            (self.began, self.moved, self.told) = (Some(now), now, now);
        }
        let began = self.began.unwrap_or(now);
        self.measurements += 1;
        Ok(Reading {
            motion: Some(self.robot.measure()),
            stamp: Some(Stamp { sequence: self.measurements as f64, time: now.seconds() }),
            acted,
            target: Some(self.robot.target((now - began).seconds())),
            is_ready: true,
            is_stopped: false,
        })
    }

    fn command(&mut self, now: LocalTime, command: Command) {
        (self.command, self.told) = (command, now);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_the_person_rests_until_the_session_runs() {
        let mut device = Simulated::new(&Laboratory::paper(), 0, 1).unwrap();
        let start = device.read(LocalTime(0)).unwrap();
        let later = device.read(LocalTime(500_000_000)).unwrap();
        assert_eq!((start.motion, start.target), (later.motion, later.target));
        device.command(LocalTime(500_000_000), Command { is_running: true, ..Command::default() });
        device.read(LocalTime(501_000_000)).unwrap();
        let moving = device.read(LocalTime(901_000_000)).unwrap();
        assert!(moving.motion != start.motion && moving.target != start.target);
    }

    #[test]
    fn law_a_command_ends_at_its_deadline() {
        let mut laboratory = Laboratory::paper();
        // nobody holds the handle
        laboratory.stations[0].agent = telespring::rig::Agent::Skilled { stiffness: 0.0, damping: 0.0 };
        let reach = |stall: i64| {
            let mut device = Simulated::new(&laboratory, 0, 1).unwrap();
            let push = Command { force: [5.0, 0.0], is_running: true, is_over: false };
            device.command(LocalTime(0), push);
            device.read(LocalTime(1_000_000)).unwrap();
            device.command(LocalTime(1_000_000), push);
            let reading = device.read(LocalTime(1_000_000) + Span(stall)).unwrap();
            (reading.motion.unwrap().velocity[0], reading.acted)
        };
        // The velocity of a damped mass under a held force that ends after 20 ms, and then decays.
        let (m, b) = (0.8334, 7.7257);
        let at = |stall: f64| 5.0 / b * (1.0 - (-b / m * 0.02_f64).exp()) * (-b / m * (stall - 0.02)).exp();
        let (pushed, acted) = reach(20_000_000);
        assert!((pushed - at(0.02)).abs() < 1e-12 && acted.is_none());
        let (coasting, acted) = reach(500_000_000);
        assert!((coasting - at(0.5)).abs() < 1e-12, "{coasting} {}", at(0.5));
        // 20 of 500 ms
        assert!((acted.unwrap()[0] - 0.2).abs() < 1e-12);
    }
}
