//! The network and the controllers, and their contributions to the age of a sample.

use crate::error::{InvalidInput, Result};
use crate::model::Delay;
use crate::quantity;

/// A network between two controllers, as far as it matters for stability. All values in s, checked.
///
/// # Examples
///
/// ```
/// use telespring::{Delay, verdicts::Network};
/// let network = Network::new(Delay::each_way(0.05)?, 0.01, 0.004, 0.001, 0.0)?;
/// assert!((network.oldest_partner_sample()[0] - 0.065).abs() < 1e-15);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Network {
    delay: Delay,
    jitters: [f64; 2],
    max_gap: f64,
    sample_period: f64,
    computing_time: f64,
}

/// The contributions to the age of a partner sample, one direction, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DelayBudget {
    /// The constant part of the one-way delay.
    pub network: f64,
    /// The maximum additional delay of a packet.
    pub jitter: f64,
    /// The longest wait for a newer sample.
    pub gap: f64,
    /// The hold of the force over one sample period.
    pub sampling: f64,
    /// The time from reading the samples to applying the force.
    pub computing: f64,
}

impl DelayBudget {
    /// The sum of all contributions to the network's delay budget, s: the maximum age of a partner sample in use.
    pub fn total(&self) -> f64 {
        self.network + self.jitter + self.gap + self.sampling + self.computing
    }

    /// Each contribution to the network's delay budget with its name and its share of the total, from 0 to 1
    /// (all 0 if the total is 0).
    pub fn shares(&self) -> [(&'static str, f64); 5] {
        let total = self.total();
        let share = |item: f64| if total > 0.0 { item / total } else { 0.0 };
        [
            ("network", share(self.network)),
            ("jitter", share(self.jitter)),
            ("gap", share(self.gap)),
            ("sampling", share(self.sampling)),
            ("computing", share(self.computing)),
        ]
    }
}

impl Network {
    /// Creates a network from the delays per direction and everything else that adds to the age of a
    /// sample.
    ///
    /// `jitter` is the maximum additional delay of a packet. `max_gap` is the longest wait for a newer
    /// partner sample, losses included; 0 means no gaps. Both controllers run at `sample_period` and hold
    /// the force (0 is a continuous controller); the force acts `computing_time` after the samples are
    /// read, within the same period.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if a span is negative, not finite or longer than 100 s, if delay, jitter and gap
    /// together exceed that, or if the computing time exceeds the sample period.
    pub fn new(
        delay: Delay,
        jitter: f64,
        max_gap: f64,
        sample_period: f64,
        computing_time: f64,
    ) -> Result<Self> {
        Self::with_jitters(delay, [jitter; 2], max_gap, sample_period, computing_time)
    }

    /// The same with a jitter of each way, forward and backward.
    ///
    /// # Errors
    ///
    /// As [`Network::new`].
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::{Delay, verdicts::Network};
    /// let network = Network::with_jitters(Delay::each_way(0.05)?, [0.01, 0.03], 0.0, 0.0, 0.0)?;
    /// assert_eq!(network.jitter(), 0.03);
    /// assert!((network.oldest_partner_sample()[0] - 0.06).abs() < 1e-15);
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn with_jitters(
        delay: Delay,
        jitters: [f64; 2],
        max_gap: f64,
        sample_period: f64,
        computing_time: f64,
    ) -> Result<Self> {
        for jitter in jitters {
            quantity::SPAN.check("jitter", jitter)?;
        }
        quantity::SPAN.check("max_gap", max_gap)?;
        quantity::SPAN.check("sample_period", sample_period)?;
        quantity::SPAN.check("computing_time", computing_time)?;
        let [forward, backward] = jitters;
        let (longest, jitter) = if delay.forward() + forward >= delay.backward() + backward {
            (delay.forward() + forward + max_gap, forward)
        } else {
            (delay.backward() + backward + max_gap, backward)
        };
        if longest > LONGEST_DELAY {
            return Err(InvalidInput::new(
                if jitter > max_gap { "jitter" } else { "max_gap" },
                if jitter > max_gap { jitter } else { max_gap },
                format!(
                    "delay, jitter and longest gap together must not exceed {LONGEST_DELAY} s, but are {longest} s"
                ),
                "Check the unit: s is expected.",
            ));
        }
        if sample_period > 0.0 && sample_period < SHORTEST_PERIOD {
            return Err(InvalidInput::new(
                "sample_period",
                sample_period,
                format!(
                    "a sample period must be 0 (a continuous controller) or at least {SHORTEST_PERIOD} s"
                ),
                "Check the unit: s is expected.",
            ));
        }
        if computing_time > sample_period {
            return Err(InvalidInput::new(
                "computing_time",
                computing_time,
                format!("a computing time must fit into the sample period of {sample_period} s"),
                "Shorten it, or give the actual sample period of the controller.",
            ));
        }
        Ok(Self { delay, jitters, max_gap, sample_period, computing_time })
    }

