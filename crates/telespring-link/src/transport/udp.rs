//! UDP to one address.

use std::io::{Error, ErrorKind};
use std::net::{SocketAddr, UdpSocket};
use std::os::fd::{AsFd, BorrowedFd};

use telespring::session::LocalTime;

use super::{ROOM, Transport, TransportReport};

/// Errors in a row after which the socket is left alone until the next call.
const PATIENCE: u32 = 8;

/// UDP to and from one address. The kernel drops what comes from any other; nothing is encrypted.
#[derive(Debug)]
pub struct Udp {
    socket: UdpSocket,
    report: TransportReport,
}

impl Udp {
    /// Binds `local` and talks to `peer` only.
    ///
    /// # Errors
    ///
    /// Those of the operating system, for instance if the port is in use.
    pub fn new(local: SocketAddr, peer: SocketAddr) -> Result<Self, Error> {
        Self::on(UdpSocket::bind(local)?, peer)
    }

    /// Talks to `peer` only, on a socket that is bound.
    ///
    /// # Errors
    ///
    /// Those of the operating system.
    pub fn on(socket: UdpSocket, peer: SocketAddr) -> Result<Self, Error> {
        socket.connect(peer)?;
        socket.set_nonblocking(true)?;
        let mut udp = Self { socket, report: TransportReport::default() };
        // what came from anybody between the two calls
        while udp.next(&mut [0; ROOM]).is_some() {}
        udp.report = TransportReport::default();
        Ok(udp)
    }

    /// The next datagram. A connected socket reports that nobody listens at the partner's address as an error of the next
    /// call, whichever that is: such an error is counted and says nothing about the datagrams behind it.
    fn next(&mut self, room: &mut [u8; ROOM]) -> Option<usize> {
        for _ in 0..PATIENCE {
            match self.socket.recv(room) {
                Ok(length) => {
                    self.report.received += 1;
                    return Some(length);
                }
                Err(error) if error.kind() == ErrorKind::WouldBlock => return None,
                Err(error) => self.note(&error),
            }
        }
        None
    }

    fn note(&mut self, error: &Error) {
        if matches!(
            error.kind(),
            ErrorKind::ConnectionRefused | ErrorKind::HostUnreachable | ErrorKind::NetworkUnreachable
        ) {
            self.report.unreachable += 1;
        }
    }
}

impl AsFd for Udp {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.socket.as_fd()
    }
}

impl Transport for Udp {
    fn send(&mut self, _: LocalTime, datagram: &[u8]) {
        for _ in 0..2 {
            match self.socket.send(datagram) {
                Ok(_) => {
                    self.report.sent += 1;
                    return;
                }
                // the error of a former datagram; this one has not been sent
                Err(error) if error.kind() == ErrorKind::ConnectionRefused => self.note(&error),
                Err(error) => {
                    self.note(&error);
                    break;
                }
            }
        }
        self.report.unsent += 1;
    }

    fn receive(&mut self, _: LocalTime, room: &mut [u8; ROOM]) -> Option<usize> {
        self.next(room)
    }

    fn report(&self) -> TransportReport {
        self.report
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pair() -> (Udp, UdpSocket) {
        let there = UdpSocket::bind("127.0.0.1:0").unwrap();
        let here = UdpSocket::bind("127.0.0.1:0").unwrap();
        there.connect(here.local_addr().unwrap()).unwrap();
        (Udp::on(here, there.local_addr().unwrap()).unwrap(), there)
    }

    /// Loopback delivers before `send` returns, but let it take its time.
    fn receive(udp: &mut Udp, room: &mut [u8; ROOM]) -> Option<usize> {
        (0..2000).find_map(|_| {
            let came = udp.receive(LocalTime(0), room);
            if came.is_none() {
                std::thread::sleep(std::time::Duration::from_millis(1));
            }
            came
        })
    }

    #[test]
    fn law_only_the_partner_is_heard() {
        let (mut udp, there) = pair();
        let stranger = UdpSocket::bind("127.0.0.1:0").unwrap();
        stranger.send_to(b"stranger", udp.socket.local_addr().unwrap()).unwrap();
        there.send(b"partner").unwrap();
        let mut room = [0; ROOM];
        assert_eq!(receive(&mut udp, &mut room), Some(7));
        assert_eq!(&room[..7], b"partner");
        assert_eq!(udp.receive(LocalTime(0), &mut room), None);
        assert_eq!(udp.report().received, 1);
    }

    #[test]
    fn law_a_partner_that_is_not_there_yet_hides_nothing() {
        let (mut udp, there) = pair();
        let (here, peer) = (udp.socket.local_addr().unwrap(), there.local_addr().unwrap());
        drop(there);
        for _ in 0..5 {
            udp.send(LocalTime(0), b"nobody hears");
            assert_eq!(udp.receive(LocalTime(0), &mut [0; ROOM]), None);
        }
        assert!(udp.report().unreachable > 0, "{:?}", udp.report());
        // an error waits in front of a datagram: one look finds the datagram
        udp.send(LocalTime(0), b"nobody hears");
        let there = UdpSocket::bind(peer).unwrap();
        there.send_to(b"here", here).unwrap();
        std::thread::sleep(std::time::Duration::from_millis(50));
        assert_eq!(udp.receive(LocalTime(0), &mut [0; ROOM]), Some(4));
        udp.send(LocalTime(0), b"good");
        there.set_read_timeout(Some(std::time::Duration::from_secs(2))).unwrap();
        assert_eq!(there.recv(&mut [0; 16]).unwrap(), 4);
    }

    #[test]
    fn law_a_datagram_that_is_too_long_is_cut_and_never_has_the_right_length() {
        let (mut udp, there) = pair();
        there.send(&[7; 4000]).unwrap();
        assert_eq!(receive(&mut udp, &mut [0; ROOM]), Some(ROOM));
    }
}
