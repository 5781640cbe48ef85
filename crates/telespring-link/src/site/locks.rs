//! Axes that are left out of the coupling: what one site locks, both do.
//!
//! A robot with one axis has no place along the other, so nothing may be asked there of the partner's handle, and no spring may
//! pull it. The endpoint, the packets, the alignment and the record have 0 along a locked axis; workspace and speed are judged by what
//! the device reports.

use telespring::session::{LocalTime, Motion};

use super::{Happened, Site};
use crate::device::{Device, Reading};
use crate::transport::Transport;

/// The values, with 0 along the axes that are locked.
pub(super) fn without(lock: [bool; 2], values: [f64; 2]) -> [f64; 2] {
    let [x, y] = values;
    let [is_x, is_y] = lock;
    [if is_x { 0.0 } else { x }, if is_y { 0.0 } else { y }]
}

impl<D: Device, T: Transport> Site<D, T> {
    /// The axes that this site and a partner lock, from the agreement on its terms to that with another one.
    pub(super) fn lock(&mut self, now: LocalTime, partner: [bool; 2]) {
        let own = self.limits.lock;
        self.lock = [0, 1].map(|axis| own[axis] || partner[axis]);
        self.gate.lock(self.limits.scale, self.lock);
        for (axis, by) in (0..).zip(own.into_iter().zip(partner)) {
            if by.0 || by.1 {
                self.log.push(now, Happened::AxisLocked { axis, by: [by.0, by.1] });
            }
        }
    }

    /// A reading without what is locked. A motion that cannot be stays as it is: it is told, and never used.
    pub(super) fn unlocked(&self, reading: Reading) -> Reading {
        let lock = self.lock;
        let only = |motion: Motion| match motion.impossible_value() {
            Some(_) => motion,
            None => {
                Motion { position: without(lock, motion.position), velocity: without(lock, motion.velocity) }
            }
        };
        Reading { motion: reading.motion.map(only), target: reading.target.map(only), ..reading }
    }
}
