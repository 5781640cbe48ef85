//! A family of axes: all operators of a range at once, and where its characteristic functions can be zero.
//!
//! With Bᵢ = mᵢ s² + bᵢ s + k_h,i and C = k + c s, the characteristic function at s = jω is zero exactly if
//!
//! ```text
//! v₁ v₂ = H² (C/|C|)² e^(−jωT),   vᵢ = H C/|C| + Bᵢ/|C|.
//! ```
//!
//! H = 1 for continuous controllers. Under a zero-order hold of period h, with a computing time τ and the round trip
//! T = N h, H = sinc(ωh/2) e^(−jω(h/2 + τ)), and the aliases of the hold multiply Bᵢ by 1/(1 + ε) with a bounded
//! ε: they come from frequencies above π/h, where the robot's mass hardly moves. Over a cell of frequencies and
//! parameters the vᵢ fill a rectangle each; the enclosures below are proven, not sampled.

use std::f64::consts::{PI, TAU};

use num_complex::Complex64;

use super::products::Sector;
use super::value_set::{Rectangle, factors_of, sector};

/// All values of one side: robot and operator together.
#[derive(Debug, Clone, Copy)]
pub(in crate::verdicts) struct SideRange {
    /// Mass, kg.
    pub mass: (f64, f64),
    /// Damping, N·s/m.
    pub damping: (f64, f64),
    /// Stiffness to ground, N/m.
    pub stiffness: (f64, f64),
}

/// Sampled controllers, which hold their force.
#[derive(Debug, Clone, Copy)]
pub(in crate::verdicts) struct Hold {
    /// The sample period, s.
    pub period: f64,
    /// From reading the samples to applying the force, s.
    pub computing_time: f64,
}

/// All axes of a range of operators.
#[derive(Debug, Clone, Copy)]
pub(in crate::verdicts) struct Family {
    pub sides: [SideRange; 2],
    pub coupling_damping: f64,
    pub hold: Option<Hold>,
}

/// A cell of the search: ranges of frequency (rad/s) and of everything that is not the operators'.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cell {
    pub frequency: (f64, f64),
    /// The spring's stiffness, N/m.
    pub stiffness: (f64, f64),
    /// The round trip, s; `None` for every delay at once.
    pub round_trip: Option<(f64, f64)>,
    /// Damping added to both robots, N·s/m.
    pub added: (f64, f64),
}

/// What a cell may hold.
pub(super) enum Content {
    /// No operator of the range has a root there.
    Nothing,
    /// Not excluded: how much the width in frequency and in the other parameters contributes to that.
    Possible { by_frequency: f64, by_parameter: f64, factors: Option<[Complex64; 2]> },
}

/// The enclosures over a cell: the rectangles of v₁ and v₂, and where their product lies at a root.
struct Enclosure {
    factors: [Rectangle; 2],
    product: Sector,
}

/// The quotient of an interval and a positive interval.
fn quotient((low, high): (f64, f64), by: (f64, f64)) -> (f64, f64) {
    (low / if low > 0.0 { by.1 } else { by.0 }, high / if high > 0.0 { by.0 } else { by.1 })
}

/// The sum of two intervals.
fn sum(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    (a.0 + b.0, a.1 + b.1)
}

/// sin(x)/x.
fn cardinal_sine(x: f64) -> f64 {
    if x.abs() < 1e-4 { 1.0 - x * x / 6.0 } else { x.sin() / x }
}

impl Hold {
    /// The mean time by which the hold delays a force, s.
    pub(super) fn lag(&self) -> f64 {
        0.5 * self.period + self.computing_time
    }

    /// The magnitude of the hold at a frequency up to π/h.
    pub(super) fn magnitude(&self, frequency: f64) -> f64 {
        cardinal_sine(0.5 * frequency * self.period)
    }
}

impl SideRange {
    /// The real part of B over a range of frequencies, N/m.
    fn elastic(&self, frequency: (f64, f64)) -> (f64, f64) {
        (
            self.stiffness.0 - self.mass.1 * frequency.1 * frequency.1,
            self.stiffness.1 - self.mass.0 * frequency.0 * frequency.0,
        )
    }

    /// The smallest and largest |B| over a cell, N/m.
    fn open(&self, cell: &Cell) -> (f64, f64) {
        let real = self.elastic(cell.frequency);
        let imaginary = self.loss(cell);
        let rectangle = Rectangle { real, imaginary };
        (rectangle.least(), rectangle.greatest())
    }

