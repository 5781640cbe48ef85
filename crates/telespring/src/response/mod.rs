//! Frequency response: transfer matrix, Nyquist locus, magnitude and phase.
//!
//! The formulas use Pᵢ(s) = mᵢ s² + (bᵢ + c) s + k + k_h,i, the delays of both directions, and χ(s) = P₁ P₂
//! − (k + c s)² e^(−T s) with the round-trip delay T.
//!
//! | question | function |
//! |---|---|
//! | how far does each handle move under each force? | [`transfer_matrix`], [`frequency_response`] |
//! | how fast (also finite at s = 0 with free handles)? | [`mobility_matrix`] |
//! | what are magnitude ratio and phase of the paper's Fig. 4? | [`partner_response`], [`open_loop`] |
//! | does the loop encircle −1, and with what margins? | [`nyquist()`] |
//! | which frequencies resolve every resonance? | [`frequency_grid`] |
//!
//! Phases are continuous in frequency and start at ω → 0⁺, not at the first sample: the phase at one
//! frequency does not depend on the other frequencies requested. Every factor but χ has a phase in closed
//! form. The phase of χ is followed by subdivision until each piece is proven free of zeros.

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
