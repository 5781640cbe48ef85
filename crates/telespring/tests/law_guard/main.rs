//! Laws of the guard, without an endpoint: a test drives the strategies, robots advanced by the matrix exponential, and a
//! network or an adversary.

#![allow(clippy::disallowed_macros, reason = "prints the numbers of docs/guard.md")]

mod account;
mod any_network;
mod hman;
mod overdraft;
mod support;
#[path = "../withstand_common/mod.rs"]
mod withstand_common;