    /// The imaginary part of B over a cell, N/m.
    fn loss(&self, cell: &Cell) -> (f64, f64) {
        (
            cell.frequency.0 * (self.damping.0 + cell.added.0),
            cell.frequency.1 * (self.damping.1 + cell.added.1),
        )
    }

    /// Bounds on the alias sums of 1/B, without and with the velocity's weight, up to a frequency: m/N each.
    ///
    /// At ω + 2πl/h, |B| ≥ m ω² − k_h; ζ(2) and ζ(3) bound the sums over l.
    pub(super) fn aliases(&self, hold: &Hold, frequency: f64) -> Option<[f64; 2]> {
        let nearest = TAU / hold.period - frequency;
        let inertia = self.mass.0 * nearest * nearest - self.stiffness.1;
        (inertia > 0.0).then(|| [2.404_114 * frequency / (nearest * inertia), 3.289_869 / inertia])
    }

    /// A bound on |ε| over a cell, for |B| up to `open`.
    fn alias_share(&self, family: &Family, cell: &Cell, open: f64) -> f64 {
        let Some(hold) = &family.hold else { return 0.0 };
        self.aliases(hold, cell.frequency.1).map_or(f64::INFINITY, |[position, velocity]| {
            open * if family.coupling_damping > 0.0 { position + velocity } else { position }
        })
    }
}

impl Family {
    /// The frequency above which no root lies on the axis for stiffnesses up to the given one, rad/s.
    pub fn frequency_bound(&self, stiffness: f64) -> f64 {
        // From m ω² ≥ 2k + k_h on, |B + C| exceeds |C|.
        let continuous = self
            .sides
            .iter()
            .map(|side| (2.0 * stiffness + side.stiffness.1) / side.mass.0)
            .fold(0.0, f64::max)
            .sqrt()
            * (1.0 + 1e-9);
        self.hold.map_or(continuous, |hold| PI / hold.period)
    }

    /// The time that the hold adds to the round trip, s.
    fn held_time(&self) -> f64 {
        self.hold.map_or(0.0, |hold| 2.0 * hold.lag())
    }

    /// What a cell may hold.
    pub(super) fn content(&self, cell: &Cell) -> Content {
        if self.is_out_of_phase(cell) {
            return Content::Nothing;
        }
        if cell.frequency.0 == 0.0 {
            let excluded = match cell.round_trip {
                None => self.is_free_of_resonance(cell),
                Some(round_trip) => self.is_slow_motion_stable(cell, round_trip),
            };
            return if excluded {
                Content::Nothing
            } else {
                // At rest both factors are 1.
                let factors = Some([Complex64::from(1.0); 2]);
                Content::Possible { by_frequency: f64::INFINITY, by_parameter: 0.0, factors }
            };
        }
        if self.is_loop_gain_small(cell) || cell.round_trip.is_none() && self.is_free_of_resonance(cell) {
            return Content::Nothing;
        }
        let Some(enclosure) = self.enclosure(cell) else {
            return Content::Possible { by_frequency: f64::INFINITY, by_parameter: 0.0, factors: None };
        };
        let [first, second] = &enclosure.factors;
        let Some(piece) = enclosure.product.products(first, second) else { return Content::Nothing };
        let (by_frequency, by_parameter) = self.contributions(cell, &enclosure.factors, &piece.rectangles);
        Content::Possible { by_frequency, by_parameter, factors: piece.factors }
    }

    /// Factors of a root at one frequency and one value of all parameters; `None` if no operator has one there.
    pub(super) fn root_at(&self, cell: &Cell) -> Option<[Complex64; 2]> {
        // Enclosures of a sampled axis are wider than its values: they prove no root.
        if self.hold.is_some() {
            return None;
        }
        let Enclosure { factors: [first, second], product: Sector { magnitude, angle } } =
            self.enclosure(cell)?;
        match angle {
            None => (first.least() * second.least() <= magnitude.0 && !self.is_free_of_resonance(cell))
                .then(|| [first.nearest_to_zero(), second.nearest_to_zero()]),
            Some(angle) => factors_of(Complex64::from_polar(magnitude.0, angle.0), &first, &second),
        }
    }

