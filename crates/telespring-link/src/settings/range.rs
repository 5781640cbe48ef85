//! A value within a range, or a refusal.

use telespring::InvalidInput;
use telespring::session::Span;

/// A span of time in seconds within a range.
pub(super) fn span(
    field: &str,
    seconds: f64,
    [least, most]: [f64; 2],
    usual: f64,
) -> Result<Span, InvalidInput> {
    if seconds >= least && seconds <= most {
        return Ok(Span::from_seconds(seconds));
    }
    let allowed = format!("{least} to {most} s");
    Err(InvalidInput::new(field, format!("{seconds} s"), allowed, format!("Give {usual}.")))
}
