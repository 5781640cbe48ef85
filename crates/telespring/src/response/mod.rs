//! The transfer matrix, the Nyquist locus, magnitude and phase.
//!
//! Everything here is written in Pᵢ(s) = mᵢ s² + (bᵢ + c) s + k + k_h,i, the delays of both
//! directions and χ(s) = P₁ P₂ − (k + c s)² e^(−T s), T the round trip.
//!
//! | question | function |
//! |---|---|
//! | how far does each handle move under each force? | [`transfer_matrix`], [`frequency_response`] |
//! | how fast (finite at s = 0 for free handles too)? | [`mobility_matrix`] |
//! | the magnitude ratio and phase of the paper's Fig. 4? | [`partner_response`], [`open_loop`] |
//! | does the loop encircle −1, and by how much does it miss? | [`nyquist()`] |
//! | which frequencies show all of it? | [`frequency_grid`] |
//!
//! Phases are continuous in frequency and anchored at ω → 0⁺, not at the first sample: the phase at
//! one frequency does not depend on which others are asked for. Every factor but χ has a phase in
//! closed form; the phase of χ is followed by subdividing until each piece is proven free of a zero.

mod grid;
mod nyquist;
mod open_loop;
mod transfer;

pub use grid::{FrequencyGrid, GridStatus, frequency_grid};
pub use nyquist::{Margin, Nyquist, NyquistStatus, nyquist};
pub use transfer::{
    Convention, FrequencyResponse, ResponseCurve, frequency_response, mobility_matrix, open_loop,
    partner_response, transfer_matrix,
};
