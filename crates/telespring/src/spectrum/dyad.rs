//! The search for the rightmost characteristic roots of a dyad, driven by the count.
//!
//! A line with enough roots to its right is found first; the places on it where the ratio of both
//! terms is real and positive start Newton, one per root. Where the count still exceeds what was
//! found, the count itself is bisected: it jumps at a root's real part, and the root then lies where
//! that line's ratio passes 1. So the search ends with the right roots, however bad the starts were.

use num_complex::Complex64;
use std::f64::consts::{PI, TAU};

use super::Certificate;
use super::contour;
use super::line::Line;
use super::newton::Refined;
use super::polynomial::complex_roots;
use crate::characteristic::Characteristic;

/// A root in the closed upper half-plane.
#[derive(Debug, Clone, Copy)]
struct Known {
    s: Complex64,
    /// 1 for a real root, 2 for one that stands for itself and its conjugate.
    weight: usize,
}

/// What the search ended with.
pub(super) struct Found {
    /// Rightmost first, a pair's upper member first.
    pub roots: Vec<Complex64>,
    pub certificate: Certificate,
    pub depth: f64,
}

/// Two approximations of one root differ by less than this, relatively.
const SAME: f64 = 1e-8;
/// How near to the middle of a double root another approximation of it may lie, relatively.
const SAME_PAIR: f64 = 1e-4;
/// More starts than this on one line are not made: then the line lies far too deep.
const MAX_STARTS: f64 = 20_000.0;

struct Search<'a> {
    chi: &'a Characteristic,
    known: Vec<Known>,
    /// The middles of double roots, with the distance within which an approximation belongs to them.
    pairs: Vec<(Complex64, f64)>,
}

/// The `count` rightmost roots, the rigid-body root left out.
pub(super) fn rightmost(chi: &Characteristic, count: usize) -> Found {
    let mut search = Search { chi, known: Vec::new(), pairs: Vec::new() };
    if chi.round_trip == 0.0 {
        return search.without_delay(count);
    }
    let line = search.line_with(count);
    let Some(counted) = line.count else {
        let reason = "no line free of roots was found to count on".to_owned();
        search.start_on(&line);
        return search.finish(count, line.sigma, Certificate::NotCounted { reason });
    };
    search.start_on(&line);
    if search.right_of(line.sigma) < counted {
        for side in chi.sides {
            for start in quadratic_roots(side.damping, side.stiffness) {
                search.start(start);
            }
        }
    }
    if search.right_of(line.sigma) < counted {
        for start in complex_roots(chi.deflated_remainder()) {
            search.start(start);
        }
    }
    if search.right_of(line.sigma) < counted {
        search.hunt(line.sigma, counted);
    }
    let found = search.right_of(line.sigma);
    let certificate =
        if found == counted { Certificate::Complete } else { Certificate::Failed { counted, found } };
    search.finish(count, line.sigma, certificate)
}

/// Roots of s² + βs + κ in the closed upper half-plane.
fn quadratic_roots(beta: f64, kappa: f64) -> Vec<Complex64> {
    let half = -0.5 * beta;
    let discriminant = half * half - kappa;
    if discriminant < 0.0 {
        return vec![Complex64::new(half, (-discriminant).sqrt())];
    }
    let far = half - discriminant.sqrt();
    vec![Complex64::new(far, 0.0), Complex64::new(kappa / far, 0.0)]
}

