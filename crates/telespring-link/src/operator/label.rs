//! A short text of fixed size, so that the loop can hand it on without allocating.

/// Up to 64 printable ASCII characters.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Label {
    bytes: [u8; Self::CAPACITY],
    length: u8,
}

impl Label {
    /// The most characters.
    pub const CAPACITY: usize = 64;

    /// The label with this text; `None` if it is empty, longer than 64 characters, or has one that is not printable ASCII.
    pub fn new(text: &str) -> Option<Self> {
        let is_printable = text.bytes().all(|byte| (b' '..=b'~').contains(&byte));
        if text.is_empty() || text.len() > Self::CAPACITY || !is_printable {
            return None;
        }
        let mut bytes = [0; Self::CAPACITY];
        bytes.iter_mut().zip(text.bytes()).for_each(|(place, byte)| *place = byte);
        Some(Self { bytes, length: u8::try_from(text.len()).ok()? })
    }

    /// What can be shown of a text: its first characters, and `?` for each that is not printable ASCII.
    pub fn shown(text: &str) -> Self {
        let mut label = Self { bytes: [0; Self::CAPACITY], length: 0 };
        for (place, letter) in label.bytes.iter_mut().zip(text.chars()) {
            let byte = u8::try_from(letter).unwrap_or(0);
            *place = if (b' '..=b'~').contains(&byte) { byte } else { b'?' };
            label.length += 1;
        }
        label
    }

    /// A whole number as text.
    pub fn number(value: u32) -> Self {
        let mut label = Self { bytes: [0; Self::CAPACITY], length: 0 };
        let mut unit = 1_000_000_000;
        while unit > 0 {
            let digit = value / unit % 10;
            if label.length > 0 || digit > 0 || unit == 1 {
                if let Some(place) = label.bytes.get_mut(usize::from(label.length)) {
                    *place = b'0' + u8::try_from(digit).unwrap_or(0);
                }
                label.length += 1;
            }
            unit /= 10;
        }
        label
    }

    /// The text.
    pub fn text(&self) -> &str {
        let bytes = self.bytes.get(..usize::from(self.length)).unwrap_or_default();
        std::str::from_utf8(bytes).unwrap_or_default()
    }
}

impl std::fmt::Debug for Label {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{:?}", self.text())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_any_text_is_shown_as_printable_letters() {
        for (text, shown) in [("consnt", "consnt"), ("f\u{fc}r \u{1b}[2J", "f?r ?[2J"), ("", "")] {
            assert_eq!(Label::shown(text).text(), shown);
        }
        assert_eq!(Label::shown(&"x".repeat(1000)).text().len(), Label::CAPACITY);
    }

    #[test]
    fn law_a_number_reads_as_people_write_it() {
        for value in [0, 7, 10, 4_294_967_295] {
            assert_eq!(Label::number(value).text(), value.to_string());
        }
    }
}
