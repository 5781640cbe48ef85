//! How often the paper's critical stiffness is unsafe in a population of dyads, counted while they are drawn.
//!
//! A map has cells over the ratios of the robots' dampings and masses. The dyads of a cell are drawn, judged and
//! forgotten; what stays is a [`Tally`] of whole numbers, so that tallies of parts add up to that of the whole,
//! bit for bit, in any order.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use crate::criteria::{critical_stiffness, paper_critical_stiffness};
use crate::error::{InvalidInput, Result};
use crate::model::DyadAxis;
use crate::quantity;

/// Bins of the histogram; the last one also counts everything above.
pub const BINS: usize = 512;
/// Each bin ends at this many times the value at which it begins: how exactly a quantile is known.
pub const BIN_RATIO: f64 = 1.02;
/// The paper's stiffness is unsafe if it exceeds the exact one by more than this share; less is rounding.
pub const ROUNDING: f64 = 1e-9;
/// Numbers that are drawn for a dyad, whether it needs them or not.
const DRAWN: u128 = 8;

/// Values with equal ratios between neighbours, or their ends: what a number is drawn from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogRange {
    /// The smallest value.
    pub low: f64,
    /// The largest value.
    pub high: f64,
}

impl LogRange {
    /// The value at a share (0 to 1) of the way, in the logarithm.
    fn at(&self, share: f64) -> f64 {
        self.low * (share * (self.high / self.low).ln()).exp()
    }

    /// One of `count` parts of equal ratio.
    fn part(&self, index: usize, count: usize) -> Self {
        let edge = |index: usize| self.at(index as f64 / count as f64);
        Self { low: edge(index), high: edge(index + 1) }
    }

    /// Refuses a range that is empty, or not of positive numbers.
    fn check(self, field: &str, unit: &str) -> Result<Self> {
        if self.low > 0.0 && self.low <= self.high && self.high.is_finite() {
            return Ok(self);
        }
        Err(InvalidInput::new(
            field,
            format!("({}, {})", self.low, self.high),
            format!("two numbers above 0{unit}, the smaller one first"),
            "Give the smallest and the largest value.",
        ))
    }
}

/// A population of dyads with free handles, over a map of cells.
///
/// Robot 1 is drawn from `mass` and `damping`, and robot 2 by its ratios to robot 1 from those of the cell; all
/// are uniform in the logarithm. Each person adds a mass and a damping, uniform from 0 to the operator's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Population {
    /// Masses of robot 1, kg.
    pub mass: LogRange,
    /// Dampings of robot 1, N·s/m.
    pub damping: LogRange,
    /// Mass of robot 2 divided by that of robot 1, over the whole map.
    pub mass_ratio: LogRange,
    /// Damping of robot 2 divided by that of robot 1, over the whole map.
    pub damping_ratio: LogRange,
    /// Rows and columns of the map: cells over the mass ratio, and over the damping ratio.
    pub cells: [usize; 2],
    /// The largest mass that a person adds, kg.
    pub operator_mass: f64,
    /// The largest damping that a person adds, N·s/m.
    pub operator_damping: f64,
    /// From which all is drawn.
    pub seed: u64,
}

/// What was counted of some dyads of a cell.
#[derive(Debug, Clone, PartialEq)]
pub struct Tally {
    /// Dyads that were judged.
    pub dyads: u64,
    /// Those for which the paper's critical stiffness is above the exact one.
    pub unsafe_dyads: u64,
    /// The largest ratio of the paper's to the exact critical stiffness; 1 without dyads.
    pub largest: f64,
    /// Unsafe dyads by that ratio: bin i begins at [`BIN_RATIO`] to the power of i.
    pub histogram: Vec<u64>,
}

impl Tally {
    /// The tally of no dyad.
    pub fn empty() -> Self {
        Self { dyads: 0, unsafe_dyads: 0, largest: 1.0, histogram: vec![0; BINS] }
    }

    /// Counts a dyad by the ratio of the paper's to the exact critical stiffness.
    fn count(&mut self, ratio: f64) {
        self.dyads += 1;
        if ratio <= 1.0 + ROUNDING {
            return;
        }
        self.unsafe_dyads += 1;
        self.largest = self.largest.max(ratio);
        // an infinite ratio saturates into the last bin
        let bin = (ratio.ln() / BIN_RATIO.ln()) as usize;
        self.histogram[bin.min(BINS - 1)] += 1;
    }
}

