//! A network that keeps the ages in their range and makes the motion grow: the other side of the bound.
//!
//! The attack is greedy. At every step it lets each side play, among the samples that the ages and the order allow, the one
//! whose force gives the side's motion most power, a little ahead of time. The motion is exact between steps. The search
//! takes several leads and seeded starts; a stiffness at which the motion's extent keeps growing is a
//! proof by example that it is not safe, up to the rounding of the simulation.

use crate::model::DyadAxis;

/// What the attacked controllers do.
#[derive(Debug, Clone, Copy)]
pub(super) struct Controllers {
    /// The sample period, s; 0 for continuous controllers.
    pub period: f64,
    /// From reading the samples to applying the force, s.
    pub computing_time: f64,
}

/// The ages of the samples at the moment they are chosen that each side may use, s.
pub(super) type Ages = [(f64, f64); 2];

/// Steps in the shorter range of ages, and in a radian of the fastest motion, under continuous controllers.
const STEPS_OF_RANGE: f64 = 24.0;
const STEPS_OF_RADIAN: f64 = 16.0;
/// Windows in which the motion must keep growing, after as many to settle. A window is longer than the ages.
const WINDOWS: i64 = 16;
/// The smallest growth of the motion's extent from the first to the last of these windows.
const GROWTH: f64 = 1.25;
/// The leads tried, as parts of the longer range of ages.
const LEADS: [f64; 5] = [0.0, 0.15, 0.3, 0.5, 0.8];
/// The stiffness is found to this part.
const ACCURACY: f64 = 2e-3;
/// The most samples among which one is chosen.
const MOST_CHOICES: i64 = 60;
/// The most samples kept.
const MOST_SAMPLES: usize = 200_000;

