"""Recorded trials as CSV: column layout, reading, checks, assembly into a dataset, and writing."""
