//! Points of time on two clocks, and spans between them.
//!
//! The two sides have their own clocks. A point of time of one cannot be subtracted from a point of the other:
//! [`LocalTime`] and [`PeerTime`] are different types, and only a clock estimate turns one into the other.

use std::ops::{Add, Sub};

/// A span of time, ns; negative backwards.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Span(pub i64);

impl Span {
    /// The nearest whole number of nanoseconds; saturates beyond 292 years, 0 for NaN.
    pub fn from_seconds(seconds: f64) -> Self {
        Self((seconds * 1e9).round() as i64)
    }

    /// The span in seconds.
    pub fn seconds(self) -> f64 {
        self.0 as f64 * 1e-9
    }

    /// The span times a factor, to the nearest nanosecond; saturates.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        Self((self.0 as f64 * factor).round() as i64)
    }
}

impl Add for Span {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self(self.0.saturating_add(other.0))
    }
}

impl Sub for Span {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self(self.0.saturating_sub(other.0))
    }
}

/// A point of time of one clock.
macro_rules! point_of_time {
    ($(#[$meta:meta])* $name:ident, $other:ident) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
        pub struct $name(pub u64);

        impl $name {
            /// The nearest whole number of nanoseconds; 0 for a negative time or NaN, the latest time beyond 584
            /// years.
            pub fn from_seconds(seconds: f64) -> Self {
                Self((seconds * 1e9).round() as u64)
            }

            /// The time in seconds.
            pub fn seconds(self) -> f64 {
                self.0 as f64 * 1e-9
            }

            /// The point of time `span` earlier, if the clock reads that far back.
            pub fn checked_sub(self, span: Span) -> Option<Self> {
                self.0.checked_add_signed(span.0.checked_neg()?).map(Self)
            }

            /// The same reading of the same clock, as the other side calls it: what is local here is the partner's
            /// there.
            pub fn seen_by_peer(self) -> $other {
                $other(self.0)
            }
        }

        impl Add<Span> for $name {
            type Output = Self;

            fn add(self, span: Span) -> Self {
                Self(self.0.saturating_add_signed(span.0))
            }
        }

        impl Sub<Span> for $name {
            type Output = Self;

            fn sub(self, span: Span) -> Self {
                Self(self.0.saturating_add_signed(span.0.saturating_neg()))
            }
        }

        impl Sub for $name {
            type Output = Span;

            fn sub(self, earlier: Self) -> Span {
                let (later, sign) = if self >= earlier { (self.0 - earlier.0, 1) } else { (earlier.0 - self.0, -1) };
                Span(sign * i64::try_from(later).unwrap_or(i64::MAX))
            }
        }
    };
}

point_of_time!(
    /// A point of time of this side's clock, ns.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::session::{LocalTime, Span};
    ///
    /// let start = LocalTime::from_seconds(1.0);
    /// assert_eq!(start + Span(500), LocalTime(1_000_000_500));
    /// assert_eq!(LocalTime(3) - LocalTime(5), Span(-2));
    /// assert_eq!(LocalTime(3) - Span(5), LocalTime(0)); // no clock reads less
    /// ```
    ///
    /// The clocks of the two sides do not mix:
    ///
    /// ```compile_fail
    /// use telespring::session::{LocalTime, PeerTime};
    ///
    /// let age = LocalTime(5) - PeerTime(3);
    /// ```
    LocalTime,
    PeerTime
);
point_of_time!(
    /// A point of time of the partner's clock, ns; see [`LocalTime`].
    PeerTime,
    LocalTime
);
