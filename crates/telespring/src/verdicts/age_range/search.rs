//! The stiffness up to which the rule is proven: steps upwards, each by branch and bound over frequencies, stiffnesses
//! and operators.
//!
//! The rule need not be monotone in the stiffness, so that no bisection finds its first failure. Each step proves f > 0
//! for all stiffnesses from the last bound to the next one, at one κ, and the next one comes closer until f ≤ 0 is met.

use super::rule::{Cell, FREQUENCY, Pair, Rule, STIFFNESS, Sample, Weights};
use crate::verdicts::ranges::SideRange;

/// The outcome of one step.
pub(super) enum Step {
    /// The rule holds for all stiffnesses, frequencies and operators of the step.
    Proven,
    /// It fails at this κ.
    Fails(Failure),
    /// It is not decided near this pair.
    Open(Pair),
}

/// A frequency (rad/s), a stiffness (N/m) and a pair of operators at which f is not positive.
#[derive(Debug, Clone, Copy)]
pub(super) struct Failure {
    pub frequency: f64,
    pub stiffness: f64,
    pub pair: Pair,
}

/// The stiffness bound of the rule.
#[derive(Debug, Clone, Copy)]
pub(super) struct Proven {
    /// The rule is proven for every smaller stiffness, N/m.
    pub stiffness: f64,
    /// A stiffness (N/m) at which the rule fails for one pair of operators, with that pair.
    pub failing: Option<(f64, Pair)>,
}

/// The bound is within this part of the first failure of the rule.
const ACCURACY: f64 = 2e-5;
const ACCURACY_OVER_RANGE: f64 = 1e-2;
/// The most cells of one step, and of a search.
const MOST_CELLS_OF_STEP: usize = 20_000;
const MOST_CELLS: usize = 300_000;
/// κ is chosen at this many frequencies over this ratio of them.
const SAMPLES: usize = 160;
const SPREAD: f64 = 1e4;
/// How often κ is chosen anew for a step.
const TRIES: usize = 3;
/// Stiffer springs are not examined, N/m.
const STIFFEST: f64 = 1e12;

/// The middle of a range, by its logarithm where the ends are decades apart.
pub(super) fn middle((low, high): (f64, f64)) -> f64 {
    if high <= 4.0 * low {
        0.5 * (low + high)
    } else if low > 0.0 {
        low.sqrt() * high.sqrt()
    } else {
        0.125 * high
    }
}

/// Both halves of a cell along a direction.
pub(super) fn halves(cell: &Cell, direction: usize) -> [Cell; 2] {
    let mut parts = [*cell; 2];
    let range = cell.0[direction];
    let at = if direction < 2 { middle(range) } else { 0.5 * (range.0 + range.1) };
    parts[0].0[direction].1 = at;
    parts[1].0[direction].0 = at;
    parts
}

impl Rule {
    /// The pair in the middle of all operators.
    pub(super) fn middle_pair(&self) -> Pair {
        Cell::new((0.0, 0.0), (0.0, 0.0), &self.sides).middle_pair()
    }

    /// Whether there is no range of operators.
    fn is_one_pair(&self) -> bool {
        Cell::new((0.0, 0.0), (0.0, 0.0), &self.sides).is_one_pair()
    }

    /// κ at which tier 2's rule for these ages follows from the one here.
    fn reference_ratio(&self, sides: &Pair) -> f64 {
        let [j1, j2] = self.reach;
        let floor = 1e-3 * j1.max(j2).max(self.own_reach);
        (j2.max(floor) * sides[1][1]) / (j1.max(floor) * sides[0][1])
    }

    /// What f depends on for one pair at a stiffness (N/m), at frequencies spread over all that matter and at given ones.
    fn samples(&self, stiffness: f64, pair: &Pair, highest: f64, given: &[f64]) -> Vec<Sample> {
        let slowest = pair.iter().map(|[mass, damping, _]| damping / mass).fold(highest, f64::min);
        let step = SPREAD.ln() / (SAMPLES - 1) as f64;
        let low = slowest / 1e3;
        let count = ((highest / low).ln() / step).ceil() as usize;
        (0..=count)
            .map(|i| low * (step * i as f64).exp())
            .chain(given.iter().copied())
            .map(|frequency| self.sample(frequency, stiffness, pair))
            .collect()
    }

