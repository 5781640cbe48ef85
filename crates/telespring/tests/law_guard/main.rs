//! Laws of the guard, without an endpoint: a test drives the strategies, robots advanced by the matrix exponential, and a
//! network or an adversary.

mod account;
mod any_network;
mod hman;
mod support;
