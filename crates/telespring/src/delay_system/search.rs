//! The search for roots that collocation missed: a vertical line with enough roots to its right, starts
//! along that line, and finally rectangles halved until each contains one missing root.

use num_complex::Complex64;

use super::known_roots::{KnownRoot, count_in_rectangle, count_right_of, refine_and_insert};
use super::matrix::CharacteristicMatrix;
use crate::spectrum::contour::{ContourError, zeros_in_rectangle};

/// The maximum number of steps of one contour in the search for a line.
const LINE_STEPS: usize = 100_000;
/// The maximum number of steps of the contour of one rectangle, and of rectangles.
const RECTANGLE_STEPS: usize = 20_000;
const MAX_RECTANGLES: usize = 80;
/// The search for a line ends after this many lines with too many steps: each costs a second.
const MAX_REFUSED: usize = 4;
/// With more roots than this right of a line, the search continues further right.
pub(super) const MAX_TO_FIND: usize = 6_000;

/// The affordable number of Newton starts in the search for roots: inverting n × n matrices costs n³.
fn newton_start_limit(matrix: &CharacteristicMatrix) -> usize {
    (1_300_000 / matrix.size().pow(3)).clamp(200, 20_000)
}

/// A line for the search with at least `count` roots to its right and not many more, with their number.
///
/// `hint` is the first line to try. `None` if no such line could be counted.
pub(super) fn line_with_roots_right_of(
    matrix: &CharacteristicMatrix,
    count: usize,
    hint: f64,
) -> Option<(f64, usize)> {
    let longest = matrix.longest_delay();
    let counted = |sigma: f64| -> Result<(f64, usize), ContourError> {
        let mut line = sigma;
        let mut nudge = 1e-9 * (sigma.abs() + 1e-3 / longest);
        loop {
            match matrix.roots_right_of(line, LINE_STEPS) {
                Err(ContourError::NearZero { .. }) if nudge < 1e-3 * (sigma.abs() + 1e-3 / longest) => {
                    line = sigma - nudge;
                    nudge *= 16.0;
                }
                other => return other.map(|number| (line, number)),
            }
        }
    };
    let mut shallow = matrix.root_radius(0.0);
    let mut deep = None;
    let mut sigma = hint.min(-1.0 / longest);
    let mut too_deep = f64::NEG_INFINITY;
    let mut refused = 0;
    for _ in 0..80 {
        match counted(sigma) {
            Ok((line, number)) if number >= count => {
                deep = Some((line, number));
                if number <= 2 * count + 8 {
                    return deep;
                }
                too_deep = line;
            }
            Ok((line, _)) => shallow = line,
            Err(_) => {
                too_deep = sigma;
                refused += 1;
            }
        }
        sigma = if too_deep > f64::NEG_INFINITY {
            if shallow - too_deep <= 1e-12 * (shallow.abs() + too_deep.abs()) {
                break;
            }
            0.5 * (shallow + too_deep)
        } else {
            2.0 * sigma
        };
        if -sigma * longest > 600.0 || refused >= MAX_REFUSED {
            break;
        }
    }
    deep
}

/// Searches for the roots right of `depth` until `counted` are known or all methods are exhausted.
pub(super) fn search_right_of(
    matrix: &CharacteristicMatrix,
    known: &mut Vec<KnownRoot>,
    depth: f64,
    counted: usize,
) {
    // Balancing for this line keeps the bound on the roots small.
    let matrix = &matrix.rebalanced(depth);
    let top = matrix.root_radius(depth);
    let right = matrix.root_radius(depth.max(0.0));
    if !top.is_finite() {
        return;
    }
    let mut starts = newton_start_limit(matrix);
    // From the left of a chain of roots Newton's method converges to it; roots further right that do not
    // come from the delay are reached from further right.
    for share in [0.0, 0.03, 0.3] {
        start_newton_along_line(
            matrix,
            known,
            (depth, depth + share * (right - depth)),
            top,
            counted,
            &mut starts,
        );
        if count_right_of(known, depth) >= counted || starts == 0 {
            break;
        }
    }
    if count_right_of(known, depth) < counted {
        bisect_rectangles(matrix, known, depth, Complex64::new(right, top), counted);
    }
}

