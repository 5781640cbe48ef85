//! Reads the log of `ping -D` as a trace of a network.

use std::collections::BTreeMap;

use super::{MOST_ROWS, Trace, TraceRow, statistics};
use crate::error::{InvalidInput, Result};

/// So many lines at most come before the first answer.
const LONGEST_HEADER: usize = 50;
/// `icmp_seq` has 16 bits.
const SEQUENCES: i64 = 1 << 16;
/// A clock that was set back by more than this is not read past, s.
const LARGEST_SETBACK: f64 = 1.0;

/// How to record a log that can be read.
const REMEDY: &str = "Record with ping -D on Linux: ping -D -i 0.01 HOST > ping.log. Elsewhere record with irtt, or write a \
                      table with the columns time_s and rtt_ms.";

/// What one line of a log says about the network.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Line {
    /// An answer, with its sequence number, its round trip in s and, if the line begins with one, its time.
    Answer { sequence: u32, round_trip: f64, stamp: Option<Stamp> },
    /// A sequence number of which something else is said: no answer yet, host unreachable.
    Unanswered { sequence: u32 },
    /// The number of packets sent, from the summary.
    Sent(i64),
    /// Anything else.
    Other,
}

/// A time since 1970: whole seconds, and the rest in s, because a double has no room for both.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Stamp {
    seconds: i64,
    rest: f64,
}

/// Whether a sign belongs to a number, with a decimal point or comma.
fn is_part_of_number(sign: char) -> bool {
    sign.is_ascii_digit() || sign == '.' || sign == ','
}

/// The whole number that a text begins with.
fn leading_number<T: std::str::FromStr>(text: &str) -> Option<T> {
    text.split(|sign: char| !sign.is_ascii_digit()).next()?.parse().ok()
}

/// The time at the beginning of a line of a network's log: `[1700000000.123456] …`.
fn read_stamp(line: &str) -> Option<Stamp> {
    let (inside, _) = line.strip_prefix('[')?.split_once(']')?;
    let (seconds, rest) = inside.split_once('.').unwrap_or((inside, "0"));
    let is_digits = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    if !is_digits(seconds) || !is_digits(rest) {
        return None;
    }
    Some(Stamp { seconds: seconds.parse().ok()?, rest: format!("0.{rest}").parse().ok()? })
}

/// The sequence number on a line of a network's log: `icmp_seq=7`, `seq=7`, `icmp_seq 7`.
fn read_sequence(line: &str) -> Option<u32> {
    let (_, after) = line.split_once("seq=").or_else(|| line.split_once("seq "))?;
    leading_number(after)
}

/// The round trip on a line of a network's log, s: `time=12.3 ms`, in any language.
fn read_round_trip(line: &str) -> Option<f64> {
    let milliseconds: f64 = line.split('=').skip(1).find_map(|after| {
        let (number, unit) = after.split_at(after.find(|sign| !is_part_of_number(sign))?);
        unit.trim_start().starts_with("ms").then(|| number.replace(',', ".").parse().ok())?
    })?;
    milliseconds.is_finite().then_some(milliseconds / 1e3)
}

/// What a line of a network's log says.
fn read_line(line: &str) -> Line {
    let line = line.trim();
    if let Some(sequence) = read_sequence(line) {
        return match read_round_trip(line) {
            Some(round_trip) => Line::Answer { sequence, round_trip, stamp: read_stamp(line) },
            None => Line::Unanswered { sequence },
        };
    }
    match leading_number(line) {
        // `300 packets transmitted, 297 received, 1% packet loss, time 2990ms`
        Some(sent) if line.contains(',') && line.contains('%') => Line::Sent(sent),
        _ => Line::Other,
    }
}

/// Whether a line is that with which a network's log begins.
fn is_header(line: &str) -> bool {
    line.trim_start().starts_with("PING ")
}

/// Whether a line of a network's log is an answer as Windows writes it, without time and number.
fn is_of_windows(line: &str) -> bool {
    line.contains("TTL=") && line.contains("ms")
}

/// The beginning of a line of a network's log, for a refusal.
fn shown(line: &str) -> String {
    line.trim().chars().take(60).collect()
}

/// Whether a text is the log of `ping`, rather than a table of a network's trace.
pub(super) fn is_ping_log(text: &str) -> bool {
    let is_of_ping = |line: &str| is_header(line) || is_of_windows(line) || read_sequence(line).is_some();
    text.trim_start_matches('\u{feff}').lines().take(LONGEST_HEADER).any(is_of_ping)
}

/// The answers in a log, and what it says of the packets without one.
#[derive(Debug, Default)]
struct Log {
    /// Round trip and time of the answer, by the number of the packet; the first of several answers.
    answers: BTreeMap<i64, (f64, Stamp)>,
    /// The numbers of the first and the last packet that the log speaks of.
    first: i64,
    last: i64,
    /// Whether the log has its beginning: then nothing was sent before number 1.
    has_header: bool,
    /// The packets sent, from the summary.
    sent: Option<i64>,
}

