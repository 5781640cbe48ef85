//! Agents that move the arms: skilled, blurred, or external.
//!
//! A blurred agent sees N spots. Each spot starts on the target, moves away with its own velocity (relative
//! to the target, normally distributed per axis), lives for a lifetime L and then restarts with a new
//! velocity. Starts are staggered evenly: at t = 0 spot i of N has the age i L/N, and then one spot
//! restarts every L/N. The cloud is thus as wide at the start of a trial as at its end.

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::random::{RandomStream, random_generator};
use super::target::TargetPoint;
use super::{Agent, Spots};

/// What an agent observes at a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observation {
    /// The time since the start of the trial, s.
    pub time: f64,
    /// The position of its handle as measured by the sensor, m.
    pub position: [f64; 2],
    /// The velocity of its handle, m/s.
    pub velocity: [f64; 2],
    /// The position of the target, m.
    pub target: [f64; 2],
}

#[derive(Debug, Clone, Copy)]
struct Spot {
    /// The start time, s; negative for spots that started before the trial.
    birth: f64,
    /// The velocity relative to the target, m/s.
    velocity: [f64; 2],
}

/// The cloud of spots during a trial.
#[derive(Debug, Clone)]
pub(crate) struct SpotCloud {
    scale: Spots,
    random: ChaCha8Rng,
    spots: Vec<Spot>,
    /// The number of restarts since the start of the trial.
    renewals: u64,
    /// The mean velocity of all spots, and the mean of velocity times start time.
    mean: [[f64; 2]; 2],
}

impl SpotCloud {
    /// An agent's cloud of spots at the start of a trial.
    fn new(scale: Spots, random: ChaCha8Rng) -> Self {
        let mut cloud =
            Self { scale, random, spots: Vec::with_capacity(scale.count), renewals: 0, mean: [[0.0; 2]; 2] };
        for index in 0..scale.count {
            let birth = -scale.lifetime * (index as f64 / scale.count as f64);
            let velocity = cloud.draw_spot_velocity();
            cloud.spots.push(Spot { birth, velocity });
        }
        cloud.update_cloud_mean();
        cloud
    }

    /// Draws the random velocity of one of an agent's spots relative to the target.
    fn draw_spot_velocity(&mut self) -> [f64; 2] {
        [(); 2].map(|()| {
            let normal: f64 = StandardNormal.sample(&mut self.random);
            self.scale.velocity * normal
        })
    }

    /// Recomputes the mean velocity of the agent's spots and the mean of velocity times start time.
    fn update_cloud_mean(&mut self) {
        let share = 1.0 / self.scale.count as f64;
        let mut mean = [[0.0; 2]; 2];
        for spot in &self.spots {
            for axis in 0..2 {
                mean[0][axis] += share * spot.velocity[axis];
                mean[1][axis] += share * spot.velocity[axis] * spot.birth;
            }
        }
        self.mean = mean;
    }

    /// The mean position of the agent's spots relative to the target at `time`, m; `time` must not decrease.
    pub(crate) fn mean_offset(&mut self, time: f64) -> [f64; 2] {
        let count = self.scale.count as u64;
        let mut renewed = false;
        loop {
            // Restart j happens at j·L/N: spot N−1 is the oldest at the start.
            let next = self.renewals + 1;
            let birth = self.scale.lifetime * (next as f64 / count as f64);
            // A restart on a tick belongs to that tick, although the products round differently.
            if birth > time * (1.0 + 4.0 * f64::EPSILON) {
                break;
            }
            let oldest = (count - 1 - self.renewals % count) as usize;
            let velocity = self.draw_spot_velocity();
            self.spots[oldest] = Spot { birth, velocity };
            self.renewals = next;
            renewed = true;
        }
        if renewed {
            self.update_cloud_mean();
        }
        [0, 1].map(|axis| time * self.mean[0][axis] - self.mean[1][axis])
    }
}

/// The state of an agent during a trial.
#[derive(Debug, Clone)]
pub(crate) enum AgentState {
    Skilled { stiffness: f64, damping: f64 },
    Blurred { stiffness: f64, cloud: Box<SpotCloud> },
    External,
}

impl AgentState {
    /// The state of an agent at the start of a trial.
    pub(crate) fn new(agent: &Agent, seed: u64, side: usize) -> Self {
        match *agent {
            Agent::Skilled { stiffness, damping } => Self::Skilled { stiffness, damping },
            Agent::Blurred { stiffness, spots } => {
                let cloud =
                    Box::new(SpotCloud::new(spots, random_generator(seed, RandomStream::Agent(side))));
                Self::Blurred { stiffness, cloud }
            }
            Agent::External => Self::External,
        }
    }

    /// The point the agent aims at, m, and its force, N; an external agent's force is zero here.
    pub(crate) fn aim_and_force(&mut self, seen: &Observation, target: &TargetPoint) -> ([f64; 2], [f64; 2]) {
        match self {
            Self::Skilled { stiffness, damping } => {
                let force = [0, 1].map(|axis| {
                    *stiffness * (target.position[axis] - seen.position[axis])
                        + *damping * (target.velocity[axis] - seen.velocity[axis])
                });
                (target.position, force)
            }
            Self::Blurred { stiffness, cloud } => {
                let offset = cloud.mean_offset(seen.time);
                let aim = [0, 1].map(|axis| target.position[axis] + offset[axis]);
                (aim, [0, 1].map(|axis| *stiffness * (aim[axis] - seen.position[axis])))
            }
            Self::External => (target.position, [0.0; 2]),
        }
    }
}
