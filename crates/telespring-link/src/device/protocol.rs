//! The device protocol: what a program beside this one exchanges with it so that any controller can be the robot.
//!
//! Every datagram is a row of little-endian doubles (IEEE 754, 8 bytes each), without padding. A row whose first value is
//! not the version is no data: a row of zeros says nothing. `docs/device-protocol.md` has it with examples.

use telespring::session::Motion;

/// The version, the first value of every row.
pub const VERSION: f64 = 1.0;
/// Values in a row from the device.
pub const STATE_VALUES: usize = 13;
/// Values in a row to the device.
pub const COMMAND_VALUES: usize = 8;

/// What a device sends.
///
/// # Examples
///
/// ```
/// use telespring_link::device::protocol::State;
///
/// let mut row = [0.0; 13];
/// assert_eq!(State::decode(&[0; 104]), None); // no data
/// row[0] = 1.0; // version
/// row[1] = 7.0; // sequence number
/// row[3] = 0.02; // x, m
/// row[10] = 1.0; // enabled
/// row[11] = 1.0; // homed
/// let bytes: Vec<u8> = row.iter().flat_map(|value: &f64| value.to_le_bytes()).collect();
/// let state = State::decode(&bytes).unwrap();
/// assert_eq!(state.motion.position, [0.02, 0.0]);
/// assert_eq!(state.encode().as_slice(), bytes);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State {
    /// Counts the rows of the device; it rises.
    pub sequence: f64,
    /// The device's own time of the measurement, s; sent back with the command that follows.
    pub time: f64,
    /// Position and velocity, m and m/s.
    pub motion: Motion,
    /// The force on the handle, N, if the device measures it.
    pub measured_force: Option<[f64; 2]>,
    /// Whether the motors may act.
    pub is_enabled: bool,
    /// Whether the positions are those of the study's axes.
    pub is_homed: bool,
    /// Whether the emergency stop is pressed.
    pub is_stopped: bool,
}

/// The values of a row; `None` if it has another length.
pub(super) fn values<const N: usize>(bytes: &[u8]) -> Option<[f64; N]> {
    if bytes.len() != 8 * N {
        return None;
    }
    let mut row = [0.0; N];
    for (value, bytes) in row.iter_mut().zip(bytes.chunks_exact(8)) {
        *value = f64::from_le_bytes(bytes.try_into().ok()?);
    }
    Some(row)
}

/// A row as bytes.
pub(super) fn bytes<const N: usize, const BYTES: usize>(row: [f64; N]) -> [u8; BYTES] {
    let mut bytes = [0; BYTES];
    for (place, value) in bytes.chunks_exact_mut(8).zip(row) {
        place.copy_from_slice(&value.to_le_bytes());
    }
    bytes
}

/// A flag, which is 0 or 1.
fn flag(value: f64) -> Option<bool> {
    if value == 0.0 {
        Some(false)
    } else if value == 1.0 {
        Some(true)
    } else {
        None
    }
}

impl State {
    /// The state in a row; `None` if it is no data: of another length or version, or with a flag that is neither 0 nor 1.
    /// Motions that no robot has are for the endpoint to refuse.
    pub fn decode(row: &[u8]) -> Option<Self> {
        let [version, sequence, time, x, y, u, v, force_x, force_y, has_force, enabled, homed, stopped] =
            values::<STATE_VALUES>(row)?;
        if version != VERSION {
            return None;
        }
        Some(Self {
            sequence,
            time,
            motion: Motion { position: [x, y], velocity: [u, v] },
            measured_force: flag(has_force)?.then_some([force_x, force_y]),
            is_enabled: flag(enabled)?,
            is_homed: flag(homed)?,
            is_stopped: flag(stopped)?,
        })
    }

    /// The state as a row.
    pub fn encode(&self) -> [u8; 8 * STATE_VALUES] {
        let ([x, y], [u, v]) = (self.motion.position, self.motion.velocity);
        let [force_x, force_y] = self.measured_force.unwrap_or_default();
        let flag = |is: bool| f64::from(u8::from(is));
        let flags =
            [self.measured_force.is_some(), self.is_enabled, self.is_homed, self.is_stopped].map(flag);
        let [has_force, enabled, homed, stopped] = flags;
        bytes([
            VERSION,
            self.sequence,
            self.time,
            x,
            y,
            u,
            v,
            force_x,
            force_y,
            has_force,
            enabled,
            homed,
            stopped,
        ])
    }
}

/// What a device is sent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Order {
    /// Counts the commands; it rises.
    pub sequence: f64,
    /// Sequence number and time of the newest state that the command answers; 0 before the first.
    pub answers: [f64; 2],
    /// The force on the handle, N, to hold until the next command or the device's deadline.
    pub force: [f64; 2],
    /// Whether the two sides are coupled.
    pub is_running: bool,
    /// Whether the session is over, so that the device program may end.
    pub is_over: bool,
}

impl Order {
    /// The command as a row.
    pub fn encode(&self) -> [u8; 8 * COMMAND_VALUES] {
        let ([sequence, time], [x, y]) = (self.answers, self.force);
        let [running, over] = [self.is_running, self.is_over].map(|flag| f64::from(u8::from(flag)));
        bytes([VERSION, self.sequence, sequence, time, x, y, running, over])
    }

    /// The command in a row; `None` if it is none.
    pub fn decode(row: &[u8]) -> Option<Self> {
        let [version, sequence, state, time, x, y, running, over] = values::<COMMAND_VALUES>(row)?;
        (version == VERSION).then_some(())?;
        let (is_running, is_over) = (flag(running)?, flag(over)?);
        Some(Self { sequence, answers: [state, time], force: [x, y], is_running, is_over })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_rows_survive_encoding() {
        let state = State {
            sequence: 3.0,
            time: 0.25,
            motion: Motion { position: [0.1, -0.2], velocity: [1.5, -2.5] },
            measured_force: Some([4.0, -5.0]),
            is_enabled: true,
            is_homed: false,
            is_stopped: true,
        };
        assert_eq!(State::decode(&state.encode()), Some(state));
        for is_over in [false, true] {
            let (answers, force, is_running) = ([3.0, 0.25], [1.0, -1.0], !is_over);
            let order = Order { sequence: 9.0, answers, force, is_running, is_over };
            assert_eq!(Order::decode(&order.encode()), Some(order));
        }
    }

    #[test]
    fn law_what_is_no_data_is_refused() {
        let state = State {
            sequence: 1.0,
            time: 0.0,
            motion: Motion::default(),
            measured_force: None,
            is_enabled: true,
            is_homed: true,
            is_stopped: false,
        };
        let good = state.encode();
        assert!(State::decode(&good).is_some());
        assert_eq!(State::decode(&good[..96]), None);
        assert_eq!(State::decode(&[0; 104]), None);
        for (at, value) in [(0, 2.0), (9, 0.5), (10, f64::NAN), (11, -1.0), (12, 2.0)] {
            let mut row = good;
            row[8 * at..8 * at + 8].copy_from_slice(&f64::to_le_bytes(value));
            assert_eq!(State::decode(&row), None, "{at}");
        }
    }
}