impl Log {
    /// Reads the log of a network line by line.
    fn read(text: &str) -> Result<Self> {
        let mut log = Self::default();
        let mut newest: Option<i64> = None;
        for (index, text) in text.trim_start_matches('\u{feff}').lines().enumerate() {
            let line = read_line(text);
            let sequence = match line {
                Line::Answer { sequence, .. } | Line::Unanswered { sequence } => i64::from(sequence),
                Line::Sent(sent) => {
                    log.sent = Some(sent);
                    continue;
                }
                Line::Other => {
                    if newest.is_some() && is_header(text) {
                        return Err(InvalidInput::new(
                            format!("ping log, line {}", index + 1),
                            format!("{:?}", shown(text)),
                            "a log has one ping, whose numbers increase",
                            "Give each log by itself.",
                        ));
                    }
                    log.has_header |= is_header(text);
                    continue;
                }
            };
            // the number next to the newest one, of all that have the same 16 bits
            let number = newest.map_or(sequence, |newest| {
                let ahead = (sequence - newest).rem_euclid(SEQUENCES);
                newest + if ahead > SEQUENCES / 2 { ahead - SEQUENCES } else { ahead }
            });
            (log.first, log.last) =
                newest.map_or((number, number), |_| (log.first.min(number), log.last.max(number)));
            newest = Some(newest.map_or(number, |newest| newest.max(number)));
            if let Line::Answer { round_trip, stamp, .. } = line {
                let stamp = stamp.ok_or_else(|| {
                    InvalidInput::new(
                        format!("ping log, line {}", index + 1),
                        format!("{:?}", shown(text)),
                        "an answer begins with its time in brackets, without which nothing says how often packets were sent",
                        REMEDY,
                    )
                })?;
                log.answers.entry(number).or_insert((round_trip, stamp));
            }
        }
        Ok(log)
    }

    /// When the answered packets were sent over the network, s from the first answer: an answer's line is written when it
    /// has come, a little later at most.
    fn sending_times(&self) -> Result<Vec<(i64, f64)>> {
        let start = self.answers.values().next().map_or(0, |(_, stamp)| stamp.seconds);
        let time =
            |(round_trip, stamp): &(f64, Stamp)| (stamp.seconds - start) as f64 + stamp.rest - round_trip;
        let mut times: Vec<(i64, f64)> =
            self.answers.iter().map(|(number, answer)| (*number, time(answer))).collect();
        // A packet was not sent after a later one.
        let mut earliest = f64::INFINITY;
        for (number, time) in times.iter_mut().rev() {
            if *time - earliest > LARGEST_SETBACK {
                return Err(InvalidInput::new(
                    format!("ping log, icmp_seq {}", *number % SEQUENCES),
                    format!("sent {} s after a later one", *time - earliest),
                    "the times of a log increase: the clock was set back while it was recorded",
                    "Record again, or keep the part before or after.",
                ));
            }
            earliest = earliest.min(*time);
            *time = earliest;
        }
        Ok(times)
    }

    /// The last packet of the network's log that would have been answered: those of the summary that were sent within the
    /// longest round trip before the end may have been on their way.
    fn last_decided(&self, interval: f64) -> i64 {
        let Some(sent) = self.sent.filter(|_| self.has_header) else { return self.last };
        let longest = self.answers.values().map(|(round_trip, _)| *round_trip).fold(0.0, f64::max);
        let on_the_way = if interval > 0.0 { (longest / interval).ceil() as i64 } else { sent };
        self.last.max(self.first.min(1).saturating_add(sent).saturating_sub(1).saturating_sub(on_the_way))
    }
}

