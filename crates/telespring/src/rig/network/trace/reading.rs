//! Reads a trace of a network from text: tables with a header, and IRTT's JSON.

use serde::Deserialize;

use super::ping::is_ping_log;
use super::{Trace, TraceRow};
use crate::error::{InvalidInput, Result};

/// The unit of times in a trace.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TimeUnit {
    /// s.
    Seconds,
    /// ms.
    Milliseconds,
    /// µs.
    Microseconds,
    /// ns.
    Nanoseconds,
}

impl TimeUnit {
    /// How many of the unit are a second: dividing by it gives the number as written in s.
    pub fn per_second(self) -> f64 {
        match self {
            Self::Seconds => 1.0,
            Self::Milliseconds => 1e3,
            Self::Microseconds => 1e6,
            Self::Nanoseconds => 1e9,
        }
    }

    /// The unit of a column of a trace by its sign.
    fn of_sign(sign: &str) -> Option<Self> {
        Some(match sign {
            "s" | "sec" | "seconds" => Self::Seconds,
            "ms" => Self::Milliseconds,
            "us" | "µs" | "μs" => Self::Microseconds,
            "ns" => Self::Nanoseconds,
            _ => return None,
        })
    }
}

/// The units of a trace's table whose header does not state them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TraceUnits {
    /// Of the times of sending.
    pub time: Option<TimeUnit>,
    /// Of the delays.
    pub delay: Option<TimeUnit>,
}

/// Which delay of an IRTT measurement is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum IrttDelay {
    /// The round trip, which needs no common clock.
    RoundTrip,
    /// From client to server; right only if both clocks agree.
    Send,
    /// From server to client; right only if both clocks agree.
    Receive,
}

/// What a text with a trace of a network is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TraceFormat {
    /// A table with a header.
    Table,
    /// The JSON of `irtt client -o`.
    Irtt,
    /// The log of `ping -D`.
    Ping,
}

impl TraceFormat {
    /// The format in which a text has a trace of a network; a table if it is none of the others.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::rig::trace::TraceFormat;
    /// assert_eq!(TraceFormat::of("time_s,delay_ms\n0,20\n"), TraceFormat::Table);
    /// assert_eq!(TraceFormat::of("PING host (10.0.0.2) 56(84) bytes of data.\n"), TraceFormat::Ping);
    /// ```
    pub fn of(text: &str) -> Self {
        if text.trim_start_matches('\u{feff}').trim_start().starts_with('{') {
            Self::Irtt
        } else if is_ping_log(text) {
            Self::Ping
        } else {
            Self::Table
        }
    }
}

const TIMES: [&str; 7] = ["time", "t", "sent", "send_time", "send", "pub_time", "timestamp"];
const DELAYS: [&str; 4] = ["delay", "latency", "owd", "rtt"];
const LOSSES: [&str; 2] = ["lost", "loss"];

/// A column of a trace's table.
struct Column {
    index: usize,
    unit: Option<TimeUnit>,
}

/// The name in a header of a trace without its unit, and the unit: `delay(ms)`, `delay [ms]`, `delay_ms`.
fn split_unit(header: &str) -> (String, Option<TimeUnit>) {
    let header = header.trim().trim_matches('"').to_lowercase();
    if let Some(at) = header.find(['(', '[']) {
        let sign = header[at..].trim_matches(['(', ')', '[', ']', ' ']);
        return (header[..at].trim().to_owned(), TimeUnit::of_sign(sign));
    }
    if let Some((name, sign)) = header.rsplit_once('_')
        && let Some(unit) = TimeUnit::of_sign(sign)
    {
        return (name.to_owned(), Some(unit));
    }
    (header, None)
}

/// The column of a trace's table with one of these names.
fn find_column(header: &[&str], names: &[&str]) -> Option<Column> {
    // In the order of the names: "time" is preferred to "timestamp".
    names.iter().find_map(|wanted| {
        let named = |text: &&str| split_unit(text).0 == *wanted;
        let index = header.iter().position(named)?;
        Some(Column { index, unit: split_unit(header[index]).1 })
    })
}

/// The names of a table's columns, and the sign that separates them; blanks if there is none.
fn split_header(text: &str) -> (Vec<&str>, Option<char>) {
    let header = content_lines(text).next().map_or("", |(_, line)| line);
    let separator = [',', ';', '\t'].into_iter().find(|sign| header.contains(*sign));
    let names = match separator {
        Some(sign) => header.split(sign).map(str::trim).collect(),
        None => header.split_whitespace().collect(),
    };
    (names, separator)
}

