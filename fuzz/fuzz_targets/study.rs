//! Any text is either a valid study or refused with a message that helps; it never panics or hangs.

#![no_main]

use libfuzzer_sys::fuzz_target;
use telespring::study::Study;

fuzz_target!(|text: &str| {
    let first = Study::from_toml(text);
    if let Err(refused) = &first {
        assert!(!refused.field.is_empty(), "a refusal names the place: {refused:?}");
        assert!(!refused.allowed.is_empty(), "a refusal says what is allowed: {refused:?}");
        assert!(refused.remedy.ends_with('.'), "a remedy is a sentence: {refused:?}");
    }
    // A study is written as it was read, and its rehearsal is there or refused.
    if let Ok(study) = &first {
        assert_eq!(Study::from_toml(&study.to_toml()).as_ref(), Ok(study));
        let _ = (study.laboratory(), study.protocol());
    }
    // The same text, the same answer; a comment and a blank line change nothing.
    let verdict = first.as_ref().err();
    assert_eq!(Study::from_toml(text).as_ref().err(), verdict);
    if verdict.is_none() {
        assert!(Study::from_toml(&format!("{text}\n# the end\n\n")).is_ok());
    }
});
