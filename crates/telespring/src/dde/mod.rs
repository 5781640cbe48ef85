//! Delay differential equations in time.

pub mod adaptive;
pub mod linear;