impl Search<'_> {
    /// Refines a start and keeps the root it leads to, if it is new.
    fn start(&mut self, start: Complex64) -> bool {
        match self.chi.refine(start) {
            Some(Refined::Simple(s)) => self.keep(s),
            Some(Refined::Pair(centre, half)) => self.keep_pair(centre, half),
            None => false,
        }
    }

    fn keep(&mut self, s: Complex64) -> bool {
        let mut s = Complex64::new(s.re, s.im.abs());
        if s.im > 0.0 && s.im <= SAME * s.norm() {
            // Real but for rounding, if Newton on the axis agrees.
            match self.chi.refine(Complex64::new(s.re, 0.0)) {
                Some(Refined::Simple(real)) if (real - s).norm() <= 2.0 * SAME * s.norm() => s = real,
                _ => {}
            }
        }
        let same = |known: &Known| (known.s - s).norm() <= SAME * s.norm();
        let in_pair = |pair: &(Complex64, f64)| (pair.0 - s).norm() <= pair.1;
        if !s.is_finite() || self.known.iter().any(same) || self.pairs.iter().any(in_pair) {
            return false;
        }
        self.known.push(Known { s, weight: if s.im == 0.0 { 1 } else { 2 } });
        true
    }

    /// Keeps two roots that lie too near each other for Newton to find them one by one.
    fn keep_pair(&mut self, centre: Complex64, half: Complex64) -> bool {
        let mut centre = Complex64::new(centre.re, centre.im.abs());
        let mut half = half;
        if centre.im <= SAME * centre.norm() {
            centre.im = 0.0;
            // A real function: the two are both real, or conjugate.
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
            self.known.push(Known { s: centre + half, weight: 2 });
        } else {
            let weight = if centre.im == 0.0 { 1 } else { 2 };
            self.known.push(Known { s: centre + half, weight });
            self.known.push(Known { s: centre - half, weight });
        }
        true
    }

    /// How many known roots lie right of a line.
    fn right_of(&self, sigma: f64) -> usize {
        self.known.iter().filter(|known| known.s.re > sigma).map(|known| known.weight).sum()
    }

    /// A line that no root touches, at or near `sigma`.
    fn clear_line(&self, sigma: f64) -> Line {
        // Roots of undamped sides gather at the axis itself: no line is put on it by chance.
        let sigma = if sigma == 0.0 { -1e-3 / self.chi.round_trip } else { sigma };
        let mut line = Line::count(self.chi, sigma);
        let mut nudge = 1e-9 * (sigma.abs() + 1e-3 / self.chi.round_trip.max(1e-12));
        for _ in 0..6 {
            if line.count.is_some() || line.crowded {
                break;
            }
            line = Line::count(self.chi, sigma - nudge);
            nudge *= 16.0;
        }
        line
    }

    /// A line with at least `count` roots to its right, and not many more where that can be had.
    fn line_with(&self, count: usize) -> Line {
        let chi = self.chi;
        let t = chi.round_trip;
        let enough = |line: &Line| line.count.is_some_and(|n| n >= count);
        let most = 2 * count + 8;
        // The n-th root of the chain on which both terms balance has an imaginary part near πn/T.
        let y = Complex64::new(0.0, PI * (count as f64 + 2.0) / t);
        let ratio =
            chi.coupling(y).norm_sqr() / (chi.sides[0].value(y).norm() * chi.sides[1].value(y).norm());
        let guess = ratio.ln().min(-0.1) / t;
        let mut line = self.clear_line(guess);
        let (mut deep, mut shallow) = (f64::NEG_INFINITY, f64::INFINITY);
        let mut step = guess.abs();
        for _ in 0..150 {
            let sigma = line.sigma;
            if line.count.is_none() && !line.crowded && deep > f64::NEG_INFINITY {
                // Rounding allows no finer choice.
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
            line = self.clear_line(next);
        }
        if enough(&line) { line } else { self.clear_line(deep) }
    }

    /// Starts Newton where the ratio of both terms is real and positive on the line, with |L| > 1:
    /// each such place belongs to one root further right.
    fn start_on(&mut self, line: &Line) {
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
                self.branch(line.sigma, y, turn - line.left_of);
                turn += 1.0;
            }
            tried = Some((first - line.left_of, last - line.left_of));
        }
        // Branches that have no place on the line start further right: the lowest ones, where sides
        // have zeros of their own right of it.
        let (Some((first, last)), Some(top)) = (tried, line.crossings.last()) else { return };
        let enough = line.count.unwrap_or(0);
        let mut turn = last + 1.0;
        if -turn > enough as f64 {
            return;
        }
        while turn <= 0.0 && self.right_of(line.sigma) < enough {
            let y = (top.y * turn / (first - 1.0)).max(0.5 / t);
            self.branch(line.sigma, y, turn);
            turn += 1.0;
        }
    }

    /// Newton on log L = 2πj · `turn`, then on χ, from height `y`.
    ///
    /// The argument of each side is taken in [0, 2π), that of s² far out: it is continuous in the
    /// whole upper half-plane beyond the resonances, so that `turn` names one branch there.
    fn branch(&mut self, sigma: f64, y: f64, turn: f64) {
        let chi = self.chi;
        let t = chi.round_trip;
        let mut s = Complex64::new(sigma, y);
        let mut moved = f64::INFINITY;
        for iteration in 0..8 {
            let (q, [p1, p2]) = (chi.coupling(s), chi.sides.map(|side| side.value(s)));
            let sides = p1.arg().rem_euclid(TAU) + p2.arg().rem_euclid(TAU);
            let size = (q.norm_sqr() / (p1.norm() * p2.norm())).ln() - t * s.re;
            if iteration == 0 {
                // To where the moduli balance, at this height.
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
        self.start(s);
    }

    /// Finds what the starts missed, by bisecting the line at which the count exceeds the known.
    fn hunt(&mut self, sigma: f64, counted: usize) {
        for _ in 0..64 {
            if self.right_of(sigma) >= counted {
                return;
            }
            if !self.hunt_one(sigma) {
                return;
            }
        }
    }

    /// Finds the rightmost missing root; whether it did.
    fn hunt_one(&mut self, sigma: f64) -> bool {
        let mut low = sigma;
        let mut high = sigma;
        let mut step = sigma.abs().max(1.0 / self.chi.round_trip);
        loop {
            high += step;
            step *= 2.0;
            if !high.is_finite() {
                return false;
            }
            if self.clear_line(high).count == Some(0) {
                break;
            }
        }
        for _ in 0..200 {
            let line = self.clear_line(0.5 * (low + high));
            let Some(counted) = line.count else { break };
            // The places where |L| = 1 on this line, the likeliest first.
            let mut places: Vec<(f64, f64)> = line
                .crossings
                .iter()
                .map(|crossing| ((crossing.phase / TAU - (crossing.phase / TAU).round()).abs(), crossing.y))
                .collect();
            places.push((0.25, 0.0));
            places.sort_by(|a, b| a.0.total_cmp(&b.0));
            for (_, y) in places {
                if self.start(Complex64::new(line.sigma, y)) {
                    return true;
                }
            }
            if self.right_of(line.sigma) < counted {
                low = line.sigma;
            } else {
                high = line.sigma;
            }
            if high - low <= 1e-11 * low.abs().max(high.abs()) {
                break;
            }
        }
        self.hunt_double(low, high)
    }

    /// Finds a second root next to a known one: where the count jumps by more than the known there.
    fn hunt_double(&mut self, low: f64, high: f64) -> bool {
        let margin = 1e-5 * low.abs().max(high.abs());
        let near: Vec<Known> = self
            .known
            .iter()
            .filter(|known| known.s.re > low - margin && known.s.re < high + margin)
            .copied()
            .collect();
        for known in near {
            let before = self.known.len();
            if let Some(Refined::Pair(centre, half)) = self.chi.pair(known.s)
                && self.keep_pair(centre, half)
                && self.known.len() > before
            {
                return true;
            }
        }
        for (centre, reach) in self.pairs.clone() {
            if (centre.re - 0.5 * (low + high)).abs() > margin.max(reach) {
                continue;
            }
            // Three or more in one place: count them in a small square and list the middle.
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
                    self.known.push(Known { s: centre, weight });
                }
                return true;
            }
        }
        false
    }

    /// No delay: the roots of a polynomial of degree four, or three without the rigid-body root.
    fn without_delay(mut self, count: usize) -> Found {
        let polynomial = self.chi.deflated_remainder();
        let degree = polynomial.len() - 1;
        let starts = complex_roots(polynomial);
        let zeros = polynomial.iter().take_while(|c| **c == 0.0).count();
        self.known.extend(std::iter::repeat_n(Known { s: Complex64::ZERO, weight: 1 }, zeros));
        for start in &starts[zeros..] {
            self.start(*start);
        }
        // A double root, to which two starts lead.
        for known in self.known.clone() {
            if self.right_of(f64::NEG_INFINITY) >= degree {
                break;
            }
            if let Some(Refined::Pair(centre, half)) = self.chi.pair(known.s) {
                self.keep_pair(centre, half);
            }
        }
        let found = self.right_of(f64::NEG_INFINITY);
        let certificate = if found == degree {
            Certificate::Complete
        } else {
            Certificate::Failed { counted: degree, found }
        };
        self.finish(count, f64::NEG_INFINITY, certificate)
    }

    fn finish(mut self, count: usize, depth: f64, certificate: Certificate) -> Found {
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
        Found { roots, certificate, depth }
    }
}
