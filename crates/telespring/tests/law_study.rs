//! Laws of study files: what is written reads back the same, and no text makes the reader panic.

use proptest::collection::vec;
use proptest::prelude::*;
use telespring::study::Study;

fn span(top: f64) -> BoxedStrategy<String> {
    prop_oneof![
        (0.0..top).prop_map(|v| format!("{v:?}")),
        (0.0..top, 0.0..top).prop_map(|(a, b)| format!("{{min = {:?}, max = {:?}}}", a.min(b), a.max(b))),
    ]
    .boxed()
}

fn study() -> impl Strategy<Value = String> {
    let axes = 1..4_usize;
    axes.prop_flat_map(|n| {
        let robot = (vec(1e-3..100.0_f64, n), vec(0.0..50.0_f64, n));
        let operator = (vec(span(5.0), n), vec(span(20.0), n), vec(span(500.0), n));
        let rest = (1e-3..1e4_f64, 0.0..10.0_f64, 0.0..1.0_f64, 0.0..1.0_f64, 0.0..0.1_f64, 1e-4..0.01_f64);
        (robot.clone(), robot, operator.clone(), operator, rest, "\\PC{0,20}", 0.0..1.0_f64)
    })
    .prop_map(|(r1, r2, o1, o2, (k, c, forward, backward, jitter, period), name, part)| {
        let operator = |(m, b, k): &(Vec<String>, Vec<String>, Vec<String>)| {
            format!("mass = [{}]\ndamping = [{}]\nstiffness = [{}]", m.join(", "), b.join(", "), k.join(", "))
        };
        format!(
            "name = {}\nallow_unusual = true\n[robot1]\nmass = {:?}\ndamping = {:?}\n[robot2]\nmass = {:?}\ndamping = {:?}\n\
             [operator1]\n{}\n[operator2]\n{}\n[coupling]\nstiffness = {k:?}\ndamping = {c:?}\n\
             [network]\ndelay = {{forward = {forward:?}, backward = {backward:?}}}\njitter = {jitter:?}\n\
             [controller]\nsample_period = {period:?}\ncomputing_time = {:?}\n",
            toml::Value::String(name),
            r1.0,
            r1.1,
            r2.0,
            r2.1,
            operator(&o1),
            operator(&o2),
            part * period
        )
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..Default::default() })]

    #[test]
    fn law_a_study_reads_back_the_same(text in study()) {
        let first = Study::from_toml(&text).map_err(|error| TestCaseError::fail(error.to_string()))?;
        let written = first.to_toml();
        let second = Study::from_toml(&written).map_err(|error| TestCaseError::fail(error.to_string()))?;
        prop_assert_eq!(&first, &second);
        prop_assert_eq!(written, second.to_toml());
    }

    #[test]
    fn law_no_text_makes_the_reader_panic(text in "\\PC{0,200}") {
        let _ = Study::from_toml(&text);
    }

    #[test]
    fn law_no_mutation_makes_the_reader_panic(
        text in study(), at in any::<prop::sample::Index>(), length in 0..20_usize,
        patch in "[-\\[\\]{}=.,\"#0-9a-z\n_ éµ]{0,8}",
    ) {
        let letters: Vec<char> = text.chars().collect();
        let start = at.index(letters.len());
        let end = (start + length).min(letters.len());
        let mutated: String =
            letters[..start].iter().copied().chain(patch.chars()).chain(letters[end..].iter().copied()).collect();
        match Study::from_toml(&mutated) {
            // What is accepted is a study in full: it can be written and read again.
            Ok(study) => prop_assert_eq!(Study::from_toml(&study.to_toml()), Ok(study)),
            Err(error) => {
                prop_assert!(!error.field.is_empty() && (error.is_missing() || !error.allowed.is_empty()));
            }
        }
    }
}

#[test]
fn law_the_paper_reads_back_the_same() {
    let paper = Study::paper();
    assert_eq!(Study::from_toml(&paper.to_toml()), Ok(paper));
}
