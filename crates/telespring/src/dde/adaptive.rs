//! An adaptive solver for any right-hand side with delays.
