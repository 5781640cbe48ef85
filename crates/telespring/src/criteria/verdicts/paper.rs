//! What Du, Kulkarni, Kager and Campolo would say: Eq. 5, Eq. 6–9 and Eq. 11, as printed.

use num_complex::Complex64;

use super::seam::crossings;
use crate::error::Result;
use crate::model::{DyadAxis, Side};

/// The paper's verdict on a dyad, where it is wrong as well.
///
/// Its formulas know neither an operator's stiffness nor a coupling damping; the operators' masses and
/// dampings are counted in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PaperVerdict {
    /// k̄_m of Eq. 11, N/m, from Eq. 5.
    pub critical_stiffness: f64,
    /// The axis with that stiffness.
    pub critical_axis: usize,
    /// δ̄_m of Eq. 11, s, from Eq. 6–9; infinite where the stiffness is at most k̄_m.
    pub maximum_delay: f64,
    /// The axis with that delay.
    pub delay_axis: usize,
    /// k ≤ k̄_m, or δ < δ̄_m.
    pub stable: bool,
    /// True where the exact verdict on this constant delay (tier 4) is the same.
    pub agrees: bool,
}

/// The axis as the paper's formulas see it: no operator stiffness, no coupling damping.
fn as_printed(axis: &DyadAxis) -> DyadAxis {
    DyadAxis { sides: axis.sides.map(|side| Side { ground_stiffness: 0.0, ..side }), coupling_damping: 0.0 }
}

/// Eq. 5, N/m.
pub(super) fn critical_stiffness(axis: &DyadAxis) -> f64 {
    let [first, second] = axis.sides;
    (first.damping * first.damping + second.damping * second.damping) / (2.0 * (first.mass + second.mass))
}

/// Eq. 6 with Eq. 7–9, s, the least over the roots of F; infinite where Eq. 5 promises stability, and
/// `None` where sign(B) of Eq. 9 is 0.
pub(super) fn maximum_delay(axis: &DyadAxis, k: f64) -> Result<Option<f64>> {
    if k <= critical_stiffness(axis) {
        return Ok(Some(f64::INFINITY));
    }
    let printed = as_printed(axis);
    let [Side { mass: m1, damping: b1, .. }, Side { mass: m2, damping: b2, .. }] = printed.sides;
    let mut least = Some(f64::INFINITY);
    for crossing in crossings(&printed, k)? {
        let w = crossing.frequency;
        let a1 = Complex64::new(m1 * w * w - k, -b1 * w);
        let a2 = Complex64::new(m2 * w * w - k, -b2 * w);
        let b = w * w - k * (b1 + b2) / (m1 * b2 + m2 * b1);
        let z = (a1 * a2).sqrt() * b.signum() / k;
        let delay = if b == 0.0 { None } else { Some(-z.arg() / w) };
        least = least.zip(delay).map(|(least, delay)| least.min(delay));
    }
    Ok(least)
}
