//! The text of a study file to the model: the one validator for Rust, Python and the live program.