    /// Creates a network with a constant delay only: continuous controllers, no jitter, no gaps.
    pub fn constant(delay: Delay) -> Self {
        Self { delay, jitters: [0.0; 2], max_gap: 0.0, sample_period: 0.0, computing_time: 0.0 }
    }

    /// The constant part of the network's one-way delays.
    pub fn delay(&self) -> Delay {
        self.delay
    }

    /// The constant part of both delays, forward and backward, s.
    fn delays(&self) -> [f64; 2] {
        [self.delay.forward(), self.delay.backward()]
    }

    /// The maximum additional delay of a packet, s: the larger of both ways.
    pub fn jitter(&self) -> f64 {
        self.jitters[0].max(self.jitters[1])
    }

    /// The maximum additional delay of a packet, forward and backward, s.
    pub fn jitters(&self) -> [f64; 2] {
        self.jitters
    }

    /// The longest wait for a newer partner sample, s.
    pub fn max_gap(&self) -> f64 {
        self.max_gap
    }

    /// The sample period of both controllers, s; 0 if they are continuous.
    pub fn sample_period(&self) -> f64 {
        self.sample_period
    }

    /// The time from reading the samples to applying the force, s, part of the network's timing.
    pub fn computing_time(&self) -> f64 {
        self.computing_time
    }

    /// True if every packet has the same delay: neither jitter nor gaps.
    pub fn is_constant(&self) -> bool {
        self.jitter() == 0.0 && self.max_gap == 0.0
    }

    /// The maximum age of a robot's own position sample on this network, s: one period plus computing time.
    pub fn oldest_own_sample(&self) -> f64 {
        self.sample_period + self.computing_time
    }

    /// The contributions of both directions: from robot 1 to robot 2, and back.
    pub fn budget(&self) -> [DelayBudget; 2] {
        [0, 1].map(|way| DelayBudget {
            network: self.delays()[way],
            jitter: self.jitters[way],
            gap: self.max_gap,
            sampling: self.sample_period,
            computing: self.computing_time,
        })
    }

    /// The maximum age T₁ and T₂ of a partner sample per direction, s.
    pub fn oldest_partner_sample(&self) -> [f64; 2] {
        self.budget().map(|direction| direction.total())
    }

    /// The smallest and largest age (s) of the partner samples in use, forward and backward, if a sample that was
    /// overtaken is never played: a force acts from the computing time on and is held over a period.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::{Delay, verdicts::Network};
    /// let network = Network::new(Delay::each_way(0.05)?, 0.01, 0.0, 0.0, 0.0)?;
    /// let [[least, greatest], _] = network.ages();
    /// assert!((least - 0.05).abs() < 1e-15 && (greatest - 0.06).abs() < 1e-15);
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn ages(&self) -> [[f64; 2]; 2] {
        self.budget().map(|direction| [direction.network + direction.computing, direction.total()])
    }

    /// The constant delays behind a playout buffer that waits for the latest packet and the longest gap, s;
    /// without jitter and gaps the network's own delays.
    pub fn buffered(&self) -> [f64; 2] {
        [0, 1].map(|way| self.delays()[way] + self.jitters[way] + self.max_gap)
    }

    /// The mean of [`Network::buffered`], s: the only constant delay that affects the stability of continuous
    /// controllers. Sampled ones round each direction up to whole periods: the same mean, shared otherwise, makes a
    /// round trip that is at most one period longer or shorter.
    pub fn buffered_mean(&self) -> f64 {
        let [forward, backward] = self.buffered();
        0.5 * (forward + backward)
    }

    /// The delays behind the playout buffer in whole sample periods, rounded up, as a sampled controller
    /// applies them.
    pub(super) fn whole_ticks(&self) -> [u64; 2] {
        self.buffered().map(|delay| ticks_of(delay, self.sample_period))
    }

    /// The round trip behind a playout buffer in whole sample periods, s.
    pub(super) fn held_round_trip(&self) -> f64 {
        let [forward, backward] = self.whole_ticks();
        (forward + backward) as f64 * self.sample_period
    }

    /// The same controllers over a constant delay, without jitter and gaps.
    pub(super) fn with_delay(&self, delay: Delay) -> Self {
        Self { delay, jitters: [0.0; 2], max_gap: 0.0, ..*self }
    }
}

/// A delay (s) in whole periods (s), rounded up; one given as a multiple of the period stays one in spite of rounding.
pub(super) fn ticks_of(delay: f64, period: f64) -> u64 {
    const ROUNDING: f64 = 1e-9;
    let ticks = delay / period;
    (ticks - ROUNDING.max(8.0 * f64::EPSILON * ticks)).ceil().max(0.0) as u64
}

/// The largest delay that every criterion accepts, s.
const LONGEST_DELAY: f64 = 100.0;
/// 10 MHz: far above any haptic controller, and delays remain countable in periods.
const SHORTEST_PERIOD: f64 = 1e-7;
