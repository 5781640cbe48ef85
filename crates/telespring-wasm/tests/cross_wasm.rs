//! The module of the page against the native core: answers to random studies, and the motion behind the guard.
//!
//! `make page` builds the module; without it, or without Node.js, these tests skip loudly.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use telespring_wasm::live::Live;
use telespring_wasm::{answer, curves, map, values};

/// Numbers from 0 to 1, seeded.
struct Draw(ChaCha8Rng);

impl Draw {
    fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    fn next(&mut self) -> f64 {
        self.0.random()
    }

    /// A number from `least` to `most`, evenly by decades, with the digits that people write.
    fn decade(&mut self, least: f64, most: f64) -> f64 {
        let value = least * (most / least).powf(self.next());
        format!("{value:.4e}").parse().unwrap()
    }

    fn is(&mut self, share: f64) -> bool {
        self.next() < share
    }
}

/// A study of robots, hands and networks as laboratories have them.
fn study(draw: &mut Draw) -> String {
    let axes = if draw.is(0.7) { 1 } else { 2 };
    let mut text = String::new();
    for robot in 1..=2 {
        let masses: Vec<f64> = (0..axes).map(|_| draw.decade(0.1, 10.0)).collect();
        let dampings: Vec<f64> = (0..axes).map(|_| draw.decade(0.5, 50.0)).collect();
        text += &format!("[robot{robot}]\nmass = {masses:?}\ndamping = {dampings:?}\n");
        if draw.is(0.2) {
            let (k, b) = (draw.decade(5.0, 500.0), draw.decade(0.1, 10.0));
            text += &format!("[operator{robot}]\nstiffness = {k:?}\ndamping = {b:?}\n");
        }
    }
    let delay = [draw.decade(0.001, 0.4), draw.decade(0.001, 0.4)];
    text += &format!("[coupling]\nstiffness = {:?}\n[network]\n", draw.decade(5.0, 800.0));
    text += &if draw.is(0.8) {
        format!("delay = {:?}\n", delay[0])
    } else {
        format!("delay = {{forward = {:?}, backward = {:?}}}\n", delay[0], delay[1])
    };
    if draw.is(0.35) {
        text += &format!("jitter = {:?}\nplayout_buffer = {}\n", draw.decade(0.01, 0.2), draw.is(0.2));
    }
    let period = if draw.is(0.5) { 0.0 } else { [0.001, 0.002, 0.005][(3.0 * draw.next()) as usize] };
    text + &format!("[controller]\nsample_period = {period:?}\n")
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Node.js with the module, which answers a list of calls; `None` where either is missing.
fn node(calls: &[Value]) -> Option<Child> {
    let module = root().join("out/page/telespring.wasm");
    if !module.is_file() {
        eprintln!("SKIPPED: no out/page/telespring.wasm; build it with 'make page'");
        return None;
    }
    let started = Command::new("node")
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/node.mjs"))
        .args([module, root().join("page/engine.js")])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn();
    let Ok(mut child) = started else {
        eprintln!("SKIPPED: no Node.js ('node')");
        return None;
    };
    let mut input = child.stdin.take().unwrap();
    let text = serde_json::to_string(calls).unwrap();
    std::thread::spawn(move || input.write_all(text.as_bytes()).unwrap());
    Some(child)
}

fn answers(child: Child) -> Vec<Value> {
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success());
    serde_json::from_slice(&output.stdout).unwrap()
}

/// The first place where two answers differ, numbers by more than 1e-9 of the larger or of `least`.
fn difference(native: &Value, page: &Value, least: f64) -> Option<String> {
    let within = |field: String, found: Option<String>| found.map(|at| format!("{field}.{at}"));
    match (native, page) {
        (Value::Number(one), Value::Number(other)) => {
            let (one, other) = (one.as_f64().unwrap(), other.as_f64().unwrap());
            let scale = one.abs().max(other.abs()).max(least);
            ((one - other).abs() > 1e-9 * scale).then(|| format!("{one} {other}"))
        }
        (Value::Array(one), Value::Array(other)) if one.len() == other.len() => one
            .iter()
            .zip(other)
            .enumerate()
            .find_map(|(i, (a, b))| within(i.to_string(), difference(a, b, least))),
        (Value::Object(one), Value::Object(other)) if one.len() == other.len() => {
            one.iter().find_map(|(key, a)| {
                within(key.clone(), difference(a, other.get(key).unwrap_or(&Value::Null), least))
            })
        }
        _ => (native != page).then(|| format!("{native} {page}")),
    }
}

fn outcome(found: telespring::Result<Value>) -> Value {
    found.unwrap_or_else(|refusal| values::refusal(&refusal))
}

/// The native answers, on all cores.
fn natively(studies: &[String], of: impl Fn(&str) -> Value + Sync) -> Vec<Value> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        let parts: Vec<_> = studies
            .chunks(studies.len().div_ceil(threads))
            .map(|part| scope.spawn(|| part.iter().map(|text| of(text)).collect::<Vec<_>>()))
            .collect();
        parts.into_iter().flat_map(|part| part.join().unwrap()).collect()
    })
}

#[test]
fn cross_answers_are_those_of_the_native_core() {
    compare_answers(300);
}

#[test]
#[ignore = "minutes: the module and the native core judge ten thousand studies each"]
fn cross_answers_are_those_of_the_native_core_on_ten_thousand_studies() {
    compare_answers(10_000);
}

