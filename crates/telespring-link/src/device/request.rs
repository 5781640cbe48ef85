//! An order that somebody gives at the device, with a button or a program: a row of its own in the device protocol.

use super::protocol::{VERSION, bytes, values};
use crate::operator::{Label, Mark, MarkKind, Order};

/// Orders that wait at most.
const MOST: usize = 8;
/// Values in the row.
pub const REQUEST_VALUES: usize = 4;

/// An order from the device.
///
/// # Examples
///
/// ```
/// use telespring_link::device::request::Request;
/// use telespring_link::operator::Order;
///
/// let row = [1.0, 7.0, 1.0, 0.0]; // version, sequence number, consent, no value
/// let bytes: Vec<u8> = row.iter().flat_map(|value: &f64| value.to_le_bytes()).collect();
/// assert_eq!(Request::decode(&bytes).unwrap().order, Order::Consent);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Request {
    /// Counts the orders of the device; it rises.
    pub sequence: f64,
    /// The order.
    pub order: Order,
}

impl Request {
    /// The order in a row; `None` if it is no data: of another length or version, or with a code or a value that means
    /// nothing.
    pub fn decode(row: &[u8]) -> Option<Self> {
        let [version, sequence, code, value] = values::<REQUEST_VALUES>(row)?;
        let is_whole = |value: f64| value >= 0.0 && value <= f64::from(u32::MAX) && value.fract() == 0.0;
        if version != VERSION || !is_whole(code) || !is_whole(value) || !sequence.is_finite() {
            return None;
        }
        let mark = |kind| Some(Order::Mark(Mark { kind, label: Label::number(value as u32) }));
        let order = match code as u32 {
            1 => Some(Order::Consent),
            2 => Some(Order::Withdraw),
            3 => Some(Order::Pause),
            4 => Some(Order::Resume),
            5 => Some(Order::Stop),
            6 => Some(Order::Clear),
            11 => mark(MarkKind::Trial),
            12 => mark(MarkKind::Condition),
            13 => mark(MarkKind::Participant),
            14 => mark(MarkKind::Note),
            _ => None,
        };
        Some(Self { sequence, order: order? })
    }

    /// The row with this code and value.
    pub fn encode(sequence: f64, code: f64, value: f64) -> [u8; 8 * REQUEST_VALUES] {
        bytes([VERSION, sequence, code, value])
    }
}

/// Orders of a device that wait for the loop.
#[derive(Debug)]
pub(super) struct Requests {
    /// The number of the newest one.
    newest: f64,
    /// Oldest first.
    waiting: [Option<Order>; MOST],
}

impl Default for Requests {
    fn default() -> Self {
        Self { newest: f64::NEG_INFINITY, waiting: [None; MOST] }
    }
}

impl Requests {
    /// Takes an order, if it is newer than all before and there is room. One that lets go takes the place of one that does not.
    /// False if an order is lost by that.
    pub(super) fn take(&mut self, Request { sequence, order }: Request) -> bool {
        if sequence <= self.newest {
            return false;
        }
        let may_yield = |waiting: &Order| order.lets_go() && !waiting.lets_go();
        let free = self.waiting.iter().position(Option::is_none);
        let place =
            free.or_else(|| self.waiting.iter().rposition(|waiting| waiting.as_ref().is_some_and(may_yield)));
        if let Some(place) = place.and_then(|place| self.waiting.get_mut(place)) {
            (self.newest, *place) = (sequence, Some(order));
        }
        free.is_some()
    }

    /// The oldest order that nobody has asked for yet.
    pub(super) fn poll(&mut self) -> Option<Order> {
        let oldest = self.waiting.first_mut().and_then(Option::take);
        self.waiting.rotate_left(usize::from(oldest.is_some()));
        oldest
    }

    /// The device program was started anew: it counts its orders from the beginning.
    pub(super) fn begin_anew(&mut self) {
        self.newest = f64::NEG_INFINITY;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_orders_wait_for_the_loop_and_one_that_lets_go_finds_a_place_among_many() {
        let mut requests = Requests::default();
        let mut take = |sequence: u32, order| requests.take(Request { sequence: sequence.into(), order });
        let mark = Order::Mark(Mark { kind: MarkKind::Trial, label: Label::number(7) });
        let taken: Vec<u32> = (1..20).filter(|sequence| take(*sequence, mark)).collect();
        assert_eq!(taken, (1..=8).collect::<Vec<u32>>());
        // in the place of the newest one that holds nobody
        assert!(!take(20, Order::Withdraw) && !take(21, Order::Consent) && !take(20, Order::Stop));
        let mut orders: Vec<_> = std::iter::from_fn(|| requests.poll()).collect();
        assert_eq!((orders.len(), orders.pop()), (MOST, Some(Order::Withdraw)));
        assert!(orders.iter().all(|order| *order == mark));
        // one that found no place may come again, one that did may not
        let mut take = |sequence: u32, order| requests.take(Request { sequence: sequence.into(), order });
        assert!(!take(20, Order::Withdraw) && take(21, Order::Consent));
        requests.begin_anew();
        assert!(requests.take(Request { sequence: 0.0, order: Order::Clear }));
        assert_eq!([requests.poll(), requests.poll()], [Some(Order::Consent), Some(Order::Clear)]);
    }

    #[test]
    fn law_an_order_of_a_device_is_read_and_everything_else_is_no_data() {
        let order =
            |code, value| Request::decode(&Request::encode(3.0, code, value)).map(|request| request.order);
        let orders =
            [Order::Consent, Order::Withdraw, Order::Pause, Order::Resume, Order::Stop, Order::Clear];
        for (code, wanted) in (1..).zip(orders) {
            assert_eq!(order(f64::from(code), 0.0), Some(wanted));
        }
        for (code, kind) in (11..).zip(MarkKind::ALL) {
            let Some(Order::Mark(mark)) = order(f64::from(code), 42.0) else { panic!("{code}") };
            assert_eq!((mark.kind, mark.label.text()), (kind, "42"));
        }
        for (code, value) in [
            (0.0, 0.0),
            (7.0, 0.0),
            (1.5, 0.0),
            (-1.0, 0.0),
            (f64::NAN, 0.0),
            (11.0, 0.5),
            (11.0, 1e10),
            (11.0, f64::NAN),
        ] {
            assert_eq!(order(code, value), None, "{code} {value}");
        }
        assert_eq!(Request::decode(&[0; 32]), None);
        assert_eq!(Request::decode(&[0; 31]), None);
    }
}
