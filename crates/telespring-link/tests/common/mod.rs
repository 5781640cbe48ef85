//! Two sites in virtual time, for several tests.

#![allow(dead_code, reason = "every test uses its part")]

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use telespring::rig::{Channel, NetworkModel};
use telespring::session::wire::LENGTH;
use telespring::session::{LocalTime, Motion, Span};
use telespring::study::Study;
use telespring_link::clock::Clock;
use telespring_link::demo::ROBOTS;
use telespring_link::device::{Command, Device, Fault, Reading};
use telespring_link::hello::MAGIC;
use telespring_link::operator::Order;
use telespring_link::site::{
    Consent, Fallback, Happened, Limits, Moment, Phase, Rules, Safety, Site, SiteSettings,
};
use telespring_link::transport::{ROOM, Transport, TransportReport};

pub const PERIOD: Span = Span(1_000_000);

/// The paper's two robots with these further lines of a study.
pub fn hman_study(lines: &str) -> Study {
    Study::from_toml(&format!("{ROBOTS}{lines}")).unwrap()
}

/// A clock that stands still until it is set, and for how long the machine has been suspended.
#[derive(Debug, Clone, Default)]
pub struct VirtualClock(pub Rc<Cell<u64>>, pub Rc<Cell<i64>>);

impl Clock for VirtualClock {
    fn now(&self) -> LocalTime {
        LocalTime(self.0.get())
    }

    fn suspended(&self) -> Span {
        Span(self.1.get())
    }
}

/// Both ways of a network in virtual time, and whether each is cut.
#[derive(Debug)]
pub struct Wire {
    pub towards: [Box<dyn Channel>; 2],
    /// The way of greetings: never within the tick, so that both sides hear alike, whichever ticks first.
    greetings: [Box<dyn Channel>; 2],
    pub is_cut: [bool; 2],
    /// Of how many packets each side sends one, and the turn.
    pub every: [u64; 2],
    turn: [u64; 2],
    /// Datagrams of any length and content that arrive beside the partner's.
    pub injected: [Vec<Vec<u8>>; 2],
    /// The latest datagram towards each side.
    pub latest: [Option<[u8; LENGTH]>; 2],
}

/// One end of the wire.
#[derive(Debug, Clone)]
pub struct End {
    pub side: usize,
    pub wire: Rc<RefCell<Wire>>,
}

/// Both ends of an ideal wire with this delay.
pub fn wire(travel: Span) -> [End; 2] {
    let towards = [0, 1].map(|side| NetworkModel::ideal().channel(travel, 1, side));
    let greetings = [0, 1].map(|side| NetworkModel::ideal().channel(travel.max(PERIOD), 1, side));
    let injected = [Vec::new(), Vec::new()];
    let wire = Wire {
        towards,
        greetings,
        is_cut: [false; 2],
        every: [1; 2],
        turn: [0; 2],
        injected,
        latest: [None; 2],
    };
    let wire = Rc::new(RefCell::new(wire));
    [0, 1].map(|side| End { side, wire: Rc::clone(&wire) })
}

impl Transport for End {
    fn is_due(&mut self) -> bool {
        let mut wire = self.wire.borrow_mut();
        wire.turn[self.side] += 1;
        wire.turn[self.side].is_multiple_of(wire.every[self.side])
    }

    fn send(&mut self, now: LocalTime, datagram: &[u8]) {
        let (mut wire, there) = (self.wire.borrow_mut(), 1 - self.side);
        let datagram: [u8; LENGTH] = datagram.try_into().unwrap();
        wire.latest[there] = Some(datagram);
        if !wire.is_cut[there] {
            let is_greeting = datagram.starts_with(&MAGIC);
            let ways = if is_greeting { &mut wire.greetings } else { &mut wire.towards };
            ways[there].send(now, datagram);
        }
    }

    fn receive(&mut self, now: LocalTime, room: &mut [u8; ROOM]) -> Option<usize> {
        let mut wire = self.wire.borrow_mut();
        if let Some(datagram) = wire.injected[self.side].pop() {
            let length = datagram.len().min(ROOM);
            room[..length].copy_from_slice(&datagram[..length]);
            return Some(length);
        }
        let greeting = wire.greetings[self.side].deliver(now);
        let datagram = greeting.or_else(|| wire.towards[self.side].deliver(now))?;
        room[..LENGTH].copy_from_slice(&datagram);
        Some(LENGTH)
    }

    fn report(&self) -> TransportReport {
        TransportReport::default()
    }
}

/// What a scripted device does, set from outside.
#[derive(Debug, Clone, Copy)]
pub struct Script {
    pub position: [f64; 2],
    pub velocity: [f64; 2],
    pub is_measured: bool,
    /// The force that the device says has acted, N.
    pub acted: Option<[f64; 2]>,
    pub is_ready: bool,
    pub is_stopped: bool,
    /// An order given at the device.
    pub order: Option<Order>,
    pub fault: Option<Fault>,
    /// The latest command.
    pub command: Command,
}

impl Default for Script {
    fn default() -> Self {
        Self {
            position: [0.0; 2],
            velocity: [0.0; 2],
            is_measured: true,
            acted: None,
            is_ready: true,
            is_stopped: false,
            order: None,
            fault: None,
            command: Command::default(),
        }
    }
}

/// A handle that stays where a test puts it.
#[derive(Debug, Clone, Default)]
pub struct Scripted(pub Rc<Cell<Script>>);

impl Scripted {
    pub fn change(&self, change: impl FnOnce(&mut Script)) {
        let mut script = self.0.get();
        change(&mut script);
        self.0.set(script);
    }
}