impl Trace {
    /// Reads a trace of a network from the log of `ping -D`: the round trip of each packet. One without an answer is lost:
    /// one whose number is missing, and one of which the log says so (`no answer yet`, `Destination Host Unreachable`)
    /// without an answer later.
    ///
    /// An answer has the time at which it came; the packet was sent one round trip before. Packets without an answer
    /// were sent evenly between those with one.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if an answer has no time, fewer than two packets were answered, the clock was set back by more than
    /// a second, there would be more than ten million packets, or as [`Trace::new`].
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::rig::Trace;
    ///
    /// let log = "PING host (10.0.0.2) 56(84) bytes of data.\n\
    ///            [1700000000.120] 64 bytes from 10.0.0.2: icmp_seq=1 ttl=64 time=20.0 ms\n\
    ///            [1700000000.130] no answer yet for icmp_seq=2\n\
    ///            [1700000000.326] 64 bytes from 10.0.0.2: icmp_seq=3 ttl=64 time=26.0 ms\n";
    /// let trace = Trace::from_ping(log)?;
    /// assert_eq!(trace.rows().len(), 3);
    /// assert!(trace.rows()[1].lost && (trace.rows()[1].time - 0.1).abs() < 1e-9);
    /// assert_eq!(trace.halved().rows()[2].delay, 0.013);
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn from_ping(text: &str) -> Result<Self> {
        let log = Log::read(text)?;
        let times = log.sending_times()?;
        let ([(first_number, first_time), ..], [.., (last_number, last_time)]) =
            (times.as_slice(), times.as_slice())
        else {
            return Err(too_few(0));
        };
        if times.len() < 2 {
            return Err(too_few(1));
        }
        let step = |pair: &[(i64, f64)]| (pair[1].1 - pair[0].1) / (pair[1].0 - pair[0].0) as f64;
        let interval = statistics::median(times.windows(2).map(step).collect());
        let begin = if log.has_header { log.first.min(1) } else { log.first };
        let end = log.last_decided(interval);
        if end as f64 - begin as f64 >= MOST_ROWS {
            return Err(InvalidInput::new(
                "ping log",
                format!("icmp_seq from {begin} to {end}"),
                format!("a trace has at most {MOST_ROWS:e} packets"),
                "Give a part of the log.",
            ));
        }
        let lost = |time: f64| TraceRow { time, delay: 0.0, lost: true };
        let mut rows: Vec<TraceRow> =
            (begin..*first_number).map(|n| lost(first_time - (first_number - n) as f64 * interval)).collect();
        for (index, (number, time)) in times.iter().enumerate() {
            rows.push(TraceRow { time: *time, delay: log.answers[number].0, lost: false });
            if let Some((next, next_time)) = times.get(index + 1) {
                let apart = (next_time - time) / (next - number) as f64;
                rows.extend((1..next - number).map(|n| lost(time + n as f64 * apart)));
            }
        }
        rows.extend((1..=end - last_number).map(|n| lost(last_time + n as f64 * interval)));
        Ok(Self::new(rows)?.with_losses_recorded())
    }
}

/// The refusal of a network's log with too few answers.
fn too_few(answers: usize) -> InvalidInput {
    InvalidInput::new(
        "ping log",
        format!("{answers} answer(s)"),
        "a trace has at least two packets that came, on lines with icmp_seq=… and time=… ms",
        REMEDY,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ref_lines_of_every_ping() {
        let answer = |sequence, round_trip, stamp| Line::Answer { sequence, round_trip, stamp };
        let stamp = Some(Stamp { seconds: 1_700_000_000, rest: 0.123_456 });
        for (line, expected) in [
            (
                "[1700000000.123456] 64 bytes from 1.2.3.4: icmp_seq=7 ttl=64 time=12.3 ms",
                answer(7, 0.0123, stamp),
            ),
            ("64 bytes from 8.8.8.8: seq=0 ttl=118 time=14.123 ms", answer(0, 0.014_123, None)),
            (
                "[1700000000.123456] 64 Bytes von h (1.2.3.4): icmp_seq=8 ttl=64 Zeit=0.045 ms (DUP!)",
                answer(8, 0.045 / 1e3, stamp),
            ),
            ("[1700000000.123456] no answer yet for icmp_seq=9", Line::Unanswered { sequence: 9 }),
            ("From 10.0.0.1 icmp_seq=3 Destination Host Unreachable", Line::Unanswered { sequence: 3 }),
            ("Request timeout for icmp_seq 5", Line::Unanswered { sequence: 5 }),
            (
                "300 packets transmitted, 297 received, +2 errors, 1% packet loss, time 2990ms",
                Line::Sent(300),
            ),
            ("300 Pakete übertragen, 297 empfangen, 1% packet loss, time 2990ms", Line::Sent(300)),
            ("rtt min/avg/max/mdev = 0.1/0.2/0.3/0.0 ms", Line::Other),
            ("--- host ping statistics ---", Line::Other),
            ("PING host (1.2.3.4) 56(84) bytes of data.", Line::Other),
            ("", Line::Other),
        ] {
            assert_eq!(read_line(line), expected, "{line}");
        }
    }

    #[test]
    fn law_tables_are_no_logs() {
        for text in
            ["time_s,icmp_seq,rtt_ms\n0,1,20\n", "time_s delay_ms\n0 20\n", "{\"round_trips\": []}", ""]
        {
            assert!(!is_ping_log(text), "{text}");
        }
        assert!(is_ping_log("PING h (1.2.3.4) 56(84) bytes of data.\n"));
        assert!(is_ping_log("Reply from 8.8.8.8: bytes=32 time=14ms TTL=118\n"));
    }
}
