//! The transfer matrix, the Nyquist locus, magnitude and phase.
