//! The telemetry stream: a row of numbers per tick for programs beside this one, for instance bridges to ROS 2 and LSL.
//!
//! Every row is a datagram of [`VALUES`] little-endian doubles. What is not known is NaN. `docs/telemetry.md` has the places.

mod row;

pub use row::{COLUMNS, VALUES, VERSION, phase_code, watchdog_code};

use std::io::{Error, ErrorKind};
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr, UdpSocket};

use crate::feed::{Item, Observer};
use crate::hello::Terms;
use crate::settings::TelemetryChoice;
use crate::site::Happened;
use crate::summary::Summary;
use row::Frame;

/// Sends the rows of a session.
#[derive(Debug)]
pub struct Telemetry {
    /// Where the rows go, each with a socket of its own.
    ends: Vec<(UdpSocket, SocketAddr)>,
    /// A row every so many ticks.
    every: u64,
    frame: Frame,
    /// Ticks seen.
    ticks: u64,
    /// Rows for which the system had no room.
    unsent: u64,
}

impl Telemetry {
    /// The stream of a site with these terms.
    ///
    /// # Errors
    ///
    /// Those of the operating system.
    pub fn new(choice: &TelemetryChoice, terms: &Terms) -> Result<Self, Error> {
        let every = u64::from(choice.every.max(1));
        let [stiffness, _] = terms.coupling;
        let frame = Frame {
            side: terms.side,
            stiffness,
            interval: terms.sample_period * every as f64,
            sequence: 0,
            missed: 0,
            motion: None,
        };
        let ends = choice.addresses.iter().map(|address| Ok((open(*address)?, *address)));
        Ok(Self { ends: ends.collect::<Result<_, Error>>()?, every, frame, ticks: 0, unsent: 0 })
    }

    fn send(&mut self, datagram: &[u8]) {
        for (socket, address) in &self.ends {
            match socket.send_to(datagram, *address) {
                Ok(_) => {}
                // nobody listens there, or not yet
                Err(error) if error.kind() == ErrorKind::ConnectionRefused => {}
                Err(_) => self.unsent += 1,
            }
        }
    }
}

/// A socket that sends to addresses of this machine.
fn open(address: SocketAddr) -> Result<UdpSocket, Error> {
    let socket = if address.is_ipv4() {
        UdpSocket::bind((Ipv4Addr::LOCALHOST, 0))?
    } else {
        UdpSocket::bind((Ipv6Addr::LOCALHOST, 0))?
    };
    socket.set_nonblocking(true)?;
    Ok(socket)
}

impl Observer for Telemetry {
    fn name(&self) -> &'static str {
        "telemetry"
    }

    fn take(&mut self, item: &Item) {
        let (moment, lateness) = match item {
            Item::Tick { moment, lateness, .. } => (moment, lateness),
            Item::Event { time, happened: Happened::Mark(mark) } => {
                let (kind, text) = (mark.kind.word(), mark.label.text());
                self.send(format!("mark {:.9} {kind} {text}", time.seconds()).as_bytes());
                return;
            }
            Item::Event { .. } | Item::Arrival(_) => return,
        };
        self.frame.motion = moment.motion.or(self.frame.motion);
        let is_due = self.ticks.is_multiple_of(self.every);
        self.ticks += 1;
        if is_due {
            self.frame.sequence += 1;
            let row = self.frame.row(moment, *lateness);
            let bytes: Vec<u8> = row.iter().flat_map(|value| value.to_le_bytes()).collect();
            self.send(&bytes);
        }
    }

    fn miss(&mut self, count: u64) {
        self.frame.missed = self.frame.missed.saturating_add(count);
    }

    fn finish(&mut self, _: &Summary) {
        if self.unsent > 0 {
            eprintln!("The system had no room for {} rows of telemetry.", self.unsent);
        }
    }
}

#[cfg(test)]
mod tests {
    use telespring::session::{LocalTime, Span};
    use telespring::study::Study;

    use super::row::tests::moment;
    use super::*;
    use crate::operator::{Mark, MarkKind};

    #[test]
    fn law_every_listener_gets_the_rows_that_are_due() {
        let listeners = [(); 2].map(|()| UdpSocket::bind("127.0.0.1:0").unwrap());
        let absent = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
        let mut addresses: Vec<_> = listeners.iter().map(|socket| socket.local_addr().unwrap()).collect();
        addresses.insert(0, absent);
        let choice = TelemetryChoice { addresses, every: 3 };
        let mut telemetry = Telemetry::new(&choice, &Terms::new(&Study::paper(), 1).unwrap()).unwrap();
        telemetry.take(&Item::Event { time: LocalTime(0), happened: crate::site::Happened::Restored });
        telemetry.miss(5);
        for _ in 0..7 {
            let (lateness, duration) = (Span(0), Span(0));
            telemetry.take(&Item::Tick { moment: moment(), lateness, duration, overruns: 0 });
        }
        for listener in listeners {
            listener.set_read_timeout(Some(std::time::Duration::from_secs(5))).unwrap();
            let mut room = [0; 1000];
            for sequence in 1..=3_u32 {
                assert_eq!(listener.recv(&mut room).unwrap(), 8 * VALUES);
                let value =
                    |place: usize| f64::from_le_bytes(room[8 * place..8 * place + 8].try_into().unwrap());
                assert_eq!([value(0), value(1), value(36)], [1.0, f64::from(sequence), 5.0]);
            }
            listener.set_nonblocking(true).unwrap();
            assert!(listener.recv(&mut room).is_err());
        }
        assert_eq!(telemetry.unsent, 0);
    }

    #[test]
    fn law_a_marker_is_sent_as_text() {
        let listener = UdpSocket::bind("127.0.0.1:0").unwrap();
        let choice = TelemetryChoice { addresses: vec![listener.local_addr().unwrap()], every: 1 };
        let mut telemetry = Telemetry::new(&choice, &Terms::new(&Study::paper(), 1).unwrap()).unwrap();
        for (kind, text) in [(MarkKind::Trial, "7 with eyes closed"), (MarkKind::Participant, "P03")] {
            let mark = Mark::new(kind, text).unwrap();
            telemetry.take(&Item::Event { time: LocalTime(2_500_000_001), happened: Happened::Mark(mark) });
            listener.set_read_timeout(Some(std::time::Duration::from_secs(5))).unwrap();
            let mut room = [0; 1000];
            let length = listener.recv(&mut room).unwrap();
            let said = format!("mark 2.500000001 {} {text}", kind.word());
            assert_eq!(std::str::from_utf8(&room[..length]).unwrap(), said);
        }
        // the page says so, and a reader of rows takes it for none
        assert!(
            include_str!("../../../../docs/telemetry.md")
                .contains("`mark 2.500000001 trial 7 with eyes closed`")
        );
    }
}
