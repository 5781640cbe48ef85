"""Stability of a dyad, its margins, and what to change."""
