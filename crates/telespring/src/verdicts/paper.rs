//! The paper's verdict on a dyad: Eq. 5, Eqs. 6 to 9 and Eq. 11 as printed.

use crate::criteria::{paper_critical_stiffness, paper_maximum_delay};
use crate::error::Result;
use crate::model::{DyadAxis, Side};

/// The verdict of the paper's formulas, including where they are wrong.
///
/// The formulas ignore an operator's stiffness and the coupling damping; masses and dampings of the
/// operators are included.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PaperVerdict {
    /// k̄_m of Eq. 11, N/m, from Eq. 5.
    pub critical_stiffness: f64,
    /// The axis with that stiffness.
    pub critical_axis: usize,
    /// δ̄_m of Eq. 11, s, from Eqs. 6 to 9; infinite if the stiffness is at most k̄_m.
    pub maximum_delay: f64,
    /// The axis with that delay.
    pub delay_axis: usize,
    /// k ≤ k̄_m, or δ < δ̄_m.
    pub stable: bool,
    /// True if the exact verdict for this constant delay (tier 4) is the same.
    pub agrees: bool,
}

/// The axis as the paper's formulas take it: no operator stiffness, no coupling damping.
fn as_printed(axis: &DyadAxis) -> DyadAxis {
    DyadAxis { sides: axis.sides.map(|side| Side { ground_stiffness: 0.0, ..side }), coupling_damping: 0.0 }
}

/// The paper's critical stiffness (Eq. 5), N/m.
pub(super) fn critical_stiffness(axis: &DyadAxis) -> Result<f64> {
    paper_critical_stiffness(&as_printed(axis))
}

/// The paper's maximum delay (Eqs. 6 to 9), s; infinite if Eq. 5 promises stability.
pub(super) fn maximum_delay(axis: &DyadAxis, stiffness: f64) -> Result<f64> {
    paper_maximum_delay(&as_printed(axis), stiffness)
}
