//! The control law of one side without input or output: bytes and the time go in; force and bytes come out.
