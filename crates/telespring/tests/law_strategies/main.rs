//! The strategies of the literature: a closed form of each, and what each promises on two H-MANs, driven through endpoints.

#![allow(clippy::disallowed_macros, reason = "the tests print what they measure")]

mod driver;
mod garbage;
mod injected_damping;
mod set_position_modulation;
mod side_by_side;
mod time_domain_passivity;
mod two_layer;
mod wave_variables;
#[path = "../withstand_common/mod.rs"]
mod withstand_common;
