//! What the people at a site tell the program while it runs: orders and markers, from the console or from a device.

mod console;
mod label;

pub use console::listen;
pub use label::Label;

/// What somebody at a site wants.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Order {
    /// The person at this site agrees to be coupled now.
    Consent,
    /// The person at this site does not agree any more: the force ramps out.
    Withdraw,
    /// The force ramps out on both sides; both stay connected.
    Pause,
    /// This site does not want the pause any more. Both must consent again.
    Resume,
    /// The session ends.
    Stop,
    /// Leaves the state after an emergency stop, once the button is released.
    Clear,
    /// A marker for the record.
    Mark(Mark),
    /// Something that is no order.
    Unknown(Label),
}

impl Order {
    /// A text that is no order.
    pub fn unknown(text: &str) -> Self {
        Self::Unknown(Label::shown(text))
    }

    /// The order in a word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Consent => "consent",
            Self::Withdraw => "withdraw",
            Self::Pause => "pause",
            Self::Resume => "resume",
            Self::Stop => "stop",
            Self::Clear => "clear",
            Self::Mark(_) => "mark",
            Self::Unknown(_) => "unknown",
        }
    }

    /// Whether it lets the force go: such an order comes before all others.
    pub fn lets_go(self) -> bool {
        matches!(self, Self::Withdraw | Self::Pause | Self::Stop)
    }

    /// The order in a line of text, without the side that it is for.
    ///
    /// # Examples
    ///
    /// ```
    /// use telespring_link::operator::{MarkKind, Order};
    ///
    /// assert_eq!(Order::parse("consent"), Order::Consent);
    /// let Order::Mark(mark) = Order::parse("mark trial  7 with eyes closed") else { panic!() };
    /// assert_eq!((mark.kind, mark.label.text()), (MarkKind::Trial, "7 with eyes closed"));
    /// // a code, not a name
    /// assert_eq!(Order::parse("mark participant Anna"), Order::unknown("mark participant Anna"));
    /// ```
    pub fn parse(line: &str) -> Self {
        let line = line.trim();
        let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let rest = rest.trim();
        match (word, rest.is_empty()) {
            ("mark", false) => Mark::parse(rest).map_or_else(|| Self::unknown(line), Self::Mark),
            ("consent", true) => Self::Consent,
            ("withdraw", true) => Self::Withdraw,
            ("pause", true) => Self::Pause,
            ("resume", true) => Self::Resume,
            ("stop", true) => Self::Stop,
            ("clear", true) => Self::Clear,
            _ => Self::unknown(line),
        }
    }
}

/// What a marker is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MarkKind {
    /// A trial begins.
    Trial,
    /// A condition begins.
    Condition,
    /// Who takes part, as a code; never a name.
    Participant,
    /// Anything else.
    Note,
}

impl MarkKind {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Trial, Self::Condition, Self::Participant, Self::Note];

    /// The kind in a word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Trial => "trial",
            Self::Condition => "condition",
            Self::Participant => "participant",
            Self::Note => "note",
        }
    }
}

/// A marker for the record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mark {
    /// What it is about.
    pub kind: MarkKind,
    /// What it says.
    pub label: Label,
}

/// The longest code of a participant.
const LONGEST_CODE: usize = 16;

impl Mark {
    /// A marker; `None` if the text is empty, too long or not printable, or is no code of a participant: up to 16 letters,
    /// digits, `-` and `_` with at least one digit, so that nobody's name gets into a record by habit.
    pub fn new(kind: MarkKind, text: &str) -> Option<Self> {
        let label = Label::new(text)?;
        let is_code = text.len() <= LONGEST_CODE
            && text.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'-' || byte == b'_')
            && text.bytes().any(|byte| byte.is_ascii_digit());
        (kind != MarkKind::Participant || is_code).then_some(Self { kind, label })
    }

    /// The marker in `KIND TEXT`.
    fn parse(text: &str) -> Option<Self> {
        let (word, rest) = text.split_once(char::is_whitespace)?;
        let kind = MarkKind::ALL.into_iter().find(|kind| kind.word() == word)?;
        Self::new(kind, rest.trim())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_an_order_is_one_line_and_anything_else_is_none() {
        for (line, order) in [
            (" consent\r\n", Order::Consent),
            ("withdraw", Order::Withdraw),
            ("pause", Order::Pause),
            ("resume", Order::Resume),
            ("stop", Order::Stop),
            ("clear", Order::Clear),
        ] {
            assert_eq!(Order::parse(line), order);
            assert_eq!(order.word(), line.trim());
        }
        let long = format!("mark note {}", "x".repeat(65));
        for line in [
            "",
            "consent now",
            "Consent",
            "start",
            "mark",
            "mark trial",
            "mark lunch 3",
            "mark note \u{7}",
            "mark note für",
            "mark participant P 1",
            "mark participant Anna",
            "mark participant 12345678901234567",
            &long,
        ] {
            assert_eq!(Order::parse(line), Order::unknown(line), "{line:?}");
        }
        for (line, kind, text) in [
            ("mark trial 1", MarkKind::Trial, "1"),
            ("mark condition  142 N/m, 60 ms ", MarkKind::Condition, "142 N/m, 60 ms"),
            ("mark participant P-07", MarkKind::Participant, "P-07"),
            (&long[..74], MarkKind::Note, &long[10..74]),
        ] {
            assert_eq!(Order::parse(line), Order::Mark(Mark { kind, label: Label::new(text).unwrap() }));
        }
    }
}
