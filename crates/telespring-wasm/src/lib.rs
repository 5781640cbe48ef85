//! The core of telespring for a web page: a C interface over bytes and numbers.
//!
//! The page writes text to the address that [`telespring_input`] returns, calls one of the other functions with the length
//! of the text, and reads as many bytes as [`telespring_length`] says from [`telespring_output`]. A function returns 0, or 1
//! if the input is refused: the output is then the refusal as JSON, with its field, value, allowed values and remedy.
//! Nothing is imported, so the module runs wherever WebAssembly does. It computes nothing itself: each function reads
//! a study and hands it to the core.
//!
//! | module | job |
//! |---|---|
//! | [`values`] | a study as values for controls, and with some of them changed |
//! | [`answer`] | the answer in the words and keys of `telespring decide --json` |
//! | [`map`] | what is stable over stiffness and delay |
//! | [`curves`] | Nyquist locus and root locus |
//! | [`live`] | two robots under way, coupled by the bare spring and by the guard |

#![cfg_attr(not(test), deny(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

pub mod answer;
pub mod curves;
pub mod live;
pub mod map;
pub mod values;

use std::cell::RefCell;

use serde_json::{Value, json};
use telespring::study::Study;
use telespring::{InvalidInput, Result};

use live::Live;

/// All that stays between two calls.
#[derive(Default)]
struct Memory {
    input: Vec<u8>,
    output: Vec<u8>,
    live: Option<Live>,
}

thread_local! {
    static MEMORY: RefCell<Memory> = RefCell::default();
}

/// Room for an input of `length` bytes; returns its address, which holds until the next call of this function.
#[unsafe(no_mangle)]
pub extern "C" fn telespring_input(length: usize) -> *mut u8 {
    MEMORY.with_borrow_mut(|memory| {
        memory.input.clear();
        memory.input.resize(length, 0);
        memory.input.as_mut_ptr()
    })
}

/// The address of the output of the last call.
#[unsafe(no_mangle)]
pub extern "C" fn telespring_output() -> *const u8 {
    MEMORY.with_borrow(|memory| memory.output.as_ptr())
}

/// The length of the output of the last call, bytes.
#[unsafe(no_mangle)]
pub extern "C" fn telespring_length() -> usize {
    MEMORY.with_borrow(|memory| memory.output.len())
}

/// A study's values, as JSON; an empty text is the paper's study. The text after the first `study` bytes, if there is any,
/// is a TOML table of values to change first.
#[unsafe(no_mangle)]
pub extern "C" fn telespring_study(study: usize) -> u32 {
    respond(|text| {
        let (study, changes) = text.split_at_checked(study).unwrap_or((text, ""));
        values::values(&values::changed(&values::read(study)?, changes)?)
    })
}

/// The answer to a study, as JSON.
#[unsafe(no_mangle)]
pub extern "C" fn telespring_decide() -> u32 {
    respond(|text| answer::decide(&values::read(text)?))
}

/// The lowest stiffness at which an attack with these ages was found to make the motion grow, as JSON. Takes a second or more.
#[unsafe(no_mangle)]
pub extern "C" fn telespring_attack(delay: f64, seed: u32) -> u32 {
    respond(|text| answer::attack(&values::read(text)?, delay, u64::from(seed)))
}

/// What is stable at a constant delay, at stiffnesses (N/m) up to one and delays (s) up to one, as JSON.
#[unsafe(no_mangle)]
pub extern "C" fn telespring_map(stiffness: f64, delay: f64, columns: usize) -> u32 {
    respond(|text| map::map(&values::read(text)?, stiffness, delay, columns))
}

/// What is proven at one mean delay (s) of the network, by verdict, as JSON.
#[unsafe(no_mangle)]
pub extern "C" fn telespring_bounds(delay: f64) -> u32 {
    respond(|text| map::bounds(&values::read(text)?, delay))
}

/// The Nyquist locus of an axis with its margins, as JSON.
#[unsafe(no_mangle)]
pub extern "C" fn telespring_nyquist(axis: usize) -> u32 {
    respond(|text| curves::nyquist_locus(&values::read(text)?, axis))
}

/// The rightmost roots of an axis at equally spaced delays up to one (s), as JSON.
#[unsafe(no_mangle)]
pub extern "C" fn telespring_roots(axis: usize, longest: f64, steps: usize) -> u32 {
    respond(|text| curves::root_locus(&values::read(text)?, axis, longest, steps))
}

/// Starts two robots on one axis of a study anew, coupled by the bare spring and, beside it, by the guard.
#[unsafe(no_mangle)]
pub extern "C" fn telespring_start(axis: usize, seed: u32) -> u32 {
    let mut live = None;
    let refused = respond(|text| {
        let started = Live::start(&values::read(text)?, axis, u64::from(seed))?;
        let period = started.period();
        live = Some(started);
        Ok(json!({ "sample_period": period }))
    });
    MEMORY.with_borrow_mut(|memory| memory.live = live);
    refused
}

/// Moves what [`telespring_start`] started by some sample periods, with a hand pulling robot 1 towards a place (m) with
/// `grip` (N/m, 0 for none). The output is [`Live::STATE`] numbers after each period.
#[unsafe(no_mangle)]
pub extern "C" fn telespring_step(ticks: usize, place: f64, grip: f64) -> u32 {
    MEMORY.with_borrow_mut(|memory| {
        memory.output.clear();
        let Some(live) = &mut memory.live else { return 1 };
        for _ in 0..ticks {
            live.tick(place, grip);
            memory.output.extend(live.state().iter().flat_map(|value| value.to_le_bytes()));
        }
        0
    })
}

/// Puts into the output what a function makes of the input; 1 if it is refused.
fn respond(function: impl FnOnce(&str) -> Result<Value>) -> u32 {
    MEMORY.with_borrow_mut(|memory| {
        let made = std::str::from_utf8(&memory.input)
            .map_err(|_| InvalidInput::new("study", "bytes", "a study is UTF-8 text", "Open another file."))
            .and_then(function);
        let refused = u32::from(made.is_err());
        memory.output = made.unwrap_or_else(|refusal| values::refusal(&refusal)).to_string().into_bytes();
        refused
    })
}

/// The study's constant delay in the answers: the network's mean, s, or 0 where it has none.
fn mean_delay(study: &Study) -> f64 {
    study.network().map_or(0.0, |network| network.delay().mean())
}