/// The lines of a trace's table that are neither empty nor comments, with their numbers from 0.
fn content_lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let lines = text.trim_start_matches('\u{feff}').lines().enumerate();
    lines.filter(|(_, line)| !line.trim().is_empty() && !line.trim_start().starts_with('#'))
}

/// Whether a trace's table says by the name of its column that its delays are round trips: `rtt`.
pub(crate) fn names_round_trips(text: &str) -> bool {
    let (names, _) = split_header(text);
    find_column(&names, &DELAYS).is_some_and(|column| split_unit(names[column.index]).0 == "rtt")
}

impl Trace {
    /// Reads a trace of a network from a table with a header: columns `time` (of sending), `delay` and, if packets were
    /// lost, `lost` (0 or 1, true or false), in any order and with others between.
    ///
    /// Commas, semicolons, tabs or blanks separate the columns. The unit stands in the header, as `time_s` or
    /// `delay(ms)`, or in `units`. A lost packet may have no delay; a packet without delay is lost. Other names are
    /// known, too: `sent`, `pub_time`, `timestamp`; `latency`, `owd`, `rtt`. A round trip is not halved: see
    /// [`Trace::halved`].
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if a column or a unit is missing, a value is no number, or as [`Trace::new`].
    pub fn from_csv(text: &str, units: TraceUnits) -> Result<Self> {
        let (names, separator) = split_header(text);
        let header = content_lines(text).next().map_or("", |(_, line)| line);
        let split = |line: &'_ str| -> Vec<String> {
            match separator {
                Some(sign) => line.split(sign).map(|cell| cell.trim().to_owned()).collect(),
                None => line.split_whitespace().map(str::to_owned).collect(),
            }
        };
        let column = |kind: &str, known: &[&str]| {
            find_column(&names, known).ok_or_else(|| {
                InvalidInput::new(
                    format!("trace, column {kind}"),
                    format!("{:?}", header.chars().take(60).collect::<String>()),
                    "the first line names the columns time, delay and, if packets were lost, lost",
                    if names.iter().all(|name| name.parse::<f64>().is_ok()) {
                        "Put a line before it that names the columns, such as time_s,delay_ms.".to_owned()
                    } else {
                        format!(
                            "Name one of them {}, with its unit: {kind}_s or {kind}_ms.",
                            known.join(" or ")
                        )
                    },
                )
            })
        };
        let (time, delay) = (column("time", &TIMES)?, column("delay", &DELAYS)?);
        let lost = find_column(&names, &LOSSES);
        let unit = |kind: &str, column: &Column, given: Option<TimeUnit>| {
            column.unit.or(given).map(TimeUnit::per_second).ok_or_else(|| {
                InvalidInput::missing(format!("trace, unit of {kind}"), "", {
                    let name = split_unit(names[column.index]).0;
                    format!("Name the column {name}_s, {name}_ms, {name}_us or {name}_ns.")
                })
            })
        };
        let (time_unit, delay_unit) = (unit("time", &time, units.time)?, unit("delay", &delay, units.delay)?);
        let mut rows = Vec::new();
        let mut start = None;
        for (line, content) in content_lines(text).skip(1) {
            let cells = split(content);
            let cell = |column: &Column| cells.get(column.index).map_or("", String::as_str);
            let number = |kind: &str, text: &str| {
                let text = if separator == Some(';') { text.replace(',', ".") } else { text.to_owned() };
                text.parse::<f64>().map_err(|_| {
                    InvalidInput::new(
                        format!("trace, line {}, {kind}", line + 1),
                        format!("{text:?}"),
                        "a number is required",
                        if text.contains(':') {
                            "Write times as numbers, in s since any moment, such as 0.02."
                        } else {
                            "Correct the line, or remove it."
                        },
                    )
                })
            };
            let is_lost = match lost.as_ref().map(|column| cell(column).to_lowercase()).as_deref() {
                None | Some("0" | "false" | "no" | "") => false,
                Some("1" | "true" | "yes") => true,
                Some(other) => {
                    return Err(InvalidInput::new(
                        format!("trace, line {}, lost", line + 1),
                        format!("{other:?}"),
                        "a packet is lost (1, true, yes) or not (0, false, no)",
                        "Write one of these words.",
                    ));
                }
            };
            let sent = number("time", cell(&time))?;
            // Epochs in ns have more digits than their differences.
            let first = *start.get_or_insert(sent);
            let text = cell(&delay);
            let is_empty = matches!(text.to_lowercase().as_str(), "" | "nan" | "na");
            let lost = is_lost || is_empty;
            let delay = if lost { 0.0 } else { number("delay", text)? / delay_unit };
            rows.push(TraceRow { time: (sent - first) / time_unit, delay, lost });
        }
        let trace = Self::new(rows)?;
        Ok(if lost.is_some() { trace.with_losses_recorded() } else { trace })
    }

    /// The trace of the network as a table that [`Trace::from_csv`] reads back.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::rig::{Trace, trace::TraceUnits};
    ///
    /// let text = "time_s,delay_s,lost\n0.0,0.0245,0\n0.02,,1\n";
    /// assert_eq!(Trace::from_csv(text, TraceUnits::default())?.to_csv(), text);
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn to_csv(&self) -> String {
        let mut text = "time_s,delay_s,lost\n".to_owned();
        for row in self.rows() {
            text += &if row.lost {
                format!("{:?},,1\n", row.time)
            } else {
                format!("{:?},{:?},0\n", row.time, row.delay)
            };
        }
        text
    }

    /// Reads a trace of a network from the JSON that `irtt client -o` writes (github.com/heistp/irtt).
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if the text is not such JSON, a delay of a packet that came is missing, or as [`Trace::new`].
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::rig::{Trace, trace::IrttDelay};
    ///
    /// let text = r#"{"round_trips": [
    ///     {"seqno": 0, "lost": "false", "timestamps": {"client": {"send": {"wall": 0, "monotonic": 1000}}},
    ///      "delay": {"receive": 8000000, "rtt": 20000000, "send": 12000000}},
    ///     {"seqno": 1, "lost": "true_down", "timestamps": {"client": {"send": {"wall": 0, "monotonic": 10001000}}}}]}"#;
    /// let trace = Trace::from_irtt(text, IrttDelay::RoundTrip)?;
    /// assert_eq!((trace.rows()[0].delay, trace.rows()[1].time), (0.02, 0.01));
    /// assert!(trace.rows()[1].lost);
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn from_irtt(text: &str, taken: IrttDelay) -> Result<Self> {
        let measured: Irtt = serde_json::from_str(text).map_err(|error| {
            InvalidInput::new(
                "trace",
                "text",
                format!("a file of IRTT has a list round_trips with lost, timestamps and delay: {error}"),
                "Write it with irtt client -o FILE.",
            )
        })?;
        let start = measured.round_trips.first().map_or(0, |trip| trip.timestamps.client.send.nanoseconds());
        let rows = measured.round_trips.iter().enumerate().map(|(index, trip)| {
            let since = trip.timestamps.client.send.nanoseconds() - start;
            let delay = trip.delay.as_ref().and_then(|delay| match taken {
                IrttDelay::RoundTrip => delay.rtt,
                IrttDelay::Send => delay.send,
                IrttDelay::Receive => delay.receive,
            });
            let missing = || {
                InvalidInput::missing(
                    format!("trace, round_trips[{index}].delay"),
                    "ns",
                    "Take the round trip (--round-trip, or round_trip = true in a study): one way needs a server that \
                     stamps packets.",
                )
            };
            // a trip that was lost on one way only tells of the other, if its delay is known
            let lost = match (taken, trip.lost.as_str()) {
                (_, "false") => false,
                (IrttDelay::Send, "true_down") | (IrttDelay::Receive, "true_up") => delay.is_none(),
                _ => true,
            };
            let delay = if lost { 0 } else { delay.ok_or_else(missing)? };
            Ok(TraceRow { time: since as f64 / 1e9, delay: delay as f64 / 1e9, lost })
        });
        Ok(Self::new(rows.collect::<Result<_>>()?)?.with_losses_recorded())
    }
}

/// The part of IRTT's file that a trace needs.
#[derive(Deserialize)]
struct Irtt {
    round_trips: Vec<IrttTrip>,
}

#[derive(Deserialize)]
struct IrttTrip {
    lost: String,
    timestamps: IrttStamps,
    delay: Option<IrttDelays>,
}

#[derive(Deserialize)]
struct IrttStamps {
    client: IrttClient,
}

#[derive(Deserialize)]
struct IrttClient {
    send: IrttStamp,
}

#[derive(Deserialize)]
struct IrttStamp {
    wall: Option<i64>,
    monotonic: Option<i64>,
}

impl IrttStamp {
    /// The stamp of a trace's packet, ns; of the clock that nobody sets, if there is one.
    fn nanoseconds(&self) -> i64 {
        self.monotonic.or(self.wall).unwrap_or(0)
    }
}

/// The delays of a trace's packet, ns.
#[derive(Deserialize)]
struct IrttDelays {
    rtt: Option<i64>,
    send: Option<i64>,
    receive: Option<i64>,
}
