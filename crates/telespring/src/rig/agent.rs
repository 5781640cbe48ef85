//! Who moves the arms.
//!
//! A blurred agent sees N spots. Each is born on the target, moves away from it with a velocity of its
//! own (relative to the target, normal per axis), lives for one lifetime L and is then born again with a
//! new velocity. Births are staggered evenly: at t = 0 spot i of N has lived i/N of its life, and from
//! then on one spot is renewed every L/N. The cloud is thus as wide at the start of a trial as at its end.

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::random::{Stream, generator};
use super::target::Aim;
use super::{Agent, Spots};

/// What an agent knows at a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observation {
    /// s since the start of the trial.
    pub time: f64,
    /// Of the own handle, as the sensor shows it, m.
    pub position: [f64; 2],
    /// Of the own handle, m/s.
    pub velocity: [f64; 2],
    /// Where the target is, m.
    pub target: [f64; 2],
}

#[derive(Debug, Clone, Copy)]
struct Spot {
    /// s; before 0 for those that lived before the trial.
    birth: f64,
    /// Relative to the target, m/s.
    velocity: [f64; 2],
}

/// The cloud of spots in the course of a trial.
#[derive(Debug, Clone)]
pub(crate) struct Cloud {
    scale: Spots,
    random: ChaCha8Rng,
    spots: Vec<Spot>,
    /// How many have been renewed since the start.
    renewals: u64,
    /// Of all spots: mean velocity, and mean of velocity times birth.
    mean: [[f64; 2]; 2],
}

impl Cloud {
    fn new(scale: Spots, random: ChaCha8Rng) -> Self {
        let mut cloud =
            Self { scale, random, spots: Vec::with_capacity(scale.count), renewals: 0, mean: [[0.0; 2]; 2] };
        for index in 0..scale.count {
            let birth = -scale.lifetime * (index as f64 / scale.count as f64);
            let velocity = cloud.draw();
            cloud.spots.push(Spot { birth, velocity });
        }
        cloud.sum();
        cloud
    }

    fn draw(&mut self) -> [f64; 2] {
        [(); 2].map(|()| {
            let normal: f64 = StandardNormal.sample(&mut self.random);
            self.scale.velocity * normal
        })
    }

    fn sum(&mut self) {
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

    /// Mean of the spots relative to the target at `time`, which may not go back, m.
    pub(crate) fn offset(&mut self, time: f64) -> [f64; 2] {
        let count = self.scale.count as u64;
        let mut renewed = false;
        loop {
            // renewal j comes at j·L/N: spot N−1 is the oldest at the start
            let next = self.renewals + 1;
            let birth = self.scale.lifetime * (next as f64 / count as f64);
            // a birth at a tick belongs to that tick, though the products round apart
            if birth > time * (1.0 + 4.0 * f64::EPSILON) {
                break;
            }
            let oldest = (count - 1 - self.renewals % count) as usize;
            let velocity = self.draw();
            self.spots[oldest] = Spot { birth, velocity };
            self.renewals = next;
            renewed = true;
        }
        if renewed {
            self.sum();
        }
        [0, 1].map(|axis| time * self.mean[0][axis] - self.mean[1][axis])
    }
}

/// An agent in the course of a trial.
#[derive(Debug, Clone)]
pub(crate) enum Mover {
    Skilled { stiffness: f64, damping: f64 },
    Blurred { stiffness: f64, cloud: Box<Cloud> },
    External,
}

impl Mover {
    pub(crate) fn new(agent: &Agent, seed: u64, side: usize) -> Self {
        match *agent {
            Agent::Skilled { stiffness, damping } => Self::Skilled { stiffness, damping },
            Agent::Blurred { stiffness, spots } => {
                let cloud = Box::new(Cloud::new(spots, generator(seed, Stream::Agent(side))));
                Self::Blurred { stiffness, cloud }
            }
            Agent::External => Self::External,
        }
    }

    /// Where the agent takes the target to be, m, and its force, N; of an external agent no force.
    pub(crate) fn act(&mut self, seen: &Observation, target: &Aim) -> ([f64; 2], [f64; 2]) {
        match self {
            Self::Skilled { stiffness, damping } => {
                let force = [0, 1].map(|axis| {
                    *stiffness * (target.position[axis] - seen.position[axis])
                        + *damping * (target.velocity[axis] - seen.velocity[axis])
                });
                (target.position, force)
            }
            Self::Blurred { stiffness, cloud } => {
                let offset = cloud.offset(seen.time);
                let aim = [0, 1].map(|axis| target.position[axis] + offset[axis]);
                (aim, [0, 1].map(|axis| *stiffness * (aim[axis] - seen.position[axis])))
            }
            Self::External => (target.position, [0.0; 2]),
        }
    }
}
