"""Robots, the operators who hold them, and the two of them as a dyad."""

from telespring._core import Dyad, Operator, Robot, hman

__all__ = ["Dyad", "Operator", "Robot", "hman"]
