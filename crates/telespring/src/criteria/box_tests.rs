//! What a box of the branch and bound holds: nothing, one crossing, or something to be split.
//!
//! The tests bound the real and the imaginary part of L by themselves, and the arguments of the factors without
//! their half turns. Where hardly anything is damped both are decades apart, and only the smaller one decides.

use std::f64::consts::{PI, TAU};

use num_complex::Complex64;

use super::branch_and_bound::{FactorBox, LineFunction, Region, SideFactors, SideSlopes};
use super::complex_box::{Argument, Interval, Rectangle};

/// What a box of the search holds.
pub(super) enum BoxContent {
    /// No crossing.
    Nothing,
    /// The frequency and the parameter of a crossing.
    Solution(f64, f64),
    /// To be split along one of its variables.
    Undecided { split_frequency: bool },
}

/// Relative slack of the tests on moduli and phases, which keeps their rounding from deciding.
const SLACK: f64 = 1e-13;

/// Beyond this derivative a factor counts as 0: products of two derivatives would overflow.
const LARGEST_SLOPE: f64 = 1e140;

/// N/D = 1 + A/D of one side over a box.
#[derive(Clone, Copy)]
struct SideRatio {
    /// The range of |N/D|.
    modulus: (f64, f64),
    /// The argument of N/D.
    argument: Argument,
}

impl SideRatio {
    /// The ratio from N and from D, which keeps the digits where N is small.
    fn of_factors(side: &SideFactors, modulus: (f64, f64)) -> Self {
        Self { modulus, argument: side.whole.argument().minus(side.coupling.argument()) }
    }

    /// The tighter one of this ratio and 1 + A/D, which keeps the digits where A is small.
    fn refined(self, change: Rectangle) -> Self {
        let Rectangle { re, im } = change;
        let shifted = Rectangle { re: re.plus(Interval::point(1.0)), im };
        let (modulus, argument) = (shifted.modulus(), shifted.argument());
        Self {
            modulus: (self.modulus.0.max(modulus.0), self.modulus.1.min(modulus.1)),
            argument: if argument.width() < self.argument.width() { argument } else { self.argument },
        }
    }
}

/// The range of |N/D| of one side over a box, from N and from D.
fn ratio_of_moduli(side: &SideFactors) -> (f64, f64) {
    let (whole, coupling) = (side.whole.modulus(), side.coupling.modulus());
    (whole.0 / coupling.1, whole.1 / coupling.0)
}

/// A/D of both sides over a box; `None` if D may be 0.
fn changes(sides: &[SideFactors; 2]) -> Option<[Rectangle; 2]> {
    let [first, second] = sides;
    Some([first.alone.times(first.coupling.reciprocal()?), second.alone.times(second.coupling.reciprocal()?)])
}

/// Whether the moduli of the factors differ everywhere in a box.
fn moduli_differ([first, second]: [(f64, f64); 2], growth: f64) -> bool {
    first.0 * second.0 > growth * (1.0 + SLACK) || first.1 * second.1 * (1.0 + SLACK) < growth
}

/// Whether |1 + A₁/D| |1 + A₂/D| differs from the growth everywhere in a box, where A is small beside D.
fn small_changes_differ(changes: &[Rectangle; 2], log_growth: f64) -> bool {
    // |1 + z|² − 1 = x (2 + x) + y², of which x (2 + x) ascends from x = −1 on.
    let [first, second] = changes.map(|Rectangle { re, im }| {
        let side = im.absolute();
        let square = |x: f64, y: f64| x * (2.0 + x) + y * y;
        let least = if re.low > -1.0 { square(re.low, side.0) } else { -1.0 };
        Interval { low: least, high: square(re.high.max(-2.0 - re.low), side.1) }
    });
    // (1 + a)(1 + b) against g².
    let square = (2.0 * log_growth).exp_m1();
    let product = |a: f64, b: f64| a + b + a * b;
    let slack = |a: f64, b: f64| SLACK * (a.abs() + b.abs() + square.abs());
    product(first.low, second.low) > square + slack(first.low, second.low)
        || product(first.high, second.high) < square - slack(first.high, second.high)
}

/// Whether an interval of phases, known to `error`, holds no whole number of turns besides some half turns.
fn is_between_turns(phase: Interval, half_turns: i32, error: f64) -> bool {
    let shift = if half_turns % 2 == 0 { 0.0 } else { PI };
    ((phase.low - error + shift) / TAU).ceil() > ((phase.high + error + shift) / TAU).floor()
}

