//! The search for the rightmost characteristic roots of a dyad, guided by a root count.
//!
//! The search first finds a vertical line with enough roots to its right. Points on it where the ratio of
//! both terms is real and positive start Newton's method, one per root. If the count exceeds the roots
//! found, the search bisects on the count: it jumps at the real part of a root, and that root lies where
//! the ratio on the line is 1. The result is correct however poor the starts were.

use num_complex::Complex64;
use std::f64::consts::{PI, TAU};

use super::Certificate;
use super::contour;
use super::line::VerticalLine;
use super::newton::RefinedRoot;
use super::polynomial::complex_roots;
use crate::characteristic::Characteristic;

/// A root in the closed upper half-plane.
#[derive(Debug, Clone, Copy)]
struct KnownRoot {
    s: Complex64,
    /// 1 for a real root, 2 for a root that also stands for its conjugate.
    weight: usize,
}

/// The result of the root search.
pub(super) struct RightmostRoots {
    /// The rightmost root first; of a pair, the upper one first.
    pub roots: Vec<Complex64>,
    pub certificate: Certificate,
    pub depth: f64,
}

/// Two approximations within this relative distance are one root.
const SAME: f64 = 1e-8;
/// Approximations within this relative distance from the centre of a double root belong to it.
const SAME_PAIR: f64 = 1e-4;
/// A line with more starts than this lies far too deep and is skipped.
const MAX_STARTS: f64 = 20_000.0;

struct RootSearch<'a> {
    chi: &'a Characteristic,
    known: Vec<KnownRoot>,
    /// The centres of double roots, with the distance within which approximations belong to them.
    pairs: Vec<(Complex64, f64)>,
}

/// The `count` rightmost characteristic roots of a dyad, without the rigid-body root.
pub(super) fn rightmost_roots(chi: &Characteristic, count: usize) -> RightmostRoots {
    let mut search = RootSearch { chi, known: Vec::new(), pairs: Vec::new() };
    if chi.round_trip == 0.0 {
        return search.roots_without_delay(count);
    }
    let line = search.line_with_roots_right_of(count);
    let Some(counted) = line.count else {
        let reason = "no vertical line without roots on it was found".to_owned();
        search.start_along_line(&line);
        return search.certified_roots(count, line.sigma, Certificate::NotCounted { reason });
    };
    search.start_along_line(&line);
    if search.count_right_of(line.sigma) < counted {
        for side in chi.sides {
            for start in quadratic_roots(side.damping, side.stiffness) {
                search.refine_start(start);
            }
        }
    }
    if search.count_right_of(line.sigma) < counted {
        for start in complex_roots(chi.deflated_remainder()) {
            search.refine_start(start);
        }
    }
    if search.count_right_of(line.sigma) < counted {
        search.find_missed_roots(line.sigma, counted);
    }
    let found = search.count_right_of(line.sigma);
    let certificate =
        if found == counted { Certificate::Complete } else { Certificate::Failed { counted, found } };
    search.certified_roots(count, line.sigma, certificate)
}

/// Roots of s² + βs + κ in the closed upper half-plane, where a dyad's search starts.
fn quadratic_roots(beta: f64, kappa: f64) -> Vec<Complex64> {
    let half = -0.5 * beta;
    let discriminant = half * half - kappa;
    if discriminant < 0.0 {
        return vec![Complex64::new(half, (-discriminant).sqrt())];
    }
    let far = half - discriminant.sqrt();
    vec![Complex64::new(far, 0.0), Complex64::new(kappa / far, 0.0)]
}

