//! Two sites with simulated people in virtual time: one may lie within the protocol, and its clock may step.

pub mod lies;

use std::cell::Cell;
use std::rc::Rc;

use telespring::session::wire::Packet;
use telespring::session::{LocalTime, Motion, Span, WatchdogState};
use telespring::study::Study;
use telespring_link::clock::Clock;
use telespring_link::device::Simulated;
use telespring_link::site::{Moment, Safety, Site, SiteSettings};
use telespring_link::transport::{ROOM, Transport, TransportReport};

use super::common::{End, PERIOD, VirtualClock, anywhere, wire};

/// What a liar knows and says.
pub struct Lie {
    /// Ticks since the lie began.
    pub tick: u64,
    /// The motion of the side that is lied to.
    pub victim: Motion,
    pub truth: Packet,
}

/// What a liar says instead of a packet; nothing, once or several times.
pub type Tongue = fn(&Lie) -> Vec<Packet>;

/// An end of the wire whose packets may be lies, and whose site may read another clock than the wire.
pub struct Twisted {
    end: End,
    truth: VirtualClock,
    tongue: Rc<Cell<Option<(u64, Tongue)>>>,
    victim: Rc<Cell<Motion>>,
}

impl Transport for Twisted {
    fn send(&mut self, _: LocalTime, datagram: &[u8]) {
        let now = self.truth.now();
        match (self.tongue.get(), Packet::decode(datagram)) {
            (Some((since, tongue)), Ok(truth)) => {
                let tick = (now.0 - since) / 1_000_000;
                for packet in tongue(&Lie { tick, victim: self.victim.get(), truth }) {
                    self.end.send(now, &packet.encode());
                }
            }
            _ => self.end.send(now, datagram),
        }
    }

    fn receive(&mut self, _: LocalTime, room: &mut [u8; ROOM]) -> Option<usize> {
        self.end.receive(self.truth.now(), room)
    }

    fn report(&self) -> TransportReport {
        self.end.report()
    }
}

/// A clock that differs from the true one.
struct Stepped<'a> {
    truth: &'a VirtualClock,
    offset: i64,
}

impl Clock for Stepped<'_> {
    fn now(&self) -> LocalTime {
        LocalTime(self.truth.now().0.wrapping_add_signed(self.offset))
    }
}

/// Two sites with simulated people; side 2 may lie, and its clock may step.
pub struct Dyad {
    truth: VirtualClock,
    /// By how much the clock of side 2 differs, ns.
    pub offset: i64,
    tongue: Rc<Cell<Option<(u64, Tongue)>>>,
    victim: Rc<Cell<Motion>>,
    pub sites: [Site<Simulated, Twisted>; 2],
    pub records: [Vec<Moment>; 2],
}

impl Dyad {
    pub fn new(study: &Study) -> Self {
        let laboratory = study.laboratory().unwrap();
        let delay = Span::from_seconds(study.network().unwrap().delay().forward());
        let truth = VirtualClock(Rc::new(Cell::new(100_000_000_000)), Rc::default());
        let (tongue, victim) = (Rc::default(), Rc::default());
        let mut sides = wire(delay - PERIOD).into_iter();
        let sites = [0, 1].map(|side| {
            let number = u8::try_from(side).unwrap() + 1;
            let settings = SiteSettings::new(study, number, 31 + side as u64, Safety::default()).unwrap();
            let settings = anywhere(settings);
            let link = Twisted {
                end: sides.next().unwrap(),
                truth: truth.clone(),
                tongue: if side == 1 { Rc::clone(&tongue) } else { Rc::default() },
                victim: Rc::clone(&victim),
            };
            Site::new(settings, Simulated::new(&laboratory, side, 5).unwrap(), link).unwrap()
        });
        Self { truth, offset: 0, tongue, victim, sites, records: [Vec::new(), Vec::new()] }
    }

    /// Both, engaged.
    pub fn engaged(study: &Study) -> Self {
        let mut dyad = Self::new(study);
        dyad.run(2000);
        for record in &dyad.records {
            assert_eq!(record.last().unwrap().state, WatchdogState::Engaged);
        }
        dyad
    }

    pub fn run(&mut self, milliseconds: u64) {
        for _ in 0..milliseconds {
            self.truth.0.set(self.truth.0.get() + 1_000_000);
            for side in 0..2 {
                let offset = if side == 1 { self.offset } else { 0 };
                let moment = self.sites[side].tick(&Stepped { truth: &self.truth, offset }, false);
                if side == 0
                    && let Some(motion) = moment.motion
                {
                    self.victim.set(motion);
                }
                self.records[side].push(moment);
            }
        }
    }

    pub fn lie(&mut self, tongue: Tongue) {
        self.tongue.set(Some((self.truth.now().0, tongue)));
    }

    pub fn be_honest(&mut self) {
        self.tongue.set(None);
    }
}
