//! A bridge from the telemetry stream of telespring-link (`docs/telemetry.md`) to ROS 2.
//!
//! | room | its one job |
//! |---|---|
//! | [`row`] | a row of the telemetry stream |
//! | [`messages`] | the messages of ROS 2 that are sent |
//! | [`conversion`] | from a row to messages |
//! | [`node`] | the node and its topics: the only room that touches ROS 2 |

#![cfg_attr(not(test), deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::todo))]

pub mod conversion;
pub mod messages;
pub mod node;
pub mod row;