/// The largest modulus of the numbers of an interval.
fn size_of(interval: Interval) -> f64 {
    interval.absolute().1
}

/// Whether the arguments of the factors and the delay never add up to whole turns in a box.
fn phases_differ(ratios: &[SideRatio; 2], turn: Interval) -> bool {
    let [first, second] = ratios.each_ref().map(|ratio| ratio.argument);
    let sum = first.plus(second);
    let size = size_of(turn) + size_of(first.rest) + size_of(second.rest);
    is_between_turns(sum.rest.plus(turn), sum.half_turns, SLACK * size)
}

/// Whether the imaginary part of one side's N differs from that of D₁ D₂ g e^(−jωT)/N of the other side
/// everywhere in a box.
///
/// Next to a resonance N is small, and its modulus and phase change fast. Its imaginary part does not.
fn imaginary_parts_differ(factors: &FactorBox, ratios: &[SideRatio; 2], growth: f64) -> bool {
    (0..2).any(|i| {
        let (own, other) = (&factors.sides[i], &ratios[1 - i]);
        let coupling = own.coupling.modulus();
        let most = coupling.1 * growth / other.modulus.0;
        let least = coupling.0 * growth / other.modulus.1;
        let angle = own.coupling.argument().minus(other.argument);
        let phase = angle.rest.plus(factors.turn.turned());
        if !most.is_finite() || phase.high - phase.low > PI {
            return false;
        }
        let mut sine = sines(phase);
        if angle.half_turns % 2 != 0 {
            sine = sine.turned();
        }
        let returned = Interval { low: least, high: most }.times(sine);
        let slack = SLACK * (most * (size_of(factors.turn) + size_of(angle.rest)) + size_of(own.whole.im));
        own.whole.im.low > returned.high + slack || own.whole.im.high < returned.low - slack
    })
}

/// Whether the imaginary part of A₁ + A₂ differs from that of D (g e^(−jωT) − 1) − A₁ A₂/D everywhere in a box,
/// for a coupling D common to both sides.
///
/// Where both sides move together A₁ + A₂ is small beside each of them. Its imaginary part is the loss of both.
fn losses_differ(factors: &FactorBox, change: Rectangle, log_growth: f64) -> bool {
    let [first, second] = &factors.sides;
    if factors.turn.high - factors.turn.low > 0.5 * PI {
        return false;
    }
    let growth = log_growth.exp();
    let scaled = |interval: Interval| Interval { low: growth * interval.low, high: growth * interval.high };
    let half = sines(Interval { low: 0.5 * factors.turn.low, high: 0.5 * factors.turn.high }).absolute();
    let versine = Interval { low: 2.0 * half.0 * half.0, high: 2.0 * half.1 * half.1 };
    let returned_less_one = Rectangle {
        re: Interval::point(log_growth.exp_m1()).plus(scaled(versine).turned()),
        im: scaled(sines(factors.turn)).turned(),
    };
    let (one, other) = (first.coupling.times(returned_less_one).im, change.times(second.alone).im.turned());
    let loss = first.alone.im.plus(second.alone.im);
    let needed = one.plus(other);
    let slack = SLACK * (size_of(loss) + size_of(one) * (1.0 + size_of(factors.turn)) + size_of(other));
    loss.low > needed.high + slack || loss.high < needed.low - slack
}

/// The sines of an interval of phases no wider than half a turn.
fn sines(phase: Interval) -> Interval {
    let mut sines = Interval::between(phase.low.sin(), phase.high.sin());
    let holds = |top: f64| ((phase.low - top) / TAU).ceil() <= ((phase.high - top) / TAU).floor();
    if holds(0.5 * PI) {
        sines.high = 1.0;
    }
    if holds(-0.5 * PI) {
        sines.low = -1.0;
    }
    sines
}

/// Rectangles around the derivatives of L, by the frequency and by the parameter; `None` if a factor may be 0.
fn log_derivatives(factors: &FactorBox, changes: &[Rectangle; 2]) -> Option<[Rectangle; 2]> {
    let [first, second] = &factors.sides;
    let reciprocals = [first.whole.reciprocal()?, second.whole.reciprocal()?];
    let derivative = |(slopes, turn): &([SideSlopes; 2], Interval)| {
        let mut sum = Rectangle { re: Interval::point(0.0), im: *turn };
        for i in 0..2 {
            // With N = A + D: N'/N − D'/D = (A' − D' A/D)/N, which keeps the digits where A is small.
            let change = slopes[i].alone.minus(slopes[i].coupling.times(changes[i]));
            sum = sum.plus(change.times(reciprocals[i]));
        }
        sum
    };
    let derivatives = [derivative(&factors.by_frequency), derivative(&factors.by_parameter)];
    derivatives.iter().all(|slope| slope.modulus().1 < LARGEST_SLOPE).then_some(derivatives)
}

