//! A linear system with several constant delays: what a dyad lowers to.
