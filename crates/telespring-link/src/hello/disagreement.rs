//! What two sides do not agree on, and what each of them has.

use std::fmt::{Display, Formatter, Result};

/// What the two sides do not agree on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Disagreement {
    /// The version of the greeting or of the packets.
    Version,
    /// The number of axes.
    Axes,
    /// Both sides want to move the same robot.
    Side,
    /// The robots.
    Robots,
    /// Stiffness or damping of the coupling.
    Coupling,
    /// The sample period.
    SamplePeriod,
    /// Strategy, predictor or play-out.
    Strategy,
    /// Something else in the study.
    Study,
}

impl Disagreement {
    /// All of them; the place, from 1, is the code in a greeting.
    const ALL: [Self; 8] = [
        Self::Version,
        Self::Axes,
        Self::Side,
        Self::Robots,
        Self::Coupling,
        Self::SamplePeriod,
        Self::Strategy,
        Self::Study,
    ];

    /// The disagreement in a word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Version => "version",
            Self::Axes => "axes",
            Self::Side => "side",
            Self::Robots => "robots",
            Self::Coupling => "coupling",
            Self::SamplePeriod => "sample-period",
            Self::Strategy => "strategy",
            Self::Study => "study",
        }
    }

    /// What makes the two sides agree.
    pub fn remedy(self) -> &'static str {
        match self {
            Self::Version => "Run the same version of the program at both sites.",
            Self::Axes => "Give both sites a study with the axes x and y.",
            Self::Side => "Write side = 1 in the site file of one site, and side = 2 in that of the other.",
            Self::Robots => "The studies describe other robots: copy one study file to both sites.",
            Self::Coupling => {
                "The studies have another stiffness or damping: copy one study file to both sites."
            }
            Self::SamplePeriod => {
                "The studies have another sample period: copy one study file to both sites."
            }
            Self::Strategy => {
                "The studies have another strategy, predictor or play-out: copy one study file to both sites."
            }
            Self::Study => "The studies differ, if only in a name: copy one study file to both sites.",
        }
    }

    /// A disagreement or none as a code in a greeting.
    pub(super) fn code(disagreement: Option<Self>) -> u8 {
        let found = |one: &Self| disagreement == Some(*one);
        Self::ALL.iter().zip(1..).find(|(one, _)| found(one)).map_or(0, |(_, code)| code)
    }

    /// The disagreement or none of a code; `None` for a code that means nothing.
    #[allow(clippy::option_option, reason = "a greeting may refuse nothing, and a code may be none")]
    pub(super) fn decode(code: u8) -> Option<Option<Self>> {
        match code {
            0 => Some(None),
            _ => Self::ALL.get(usize::from(code) - 1).copied().map(Some),
        }
    }
}

/// What one side has of a term. Those of the partner may be anything.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Value {
    /// A version of the greeting.
    Greeting(u8),
    /// A version of the packets.
    Packets(u8),
    /// A number of axes.
    Axes(u8),
    /// A robot of the study.
    Robot(u8),
    /// Stiffness (N/m) and damping (N·s/m).
    Coupling([f64; 2]),
    /// A sample period, s.
    Period(f64),
    /// Of something that is longer than a greeting.
    Fingerprint(u64),
}

impl Display for Value {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> Result {
        match *self {
            Self::Greeting(version) => write!(formatter, "greeting {version}"),
            Self::Packets(version) => write!(formatter, "packets {version}"),
            Self::Axes(axes) => write!(formatter, "{axes} axes"),
            Self::Robot(side) => write!(formatter, "robot {side}"),
            Self::Coupling([stiffness, damping]) => {
                write!(formatter, "{} N/m and {} N·s/m", Short(stiffness), Short(damping))
            }
            Self::Period(period) => write!(formatter, "{} s", Short(period)),
            Self::Fingerprint(print) => write!(formatter, "fingerprint {print:016x}"),
        }
    }
}

/// A number in at most 24 letters, whatever it is.
struct Short(f64);

impl Display for Short {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> Result {
        let Self(value) = *self;
        if value == 0.0 || (1e-4..1e6).contains(&value.abs()) {
            write!(formatter, "{value}")
        } else {
            write!(formatter, "{value:e}")
        }
    }
}

/// On what the two sides do not agree, and what each has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// On what.
    pub on: Disagreement,
    /// Here and there; `None` if the partner sees a difference that this side does not.
    pub(crate) values: Option<[Value; 2]>,
}

impl Difference {
    /// The partner sends greetings of another version.
    pub(crate) fn of_version(version: u8) -> Self {
        let values = [super::VERSION, version].map(Value::Greeting);
        Self { on: Disagreement::Version, values: Some(values) }
    }

    /// The partner sees a difference that this side does not.
    pub(crate) fn said_there(on: Disagreement) -> Self {
        Self { on, values: None }
    }
}

impl Display for Difference {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> Result {
        formatter.write_str(self.on.word())?;
        match self.values {
            Some([here, there]) => write!(formatter, ": {here} here, {there} there"),
            None => formatter.write_str(": as the partner says"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_a_difference_says_what_both_sides_have_in_a_line_of_bounded_length() {
        let said = |on, values| Difference { on, values }.to_string();
        let coupling = |stiffness, damping| Value::Coupling([stiffness, damping]);
        assert_eq!(
            said(Disagreement::Coupling, Some([coupling(142.0, 0.0), coupling(20.5, 1.0)])),
            "coupling: 142 N/m and 0 N·s/m here, 20.5 N/m and 1 N·s/m there"
        );
        assert_eq!(
            said(Disagreement::Version, Some([Value::Greeting(3), Value::Greeting(2)])),
            "version: greeting 3 here, greeting 2 there"
        );
        assert_eq!(said(Disagreement::Study, None), "study: as the partner says");
        // a partner may say anything
        let words = "coupling:  N/m and  N·s/m here,  N/m and  N·s/m there".len();
        for value in
            [f64::MAX, f64::MIN_POSITIVE, -f64::MAX / 3.0, f64::NAN, f64::INFINITY, 0.1 + 0.2, 1e-4 / 3.0]
        {
            let line = said(Disagreement::Coupling, Some([coupling(value, -value); 2]));
            assert!(line.len() <= words + 4 * 24, "{line}");
        }
    }

    #[test]
    fn law_every_disagreement_has_its_code() {
        let codes = (0..=u8::MAX).filter(|code| {
            Disagreement::decode(*code).is_some_and(|disagreement| Disagreement::code(disagreement) == *code)
        });
        assert_eq!(codes.collect::<Vec<u8>>(), (0..=8).collect::<Vec<u8>>());
    }
}
