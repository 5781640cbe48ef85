//! Characteristic roots to a wanted depth, with a certificate that none is missing.

pub mod contour;
