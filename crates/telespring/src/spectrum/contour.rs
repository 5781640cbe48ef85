//! Counts the zeros of an analytic function inside a contour by the argument principle.
//!
//! An analytic function with n zeros inside a closed contour, and none on it, winds n times around 0 along
//! that contour. Summing principal arguments between samples gives the winding only if the function cannot
//! wind unnoticed between two samples. Every step is therefore certified by the function itself, through
//! [`Winding::probe`]: along the step its values stay in a region around the first one that excludes 0.

use num_complex::Complex64;

/// A function whose argument can be followed along a straight line.
pub trait Winding {
    /// The value at `point` of the contour, and a step along `direction` (of modulus 1) over which the
    /// argument provably changes by less than π.
    ///
    /// `longest` is the distance to the end of the segment; a longer step is useless.
    fn probe(&self, point: Complex64, direction: Complex64, longest: f64) -> Probe;
}

/// The result of [`Winding::probe`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Probe {
    /// The value of the function or a positive multiple of it; only its argument is used.
    pub value: Complex64,
    /// The length of the safe step; 0 if the value is 0.
    pub step: f64,
}

/// Why the zeros could not be counted.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum ContourError {
    /// The safe steps shrank to nothing: a zero lies on the contour or too close to it. Move the contour.
    NearZero {
        /// The point where the steps ended.
        at: Complex64,
    },
    /// More steps were needed than allowed.
    StepsExhausted {
        /// The point where the steps ended.
        at: Complex64,
    },
}

impl std::fmt::Display for ContourError {
    /// Writes why the zeros in a contour were not counted.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NearZero { at } => write!(f, "the contour passes too close to a root near {at}"),
            Self::StepsExhausted { at } => {
                write!(f, "the contour needs more steps than allowed; it stopped at {at}")
            }
        }
    }
}

/// The fraction of |f| that a step may use; the rest covers rounding.
const SHARE: f64 = 0.9;

/// A safe step along a contour from the value, the derivative and a bound on the second derivative of a function.
///
/// The step h satisfies |f'| h + M h²/2 ≤ 0.9 |f|, where M = `curvature(radius)` bounds |f''| over the next
/// `radius` of the line. f then stays in a disc around its value that excludes 0, and its argument changes
/// by less than π/2. Returns 0 if f is 0 or a number is not finite.
///
/// # Examples
///
/// ```
/// use telespring::spectrum::contour::taylor_step;
/// // f(s) = s² at s = 1: |f| = 1, |f'| = 2, |f''| = 2
/// let step = taylor_step(1.0, 2.0, |_| 2.0, 10.0);
/// assert!(2.0 * step + step * step <= 0.9 + 1e-12);
/// ```
pub fn taylor_step(value: f64, derivative: f64, curvature: impl Fn(f64) -> f64, longest: f64) -> f64 {
    let room = SHARE * value;
    // The step without curvature is an upper bound. Reducing it keeps the radius small, and with it the
    // bound M where M grows fast (an exponential).
    let mut radius = longest.min(room / derivative);
    let mut best: f64 = 0.0;
    for _ in 0..40 {
        if !(radius.is_finite() && radius > 0.0) {
            break;
        }
        let bound = curvature(radius);
        let step =
            (2.0 * room / (derivative + (derivative * derivative + 2.0 * bound * room).sqrt())).min(radius);
        if step.is_finite() && step > best {
            best = step;
        }
        if best >= 0.5 * radius {
            break;
        }
        radius *= 0.25;
    }
    best
}

/// The change of the argument along the segment of a contour from `from` to `to`, rad.
///
/// # Errors
///
/// [`ContourError`] if the segment passes too close to a zero or needs more than `steps` steps; the steps
/// used are subtracted from `steps`.
///
/// # Examples
///
/// ```
/// use num_complex::Complex64;
/// use telespring::spectrum::contour::{Probe, Winding, argument_change, taylor_step};
/// struct Identity;
/// impl Winding for Identity {
///     fn probe(&self, point: Complex64, _: Complex64, longest: f64) -> Probe {
///         Probe { value: point, step: taylor_step(point.norm(), 1.0, |_| 0.0, longest) }
///     }
/// }
/// let turn = argument_change(&Identity, Complex64::new(1.0, -1.0), Complex64::new(1.0, 1.0), &mut 100);
/// assert!((turn.unwrap() - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
/// ```
pub fn argument_change<F: Winding + ?Sized>(
    function: &F,
    from: Complex64,
    to: Complex64,
    steps: &mut usize,
) -> Result<f64, ContourError> {
    let length = (to - from).norm();
    if length == 0.0 {
        return Ok(0.0);
    }
    let direction = (to - from) / length;
    let mut done = 0.0;
    let mut point = from;
    let mut turn = 0.0;
    let mut probe = function.probe(point, direction, length);
    loop {
        let remaining = length - done;
        let smallest = (32.0 * f64::EPSILON * point.norm().max(length)).min(0.5 * remaining);
        if probe.step.is_nan() || probe.step <= smallest {
            return Err(ContourError::NearZero { at: point });
        }
        if *steps == 0 {
            return Err(ContourError::StepsExhausted { at: point });
        }
        *steps -= 1;
        let last = probe.step >= remaining;
        done += probe.step;
        point = if last { to } else { from + direction * done };
        let next = function.probe(point, direction, length - done);
        turn += (next.value * probe.value.conj()).arg();
        if last {
            return Ok(turn);
        }
        probe = next;
    }
}

