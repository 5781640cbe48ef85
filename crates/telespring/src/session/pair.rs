//! Arithmetic on the values of both axes.

/// The scalar product.
pub(super) fn dot([a, b]: [f64; 2], [c, d]: [f64; 2]) -> f64 {
    a * c + b * d
}

/// The length.
pub(super) fn size([a, b]: [f64; 2]) -> f64 {
    a.hypot(b)
}

/// A function of two values, per axis.
pub(super) fn zip([a, b]: [f64; 2], [c, d]: [f64; 2], combine: impl Fn(f64, f64) -> f64) -> [f64; 2] {
    [combine(a, c), combine(b, d)]
}

/// True if both values are finite.
pub(super) fn is_finite([a, b]: [f64; 2]) -> bool {
    a.is_finite() && b.is_finite()
}

/// The value if it is finite.
pub(super) fn finite_or(value: f64, otherwise: f64) -> f64 {
    if value.is_finite() { value } else { otherwise }
}