impl Device for Scripted {
    fn read(&mut self, _: LocalTime) -> Result<Reading, Fault> {
        let script = self.0.get();
        if let Some(fault) = script.fault {
            return Err(fault);
        }
        let Script { position, velocity, is_measured, acted, is_ready, is_stopped, .. } = script;
        let motion = is_measured.then_some(Motion { position, velocity });
        Ok(Reading { motion, stamp: None, acted, target: None, is_ready, is_stopped })
    }

    fn command(&mut self, _: LocalTime, command: Command) {
        self.change(|script| script.command = command);
    }

    fn poll_order(&mut self) -> Option<Order> {
        let order = self.0.get().order;
        self.change(|script| script.order = None);
        order
    }
}

/// Changes what a site is made of.
type Adjust = Rc<dyn Fn(SiteSettings) -> SiteSettings>;

/// Simulated people that are coupled wherever their handles are, and however bad the network is: for tests of the endpoint.
pub fn anywhere(settings: SiteSettings) -> SiteSettings {
    let long = Span(600_000_000_000);
    let fallback = Fallback { softened: 1.0, patience: long, silence: long, ..Fallback::default() };
    let rules =
        Rules { consent: Consent::Automatic, alignment: 10.0, rest: 10.0, fallback, ..settings.rules };
    SiteSettings { rules, limits: Limits { velocity: 100.0, ..settings.limits }, ..settings }
}

/// Two sites with scripted devices, 2 cm apart, in virtual time. People consent without an order unless a test says
/// otherwise.
pub struct Pair {
    /// What each site is made of, on top of its study.
    adjust: Adjust,
    pub clock: VirtualClock,
    pub ends: [End; 2],
    pub devices: [Scripted; 2],
    pub sites: [Option<Site<Scripted, End>>; 2],
    pub stop: [bool; 2],
    pub moments: [Option<Moment>; 2],
}

impl Pair {
    /// Both sites of these studies.
    pub fn new(studies: [&Study; 2], delay: f64) -> Self {
        Self::with(studies, delay, SiteSettings::simulated)
    }

    /// Both sites of a study, with at most this force, N, coupled wherever the handles are.
    pub fn limited(study: &Study, delay: f64, force: f64) -> Self {
        Self::with([study, study], delay, move |settings| {
            let settings = anywhere(settings);
            SiteSettings { limits: Limits { force, ..settings.limits }, ..settings }
        })
    }

    /// As [`Pair::new`], of other settings.
    pub fn with(
        studies: [&Study; 2],
        delay: f64,
        adjust: impl Fn(SiteSettings) -> SiteSettings + 'static,
    ) -> Self {
        let adjust: Adjust = Rc::new(adjust);
        let ends = wire(Span::from_seconds(delay) - PERIOD);
        let devices = [Scripted::default(), Scripted::default()];
        devices[1].change(|script| script.position = [0.02, 0.0]);
        let sites = [0, 1]
            .map(|side| Some(Self::site(studies[side], side, 11 + side as u64, &adjust, &devices, &ends)));
        let clock = VirtualClock(Rc::new(Cell::new(5_000_000_000)), Rc::default());
        Self { adjust, clock, ends, devices, sites, stop: [false; 2], moments: [None; 2] }
    }

    fn site(
        study: &Study,
        side: usize,
        session: u64,
        adjust: &Adjust,
        devices: &[Scripted; 2],
        ends: &[End; 2],
    ) -> Site<Scripted, End> {
        let number = u8::try_from(side).unwrap() + 1;
        let settings = SiteSettings::new(study, number, session, Safety::default()).unwrap();
        Site::new(adjust(settings), devices[side].clone(), ends[side].clone()).unwrap()
    }

    /// Starts the program of a side anew.
    pub fn restart(&mut self, study: &Study, side: usize, session: u64) {
        self.sites[side] = Some(Self::site(study, side, session, &self.adjust, &self.devices, &self.ends));
    }

    /// One tick of both.
    pub fn tick(&mut self) {
        self.clock.0.set(self.clock.0.get() + 1_000_000);
        for side in 0..2 {
            if let Some(site) = &mut self.sites[side] {
                self.moments[side] = Some(site.tick(&self.clock, self.stop[side]));
            }
        }
    }

    /// Ticks for this many milliseconds; `watch` sees both forces after each.
    pub fn run(&mut self, milliseconds: usize, mut watch: impl FnMut(&Self, [[f64; 2]; 2])) {
        for _ in 0..milliseconds {
            self.tick();
            watch(self, self.forces());
        }
    }

    /// The forces that both devices were told last, N.
    pub fn forces(&self) -> [[f64; 2]; 2] {
        [0, 1].map(|side| self.devices[side].0.get().command.force)
    }

    pub fn moment(&self, side: usize) -> Moment {
        self.moments[side].unwrap()
    }

    pub fn site_of(&self, side: usize) -> &Site<Scripted, End> {
        self.sites[side].as_ref().unwrap()
    }

    /// Gives an order at a side, which takes it at its next tick.
    pub fn order(&self, side: usize, order: Order) {
        self.devices[side].change(|script| script.order = Some(order));
    }

    /// Whether something has happened at a side.
    pub fn happened(&self, side: usize, wanted: &Happened) -> bool {
        self.site_of(side).log().entries().iter().any(|(_, happened)| happened == wanted)
    }

    pub fn phases(&self) -> [Phase; 2] {
        [0, 1].map(|side| self.site_of(side).phase())
    }
}
