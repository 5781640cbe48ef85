//! An order that somebody gives at the device, with a button or a program: a row of its own in the device protocol.

use super::protocol::{VERSION, bytes, values};
use crate::operator::{Label, Mark, MarkKind, Order};

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

#[cfg(test)]
mod tests {
    use super::*;

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
