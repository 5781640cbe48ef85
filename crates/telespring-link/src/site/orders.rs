//! What the people at this site order.

use telespring::session::LocalTime;

use super::{Cause, Consent, Happened, Interruption, Phase, Site};
use crate::device::Device;
use crate::operator::Order;
use crate::transport::Transport;

/// Orders that are taken in one tick; the rest waits.
const MOST_ORDERS: usize = 4;

impl<D: Device, T: Transport> Site<D, T> {
    /// Takes the orders that have come, from console and device by turns: neither keeps the other from being heard.
    pub(super) fn take_orders(&mut self, now: LocalTime) {
        for turn in 0..MOST_ORDERS {
            let device = if turn % 2 == 0 { self.device.poll_order() } else { None };
            let console = || self.orders.as_mut().and_then(|orders| orders.pop().ok());
            let order = device.or_else(console).or_else(|| self.device.poll_order());
            let Some(order) = order else { return };
            if !self.take_order(now, order) {
                self.log.push(now, Happened::OrderRefused { order, phase: self.phase });
            }
        }
    }

    /// Does what was ordered; false if that is not possible now.
    fn take_order(&mut self, now: LocalTime, order: Order) -> bool {
        if self.left.is_some() {
            return false;
        }
        match order {
            Order::Consent => {
                let is_asked = self.phase == Phase::Consenting && !self.accord.own.has_consented;
                if is_asked {
                    self.accord.own.has_consented = true;
                    self.greeter.hurry();
                }
                is_asked
            }
            Order::Withdraw => {
                // whoever withdraws once is asked from then on
                let was_given = self.rules.consent == Consent::Automatic || self.accord.own.has_consented;
                self.rules.consent = Consent::Ordered;
                self.interrupt(now, Interruption::ConsentWithdrawn);
                was_given
            }
            Order::Pause => {
                let is_news = !std::mem::replace(&mut self.accord.own.is_paused, true);
                self.interrupt(now, Interruption::PauseOrdered);
                is_news
            }
            Order::Resume => {
                let was_paused = std::mem::replace(&mut self.accord.own.is_paused, false);
                if was_paused {
                    self.greeter.hurry();
                    self.log.push(now, Happened::Resumed);
                }
                was_paused
            }
            Order::Stop => {
                self.leave(now, Cause::StopRequested);
                true
            }
            Order::Clear => self.clear(now),
            Order::Mark(mark) => {
                self.log.push(now, Happened::Mark(mark));
                true
            }
            Order::Unknown(_) => false,
        }
    }

    /// Leaves a latched emergency stop; false if there is none, or the button is still pressed.
    fn clear(&mut self, now: LocalTime) -> bool {
        if !self.accord.own.is_stopped || self.is_pressed {
            return false;
        }
        self.accord.own.is_stopped = false;
        self.greeter.hurry();
        self.log.push(now, Happened::Cleared);
        true
    }
}
