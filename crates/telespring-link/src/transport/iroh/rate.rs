//! The rate of the packets: every one, every second or every fourth, by the loss that lasts.
//!
//! The controller of QUIC's congestion never stops a packet (see `quic`), so this is what answers a path that is too narrow:
//! if more than a tenth of the packets get lost two seconds in a row, every second packet is left out. It says what was lost on
//! the way to the partner, as the partner's acknowledgements tell: only that way gets better by sending less. Loss that does
//! not come from a queue, as on a radio link, stays below that, or comes in bursts.

use std::time::Duration;

/// From one judgement to the next.
const WINDOW: Duration = Duration::from_secs(1);
/// Fewer packets than this in a window say nothing.
const ENOUGH: u64 = 50;
/// A larger share of loss is too much.
const TOO_MUCH: f64 = 0.10;
/// A smaller share is clear.
const CLEAR: f64 = 0.03;
/// Windows in a row with too much loss after which the rate is halved.
const PATIENCE: u32 = 2;
/// Windows in a row without loss after which the rate is doubled, at first and at most.
const CLEARING: [u32; 2] = [5, 60];
/// If the rate must be halved again within this many windows of doubling it, the next doubling takes twice as long.
const RELAPSE: u32 = 10;
/// The largest number of packets of which one is sent.
const MOST: u8 = 4;

/// What became of packets since the last look.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Outcome {
    /// Packets sent.
    pub(super) sent: u64,
    /// Packets that got lost.
    pub(super) lost: u64,
    /// Acknowledgements that came.
    pub(super) acknowledgements: u64,
}

/// The rate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct RateCap {
    every: u8,
    window: Outcome,
    /// When the window is over, since any origin.
    due: Option<Duration>,
    bad: u32,
    good: u32,
    clearing: u32,
    /// Windows since the rate was doubled.
    since_faster: Option<u32>,
}

impl Default for RateCap {
    fn default() -> Self {
        Self {
            every: 1,
            window: Outcome::default(),
            due: None,
            bad: 0,
            good: 0,
            clearing: CLEARING[0],
            since_faster: None,
        }
    }
}

impl RateCap {
    /// Of how many packets one is sent: 1, 2 or 4.
    pub(super) fn every(&self) -> u8 {
        self.every
    }

    /// Takes what became of packets since the last call.
    pub(super) fn observe(&mut self, now: Duration, outcome: Outcome) {
        let Outcome { sent, lost, acknowledgements } = outcome;
        self.window.sent = self.window.sent.saturating_add(sent);
        self.window.lost = self.window.lost.saturating_add(lost);
        self.window.acknowledgements = self.window.acknowledgements.saturating_add(acknowledgements);
        let due = *self.due.get_or_insert(now + WINDOW);
        if now < due {
            return;
        }
        self.due = Some(now + WINDOW);
        let window = std::mem::take(&mut self.window);
        // without an answer nothing is known: a silence is for the watchdog, not for this
        if window.acknowledgements > 0 && window.sent >= ENOUGH {
            self.judge(window.lost as f64 / window.sent as f64);
        }
    }

    fn judge(&mut self, share: f64) {
        self.since_faster = self.since_faster.map(|windows| windows.saturating_add(1));
        self.bad = if share > TOO_MUCH { self.bad + 1 } else { 0 };
        self.good = if share < CLEAR { self.good.saturating_add(1) } else { 0 };
        if self.bad >= PATIENCE && self.every < MOST {
            self.every *= 2;
            (self.bad, self.good) = (0, 0);
            if self.since_faster.take().is_some_and(|windows| windows <= RELAPSE) {
                self.clearing = (2 * self.clearing).min(CLEARING[1]);
            }
        } else if self.good >= self.clearing && self.every > 1 {
            self.every /= 2;
            self.good = 0;
            self.since_faster = Some(0);
        }
        if self.since_faster.is_some_and(|windows| windows > RELAPSE) && self.every == 1 {
            (self.since_faster, self.clearing) = (None, CLEARING[0]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A path seen ten times a second; `loss` says what share of a rate, in packets per second, gets lost.
    struct Path {
        cap: RateCap,
        now: Duration,
        changes: Vec<(u64, u8)>,
    }

    impl Path {
        fn new() -> Self {
            Self { cap: RateCap::default(), now: Duration::ZERO, changes: Vec::new() }
        }

        fn run(&mut self, seconds: u32, loss: impl Fn(f64) -> f64) {
            for _ in 0..10 * seconds {
                let rate = 1000.0 / f64::from(self.cap.every());
                let sent = rate / 10.0;
                let before = self.cap.every();
                let lost = (sent * loss(rate)).round() as u64;
                let outcome =
                    Outcome { sent: sent as u64, lost, acknowledgements: u64::from(loss(rate) < 1.0) };
                self.cap.observe(self.now, outcome);
                if self.cap.every() != before {
                    self.changes.push((self.now.as_secs(), self.cap.every()));
                }
                self.now += Duration::from_millis(100);
            }
        }

        fn rates(&self) -> Vec<u8> {
            self.changes.iter().map(|(_, every)| *every).collect()
        }
    }

    #[test]
    fn law_ordinary_loss_changes_nothing() {
        for loss in [0.0, 0.02, 0.05, 0.09] {
            let mut path = Path::new();
            path.run(600, |_| loss);
            assert_eq!(path.changes, [], "{loss}");
        }
    }

    #[test]
    fn law_sustained_loss_halves_the_rate_twice_and_clearing_brings_it_back() {
        let mut path = Path::new();
        path.run(20, |_| 0.2);
        assert_eq!(path.rates(), [2, 4]);
        assert!(path.changes[0].0 <= 3 && path.changes[1].0 <= 6, "{:?}", path.changes);
        path.run(60, |_| 0.0);
        assert_eq!(path.rates(), [2, 4, 2, 1]);
        // between clear and too much it stays as it is
        path.run(20, |_| 0.2);
        path.run(300, |_| 0.05);
        assert_eq!(path.cap.every(), 4);
    }

    #[test]
    fn law_a_burst_and_a_silence_change_nothing() {
        let mut path = Path::new();
        for _ in 0..20 {
            path.run(1, |_| 0.9);
            path.run(5, |_| 0.0);
        }
        assert_eq!(path.changes, []);
        // nothing is heard for a minute, and then all that was lost is known at once
        path.run(60, |_| 1.0);
        path.cap.observe(path.now, Outcome { sent: 100, lost: 60_000, acknowledgements: 1 });
        path.run(60, |_| 0.0);
        assert_eq!(path.changes, []);
        // a silence neither speeds up
        path.run(10, |_| 0.3);
        assert_eq!(path.cap.every(), 4);
        path.run(120, |_| 1.0);
        assert_eq!(path.cap.every(), 4);
    }

    #[test]
    fn law_a_narrow_path_is_tried_again_ever_more_rarely() {
        // 600 packets per second fit
        let narrow = |rate: f64| (1.0 - 600.0 / rate).max(0.0);
        let mut path = Path::new();
        path.run(600, narrow);
        assert!(path.rates().iter().all(|every| *every <= 2), "{:?}", path.changes);
        let tries = path.rates().iter().filter(|every| **every == 1).count();
        assert!((3..=14).contains(&tries), "{:?}", path.changes);
        // most of the time the rate is the one that fits
        let times: Vec<u64> = path.changes.iter().map(|(time, _)| *time).collect();
        assert!(times.last().unwrap() - times[times.len() - 3] >= 50, "{:?}", path.changes);
    }
}
