//! What the tests of the guard and of the other strategies share: exact robots, two endpoints with all that stands between
//! them, and the laws of energy, computed from the robots alone.

#![allow(dead_code, reason = "each test uses a part of it")]

pub mod books;
pub mod ledger;
pub mod pair;
pub mod plant;
pub mod seed;
