"""HEBI modules as the robot of a live session: a device program of its own (README.md)."""
