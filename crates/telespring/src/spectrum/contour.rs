//! Counting the zeros of an analytic function inside a contour, with steps that cannot skip a turn.
