//! What the forces move: a robot's handle with the arm that holds it.

pub mod two_link;
