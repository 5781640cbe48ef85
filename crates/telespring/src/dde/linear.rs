//! The ideal linear dyad, solved by Taylor series on steps that divide the delay.
