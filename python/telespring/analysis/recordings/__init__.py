"""Recorded trials as CSV: their layout, reading, checks and writing."""
