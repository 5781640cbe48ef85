//! `[loop]`: what the loop asks the operating system for.

use serde::Deserialize;
use telespring::InvalidInput;

/// What the loop asks the operating system for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LoopChoice {
    /// The priority of the first-in-first-out schedule, 1 to 99; `None` to ask for none.
    pub priority: Option<i32>,
    /// Whether the memory stays in place.
    pub lock_memory: bool,
    /// Whether the processors stay out of deep sleep.
    pub stay_awake: bool,
    /// What the loop keeps time with.
    pub pace: PaceChoice,
}

/// What a loop keeps time with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PaceChoice {
    /// The clock of the machine.
    Clock,
    /// The measurements of the device, if it sends them by itself. Two clocks of one rate drift past each other: by its own
    /// clock, a loop finds now two measurements and now none.
    #[default]
    Device,
}

impl Default for LoopChoice {
    /// Priority 80, memory locked, processors awake, the pace of the device.
    fn default() -> Self {
        Self { priority: Some(80), lock_memory: true, stay_awake: true, pace: PaceChoice::Device }
    }
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct Text {
    priority: Option<i32>,
    lock_memory: Option<bool>,
    stay_awake: Option<bool>,
    pace: Option<PaceChoice>,
}

impl LoopChoice {
    pub(super) fn new(text: &Text) -> Result<Self, InvalidInput> {
        let usual = Self::default();
        let priority = text.priority.or(usual.priority);
        if let Some(priority) = priority.filter(|priority| !(0..=99).contains(priority)) {
            let remedy = "Give 80, or 0 for an ordinary thread.";
            return Err(InvalidInput::new("loop.priority", priority, "a whole number from 0 to 99", remedy));
        }
        Ok(Self {
            priority: priority.filter(|priority| *priority > 0),
            lock_memory: text.lock_memory.unwrap_or(usual.lock_memory),
            stay_awake: text.stay_awake.unwrap_or(usual.stay_awake),
            pace: text.pace.unwrap_or(usual.pace),
        })
    }
}
