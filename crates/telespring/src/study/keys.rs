//! The keys of every section of a study file, and suggestions for misspelt ones.

/// The keys of a section.
#[derive(Debug, Clone, Copy)]
pub(super) enum Keys {
    /// The same keys in every study.
    Fixed(&'static [&'static str]),
    /// The keys depend on the section's key `kind`; without it the first kind applies.
    ByKind(&'static [(&'static str, &'static [&'static str])]),
}

const ROBOT: Keys = Keys::Fixed(&[
    "name",
    "axes",
    "mass",
    "damping",
    "coulomb",
    "ground_stiffness",
    "mass_sd",
    "damping_sd",
    "mass_damping_correlation",
]);
const OPERATOR: Keys = Keys::Fixed(&["mass", "damping", "stiffness"]);
const ARM: Keys = Keys::ByKind(&[
    ("massless", &["kind"]),
    ("lumped", &["kind", "mass", "damping"]),
    (
        "two-link",
        &[
            "kind",
            "base",
            "elbow",
            "link_length",
            "link_mass",
            "link_centre",
            "link_inertia",
            "joint_damping",
            "rotor_inertia",
            "torque_limit",
        ],
    ),
]);
const SKILLED: (&str, &[&str]) = ("skilled", &["kind", "stiffness", "damping"]);
const BLURRED: (&str, &[&str]) =
    ("blurred", &["kind", "stiffness", "spots", "spot_velocity", "spot_lifetime"]);
const PYTHON_AGENT: (&str, &[&str]) = ("python", &["kind", "class", "options"]);

/// Every section with its keys. Unknown keys are rejected, so that no setting is silently ignored.
pub(super) const SECTIONS: [(&str, Keys); 16] = [
    ("robot1", ROBOT),
    ("robot2", ROBOT),
    ("operator1", OPERATOR),
    ("operator2", OPERATOR),
    ("coupling", Keys::Fixed(&["stiffness", "damping"])),
    (
        "network",
        Keys::Fixed(&[
            "delay",
            "jitter",
            "max_gap",
            "playout_buffer",
            "distribution",
            "loss",
            "burst",
            "duplicate",
            "order",
            "rate",
            "blackout",
            "trace",
            "adversary",
        ]),
    ),
    ("controller", Keys::Fixed(&["sample_period", "computing_time"])),
    ("arm1", ARM),
    ("arm2", ARM),
    ("agent1", Keys::ByKind(&[SKILLED, BLURRED, PYTHON_AGENT])),
    ("agent2", Keys::ByKind(&[BLURRED, SKILLED, PYTHON_AGENT])),
    (
        "task",
        Keys::ByKind(&[
            ("figure-eight", &["kind", "amplitude", "angular_frequency"]),
            ("python", &["kind", "function", "options"]),
        ]),
    ),
    (
        "laboratory",
        Keys::Fixed(&[
            "sample_period",
            "computing_tick",
            "actuator_lag",
            "encoder_resolution",
            "jitter",
            "loss",
        ]),
    ),
    (
        "protocol",
        Keys::Fixed(&[
            "unconnected",
            "stiffness",
            "delay",
            "conditions",
            "trials",
            "duration",
            "discard",
            "record_rate",
            "seed",
            "order",
        ]),
    ),
    ("session", Keys::Fixed(&["strategy", "predictor", "playout"])),
    ("comparison", Keys::Fixed(&["architectures", "networks"])),
];

/// The keys outside the sections.
pub(super) const TOP: [&str; 2] = ["name", "allow_unusual"];

/// The sections that only a rehearsal needs.
pub(super) const REHEARSAL: [&str; 9] =
    ["arm1", "arm2", "agent1", "agent2", "task", "laboratory", "protocol", "session", "comparison"];

impl Keys {
    /// The kinds of a section, which decide its keys; empty if it has none.
    pub fn kinds(self) -> Vec<&'static str> {
        match self {
            Self::Fixed(_) => Vec::new(),
            Self::ByKind(kinds) => kinds.iter().map(|(kind, _)| *kind).collect(),
        }
    }

    /// The keys allowed in a section of the kind that it names, and that kind.
    pub fn allowed_in(self, named: Option<&str>) -> (&'static [&'static str], Option<&'static str>) {
        match self {
            Self::Fixed(keys) => (keys, None),
            Self::ByKind(kinds) => {
                let (kind, keys) = kinds.iter().find(|(kind, _)| Some(*kind) == named).unwrap_or(&kinds[0]);
                (keys, Some(kind))
            }
        }
    }

    /// The kind that has this key, if the section's keys depend on a kind.
    pub fn kind_with_key(self, key: &str) -> Option<&'static str> {
        match self {
            Self::Fixed(_) => None,
            Self::ByKind(kinds) => kinds.iter().find(|(_, keys)| keys.contains(&key)).map(|(kind, _)| *kind),
        }
    }

    /// All keys of a section, of any kind.
    pub fn all(self) -> Vec<&'static str> {
        match self {
            Self::Fixed(keys) => keys.to_vec(),
            Self::ByKind(kinds) => {
                let mut all = Vec::new();
                for key in kinds.iter().flat_map(|(_, keys)| keys.iter()) {
                    if !all.contains(key) {
                        all.push(*key);
                    }
                }
                all
            }
        }
    }
}

/// A key of a study file in TOML syntax, quoted if it is not a bare key.
pub(super) fn toml_key(key: &str) -> String {
    let bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if !key.is_empty() && key.chars().all(bare) { key.to_owned() } else { format!("{key:?}") }
}

/// The allowed key or word nearest to a misspelt one, if any is near enough.
pub(super) fn nearest_word<'w>(word: &str, allowed: &[&'w str]) -> Option<&'w str> {
    const LONGEST_WORD: usize = 40;
    if word.is_empty() || word.chars().count() > LONGEST_WORD {
        return None;
    }
    let lower = word.to_lowercase();
    let misspelt = allowed
        .iter()
        .map(|key| (strsim::damerau_levenshtein(&lower, &key.to_lowercase()), *key))
        .filter(|&(distance, key)| distance <= (key.len() / 3).max(1))
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, key)| key);
    let extended = || allowed.iter().find(|key| lower.starts_with(**key) || key.starts_with(&lower)).copied();
    misspelt.or_else(extended)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ref_the_nearest_word_allows_for_slips_of_the_finger() {
        let keys = ["mass", "damping", "delay", "max_gap"];
        for (word, expected) in [
            ("Mas", Some("mass")),
            ("dalay", Some("delay")),
            ("dampnig", Some("damping")),
            ("dealy", Some("delay")),
            ("delay_ms", Some("delay")),
            ("max", Some("max_gap")),
            ("stiffness", None),
            ("", None),
        ] {
            assert_eq!(nearest_word(word, &keys), expected, "{word}");
        }
        assert_eq!(nearest_word(&"mass".repeat(20), &keys), None);
    }
}