    /// The weights that suit one pair best at a stiffness (N/m), and the least f/|D|² with them: ln κ by golden section,
    /// since the gain is convex in it.
    fn best_weights(&self, stiffness: f64, pair: &Pair, given: &[f64]) -> (Weights, f64) {
        let start = self.reference_ratio(pair).ln();
        let at = |log: f64| Weights::new(self, log.exp());
        let Some(highest) = self.highest_frequency(stiffness, &at(start)) else {
            return (at(start), f64::INFINITY);
        };
        let samples = self.samples(stiffness, pair, highest, given);
        let least = |log: f64| {
            let weights = at(log);
            samples.iter().map(|sample| sample.relative(&weights)).fold(f64::INFINITY, f64::min)
        };
        let golden = 0.5 * (5f64.sqrt() - 1.0);
        let (mut low, mut high) = (start - 6.0, start + 6.0);
        let (mut left, mut right) = (high - golden * (high - low), low + golden * (high - low));
        let (mut at_left, mut at_right) = (least(left), least(right));
        while high - low > 1e-4 {
            if at_left > at_right {
                (high, right, at_right) = (right, left, at_left);
                left = high - golden * (high - low);
                at_left = least(left);
            } else {
                (low, left, at_left) = (left, right, at_right);
                right = low + golden * (high - low);
                at_right = least(right);
            }
        }
        let best = 0.5 * (low + high);
        // Where nothing distinguishes the ratios the one of tier 2 is kept.
        let best = if least(best) > least(start) { best } else { start };
        (at(best), least(best))
    }

    /// Whether the rule holds for all stiffnesses of a range (N/m), all operators and all frequencies from `slowest` on.
    fn step(&self, stiffness: (f64, f64), slowest: f64, weights: &Weights, examined: &mut usize) -> Step {
        if !self.is_one_pair() {
            return self.step_over_range(stiffness, slowest, weights, examined);
        }
        let Some(highest) = self.highest_frequency(stiffness.1, weights) else {
            return Step::Open(self.middle_pair());
        };
        let start = *examined;
        let mut waiting = vec![Cell::new((slowest, highest), stiffness, &self.sides)];
        while let Some(cell) = waiting.pop() {
            *examined += 1;
            let enclosed = self.least(&cell, weights);
            if enclosed.least > 0.0 {
                continue;
            }
            let pair = cell.middle_pair();
            let (range, springs) = (cell.0[FREQUENCY], cell.0[STIFFNESS]);
            let failure = Failure { frequency: middle(range), stiffness: middle(springs), pair };
            if self.sample(failure.frequency, failure.stiffness, &pair).relative(weights) <= 0.0 {
                return Step::Fails(failure);
            }
            if *examined - start > MOST_CELLS_OF_STEP || range.1 - range.0 <= 1e-11 * range.1 {
                return Step::Open(pair);
            }
            waiting.extend(halves(&cell, enclosed.widest));
        }
        Step::Proven
    }

    /// The stiffness (N/m) up to which the rule holds at every frequency.
    pub(super) fn proven_stiffness(&self) -> Proven {
        let mut examined = 0;
        let Some((mut proven, mut weights)) = self.soft_stiffness(&mut examined) else {
            return Proven { stiffness: 0.0, failing: None };
        };
        let mut failing = self.failing_alone();
        // The lowest stiffness up to which a step over a range was left open.
        let mut open = f64::INFINITY;
        // Frequencies at which f came out negative: the next κ is chosen with them.
        let mut critical = Vec::new();
        let mut factor: f64 = 2.0;
        let accuracy = if self.is_one_pair() { ACCURACY } else { ACCURACY_OVER_RANGE };
        while factor > 1.0 + accuracy && examined < MOST_CELLS && proven < STIFFEST {
            let next = proven * factor;
            if next >= open {
                factor = factor.sqrt();
                continue;
            }
            // No search is needed where the pair that failed last fails alone.
            if let Some((_, pair)) = failing {
                let (own, least) = self.best_weights(next, &pair, &critical);
                if least <= 0.0 {
                    failing = failing.map(|(before, pair)| (before.min(next), pair));
                    factor = factor.sqrt();
                    continue;
                }
                weights = own;
            }
            let mut outcome = self.step((proven, next), 0.0, &weights, &mut examined);
            for _ in 0..TRIES {
                let pair = match &outcome {
                    Step::Proven => break,
                    // Cells without end near a failure: another κ does not change that.
                    Step::Open(_) if !self.is_one_pair() => {
                        open = next;
                        break;
                    }
                    Step::Open(pair) => *pair,
                    Step::Fails(at) => {
                        critical.extend([0.99, 1.0, 1.01].map(|factor| factor * at.frequency));
                        let (_, least) = self.best_weights(at.stiffness, &at.pair, &critical);
                        if least <= 0.0 {
                            if failing.is_none_or(|(before, _)| at.stiffness < before) {
                                failing = Some((at.stiffness, at.pair));
                            }
                            break;
                        }
                        at.pair
                    }
                };
                weights = self.best_weights(next, &pair, &critical).0;
                outcome = self.step((proven, next), 0.0, &weights, &mut examined);
            }
            if matches!(outcome, Step::Proven) {
                proven = next;
            } else {
                factor = factor.sqrt();
            }
        }
        Proven { stiffness: proven, failing }
    }

