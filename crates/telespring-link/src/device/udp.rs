//! A robot behind the device protocol.

use std::io::Error;
use std::net::{SocketAddr, UdpSocket};
use std::os::fd::{AsFd, BorrowedFd};

use telespring::session::{LocalTime, Span};

use super::protocol::{Order, State};
use super::request::{Request, Requests};
use super::unread::Unread;
use super::{Command, Device, Fault, Reading, Stamp};
use crate::operator;
use crate::transport::{ROOM, Transport, Udp};

/// Rows that are looked at in one tick: as many as wait in a socket after a standstill.
const MOST_ROWS: usize = 512;

/// A robot whose program speaks the device protocol (`docs/device-protocol.md`).
#[derive(Debug)]
pub struct UdpDevice {
    link: Udp,
    deadline: Span,
    newest: Option<State>,
    /// The sequence number of the newest row before the device fell silent.
    former: Option<f64>,
    heard: Option<LocalTime>,
    unread: Unread,
    orders: u64,
    refused: u64,
    requests: Requests,
}

impl UdpDevice {
    /// The robot at the address `device`; this side listens at `local`. If nothing comes for `deadline` after the first
    /// row, the device is at fault.
    ///
    /// # Errors
    ///
    /// Those of the operating system.
    pub fn new(local: SocketAddr, device: SocketAddr, deadline: Span) -> Result<Self, Error> {
        Self::on(UdpSocket::bind(local)?, device, deadline)
    }

    /// As [`UdpDevice::new`], on a socket that is bound.
    ///
    /// # Errors
    ///
    /// Those of the operating system.
    pub fn on(socket: UdpSocket, device: SocketAddr, deadline: Span) -> Result<Self, Error> {
        let link = Udp::on(socket, device)?;
        Ok(Self {
            link,
            deadline,
            newest: None,
            former: None,
            heard: None,
            unread: Unread::default(),
            orders: 0,
            refused: 0,
            requests: Requests::default(),
        })
    }

    /// Rows that were no data, repeated or overtaken.
    pub fn refused(&self) -> u64 {
        self.refused
    }

    /// Takes a row; the state if it is newer than all before. A device program that is started anew counts from the
    /// beginning, and is not believed before the former one has been silent for the deadline.
    fn take(&mut self, row: &[u8]) -> Option<State> {
        if let Some(request) = Request::decode(row) {
            let is_lost = !self.requests.take(request);
            self.refused = self.refused.saturating_add(u64::from(is_lost));
            return None;
        }
        let newest = self.newest.map_or(f64::NEG_INFINITY, |state| state.sequence);
        let state = State::decode(row).filter(|state| state.sequence.is_finite() && state.sequence > newest);
        match state {
            Some(State { sequence, .. }) => {
                // It counts anew, so it was started anew, and so do its orders. One that goes on may repeat an old order.
                if self.former.take().is_some_and(|former| sequence <= former) {
                    self.requests.begin_anew();
                }
                self.newest = state;
            }
            None => self.refused = self.refused.saturating_add(1),
        }
        state
    }
}

impl Device for UdpDevice {
    fn listen(&mut self, now: LocalTime) -> bool {
        let mut room = [0; ROOM];
        for _ in 0..MOST_ROWS {
            let Some(length) = self.link.receive(now, &mut room) else { break };
            if let Some(state) = self.take(room.get(..length).unwrap_or_default()) {
                self.unread.add(&state);
            }
        }
        self.unread.rows > 0
    }

    fn read(&mut self, now: LocalTime) -> Result<Reading, Fault> {
        let is_fresh = self.listen(now);
        let unread = std::mem::take(&mut self.unread);
        if is_fresh {
            self.heard = Some(now);
        } else if self.heard.is_some_and(|heard| now - heard > self.deadline) {
            // whatever comes next may be a program started anew
            self.former = self.newest.take().map(|state| state.sequence).or(self.former);
            return Err(Fault::Silent);
        }
        let state = self.newest;
        Ok(Reading {
            motion: state.filter(|_| is_fresh).map(|state| state.motion),
            stamp: state.map(|State { sequence, time, .. }| Stamp { sequence, time }),
            acted: unread.force(),
            target: None,
            is_ready: !unread.was_unready && state.is_some_and(|state| state.is_enabled && state.is_homed),
            is_stopped: unread.was_stopped || state.is_some_and(|state| state.is_stopped),
        })
    }

