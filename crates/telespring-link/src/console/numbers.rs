//! JSON for people: numbers without digits that mean nothing.

use std::io::{Result, Write};

use serde::Serialize;
use serde_json::Serializer;
use serde_json::ser::{CompactFormatter, Formatter, PrettyFormatter};

/// A number is written to so many parts of its unit: 1 ns, 1 nm, 1 nJ. Sums of binary fractions have digits behind that, such as
/// 0.000051200000000000004.
const PARTS: f64 = 1e9;

/// A formatter that rounds.
struct Rounding<F>(F);

/// Hands a call on to the formatter inside.
macro_rules! as_inside {
    ($($name:ident($($argument:ident: $kind:ty),*);)*) => {
        $(fn $name<W: ?Sized + Write>(&mut self, writer: &mut W $(, $argument: $kind)*) -> Result<()> {
            self.0.$name(writer $(, $argument)*)
        })*
    };
}

impl<F: Formatter> Formatter for Rounding<F> {
    fn write_f64<W: ?Sized + Write>(&mut self, writer: &mut W, value: f64) -> Result<()> {
        let rounded = (value * PARTS).round() / PARTS;
        // what is too large for that keeps its digits, and so does what it would make nothing of
        let is_kept = !rounded.is_finite() || (rounded == 0.0) != (value == 0.0);
        self.0.write_f64(writer, if is_kept { value } else { rounded })
    }

    as_inside! {
        begin_array();
        end_array();
        begin_array_value(first: bool);
        end_array_value();
        begin_object();
        end_object();
        begin_object_key(first: bool);
        end_object_key();
        begin_object_value();
        end_object_value();
    }
}

/// The object in one line.
///
/// # Errors
///
/// Those of its own serialisation.
pub fn line(content: &impl Serialize) -> serde_json::Result<Vec<u8>> {
    written(content, Rounding(CompactFormatter))
}

/// The object in many lines, indented.
///
/// # Errors
///
/// Those of its own serialisation.
pub fn lines(content: &impl Serialize) -> serde_json::Result<Vec<u8>> {
    written(content, Rounding(PrettyFormatter::new()))
}

fn written(content: &impl Serialize, formatter: impl Formatter) -> serde_json::Result<Vec<u8>> {
    let mut text = Vec::new();
    content.serialize(&mut Serializer::with_formatter(&mut text, formatter))?;
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_numbers_have_no_digits_that_mean_nothing_and_lose_none_that_do() {
        let numbers = [0.000_051_200_000_000_000_004, 0.1 + 0.2, -1e-15, 0.0, 1e300, 1_234.567_891_234];
        let text = String::from_utf8(line(&numbers).unwrap()).unwrap();
        assert_eq!(text, "[0.0000512,0.3,-1e-15,0.0,1e300,1234.567891234]");
        let content = serde_json::json!({"a": [0.3, null, true], "b": {}, "c": "0.30000000000000004"});
        let [line, lines] =
            [line(&content), lines(&content)].map(|text| String::from_utf8(text.unwrap()).unwrap());
        assert_eq!(line, serde_json::to_string(&content).unwrap());
        assert_eq!(lines, serde_json::to_string_pretty(&content).unwrap());
    }
}
