"""Stability of a dyad, its margins, and what could be used instead."""
