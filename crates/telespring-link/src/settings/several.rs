//! A value, or a list of values.

use std::fmt::{self, Display};
use std::marker::PhantomData;
use std::str::FromStr;

use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};

/// The most values of a list.
const MOST: usize = 16;

/// One text, or up to 16 of them in a list, each read as a `T`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Several<T>(pub(super) Vec<T>);

impl<T> Default for Several<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

struct Reader<T>(PhantomData<T>);

impl<'de, T: FromStr<Err: Display>> Visitor<'de> for Reader<T> {
    type Value = Several<T>;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "a text, or a list of up to {MOST} texts")
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Self::Value, E> {
        text.parse().map(|value| Several(vec![value])).map_err(E::custom)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Value, A::Error> {
        let mut values = Vec::new();
        while let Some(text) = list.next_element::<String>()? {
            if values.len() == MOST {
                return Err(A::Error::custom(format!("more than {MOST} entries")));
            }
            values.push(text.parse().map_err(A::Error::custom)?);
        }
        Ok(Several(values))
    }
}

impl<'de, T: FromStr<Err: Display>> Deserialize<'de> for Several<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Reader(PhantomData))
    }
}
