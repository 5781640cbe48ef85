//! What Du, Kulkarni, Kager and Campolo would say: Eq. 5, Eq. 6–9 and Eq. 11, as printed.

use crate::criteria::{paper_critical_stiffness, paper_maximum_delay};
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
pub(super) fn critical_stiffness(axis: &DyadAxis) -> Result<f64> {
    paper_critical_stiffness(&as_printed(axis))
}

/// Eq. 6 with Eq. 7–9, s; infinite where Eq. 5 promises stability.
pub(super) fn maximum_delay(axis: &DyadAxis, stiffness: f64) -> Result<f64> {
    paper_maximum_delay(&as_printed(axis), stiffness)
}
