//! Real roots of polynomials of low degree: isolated, scaled, none missed.