/// Searches by Newton's method along the line Re s = `sigma`, so densely that det Δ turns little between starts.
fn start_newton_along_line(
    matrix: &CharacteristicMatrix,
    known: &mut Vec<KnownRoot>,
    (depth, sigma): (f64, f64),
    top: f64,
    counted: usize,
    starts: &mut usize,
) {
    let longest = matrix.longest_delay();
    // Roots of a chain are at least this far apart on average: det Δ holds n delays in all.
    let finest = 0.5 / (matrix.size() as f64 * longest);
    let coarsest = 1.5 / longest;
    let mut y = 0.0;
    while y <= top && *starts > 0 {
        let s = Complex64::new(sigma, y);
        *starts -= 1;
        if refine_and_insert(matrix, known, s) && count_right_of(known, depth) >= counted {
            return;
        }
        let step = matrix.newton_step(s).norm();
        y += if step.is_finite() { (1.5 * step).clamp(finest, coarsest.max(1e-4 * top)) } else { finest };
    }
}

/// Searches rectangles: counts the roots in them, halves those with unknown roots, and starts Newton's method
/// in them.
fn bisect_rectangles(
    matrix: &CharacteristicMatrix,
    known: &mut Vec<KnownRoot>,
    depth: f64,
    corner: Complex64,
    counted: usize,
) {
    // The lower edge leaves room for real roots, which must not lie on it.
    let bottom = -1e-3 * (corner.im + 1.0 / matrix.longest_delay());
    let mut waiting = vec![(Complex64::new(depth, bottom), corner * 1.01)];
    let mut tried = 0;
    while let Some((low, high)) = waiting.pop() {
        if tried >= MAX_RECTANGLES || count_right_of(known, depth) >= counted {
            return;
        }
        tried += 1;
        if let Ok(number) = zeros_in_rectangle(matrix, low, high, RECTANGLE_STEPS)
            && number <= count_in_rectangle(known, low, high)
        {
            continue;
        }
        let size = high - low;
        for (x, y) in [(0.5, 0.5), (0.05, 0.25), (0.05, 0.75), (0.7, 0.3), (0.7, 0.8)] {
            refine_and_insert(matrix, known, low + Complex64::new(x * size.re, y * size.im));
        }
        if size.norm() <= 1e-7 * high.norm() {
            continue;
        }
        // Not the middle: roots of simple systems lie on round numbers.
        if size.re > size.im {
            let middle = low.re + 0.483 * size.re;
            waiting.push((low, Complex64::new(middle, high.im)));
            waiting.push((Complex64::new(middle, low.im), high));
        } else {
            let middle = low.im + 0.483 * size.im;
            waiting.push((low, Complex64::new(high.re, middle)));
            waiting.push((Complex64::new(low.re, middle), high));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Delay, hman};

    #[test]
    fn law_halving_alone_finds_every_root_that_is_counted() {
        let axis = hman().axis(0).unwrap();
        let system = axis.delay_system(71.2, &Delay::new(0.1, 0.2).unwrap()).unwrap();
        let matrix = CharacteristicMatrix::balanced(&system, -22.0);
        let counted = matrix.roots_right_of(-22.0, LINE_STEPS).unwrap();
        assert_eq!(counted, 7);
        let mut known = Vec::new();
        let corner = Complex64::new(matrix.root_radius(0.0), matrix.root_radius(-22.0));
        bisect_rectangles(&matrix, &mut known, -22.0, corner, counted);
        assert_eq!(count_right_of(&known, -22.0), counted);
    }

    #[test]
    fn law_a_line_has_the_roots_it_was_asked_for() {
        let axis = hman().axis(0).unwrap();
        for (forward, backward) in [(6e-6, 1.4e-5), (0.1, 0.2), (43.0, 99.0)] {
            let system = axis.delay_system(71.2, &Delay::new(forward, backward).unwrap()).unwrap();
            let matrix = CharacteristicMatrix::balanced(&system, 0.0);
            for count in [1, 8, 40] {
                let (line, counted) = line_with_roots_right_of(&matrix, count, 0.0).unwrap();
                assert!((count..=2 * count + 8).contains(&counted), "{forward}: {counted} of {count}");
                assert_eq!(matrix.roots_right_of(line, LINE_STEPS), Ok(counted));
            }
        }
    }
}
