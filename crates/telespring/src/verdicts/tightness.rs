//! When a certified bound over a range counts as tight.

/// A bound counts as tight up to this ratio of the truth to it: at most 5 % may be given away.
pub(super) const LOOSE: f64 = 1.05;

/// True if a bound is tight beside the smallest one found for a single pair of operators: the truth lies between both.
pub(super) fn is_tight(bound: f64, least_found: f64) -> bool {
    LOOSE * bound >= least_found
}