/// The number of zeros inside the rectangle with these corners, counted with multiplicity.
///
/// # Errors
///
/// [`ContourError`] as for [`argument_change`], with `steps` for the whole contour.
///
/// # Examples
///
/// ```
/// # use num_complex::Complex64;
/// # use telespring::spectrum::contour::{Probe, Winding, taylor_step, zeros_in_rectangle};
/// struct Square; // s² + 1: zeros at ±i
/// impl Winding for Square {
///     fn probe(&self, s: Complex64, _: Complex64, longest: f64) -> Probe {
///         let value = s * s + 1.0;
///         Probe { value, step: taylor_step(value.norm(), 2.0 * s.norm(), |_| 2.0, longest) }
///     }
/// }
/// let corners = (Complex64::new(-1.0, 0.0), Complex64::new(1.0, 2.0));
/// assert_eq!(zeros_in_rectangle(&Square, corners.0, corners.1, 1000), Ok(1));
/// ```
pub fn zeros_in_rectangle<F: Winding + ?Sized>(
    function: &F,
    lower_left: Complex64,
    upper_right: Complex64,
    steps: usize,
) -> Result<usize, ContourError> {
    let lower_right = Complex64::new(upper_right.re, lower_left.im);
    let upper_left = Complex64::new(lower_left.re, upper_right.im);
    let mut steps = steps;
    let mut turn = 0.0;
    for (from, to) in [
        (lower_left, lower_right),
        (lower_right, upper_right),
        (upper_right, upper_left),
        (upper_left, lower_left),
    ] {
        turn += argument_change(function, from, to, &mut steps)?;
    }
    Ok(whole_turns(turn))
}

/// The number of zeros with real part above `abscissa`, counted with multiplicity, of a function with
/// conjugate values at conjugate points and no such zero farther than `radius` from 0.
///
/// Only the upper half of the contour is followed. If `radius` is not a proven bound, the result counts the
/// zeros in the rectangle `abscissa` ≤ Re s ≤ `radius`, |Im s| ≤ `radius`.
///
/// # Errors
///
/// [`ContourError`] as for [`argument_change`], with `steps` for the whole contour.
///
/// # Examples
///
/// ```
/// # use num_complex::Complex64;
/// # use telespring::spectrum::contour::{Probe, Winding, taylor_step, zeros_right_of};
/// struct Square; // s² + 1: zeros at ±i
/// impl Winding for Square {
///     fn probe(&self, s: Complex64, _: Complex64, longest: f64) -> Probe {
///         let value = s * s + 1.0;
///         Probe { value, step: taylor_step(value.norm(), 2.0 * s.norm(), |_| 2.0, longest) }
///     }
/// }
/// assert_eq!(zeros_right_of(&Square, -0.5, 2.0, 1000), Ok(2));
/// assert_eq!(zeros_right_of(&Square, 0.5, 2.0, 1000), Ok(0));
/// ```
pub fn zeros_right_of<F: Winding + ?Sized>(
    function: &F,
    abscissa: f64,
    radius: f64,
    steps: usize,
) -> Result<usize, ContourError> {
    // Extends past the bound, so that a zero on the bound is inside.
    let far = (1.5 * radius).max(abscissa.abs() * f64::EPSILON);
    if abscissa >= far {
        return Ok(0);
    }
    let mut steps = steps;
    let mut turn = 0.0;
    let corners = [
        Complex64::new(far, 0.0),
        Complex64::new(far, far),
        Complex64::new(abscissa, far),
        Complex64::new(abscissa, 0.0),
    ];
    for side in corners.windows(2) {
        turn += argument_change(function, side[0], side[1], &mut steps)?;
    }
    Ok(whole_turns(2.0 * turn))
}

/// The number of whole turns along a closed contour in an angle (rad): an integer up to rounding, never negative.
fn whole_turns(turn: f64) -> usize {
    (turn / std::f64::consts::TAU).round().max(0.0) as usize
}