/// Im(conj(a) b), the component of b perpendicular to a times |a|, for the box search.
fn cross_product(a: Complex64, b: Complex64) -> f64 {
    a.re * b.im - a.im * b.re
}

/// A bound on the cross product of a number with an uncertain one.
fn cross_bound(a: Complex64, uncertain: Complex64) -> f64 {
    a.re.abs() * uncertain.im + a.im.abs() * uncertain.re
}

/// Whether a box that the moduli and phases of N and D leave open holds no crossing, by what A/D adds.
fn is_ruled_out(
    function: &impl LineFunction,
    factors: &FactorBox,
    ratios: [SideRatio; 2],
    changes: [Rectangle; 2],
) -> bool {
    let log_growth = function.log_growth();
    let growth = log_growth.exp();
    let [first, second] = ratios;
    let ratios = [first.refined(changes[0]), second.refined(changes[1])];
    moduli_differ(ratios.map(|ratio| ratio.modulus), growth)
        || small_changes_differ(&changes, log_growth)
        || phases_differ(&ratios, factors.turn)
        || imaginary_parts_differ(factors, &ratios, growth)
        || function.has_common_coupling() && losses_differ(factors, changes[0], log_growth)
}

/// Decides whether a box of the search holds no solution, at most one, or must be split.
pub(super) fn examine_box(function: &impl LineFunction, part: &Region) -> BoxContent {
    if function.is_excluded(part) {
        return BoxContent::Nothing;
    }
    let factors = function.factors(part);
    let log_growth = function.log_growth();
    let growth = if log_growth == 0.0 { 1.0 } else { log_growth.exp() };
    let moduli = factors.sides.each_ref().map(ratio_of_moduli);
    if moduli_differ(moduli, growth) {
        return BoxContent::Nothing;
    }
    let ratios = [0, 1].map(|i| SideRatio::of_factors(&factors.sides[i], moduli[i]));
    if phases_differ(&ratios, factors.turn) {
        return BoxContent::Nothing;
    }
    let changes = changes(&factors.sides);
    // Dearer than the other tests, and of use only where those cannot decide.
    let is_ruled_out = || changes.is_some_and(|changes| is_ruled_out(function, &factors, ratios, changes));
    let (w, p) = (0.5 * (part.frequency.0 + part.frequency.1), 0.5 * (part.parameter.0 + part.parameter.1));
    let (dw, dp) = (w - part.frequency.0, p - part.parameter.0);
    let Some([by_w, by_p]) = changes.and_then(|changes| log_derivatives(&factors, &changes)) else {
        if dw <= 1e-15 * w && dp <= 1e-15 * p {
            return BoxContent::Solution(w, p);
        }
        if is_ruled_out() {
            return BoxContent::Nothing;
        }
        return BoxContent::Undecided { split_frequency: frequency_moves_more(&factors, dw, dp) };
    };

    // Where the function is real its phase is a multiple of π, and leaves it at once if it is monotone.
    let ends = [part.frequency.0, part.frequency.1];
    let mut waits_for_parameter = false;
    if ends.iter().any(|&end| function.is_real_at(end)) {
        let leaves_at_once = |slope: Interval| {
            let (least, size) = slope.absolute();
            least > SLACK * size && 2.0 * dw * size < 0.99 * PI
        };
        if leaves_at_once(by_w.im) {
            return BoxContent::Nothing;
        }
        // Where one value of the parameter leaves no doubt about the slope, the range of the parameter does.
        let single = function.factors(&Region { parameter: (p, p), ..*part });
        waits_for_parameter = self::changes(&single.sides)
            .and_then(|changes| log_derivatives(&single, &changes))
            .is_some_and(|[by_w, _]| leaves_at_once(by_w.im));
    }

    // The value at the centre, less the nearest multiple of 2πj, and its possible change over the box.
    let logarithm = function.logarithm(w, p);
    let turns = logarithm.nearest_turns();
    let (value, error) = (logarithm.less(turns), logarithm.error);
    let real_change = size_of(by_w.re) * dw + size_of(by_p.re) * dp + error.re;
    let phase_change = size_of(by_w.im) * dw + size_of(by_p.im) * dp + error.im;
    let phase = Interval::point(value.im).widened(phase_change);
    if value.re.abs() > real_change || is_between_turns(phase, 0, f64::EPSILON * PI * turns.abs()) {
        return BoxContent::Nothing;
    }
    // Another multiple of 2πj may be reached, too.
    let one_turn = phase_change + value.im.abs() < 0.99 * TAU;

    // Along the direction of one derivative only the other one and the curvature change the value.
    let (w_slope, p_slope) = (by_w.centre(), by_p.centre());
    let ((w_re, w_im), (p_re, p_im)) = (by_w.radii(), by_p.radii());
    let determinant = cross_product(w_slope, p_slope);
    let remainder = Complex64::new(w_re * dw + p_re * dp + error.re, w_im * dw + p_im * dp + error.im);
    if one_turn
        && (cross_product(w_slope, value).abs() > determinant.abs() * dp + cross_bound(w_slope, remainder)
            || cross_product(p_slope, value).abs() > determinant.abs() * dw + cross_bound(p_slope, remainder))
    {
        return BoxContent::Nothing;
    }
    // At most one solution if the derivative stays invertible over the box, whatever the points at which the mean
    // value theorem takes its entries.
    let spread = cross_bound(w_slope, Complex64::new(p_re, p_im))
        + cross_bound(p_slope, Complex64::new(w_re, w_im))
        + w_re * p_im
        + w_im * p_re;
    if one_turn
        && spread < 0.5 * determinant.abs()
        && let Some(content) = newton_in_box(function, part, (w, p), turns)
    {
        return content;
    }
    // A box this narrow holds at most a double solution, where two branches touch.
    if dw <= 1e-13 * w && dp <= 1e-13 * p {
        return BoxContent::Solution(w, p);
    }
    if is_ruled_out() {
        return BoxContent::Nothing;
    }
    let largest = |slope: Rectangle| slope.modulus().1;
    let frequency_matters = largest(by_w) * dw > largest(by_p) * dp;
    BoxContent::Undecided { split_frequency: frequency_matters && !waits_for_parameter }
}