    /// How much the widths of a cell in frequency and in the parameters widen its enclosures, relative to the least
    /// magnitudes of the pieces that are not excluded.
    fn contributions(&self, cell: &Cell, factors: &[Rectangle; 2], pieces: &[Rectangle; 2]) -> (f64, f64) {
        let width = |(low, high): (f64, f64)| high - low;
        let frequency = cell.frequency.1;
        let size = cell.stiffness.0.hypot(self.coupling_damping * cell.frequency.0);
        let time = cell.round_trip.map_or(0.0, |trip| trip.1) + self.held_time();
        let (mut by_frequency, mut by_parameter) = (time, 0.0);
        for (i, side) in self.sides.iter().enumerate() {
            let (factor, piece) = (factors[i].real, pieces[i].real);
            let weight = 1.0 / (size * pieces[i].least().max(1e-9));
            // The width of the real part counts at its ends only.
            let is_inside = piece.0 > factor.0 && piece.1 < factor.1;
            let inertia = if is_inside { 0.0 } else { 2.0 * side.mass.1 * frequency };
            by_frequency += weight * (inertia + side.damping.0 + cell.added.0 + self.coupling_damping);
            by_parameter += width(cell.stiffness) * (weight + 1.0 / size);
            by_parameter += width(cell.added) * frequency * weight;
        }
        by_parameter += cell.round_trip.map_or(0.0, width) * frequency;
        (by_frequency * width(cell.frequency), by_parameter)
    }

    /// The enclosures over a cell of positive frequencies; `None` where the aliases of the hold are not small.
    fn enclosure(&self, cell: &Cell) -> Option<Enclosure> {
        let c = self.coupling_damping;
        let size =
            (cell.stiffness.0.hypot(c * cell.frequency.0), cell.stiffness.1.hypot(c * cell.frequency.1));
        // The angle of C.
        let turn = if c > 0.0 {
            ((c * cell.frequency.0).atan2(cell.stiffness.1), (c * cell.frequency.1).atan2(cell.stiffness.0))
        } else {
            (0.0, 0.0)
        };
        let lag = self.hold.map_or(0.0, |hold| hold.lag());
        let held = self
            .hold
            .map_or((1.0, 1.0), |hold| (hold.magnitude(cell.frequency.1), hold.magnitude(cell.frequency.0)));
        let shift = if c > 0.0 || self.hold.is_some() {
            sector(held, (turn.0 - cell.frequency.1 * lag, turn.1 - cell.frequency.0 * lag))
        } else {
            Rectangle { real: (1.0, 1.0), imaginary: (0.0, 0.0) }
        };
        let mut factors = [shift; 2];
        for (factor, side) in factors.iter_mut().zip(&self.sides) {
            factor.real = sum(factor.real, quotient(side.elastic(cell.frequency), size));
            factor.imaginary = sum(factor.imaginary, quotient(side.loss(cell), size));
            if self.hold.is_some() {
                // Only a |B| that a root allows matters; the other factor is not known yet, so take them all.
                let open = side.open(cell).1;
                let share = side.alias_share(self, cell, open);
                if share >= 0.5 {
                    return None;
                }
                *factor = factor.widened(open / size.0 * share / (1.0 - share));
            }
        }
        let angle = cell.round_trip.map(|trip| {
            let time = (trip.0 + 2.0 * lag, trip.1 + 2.0 * lag);
            (2.0 * turn.0 - cell.frequency.1 * time.1, 2.0 * turn.1 - cell.frequency.0 * time.0)
        });
        let product = Sector { magnitude: (held.0 * held.0, held.1 * held.1), angle };
        Some(Enclosure { factors, product })
    }

    /// Whether under the hold |1 + B/(HC)| exceeds 1 on both sides, because the force hardly moves the robots.
    fn is_loop_gain_small(&self, cell: &Cell) -> bool {
        let Some(hold) = &self.hold else { return false };
        let size = cell.stiffness.1.hypot(self.coupling_damping * cell.frequency.1);
        self.sides.iter().all(|side| {
            side.aliases(hold, cell.frequency.1).is_some_and(|[position, velocity]| {
                let aliases = if self.coupling_damping > 0.0 { position + velocity } else { position };
                hold.magnitude(cell.frequency.0) * size * (1.0 / side.open(cell).0 + aliases) < 0.499
            })
        })
    }

