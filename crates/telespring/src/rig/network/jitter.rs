//! How the additional delay of a packet is distributed.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Gamma, LogNormal, Normal};

use super::trace::special;

/// How the additional delay of a network's packets is distributed between 0 and its bound.
///
/// Mean and standard deviation are those of the whole distribution; delays below 0 and above the bound are drawn
/// again, so that the delays that occur have another mean and a smaller standard deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum JitterDistribution {
    /// Every delay from 0 to the bound is equally likely.
    Uniform,
    /// A normal distribution.
    Normal {
        /// s.
        mean: f64,
        /// The standard deviation, s.
        sd: f64,
    },
    /// A gamma distribution: the sum of many exponential waits.
    Gamma {
        /// s.
        mean: f64,
        /// The standard deviation, s.
        sd: f64,
    },
    /// A log-normal distribution: its tail is the longest.
    LogNormal {
        /// s.
        mean: f64,
        /// The standard deviation, s.
        sd: f64,
    },
}

impl JitterDistribution {
    /// Mean and standard deviation of the jitter before it is cut at its bound; `None` if it is uniform.
    pub fn moments(&self) -> Option<[f64; 2]> {
        match *self {
            Self::Uniform => None,
            Self::Normal { mean, sd } | Self::Gamma { mean, sd } | Self::LogNormal { mean, sd } => {
                Some([mean, sd])
            }
        }
    }

    /// The probability that the additional delay is at most `delay`, s, where `bound` is the largest, s.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::rig::JitterDistribution;
    ///
    /// let symmetric = JitterDistribution::Normal { mean: 0.005, sd: 0.002 };
    /// assert!((symmetric.cumulative(0.005, 0.010) - 0.5).abs() < 1e-12);
    /// ```
    pub fn cumulative(&self, delay: f64, bound: f64) -> f64 {
        if delay >= bound {
            return 1.0;
        }
        if delay < 0.0 {
            return 0.0;
        }
        ((self.uncut(delay, bound) - self.uncut(0.0, bound)) / self.mass(bound)).clamp(0.0, 1.0)
    }

    /// The share of the jitter's whole distribution between 0 and the bound.
    pub(super) fn mass(&self, bound: f64) -> f64 {
        self.uncut(bound, bound) - self.uncut(0.0, bound)
    }

    /// The logarithm of the jitter's density at x above 0 before it is cut.
    pub(super) fn ln_density(&self, x: f64, bound: f64) -> f64 {
        let ln_normal = |z: f64| -0.5 * (z * z + std::f64::consts::TAU.ln());
        match *self {
            Self::Uniform => -bound.ln(),
            Self::Normal { mean, sd } => ln_normal((x - mean) / sd) - sd.ln(),
            Self::Gamma { mean, sd } => {
                let (shape, scale) = ((mean / sd).powi(2), sd * sd / mean);
                (shape - 1.0) * (x / scale).ln() - x / scale - special::ln_gamma(shape) - scale.ln()
            }
            Self::LogNormal { mean, sd } => {
                let [middle, spread] = log_moments(mean, sd);
                ln_normal((x.ln() - middle) / spread) - spread.ln() - x.ln()
            }
        }
    }

    /// The distribution function of the jitter before it is cut.
    fn uncut(&self, x: f64, bound: f64) -> f64 {
        match *self {
            Self::Uniform => x / bound,
            Self::Normal { mean, sd } => special::normal_cumulative((x - mean) / sd),
            Self::Gamma { mean, sd } => special::gamma_cumulative((mean / sd).powi(2), x * mean / (sd * sd)),
            Self::LogNormal { .. } if x <= 0.0 => 0.0,
            Self::LogNormal { mean, sd } => {
                let [middle, spread] = log_moments(mean, sd);
                special::normal_cumulative((x.ln() - middle) / spread)
            }
        }
    }
}

/// Mean and standard deviation of the logarithm of a log-normal jitter.
fn log_moments(mean: f64, sd: f64) -> [f64; 2] {
    let variance = (sd / mean).powi(2).ln_1p();
    [mean.ln() - 0.5 * variance, variance.sqrt()]
}

/// Draws additional delays.
#[derive(Debug, Clone)]
pub(super) enum JitterSource {
    Uniform,
    Normal(Normal<f64>),
    Gamma(Gamma<f64>),
    LogNormal(LogNormal<f64>),
}

impl JitterSource {
    /// The source of a checked jitter distribution.
    pub fn new(distribution: JitterDistribution) -> Self {
        let checked = "mean and standard deviation of a jitter are above 0";
        match distribution {
            JitterDistribution::Uniform => Self::Uniform,
            JitterDistribution::Normal { mean, sd } => Self::Normal(Normal::new(mean, sd).expect(checked)),
            JitterDistribution::Gamma { mean, sd } => {
                Self::Gamma(Gamma::new((mean / sd).powi(2), sd * sd / mean).expect(checked))
            }
            JitterDistribution::LogNormal { mean, sd } => {
                Self::LogNormal(LogNormal::from_mean_cv(mean, sd / mean).expect(checked))
            }
        }
    }

    /// An additional delay of the jitter with this bound, s.
    pub fn draw(&self, bound: f64, random: &mut ChaCha8Rng) -> f64 {
        if bound == 0.0 {
            return 0.0;
        }
        // At least a third of the draws lies inside: the check demands mean and deviation up to the bound.
        loop {
            let delay = match self {
                Self::Uniform => bound * random.random::<f64>(),
                Self::Normal(normal) => normal.sample(random),
                Self::Gamma(gamma) => gamma.sample(random),
                Self::LogNormal(log_normal) => log_normal.sample(random),
            };
            if (0.0..=bound).contains(&delay) {
                return delay;
            }
        }
    }
}
