//! Files of another kind that are given as a study or a robot file: what to do with them instead.

use toml::de::DeTable;

use super::keys::SECTIONS;

/// What to do with a text that is not TOML but a table of measurements; `None` if it is none.
pub(super) fn remedy_for_table(text: &str) -> Option<&'static str> {
    let is_comment = |line: &str| line.is_empty() || line.starts_with(['#', '%']);
    let first = text.lines().map(str::trim).find(|line| !is_comment(line))?;
    let is_toml = first.starts_with('[') || first.contains('=');
    let numbers = first.split_whitespace().filter(|word| word.parse::<f64>().is_ok()).count();
    (!is_toml && (first.contains([',', ';', '\t']) || numbers > 1)).then_some(
        "This is a table of measurements. Make a robot file of a log first, and give that to --robot: telespring \
         identify LOG --out robot.toml. Trials are for telespring analyse.",
    )
}

/// Whether a study's text is a robot file.
pub(super) fn is_robot_file(table: &DeTable<'_>) -> bool {
    let has = |name: &str| table.contains_key(name);
    has("robot") && table.keys().all(|key| ["robot", "identification"].contains(&key.get_ref().as_ref()))
}

/// The first section in a robot file's text that shows it to be a study.
pub(super) fn section_of_study<'k>(mut keys: impl Iterator<Item = &'k String>) -> Option<&'k str> {
    keys.find(|key| SECTIONS.iter().any(|(section, _)| section == key)).map(String::as_str)
}