    fn command(&mut self, now: LocalTime, command: Command) {
        // From the time on: the device acts on a higher number only, also after this program was started anew.
        self.orders = if self.orders == 0 { now.0 / 1000 } else { self.orders } + 1;
        let answers = self.newest.map_or([0.0; 2], |state| [state.sequence, state.time]);
        let Command { force, is_running, is_over } = command;
        let order = Order { sequence: self.orders as f64, answers, force, is_running, is_over };
        self.link.send(now, &order.encode());
    }

    fn poll_order(&mut self) -> Option<operator::Order> {
        self.requests.poll()
    }

    fn lacks(&self) -> Option<&'static str> {
        self.newest.and_then(|state| match (state.is_homed, state.is_enabled) {
            (false, false) => Some("it is not homed, and its motors are not enabled"),
            (false, true) => Some("it is not homed"),
            (true, false) => Some("its motors are not enabled"),
            (true, true) => None,
        })
    }

    fn pace(&self) -> Option<BorrowedFd<'_>> {
        Some(self.link.as_fd())
    }
}

#[cfg(test)]
mod tests {
    use telespring::session::Motion;

    use super::*;

    const MILLISECOND: Span = Span(1_000_000);

    /// A device program in the hands of a test.
    struct Robot(UdpSocket);

    impl Robot {
        fn pair() -> (Self, UdpDevice) {
            let [robot, site] = [(); 2].map(|()| UdpSocket::bind("127.0.0.1:0").unwrap());
            robot.connect(site.local_addr().unwrap()).unwrap();
            let there = robot.local_addr().unwrap();
            (Self(robot), UdpDevice::on(site, there, Span(100_000_000)).unwrap())
        }

        fn send(&self, sequence: f64, x: f64, force: Option<f64>) {
            let state = State {
                sequence,
                time: 0.5,
                motion: Motion { position: [x, 0.0], velocity: [0.0; 2] },
                measured_force: force.map(|force| [force, 0.0]),
                is_enabled: true,
                is_homed: true,
                is_stopped: false,
            };
            self.send_row(&state.encode());
        }

        /// Sends, and gives the system time to deliver.
        fn send_row(&self, row: &[u8]) {
            self.0.send(row).unwrap();
            std::thread::sleep(std::time::Duration::from_millis(20));
        }
    }

    #[test]
    fn law_the_newest_row_counts_and_rows_of_the_past_do_not() {
        let (robot, mut device) = Robot::pair();
        let now = LocalTime(0);
        let nothing = device.read(now).unwrap();
        assert_eq!((nothing.motion, nothing.is_ready, nothing.is_stopped), (None, false, false));
        robot.send(5.0, 0.1, Some(1.0));
        robot.send(6.0, 0.2, None);
        robot.send(7.0, 0.3, Some(2.0));
        let reading = device.read(now).unwrap();
        assert_eq!(reading.motion.unwrap().position, [0.3, 0.0]);
        assert_eq!(reading.stamp, Some(Stamp { sequence: 7.0, time: 0.5 }));
        assert_eq!(reading.acted, Some([1.5, 0.0]));
        assert!(reading.is_ready);
        // told once only
        assert_eq!(device.read(now).unwrap().motion, None);
        robot.send(7.0, 0.4, None);
        robot.send(1.0, 0.4, None);
        robot.send(f64::NAN, 0.4, None);
        robot.send(f64::INFINITY, 0.4, None);
        robot.send_row(&[0; 104]);
        robot.send_row(b"hello");
        let reading = device.read(now).unwrap();
        assert_eq!((reading.motion, reading.acted, reading.is_ready), (None, None, true));
        assert_eq!(device.refused(), 6);
        robot.send(8.0, 0.5, None);
        assert_eq!(device.read(now).unwrap().motion.unwrap().position, [0.5, 0.0]);
    }

