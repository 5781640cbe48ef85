//! Whatever the dyad, its hands, the network, the partner and the prediction: two guarded endpoints on the laboratory's
//! networks, against energies computed from the robots alone.

#![allow(clippy::disallowed_macros, reason = "the tests print what they measure")]

mod case;
mod liar;
mod networks;
mod random_cases;
mod rest;
mod run;
mod steady_pull;
#[path = "../withstand_common/mod.rs"]
mod withstand_common;