impl RootSearch<'_> {
    /// Refines a start by Newton's method and stores the dyad's root if it is new.
    fn refine_start(&mut self, start: Complex64) -> bool {
        match self.chi.refine_root(start) {
            Some(RefinedRoot::Simple(s)) => self.add_root(s),
            Some(RefinedRoot::Pair(centre, half)) => self.add_pair(centre, half),
            None => false,
        }
    }

    /// Stores a simple root of the dyad if it is new, on the real axis if it is real up to rounding.
    fn add_root(&mut self, s: Complex64) -> bool {
        let mut s = Complex64::new(s.re, s.im.abs());
        if s.im > 0.0 && s.im <= SAME * s.norm() {
            // Real up to rounding, if Newton's method on the axis agrees.
            match self.chi.refine_root(Complex64::new(s.re, 0.0)) {
                Some(RefinedRoot::Simple(real)) if (real - s).norm() <= 2.0 * SAME * s.norm() => s = real,
                _ => {}
            }
        }
        let same = |known: &KnownRoot| (known.s - s).norm() <= SAME * s.norm();
        let in_pair = |pair: &(Complex64, f64)| (pair.0 - s).norm() <= pair.1;
        if !s.is_finite() || self.known.iter().any(same) || self.pairs.iter().any(in_pair) {
            return false;
        }
        self.known.push(KnownRoot { s, weight: if s.im == 0.0 { 1 } else { 2 } });
        true
    }

    /// Stores two roots of the dyad too close together to be found one by one.
    fn add_pair(&mut self, centre: Complex64, half: Complex64) -> bool {
        let mut centre = Complex64::new(centre.re, centre.im.abs());
        let mut half = half;
        if centre.im <= SAME * centre.norm() {
            centre.im = 0.0;
            // A real function: the two roots are both real or conjugate.
            half = if half.re.abs() >= half.im.abs() {
                Complex64::new(half.re.abs(), 0.0)
            } else {
                Complex64::new(0.0, half.im.abs())
            };
        }
        let reach = (SAME_PAIR * centre.norm()).min(0.01 * TAU / self.chi.round_trip).max(4.0 * half.norm());
        if !centre.is_finite() || self.pairs.iter().any(|pair| (pair.0 - centre).norm() <= pair.1) {
            return false;
        }
        self.known.retain(|known| (known.s - centre).norm() > reach);
        self.pairs.push((centre, reach));
        if centre.im == 0.0 && half.im > 0.0 {
            self.known.push(KnownRoot { s: centre + half, weight: 2 });
        } else {
            let weight = if centre.im == 0.0 { 1 } else { 2 };
            self.known.push(KnownRoot { s: centre + half, weight });
            self.known.push(KnownRoot { s: centre - half, weight });
        }
        true
    }

    /// The number of the dyad's known roots right of a vertical line, with conjugates.
    fn count_right_of(&self, sigma: f64) -> usize {
        self.known.iter().filter(|known| known.s.re > sigma).map(|known| known.weight).sum()
    }

    /// A vertical line at or near `sigma` with no root of the dyad on it.
    fn line_clear_of_roots(&self, sigma: f64) -> VerticalLine {
        // Roots of undamped sides accumulate at the imaginary axis, so no line is placed there.
        let sigma = if sigma == 0.0 { -1e-3 / self.chi.round_trip } else { sigma };
        let mut line = VerticalLine::count_right_of(self.chi, sigma);
        let mut nudge = 1e-9 * (sigma.abs() + 1e-3 / self.chi.round_trip.max(1e-12));
        for _ in 0..6 {
            if line.count.is_some() || line.crowded {
                break;
            }
            line = VerticalLine::count_right_of(self.chi, sigma - nudge);
            nudge *= 16.0;
        }
        line
    }

    /// A vertical line with at least `count` roots of the dyad to its right, and few more if possible.
    fn line_with_roots_right_of(&self, count: usize) -> VerticalLine {
        let chi = self.chi;
        let t = chi.round_trip;
        let enough = |line: &VerticalLine| line.count.is_some_and(|n| n >= count);
        let most = 2 * count + 8;
        // The n-th root of the chain on which both terms balance has an imaginary part near πn/T.
        let y = Complex64::new(0.0, PI * (count as f64 + 2.0) / t);
        let ratio =
            chi.coupling(y).norm_sqr() / (chi.sides[0].value(y).norm() * chi.sides[1].value(y).norm());
        let guess = ratio.ln().min(-0.1) / t;
        let mut line = self.line_clear_of_roots(guess);
        let (mut deep, mut shallow) = (f64::NEG_INFINITY, f64::INFINITY);
        let mut step = guess.abs();
        for _ in 0..150 {
            let sigma = line.sigma;
            if line.count.is_none() && !line.crowded && deep > f64::NEG_INFINITY {
                // Rounding prevents a finer choice.
                break;
            }
            if line.crowded {
                deep = deep.max(sigma);
            } else if enough(&line) {
                if line.count.is_some_and(|n| n <= most) {
                    return line;
                }
                deep = deep.max(sigma);
            } else {
                shallow = shallow.min(sigma);
            }
            let next = if deep == f64::NEG_INFINITY {
                step *= 2.0;
                sigma - step
            } else if shallow == f64::INFINITY {
                step *= 2.0;
                sigma + step
            } else {
                if shallow - deep <= 1e-13 * (deep.abs().max(1e-3 / t)) {
                    break;
                }
                0.5 * (deep + shallow)
            };
            line = self.line_clear_of_roots(next);
        }
        if enough(&line) { line } else { self.line_clear_of_roots(deep) }
    }

    /// Starts Newton's method where the ratio of both terms is real and positive on the line, with |L| > 1:
    /// each such point belongs to one root further right.
    fn start_along_line(&mut self, line: &VerticalLine) {
        let t = self.chi.round_trip;
        let mut stretch = line.start.map(|phase| (0.0, phase));
        let mut tried: Option<(f64, f64)> = None;
        for crossing in &line.crossings {
            let Some((low, low_phase)) = stretch.take() else {
                stretch = Some((crossing.y, crossing.phase));
                continue;
            };
            let (high, high_phase) = (crossing.y, crossing.phase);
            let first = (low_phase.min(high_phase) / TAU).ceil();
            let last = (low_phase.max(high_phase) / TAU).floor();
            if last - first > MAX_STARTS {
                continue;
            }
            let mut turn = first;
            while turn <= last {
                let share = (turn * TAU - low_phase) / (high_phase - low_phase);
                let y = if share.is_finite() { low + share * (high - low) } else { low };
                self.follow_branch(line.sigma, y, turn - line.left_of);
                turn += 1.0;
            }
            tried = Some((first - line.left_of, last - line.left_of));
        }
        // Branches without a point on the line start further right: the lowest ones, if sides have zeros of
        // their own right of it.
        let (Some((first, last)), Some(top)) = (tried, line.crossings.last()) else { return };
        let enough = line.count.unwrap_or(0);
        let mut turn = last + 1.0;
        if -turn > enough as f64 {
            return;
        }
        while turn <= 0.0 && self.count_right_of(line.sigma) < enough {
            let y = (top.y * turn / (first - 1.0)).max(0.5 / t);
            self.follow_branch(line.sigma, y, turn);
            turn += 1.0;
        }
    }

    /// Applies Newton's method to log L = 2πj · `turn` and then to χ, from height `y`.
    ///
    /// The argument of each side is taken in [0, 2π), that of s² at infinity. It is continuous in the upper
    /// half-plane beyond the resonances, so `turn` identifies one branch.
    fn follow_branch(&mut self, sigma: f64, y: f64, turn: f64) {
        let chi = self.chi;
        let t = chi.round_trip;
        let mut s = Complex64::new(sigma, y);
        let mut moved = f64::INFINITY;
        for iteration in 0..8 {
            let (q, [p1, p2]) = (chi.coupling(s), chi.sides.map(|side| side.value(s)));
            let sides = p1.arg().rem_euclid(TAU) + p2.arg().rem_euclid(TAU);
            let size = (q.norm_sqr() / (p1.norm() * p2.norm())).ln() - t * s.re;
            if iteration == 0 {
                // Moves to where the moduli balance at this height.
                s.re += size / t;
                continue;
            }
            let rest = Complex64::new(size, 2.0 * q.arg() - t * s.im - sides - TAU * turn);
            let step = rest / chi.log_slope(s);
            let length = step.norm();
            let longest = 0.5 * moved;
            let step = if length > longest { step * (longest / length) } else { step };
            moved = if iteration == 1 { 4.0 / t + 0.5 * s.norm() } else { moved };
            s += step;
            if !s.is_finite() || s.im < 0.0 || length < 0.02 / t {
                break;
            }
        }
        self.refine_start(s);
    }

    /// Finds roots of the dyad that the starts missed, by bisecting on the root count.
    fn find_missed_roots(&mut self, sigma: f64, counted: usize) {
        for _ in 0..64 {
            if self.count_right_of(sigma) >= counted {
                return;
            }
            if !self.find_missed_root(sigma) {
                return;
            }
        }
    }

    /// Finds the dyad's rightmost missed root; returns whether it succeeded.
    fn find_missed_root(&mut self, sigma: f64) -> bool {
        let mut low = sigma;
        let mut high = sigma;
        let mut step = sigma.abs().max(1.0 / self.chi.round_trip);
        loop {
            high += step;
            step *= 2.0;
            if !high.is_finite() {
                return false;
            }
            if self.line_clear_of_roots(high).count == Some(0) {
                break;
            }
        }
        for _ in 0..200 {
            let line = self.line_clear_of_roots(0.5 * (low + high));
            let Some(counted) = line.count else { break };
            // The points with |L| = 1 on this line, the most likely first.
            let mut places: Vec<(f64, f64)> = line
                .crossings
                .iter()
                .map(|crossing| ((crossing.phase / TAU - (crossing.phase / TAU).round()).abs(), crossing.y))
                .collect();
            places.push((0.25, 0.0));
            places.sort_by(|a, b| a.0.total_cmp(&b.0));
            for (_, y) in places {
                if self.refine_start(Complex64::new(line.sigma, y)) {
                    return true;
                }
            }
            if self.count_right_of(line.sigma) < counted {
                low = line.sigma;
            } else {
                high = line.sigma;
            }
            if high - low <= 1e-11 * low.abs().max(high.abs()) {
                break;
            }
        }
        self.find_missed_multiplicity(low, high)
    }

    /// Finds a second root of the dyad next to a known one, where the count jumps by more than the known roots.
    fn find_missed_multiplicity(&mut self, low: f64, high: f64) -> bool {
        let margin = 1e-5 * low.abs().max(high.abs());
        let near: Vec<KnownRoot> = self
            .known
            .iter()
            .filter(|known| known.s.re > low - margin && known.s.re < high + margin)
            .copied()
            .collect();
        for known in near {
            let before = self.known.len();
            if let Some(RefinedRoot::Pair(centre, half)) = self.chi.double_root_near(known.s)
                && self.add_pair(centre, half)
                && self.known.len() > before
            {
                return true;
            }
        }
        for (centre, reach) in self.pairs.clone() {
            if (centre.re - 0.5 * (low + high)).abs() > margin.max(reach) {
                continue;
            }
            // Three or more roots in one place: count them in a small square and list the centre.
            let side = 4.0 * reach;
            let corner = Complex64::new(side, side);
            let Ok(inside) = contour::zeros_in_rectangle(self.chi, centre - corner, centre + corner, 10_000)
            else {
                continue;
            };
            let weight = if centre.im == 0.0 { 1 } else { 2 };
            let listed: usize = self
                .known
                .iter()
                .filter(|known| (known.s - centre).norm() <= side)
                .map(|known| if weight == 2 { 1 } else { known.weight })
                .sum();
            if inside > listed {
                for _ in listed..inside {
                    self.known.push(KnownRoot { s: centre, weight });
                }
                return true;
            }
        }
        false
    }

    /// The dyad's roots without delay: those of a polynomial of degree four, or three without the rigid-body root.
    fn roots_without_delay(mut self, count: usize) -> RightmostRoots {
        let polynomial = self.chi.deflated_remainder();
        let degree = polynomial.len() - 1;
        let starts = complex_roots(polynomial);
        let zeros = polynomial.iter().take_while(|c| **c == 0.0).count();
        self.known.extend(std::iter::repeat_n(KnownRoot { s: Complex64::ZERO, weight: 1 }, zeros));
        for start in &starts[zeros..] {
            self.refine_start(*start);
        }
        // A double root, to which two starts converge.
        for known in self.known.clone() {
            if self.count_right_of(f64::NEG_INFINITY) >= degree {
                break;
            }
            if let Some(RefinedRoot::Pair(centre, half)) = self.chi.double_root_near(known.s) {
                self.add_pair(centre, half);
            }
        }
        let found = self.count_right_of(f64::NEG_INFINITY);
        let certificate = if found == degree {
            Certificate::Complete
        } else {
            Certificate::Failed { counted: degree, found }
        };
        self.certified_roots(count, f64::NEG_INFINITY, certificate)
    }

    /// The list of the dyad's `count` rightmost known roots with its certificate.
    fn certified_roots(mut self, count: usize, depth: f64, certificate: Certificate) -> RightmostRoots {
        self.known.retain(|known| known.s.re > depth);
        self.known.sort_by(|a, b| b.s.re.total_cmp(&a.s.re).then(a.s.im.total_cmp(&b.s.im)));
        let mut roots = Vec::with_capacity(count + 1);
        for known in &self.known {
            roots.push(known.s);
            if known.weight == 2 {
                roots.push(known.s.conj());
            }
            if roots.len() >= count {
                break;
            }
        }
        roots.truncate(count);
        RightmostRoots { roots, certificate, depth }
    }
}
