//! The virtual laboratory: two robots in two arms, their agents, a target and a network, in virtual time.

mod laboratory;
pub mod plant;

pub use laboratory::{
    Agent, Arm, Controller, Elbow, Handle, Laboratory, Network, Protocol, Side, Spots, Target, TwoLinkArm,
};
