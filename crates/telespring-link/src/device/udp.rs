//! A robot behind the device protocol.

use std::io::Error;
use std::net::{SocketAddr, UdpSocket};

use telespring::session::{LocalTime, Span};

use super::protocol::{Order, State};
use super::{Command, Device, Fault, Reading};
use crate::transport::{ROOM, Transport, Udp};

/// Rows that are looked at in one tick.
const MOST_ROWS: usize = 64;

/// A robot whose program speaks the device protocol (`docs/device-protocol.md`).
#[derive(Debug)]
pub struct UdpDevice {
    link: Udp,
    deadline: Span,
    newest: Option<State>,
    heard: Option<LocalTime>,
    orders: u64,
    refused: u64,
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
        Ok(Self { link, deadline, newest: None, heard: None, orders: 0, refused: 0 })
    }

    /// Rows that were no data, repeated or overtaken.
    pub fn refused(&self) -> u64 {
        self.refused
    }

    /// Takes a row; the state if it is newer than all before. A device program that is started anew counts from the
    /// beginning, and is not believed within this session.
    fn take(&mut self, row: &[u8]) -> Option<State> {
        let newest = self.newest.map_or(f64::NEG_INFINITY, |state| state.sequence);
        let state = State::decode(row).filter(|state| state.sequence.is_finite() && state.sequence > newest);
        match state {
            Some(_) => self.newest = state,
            None => self.refused = self.refused.saturating_add(1),
        }
        state
    }
}

impl Device for UdpDevice {
    fn read(&mut self, now: LocalTime) -> Result<Reading, Fault> {
        let (mut room, mut fresh) = ([0; ROOM], false);
        let (mut sum, mut measured) = ([0.0; 2], 0_u32);
        for _ in 0..MOST_ROWS {
            let Some(length) = self.link.receive(now, &mut room) else { break };
            let Some(state) = self.take(room.get(..length).unwrap_or_default()) else { continue };
            fresh = true;
            if let Some(force) = state.measured_force {
                sum = [0, 1].map(|axis| sum[axis] + force[axis]);
                measured += 1;
            }
        }
        if fresh {
            self.heard = Some(now);
        } else if self.heard.is_some_and(|heard| now - heard > self.deadline) {
            return Err(Fault::Silent);
        }
        let state = self.newest;
        Ok(Reading {
            motion: state.filter(|_| fresh).map(|state| state.motion),
            acted: (measured > 0).then(|| sum.map(|sum| sum / f64::from(measured))),
            target: None,
            is_ready: state.is_some_and(|state| state.is_enabled && state.is_homed),
            is_stopped: state.is_some_and(|state| state.is_stopped),
        })
    }

    fn command(&mut self, now: LocalTime, command: Command) {
        self.orders += 1;
        let answers = self.newest.map_or([0.0; 2], |state| [state.sequence, state.time]);
        let Command { force, is_running } = command;
        let order = Order { sequence: self.orders as f64, answers, force, is_running };
        self.link.send(now, &order.encode());
    }
}
