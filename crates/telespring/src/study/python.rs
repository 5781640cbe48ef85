//! Python objects named in a study: the class of an agent or the function of a target, with options. Rust
//! stores the text; Python imports it.

use std::collections::BTreeMap;

use toml::de::DeValue;

use super::entry::Entry;
use super::reader::Reader;
use crate::error::Result;

/// The value of an option.
#[derive(Debug, Clone, PartialEq)]
pub enum OptionValue {
    /// True or false.
    Boolean(bool),
    /// A whole number.
    Whole(i64),
    /// A finite number with a decimal point.
    Number(f64),
    /// A text.
    Text(String),
    /// A list of such values.
    List(Vec<OptionValue>),
}

/// A Python class or function with its options.
#[derive(Debug, Clone, PartialEq)]
pub struct PythonObject {
    /// `module:name`; the module is next to the study file or installed.
    pub path: String,
    /// Keyword arguments.
    pub options: BTreeMap<String, OptionValue>,
}

/// Whether a word of a Python path is a valid identifier, as far as its letters decide.
fn is_identifier(word: &str) -> bool {
    let mut letters = word.chars();
    letters.next().is_some_and(|first| first.is_alphabetic() || first == '_')
        && letters.all(|letter| letter.is_alphanumeric() || letter == '_')
}

/// Reads the Python object of a section with its options.
pub(super) fn read_python_object(
    reader: &Reader<'_>,
    section: &str,
    key: &str,
    like: &str,
) -> Result<PythonObject> {
    let entry = reader.require(section, key, "", &format!("\"{like}\""))?;
    let path = entry.text()?;
    let well_formed = path.split_once(':').is_some_and(|(module, name)| {
        [module, name].iter().all(|dotted| dotted.split('.').all(is_identifier))
    });
    if !well_formed {
        return Err(entry.reject(
            "a module and a name in it are required, separated by a colon",
            format!("Write, for example, \"{like}\"."),
        ));
    }
    let mut options = BTreeMap::new();
    if let Some(entry) = reader.get(section, "options") {
        for (name, value) in entry.members()? {
            if !is_identifier(&name) {
                return Err(value.reject(
                    "the name of an option consists of letters, digits and _, and does not begin with a digit",
                    "Use the name of a Python argument.",
                ));
            }
            options.insert(name, read_option(&value)?);
        }
    }
    Ok(PythonObject { path, options })
}

/// Reads the value of an option of a Python object.
fn read_option(entry: &Entry<'_, '_>) -> Result<OptionValue> {
    let refused = |remedy: &str| {
        entry.reject("an option is a finite number, a string, true, false or a list of these", remedy)
    };
    match entry.value() {
        DeValue::Boolean(value) => Ok(OptionValue::Boolean(*value)),
        DeValue::String(_) => entry.text().map(OptionValue::Text),
        DeValue::Integer(integer) => i64::from_str_radix(integer.as_str(), integer.radix())
            .map(OptionValue::Whole)
            .map_err(|_| refused("Write a smaller number.")),
        DeValue::Float(float) => float
            .as_str()
            .parse()
            .ok()
            .filter(|value: &f64| value.is_finite())
            .map(OptionValue::Number)
            .ok_or_else(|| refused("Replace it by a finite number.")),
        DeValue::Array(_) => {
            let items = entry.items("values")?;
            Ok(OptionValue::List(items.iter().map(read_option).collect::<Result<_>>()?))
        }
        _ => Err(refused("Give the option a single value.")),
    }
}
