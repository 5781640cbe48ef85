//! Checks of the values of a network model.

use super::{Blackout, GilbertElliott, JitterDistribution, Network, NetworkModel, RateLimit};
use crate::error::{InvalidInput, Result};
use crate::quantity;

impl Network {
    /// Checks both directions of the network.
    ///
    /// # Errors
    ///
    /// As [`NetworkModel::check`]; with the direction in the field if both differ.
    pub fn check(&self) -> Result<()> {
        if self.forward == self.backward {
            return self.forward.check();
        }
        let ways = [("forward", &self.forward), ("backward", &self.backward)];
        ways.into_iter().try_for_each(|(way, model)| {
            model.check().map_err(|mut refusal| {
                let (key, rest) = match refusal.field.split_once('.') {
                    Some((key, rest)) => (key.to_owned(), format!(".{rest}")),
                    None => (refusal.field.clone(), String::new()),
                };
                refusal.field = format!("{key}.{way}{rest}");
                refusal
            })
        })
    }
}

impl NetworkModel {
    /// Checks that all values of one direction of the network are in range and fit together.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] with a field such as `burst.to_bad`.
    pub fn check(&self) -> Result<()> {
        quantity::SPAN.check("jitter", self.jitter)?;
        quantity::PROBABILITY.check("loss", self.loss)?;
        quantity::PROBABILITY.check("duplicate", self.duplicate)?;
        self.distribution.check(self.jitter).map_err(|refusal| refusal.within("distribution"))?;
        if let Some(burst) = &self.burst {
            burst.check().map_err(|refusal| refusal.within("burst"))?;
        }
        if let Some(rate) = &self.rate {
            rate.check().map_err(|refusal| refusal.within("rate"))?;
        }
        if let Some(blackout) = &self.blackout {
            blackout.check().map_err(|refusal| refusal.within("blackout"))?;
        }
        if let Some(adversary) = &self.adversary {
            adversary.check().map_err(|refusal| refusal.within("adversary"))?;
        }
        if self.trace.is_some() && self.jitter > 0.0 {
            return Err(InvalidInput::new(
                "jitter",
                self.jitter,
                "a recorded trace has its own delays, to which no jitter is added",
                "Remove jitter and distribution, or the trace.",
            ));
        }
        Ok(())
    }
}

impl JitterDistribution {
    /// Checks mean and standard deviation of the network's jitter with this bound, s.
    fn check(&self, bound: f64) -> Result<()> {
        let Some(moments) = self.moments() else { return Ok(()) };
        if bound == 0.0 {
            let [mean, sd] = moments;
            return Err(InvalidInput::new(
                "kind",
                "a distribution without a bound",
                "the key jitter gives the largest additional delay, at which the distribution is cut",
                format!("Add jitter = {}, or another bound.", mean + 4.0 * sd),
            ));
        }
        for (field, value) in ["mean", "sd"].into_iter().zip(moments) {
            quantity::SPAN.check(field, value)?;
            if !(value > 0.0 && value <= bound) {
                return Err(InvalidInput::new(
                    field,
                    format!("{value:?}"),
                    format!("it is above 0 s and at most the bound of the jitter, {bound:?} s"),
                    "Give a larger jitter, or a smaller value.",
                ));
            }
        }
        let [mean, sd] = moments;
        if sd < 1e-3 * mean {
            return Err(InvalidInput::new(
                "sd",
                format!("{sd:?}"),
                "a standard deviation of a jitter is at least a thousandth of its mean",
                "Add the mean to the delay of the network, and leave the rest out.",
            ));
        }
        Ok(())
    }
}

impl GilbertElliott {
    /// Checks the four probabilities of the network's bursts.
    fn check(&self) -> Result<()> {
        let values = [
            ("to_bad", self.to_bad),
            ("to_good", self.to_good),
            ("loss_good", self.loss_good),
            ("loss_bad", self.loss_bad),
        ];
        values.into_iter().try_for_each(|(field, value)| quantity::PROBABILITY.check(field, value).map(drop))
    }
}

impl RateLimit {
    /// The longest queue, packets.
    pub const LONGEST_QUEUE: usize = 1_000_000;

    /// Checks rate and queue of the network's link.
    fn check(&self) -> Result<()> {
        quantity::BIT_RATE.check("bits_per_second", self.bits_per_second)?;
        if self.queue > Self::LONGEST_QUEUE {
            return Err(InvalidInput::new(
                "queue",
                self.queue,
                format!("a queue holds at most {} packets", Self::LONGEST_QUEUE),
                "Give a shorter queue.",
            ));
        }
        Ok(())
    }
}

impl Blackout {
    /// Checks the times of the network's blackouts.
    fn check(&self) -> Result<()> {
        quantity::SPAN_OF_TRIAL.check("start", self.start)?;
        quantity::SPAN_OF_TRIAL.check("duration", self.duration)?;
        let Some(period) = self.period else { return Ok(()) };
        quantity::SPAN_OF_TRIAL.check("period", period)?;
        if !(period > 0.0 && period >= self.duration) {
            return Err(InvalidInput::new(
                "period",
                format!("{period:?}"),
                format!("it is at least the duration of a blackout, {:?} s, and above 0", self.duration),
                "Give the time from one beginning to the next, or leave it out for a single blackout.",
            ));
        }
        Ok(())
    }
}