/// Numbers from 0 to 1, seeded.
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> f64 {
        // SplitMix64.
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// The motion of one side over a time under a constant force: its state follows a matrix.
#[derive(Debug, Clone, Copy)]
struct Motion {
    free: [[f64; 2]; 2],
    forced: [f64; 2],
}

impl Motion {
    /// A side of mass m, damping b and stiffness k to the ground over a time (s).
    fn new([m, b, k]: [f64; 3], time: f64) -> Self {
        // Half steps until the series converges fast, then doubled.
        let size = time * (b / m + (k / m).sqrt() + 1.0 / (1.0 + time));
        let halvings = size.log2().ceil().max(0.0) as i32 + 4;
        let t = time * (-f64::from(halvings)).exp2();
        let a = [[0.0, 1.0], [-k / m, -b / m]];
        let product = |x: [[f64; 2]; 2], y: [[f64; 2]; 2]| {
            [0, 1].map(|i| [0, 1].map(|j| x[i][0] * y[0][j] + x[i][1] * y[1][j]))
        };
        // free = Σ (a t)ⁿ/n!, integral = Σ aⁿ tⁿ⁺¹/(n + 1)!
        let mut term = [[1.0, 0.0], [0.0, 1.0]];
        let (mut free, mut integral) = (term, [[t, 0.0], [0.0, t]]);
        for n in 1..14 {
            term = product(term, a).map(|row| row.map(|x| x * t / f64::from(n)));
            for i in 0..2 {
                for j in 0..2 {
                    free[i][j] += term[i][j];
                    integral[i][j] += term[i][j] * t / f64::from(n + 1);
                }
            }
        }
        for _ in 0..halvings {
            let more = product(free, integral);
            integral = [0, 1].map(|i| [0, 1].map(|j| integral[i][j] + more[i][j]));
            free = product(free, free);
        }
        Self { free, forced: [integral[0][1] / m, integral[1][1] / m] }
    }

    fn step(&self, [x, v]: [f64; 2], force: f64) -> [f64; 2] {
        [0, 1].map(|i| self.free[i][0] * x + self.free[i][1] * v + self.forced[i] * force)
    }
}

/// One simulated attack at one stiffness.
struct Attack {
    axis: DyadAxis,
    stiffness: f64,
    sampled: bool,
    /// Each side before and after the new force acts in a step.
    motions: [[Motion; 2]; 2],
    step: f64,
    /// The ages in steps that each side may use.
    ages: [(usize, usize); 2],
}

impl Attack {
    /// The attack at a stiffness (N/m); `None` if no sample has an age in the range.
    fn new(axis: &DyadAxis, ages: &Ages, controllers: &Controllers, stiffness: f64) -> Option<Self> {
        let sampled = controllers.period > 0.0;
        let c = axis.coupling_damping;
        let step = if sampled {
            controllers.period
        } else {
            let fastest = axis
                .sides
                .iter()
                .map(|side| {
                    ((2.0 * stiffness + side.ground_stiffness) / side.mass).sqrt()
                        + (side.damping + c) / side.mass
                })
                .fold(0.0, f64::max);
            let width = ages.iter().map(|(least, most)| most - least).filter(|&width| width > 0.0);
            width.fold(f64::INFINITY, f64::min).min(STEPS_OF_RANGE / (STEPS_OF_RADIAN * fastest))
                / STEPS_OF_RANGE
        };
        // A sample that is held over a step ages by it.
        let held = if sampled { 0.0 } else { step };
        let steps = ages.map(|(least, most)| {
            let low = (least / step * (1.0 - 1e-12)).ceil().max(0.0);
            let high = ((most - held) / step * (1.0 + 1e-12)).floor();
            (low, high)
        });
        if steps.iter().any(|(low, high)| low > high || *high > MOST_SAMPLES as f64) {
            return None;
        }
        let late = if sampled { controllers.computing_time } else { 0.0 };
        let motions = axis.sides.map(|side| {
            let own = if sampled { 0.0 } else { stiffness };
            let values =
                [side.mass, side.damping + if sampled { 0.0 } else { c }, side.ground_stiffness + own];
            [late, step - late].map(|time| Motion::new(values, time))
        });
        Some(Self {
            axis: *axis,
            stiffness,
            sampled,
            motions,
            step,
            ages: steps.map(|(low, high)| (low as usize, high as usize)),
        })
    }

    /// The positions, and where the sides would come to rest: free overdamped sides never leave the hull of both.
    fn reached(&self, state: &[[f64; 2]; 2]) -> [f64; 4] {
        let coasting = |i: usize| {
            let side = &self.axis.sides[i];
            let stiffness = self.stiffness + side.ground_stiffness;
            (2.0 * side.mass / side.damping).min(10.0 * (side.mass / stiffness).sqrt())
        };
        let [[x1, v1], [x2, v2]] = *state;
        [x1, x2, x1 + v1 * coasting(0), x2 + v2 * coasting(1)]
    }

    /// Whether the motion grows in every third of the windows after it has settled.
    fn grows(&self, lead: f64, seed: u64) -> bool {
        let mut draw = Draw(seed);
        let oldest = self.ages[0].1.max(self.ages[1].1);
        let length = oldest + 2;
        // Whole-window peaks of a slow oscillation: several turns and several ages.
        let slowest = self
            .axis
            .sides
            .iter()
            .map(|side| (side.mass / (self.stiffness + side.ground_stiffness)).sqrt())
            .fold(0.0, f64::max);
        let window =
            (4.0 * oldest as f64).max(4.0 * std::f64::consts::TAU * slowest / self.step) as usize + 1;
        let mut state = [0, 1].map(|i| {
            [draw.next() - 0.5, (draw.next() - 0.5) * (self.stiffness / self.axis.sides[i].mass).sqrt()]
        });
        // The past is a rest at the starting position.
        let mut past: [Vec<f64>; 2] = [0, 1].map(|i| vec![self.stiffness * state[i][0]; length]);
        let mut acting = [0, 1].map(|i| self.stiffness * state[i][0]);
        let mut first = 0.0;
        let mut halfway = 0.0;
        let grounded = !self.axis.is_free();
        let none = if grounded { (0.0, 0.0) } else { (f64::INFINITY, f64::NEG_INFINITY) };
        let mut extent: (f64, f64) = none;
        let mut played: [i64; 2] = [0, 1].map(|i| -(self.ages[i].1 as i64));
        for n in 0..2 * WINDOWS * window as i64 {
            for i in 0..2 {
                let [x, v] = state[i];
                past[i][n.rem_euclid(length as i64) as usize] =
                    self.stiffness * x + self.axis.coupling_damping * v;
            }
            let mut forces = acting;
            for i in 0..2 {
                let (newest, oldest) = (n - self.ages[i].0 as i64, n - self.ages[i].1 as i64);
                let partner = &past[1 - i];
                let value = |m: i64| partner[m.rem_euclid(length as i64) as usize];
                let side = &self.axis.sides[i];
                let [x, v] = state[i];
                let from = played[i].max(oldest);
                let pull = value(from)
                    - self.stiffness * x
                    - side.ground_stiffness * x
                    - (side.damping + self.axis.coupling_damping) * v;
                let sign = v + lead * pull / side.mass;
                let mut best = (from, value(from) * sign);
                let stride = ((newest - oldest) / MOST_CHOICES).max(1) as usize;
                for m in (from + 1..=newest).rev().step_by(stride) {
                    let power = value(m) * sign;
                    if power > best.1 {
                        best = (m, power);
                    }
                }
                played[i] = best.0;
                forces[i] = value(best.0);
                if self.sampled {
                    forces[i] -= self.stiffness * x + self.axis.coupling_damping * v;
                }
            }
            for i in 0..2 {
                let [before, after] = &self.motions[i];
                let middle = if self.sampled { before.step(state[i], acting[i]) } else { state[i] };
                state[i] = after.step(middle, forces[i]);
            }
            acting = forces;
            for x in self.reached(&state) {
                extent = (extent.0.min(x), extent.1.max(x));
            }
            if (n + 1) % window as i64 != 0 {
                continue;
            }
            let size = extent.1 - extent.0;
            match (n + 1) / window as i64 {
                _ if !size.is_finite() || size > 1e100 => return true,
                _ if size < 1e-100 => return false,
                i if i == WINDOWS => first = size,
                i if i == WINDOWS + WINDOWS / 2 => halfway = size,
                i if i == 2 * WINDOWS => return size > GROWTH * first && halfway > first && size > halfway,
                i if i > WINDOWS && size < 0.1 * first => return false,
                _ => {}
            }
            extent = none;
        }
        false
    }
}

/// The lowest stiffness (N/m) from `safe` to `limit` at which the attack was seen to grow without end; `None` if it never did.
pub(super) fn lowest_stiffness(
    axis: &DyadAxis,
    ages: &Ages,
    controllers: &Controllers,
    (safe, limit): (f64, f64),
    seed: u64,
) -> Option<f64> {
    let widest = ages.iter().map(|(least, most)| most - least).fold(0.0, f64::max);
    let grows = |k: f64| {
        Attack::new(axis, ages, controllers, k).is_some_and(|attack| {
            LEADS.iter().enumerate().any(|(i, lead)| attack.grows(lead * widest, seed.wrapping_add(i as u64)))
        })
    };
    // Upwards from the bound to the first stiffness that fails; between two steps by halving.
    let mut low = safe;
    if low >= limit {
        return None;
    }
    loop {
        let high = (low * 1.04).min(limit);
        if grows(high) {
            let (mut low, mut high) = (low, high);
            while high - low > ACCURACY * high {
                let middle = 0.5 * (low + high);
                if grows(middle) { high = middle } else { low = middle }
            }
            return Some(high);
        }
        if high >= limit {
            return None;
        }
        low = high;
    }
}