    /// The lowest stiffness (N/m) at which the rule fails for one of the pairs that are often the worst; `None` without a range.
    fn failing_alone(&self) -> Option<(f64, Pair)> {
        if self.is_one_pair() {
            return None;
        }
        let weakest = self.sides.map(|side| [side.mass.1, side.damping.0, side.stiffness.0]);
        let alone = |pair: Pair| {
            let point = |value: f64| (value, value);
            let sides = pair.map(|[mass, damping, stiffness]| SideRange {
                mass: point(mass),
                damping: point(damping),
                stiffness: point(stiffness),
            });
            Self { sides, ..*self }.proven_stiffness().failing
        };
        let found = [weakest, self.middle_pair()].into_iter().filter_map(alone);
        found.reduce(|least, next| if next.0 < least.0 { next } else { least })
    }

    /// A stiffness (N/m) below which the rule is proven by the loss of both sides, and the weights for it.
    ///
    /// Without a coupling damper this is tier 2's rule for the same ages, solved for k. With one it holds at the lowest
    /// frequencies, and the search proves the others.
    fn soft_stiffness(&self, examined: &mut usize) -> Option<(f64, Weights)> {
        let weakest = self.sides.map(|side| [side.mass.1, side.damping.0, side.stiffness.0]);
        let [b1, b2] = [weakest[0][1], weakest[1][1]];
        if b1 == 0.0 || b2 == 0.0 {
            return None;
        }
        let weights = Weights::new(self, self.reference_ratio(&weakest));
        let (ratio, [a1, a2]) = (weights.ratio, weights.alpha);
        let u = (b1 / b2).sqrt();
        let middle = ((1.0 / ratio + 1.0) / (a1 + a2)).sqrt();
        let mut soft = (-24..=24)
            .map(|i| {
                let t = middle * (0.25 * f64::from(i)).exp2();
                let first = self.own_delay + 0.5 * (self.round_trip * u + t * a1 + 1.0 / (t * ratio));
                let second = self.own_delay + 0.5 * (self.round_trip / u + t * a2 + 1.0 / t);
                (b1 / first).min(b2 / second)
            })
            .fold(0.0, f64::max)
            * (1.0 - 1e-9);
        let c = self.coupling_damping;
        if c == 0.0 {
            return Some((soft, weights));
        }
        // |C| ≤ √2 k up to ω = k/c.
        soft *= std::f64::consts::FRAC_1_SQRT_2;
        for _ in 0..12 {
            let chosen = self.best_weights(soft, &self.middle_pair(), &[]).0;
            for weights in [weights, chosen] {
                if self.is_lossy_enough(soft, &weights)
                    && matches!(self.step((0.0, soft), soft / c, &weights, examined), Step::Proven)
                {
                    return Some((soft, weights));
                }
            }
            soft *= 0.25;
        }
        None
    }

    /// Whether the loss of both sides proves the rule for every stiffness up to this one (N/m) and ω ≤ k/c.
    fn is_lossy_enough(&self, stiffness: f64, weights: &Weights) -> bool {
        let [b1, b2] = self.sides.map(|side| side.damping.0);
        let (ratio, [a1, a2]) = (weights.ratio, weights.alpha);
        let size = std::f64::consts::SQRT_2 * stiffness;
        let u = (b1 / b2).sqrt();
        let middle = ((1.0 / ratio + 1.0) / (a1 + a2)).sqrt();
        (-40..=40).any(|i| {
            let t = middle * (0.5 * f64::from(i)).exp2();
            b1 > 0.5 * (stiffness * self.round_trip * u + size * (t * a1 + 1.0 / (t * ratio)))
                && b2 > 0.5 * (stiffness * self.round_trip / u + size * (t * a2 + 1.0 / t))
        })
    }
}