impl Population {
    /// Checks that every dyad that can be drawn is one.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if a range is empty, a robot 2 may be out of range, or there are no cells.
    pub fn checked(self) -> Result<Self> {
        let within = |quantity: quantity::Quantity, field: &str, range: LogRange| {
            quantity.check(field, range.low)?;
            quantity.check(field, range.high)
        };
        let product = |a: LogRange, b: LogRange| LogRange { low: a.low * b.low, high: a.high * b.high };
        self.mass.check("mass", " (kg)")?;
        self.damping.check("damping", " (N·s/m)")?;
        self.mass_ratio.check("mass_ratio", "")?;
        self.damping_ratio.check("damping_ratio", "")?;
        within(quantity::MASS, "mass", self.mass)?;
        within(quantity::DAMPING, "damping", self.damping)?;
        within(quantity::MASS, "mass_ratio (mass of robot 2)", product(self.mass, self.mass_ratio))?;
        let second = product(self.damping, self.damping_ratio);
        within(quantity::DAMPING, "damping_ratio (damping of robot 2)", second)?;
        quantity::ADDED_MASS.check("operator_mass", self.operator_mass)?;
        quantity::OPERATOR_DAMPING.check("operator_damping", self.operator_damping)?;
        if self.cells.contains(&0) {
            return Err(InvalidInput::new(
                "cells",
                format!("{:?}", self.cells),
                "1 or more cells in each direction",
                "Give the number of cells over the mass ratio and over the damping ratio.",
            ));
        }
        Ok(self)
    }

    /// The ratios of masses and of dampings in one cell, counted row by row over the mass ratio.
    pub fn cell(&self, cell: usize) -> [LogRange; 2] {
        let [rows, columns] = self.cells;
        [self.mass_ratio.part(cell / columns, rows), self.damping_ratio.part(cell % columns, columns)]
    }

    /// Draws and judges the dyads `first` to `first + count` of a cell.
    ///
    /// A dyad depends on the seed, its cell and its number only.
    ///
    /// # Errors
    ///
    /// [`InvalidInput`] if a dyad is out of range, which [`Population::checked`] excludes.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::population::{LogRange, Population};
    /// let ratio = LogRange { low: 0.05, high: 20.0 };
    /// let population = Population {
    ///     mass: LogRange { low: 0.5, high: 5.0 },
    ///     damping: LogRange { low: 1.0, high: 20.0 },
    ///     mass_ratio: ratio,
    ///     damping_ratio: ratio,
    ///     cells: [1, 1],
    ///     operator_mass: 0.0,
    ///     operator_damping: 0.0,
    ///     seed: 1,
    /// }
    /// .checked()?;
    /// let tally = population.tally(0, 0, 1000)?;
    /// assert_eq!(tally.dyads, 1000);
    /// assert!(tally.unsafe_dyads > 0 && tally.unsafe_dyads < 1000);
    /// # Ok::<(), telespring::InvalidInput>(())
    /// ```
    pub fn tally(&self, cell: usize, first: u64, count: u64) -> Result<Tally> {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        random.set_stream(cell as u64);
        // words of 32 bits, two for each number
        random.set_word_pos(2 * DRAWN * u128::from(first));
        let ratios = self.cell(cell);
        let mut tally = Tally::empty();
        for _ in 0..count {
            let axis = self.draw(&ratios, &mut random)?;
            tally.count(paper_critical_stiffness(&axis)? / critical_stiffness(&axis));
        }
        Ok(tally)
    }

    /// Draws one dyad.
    fn draw(&self, [mass_ratio, damping_ratio]: &[LogRange; 2], random: &mut ChaCha8Rng) -> Result<DyadAxis> {
        // 53 bits, as many as a double has
        let mut share = || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
        let (m1, b1) = (self.mass.at(share()), self.damping.at(share()));
        let (m2, b2) = (m1 * mass_ratio.at(share()), b1 * damping_ratio.at(share()));
        let person = [share(), share(), share(), share()];
        let [held1, held2] = [person[0], person[1]].map(|share| share * self.operator_mass);
        let [damped1, damped2] = [person[2], person[3]].map(|share| share * self.operator_damping);
        DyadAxis::new(m1 + held1, b1 + damped1, m2 + held2, b2 + damped2)
    }
}
