//! The error type for invalid input.

/// An invalid value, with the allowed range and a remedy.
///
/// # Examples
///
/// ```
/// let refused = telespring::Robot::new(vec![-1.0], vec![4.0], None).unwrap_err();
/// assert_eq!(refused.field, "mass[0]");
/// assert!(refused.to_string().contains("-1"));
/// ```
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{} {remedy}", self.statement())]
#[non_exhaustive]
pub struct InvalidInput {
    /// The field, such as `robot1.mass[0]`.
    pub field: String,
    /// The value as given; empty if it is missing.
    pub value: String,
    /// The allowed values, with their unit; only the unit if the value is missing.
    pub allowed: String,
    /// How to correct the input, as a full sentence.
    pub remedy: String,
}

impl InvalidInput {
    /// Creates an error; `allowed` has no full stop, `remedy` is a full sentence.
    pub fn new(
        field: impl Into<String>,
        value: impl ToString,
        allowed: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self { field: field.into(), value: value.to_string(), allowed: allowed.into(), remedy: remedy.into() }
    }

    /// Creates an error for a missing value; `unit` may be empty, `remedy` is a full sentence.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring::InvalidInput;
    /// let missing = InvalidInput::missing("coupling.stiffness", "N/m", "Add stiffness = 20.0.");
    /// assert_eq!(missing.to_string(), "Missing coupling.stiffness (N/m). Add stiffness = 20.0.");
    /// ```
    pub fn missing(field: impl Into<String>, unit: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { field: field.into(), value: String::new(), allowed: unit.into(), remedy: remedy.into() }
    }

    /// True if the input value is missing.
    pub fn is_missing(&self) -> bool {
        self.value.is_empty()
    }

    /// The first sentence of the message: what is wrong, without the remedy.
    pub fn statement(&self) -> String {
        let Self { field, value, allowed, .. } = self;
        match (self.is_missing(), allowed.is_empty()) {
            (true, true) => format!("Missing {field}."),
            (true, false) => format!("Missing {field} ({allowed})."),
            (false, _) => format!("{field} = {value}: {allowed}."),
        }
    }

    /// The same input error with `prefix` and a dot before the field.
    #[must_use]
    pub fn within(mut self, prefix: &str) -> Self {
        self.field = format!("{prefix}.{}", self.field);
        self
    }
}

/// The result of checking input.
pub type Result<T> = std::result::Result<T, InvalidInput>;
