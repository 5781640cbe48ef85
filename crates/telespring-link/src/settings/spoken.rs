//! What is wrong with a site file or its study, in the words of somebody who writes one.

use telespring::InvalidInput;

/// What the reader of TOML expects, and what that means to somebody who writes a site file.
const EXPECTED: [(&str, &str); 7] = [
    ("expected f64", "expected a number, such as 0.1"),
    ("expected u8", "expected a whole number, such as 1"),
    ("expected u32", "expected a whole number, such as 1"),
    ("expected u64", "expected a whole number, such as 1"),
    ("expected i32", "expected a whole number, such as 80"),
    ("expected a boolean", "expected true or false"),
    ("invalid socket address syntax", "expected an address with a port, such as \"127.0.0.1:4500\""),
];

/// An error of the TOML reader in words.
pub(super) fn in_words(error: &toml::de::Error) -> String {
    let text = error.to_string();
    EXPECTED.iter().fold(text.trim_end().to_owned(), |text, (from, to)| text.replace(from, to))
}

/// Measured, not invented.
const DAMPING: &str = "Give the least damping that the robot certainly has, without its motors, as telespring identify measures it \
                       (docs/your-robot.md).";

/// The refusal of a study by a live session: without what only other commands know, and with what only this one needs.
pub(super) fn of_study(refusal: InvalidInput) -> InvalidInput {
    let mut refusal = refusal.within("study");
    if refusal.field == "study.protocol.stiffness" && refusal.value == "not given" {
        let allowed = "the guard needs robots with damping above 0 along every axis";
        return InvalidInput::new("study", "robots without damping", allowed, DAMPING);
    }
    if refusal.value.is_empty() && refusal.field.ends_with(".damping") {
        DAMPING.clone_into(&mut refusal.remedy);
    }
    refusal.remedy = refusal.remedy.replace(", or --allow-unusual on the command line", "");
    refusal
}