/// Whether the frequency changes the factors of a box more than the parameter does, relative to their size.
fn frequency_moves_more(factors: &FactorBox, dw: f64, dp: f64) -> bool {
    let largest = |slopes: &[SideSlopes; 2], d: f64| {
        let sides = slopes.iter().zip(&factors.sides);
        sides
            .flat_map(|(slope, side)| {
                let own = slope.alone.modulus().1 + slope.coupling.modulus().1;
                [own / side.whole.modulus().1, slope.coupling.modulus().1 / side.coupling.modulus().1]
            })
            .map(|change| change * d)
            .filter(|change| !change.is_nan())
            .fold(0.0, f64::max)
    };
    largest(&factors.by_frequency.0, dw) > largest(&factors.by_parameter.0, dp)
}

/// Newton's iteration in a box of the search with at most one solution, at a number of half turns; `None` if it
/// leaves the box.
fn newton_in_box(
    function: &impl LineFunction,
    part: &Region,
    (mut w, mut p): (f64, f64),
    half_turns: f64,
) -> Option<BoxContent> {
    let inside = |(low, high): (f64, f64), x: f64, slack: f64| {
        let margin = slack * (high - low) + 1e-13 * x.abs();
        x >= low - margin && x <= high + margin
    };
    let mut previous = f64::INFINITY;
    for _ in 0..30 {
        let factors = function.factors(&Region { frequency: (w, w), parameter: (p, p) });
        let [by_w, by_p] = log_derivatives(&factors, &changes(&factors.sides)?)?.map(|slope| slope.centre());
        let value = function.logarithm(w, p).less(half_turns);
        let determinant = cross_product(by_w, by_p);
        let step_w = cross_product(by_p, value) / determinant;
        let step_p = -cross_product(by_w, value) / determinant;
        w += step_w;
        p += step_p;
        let size = (step_w / w).abs() + (step_p / p).abs();
        if !inside(part.frequency, w, 1.0) || !inside(part.parameter, p, 1.0) {
            return None;
        }
        if size < 1e-15 || size < 1e-9 && size >= 0.5 * previous {
            let own = inside(part.frequency, w, 1e-9) && inside(part.parameter, p, 1e-9);
            return Some(if own { BoxContent::Solution(w, p) } else { BoxContent::Nothing });
        }
        previous = size;
    }
    None
}
