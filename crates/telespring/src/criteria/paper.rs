//! The paper's own criteria as printed (Du, Kulkarni, Kager, Campolo, Eqs. 5 to 9), for comparison with the
//! exact ones.

use super::polynomial::crossing_roots;
use crate::error::{InvalidInput, Result};
use crate::model::DyadAxis;
use crate::quantity;

/// Rejects an axis that the paper's equations do not cover: grounded operators and coupling damping.
fn check_paper_applies(axis: &DyadAxis) -> Result<()> {
    if axis.is_free() && axis.coupling_damping == 0.0 {
        return Ok(());
    }
    Err(InvalidInput::new(
        "method",
        "\"paper\"",
        "the paper's equations hold for free handles without coupling damping",
        "Use the exact method, or set kh1, kh2 and c to 0.",
    ))
}

/// The paper's critical stiffness (Eq. 5), N/m: (b₁² + b₂²) / (2 (m₁ + m₂)).
///
/// It is necessary but not sufficient for stability at every constant delay: see
/// [`critical_stiffness`](super::critical_stiffness).
///
/// # Errors
///
/// [`InvalidInput`] if an operator has stiffness or there is a coupling damping: the paper covers neither.
///
/// # Examples
///
/// ```
/// use telespring::{DyadAxis, criteria::paper_critical_stiffness};
/// assert_eq!(paper_critical_stiffness(&DyadAxis::new(1.0, 1.0, 1.0, 10.0)?)?, 25.25);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
pub fn paper_critical_stiffness(axis: &DyadAxis) -> Result<f64> {
    check_paper_applies(axis)?;
    let [first, second] = &axis.sides;
    let damping = first.damping.powi(2) + second.damping.powi(2);
    Ok(damping / (2.0 * (first.mass + second.mass)))
}

/// The paper's maximum delay (Eqs. 5 to 9), s: infinite up to its critical stiffness, and above it the
/// smallest −arg(z)/ω over the positive roots of Eq. 8. 0 if neither side is damped: Eq. 9 then divides by
/// m₁b₂ + m₂b₁ = 0, and an undamped motion allows no delay.
///
/// # Errors
///
/// [`InvalidInput`] if the stiffness is out of range or the paper does not cover the axis.
pub fn paper_maximum_delay(axis: &DyadAxis, stiffness: f64) -> Result<f64> {
    quantity::STIFFNESS.check("stiffness", stiffness)?;
    if stiffness <= paper_critical_stiffness(axis)? {
        return Ok(f64::INFINITY);
    }
    let [first, second] = &axis.sides;
    if first.damping == 0.0 && second.damping == 0.0 {
        return Ok(0.0);
    }
    let shortest = crossing_roots(axis, stiffness).iter().fold(f64::INFINITY, |shortest, root| {
        let squared = root.at * stiffness;
        let frequency = squared.sqrt();
        let [a1, a2] = [first, second].map(|side| {
            num_complex::Complex64::new(side.mass * squared - stiffness, -side.damping * frequency)
        });
        // B of Eq. 9; if it is zero its sign is zero too, and the formula gives a delay of zero.
        let b = squared
            - stiffness * (first.damping + second.damping)
                / (first.mass * second.damping + second.mass * first.damping);
        let sign = if b == 0.0 { 0.0 } else { b.signum() };
        let z = (a1 * a2).sqrt() * sign / stiffness;
        shortest.min(-z.arg() / frequency)
    });
    Ok(shortest)
}