    /// Whether the phases of both sides exclude roots under continuous controllers.
    ///
    /// With Im Pᵢ = ω(bᵢ + c) > 0 and |P₁P₂| = |C|², arg P₁ + arg P₂ lies between 2A and 2π − 2A, where
    /// sin A = ω√((b₁ + c)(b₂ + c))/|C|, since arcsin(eˣ) is convex. At a root it is 2θ − ωT, up to whole turns,
    /// with sin θ = ωc/|C|. As A ≥ θ, a whole turn is needed, and with it ωT ≥ 2A + 2θ; where both real parts are
    /// positive, ωT ≥ π.
    fn is_out_of_phase(&self, cell: &Cell) -> bool {
        let Some(round_trip) = cell.round_trip else { return false };
        if self.hold.is_some() {
            return false;
        }
        // Rounding may exclude no root.
        const ROUNDING: f64 = 1e-13;
        let c = self.coupling_damping;
        let [first, second] = self.sides.map(|side| side.damping.0 + cell.added.0);
        let (low, high) = cell.frequency;
        let spring = cell.stiffness.1;
        let loss = (first + c).sqrt() * (second + c).sqrt() * (1.0 - ROUNDING);
        let sine = loss * low / spring.hypot(c * low);
        if sine > 1.0 {
            return true;
        }
        if first == 0.0 && second == 0.0 && round_trip.0 == 0.0 {
            return false;
        }
        let is_slow = self
            .sides
            .iter()
            .all(|side| side.mass.1 * high * high < (cell.stiffness.0 + side.stiffness.0) * (1.0 - ROUNDING));
        // A/sin A and sin A grow with ω, sin A/ω and θ/ω fall.
        let growth = if sine > 0.0 { sine.asin() / sine } else { 1.0 };
        let least = 2.0 * (growth * loss / spring.hypot(c * high) + (c * high / spring).atan() / high);
        round_trip.1 < least * (1.0 - ROUNDING) || is_slow && round_trip.1 * high < PI
    }

    /// Whether |P₁P₂| exceeds |C|² in a cell where both P have a positive real part, the lowest frequencies
    /// included. There the operator with the largest mass, smallest damping and smallest stiffness is the worst.
    ///
    /// With |Pᵢ|² = S + ξ gᵢ, S = |C|² and ξ = ω², this is S (g₁ + g₂) + ξ g₁ g₂ > 0.
    fn is_free_of_resonance(&self, cell: &Cell) -> bool {
        let c = self.coupling_damping;
        let squared = (cell.frequency.0 * cell.frequency.0, cell.frequency.1 * cell.frequency.1);
        let (low, high) = cell.stiffness;
        let mut growth = [0.0; 2];
        for (growth, side) in growth.iter_mut().zip(&self.sides) {
            let (m, ground) = (side.mass.1, side.stiffness.0);
            let b = side.damping.0 + cell.added.0;
            if low + ground <= m * squared.1 {
                return false;
            }
            let held = ground * (2.0 * low + ground) / squared.1;
            *growth = b * (b + 2.0 * c) - 2.0 * m * (high + ground) + m * m * squared.0 + held;
        }
        let [first, second] = growth;
        // Otherwise the sum below need not grow with g₁ and g₂.
        let least = low * low + c * c * squared.0;
        if growth.iter().any(|growth| least + squared.1 * growth.min(0.0) <= 0.0) {
            return false;
        }
        let total = first + second;
        let size = if total > 0.0 { least } else { high * high + c * c * squared.1 };
        let product = first * second;
        total * size + product * if product > 0.0 { squared.0 } else { squared.1 } > 0.0
    }

    /// The values of both sides (mass, damping, stiffness) whose factors these are, as near as the range allows.
    pub(super) fn sides_of(&self, cell: &Cell, factors: [Complex64; 2]) -> [[f64; 3]; 2] {
        let middle = |(low, high): (f64, f64)| 0.5 * (low + high);
        let frequency = middle(cell.frequency);
        let spring = Complex64::new(middle(cell.stiffness), self.coupling_damping * frequency);
        let held = self.hold.map_or(Complex64::from(1.0), |hold| {
            Complex64::from_polar(hold.magnitude(frequency), -frequency * hold.lag())
        });
        [0, 1].map(|i| {
            let side = &self.sides[i];
            let open = factors[i] * spring.norm() - held * spring;
            let (least, most) = side.elastic((frequency, frequency));
            let part = if most > least { ((open.re - least) / (most - least)).clamp(0.0, 1.0) } else { 0.0 };
            let damping = if frequency > 0.0 { open.im / frequency - middle(cell.added) } else { 0.0 };
            [
                side.mass.1 + part * (side.mass.0 - side.mass.1),
                damping.clamp(side.damping.0, side.damping.1),
                side.stiffness.0 + part * (side.stiffness.1 - side.stiffness.0),
            ]
        })
    }
}
