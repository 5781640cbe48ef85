//! Laws of adversaries on the network: what they hand over, what they do to the bare spring, and what the guard makes of them.

#![allow(clippy::disallowed_macros, reason = "the tests print what they measure")]

mod bare_spring;
mod guard;
mod handed_over;
#[allow(dead_code, reason = "the guard's tests use more of it")]
#[path = "../withstand_common/plant.rs"]
mod plant;