    #[test]
    fn law_a_silent_device_is_at_fault_once_it_has_spoken() {
        let (robot, mut device) = Robot::pair();
        let at = |milliseconds: i64| LocalTime(0) + Span(milliseconds * MILLISECOND.0);
        assert!(device.read(at(10_000)).is_ok());
        robot.send(1.0, 0.0, None);
        assert!(device.read(at(10_000)).is_ok());
        assert!(device.read(at(10_100)).is_ok());
        assert_eq!(device.read(at(10_101)), Err(Fault::Silent));
        assert_eq!(device.read(at(10_102)), Err(Fault::Silent));
        // its program is started anew, and counts from the beginning
        robot.send(0.0, 0.1, None);
        assert!(device.read(at(10_200)).unwrap().is_ready);
    }

    #[test]
    fn law_orders_of_a_device_wait_and_none_counts_twice() {
        use crate::operator::Order::{Consent, Pause, Stop};
        let (robot, mut device) = Robot::pair();
        for (sequence, code) in [(1.0, 1.0), (1.0, 1.0), (0.0, 2.0), (2.0, 3.0), (3.0, 99.0), (4.0, 5.0)] {
            robot.send_row(&Request::encode(sequence, code, 0.0));
        }
        // an order is no sign of life of the robot
        assert_eq!(device.read(LocalTime(0)).unwrap().motion, None);
        let orders: Vec<_> = std::iter::from_fn(|| device.poll_order()).collect();
        assert_eq!(orders, [Consent, Pause, Stop]);
        assert_eq!(device.refused(), 3);
    }

    #[test]
    fn law_a_stop_and_motors_that_may_not_act_count_in_every_row() {
        for place in [10, 11, 12] {
            let (robot, mut device) = Robot::pair();
            for sequence in 1..4_u8 {
                let flag = f64::from(u8::from((sequence == 2) == (place == 12)));
                let mut row =
                    [1.0, f64::from(sequence), 0.5, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0];
                row[place] = flag;
                robot.send_row(&super::super::protocol::bytes::<13, 104>(row));
            }
            let reading = device.read(LocalTime(0)).unwrap();
            assert_eq!((reading.is_ready, reading.is_stopped), (place == 12, place == 12), "{place}");
            let reading = device.read(LocalTime(0)).unwrap();
            assert_eq!((reading.is_ready, reading.is_stopped), (true, false), "{place}");
        }
    }

    #[test]
    fn law_only_a_new_row_is_a_measurement_and_no_row_is_lost_by_listening() {
        let (robot, mut device) = Robot::pair();
        assert!(!device.listen(LocalTime(0)));
        robot.send_row(&[0; 104]);
        robot.send_row(b"noise");
        robot.send_row(&Request::encode(1.0, 1.0, 0.0));
        assert!(!device.listen(LocalTime(0)));
        robot.send(1.0, 0.1, Some(1.0));
        assert!(device.listen(LocalTime(0)));
        // repeated: nothing new, but the one before is unread
        robot.send(1.0, 0.1, Some(1.0));
        assert!(device.listen(LocalTime(0)));
        robot.send(2.0, 0.2, Some(2.0));
        let reading = device.read(LocalTime(0)).unwrap();
        assert_eq!((reading.motion.unwrap().position[0], reading.acted), (0.2, Some([1.5, 0.0])));
        robot.send(2.0, 0.2, Some(1.0));
        assert!(!device.listen(LocalTime(0)));
        assert_eq!(device.poll_order(), Some(operator::Order::Consent));
    }