fn compare_answers(count: usize) {
    let mut draw = Draw::new(20_261_129);
    let studies: Vec<String> = (0..count).map(|_| study(&mut draw)).collect();
    let calls: Vec<Value> = studies.iter().map(|text| json!(["decide", text])).collect();
    let Some(child) = node(&calls) else { return };
    let native =
        natively(&studies, |text| outcome(values::read(text).and_then(|study| answer::decide(&study))));
    let page = answers(child);
    assert_eq!(page.len(), native.len());
    let mut words = std::collections::BTreeMap::new();
    for ((text, native), page) in studies.iter().zip(&native).zip(&page) {
        *words.entry(native["status"].as_str().unwrap_or("refused").to_owned()).or_insert(0) += 1;
        // 1e-3: below it a stiffness is nothing, a time that of a microsecond
        assert_eq!(difference(native, page, 1e-3), None, "{text}\n{native}\n{page}");
    }
    // the draw reaches every answer
    for word in ["stable", "marginal", "unstable", "not proven"] {
        assert!(words.get(word).is_some_and(|&met| met > 0), "{words:?}");
    }
}

#[test]
fn cross_maps_and_curves_are_those_of_the_native_core() {
    let mut draw = Draw::new(7);
    let studies: Vec<String> = (0..20).map(|_| study(&mut draw)).collect();
    let calls: Vec<Value> = studies
        .iter()
        .flat_map(|text| {
            [
                json!(["map", text, 300.0, 0.3, 20]),
                json!(["bounds", text, 0.05]),
                json!(["nyquist", text, 0]),
                json!(["roots", text, 0, 0.3, 10]),
                json!(["study", text, "coupling.stiffness = 33"]),
            ]
        })
        .collect();
    let Some(child) = node(&calls) else { return };
    let page = answers(child);
    for (text, page) in studies.iter().zip(page.chunks(5)) {
        let read = values::read(text).unwrap();
        let native = [
            map::map(&read, 300.0, 0.3, 20),
            map::bounds(&read, 0.05),
            curves::nyquist_locus(&read, 0),
            curves::root_locus(&read, 0, 0.3, 10),
            values::changed(&read, "coupling.stiffness = 33").and_then(|study| values::values(&study)),
        ];
        for (native, page) in native.into_iter().zip(page) {
            assert_eq!(difference(&outcome(native), page, 1.0), None, "{text}");
        }
    }
}

/// Numbers in JSON, which has no NaN.
fn numbers(state: impl IntoIterator<Item = f64>) -> Value {
    state.into_iter().map(|value| if value.is_finite() { json!(value) } else { Value::Null }).collect()
}

#[test]
fn cross_motion_behind_spring_and_guard_is_that_of_the_native_core() {
    let mut draw = Draw::new(11);
    let studies: Vec<String> = (0..12).map(|_| study(&mut draw)).collect();
    let calls: Vec<Value> =
        studies.iter().map(|text| json!(["move", text, 0, 400, 0.02, 200.0, 1600])).collect();
    let Some(child) = node(&calls) else { return };
    for (text, page) in studies.iter().zip(&answers(child)) {
        let mut live = Live::start(&values::read(text).unwrap(), 0, 1).unwrap();
        let mut states = Vec::new();
        for tick in 0..2000 {
            let grip = if tick < 400 { 200.0 } else { 0.0 };
            live.tick(0.02, grip);
            states.push(numbers(live.state()));
        }
        // 1e-9 of a metre, a newton, a joule
        assert_eq!(difference(&Value::Array(states), page, 1.0), None, "{text}");
    }
}

#[test]
fn law_the_guard_calms_what_the_bare_spring_shakes_up() {
    let text = "robot1 = {mass = 1, damping = 6}\nrobot2 = {mass = 1, damping = 6}\ncoupling.stiffness = 300\nnetwork.delay = 0.1\n";
    let read = values::read(text).unwrap();
    assert_eq!(answer::decide(&read).unwrap()["status"], "unstable");
    let mut live = Live::start(&read, 0, 1).unwrap();
    let mut swing = [[0.0_f64; 2]; 2];
    for tick in 0..6000 {
        live.tick(0.02, if tick < 300 { 200.0 } else { 0.0 });
        let state = live.state();
        for (run, at) in [1, 7].into_iter().enumerate() {
            let part = usize::from(tick >= 5000);
            if tick >= 5000 || (300..1300).contains(&tick) {
                swing[run][part] = swing[run][part].max((state[at] - state[at + 1]).abs());
            }
        }
    }
    assert!(swing[0][1] > 10.0 * swing[0][0], "{swing:?}");
    assert!(swing[1][1] < 0.3 * swing[1][0], "{swing:?}");
}

#[test]
fn law_a_run_without_a_hand_rests() {
    let mut live = Live::start(&values::read("").unwrap(), 1, 1).unwrap();
    for _ in 0..500 {
        live.tick(0.1, 0.0);
    }
    let state = live.state();
    assert!((state[0] - 0.5).abs() < 1e-9);
    assert_eq!([state[1], state[2], state[7], state[8]], [0.0; 4]);
}

#[test]
fn law_what_a_page_sends_is_refused_at_the_door() {
    for text in ["robot1 = 3", "[robot1]\nmass = -1", "\u{0}", "[network]\ndelay = 167"] {
        assert!(values::read(text).is_err(), "{text}");
    }
    let paper = values::read("").unwrap();
    for changes in [
        "coupling.stiffness = 0",
        "coupling.stiffness = 'stiff'",
        "nonsense.key = 1",
        "=",
        "network.delay = 200",
    ] {
        assert!(values::changed(&paper, changes).is_err(), "{changes}");
    }
    for (stiffness, delay, columns) in
        [(0.0, 0.1, 10), (f64::NAN, 0.1, 10), (100.0, -1.0, 10), (100.0, 0.1, 0), (100.0, 0.1, 1 << 30)]
    {
        assert!(map::map(&paper, stiffness, delay, columns).is_err());
    }
    assert!(curves::nyquist_locus(&paper, 9).is_err());
    assert!(Live::start(&paper, 9, 1).is_err());
}
