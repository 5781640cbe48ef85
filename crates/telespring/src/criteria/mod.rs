//! Stability criteria of one axis of a dyad, and the verdicts on a whole dyad.

pub mod verdicts;
