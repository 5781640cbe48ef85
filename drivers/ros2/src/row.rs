//! A row of the telemetry stream.

use std::sync::LazyLock;

/// The version, the first value of every row.
pub const VERSION: f64 = 1.0;
/// Values in a row.
pub const VALUES: usize = 40;
/// Bytes in a row.
pub const LENGTH: usize = 8 * VALUES;

/// The page that defines the rows. A test of telespring-link holds the two together.
const PAGE: &str = include_str!("../../../docs/telemetry.md");

/// What a place holds, in their order; the rest is not used.
pub static COLUMNS: LazyLock<Vec<&'static str>> =
    LazyLock::new(|| (0..VALUES).map_while(|place| Some(cells(place)?.0)).collect());
/// The codes and words of place 4.
static PHASES: LazyLock<Words> = LazyLock::new(|| words(4));
/// The codes and words of place 5.
static WATCHDOGS: LazyLock<Words> = LazyLock::new(|| words(5));

type Words = Vec<(f64, &'static str)>;

/// What the page says of a place: its content, and its values.
fn cells(place: usize) -> Option<(&'static str, &'static str)> {
    PAGE.lines().find_map(|line| {
        let mut cells = line.split('|').map(str::trim).skip(1);
        let is_it = cells.next()?.parse() == Ok(place);
        let (content, _, values) = (cells.next()?, cells.next()?, cells.next()?);
        is_it.then_some((content, values))
    })
}

/// "0 greeting, 1 running" as codes and words.
fn words(place: usize) -> Words {
    let values = cells(place).map_or("", |(_, values)| values);
    let pairs = values.split(", ").filter_map(|value| value.split_once(' '));
    pairs.filter_map(|(code, word)| Some((code.parse().ok()?, word))).collect()
}

/// The first of two places, x and y.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(usize)]
pub enum Pair {
    /// The position of the own handle, m.
    Handle = 7,
    /// That of the partner's handle as used for the force, m.
    Partner = 11,
    /// That of the target, m.
    Target = 15,
    /// The force commanded, N.
    Force = 19,
    /// The force measured, N.
    MeasuredForce = 21,
}

/// The values of a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row(pub [f64; VALUES]);

impl Row {
    /// The row in a datagram; `None` if it is none of this version, or does not say when and whose it is.
    pub fn decode(datagram: &[u8]) -> Option<Self> {
        if datagram.len() != LENGTH {
            return None;
        }
        let mut values = [0.0; VALUES];
        for (value, bytes) in values.iter_mut().zip(datagram.chunks_exact(8)) {
            *value = f64::from_le_bytes(bytes.try_into().ok()?);
        }
        let row = Self(values);
        let [version, _, _, time, ..] = values;
        (version == VERSION && row.side().is_some() && (0.0..1e9).contains(&time)).then_some(row)
    }

    /// The robot of the study, 1 or 2.
    pub fn side(&self) -> Option<u8> {
        [1, 2].into_iter().find(|side| self.0[2] == f64::from(*side))
    }

    /// When the tick was, s, by the monotonic clock of the machine.
    pub fn time(&self) -> f64 {
        self.0[3]
    }

    /// Two values; `None` if they are not known.
    pub fn pair(&self, pair: Pair) -> Option<[f64; 2]> {
        let first = pair as usize;
        let values = [self.0[first], self.0[first + 1]];
        values.iter().all(|value| value.is_finite()).then_some(values)
    }

    /// The states of session and watchdog in words.
    pub fn status(&self) -> String {
        let phase = word(&PHASES, self.0[4]).unwrap_or_else(|| "unknown".into());
        match word(&WATCHDOGS, self.0[5]) {
            Some(watchdog) => format!("{phase}, {watchdog}"),
            None => phase,
        }
    }
}

/// The word of a code, the code itself for one of a newer program; `None` if it is not known.
fn word(words: &Words, code: f64) -> Option<String> {
    if code.is_nan() {
        return None;
    }
    let named = words.iter().find(|(known, _)| *known == code);
    Some(named.map_or_else(|| code.to_string(), |(_, word)| (*word).to_owned()))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A row with some of its places.
    pub(crate) fn row(places: &[(usize, f64)]) -> Row {
        let mut values = [f64::NAN; VALUES];
        for (place, value) in [(0, 1.0), (1, 1.0), (2, 2.0), (3, 10.5)].iter().chain(places) {
            values[*place] = *value;
        }
        Row(values)
    }

    fn bytes(row: &Row) -> Vec<u8> {
        row.0.iter().flat_map(|value| value.to_le_bytes()).collect()
    }

    #[test]
    fn law_the_places_are_those_of_the_page() {
        assert_eq!(COLUMNS.len(), 38);
        assert_eq!([COLUMNS[0], COLUMNS[1], COLUMNS[2], COLUMNS[3]], ["version", "sequence", "side", "time"]);
        assert_eq!([COLUMNS[4], COLUMNS[5], COLUMNS[37]], ["phase", "watchdog", "marker"]);
        assert!(PHASES.len() > 1 && PHASES.iter().any(|(_, word)| *word == "running"));
        assert_eq!(WATCHDOGS[1..3], [(1.0, "ramping-in"), (2.0, "engaged")]);
        for (pair, name) in [
            (Pair::Handle, "position"),
            (Pair::Partner, "partner position"),
            (Pair::Target, "target position"),
            (Pair::Force, "force"),
            (Pair::MeasuredForce, "measured force"),
        ] {
            assert_eq!(COLUMNS[pair as usize], format!("{name} x"));
            assert_eq!(COLUMNS[pair as usize + 1], format!("{name} y"));
        }
        assert!(
            PAGE.contains(&format!(
                "{VALUES} little-endian doubles (IEEE 754), 8 bytes each, {LENGTH} bytes"
            ))
        );
    }

    #[test]
    fn law_what_is_no_row_is_refused() {
        let good = row(&[(7, 0.25), (8, -0.5)]);
        let read = Row::decode(&bytes(&good)).unwrap();
        assert_eq!((read.side(), read.time(), read.pair(Pair::Handle)), (Some(2), 10.5, Some([0.25, -0.5])));
        assert_eq!(read.pair(Pair::Force), None);
        assert_eq!(Row::decode(&bytes(&good)[..LENGTH - 8]), None);
        assert_eq!(Row::decode(&[0; LENGTH]), None);
        for (place, value) in [(0, 2.0), (2, 0.0), (2, 1.5), (3, f64::NAN), (3, -1.0), (3, f64::INFINITY)] {
            assert_eq!(Row::decode(&bytes(&row(&[(place, value)]))), None, "{place} {value}");
        }
    }

    #[test]
    fn law_the_status_is_in_words() {
        let (running, _) = PHASES.iter().find(|(_, word)| *word == "running").unwrap();
        assert_eq!(row(&[(4, *running)]).status(), "running");
        assert_eq!(row(&[(4, *running), (5, 3.0)]).status(), "running, holding");
        assert_eq!(row(&[(4, 99.0), (5, 0.5)]).status(), "99, 0.5");
        assert_eq!(row(&[]).status(), "unknown");
    }
}
