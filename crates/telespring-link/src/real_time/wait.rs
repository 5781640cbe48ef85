//! Waiting for the clock, or for the device with the clock as the limit.

use std::os::fd::BorrowedFd;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use telespring::session::LocalTime;

use crate::clock::{Clock, MonotonicClock};

/// What ended a wait.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Woken {
    /// The time has come.
    Clock,
    /// The device has sent something.
    Device,
}

/// Waits until `due`, or until `device` is readable but not before `earliest`.
pub(super) fn wait(device: Option<BorrowedFd<'_>>, earliest: LocalTime, due: LocalTime) -> Woken {
    let clock = MonotonicClock;
    let Some(device) = device else {
        clock.sleep_until(due);
        return Woken::Clock;
    };
    clock.sleep_until(earliest);
    loop {
        let left = (due - clock.now()).0.max(0);
        let limit = Timespec { tv_sec: left / 1_000_000_000, tv_nsec: left % 1_000_000_000 };
        let mut watched = [PollFd::new(&device, PollFlags::IN)];
        match poll(&mut watched, Some(&limit)) {
            Ok(_) if watched.iter().any(|device| device.revents().contains(PollFlags::IN)) => {
                return Woken::Device;
            }
            // a signal
            Err(_) if clock.now() < due => {}
            _ => {
                // a limit is rounded: the clock has the last word. So it has while the device's program is not there, which
                // is an error of the socket, and no measurement.
                clock.sleep_until(due);
                return Woken::Clock;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::net::UdpSocket;
    use std::os::fd::AsFd;

    use telespring::session::Span;

    use super::*;

    #[test]
    fn law_a_measurement_ends_the_wait_but_not_before_its_time() {
        let clock = MonotonicClock;
        let device = UdpSocket::bind("127.0.0.1:0").unwrap();
        let after = |milliseconds: i64| clock.now() + Span(milliseconds * 1_000_000);
        let due = after(3);
        assert_eq!(wait(Some(device.as_fd()), clock.now(), due), Woken::Clock);
        assert!(clock.now() >= due);
        device.send_to(b"row", device.local_addr().unwrap()).unwrap();
        let (earliest, due) = (after(3), after(60_000));
        assert_eq!(wait(Some(device.as_fd()), earliest, due), Woken::Device);
        assert!(clock.now() >= earliest && clock.now() < due);
        let due = after(1);
        assert_eq!(wait(None, after(-1), due), Woken::Clock);
        assert!(clock.now() >= due);
    }

    #[test]
    fn law_a_device_that_is_not_there_ends_no_wait() {
        let clock = MonotonicClock;
        let nobody = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
        let device = UdpSocket::bind("127.0.0.1:0").unwrap();
        device.connect(nobody).unwrap();
        device.send(b"command").unwrap();
        let due = clock.now() + Span(20_000_000);
        assert_eq!(wait(Some(device.as_fd()), clock.now(), due), Woken::Clock);
        assert!(clock.now() >= due);
        // the error was there all the time
        assert!(device.take_error().unwrap().is_some());
    }
}
