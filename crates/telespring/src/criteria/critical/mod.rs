//! The critical stiffness: below it no constant delay destabilises.

mod free;
mod grounded;

use super::polynomial::crossing_roots;
use crate::error::Result;
use crate::model::DyadAxis;
use crate::quantity;

/// True if no constant delay destabilises: the undelayed dyad is stable and no characteristic root ever
/// reaches the imaginary axis.
///
/// # Errors
///
/// [`InvalidInput`](crate::InvalidInput) if the stiffness (N/m) is out of range.
pub fn is_delay_independent(axis: &DyadAxis, stiffness: f64) -> Result<bool> {
    quantity::STIFFNESS.check("stiffness", stiffness)?;
    Ok(crossing_roots(axis, stiffness).is_empty())
}

/// The critical stiffness k_m, N/m: below it no constant delay destabilises. 0 if every stiffness has a
/// destabilising delay.
///
/// It is the smallest stiffness at which F, the polynomial of the crossing frequencies (the paper's Eq. 8
/// with operators and coupling damping), has a positive root. The paper's Eq. 5 only requires F(0) ≥ 0, and
/// is too large if the robots' damping differs much.
///
/// With free handles, F falls with k at a fixed ratio y = ω²/k. The roots therefore appear once, either at
/// y = 0 (Eq. 5) or at a tangency, the maximum of a quasi-concave function of y. With a grounded operator,
/// the smallest k on the curve F = 0 is bounded by subdivision with Bernstein coefficients, which enclose F
/// on a whole box.
///
/// # Examples
///
/// ```
/// use telespring::{DyadAxis, criteria::critical_stiffness};
/// let k = critical_stiffness(&DyadAxis::new(1.0, 1.0, 1.0, 10.0)?);
/// assert!((k - 9.4610953).abs() < 1e-7);
/// # Ok::<(), telespring::InvalidInput>(())
/// ```
pub fn critical_stiffness(axis: &DyadAxis) -> f64 {
    if axis.is_free() { free::critical_stiffness(axis) } else { grounded::critical_stiffness(axis) }
}