    #[test]
    fn law_after_a_standstill_the_newest_row_counts() {
        let (robot, mut device) = Robot::pair();
        for sequence in 1..=200 {
            let state = State {
                sequence: f64::from(sequence),
                time: 0.5,
                motion: Motion { position: [f64::from(sequence), 0.0], velocity: [0.0; 2] },
                measured_force: None,
                is_enabled: true,
                is_homed: true,
                is_stopped: false,
            };
            robot.0.send(&state.encode()).unwrap();
        }
        std::thread::sleep(std::time::Duration::from_millis(50));
        assert_eq!(device.read(LocalTime(0)).unwrap().motion.unwrap().position[0], 200.0);
    }

    #[test]
    fn law_a_device_that_goes_on_after_a_silence_repeats_no_order_and_one_started_anew_is_heard() {
        use crate::operator::Order::{Clear, Consent};
        let at = |milliseconds: i64| LocalTime(0) + Span(milliseconds * MILLISECOND.0);
        let (robot, mut device) = Robot::pair();
        let clear = Request::encode(9.0, 6.0, 0.0);
        robot.send(5.0, 0.1, None);
        robot.send_row(&clear);
        device.read(at(0)).unwrap();
        assert_eq!(device.poll_order(), Some(Clear));
        for milliseconds in [101, 150] {
            assert_eq!(device.read(at(milliseconds)), Err(Fault::Silent));
        }
        // the same program, which sends its last order again and again
        robot.send_row(&clear);
        robot.send(6.0, 0.1, None);
        robot.send_row(&clear);
        assert!(device.read(at(200)).is_ok());
        assert_eq!(device.poll_order(), None);
        assert_eq!(device.read(at(400)), Err(Fault::Silent));
        // another one
        robot.send(0.0, 0.1, None);
        robot.send_row(&Request::encode(0.0, 1.0, 0.0));
        assert!(device.read(at(500)).is_ok());
        assert_eq!(device.poll_order(), Some(Consent));
    }

    #[test]
    fn law_after_a_new_start_commands_are_newer_than_those_before() {
        let robot = UdpSocket::bind("127.0.0.1:0").unwrap();
        robot.set_read_timeout(Some(std::time::Duration::from_secs(2))).unwrap();
        let mut newest = 0.0;
        // sessions one after the other, the first with a command per 0.5 ms
        for (start, commands, interval) in [(7, 2000, 500_000), (1_000_000_300, 5, 1_000_000)] {
            let site = UdpSocket::bind("127.0.0.1:0").unwrap();
            let mut device = UdpDevice::on(site, robot.local_addr().unwrap(), Span(100_000_000)).unwrap();
            for number in 0..commands {
                device.command(LocalTime(start + number * interval), Command::default());
                let mut row = [0; 100];
                let length = robot.recv(&mut row).unwrap();
                let order = Order::decode(&row[..length]).unwrap();
                assert!(order.sequence > newest, "{} after {newest}", order.sequence);
                newest = order.sequence;
            }
        }
    }

    #[test]
    fn law_a_command_answers_the_newest_row() {
        let (robot, mut device) = Robot::pair();
        robot.0.set_read_timeout(Some(std::time::Duration::from_secs(2))).unwrap();
        let hear = || {
            let mut row = [0; 100];
            let length = robot.0.recv(&mut row).unwrap();
            Order::decode(&row[..length]).unwrap()
        };
        device.command(LocalTime(0), Command::default());
        let nothing =
            Order { sequence: 1.0, answers: [0.0; 2], force: [0.0; 2], is_running: false, is_over: false };
        assert_eq!(hear(), nothing);
        robot.send(4.0, 0.0, None);
        device.read(LocalTime(0)).unwrap();
        device.command(LocalTime(0), Command { force: [1.0, -2.0], is_running: true, is_over: false });
        let force = [1.0, -2.0];
        assert_eq!(hear(), Order { sequence: 2.0, answers: [4.0, 0.5], force, is_running: true, ..nothing });
    }
}
