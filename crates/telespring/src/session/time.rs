//! Points and spans of time in nanoseconds.

/// A point or a span of time in whole nanoseconds.
///
/// # Examples
///
/// ```
/// use telespring::session::Nanoseconds;
///
/// assert_eq!(Nanoseconds::from_seconds(0.0835), Nanoseconds(83_500_000));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Nanoseconds(pub u64);

impl Nanoseconds {
    /// The nearest whole number of nanoseconds; 0 for a negative span or NaN, the longest span beyond 584
    /// years.
    pub fn from_seconds(seconds: f64) -> Self {
        Self((seconds * 1e9).round() as u64)
    }

    /// The time in seconds.
    pub fn seconds(self) -> f64 {
        self.0 as f64 * 1e-9
    }

    /// The sum, saturating at the latest time.
    pub fn plus(self, span: Self) -> Self {
        Self(self.0.saturating_add(span.0))
    }

    /// The time `span` earlier, if there is one.
    pub fn before(self, span: Self) -> Option<Self> {
        self.0.checked_sub(span.0).map(Self)
    }
}
