//! Laws of adversaries on the network: what they hand over, what they do to the bare spring, and what the guard makes of them.

#![allow(clippy::disallowed_macros, reason = "the tests print what they measure")]

mod bare_spring;
mod creeping;
mod guard;
mod handed_over;
mod trial;
#[path = "../withstand_common/mod.rs"]
mod withstand_common;
