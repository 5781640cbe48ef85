//! The four verdicts on a dyad, side by side with the paper's.
