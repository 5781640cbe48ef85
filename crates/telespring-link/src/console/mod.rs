//! The console: status and events of a session as JSON lines on the standard output, for a program that shows them.

mod output;

pub use output::Output;
